"""Formats of a document, `FORMATS` is the table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from symdyn.errors import EmitError, choice

if TYPE_CHECKING:
    from symdyn.teach.document import Document
    from symdyn.teach.render.quiz_text import Quiz

FORMATS: Mapping[str, tuple[str, str]] = {  # name: module and function, imported when asked for
    "md": ("markdown", "markdown"),
    "latex": ("latex", "latex"),
    "pdf": ("latex", "pdf"),
    "html": ("html", "html"),
    "notebook": ("notebook", "notebook"),
}

PLATFORMS: Mapping[str, tuple[str, str]] = {  # the same of exercises for learning platforms
    "stack": ("stack", "stack"),
    "prairielearn": ("prairielearn", "prairielearn"),
    "numbas": ("numbas", "numbas"),
}


def rendered(document: Document, format: str) -> dict[str, str | bytes]:
    """Return the files of a document in one format, by name, the text first.

    Raises:
        EmitError: an unknown format, or a program that the format needs is absent.
    """
    if format not in FORMATS:
        raise EmitError(f"format {format!r} is not known; {choice(format, FORMATS)}")
    render: Callable[[Document], dict[str, str | bytes]] = _writer(*FORMATS[format])
    return render(document)


def asked(quiz: Quiz, platform: str) -> dict[str, str | bytes]:
    """Return the files of exercises for a learning platform, a key of `PLATFORMS`, by name."""
    render: Callable[[Quiz], dict[str, str | bytes]] = _writer(*PLATFORMS[platform])
    return render(quiz)


def _writer(module: str, function: str) -> Any:
    return getattr(import_module(f"{__name__}.{module}"), function)
