"""A small reader of JME, written from Numbas' documents: what the marking scripts of exercises use of it."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

TOKEN = re.compile(
    r"""\s*(?:(?P<number>\d+(?:\.(?!\.)\d+)?)|(?P<text>"(?:\\.|[^"\\])*")|(?P<word>[A-Za-z_]\w*)"""
    r"""|(?P<op>\.\.|<=|>=|<>|[-+*/^<>=()\[\],;:]))""",
    re.DOTALL,
)
BINDS = {";": 1, "or": 3, "and": 4, "isa": 6, "=": 6, "<>": 6, "<": 6, ">": 6, "<=": 6, ">=": 6, "..": 7,
         "+": 8, "-": 8, "*": 9, "/": 9, "^": 11}  # fmt: skip
RIGHT = ("^", ";")
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "abs": abs, "len": len, "trim": str.strip, "sqrt": math.sqrt, "sin": math.sin, "cos": math.cos, "exp": math.exp,
    "ln": math.log, "sgn": lambda x: (x > 0) - (x < 0), "tanh": math.tanh, "all": all, "some": any, "safe": str,
    "max": lambda *x: max(x[0] if isinstance(x[0], list) else x), "html": str, "json_decode": json.loads,
    "expression": str, "atan2": math.atan2,
}  # fmt: skip


class JmeError(Exception):
    """What JME cannot read or evaluate."""


class EndError(Exception):
    """The end of a marking script."""


def parsed(text: str) -> Any:
    """Return the tree of an expression: numbers, ("text", x), ("name", x), (operator, ...), ("call", name, args)."""
    rest, found = text.strip(), []
    while rest:
        token = TOKEN.match(rest)
        if not token:
            raise JmeError(f"what is {rest[:20]!r}?")
        found.append((str(token.lastgroup), token[str(token.lastgroup)]))
        rest = rest[token.end() :].strip()
    parser = _Parser(found)
    tree = parser.expression(0)
    if parser.at < len(found):
        raise JmeError(f"{found[parser.at][1]} is one too many")
    return tree


class _Parser:
    def __init__(self, tokens: list[tuple[str, str]]) -> None:
        self.tokens, self.at = tokens, 0

    def peek(self) -> str:
        return self.tokens[self.at][1] if self.at < len(self.tokens) else ""

    def take(self, wanted: str = "") -> tuple[str, str]:
        if self.at >= len(self.tokens) or (wanted and self.peek() != wanted):
            raise JmeError(f"{wanted or 'more'} is missing")
        self.at += 1
        return self.tokens[self.at - 1]

    def expression(self, least: int) -> Any:
        left = self.prefix()
        while (op := self.peek()) in BINDS and BINDS[op] >= least:
            self.take()
            left = (op, left, self.expression(BINDS[op] + (op not in RIGHT)))
        return left

    def prefix(self) -> Any:
        kind, text = self.take()
        if kind == "number":
            return float(text)
        if kind == "text":
            return self.indexed(("text", json.loads(text, strict=False)))
        if text == "-":
            return ("negative", self.expression(10))
        if text == "not":
            return ("not", self.expression(5))
        if text == "(":
            inside = self.expression(0)
            self.take(")")
            return self.indexed(inside)
        if text == "[":
            return self.indexed(("list", self.listed("]")))
        if kind != "word":
            raise JmeError(f"{text} stands where a value should")
        if self.peek() == "(":
            self.take()
            return self.indexed(("call", text, self.listed(")")))
        return self.indexed(("name", text))

    def listed(self, end: str) -> list[Any]:
        found = []
        while self.peek() != end:
            item = self.expression(0)
            if self.peek() == ":":
                self.take()
                item = ("pair", item, self.expression(0))
            found.append(item)
            if self.peek() == ",":
                self.take()
        self.take(end)
        return found

    def indexed(self, tree: Any) -> Any:
        while self.peek() == "[":
            self.take()
            tree = ("at", tree, self.expression(0))
            self.take("]")
        return tree


