"""What a reader is told who points at a part of a picture, in English; a lesson says it in its own language."""

from __future__ import annotations

from collections.abc import Mapping


class Title(str):
    """An English sentence with its places filled, which remembers how it was made.

    Attributes:
        template: the sentence, with places in braces.
        places: what fills them.
    """

    template: str
    places: Mapping[str, str]

    def __new__(cls, template: str, **places: str) -> Title:
        """Fill a sentence."""
        made = super().__new__(cls, template.format(**places))
        made.template, made.places = template, places
        return made

    def sentence(self, words: Mapping[str, str]) -> str:
        """Return the sentence by a table from English: sentences, and words such as types of joints in their places."""
        filled = {key: words.get(value, value) if key in TRANSLATED else value for key, value in self.places.items()}
        return words.get(self.template, self.template).format(**filled)


ENGLISH: Mapping[str, str] = {}
"""Nothing to translate."""

TRANSLATED = ("type",)
"""Places that hold a word and no name."""
