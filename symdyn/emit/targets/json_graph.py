"""The JSON target: the graph of a program itself, for whoever wants to write one more target, or to keep it.

    <scene>.json    docs/json.md says what it holds; `read_program` reads it back

Numbers are exact: fractions in text, π by its name; there is no float in the file. The text is ASCII.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from symdyn.dynamics import Argument, Function
from symdyn.emit.code.real import REALS
from symdyn.emit.code.target import Draft, Target, alone
from symdyn.emit.targets.javascript import JS
from symdyn.graph import Expr, Op, reachable
from symdyn.scene import write_text

FORMAT = 1
"""Of the file: a reader of another one refuses it."""


def _write(draft: Draft) -> dict[str, str]:
    """Return the graph."""
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
    """Return a list with a line for each value."""
    lines = ",\n".join(map(_text, values))
    return f"[\n{lines}\n]" if lines else "[]"


JSON = Target(
    name="json",
    title="JSON",
    text="the graph itself in JSON, exact, which symdyn reads back",
    reals=("double",),
    options={},
    files={"{stem}.json": str},
    first=0,
    keywords=frozenset(),
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: JS.printer(REALS["double"]),
    comment=lambda text: text,
    write=_write,
    beside=alone,
    shortens=(),
    loops=False,
)
