"""The JSON target: the graph of a program itself, for whoever wants to write one more target, or to keep it.

    <scene>.json    docs/json.md says what it holds; `read_program` reads it back

Numbers are exact: fractions in text, π by its name; there is no float in the file. The text is ASCII.

A file that is read back is a stranger's until all of it has been looked at. What every target writes of a program that
was read is, byte for byte, what it writes of the program itself.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from fractions import Fraction
from math import prod
from typing import Any, NoReturn

from symdyn.arguments import suggesting
from symdyn.bounds import BOUNDS
from symdyn.dynamics import Argument, Function
from symdyn.emit.code.spelling import Printer, Real
from symdyn.emit.code.target import Draft, Target
from symdyn.emit.targets.javascript import JS
from symdyn.errors import SymdynError
from symdyn.graph import Expr, Graph, Op, reachable
from symdyn.program import Program, assemble
from symdyn.scene import read_text, write_text

FORMAT = 1
"""Of the file: a reader of another one refuses it."""


def _write(draft: Draft) -> dict[str, str]:
    program = draft.program
    functions = [routine.function for routine in program.routines]
    nodes = _nodes(functions)
    place = {node: number for number, node in enumerate(nodes)}
    parameters = [{"name": name, "unit": unit, "text": text} for name, unit, text in draft.page.parameters]
    parts = {
        "format": _text(FORMAT),
        "about": _lines(draft.about.split("\n")),
        "scene": _text(write_text(program.scene.in_si(), "toml", lossy=True).text),
        "parameters": _lines(parameters),
        "nodes": _lines(_node(node, place) for node in nodes),
        "functions": _lines(_function(function, place) for function in functions),
    }
    return {f"{draft.stem}.json": "{\n" + ",\n".join(f"{_text(key)}: {text}" for key, text in parts.items()) + "\n}\n"}


def _nodes(functions: Iterable[Function]) -> list[Expr]:
    """Return all that functions are made of, their arguments too, in the order of the graph."""
    functions = list(functions)
    found = {*reachable([entry for function in functions for entry in function.entries])}
    found |= {symbol for function in functions for argument in function.arguments for symbol in argument.symbols}
    return sorted(found, key=lambda node: node.index)


def _node(node: Expr, place: Mapping[Expr, int]) -> list[Any]:
    """Return a node: its operation, then the numbers of its operands, or what a leaf is."""
    told = [str(node.value)] if node.op in (Op.CONSTANT, Op.SYMBOL) else [place[arg] for arg in node.args]
    return [node.op.name.lower(), *told]


def _function(function: Function, place: Mapping[Expr, int]) -> dict[str, Any]:
    told = {
        "name": function.name,
        "text": function.text,
        "arguments": [_argument(argument, place) for argument in function.arguments],
        "result": function.result,
        "shape": list(function.shape),
        "entries": [place[entry] for entry in function.entries],
        "units": function.units,
        "formulation": function.formulation,
        "request": function.request,
        "unique": list(function.unique),
        "labels": [list(labels) for labels in function.labels],
    }
    return {key: value for key, value in told.items() if value != [] or key not in ("unique", "labels")}


def _argument(argument: Argument, place: Mapping[Expr, int]) -> dict[str, Any]:
    return {
        "name": argument.name,
        "text": argument.text,
        "entries": [place[symbol] for symbol in argument.symbols],
        "units": list(argument.units),
        "scalar": argument.scalar,
        "names": argument.names,
    }


def _text(value: Any) -> str:
    return json.dumps(value)


def _lines(values: Iterable[Any]) -> str:
    lines = ",\n".join(map(_text, values))
    return f"[\n{lines}\n]" if lines else "[]"


def _printer(real: Real) -> Printer:
    printer = JS.printer(real)
    return replace(printer, spellings={op: one for op, one in printer.spellings.items() if op is not Op.TABLE})


JSON = Target(
    name="json",
    title="JSON",
    text="the graph itself in JSON, exact, which symdyn reads back",
    files={"{stem}.json": str},
    printer=_printer,
    comment=lambda text: text,
    write=_write,
)


LONGEST = BOUNDS["characters of a program in JSON"]
"""Some millions of nodes."""

MOST_DIMENSIONS = 8
"""Lengths of a shape."""

LONGEST_NUMBER = 2_000
"""Digits of a numerator or denominator."""

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,199}\Z")
SYMBOL_NAME = re.compile(r"[^\W\d]\w{0,199}(\[\d{1,9}\])?\Z")
NUMBER = re.compile(rf"-?\d{{1,{LONGEST_NUMBER}}}(/[1-9]\d{{0,{LONGEST_NUMBER - 1}}})?\Z", re.ASCII)

KEYS = ("format", "about", "scene", "parameters", "nodes", "functions")
FUNCTION = {
    "name": str, "text": str, "arguments": list, "result": str, "shape": list, "entries": list, "units": str,
    "formulation": str, "request": str, "unique": list, "labels": list,
}  # fmt: skip
ARGUMENT = {"name": str, "text": str, "entries": list, "units": list, "scalar": bool, "names": str}
LEFT_OUT = ("unique", "labels")
"""Keys of a function that may be missing."""

KINDS = {str: "a text", list: "a list", bool: "true or false", dict: "an object", int: "an integer"}


class ProgramError(SymdynError):
    """A file of a program that cannot be read; says where, and what was found."""


@suggesting
def read_program(text: str, source: str = "graph.json") -> Program:
    """Return the program that the target "json" has written.

    Raises:
        ProgramError: what is wrong and where; SceneError for its scene.
        DerivationError: a constant is no finite real number.
    """
    return _Reader(source).program(text)


class _Reader:
    """Reads one file; a fault is raised with its place."""

    def __init__(self, source: str) -> None:
        self.source = source

    def program(self, text: str) -> Program:
        whole = self._object("file", self._loaded(text), dict.fromkeys(KEYS, object))
        if whole["format"] != FORMAT or type(whole["format"]) is not int:
            self._refuse("format", f"is {whole['format']!r:.40}; this version reads {FORMAT}")
        scene = read_text(self._of("scene", whole["scene"], str), f"{self.source}: scene")
        graph = Graph()
        nodes = self._nodes(graph, self._of("nodes", whole["nodes"], list))
        listed = self._of("functions", whole["functions"], list)
        functions = tuple(self._function(f"functions[{k}]", one, nodes) for k, one in enumerate(listed))
        if not functions:
            self._refuse("functions", "is empty; a program has one or more")
        for k, function in enumerate(functions):
            if function.name in [other.name for other in functions[:k]]:
                self._refuse(f"functions[{k}].name", f"{function.name} is the name of an earlier one")
        reported = whole["parameters"]
        there = {one.name: one for one in scene.parameters}
        names = next((a.symbols for function in functions for a in function.arguments if a.name == Program.PARAMS), ())
        right = [there[str(one.value)] for one in names if str(one.value) in there]
        wanted = [{"name": one.name, "unit": one.unit, "text": one.text} for one in right]
        if reported != wanted or len(right) != len(names):
            self._refuse("parameters", "are not those that params has in the scene, each with name, unit and text")
        return assemble(scene, graph, functions)

    def _loaded(self, text: str) -> Any:
        if len(text) > LONGEST:
            self._refuse("file", f"has more than {LONGEST} characters; no program of ours has as many")
        try:
            return json.loads(
                text, object_pairs_hook=self._pairs, parse_float=self._no_float, parse_constant=self._no_float
            )
        except json.JSONDecodeError as fault:
            self._refuse(f"line {fault.lineno}, column {fault.colno}", f"is no JSON: {fault.msg}")
        except RecursionError:
            self._refuse("file", "nests too deep")
        except SymdynError:
            raise
        except ValueError:
            self._refuse("file", "holds an integer of more digits than any number needs")

    def _pairs(self, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) != len(pairs):
            self._refuse("file", f"has an object with a key twice, among {', '.join(sorted(found))}"[:200])
        return found

    def _no_float(self, digits: str) -> NoReturn:
        self._refuse("file", f"holds the number {digits[:40]}; numbers are integers, or fractions in text")

    def _nodes(self, graph: Graph, listed: list[Any]) -> list[Expr]:
        operations = {op.name.lower(): op for op in Op if op is not Op.TABLE}
        nodes: list[Expr] = []
        for k, told in enumerate(listed):
            where = f"nodes[{k}]"
            name, *rest = self._of(where, told, list) or [None]
            if not isinstance(name, str) or name not in operations:
                self._refuse(where, f"is of no operation there is; give one of {', '.join(operations)}")
            op = operations[name]
            wanted = 1 if op in (Op.CONSTANT, Op.SYMBOL) else op.arity
            if len(rest) != wanted:
                self._refuse(where, f"{name} takes {wanted}, here are {len(rest)}")
            if op is Op.CONSTANT:
                nodes.append(
                    graph.constant(Fraction(self._matching(where, rest[0], NUMBER, "a fraction, such as -2/3")))
                )
            elif op is Op.SYMBOL:
                nodes.append(graph.symbol(self._matching(where, rest[0], SYMBOL_NAME, "a name")))
            else:
                args = [self._earlier(where, number, nodes) for number in rest]
                if op is Op.NEG and args[0].op in (Op.NEG, Op.CONSTANT):
                    self._refuse(where, "is the negative of a negative, or of a constant; write that itself")
                nodes.append(graph.node(op, *args))
        return nodes

    def _earlier(self, where: str, number: Any, nodes: list[Expr]) -> Expr:
        if type(number) is not int or not 0 <= number < len(nodes):
            self._refuse(where, f"refers to {number!r:.40}; there are nodes 0 to {len(nodes) - 1} before it")
        return nodes[number]

    def _function(self, where: str, reported: Any, nodes: list[Expr]) -> Function:
        """Return one function, all of whose symbols are arguments."""
        reported = self._object(where, reported, FUNCTION, LEFT_OUT)
        arguments = tuple(
            self._argument(f"{where}.arguments[{k}]", a, nodes) for k, a in enumerate(reported["arguments"])
        )
        symbols = [symbol for argument in arguments for symbol in argument.symbols]
        for what, values in (("argument", [a.name for a in arguments]), ("symbol", symbols)):
            if len({*values}) != len(values):
                self._refuse(f"{where}.arguments", f"have one {what} twice")
        if len(reported["shape"]) > MOST_DIMENSIONS:
            self._refuse(f"{where}.shape", f"has {len(reported['shape'])} lengths; {MOST_DIMENSIONS} at most are read")
        shape = tuple(self._size(f"{where}.shape", length) for length in reported["shape"])
        entries = tuple(self._earlier(f"{where}.entries", number, nodes) for number in reported["entries"])
        if prod(shape) != len(entries):
            self._refuse(f"{where}.entries", f"are {len(entries)}; shape {shape} has {prod(shape)}")
        strange = {node for node in reachable(entries) if node.op is Op.SYMBOL} - {*symbols}
        if strange:
            names = ", ".join(sorted(str(node.value) for node in strange))
            self._refuse(f"{where}.entries", f"need {names[:200]}, which are none of the arguments")
        unique = tuple(self._of(f"{where}.unique", one, bool) for one in reported.get("unique", []))
        labels = tuple(self._texts(f"{where}.labels", one) for one in reported.get("labels", []))
        if unique and len(unique) != len(entries):
            self._refuse(f"{where}.unique", f"has {len(unique)} entries, the result {len(entries)}")
        name, result = (
            self._matching(f"{where}.{k}", reported[k], NAME, "a name of ASCII") for k in ("name", "result")
        )
        return Function(
            name=name, text=str(reported["text"]), arguments=arguments, result=result, shape=shape, entries=entries,
            units=str(reported["units"]), formulation=str(reported["formulation"]), request=str(reported["request"]),
            unique=unique, labels=labels,
        )  # fmt: skip

    def _argument(self, where: str, reported: Any, nodes: list[Expr]) -> Argument:
        reported = self._object(where, reported, ARGUMENT)
        symbols = tuple(self._earlier(f"{where}.entries", number, nodes) for number in reported["entries"])
        if any(symbol.op is not Op.SYMBOL for symbol in symbols):
            self._refuse(f"{where}.entries", "holds what is no symbol")
        units = self._texts(f"{where}.units", reported["units"])
        if units and len(units) != len(symbols):
            self._refuse(f"{where}.units", f"are {len(units)}; there are {len(symbols)} entries")
        if reported["scalar"] and len(symbols) != 1:
            self._refuse(f"{where}.scalar", f"one number has one entry, here are {len(symbols)}")
        name = self._matching(f"{where}.name", reported["name"], NAME, "a name of ASCII")
        return Argument(name, symbols, reported["text"], units, reported["scalar"], reported["names"])

    # Values of one kind

    def _object(self, where: str, value: Any, kinds: dict[str, Any], left_out: tuple[str, ...] = ()) -> dict[str, Any]:
        """Return an object after a look at its keys and what they hold."""
        found: dict[str, Any] = self._of(where, value, dict)
        missing, strange = [key for key in kinds if key not in (*found, *left_out)], [*({*found} - {*kinds})]
        if missing or strange:
            told = f"lacks {', '.join(missing)}" if missing else f"has {', '.join(sorted(strange))[:200]}"
            self._refuse(where, f"{told}; it has {', '.join(kinds)}")
        for key, kind in kinds.items():
            if key in found and kind is not object:
                self._of(f"{where}.{key}", found[key], kind)
        return found

    def _of(self, where: str, value: Any, kind: type) -> Any:
        if type(value) is not kind:
            self._refuse(where, f"is not {KINDS[kind]}")
        return value

    def _size(self, where: str, value: Any) -> int:
        if type(value) is not int or not 0 <= value <= LONGEST:
            self._refuse(where, f"holds {value!r:.40}; lengths are integers from 0")
        return value

    def _texts(self, where: str, values: Any) -> tuple[str, ...]:
        return tuple(self._of(where, one, str) for one in self._of(where, values, list))

    def _matching(self, where: str, value: Any, pattern: re.Pattern[str], words: str) -> str:
        if not isinstance(value, str) or not pattern.match(value):
            self._refuse(where, f"holds {value!r:.60}; give {words}")
        return value

    def _refuse(self, where: str, what: str) -> NoReturn:
        place = "" if where == "file" else f"{where}: "
        raise ProgramError(f"{self.source}: {place}{what}") from None
