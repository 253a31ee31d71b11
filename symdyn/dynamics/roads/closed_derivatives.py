"""Derivatives of closed scenes along the manifold of their states: rows that they have in place of what operators make.

    ξ, v     independent positions, of the rows that hold positions; independent velocities, of all rows
    J        [∂f/∂ξ | ∂f/∂v | ∂f/∂τ], dependent positions and velocities (and accelerations) moving along
    R        M u̇ + h - Gᵀ λ - τ, and C = G u̇ + γ, which vanish

With rolling there are more ξ than v. The same independent velocities serve all outputs; of inverse dynamics, which may
solve for other ones, too. The road "implicit" differentiates R and C at fixed u̇ and λ and solves what forward dynamics
solves once more:

    M δu̇ - Gᵀ δλ = -δR,    G δu̇ = -δC

and needs one tangent of unsolved equations a column. The other roads differentiate what is solved, each its own.

Reference: Carpentier, Budhiraja and Mansard, Proximal and sparse resolution of constrained dynamic equations (2021),
section IV, for the derivatives of what is solved by those of what is not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from symdyn.dynamics.loops.manifold import Manifold, Seeds
from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.roads import closed_outputs as closed
from symdyn.dynamics.roads import result_labels as labels
from symdyn.dynamics.roads.derivative_outputs import COLUMNS
from symdyn.dynamics.roads.kinks import kinks
from symdyn.dynamics.roads.output import FORCES, Output, Road, Unasked, by_lagrange
from symdyn.dynamics.roads.result_labels import Axis
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.graph import Expr, substitute, tangents
from symdyn.scene import acceleration_name

Columns = list[list[Expr]]

# What the columns stand for


def independent_positions(w: Workspace) -> tuple[str, ...]:
    """Return a label for each independent position; those of independent velocities come first."""
    return tuple(COLUMNS["q"](w)[k] for k in w.loops.held_positions[1].independent)


def independent_velocities(w: Workspace) -> tuple[str, ...]:
    """Return a label for each independent velocity."""
    return tuple(w.scene.velocities[k] for k in w.loops.decisions.partition.independent)


def _independent_accelerations(w: Workspace) -> tuple[str, ...]:
    return tuple(map(acceleration_name, independent_velocities(w)))


def _behind(*axes: Axis) -> Axis:
    return lambda w: tuple(label for axis in axes for label in axis(w))


# Roads


def manifold_of(w: Workspace, road: str) -> Manifold:
    """Return the manifold by the road that derivatives of a name take."""
    return w.loops.differentiated_manifold if road == "lagrange" else w.loops.recursive_manifold


def _by_row(columns: Columns, rows: int) -> list[Expr]:
    return [column[i] for i in range(rows) for column in columns]


def _differentiated(entries: Sequence[Expr], seeds: Sequence[Seeds]) -> list[Expr]:
    return _by_row([tangents(entries, one) for one in seeds], len(entries))


def _moving(manifold: Manifold) -> list[Seeds]:
    return [*manifold.by_position, *manifold.by_velocity, *manifold.by_force]


def implicit(w: Workspace) -> list[tuple[list[Expr], list[Expr]]]:
    """Return δu̇ and δλ of every column, by differentiating the equations of motion before they are solved."""
    loops, graph, state = w.loops, w.graph, w.state
    G, manifold = loops.G(loops.recursive), loops.recursive_manifold
    names = [graph.symbol(f"lambda[{i}]") for i in range(len(G))]
    motion = [f - x for f, x in zip(w.forces(list(state.qdd)), loops.constraint_forces(names), strict=True)]
    closing = [
        graph.total([*(x * a for x, a in zip(row, state.qdd, strict=True)), rest])
        for row, rest in zip(G, loops.gamma(loops.recursive), strict=True)
    ]
    known = dict(zip(state.qdd, w.once(closed.forward), strict=True)) | dict(
        zip(names, w.once(closed.multipliers), strict=True)
    )
    sides = [tangents([*motion, *closing], one) for one in (*manifold.by_position, *manifold.by_velocity)]
    sides = [substitute(one, known) for one in sides]
    none = [graph.zero] * len(G)
    pushes = [[graph.one if i == k else graph.zero for i in range(state.n)] for k in range(state.n)]
    return [
        *(loops.solved([-x for x in one[: state.n]], one[state.n :]) for one in sides),
        *(loops.solved(push, none) for push in pushes),
    ]


def _implicit_forward(w: Workspace) -> list[Expr]:
    return _by_row([x for x, _ in w.once(implicit)], w.state.n)


def _implicit_multipliers(w: Workspace) -> list[Expr]:
    return _by_row([x for _, x in w.once(implicit)], len(w.loops.decisions.kept))


def _tangent_forward(w: Workspace) -> list[Expr]:
    return _differentiated(w.once(closed.forward), _moving(w.loops.recursive_manifold))


def _tangent_multipliers(w: Workspace) -> list[Expr]:
    return _differentiated(w.once(closed.multipliers), _moving(w.loops.recursive_manifold))


def _lagrange_forward(w: Workspace) -> list[Expr]:
    return _differentiated(w.loops.lagrange_solution[0], _moving(w.loops.differentiated_manifold))


def _lagrange_multipliers(w: Workspace) -> list[Expr]:
    found = w.loops.lagrange_solution[1][: len(w.loops.decisions.kept)]
    return _differentiated(found, _moving(w.loops.differentiated_manifold))


COUNTED = 8
"""Velocities up to which both roads are counted; beyond, what differentiates unsolved equations is cheaper."""


def cheaper(one: Callable[[Workspace], list[Expr]], other: Callable[[Workspace], list[Expr]], w: Workspace) -> str:
    """Return "implicit" or "forward", whichever costs less."""
    if w.state.n > COUNTED:
        return "implicit"
    varying = (*w.state.q, *w.state.qd, *w.state.tau)
    return "implicit" if cost(w.once(one), varying) <= cost(w.once(other), varying) else "forward"


def _driving(manifold: Manifold) -> list[Seeds]:
    moving = [manifold.accelerating(one) for one in (*manifold.by_position, *manifold.by_velocity)]
    return [*moving, *manifold.by_acceleration]


def _velocities(w: Workspace) -> list[Expr]:
    """Return S and T, in terms of the independent velocities."""
    manifold = w.loops.recursive_manifold
    known = dict(zip(w.state.qd, w.once(closed.velocities), strict=True))
    seeds = [*manifold.by_position, *manifold.by_velocity]
    columns = [substitute([one.get(u, w.graph.zero) for u in w.state.qd], known) for one in seeds]
    return _by_row(columns, w.state.n)


def _normal_velocities(w: Workspace) -> list[Expr]:
    manifold, u = w.loops.differentiated_manifold, w.state.qd
    free = [{u[k]: w.graph.one} for k in manifold.partition.independent]
    return _differentiated(w.once(closed.normal_velocities), [*manifold.by_position, *free])


def _positions(manifold: Manifold) -> list[Expr]:
    zero = manifold.state.q[0].graph.zero
    return _by_row(
        [[column.get(k, zero) for k in range(manifold.state.n)] for column in manifold.slopes], manifold.state.n
    )


def _kinks(of: Callable[[Workspace], Sequence[Expr]]) -> Callable[[Workspace], str]:
    return lambda w: kinks(w.once(of), (*w.state.q, *w.state.qd))


_row = partial(Output, in_loops="same", loops_only=True, unasked=Unasked.NEVER, lacks="told")
_OF_MOTION = _behind(independent_positions, independent_velocities, COLUMNS["tau"])
_ALONG = "along the manifold, dependent positions and velocities moving along, of"
_CHOICES = ("independent", "alpha", "beta")

CLOSED_DERIVATIVES: dict[str, Output] = {
    "forward_dynamics_derivatives": _row(
        f"derivatives [dqdd/dq_i | dqdd/dqd_i | dqdd/dtau] {_ALONG} the accelerations of the closed mechanism",
        ("q", "qd", "tau"),
        "dqdd",
        (labels.velocities, _OF_MOTION),
        "rad/s^2 or m/s^2, per unit of what moves",
        roads={
            "implicit": Road(_implicit_forward),
            "forward": Road(_tangent_forward),
            "lagrange": by_lagrange(_lagrange_forward),
        },
        depends=_CHOICES,
        prefer=partial(cheaper, _implicit_forward, _tangent_forward),
        remark=_kinks(closed.forward),
    ),
    "multipliers_derivatives": _row(
        f"derivatives [dlambda/dq_i | dlambda/dqd_i | dlambda/dtau] {_ALONG} the multipliers",
        ("q", "qd", "tau"),
        "dlambda",
        (labels.kept_rows, _OF_MOTION),
        "N or N m, per unit of what moves",
        roads={
            "implicit": Road(_implicit_multipliers),
            "forward": Road(_tangent_multipliers),
            "lagrange": by_lagrange(_lagrange_multipliers),
        },
        depends=_CHOICES,
        prefer=partial(cheaper, _implicit_multipliers, _tangent_multipliers),
        remark=_kinks(closed.multipliers),
    ),
    "inverse_dynamics_derivatives": _row(
        f"derivatives [dtau/dq_i | dtau/dqd_i | dtau/dqdd_i] {_ALONG} the driving forces of the closed mechanism",
        ("q", "qd", "qdd"),
        "dtau",
        (labels.velocities, _behind(independent_positions, independent_velocities, _independent_accelerations)),
        f"{FORCES}, per unit of what moves",
        roads={
            "forward": Road(lambda w: _differentiated(w.once(closed.inverse), _driving(w.loops.recursive_manifold))),
            "lagrange": by_lagrange(
                lambda w: _differentiated(w.once(closed.lagrange_inverse), _driving(w.loops.differentiated_manifold))
            ),
        },
        depends=("independent",),
        remark=_kinks(closed.inverse),
    ),
    "velocities_derivatives": _row(
        f"derivatives [dqd/dq_i | dqd/dqd_i] {_ALONG} the velocities that the loops allow",
        ("q", "ui"),
        "dqd",
        (labels.velocities, _behind(independent_positions, independent_velocities)),
        "rad/s or m/s, per unit of what moves",
        roads={"partition": Road(_velocities), "normal": Road(_normal_velocities)},
        depends=("independent",),
    ),
    "positions_derivatives": _row(
        "derivatives dq/dq_i of positions by independent ones, loops staying closed, along the directions of the "
        "velocities",
        ("q",),
        "dq",
        (COLUMNS["q"], independent_positions),
        "1, m or 1/m",
        roads={
            "partition": Road(lambda w: _positions(w.loops.recursive_manifold)),
            "normal": Road(lambda w: _positions(w.loops.differentiated_manifold)),
        },
        depends=("independent",),
    ),
}
"""Rows of closed scenes, by what is asked; what operators make is asked of all others."""
