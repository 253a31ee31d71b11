"""C that `casadi.external` takes: our own, and around it the interface by which CasADi calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod

from symdyn.emit.code.source_text import FunctionText
from symdyn.emit.code.target import Draft
from symdyn.emit.render import render
from symdyn.emit.targets.c.c99 import HEADER_ONLY, C
from symdyn.emit.targets.casadi.jacobians import JacobianBlock


@dataclass(frozen=True)
class Array:
    """An argument or a result of CasADi: its name and shape."""

    name: str
    rows: int
    columns: int


@dataclass(frozen=True)
class Called:
    """One function that CasADi calls.

    Attributes:
        name: how the library shows it.
        inputs, outputs: what it takes and returns.
        body: lines of C.
        work: numbers that it needs beside.
    """

    name: str
    inputs: tuple[Array, ...]
    outputs: tuple[Array, ...]
    body: tuple[str, ...]
    work: int


def external_text(
    draft: Draft, jacobians: Mapping[str, Mapping[str, JacobianBlock]], results: Mapping[str, str]
) -> str:
    """Return the file; functions of which all derivatives are there have their Jacobian."""
    inner = C.draft(draft.program, draft.real, draft.page.command, HEADER_ONLY)
    (code,) = C.write(inner).values()
    assert isinstance(code, str), "a header is text"
    named = zip(draft.page.functions, inner.page.functions, strict=True)
    inside = {function.name: f"{inner.stem}_{other.name}" for function, other in named}
    functions, whole = [], []
    for function in draft.page.functions:
        functions.append(_plain(function, inside[function.name], results[function.name]))
        blocks = jacobians.get(function.name, {})
        if {*blocks} == {argument.name for argument in function.arguments if argument.length}:
            whole.append(function.name)
            functions.append(_jacobian(function, blocks, inside, draft.page.functions, functions[-1]))
    values = {
        "page": draft.page,
        "name": f"{draft.stem}_external",
        "whole": whole,
        "code": code.rstrip("\n"),
        "longest": max([1, *(argument.length for argument in draft.page.arguments)]),
        "copies": any(one.work for one in functions),
        "functions": functions,
    }
    return render("casadi/external.c.jinja", values)


def _given(function: FunctionText) -> str:
    """Return the arguments of a call of our C."""
    every = [f"arg[{k}] ? arg[{k}] : symdyn_zeros" for k in range(len(function.arguments))]
    return ", ".join(
        f"*({one})" if argument.scalar else one for one, argument in zip(every, function.arguments, strict=True)
    )


def _plain(function: FunctionText, inside: str, result: str) -> Called:
    """Return what computes a function; a matrix is turned, since CasADi's are column by column."""
    rows, columns = (function.shape[0] if function.shape else 1), prod(function.shape[1:])
    turned = rows > 1 and columns > 1
    body = [f"if (res[0]) {inside}({_given(function)}, {'w' if turned else 'res[0]'});"] if rows * columns else []
    if turned:
        body.append(f"if (res[0]) symdyn_turned(w, {rows}, {columns}, 0, {columns}, res[0]);")
    inputs = tuple(Array(argument.name, argument.length, 1) for argument in function.arguments)
    work = rows * columns if turned else 0
    return Called(function.name, inputs, (Array(result, rows, columns),), tuple(body), work)


def _jacobian(
    function: FunctionText,
    blocks: Mapping[str, JacobianBlock],
    inside: Mapping[str, str],
    every: tuple[FunctionText, ...],
    plain: Called,
) -> Called:
    """Return what computes the blocks of a Jacobian, each of our functions once."""
    lengths = {one.name: len(one.outputs) for one in every}
    (result,) = plain.outputs
    rows = result.rows * result.columns
    places = [argument.name for argument in function.arguments]
    body: list[str] = []
    for name in dict.fromkeys(block.function for block in blocks.values()):
        mine = [(places.index(argument), block) for argument, block in blocks.items() if block.function == name]
        wanted = " || ".join(f"res[{k}]" for k, _ in mine)
        body.append(f"if ({wanted}) {inside[name]}({_given(function)}, w);")
        width = lengths[name] // rows
        body += [
            f"if (res[{k}]) symdyn_turned(w, {rows}, {width}, {block.first}, {block.end - block.first}, res[{k}]);"
            for k, block in mine
        ]
    return Called(
        f"jac_{function.name}",
        (*plain.inputs, Array(f"out_{result.name}", result.rows, result.columns)),
        tuple(Array(f"jac_{result.name}_{a.name}", rows, a.length) for a in function.arguments),
        tuple(body),
        max(lengths[block.function] for block in blocks.values()),
    )
