"""A place in a row of tokens: looking at the next one, taking it, faults at it."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.errors import TeachError
from symdyn.teach.student.source import Source
from symdyn.teach.student.tokens import Token


class Cursor:
    """A row of tokens and how far it is read."""

    def __init__(self, source: Source, tokens: Sequence[Token], end: int) -> None:
        """Begin at the first token; `end` is where the formula ends in the source's text."""
        self.source, self.tokens, self.end = source, tokens, end
        self.next = 0

    def peek(self) -> Token | None:
        """Return the next token, None at the end."""
        return self.tokens[self.next] if self.next < len(self.tokens) else None

    def sees(self, kind: str, *texts: str) -> bool:
        """Whether the next token is of a kind, with one of the texts if there are any."""
        token = self.peek()
        return token is not None and token.kind == kind and (not texts or token.text in texts)

    def take(self) -> Token:
        """Return the next token and go on.

        Raises:
            TeachError: there is none, or it has no place in a formula.
        """
        token = self.peek()
        if token is None:
            raise self.source.fault(self.end, "the formula breaks off; something is missing here")
        if token.kind == "unknown":
            raise self.fault(token, token.text)
        self.next += 1
        return token

    def fault(self, token: Token, message: str) -> TeachError:
        """Return the error for a token."""
        return self.source.fault(token.at, message)
