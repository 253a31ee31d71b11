"""What is claimed about the equations of a scene: derivations against each other, laws, the program.

A program computes its equations, whichever way code goes over them. A law of mechanics is a claim about outputs of one
scene, or a check in numbers. Those of regressors and of momentum stand here, others in `laws.py`
and `laws_of_functions.py`.

Regressors times the declared parameters are what they are regressors of:

    τ = Y π + r, τ = Y_base β + r        r: driving forces where all of π is zero
    K, P = Y_E π + r                     energies
    τ_r = τ, Y_r = Y_base, C v = c       along the motion itself, where q̇_r = v = q̇ and q̈_r = q̈

The centre of mass C and momentum about it, A u = [p; L], where loops close a scene, too:

    dC/dt = J u
    p = m J u                            momentum is that of all mass at C
    g = -m Jᵀ g₀                         weight acts at C; g₀ is the acceleration of free fall
    d/dt (A u) = A u̇ + b
    ∂K/∂[v; ω] = Rᵀ [p; L + (C - r) × p] where all hangs on one free body at r, R: its share of M u is the momentum

Reference: Orin, Goswami and Lee, Centroidal dynamics of a humanoid robot, Autonomous Robots 35 (2013) 161.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

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
from symdyn.dynamics.outputs import BaseColumns, Linear
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, reachable, substitute, tangents
from symdyn.program import Program, RowLoop, choose, choose_one
from symdyn.scene import Quantity, Scene
from symdyn.spatial import add, cross, sub
from symdyn.verdict import Unclaimed
from symdyn.verify.equality import Claim, Finding

Outputs = tuple[str, ...]

Looked = tuple[list[Finding], list[Unclaimed]]
"""What was found in numbers, and where there is nothing to claim."""


@dataclass(frozen=True)
class About:
    """The outputs that a law is about."""

    trees: Outputs | None  # those of trees, "output_rate:" for any of that kind; None where it is no law of trees
    loops: Outputs | None  # those where loops or rows close the scene; None where it is no law of such

    def fits(self, scene: Scene, outputs: Collection[str]) -> bool:
        """Tell whether it is a law of scenes of this kind, and about nothing but these outputs."""
        needed = self.loops if scene.is_constrained else self.trees
        return needed is not None and {*needed} <= {*outputs, *(f"{one.partition(':')[0]}:" for one in outputs)}


@dataclass(frozen=True)
class Law(About):
    """A law that is proved; `claim` returns None where it says nothing about a scene."""

    claim: Callable[[Workspace], Claim | None]


@dataclass(frozen=True)
class Seen:
    """What is looked at in numbers: a scene's derivations, their outputs, and its program with its built modules."""

    workspace: Workspace
    outputs: Sequence[str]
    program: Program
    modules: Mapping[str, Any]
    seed: int


@dataclass(frozen=True)
class Look(About):
    """A law that is looked at in numbers, where proofs see nothing; `look` returns findings, and what is no claim."""

    doing: str
    look: Callable[[Seen], Looked]


def everywhere(claim: Callable[[Workspace], Claim | None], *outputs: str) -> Law:
    """Return a law about the same outputs of trees and of closed scenes."""
    return Law(outputs, outputs, claim)


def of_loops(claim: Callable[[Workspace], Claim | None], *outputs: str) -> Law:
    """Return a law of closed scenes alone."""
    return Law(None, outputs, claim)


def entries(w: Workspace, name: str) -> tuple[Expr, ...]:
    """Return the entries of an output, in the formulation that code is generated from."""
    return derive_one(w, name).entries


DRIVING, DRIVING_TREE = "inverse_dynamics", "tree_forces"


