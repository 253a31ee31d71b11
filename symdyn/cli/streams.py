"""Standard streams as they come: closed, of a terminal that knows few letters, cut off.

A closed stream (`>&-`) becomes the null device, so that nothing that is opened later takes its number and no message is
printed into a file. What the encoding of a stream lacks is written as its nearest letters, never as a traceback.
"""

from __future__ import annotations

import codecs
import os
import sys
import unicodedata
from typing import Any

READABLE = {
    "·": "*", "×": "x", "−": "-", "–": "-", "—": "-", "…": "...", "≈": "~", "≤": "<=", "≥": ">=", "→": "->", "←": "<-",
    "⇒": "=>", "°": " deg", "∞": "oo", "∂": "d", "∫": "int", "Σ": "sum", "√": "sqrt", "„": '"', "“": '"', "”": '"',
    "‘": "'", "’": "'", "′": "'", "″": "''", "⋅": "*", "±": "+-", "≠": "!=", "≡": "=", "½": "1/2", "⅓": "1/3",
    "─": "-", "━": "-", "│": "|", "└": "`", "├": "|", "✓": "+", "✗": "x", "\xa0": " ",
}  # fmt: skip
"""Characters of our own texts, and what a terminal without them shows."""

LACKING = "symdyn.nearest"
"""Name of the handler of characters that an encoding lacks."""


def prepare_streams() -> None:
    """Put the null device where a standard stream is closed, and let no character end a command."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, _null_device(number, mode))
    codecs.register_error(LACKING, _nearest)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a test's or a notebook's stream may have no encoding to fail at
            stream.reconfigure(errors=LACKING)


def silence_stdout() -> None:
    """Put the null device where nobody reads results any more."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _null_device(number: int, mode: str) -> Any:
    """Return the null device as a stream, under the number of the standard stream that it stands for."""
    opened = os.open(os.devnull, os.O_RDONLY if mode == "r" else os.O_WRONLY)
    if opened != number:
        os.dup2(opened, number)
        os.close(opened)
    return open(number, mode, encoding="utf-8", closefd=False)


def _nearest(error: UnicodeError) -> tuple[str, int]:
    """Return the nearest ASCII letters for what an encoding lacks, and where to go on; "?" if there are none."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    wanted = error.object[error.start : error.end]
    return "".join(_ascii(character) for character in wanted), error.end


def _ascii(character: str) -> str:
    if character in READABLE:
        return READABLE[character]
    if unicodedata.combining(character):
        return ""
    bare = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode("ascii")
    if bare:
        return bare
    name = unicodedata.name(character, "").split()
    return name[-1].lower() if name[:2] in (["GREEK", "SMALL"], ["GREEK", "CAPITAL"]) and len(name) == 4 else "?"
