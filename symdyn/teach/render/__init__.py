"""Formats of a document, `FORMATS` is the table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING

from symdyn.errors import EmitError, choice

if TYPE_CHECKING:
    from symdyn.teach.document import Document

FORMATS: Mapping[str, tuple[str, str]] = {  # name: module and function, imported when asked for
    "md": ("markdown", "markdown"),
    "latex": ("latex", "latex"),
    "pdf": ("latex", "pdf"),
    "html": ("html", "html"),
    "notebook": ("notebook", "notebook"),
}


def rendered(document: Document, format: str) -> dict[str, str | bytes]:
    """Return the files of a document in one format, by name, the text first.

    Raises:
        EmitError: an unknown format, or a program that the format needs is absent.
    """
    if format not in FORMATS:
        raise EmitError(f"format {format!r} is not known; {choice(format, FORMATS)}")
    module, function = FORMATS[format]
    render: Callable[[Document], dict[str, str | bytes]] = getattr(import_module(f"{__name__}.{module}"), function)
    return render(document)
