r"""Tokens of a student's formula: the same for LaTeX and for plain text.

word      a name with its indices, as letters and digits alone: q_{1}, q1 and q_1 are "q1", \theta_1 is "theta1"
sub       an index that follows a bracket or an accent
number    exact; 0.5 and 0,5
command   \frac, \sqrt, \dot, a function, a brace
open, close, op      brackets and + - * / ^ =
row, stop            the end of a line; the end of a formula
unknown              what has no place in a formula; its text says why

A cursor reads them one by one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from symdyn.errors import TeachError
from symdyn.scene.values import GREEK
from symdyn.teach.student.source import Source

FUNCTIONS = ("sin", "cos", "tan", "sqrt", "exp", "log", "ln", "tanh", "abs", "sign", "sgn")
COMMANDS = ("frac", "sqrt", "dot", "ddot", "underbrace", "overbrace")
SILENT: tuple[str, ...]
SILENT = ("quad", "qquad", "left", "right", "displaystyle", "textstyle", "limits", "nonumber", "notag", "hfill")
SILENT += tuple(f"{size}{side}" for size in ("big", "Big", "bigg", "Bigg") for side in ("", "l", "r"))
OPENING = {"(": ")", "[": "]", "{": "}", "\\{": "\\}", "\\lvert": "\\rvert"}
UPRIGHT = ("mathrm", "mathit", "mathbf", "mathsf", "mathtt", "text", "textrm", "operatorname", "textit", "boldsymbol")
SAME = {"varphi": "phi", "vartheta": "theta", "varepsilon": "epsilon", "varrho": "rho", "dfrac": "frac"}
SAME |= {"tfrac": "frac", "cfrac": "frac", "sgn": "sign", "ln": "log", "vert": "lvert"}
KINDS = {"op": "+-*/^=", "open": "([{", "close": ")]}", "stop": ",.:"}
CHARACTERS = {character: kind for kind, characters in KINDS.items() for character in characters}
MOST_DIGITS, MOST_LETTERS = 40, 200

_SPACE = re.compile(r"[ ~&]+|\\[,;:! >]")
_NUMBER = re.compile(r"\d+(?:(?:\.|\{,\}|,(?=\d))\d+)?(?:[eE][+-]?\d{1,3}(?![A-Za-z0-9_]))?|\.\d+")
_WORD = re.compile(r"[A-Za-z][A-Za-z0-9]*")
_COMMAND = re.compile(r"\\([A-Za-z]+)")
_EQUATION_NUMBER = re.compile(r"\\q?quad\s*\(\d+(?:\.\d+)*[a-z]?\)|\\(?:tag|label)\*?\{[^{}]*\}")
_ENVIRONMENT = re.compile(r"\\(?:begin|end)\{[^{}]*\}(?:\{[^{}]*\})?|\$\$?|\\[\[\]()]|;|\n *\n")
_ROW = re.compile(r"\\\\(?:\[[^\]]*\])?|\n")
_GROUP = re.compile(r"\{(?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*\}")
_INDICES = (_GROUP, re.compile(r"\\[A-Za-z]+(?:\{[^{}]*\})?"), re.compile(r"[A-Za-z0-9]+"))
_UNDERSCORES = re.compile("_+")


@dataclass(frozen=True)
class Token:
    """One token of a kind, see the module; it begins `at` in the source's text. Dots of a word come from primes."""

    kind: str
    text: str
    at: int
    dots: int = 0
    value: Fraction = Fraction(0)


def tokens(source: Source) -> list[Token]:
    """Return the tokens of a text.

    Raises:
        TeachError: an index, a brace or digits that cannot be right.
    """
    return _Lexer(source).run()


def plain_index(text: str) -> str:
    """Return an index as letters and digits alone: "{C,1,12}" is "C112"."""
    bare = re.sub(r"\\(?:" + "|".join(UPRIGHT) + r")(?![A-Za-z])", "", text)
    return re.sub(r"\\[,;:! ]|[\\{},_ ]", "", bare)


