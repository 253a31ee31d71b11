"""Claims about programs: each computes its equations, whichever way code goes over them."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics import Function, row_of
from symdyn.graph import Expr, reachable, substitute
from symdyn.program import Program, RowLoop
from symdyn.scene import Scene
from symdyn.verify.equality import Claim


def program_claims(scene: Scene, functions: Sequence[Function], program: Program) -> list[Claim]:
    """Return that each routine of the program computes its function, parameters with values bound."""
    values = {p.name: p.value for p in scene.parameters if p.value is not None}
    entries = [entry for function in functions for entry in function.entries]
    bound: dict[Expr, Expr] = {
        node: value.express(node.graph)
        for node in reachable(entries)
        if isinstance(node.value, str) and (value := values.get(node.value)) is not None
    }
    claims = [
        Claim(
            routine.function.name,
            "program",
            "equations",
            routine.function.entries,
            tuple(substitute(function.entries, bound)),
        )
        for function, routine in zip(functions, program.routines, strict=True)
    ]
    return claims + [_row_claim(one.function, rows) for one in program.routines if (rows := RowLoop.of(one.function))]


def _row_claim(function: Function, rows: RowLoop) -> Claim:
    """Return that a loop over rows, after the lines before it, computes the entries of a function."""
    return Claim(function.name, "solved in rows", "program", tuple(rows.composed(rows.entries)), function.entries)


def loop_claim(function: Function) -> Claim:
    """Return that a loop over the table of a function computes its entries."""
    assert function.loop is not None, "there is a table"
    (compute,) = (
        formulation.loop for formulation in row_of(function.request)[0].formulations.values() if formulation.loop
    )
    found = compute(function.loop.table, *(argument.symbols for argument in function.arguments))
    return Claim(function.name, "loop over a table", function.formulation, tuple(found), function.entries)


def composed_claims(program: Program, prepared: Program) -> list[Claim]:
    """Return that each routine of a prepared program, after `prepare`, is the routine of the program."""
    if not prepared.is_prepared:
        return []
    first, *rest = prepared.routines
    claims = []
    for after, before in zip(rest, program.routines, strict=True):
        values = dict(zip(after.function.arguments[-1].symbols, first.function.entries, strict=True))
        composed = tuple(substitute(after.function.entries, values))
        claims.append(
            Claim(after.function.name, f"after {Program.PREPARE}", "program", composed, before.function.entries)
        )
    return claims
