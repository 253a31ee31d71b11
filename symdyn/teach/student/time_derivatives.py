r"""Functions of time and their derivatives, as books and computer algebra write them, in the one way that is parsed.

q_2(t), q_{2}{\left(t \right)}                              q_2
\frac{d}{dt} q_1, \frac{dq_1}{dt}, dq_1/dt, d/dt q_1          q_1'
Derivative(q1(t), t), diff(q1, t, t), Derivative(q1, (t, 2))   q_1', q_1''
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.teach.student.source import Source
from symdyn.teach.student.tokens import Token
from symdyn.teach.student.vocabulary import Names

OF_TIME = (["(", "t", ")"], ["{", "(", "t", ")", "}"], ["[", "t", "]"])
ONCE = (["d", "t"], ["dt"])
BRACED = ["^", "{", "2", "}"]
CALLS = ("Derivative", "diff", "Diff", "D")
BY_TIME = (
    ([",", "t", ")"], 1),
    ([",", "t", ",", "t", ")"], 2),
    ([",", "(", "t", ",", "2", ")", ")"], 2),
    ([",", "t", ",", "2", ")"], 2),
)


def without_time(source: Source, tokens: Sequence[Token], names: Names) -> list[Token]:
    """Return the tokens with primes in place of derivatives with respect to time, and no "(t)" behind a coordinate.

    Raises:
        TeachError: the derivative of what is no coordinate, which is a step and no result.
    """
    return _Timeless(source, tokens, names).run()


class _Timeless:
    def __init__(self, source: Source, tokens: Sequence[Token], names: Names) -> None:
        self.source, self.names = source, names
        self.moving = {*names.dotted, *names.rates}
        self.found = list(tokens)

    def run(self) -> list[Token]:
        self.found = self._without_arguments()
        kept: list[Token] = []
        at = 0
        while at < len(self.found):
            taken = self._fraction(at) or self._slash(at) or self._call(at)
            if taken:
                word, at = taken
                kept.append(word)
            else:
                kept.append(self.found[at])
                at += 1
        return kept

    # What stands where

    def _texts(self, at: int, count: int) -> list[str]:
        return [token.text for token in self.found[at : at + count]]

    def _sees(self, at: int, *patterns: Sequence[str]) -> int:
        """Return how many tokens the first pattern that fits has, 0 if none fits."""
        return next((len(one) for one in patterns if self._texts(at, len(one)) == list(one)), 0)

    def _is_moving(self, text: str) -> bool:
        return self.names.symbols.get(text) in self.moving

    def _without_arguments(self) -> list[Token]:
        """Return the tokens without "(t)" behind what moves."""
        kept: list[Token] = []
        at = 0
        while at < len(self.found):
            skipped = self._sees(at, *OF_TIME)
            if skipped and self._moves_before(kept):
                at += skipped
            else:
                kept.append(self.found[at])
                at += 1
        return kept

    def _moves_before(self, kept: Sequence[Token]) -> bool:
        if not kept:
            return False
        if kept[-1].kind == "word":
            return self._is_moving(kept[-1].text)
        tail = [token.text for token in kept[-6:] if token.kind not in ("sub", "number")]
        return len(tail) >= 4 and tail[-4] in ("dot", "ddot") and (tail[-3], tail[-1]) == ("{", "}")

    # Derivatives

    def _word(self, at: int) -> tuple[Token, int] | None:
        """Return what moves and stands at a place, in brackets or not, with its dots, and where it ends."""
        token = self.found[at] if at < len(self.found) else None
        if token is None:
            return None
        if token.kind == "open" and token.text in "({":
            inside = self._word(at + 1)
            closed = inside and inside[1] < len(self.found) and self.found[inside[1]].kind == "close"
            return (inside[0], inside[1] + 1) if inside and closed else None
        if token.kind == "command" and token.text in ("dot", "ddot"):
            inside = self._word(at + 1)
            more = 1 if token.text == "dot" else 2
            return (replace(inside[0], dots=inside[0].dots + more), inside[1]) if inside else None
        if token.kind == "word" and self._is_moving(token.text):
            return token, at + 1
        return None

    def _order(self, at: int, heads: Sequence[Sequence[str]]) -> tuple[int, int]:
        """Return how often d or dt is meant at a place, 0 for not at all, and where that ends."""
        size = self._sees(at, *heads)
        if not size:
            return 0, at
        squared = self._sees(at + size, BRACED, BRACED[:1] + BRACED[2:3])
        return (2 if squared else 1), at + size + squared

    def _fraction(self, at: int) -> tuple[Token, int] | None:
        if not (self._sees(at, ["frac", "{"]) and self.found[at].kind == "command"):
            return None
        inner = self.found[at + 2] if at + 2 < len(self.found) else None
        above, end = self._order(at + 2, [["d"]])
        word: tuple[Token, int] | None = None
        if above:
            word = self._word(end)
        elif inner is not None and inner.text.startswith("d") and self._is_moving(inner.text[1:]):
            above, word = 1, (replace(inner, text=inner.text[1:]), at + 3)
        end = word[1] if word else end
        if not above or not self._sees(end, ["}", "{"]):
            return None
        below, end = self._order(end + 2, ONCE)
        if below != above or not self._sees(end, ["}"]):
            return None
        return self._derived(self.found[at], word or self._word(end + 1), above, end + 1)

    def _slash(self, at: int) -> tuple[Token, int] | None:
        """Return d/dt q1, or dq1/dt."""
        token = self.found[at]
        if token.kind != "word" or not self._sees(at + 1, ["/", "dt"]) or "dt" in self.names.symbols:
            return None
        if token.text == "d":
            return self._derived(token, self._word(at + 3), 1, at + 3)
        if token.text.startswith("d") and self._is_moving(token.text[1:]):
            return self._derived(token, (replace(token, text=token.text[1:]), at + 3), 1, at + 3)
        return None

    def _call(self, at: int) -> tuple[Token, int] | None:
        token = self.found[at]
        if token.text not in CALLS or token.text in self.names.symbols or not self._sees(at + 1, ["("]):
            return None
        word = self._word(at + 2)
        for pattern, order in BY_TIME:
            if word and self._sees(word[1], pattern):
                return self._derived(token, word, order, word[1] + len(pattern))
        return self._derived(token, None, 1, at)

    def _derived(self, token: Token, word: tuple[Token, int] | None, order: int, end: int) -> tuple[Token, int]:
        if word is None:
            raise self.source.fault(
                token.at, "derivatives are read of coordinates only; carry this one out first: results are compared"
            )
        return replace(word[0], dots=word[0].dots + order), max(end, word[1])
