"""The outputs of closed scenes, rows of OUTPUTS that only they have and what others say there; and reactions.

Reactions, of trees too, are rows that a scene has when it is asked for them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from symdyn.dynamics.loops.constraint_rows import Constraints
from symdyn.dynamics.loops.loop_workspace import LoopWorkspace
from symdyn.dynamics.loops.partition import solve_normal
from symdyn.dynamics.loops.reduction import accelerations
from symdyn.dynamics.mechanism.linear_solve import moves_no_mass
from symdyn.dynamics.outputs import result_labels as labels, tree_formulations as formulations
from symdyn.dynamics.outputs.output import FORCES, Constrained, Formulation, Output, by_differentiation, by_lagrange
from symdyn.dynamics.outputs.tree_formulations import flat
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, substitute

# Forward dynamics


def forward(w: Workspace) -> list[Expr]:
    """Return u̇ by recursion."""
    _massive(w)
    if w.loops.decisions.fails:
        return w.loops.all_constraints_solution[0]
    reduced = w.loops.motion
    rest = [tau - force for tau, force in zip(w.state.tau, w.forces(list(reduced.s)), strict=True)]
    return accelerations(reduced, w.composite_mass, rest)


def _massive(w: Workspace) -> None:
    """Raise DerivationError where a motion that the loops leave free moves no mass: it names the joint and the body."""
    import numpy as np

    from symdyn.algebra import Floats

    reduced = w.loops.motion
    if not reduced.independent:
        return
    size = len(reduced.independent)
    known = w.loops.values(w.loops.decisions.assembly.regular) | w.scene.at_time(w.graph)
    entries = evaluate(flat(reduced.mass(w.composite_mass)), Floats(), known)
    mass = np.array(entries).reshape(size, size)
    values, vectors = np.linalg.eigh(mass)
    if values[0] > 1e-13 * max(1e-300, abs(values[-1])):
        return
    velocity = reduced.independent[int(np.abs(vectors[:, 0]).argmax())]
    raise DerivationError(moves_no_mass(w.scene, velocity, " of what the loops leave free"))


def multipliers(w: Workspace) -> list[Expr]:
    """Return λ of the independent rows by recursion."""
    if w.loops.decisions.fails:
        return w.loops.all_constraints_solution[1][: len(w.loops.decisions.independent_rows)]
    found = w.forces(w.once(forward))
    excess = [force - tau for force, tau in zip(found, w.state.tau, strict=True)]
    return w.loops.decisions.partition.solve_transposed(w.loops.G(w.loops.recursive), excess)


def lagrange_forward(w: Workspace) -> list[Expr]:
    """Return u̇ by Lagrange's equations."""
    return w.loops.lagrange_solution[0]


def lagrange_multipliers(w: Workspace) -> list[Expr]:
    """Return λ of the independent rows by Lagrange's equations."""
    return w.loops.lagrange_solution[1][: len(w.loops.decisions.independent_rows)]


def drives(w: Workspace) -> list[Expr]:
    """Return the driving forces, those of prescribed motions solved for."""
    place, tau = w.prescribed.place, list(w.state.tau)
    if not place:
        return tau
    forces, found = w.forces(w.once(forward)), w.once(multipliers)
    pairs = list(zip(w.loops.G(w.loops.recursive), found, strict=True))
    for k in place:
        tau[k] = forces[k] - w.graph.total(row[k] * x for row, x in pairs)
    return tau


def lagrange_drives(w: Workspace) -> list[Expr]:
    """Return them by Lagrange's equations."""
    tau = list(w.state.tau)
    if w.prescribed.place:
        extra = w.loops.lagrange_solution[1][len(w.loops.decisions.independent_rows) :]
        for k, more in zip(w.prescribed.place, extra, strict=True):
            tau[k] = tau[k] + more
    return tau


def udwadia_kalaba(w: Workspace) -> list[Expr]:
    """Return Gᵀ (G M⁻¹ Gᵀ)⁺ (-γ - G M⁻¹ (τ - h)) by Lagrange's equations, which independent rows have by an inverse.

    Where M is singular, M + Gᵀ G stands in its place.

    Reference: Udwadia and Kalaba, A new perspective on constrained motion, Proc. R. Soc. Lond. A 439 (1992) 407;
    Udwadia and Phohomsiri, Explicit equations of motion for constrained mechanical systems (2006).
    """
    return w.loops.constraint_forces(w.once(lagrange_multipliers), w.loops.differentiated)


# Inverse dynamics: forces of the spanning tree, less constraint forces


