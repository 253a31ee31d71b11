"""What a scene and the nouns of its lists in `DESCRIBED` are in words, in one language or in several.

text = "crank"
text = { en = "crank", sk = "kľuka" }
"""

from __future__ import annotations

import re
from typing import Any, Protocol

from symdyn.scene.values.entry import Entry, EntryReader, show
from symdyn.scene.values.key import KeyGroup
from symdyn.scene.values.shape import TEXT, Shape, described


class Described(Protocol):
    """What has a description."""

    text: str  # in English, or in the one language that there is
    texts: tuple[tuple[str, str], ...]  # in the others: ("sk", description)


LANGUAGE = re.compile("[a-z]{2}")


def _text(table: EntryReader, scope: object) -> dict[str, Any]:
    """Return `text` and `texts` of what a row says it is, in one language or in several."""
    raw = table.raw.get("text", "")
    if not isinstance(raw, dict):
        return {"text": table.text("text"), "texts": ()}
    if not raw or not all(LANGUAGE.fullmatch(code) for code in raw):
        table.fault(f'text = {show(raw)} needs language codes, such as {{ en = "mass", sk = "hmotnosť" }}')
        return {"text": "", "texts": ()}
    each = EntryReader(Entry(table.entry.name, raw, f"{table.entry.where}.text"), table.faults, tuple(raw))
    said = {code: each.text(code) for code in raw}
    first = "en" if "en" in said else next(iter(said))
    return {"text": said[first], "texts": tuple((code, text) for code, text in said.items() if code != "en")}


def _said_text(one: Described, scope: object) -> dict[str, object]:
    """Return what it is, in one language or in several."""
    if not one.texts:
        return {"text": one.text} if one.text else {}
    english = {} if one.text in dict(one.texts).values() else {"en": one.text}
    return {"text": english | dict(one.texts)}


LANGUAGES: Shape = {
    "type": "object",
    "patternProperties": {"^[a-z]{2}$": TEXT},
    "additionalProperties": False,
    "minProperties": 1,
}

DESCRIBED = KeyGroup(
    {
        "text": described(
            "what it is, for tables and comments; or a table of languages: { en = ..., sk = ... }",
            {"anyOf": [TEXT, LANGUAGES]},
        )
    },
    _text,
    _said_text,
)