def product(w: Workspace, rows: Sequence[Expr], values: Sequence[Expr]) -> list[Expr]:
    """Return a matrix, entries row by row, times a vector."""
    count = len(values)
    return [
        w.graph.total(rows[i * count + k] * value for k, value in enumerate(values)) for i in range(len(rows) // count)
    ]


def driving(w: Workspace) -> tuple[Expr, ...]:
    """Return what drives of a tree must exert, those of the spanning tree where loops close."""
    return entries(w, DRIVING_TREE if w.scene.is_constrained else DRIVING)


def of_driving(claim: Callable[[Workspace], Claim | None], *outputs: str) -> Law:
    """Return a law about these forces and other outputs."""
    return Law((DRIVING, *outputs), (DRIVING_TREE, *outputs), claim)


def _of_forces(output: str, values: Callable[[Workspace], list[Expr]]) -> Law:
    def claim(w: Workspace) -> Claim | None:
        known = values(w)
        if not known:
            return None
        rest = Linear.of(w).remainder()
        rest = w.loops.drives_of(rest) if w.scene.is_constrained else rest
        sums = [a + b for a, b in zip(product(w, entries(w, output), known), rest, strict=True)]
        return Claim(output.replace("_", " "), "Y parameters + rest", "tau", tuple(sums), entries(w, DRIVING))

    return everywhere(claim, DRIVING, output)


def _energies(w: Workspace) -> Claim:
    products = product(w, entries(w, "energy_regressor"), Linear.of(w).parameters())
    sums = [a + b for a, b in zip(products, Linear.of(w).remainder(Workspace.energies_by_momentum), strict=True)]
    both = (*entries(w, "kinetic_energy"), *entries(w, "potential_energy"))
    return Claim("energy regressor", "Y pi + rest", "K, P", tuple(sums), both)


def _along_itself(w: Workspace, output: str) -> tuple[Expr, ...]:
    """Return an output where the reference is the motion itself."""
    found, references = derive_one(w, output), {"qd_r": w.state.qd, "qdd_r": w.state.qdd}
    given = [one for one in found.arguments if one.name in references]
    moved = {x: y for one in given for x, y in zip(one.symbols, references[one.name], strict=True)}
    return tuple(substitute(found.entries, moved))


def _passive(w: Workspace) -> Claim:
    return Claim("forces along a reference", "at qd_r = qd", "tau", _along_itself(w, "slotine_li_forces"), driving(w))


def _passive_columns(w: Workspace) -> Claim | None:
    if w.scene.is_constrained:  # one is of the drives, the other one of the spanning tree
        return None
    along, own = _along_itself(w, "slotine_li_regressor"), entries(w, "base_regressor")
    return Claim("regressor along a reference", "at qd_r = qd", "base regressor", along, own)


def _velocity_forces(w: Workspace) -> Claim:
    return Claim(
        "C times a velocity", "at qd_r = qd", "c", _along_itself(w, "coriolis_times"), entries(w, "velocity_forces")
    )


LAWS_OF_REGRESSORS: tuple[Law, ...] = (
    _of_forces("regressor", lambda w: Linear.of(w).parameters()),
    _of_forces("base_regressor", lambda w: BaseColumns.of(w).values()),
    everywhere(_energies, "kinetic_energy", "potential_energy", "energy_regressor"),
    of_driving(_passive, "slotine_li_forces"),
    everywhere(_passive_columns, "slotine_li_regressor", "base_regressor"),
    everywhere(_velocity_forces, "coriolis_times", "velocity_forces"),
)


def _momentum(w: Workspace) -> tuple[Expr, ...]:
    return tuple(product(w, entries(w, "centroidal_momentum_matrix"), w.state.qd))


def _velocity(w: Workspace) -> Claim:
    moved = tuple(product(w, entries(w, "centre_of_mass_jacobian"), w.state.qd))
    rates = tuple(tangents(entries(w, "centre_of_mass"), w.state.velocity))
    return Claim("centre of mass", "dC/dt", "J qd", rates, moved)


def _linear(w: Workspace) -> Claim:
    m = w.mass
    J = tuple(m * one for one in entries(w, "centre_of_mass_jacobian"))
    return Claim("momentum", "upper half of A", "m J", entries(w, "centroidal_momentum_matrix")[: len(J)], J)


def _weight(w: Workspace) -> Claim:
    J, n, m = entries(w, "centre_of_mass_jacobian"), w.state.n, w.mass
    pulled = tuple(-m * w.graph.total(J[i * n + k] * w.tree.gravity[i] for i in range(3)) for k in range(n))
    return Claim("weight", "g", "-m J^T g_0", entries(w, "gravity_forces"), pulled)


def _rate(w: Workspace) -> Claim:
    bias = entries(w, "centroidal_momentum_bias")
    rates = tuple(tangents(_momentum(w), w.state.acceleration))
    moved = product(w, entries(w, "centroidal_momentum_matrix"), w.state.qdd)
    sums = tuple(a + b for a, b in zip(moved, bias, strict=True))
    return Claim("rate of momentum", "d/dt (A qd)", "A qdd + b", rates, sums)


def _share_of_base(w: Workspace) -> Claim | None:
    base, tree = w.scene.joints[0], w.tree
    free = len(base.rates) == 6 and len(base.coordinates) == 7  # v and ω in the moved frame
    if not free or base.armature != Quantity.ZERO or tree.parent.count(0) > 1:
        return None
    carrier, here = tree.joint[base.name][1]
    T, C = tree.placements()[carrier] @ here, entries(w, "centre_of_mass")
    six = _momentum(w)
    p, L = (six[0], six[1], six[2]), (six[3], six[4], six[5])
    turning = add(L, cross(sub((C[0], C[1], C[2]), T.p), p))
    share = (*T.R.T @ p, *T.R.T @ turning)
    return Claim("momentum of a free base", "its part of p = M qd", "R^T [p; L]", entries(w, "momentum")[:6], share)


LAWS_OF_MOMENTUM: tuple[Law, ...] = (
    everywhere(_velocity, "centre_of_mass", "centre_of_mass_jacobian"),
    everywhere(_linear, "centre_of_mass_jacobian", "centroidal_momentum_matrix"),
    everywhere(_weight, "centre_of_mass_jacobian", "gravity_forces"),
    everywhere(_rate, "centroidal_momentum_matrix", "centroidal_momentum_bias"),
    everywhere(_share_of_base, "centroidal_momentum_matrix", "centre_of_mass", "momentum"),
)


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
    loops = ((one.function, rows) for one in program.routines if (rows := RowLoop.of(one.function)))
    return claims + [Claim(f.name, x.HOW, "program", tuple(x.composed(x.entries)), f.entries) for f, x in loops]


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


BY_FORMULATION: dict[str, Outputs] = {
    "hamilton": (
        "hamiltonian", "canonical_rates", "momentum", "kinetic_energy", "potential_energy", "forward_dynamics",
    ),
    "port-hamiltonian": ("hamiltonian", "canonical_rates"),
    "routh": ("routhian", "canonical_rates", "momentum"),
    "gibbs-appell": ("gibbs_function", "gravity_forces"),
    "udwadia-kalaba": ("constraint_forces", "forward_dynamics"),
}  # fmt: skip
"""Functions of formulations that are no derivation of another output, and what their laws are about."""


def taken(
    workspace: Workspace, outputs: Sequence[str] | None, formulation: str | None
) -> tuple[tuple[str, ...], tuple[Function, ...], list[str], list[Unclaimed]]:
    """Return outputs, those that become code, what is left out, and what does not exist: for None all worth certifying.

    These are what a scene has by default, kinematics of the last body, and what no one writes by default; of a
    formulation with functions of its own, these, with what their laws are about.
    """
    if formulation in BY_FORMULATION:
        driving = (DRIVING_TREE if workspace.scene.is_constrained else DRIVING,) * (formulation == "gibbs-appell")
        outputs, formulation = (*BY_FORMULATION[formulation], *driving, *(outputs or ())), None
    if outputs is not None:
        outputs = tuple(dict.fromkeys(request_of(name, workspace.scene) for name in outputs))
        known_formulation(workspace.scene, outputs, formulation, BY_FORMULATION)
        return outputs, choose(workspace, outputs, formulation), [], []
    wanted = Requested.of(workspace, "verify")
    known_formulation(workspace.scene, wanted.outputs, formulation, BY_FORMULATION)
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
    workspace: Workspace, outputs: Sequence[str], preferred: Sequence[Function], program: Program, laws: Sequence[Claim]
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
    return [*agreements, *laws, *program_claims(scene, preferred, program)], absent


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