@dataclass
class Script:
    """A marking script with the variables of its question."""

    notes: Mapping[str, str]
    known: Mapping[str, Any]
    values: dict[str, Any] = field(default_factory=dict)
    credit: float | None = None
    said: str = ""
    read: bool = True

    @classmethod
    def of(cls, text: str, known: Mapping[str, Any]) -> Script:
        """Read the notes: name (description): expression."""
        heads = list(re.finditer(r"^([a-z_]+)(?: \((?:.*?)\))?:", text, re.MULTILINE))
        ends = [*(head.start() for head in heads[1:]), len(text)]
        return cls({h[1]: text[h.end() : end] for h, end in zip(heads, ends, strict=True)}, known)

    def mark(self) -> float:
        """Return the credit, 0 to 1."""
        try:
            self.note("mark")
        except EndError:
            self.credit, self.read = 0.0, False
        assert self.credit is not None, "a script says what an answer is worth"
        return self.credit

    def note(self, name: str) -> Any:
        """Return a note's value."""
        if name not in self.values:
            self.values[name] = self.value(parsed(self.notes[name]), {})
        return self.values[name]

    def value(self, tree: Any, names: Mapping[str, Any]) -> Any:
        """Return the value of a tree."""
        if isinstance(tree, float):
            return tree
        kind, *parts = tree
        if kind == "text":
            return parts[0]
        if kind == "name":
            return self.named(parts[0], names)
        if kind == "list":
            if any(isinstance(x, tuple) and x[0] == "pair" for x in parts[0]):
                return {self.value(k, names): self.value(v, names) for _, k, v in parts[0]}
            return [self.value(x, names) for x in parts[0]]
        if kind == "call":
            return self.called(parts[0], parts[1], names)
        if kind in ("and", "or"):
            first = self.value(parts[0], names)
            return self.value(parts[1], names) if bool(first) == (kind == "and") else first
        return self.combined(kind, [self.value(x, names) for x in parts])

    def named(self, name: str, names: Mapping[str, Any]) -> Any:
        for table in (names, self.known):
            if name in table:
                return table[name]
        if name in self.notes:
            return self.note(name)
        constants = {"pi": math.pi, "e": math.e, "true": True, "false": False, "nothing": None}
        if name not in constants:
            raise JmeError(f"{name} is not known")
        return constants[name]

    @staticmethod
    def combined(kind: str, x: list[Any]) -> Any:
        if kind == "at":
            return x[0][int(x[1]) if isinstance(x[0], list) else x[1]]
        if kind == "..":
            return [float(k) for k in range(int(x[0]), int(x[1]) + 1)]
        if kind == "isa":
            return isinstance(x[0], float) and x[1] == "number"
        by = {
            "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b,
            "^": lambda a, b: a**b, "=": lambda a, b: a == b, "<>": lambda a, b: a != b, "<": lambda a, b: a < b,
            ">": lambda a, b: a > b, "<=": lambda a, b: a <= b, ">=": lambda a, b: a >= b, ";": lambda a, b: b,
            "negative": lambda a: -a, "not": lambda a: not a,
        }  # fmt: skip
        return by[kind](*x)

    def called(self, name: str, args: list[Any], names: Mapping[str, Any]) -> Any:
        def at(tree: Any, **more: Any) -> Any:
            return self.value(tree, {**names, **more})

        if name == "if":
            return at(args[1] if at(args[0]) else args[2])
        if name == "let":
            *pairs, body = args
            inside = dict(names)
            for key, tree in zip(pairs[::2], pairs[1::2], strict=True):
                inside[key[1]] = self.value(tree, inside)
            return self.value(body, inside)
        if name == "map":
            return [at(args[0], **{args[1][1]: x}) for x in at(args[2])]
        if name == "filter":
            return [x for x in at(args[2]) if at(args[0], **{args[1][1]: x})]
        if name == "try":
            try:
                return at(args[0])
            except (JmeError, ArithmeticError, ValueError, TypeError, KeyError) as fault:
                return at(args[2], **{args[1][1]: str(fault)})
        if name == "assert":
            return None if at(args[0]) else at(args[1])
        if name == "apply":
            return at(args[0])
        if name == "parse":
            return parsed(at(args[0]))
        if name == "eval":
            point = {key: float(x) for key, x in at(args[1]).items()} if len(args) > 1 else {}
            return Script({}, {}).value(at(args[0]), point)
        if name in ("correct", "incorrect", "fail"):
            self.credit, self.said = float(name == "correct"), at(args[0])
            if name == "fail":
                raise EndError
            return None
        return FUNCTIONS[name](*map(at, args))


@dataclass(frozen=True)
class Numbas:
    """A question of Numbas, read from its file, with one of its variants."""

    text: str
    variant: int = 0

    @property
    def exam(self) -> dict[str, Any]:
        """The file behind its first line."""
        head, _, rest = self.text.partition("\n")
        assert head == "// Numbas version: exam_results_page_options"
        return dict(json.loads(rest))

    @property
    def question(self) -> dict[str, Any]:
        """The one question."""
        ((question,),) = (group["questions"] for group in self.exam["question_groups"])
        return dict(question)

    def known(self) -> dict[str, Any]:
        """Return the variables of the question."""
        found: dict[str, Any] = {"quiz_variant": float(self.variant)}
        for name in ("quiz_data", "quiz_shown"):
            found[name] = Script({}, found).value(parsed(self.question["variables"][name]["definition"]), {})
        return found

    def marked(self, answers: list[tuple[int, str]]) -> list[tuple[float, str]]:
        """Return credit and words of each answer to a part by number from 0."""
        known, parts, told = self.known(), self.question["parts"], []
        for number, text in answers:
            script = Script.of(parts[number]["customMarkingAlgorithm"], {**known, "studentAnswer": text})
            told.append((script.mark(), script.said))
        return told
