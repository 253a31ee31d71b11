"""Files beside those that were proved which a tool would take in place of its own: `numpy.py`, `math.h`, `cos.m`.

What stands in the folder of a module is imported before the package of that name, a folder that a compiler is given is
searched before its own, and a function of MATLAB's path or of a private folder hides a builtin.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path, PurePath

from symdyn.verdict import Verdict
from symdyn.verify.written.proof import Written

INCLUDED = re.compile(r"^\s*#\s*include\s*[<\"]([^>\"\n]+)", re.MULTILINE)
IMPORTED = re.compile(r"^\s*(?:import|from)\s+(\w+)", re.MULTILINE)
CALLED = re.compile(r"\b([A-Za-z]\w*)\(")
VARIABLE = re.compile(r"^\s*([A-Za-z]\w*)\s*(?:\([^()\n]*\))?\s*=", re.MULTILINE)
SIGNATURE = re.compile(r"^function .*$", re.MULTILINE)
COMMENT = re.compile(r"%.*$", re.MULTILINE)

OF_C = (".c", ".h", ".hpp", ".cu", ".cl")
OF_PYTHON = (".py", ".pyc", ".so", ".pyd")
OF_MATLAB = (".m", ".p", ".oct", ".mlx")


def hiding_files(folder: Path, written: Sequence[Written], beside: Iterable[str]) -> tuple[Written, ...]:
    """Return the verdicts on files of a folder, of those `beside`, that hide what a proved one asks for."""
    there = {one.file: folder / one.file for one in written if (folder / one.file).is_file()}
    texts = {name: path.read_bytes().decode("utf-8", "replace") for name, path in there.items()}
    found = []
    for name, by in taken_first(texts, beside).items():
        file = next(one for one in written if one.file == by)
        told = f"{by} asks for something of this name, and would be given this file"
        contents = sha256((folder / name).read_bytes()).hexdigest()
        found.append(Written(file.target, file.option, name, contents, (), Verdict.DIFFERENT, told, 0))
    return tuple(found)


def taken_first(files: Mapping[str, str], beside: Iterable[str]) -> dict[str, str]:
    """Return which of the names `beside` a tool takes for what a file asks for, each with the name of that file.

    Args:
        files: what was read, text by name; names have slashes.
        beside: names of the other files of the folder.
    """
    found: dict[str, str] = {}
    for name in beside:
        path = PurePath(name)
        for file, text in files.items():
            ending = PurePath(file).suffix
            included = ending in OF_C and any(name == one or name.endswith(f"/{one}") for one in INCLUDED.findall(text))
            module = path.parts[0].partition(".")[0]
            imported = ending == ".py" and path.suffix in OF_PYTHON and module in IMPORTED.findall(text)
            like_matlab = path.suffix in OF_MATLAB or path.suffix.startswith(".mex")
            called = ending == ".m" and like_matlab and path.stem in _functions(text)
            if included or imported or called:
                found.setdefault(name, file)
    return found


def _functions(text: str) -> set[str]:
    """Return what a MATLAB file calls that is no variable of its own."""
    code = COMMENT.sub("", text)
    own = {*VARIABLE.findall(code), *re.findall(r"\w+", " ".join(SIGNATURE.findall(code)))}
    return {*CALLED.findall(code)} - own
