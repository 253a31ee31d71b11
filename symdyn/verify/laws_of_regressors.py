"""Laws of regressors: times the parameters as declared they are what they are regressors of.

τ = Y π + r, τ = Y_base β + r        r: driving forces where all of π is zero
K, P = Y_E π + r                     energies
τ_r = τ, Y_r = Y_base, C v = c       along the motion itself, where q̇_r = v = q̇ and q̈_r = q̈
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.outputs import BaseColumns, Linear
from symdyn.graph import Expr, substitute
from symdyn.verify.equality import Claim
from symdyn.verify.law import Law, entries, everywhere

DRIVING, DRIVING_TREE = "inverse_dynamics", "tree_forces"


def _product(w: Workspace, rows: Sequence[Expr], values: Sequence[Expr]) -> list[Expr]:
    count = len(values)
    return [
        w.graph.total(rows[i * count + k] * value for k, value in enumerate(values)) for i in range(len(rows) // count)
    ]


def _driving(w: Workspace) -> tuple[Expr, ...]:
    return entries(w, DRIVING_TREE if w.scene.is_closed else DRIVING)


def _of_forces(output: str, values: Callable[[Workspace], list[Expr]]) -> Law:
    def claim(w: Workspace) -> Claim | None:
        known = values(w)
        if not known:
            return None
        rest = Linear.of(w).remainder()
        rest = w.loops.drives_of(rest) if w.scene.is_closed else rest
        sums = [a + b for a, b in zip(_product(w, entries(w, output), known), rest, strict=True)]
        return Claim(output.replace("_", " "), "Y parameters + rest", "tau", tuple(sums), entries(w, DRIVING))

    return everywhere(claim, DRIVING, output)


def _energies(w: Workspace) -> Claim:
    products = _product(w, entries(w, "energy_regressor"), Linear.of(w).parameters())
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
    return Claim("forces along a reference", "at qd_r = qd", "tau", _along_itself(w, "slotine_li_forces"), _driving(w))


def _passive_columns(w: Workspace) -> Claim | None:
    if w.scene.is_closed:  # one is of the drives, the other one of the spanning tree
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
    Law((DRIVING, "slotine_li_forces"), (DRIVING_TREE, "slotine_li_forces"), _passive),
    everywhere(_passive_columns, "slotine_li_regressor", "base_regressor"),
    everywhere(_velocity_forces, "coriolis_times", "velocity_forces"),
)