def inverse(w: Workspace) -> list[Expr]:
    """Return driving forces by recursion: of the tree, less constraint forces."""
    multipliers = w.once(inverse_multipliers)
    return w.loops.at_drives(w.forces(list(w.state.qdd)), w.loops.G(w.loops.recursive), multipliers)


def inverse_multipliers(w: Workspace) -> list[Expr]:
    """Return λ of the independent rows for a motion that the loops allow."""
    partition, G = w.loops.actuated, w.loops.G(w.loops.recursive)
    return partition.solve_transposed(G, w.forces(list(w.state.qdd)))


def lagrange_inverse(w: Workspace) -> list[Expr]:
    """Return them by Lagrange's equations."""
    return lagrange_drives_of(w, w.loops.lagrange_forces)


def lagrange_drives_of(w: Workspace, forces: list[Expr]) -> list[Expr]:
    """Return the same by the rows of differentiated positions."""
    partition, G = w.loops.actuated, w.loops.G(w.loops.differentiated)
    transposed = [[row[k] for row in G] for k in partition.dependent]
    found = solve_normal(transposed, [forces[k] for k in partition.dependent]) if G else []
    return w.loops.at_drives(forces, G, found)


# Velocities


def velocities(w: Workspace) -> list[Expr]:
    """Return u = T u_i."""
    T = w.loops.reduction.T
    return [w.graph.total(t * w.state.qd[i] for i, t in row.items()) for row in T]


def normal_velocities(w: Workspace) -> list[Expr]:
    """Return the same by normal equations."""
    partition, G, u = w.loops.decisions.partition, w.loops.G(w.loops.differentiated), w.state.qd
    result = [u[k] if k in partition.independent else w.graph.zero for k in range(w.state.n)]
    given = [-w.graph.total(row[k] * u[k] for k in partition.independent) for row in G]
    for k, value in partition.solve_normal(G, given).items():
        result[k] = value
    return result


def _positions(w: Workspace) -> list[Expr]:
    from symdyn.dynamics.loops.closed_positions import positions  # with NumPy, which trees can do without

    return positions(w)


CONSTRAINED_FORWARD = Constrained(
    {"crba": Formulation(forward), "lagrange": by_lagrange(lagrange_forward)},
    "accelerations qdd of the closed mechanism: M(q) qdd + h = tau + G^T lambda, G qdd + Gdot qd = 0",
    ("mass_matrix", "tree_forces", "constraint_jacobian", "constraint_bias"),
)
CONSTRAINED_INVERSE = Constrained(
    {
        "rnea": Formulation(inverse),
        "lagrange": by_lagrange(lagrange_inverse),
        "kane": by_lagrange(lambda w: lagrange_drives_of(w, w.kane.driving_forces())),
    },
    "driving forces tau of the closed mechanism for a motion that its loops allow; {undriven}",
)
CONSTRAINED_DRIVES = Constrained({"crba": Formulation(drives), "lagrange": by_lagrange(lagrange_drives)})

_of_loops = partial(Output, when_constrained="only")


def _both(of: Callable[[LoopWorkspace, Constraints], Sequence[Expr]]) -> dict[str, Formulation]:
    """Return the two formulations of what follows from the rows."""
    return {
        "recursive": Formulation(lambda w: of(w.loops, w.loops.recursive)),
        "differentiation": by_differentiation(lambda w: of(w.loops, w.loops.differentiated)),
    }


