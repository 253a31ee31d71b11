"""Files are written whole or not at all, by one function for all doors, and never through a link."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import symdyn
from symdyn.cli import main
from symdyn.emit import write
from symdyn.errors import EmitError

EXAMPLES = Path(__file__).parent.parent / "examples"
ROOT = Path(symdyn.__file__).parent
TWO_LINK = str(EXAMPLES / "two_link.toml")

DOORS = {  # words of the command line that write a file, and its name
    "walkthrough": (["walkthrough", TWO_LINK, "-o", "{}"], "l.html"),
    "lesson with pictures": (["walkthrough", TWO_LINK, "-o", "{}"], "l.md"),
    "sliders": (["walkthrough", TWO_LINK, "--format", "sliders", "-o", "{}"], "l.html"),
    "draw": (["draw", TWO_LINK, "-o", "{}"], "p.svg"),
    "convert": (["convert", "--force", TWO_LINK, "{}"], "c.toml"),
}
FULL = """
import resource, sys
from symdyn.cli import main
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
sys.exit(main(sys.argv[1:]))
"""


MENDED = {"walkthrough": [pytest.mark.mends("1.6")], "sliders": [pytest.mark.mends("1.6"), pytest.mark.slow]}
MENDED["lesson with pictures"] = [pytest.mark.mends("1.6"), pytest.mark.slow]
MENDED["draw"] = [pytest.mark.slow]


def doors(*names: str) -> list[object]:
    return [pytest.param(name, marks=MENDED.get(name, [])) for name in names]


@pytest.mark.long(0)
@pytest.mark.parametrize("door", doors("walkthrough", "lesson with pictures", "sliders", "draw", "convert"))
def test_a_link_that_stands_where_a_file_goes_is_replaced_not_followed(door: str, tmp_path: Path) -> None:
    words, name = DOORS[door]
    (tmp_path / "mine").write_text("mine")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).symlink_to(tmp_path / "mine")

    assert main([word.format(tmp_path / "out" / name) for word in words]) == 0

    assert (tmp_path / "mine").read_text() == "mine"
    assert not (tmp_path / "out" / name).is_symlink()
    assert (tmp_path / "out" / name).stat().st_size > 400


@pytest.mark.runs
@pytest.mark.skipif(sys.platform == "win32", reason="limits on files are those of POSIX")
@pytest.mark.parametrize("door", doors("walkthrough", "lesson with pictures", "sliders", "draw"))
def test_a_full_disk_leaves_nothing_new_and_keeps_what_was_there(door: str, tmp_path: Path) -> None:
    words, name = DOORS[door]
    path = tmp_path / name
    path.write_text("before")
    command = [sys.executable, "-c", FULL, *(word.format(path) for word in words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | _here())

    assert done.returncode == 1
    assert "File too large" in done.stderr
    assert path.read_text() == "before"
    assert os.listdir(tmp_path) == [name]


def _here() -> dict[str, str]:
    return {"PYTHONPATH": os.pathsep.join(part for part in sys.path if part)}


def test_what_fails_while_it_is_written_leaves_no_file_at_all(tmp_path: Path) -> None:
    def fill(file: object) -> None:
        raise OSError(28, "No space left on device")

    with pytest.raises(EmitError, match=r"cannot write a.txt, b.txt there \(No space left on device\)"):
        write({"a.txt": "whole", "b.txt": fill}, tmp_path)
    assert os.listdir(tmp_path) == []


def test_an_interrupt_leaves_no_file_at_all(tmp_path: Path) -> None:
    def fill(file: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write({"a.txt": b"whole", "b.txt": fill}, tmp_path)
    assert os.listdir(tmp_path) == []


def test_files_lie_in_their_folder_and_nowhere_else(tmp_path: Path) -> None:
    for name in ("../a", "a/../../b", "/tmp/a", "a//b", "./a", "a/"):
        with pytest.raises(AssertionError, match=r"nowhere else|one form"):
            write({name: ""}, tmp_path / "in")
    assert os.listdir(tmp_path / "in") == []


WRITES = {"write_bytes", "replace", "rename", "mkstemp", "NamedTemporaryFile", "TemporaryDirectory", "savetxt"}
OWN = {  # beside the cache of compiled code, in runtime/
    "emit/writing.py": "the one place",
    "bench/time_and_error.py": "a folder of its own, for what is compiled and timed",
    "draw/films.py": "a folder of its own, for ffmpeg",
    "study/run_sweep.py": "a folder of its own, in which Zarr makes a store; it is renamed when it is whole",
    "teach/render/latex.py": "a folder of its own, for pdflatex",
}


@cache
def parsed() -> dict[str, list[ast.Call | ast.Import | ast.ImportFrom]]:
    """Return the calls and imports of every module of symdyn that may write or escape."""
    kinds = (ast.Call, ast.Import, ast.ImportFrom)
    may = re.compile("|".join([*(WRITES - {"replace"}), r"os\.replace", r"open\(", "html", "saxutils", "markupsafe"]))
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(ROOT.rglob("*.py"))}
    trees = {path: ast.parse(text) for path, text in texts.items() if may.search(text)}
    return {
        path.relative_to(ROOT).as_posix(): [x for x in ast.walk(tree) if isinstance(x, kinds)]
        for path, tree in trees.items()
    }


@pytest.mark.long(0)
def test_one_file_writes_for_all_doors() -> None:
    found = {name for name, nodes in parsed().items() if any(isinstance(x, ast.Call) and _writes(x) for x in nodes)}
    assert {name for name in found if not name.startswith("runtime/")} == set(OWN)


def _writes(call: ast.Call) -> bool:
    """Return whether a call makes a file, renames one, or opens one for writing."""
    called = getattr(call.func, "attr", getattr(call.func, "id", ""))
    if called == "open":
        given = [*call.args, *(keyword.value for keyword in call.keywords)]
        return any(isinstance(x, ast.Constant) and x.value in ("w", "wb", "a", "ab", "x", "xb") for x in given)
    on = call.func.value if isinstance(call.func, ast.Attribute) else None
    return called in WRITES and (getattr(on, "id", "") in ("os", "tempfile") or called not in ("replace", "save"))


def test_text_is_escaped_for_a_target_in_one_file() -> None:
    """What other modules could escape with is imported by no other, but for the XML of robots, which is a format's."""
    tools = {"html", "xml.sax.saxutils", "markupsafe"}
    found: set[tuple[str, str | None]] = set()
    for path, nodes in parsed().items():
        for node in nodes:
            names = [node.module] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            found |= {(path, name) for name in names if name in tools}
    assert found == {("emit/render.py", "html"), ("scene/formats/urdf_writer.py", "xml.sax.saxutils")}


def test_a_file_may_lie_in_a_folder_of_the_folder(tmp_path: Path) -> None:
    assert write({"+a/b.m": "x", "c": b"y"}, tmp_path / "in") == (tmp_path / "in" / "+a" / "b.m", tmp_path / "in" / "c")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["+a", "b.m", "c", "in"]
