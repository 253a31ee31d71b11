"""Every word of lessons, pages and answers, a file a language: templates with named places, no mathematics."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from symdyn.algebra import Form
from symdyn.errors import TeachError, choice
from symdyn.frozen import dataclass, field

if TYPE_CHECKING:
    from symdyn.teach.document import Words

FOLDER = Path(__file__).parent
"""Where the files are: en.toml, sk.toml."""

PLACE = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True)
class Language:
    """What is said in one language.

    Attributes:
        code: "en".
        name: what its speakers call it.
        decimal: what stands before the decimals of a number.
        lesson: prose of lessons by key.
        page: words of the interactive page.
        answers: sentences to a student about an answer.
        mistakes: by rule, what a student forgot.
        picture: what parts of pictures are called, from English.
        letters: what letters are that stand for a scene's numbers, from English.
        kinds: what a type of joint or a kind of force is called, where its own row does not say it in this language.
    """

    code: str
    name: str
    decimal: str
    lesson: Mapping[str, str]
    page: Mapping[str, str]
    answers: Mapping[str, str]
    mistakes: Mapping[str, str]
    picture: Mapping[str, str]
    letters: Mapping[str, str]
    kinds: Mapping[str, str] = field(default_factory=dict)

    def kind(self, type: str, words: Mapping[str, str]) -> str:
        """Return what a type of joint or a kind of force is called, whose row has these words by language."""
        return self.kinds.get(type) or words.get(self.code) or words["en"]

    def letter(self, text: str) -> str:
        """Return what a letter is that stands for a number of the scene, said in English; other texts as they are."""
        for english, said in self.letters.items():
            pattern = "".join(f"(?P<{x}>.+)" if k % 2 else re.escape(x) for k, x in enumerate(PLACE.split(english)))
            if found := re.fullmatch(pattern, text):
                return said.format(
                    **{key: self.letter(x) if key == "what" else x for key, x in found.groupdict().items()}
                )
        return text


def languages() -> tuple[str, ...]:
    """Return the codes of all languages, English first."""
    return tuple(sorted((path.stem for path in FOLDER.glob("*.toml")), key=lambda code: (code != "en", code)))


def language_of(code: str) -> Language:
    """Return a language by its code.

    Raises:
        TeachError: there is no such language.
    """
    if code not in languages():
        raise TeachError(f"language {code!r} is not known; {choice(code, languages())}")
    return _read(FOLDER / f"{code}.toml")


@cache
def _read(path: Path) -> Language:
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    tables = data.pop("lesson").values()
    prose = {key: text for part in tables for key, text in part.items()}
    assert len(prose) == sum(map(len, tables)), f"{path.name}: two tables of lessons say different things by one key"
    return Language(path.stem, lesson=prose, **data)


def fill(template: str, places: Mapping[str, str | Form | Words]) -> tuple[str | Form, ...]:
    """Return the parts of a template with its places filled; a place without a value is a KeyError."""
    parts: list[str | Form] = []
    for k, piece in enumerate(PLACE.split(template)):
        value = places[piece] if k % 2 else piece
        inner: tuple[str | Form, ...] = (value,) if isinstance(value, (str, Form)) else value.parts
        for part in inner:
            if isinstance(part, str) and parts and isinstance(parts[-1], str):
                parts[-1] += part
            elif part != "":
                parts.append(part)
    return tuple(parts)
