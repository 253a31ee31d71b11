"""The one place that puts files on disk, for all that write any: all of a file or nothing of it.

Each is filled aside, in its own folder, and renamed, so that a reader sees the old contents or the new ones and never
half of them, a full disk leaves nothing, and a link that stands where the file goes is replaced, not followed.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from errno import EILSEQ, EISDIR, ENAMETOOLONG, ENOSPC
from pathlib import Path, PurePosixPath
from stat import S_ISDIR
from typing import IO

from symdyn.arguments import suggesting
from symdyn.errors import EmitError, SymdynError, quoted

ELSEWHERE = "give a folder that you may write to"
SPELLED = "give names of characters that UTF-8 has"
WAYS_OUT: Mapping[int | None, str] = {
    EILSEQ: SPELLED,
    EISDIR: "give another name",
    ENAMETOOLONG: "give a shorter name",
    ENOSPC: "make room, or give a folder on another disk",
}
"""What helps against what a system says, where it is not another folder."""

IN_A_SHELL = "of a scene, symdyn generate SCENE --target c -o FOLDER writes code in a shell"
Contents = str | bytes | Callable[[IO[bytes]], None]


@suggesting
def write(files: Mapping[str, Contents], folder: str | Path) -> tuple[Path, ...]:
    """Write files into a folder and return the paths; all are filled before the first is renamed.

    Args:
        files: contents by name, with a folder or several before a stroke: text, which becomes UTF-8, bytes, or what
            fills an open file.
        folder: where they go; it is made if it is missing, as are the folders in it.

    Raises:
        EmitError: the folder cannot be made or written to; two names are one where capital letters do not count.
    """
    if not isinstance(files, Mapping):
        raise EmitError(f"files = {quoted(files)}: give contents by name; {IN_A_SHELL}")
    place = Path(folder)
    if "\0" in "".join(map(str, (place, *files))):
        raise EmitError(f"{place / next(iter(files), '')}: no system allows this name; give another folder")
    folded: dict[str, str] = {}
    for name in files:
        other = folded.setdefault(name.casefold(), name)
        if other != name:
            raise EmitError(
                f"{other} and {name} differ in capital letters alone, and are one file on many systems; rename one"
            )
    try:
        place.mkdir(parents=True, exist_ok=True)
        with ExitStack() as left_over:
            aside = []
            for name, contents in files.items():
                inside = PurePosixPath(name)
                assert str(inside) == name, "a name has one form"
                assert not {"..", inside.anchor} & {*inside.parts}, "files lie in the folder, nowhere else"
                (place / inside.parent).mkdir(parents=True, exist_ok=True)
                # what no file can replace is told before another file is renamed
                path = place / name
                if path.is_dir() and not path.is_symlink():
                    raise IsADirectoryError(EISDIR, "a folder of that name stands there")
                aside.append(temporary := _aside((place / name).parent))
                left_over.callback(temporary.unlink, missing_ok=True)
                with temporary.open("wb") as file:
                    if callable(contents):
                        contents(file)
                    else:
                        file.write(contents.encode() if isinstance(contents, str) else contents)
            for temporary, name in zip(aside, files, strict=True):
                os.replace(temporary, place / name)
    except (OSError, ValueError) as fault:  # a name that no system can spell
        reason = getattr(fault, "strerror", None) or str(fault)
        advice = WAYS_OUT.get(fault.errno, ELSEWHERE) if isinstance(fault, OSError) else SPELLED
        raise EmitError(f"{place}: cannot write {', '.join(files)} there ({reason}); {advice}") from fault
    return tuple(place / name for name in files)


def write_file(file: str | Path, contents: Contents, error: type[SymdynError] = EmitError) -> Path:
    """Write one file, as `write` does, into a folder that is there: one that is not may be mistyped.

    Raises:
        EmitError, or another that is given: it cannot be written, or has no name or no folder.
    """
    path = Path(file)
    if path.name in ("", ".."):
        raise error(f"file = {quoted(str(file))} is a folder; give the path of a file")
    check_folder(path, error)
    try:
        return write({path.name: contents}, path.parent)[0]
    except EmitError as fault:
        raise error(str(fault)) from fault.__cause__


def check_folder(path: Path, error: type[SymdynError] = EmitError) -> None:
    """Raise an error where the folder of a file is not there."""
    try:
        there = S_ISDIR(os.stat(path.parent).st_mode)
    except (OSError, ValueError) as fault:
        there = not isinstance(fault, FileNotFoundError | NotADirectoryError)  # else `write` says why
    if not there:
        raise error(f"{path}: there is no folder {path.parent}; make it, or give another")


def _aside(place: Path) -> Path:
    """Return a new empty file in a folder, with the permissions of any other file there."""
    import tempfile  # with all compressors, which few commands want

    handle, name = tempfile.mkstemp(prefix=".symdyn-", dir=place)
    os.close(handle)
    mask = os.umask(0)
    os.umask(mask)
    os.chmod(name, 0o666 & ~mask)
    return Path(name)
