"""What is claimed about the equations of a scene: derivations against each other, laws, the program.

A program computes its equations, whichever way code goes over them.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics import (
    Function,
    Requested,
    Workspace,
    derive_one,
    formulations_lacking,
    formulations_of,
    known_formulation,
    request_of,
    row_of,
)
from symdyn.errors import DerivationError
from symdyn.graph import Expr, reachable, substitute
from symdyn.program import Program, RowLoop, choose, choose_one
from symdyn.scene import Scene
from symdyn.verdict import Unclaimed
from symdyn.verify.equality import Claim
from symdyn.verify.laws import laws


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


def taken(
    workspace: Workspace, outputs: Sequence[str] | None, formulation: str | None
) -> tuple[tuple[str, ...], tuple[Function, ...], list[str], list[Unclaimed]]:
    """Return outputs, those that become code, what is left out, and what does not exist: for None all worth certifying.

    These are what a scene has by default, kinematics of the last body, and what no one writes by default.
    """
    if outputs is not None:
        outputs = tuple(dict.fromkeys(request_of(name, workspace.scene) for name in outputs))
        return outputs, choose(workspace, outputs, formulation), [], []
    wanted = Requested.of(workspace, "verify")
    known_formulation(workspace.scene, wanted.outputs, formulation)
    functions: list[Function] = []
    why: dict[str, str] = {}

    def derive(w: Workspace, name: str) -> None:
        try:
            functions.append(choose_one(w, name, formulation))
        except DerivationError as fault:
            why[name] = str(fault)
            raise

    found, faults = wanted.there(derive)
    names = {fault: ", ".join(name for name, one in why.items() if one == fault) for fault in faults}
    return found, tuple(functions), list(wanted.left_out), [Unclaimed(names[fault], fault) for fault in faults]


def claims_of(
    workspace: Workspace, outputs: Sequence[str], preferred: Sequence[Function], program: Program
) -> tuple[list[Claim], list[Unclaimed]]:
    """Return that all formulations agree, that laws hold, and that the program is what the preferred ones gave.

    Beside them stand the derivations that the scene has not.
    """
    scene, agreements = workspace.scene, list[Claim]()
    lacking: dict[str, list[str]] = {}  # formulations by the reason
    for name, one in zip(outputs, preferred, strict=True):
        for formulation, why in formulations_lacking(name, scene).items():
            lacking.setdefault(why, []).append(f"{formulation} of {name}")
        for formulation in formulations_of(name, scene):
            if formulation == one.formulation:
                continue
            try:
                other = derive_one(workspace, name, formulation)
            except DerivationError as fault:
                lacking.setdefault(str(fault), []).append(f"{formulation} of {name}")
            else:
                agreements.append(_agreement(workspace, name, one, other))
    absent = [Unclaimed(f"formulation {', '.join(formulations)}", why) for why, formulations in lacking.items()]
    return [*agreements, *laws(workspace, outputs), *program_claims(scene, preferred, program)], absent


def compared(claims: Sequence[Claim], functions: Sequence[Function]) -> tuple[list[Claim], list[Unclaimed]]:
    """Return the claims that are to be compared, and what has no entries, such as k_C of one coordinate.

    A claim about such has none either. Where all functions have some, one without is looked at, and not shown.
    """
    empty = [Unclaimed(function.name, "it has no entries") for function in functions if not function.entries]
    return [claim for claim in claims if claim.left or not empty], empty


def _agreement(w: Workspace, request: str, one: Function, other: Function) -> Claim:
    """Return that two derivations agree, in what is no choice."""
    compared = row_of(request, w.scene)[0].compared
    name, of = compared or (request, lambda _, entries: entries)
    return Claim(name, one.formulation, other.formulation, tuple(of(w, one.entries)), tuple(of(w, other.entries)))
