"""A picture in a file, by its ending: SVG as it is returned, PDF and PNG painted by matplotlib."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from os import PathLike, fspath
from pathlib import Path

from symdyn.draw.canvas import require
from symdyn.draw.paint import painted
from symdyn.draw.svg import Drawing
from symdyn.emit import Contents, write
from symdyn.errors import DrawError, EmitError

File = str | PathLike[str]

PICTURES: Mapping[str, Callable[[Drawing, str, str], Contents]] = {
    ".svg": lambda drawing, text, scheme: text,
    ".pdf": lambda drawing, text, scheme: painted(drawing, "pdf", scheme),
    ".png": lambda drawing, text, scheme: painted(drawing, "png", scheme),
}
"""Contents of a file by its ending, of a drawing, its SVG text and a colour scheme."""


def check_picture(file: File) -> Path:
    """Return the path of a picture.

    Raises:
        DrawError: an ending that no picture has, or what paints it is not installed.
    """
    path = Path(fspath(file))
    if path.suffix.lower() not in PICTURES:
        raise DrawError(f"{path}: pictures are written to {', '.join(PICTURES)} files")
    if path.suffix.lower() != ".svg":
        require(f"pictures in {path.suffix.lower()} files", "matplotlib")
    return path


def write_picture(file: File, drawing: Drawing, text: str, scheme: str) -> None:
    """Write a drawing, whose SVG text is `text`, to a .svg, .pdf or .png file, all of it or nothing.

    Raises:
        DrawError: another ending, no matplotlib, or a file that cannot be written.
    """
    path = check_picture(file)
    write_whole(path, PICTURES[path.suffix.lower()](drawing, text, scheme))


def write_whole(path: Path, contents: Contents) -> None:
    """Write a file, all of it or nothing.

    Raises:
        DrawError: it cannot be written, and why.
    """
    try:
        write({path.name: contents}, path.parent)
    except EmitError as fault:
        raise DrawError(str(fault)) from None
