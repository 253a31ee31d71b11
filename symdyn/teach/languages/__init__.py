"""Prose of the steps by key, a module a language: templates with named places, no mathematics."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from symdyn.teach.languages.en import TEXTS as ENGLISH
from symdyn.teach.languages.sk import TEXTS as SLOVAK

if TYPE_CHECKING:
    from symdyn.algebra.form import Form
    from symdyn.teach.document import Words

LANGUAGES: Mapping[str, Mapping[str, str]] = {"en": ENGLISH, "sk": SLOVAK}

PLACE = re.compile(r"\{(\w+)\}")


def fill(template: str, places: Mapping[str, str | Form | Words]) -> tuple[str | Form, ...]:
    """Return the parts of a template with its places filled; a place without a value is a KeyError."""
    parts: list[str | Form] = []
    for k, piece in enumerate(PLACE.split(template)):
        value = places[piece] if k % 2 else piece
        inner: tuple[str | Form, ...] = value.parts if hasattr(value, "parts") else (value,)
        for part in inner:
            if isinstance(part, str) and parts and isinstance(parts[-1], str):
                parts[-1] += part
            elif part != "":
                parts.append(part)
    return tuple(parts)