OF_LOOPS: dict[str, Output] = {
    "constraint_residual": _of_loops(
        "residuals of the loops, which vanish where they are closed",
        ("q",),
        "r",
        (labels.kept_rows,),
        "m or 1",
        formulations=_both(LoopWorkspace.residual),
        may_fail="reported",
    ),
    "constraint_jacobian": _of_loops(
        "rows G(q) of the loops: G qd = 0, and the multipliers do the power lambda.G qd",
        ("q",),
        "G",
        (labels.kept_rows, labels.velocities),
        "m or 1",
        formulations=_both(lambda loops, rows: flat(loops.G(rows))),
        may_fail="reported",
    ),
    "constraint_bias": _of_loops(
        "velocity products Gdot qd of the loops: G qdd + Gdot qd = 0",
        ("q", "qd"),
        "gamma",
        (labels.kept_rows,),
        "m/s^2 or 1/s^2",
        formulations=_both(LoopWorkspace.bias),
        may_fail="reported",
    ),
    "multipliers": _of_loops(
        "multipliers lambda of M qdd + h = tau + G^T lambda: wrenches that parents exert on children at the cuts, at "
        "the origin of the moved joint frame, axes of the joint frame on the parent; of contacts along, across, normal",
        ("q", "qd", "tau"),
        "lambda",
        (labels.kept_rows,),
        "N or N m",
        formulations={"crba": Formulation(multipliers), "lagrange": by_lagrange(lagrange_multipliers)},
        depends=("independent", "alpha", "beta"),
        compared=("G^T multipliers", lambda w, found: w.loops.constraint_forces(found)),
        may_fail="reported",
    ),
    "constraint_forces": _of_loops(
        "forces G^T lambda that loops and rows exert on the velocities during forward dynamics",
        ("q", "qd", "tau"),
        "f",
        (labels.velocities,),
        FORCES,
        formulations={
            "crba": Formulation(lambda w: w.loops.constraint_forces(w.once(multipliers))),
            "udwadia-kalaba": by_lagrange(udwadia_kalaba),
        },
        depends=("independent", "alpha", "beta"),
        default_in="request",
        may_fail="reported",
    ),
    "tree_forces": _of_loops(
        "forces M(q) qdd + c(q, qd) + g(q) - Q of the spanning tree, as if nothing closed it",
        ("q", "qd", "qdd"),
        "f",
        (labels.velocities,),
        FORCES,
        formulations={
            "rnea": Formulation(lambda w: w.forces(list(w.state.qdd))),
            "lagrange": by_lagrange(lambda w: w.loops.lagrange_forces),
            "kane": by_lagrange(lambda w: w.kane.driving_forces()),
        },
    ),
    "velocities": _of_loops(
        "velocities qd that the loops allow, from independent ones",
        ("q", "ui"),
        "qd",
        (labels.velocities,),
        "rad/s or m/s",
        formulations={"partition": Formulation(velocities), "normal": Formulation(normal_velocities)},
        depends=("independent",),
        may_fail="reported",
    ),
    "positions": _of_loops(
        "positions q at which the loop is closed, from the independent one, on the branch of the start",
        ("qi",),
        "q",
        (labels.coordinates,),
        "rad or m",
        formulations={"closed form": Formulation(_positions)},
        depends=("independent",),
        may_fail="silently",
    ),
}
"""Rows of the table that only closed scenes have."""


WORDS = {
    "body": "the child's body frame",
    "joint": "the joint frame on the parent",
    "ground": "the ground frame",
}


def _inverse(w: Workspace, axes: str) -> list[Expr]:
    """Return reactions of a motion that is given."""
    from symdyn.dynamics.reactions.free_bodies import reactions  # with NumPy, which printing can do without

    return reactions(w.hanging, axes)


Solved = Callable[[Workspace], list[Expr]]


def forward_reactions(
    w: Workspace, axes: str, moved: tuple[Solved, Solved, Solved] = (formulations.forward, forward, multipliers)
) -> list[Expr]:
    """Return reactions during the motion that driving forces give, with the multipliers of that motion.

    `moved` derive accelerations of trees, those of closed scenes, and multipliers.
    """
    from symdyn.dynamics.reactions.free_bodies import reactions

    accelerations = w.once(moved[w.scene.is_constrained])
    multipliers = w.once(moved[2]) if w.hanging.cuts else ()
    return substitute(reactions(w.hanging, axes, multipliers), dict(zip(w.state.qdd, accelerations, strict=True)))


def unique(w: Workspace, axes: str) -> tuple[bool, ...]:
    """Return which entries rigid bodies determine, () for all."""
    if not w.scene.is_constrained:
        return ()
    from symdyn.dynamics.outputs.unique_reactions import unique_entries

    return unique_entries(w, axes)


def _rows(axes: str) -> dict[str, Output]:
    suffix = "" if axes == "body" else f":{axes}"
    text = (
        "reactions [force; moment] that parents exert on children, a row a joint and then a loop, drives included, at "
        f"the origin of the moved joint frame, axes of {WORDS[axes]}"
    )
    usual = partial(
        Output,
        result="R",
        axes=(labels.joints, labels.fixed(*labels.COMPONENTS)),
        units="N and N m",
        when_constrained="same",
        may_fail="reported",
        unique=lambda w: w.once(unique, axes),
    )
    return {
        f"reactions{suffix}": usual(
            text,
            ("q", "qd", "qdd"),
            formulations={"recursive": Formulation(lambda w: _inverse(w, axes))},
            default_in="request" if suffix else "verify",
        ),
        f"forward_reactions{suffix}": usual(
            f"{text}, during forward dynamics",
            ("q", "qd", "tau"),
            formulations={"recursive": Formulation(lambda w: forward_reactions(w, axes))},
            default_in="request",
            depends=("independent", "alpha", "beta"),
        ),
    }


REACTIONS: dict[str, Output] = {name: row for axes in WORDS for name, row in _rows(axes).items()}
"""Rows of the table; they cost nothing where none is asked for."""
