"""A reader of the LaTeX that symdyn prints: formulas back to nodes of a graph, for tests."""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction

from symdyn.graph import Expr, Graph, Op

SKIPPED = re.compile(r"(?:\s|\\,|\\quad|&|\{\}|\\bigl(?!\w)|\\bigr(?!\w)|\\Bigl(?!\w)|\\Bigr(?!\w)|\\biggl|\\biggr)+")
FUNCTIONS = {r"\sin": Op.SIN, r"\cos": Op.COS, r"\exp": Op.EXP, r"\tanh": Op.TANH}


class LatexReader:
    """Reads formulas whose symbols are known: LaTeX of each name, and its value."""

    def __init__(self, symbols: Mapping[str, Expr], graph: Graph) -> None:
        self.symbols = sorted(symbols.items(), key=lambda item: -len(item[0]))
        self.graph = graph
        self.text, self.at = "", 0

    def sides(self, text: str) -> list[Expr]:
        """Return the value of every side of a = b = c."""
        self.text, self.at = text, 0
        sides = [self.sum()]
        while self.take("=") or self.take(r"\approx"):
            sides.append(self.sum())
        self.skip()
        assert self.at == len(text), f"not read: {text[self.at :]!r} of {text!r}"
        return sides

    def skip(self) -> None:
        found = SKIPPED.match(self.text, self.at)
        self.at = found.end() if found else self.at

    def peek(self, word: str) -> bool:
        self.skip()
        return self.text.startswith(word, self.at)

    def take(self, word: str) -> bool:
        found = self.peek(word)
        self.at += len(word) * found
        return found

    def sum(self) -> Expr:
        total = -self.product() if self.take("-") else self.product()
        while self.peek("+") or self.peek("-"):
            negative = self.take("-") or not self.take("+")
            total = total - self.product() if negative else total + self.product()
        return total

    def product(self) -> Expr:
        value = self.power()
        while (
            (self.skip(), self.at < len(self.text))[1]
            and self.text[self.at] not in "+-=)}"
            and not self.peek(r"\approx")
        ):
            self.take(r"\cdot")
            value = value * self.power()
        return value

    def power(self) -> Expr:
        base = self.atom()
        if not self.peek("^"):
            return base
        if half := re.compile(r"\^\{(-?\d+)/2\}").match(self.text, self.at):
            self.at = half.end()
            return self.graph.power(self.graph.sqrt(base), int(half[1]))
        return self.graph.power(base, self.exponent())

    def exponent(self) -> int:
        self.take("^")
        found = re.compile(r"\{(-?\d+)\}|(\d)").match(self.text, self.at)
        assert found, f"no exponent: {self.text[self.at :]!r}"
        self.at = found.end()
        return int(found[1] or found[2])

    def braces(self) -> Expr:
        assert self.take("{"), self.text[self.at :]
        value = self.sum()
        assert self.take("}"), self.text[self.at :]
        return value

    def atom(self) -> Expr:
        self.skip()
        for latex, value in self.symbols:
            end = self.at + len(latex)
            ends_word = not (latex[-1].isalpha() and "\\" in latex and self.text[end : end + 1].isalpha())
            if self.text.startswith(latex, self.at) and ends_word:
                self.at = end
                return value
        if self.take(r"\underbrace"):
            value = self.braces()
            found = re.compile(r"_\{(?:[^{}]|\{[^{}]*\})*\}").match(self.text, self.at)
            assert found, self.text[self.at :]
            self.at = found.end()
            return value
        if self.take(r"\tfrac") or self.take(r"\frac"):
            above = self.braces()
            return above / self.braces()
        if self.take(r"\sqrt"):
            return self.graph.sqrt(self.braces())
        if self.take(r"\pi"):
            return self.graph.pi
        for name, op in FUNCTIONS.items():
            if self.take(name):
                exponent = self.exponent() if self.peek("^") else 1
                return self.graph.power(self.graph.function(op, self.atom()), exponent)
        if self.take("("):
            value = self.sum()
            assert self.take(")"), self.text[self.at :]
            return value
        found = re.compile(r"\d+(?:\.\d+)?").match(self.text, self.at)
        assert found, f"not read: {self.text[self.at :]!r} of {self.text!r}"
        self.at = found.end()
        return self.graph.constant(Fraction(found[0]))


def displays(tex: str) -> list[str]:
    """Return the formulas of every align* in reading order, lines of one formula joined, tags taken off."""
    found = []
    for body in re.findall(r"\\begin\{align\*\}(.*?)\\end\{align\*\}", tex, re.DOTALL):
        for line in body.split(r"\\"):
            plain = re.sub(r"\\tag\{[^}]*\}", "", line).strip()
            if plain.startswith(r"&\quad {}"):
                found[-1] += plain.removeprefix(r"&\quad {}")
            else:
                found.append(plain.replace("&", "", 1))
    return found
