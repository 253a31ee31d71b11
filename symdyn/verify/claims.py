"""What is claimed about the equations of a scene: derivations against each other, laws, the program."""

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
from symdyn.program import Candidates, Program, choose
from symdyn.verdict import Unclaimed
from symdyn.verify.equality import Claim
from symdyn.verify.laws import laws
from symdyn.verify.program_claims import program_claims


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
            functions.append(Candidates(w, name).chosen(formulation))
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
