"""Functions in a notebook: what each takes and returns, and what it costs."""

from __future__ import annotations

from symdyn.dynamics import Equations, Function
from symdyn.notebook.page import Markup, head, note, table
from symdyn.program import Program
from symdyn.runtime import Loaded, NumericFunction


def derived(equations: Equations) -> list[Markup]:
    """Return the functions that were derived, and by which formulation."""
    rows = [(_call(one), _shape(one.shape), one.units, one.formulation, one.text) for one in equations.functions]
    return [
        head(equations.scene.name, "functions on one expression graph"),
        table(("function", "shape", "unit", "derived by", ""), rows),
    ]


def program(result: Program) -> list[Markup]:
    """Return the routines, and how many operations each takes."""
    rows = [
        (_call(one.function), _shape(one.function.shape), one.counts.cost, len(one.steps), one.function.text)
        for one in result.routines
    ]
    return [
        head(result.scene.name, "straight-line program"),
        table(("routine", "shape", "operations, weighted", "lines", ""), rows),
    ]


def loaded(result: Loaded) -> list[Markup]:
    """Return how every function is called."""
    kind = (
        f"compiled functions for {result.backend}"
        if result.compiled
        else "functions of the NumPy module: there was no compiler"
    )
    return [
        head(result.scene.name, kind),
        table(("function", "lengths"), (text.split(": ", 1) for text in result.signatures.values())),
        note("leading dimensions broadcast; parameters and inputs may be given by name"),
    ]


def numeric(function: NumericFunction) -> list[Markup]:
    """Return how a function is called, and the entries of its arguments, which may be given by name."""
    rows = [
        (one.name, "number" if one.scalar else len(one.entries), ", ".join(one.entries)) for one in function.operands
    ]
    return [
        head(function.name, function.description.partition(": ")[2]),
        table(("argument", "length", "entries"), rows),
        table(("fixed", "value"), function.fixed.items()),
        note("leading dimensions broadcast; parameters and inputs may be given by name"),
    ]


def _call(one: Function) -> str:
    return f"{one.name}({', '.join(argument.name for argument in one.arguments)})"


def _shape(shape: tuple[int, ...]) -> str:
    return " × ".join(map(str, shape)) if shape else "number"