class _Lexer:
    def __init__(self, source: Source) -> None:
        self.source, self.text, self.at = source, source.text, 0
        self.found: list[Token] = []

    def run(self) -> list[Token]:
        while self.at < len(self.text):
            self._next()
        return self.found

    def _add(self, kind: str, text: str, end: int, dots: int = 0, value: Fraction = Fraction(0)) -> None:
        self.found.append(Token(kind, text, self.at, dots, value))
        self.at = end

    def _next(self) -> None:
        text, at = self.text, self.at
        for pattern, kind in ((_EQUATION_NUMBER, ""), (_ENVIRONMENT, "stop"), (_ROW, "row"), (_SPACE, "")):
            if found := pattern.match(text, at):
                if kind:
                    self._add(kind, found[0], found.end())
                else:
                    self.at = found.end()
                return
        if found := _NUMBER.match(text, at):
            if len(found[0]) > MOST_DIGITS:
                raise self.source.fault(at, f"a number of {len(found[0])} characters; {MOST_DIGITS} are allowed")
            plain = found[0].replace("{,}", ".").replace(",", ".")
            self._add("number", found[0], found.end(), value=Fraction(plain))
        elif found := _WORD.match(text, at):
            self._word(found[0], found.end())
        elif found := _COMMAND.match(text, at):
            self._command(found[1], found.end())
        elif text.startswith("**", at):
            self._add("op", "^", at + 2)
        elif text.startswith(("\\{", "\\}"), at):
            self._add(CHARACTERS[text[at + 1]], text[at : at + 2], at + 2)
        elif text[at] == "_":
            index, end = self._index(at)
            self._add("sub", index, end)
        elif text[at] in CHARACTERS:
            self._add(CHARACTERS[text[at]], text[at], at + 1)
        else:
            self._add("unknown", f"{text[at]!r} has no place in a formula", at + 1)

    def _word(self, name: str, end: int) -> None:
        if len(name) > MOST_LETTERS:
            raise self.source.fault(self.at, f"a name of {len(name)} characters; put spaces or * between factors")
        if name in FUNCTIONS and (end >= len(self.text) or self.text[end] != "_"):
            self._add("command", SAME.get(name, name), end)
            return
        while under := _UNDERSCORES.match(self.text, end):
            index, end = self._index(under.end() - 1, optional=len(name) > 1)
            name += index
        dots = 0
        while dots < 2 and end < len(self.text) and self.text[end] == "'":
            dots, end = dots + 1, end + 1
        self._add("command" if name == "pi" and not dots else "word", name, end, dots)

    def _index(self, at: int, optional: bool = False) -> tuple[str, int]:
        """Return the index that begins with the underscore at `at`, and where it ends; names of code end in _ too."""
        for pattern in _INDICES:
            if found := pattern.match(self.text, at + 1):
                return plain_index(found[0]), found.end()
        if optional:
            return "", at + 1
        raise self.source.fault(at, "an index is missing; write q_1 or q_{12}")

    def _command(self, name: str, end: int) -> None:
        name = SAME.get(name, name)
        if name in SILENT:
            self.at = end
        elif name in GREEK and name != "pi":
            self._word(name, end)
        elif name == "pi":
            self._add("command", name, end)
        elif name in UPRIGHT:
            group = _GROUP.match(self.text, end)
            if not group:
                raise self.source.fault(self.at, f"\\{name} needs braces: \\{name}{{m}}")
            self._word(plain_index(group[0]), group.end())
        elif name in ("lvert", "rvert"):
            self._add("open" if name == "lvert" else "close", f"\\{name}", end)
        elif name in ("cdot", "times", "ast"):
            self._add("op", "*", end)
        elif name in FUNCTIONS or name in COMMANDS:
            self._add("command", name, end)
        elif name in ("partial", "int", "sum"):
            self._add("unknown", f"\\{name}: carry it out first; results are compared, not steps", end)
        else:
            self._add("unknown", f"\\{name} is not known here; write the formula with \\frac, \\sin, \\dot", end)


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
