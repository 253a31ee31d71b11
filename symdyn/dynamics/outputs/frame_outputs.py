"""How a named frame moves, in the axes and at the point that a word behind its name says: rows of OUTPUTS.

"jacobian:tool" is that of frames that are aligned with the ground, as is "jacobian:tool:aligned"; "jacobian:tool:local"
and "jacobian:tool:world" are others, with derivatives of their own: "jacobian_jvp:tool:local".

    aligned   at the origin of the named frame, axes of the ground
    local     at the origin of the named frame, its own axes
    world     of the point of the body that passes the origin of the ground, axes of the ground
    R, p      placement of the named frame in the ground frame
    v, ω      velocity of its origin, angular velocity; axes of the ground

    V         aligned [v; ω]        local [Rᵀ v; Rᵀ ω]                  world [v + p × ω; ω]           V = J u
    V̇         aligned [v̇; ω̇]        local [Rᵀ (v̇ - ω × v); Rᵀ ω̇]        world [v̇ + v × ω + p × ω̇; ω̇]   V̇ = J u̇ + J̇ u

V̇ is the rate of the numbers in V: so it is the acceleration of a point where frames are aligned, and what Featherstone
calls a spatial acceleration elsewhere. Each exists twice. *By differentiation*: the placement in the ground frame, its
rates, and [v; ω] as a function of u. *Recursive*: from the joint axes and the motion of the tree, in axes of the body
that carries the frame. The linear part stands first.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), sections 2.10 and 2.11.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from symdyn.dynamics.mechanism.kinematics import locate, placed, tree_placed
from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.output import Formulation, Output, by_differentiation
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr, tangents
from symdyn.spatial import Transform, Vec, add, cross, scale, sub, zero_vector

WORDS = {
    "aligned": "ground frame",
    "local": "in its own axes",
    "world": "axes of the ground, of the point of the body that passes the origin of the ground",
}
"""What texts say of a frame, and of the point whose velocity the linear part is; first, that without a word."""

# By differentiation


def _by_rates(w: Workspace, name: str, frame: str) -> list[Expr]:
    """Return V, shape (6,), of v = ṗ and ω̃ = Ṙ Rᵀ."""
    T, rates = placed(w.scene, name, w.graph), w.state.velocity
    x, y, z = tangents(T.p, rates)
    v, omega = (x, y, z), T.R.spin([tangents(row, rates) for row in T.R])
    if frame == "local":
        v, omega = T.R.T @ v, T.R.T @ omega
    return [*(add(v, cross(T.p, omega)) if frame == "world" else v), *omega]


def _jacobian_by_rates(w: Workspace, name: str, frame: str) -> list[Expr]:
    """Return J row by row, shape (6, n)."""
    twist = _by_rates(w, name, frame)
    columns = [tangents(twist, {qd: w.graph.one}) for qd in w.state.qd]
    return [column[k] for k in range(6) for column in columns]


# Recursive


def _jacobian(w: Workspace, name: str, frame: str) -> list[Expr]:
    """Return J row by row, shape (6, n): column z × (p - o) + s over z, with z, s the joint axis."""
    tree, graph = w.tree, w.graph
    body, local = locate(w.scene, name, graph)
    i, home = tree.home[body]
    columns: list[tuple[Expr, ...]] = [(graph.zero,) * 6] * tree.n
    placements, here = tree.placements(), home @ local  # here: the named frame in that of body i
    p = zero_vector(graph) if frame == "world" else tree_placed(w.scene, tree, name).p
    while i:
        (z, s), T = tree.S[i], placements[i]
        if frame == "local":
            column = (*here.R.T @ add(cross(z, here.p), s), *here.R.T @ z)
        else:
            z, s = T.R @ z, T.R @ s
            column = (*add(cross(z, sub(p, T.p)), s), *z)
        for k, share in tree.A[i]:
            columns[k] = tuple(x + share * y for x, y in zip(columns[k], column, strict=True))
        here, i = tree.T[i] @ here, tree.parent[i]
    return [column[k] for k in range(6) for column in columns]


def _velocity(w: Workspace, name: str, frame: str) -> list[Expr]:
    """Return V, shape (6,)."""
    carrier, here, T = _carried(w, name)
    v, omega = _twist(w, carrier, here.p)
    if frame == "local":
        return [*here.R.T @ v, *here.R.T @ omega]
    v, omega = T.R @ v, T.R @ omega
    return [*(add(v, cross(T.point(here.p), omega)) if frame == "world" else v), *omega]


def _acceleration(w: Workspace, name: str, frame: str, qdd: Sequence[Expr] = ()) -> list[Expr]:
    """Return V̇, shape (6,); J̇ u without the rates u̇ of the velocities."""
    carrier, here, T = _carried(w, name)
    motion = w.tree.motion(w.state.qd, qdd or w.zeros, zero_vector(w.graph))[carrier]
    a, dw = motion.at(here.p), motion.dw
    if frame != "aligned":
        a = add(a, cross(_twist(w, carrier, here.p)[0], motion.w))
    if frame == "local":
        return [*here.R.T @ a, *here.R.T @ dw]
    a, dw = T.R @ a, T.R @ dw
    return [*(add(a, cross(T.point(here.p), dw)) if frame == "world" else a), *dw]


def _carried(w: Workspace, name: str) -> tuple[int, Transform, Transform]:
    """Return the moving body that carries a frame, the frame's placement there, and the body's in the ground."""
    body, local = locate(w.scene, name, w.graph)
    carrier, home = w.tree.home[body]
    return carrier, home @ local, w.tree.placements()[carrier]


def _twist(w: Workspace, carrier: int, r: Vec) -> tuple[Vec, Vec]:
    """Return the velocity of the point r of a moving body, m/s, and its angular velocity, in the body's axes."""
    tree, rate, v, omega = w.tree, w.tree.rates(w.state.qd), zero_vector(w.graph), zero_vector(w.graph)
    for i in tree.paths(0, carrier)[1]:
        (z, s), E = tree.S[i], tree.T[i].R
        v = add(E.T @ add(v, cross(omega, tree.T[i].p)), scale(rate[i], s))
        omega = add(E.T @ omega, scale(rate[i], z))
    return add(v, cross(omega, r)), omega


# The table

Derive = Callable[..., list[Expr]]
Kind = tuple[str, tuple[str, ...], str, tuple[labels.Axis, ...], str, Derive, Derive]
_TWIST = labels.fixed(*labels.TWIST)
_RATES = "m/s^2 and rad/s^2"
KINDS: dict[str, Kind] = {
    "jacobian": (
        "Jacobian J of {{name}}: [velocity of its origin; angular velocity] = J qd, {at}",
        ("q",), "J", (_TWIST, labels.velocities), "m or 1, and 1", _jacobian, _jacobian_by_rates,
    ),
    "jdot_qdot": (
        "velocity product Jdot qd of {{name}}: its [acceleration; angular acceleration] at qdd = 0, {at}{rate}",
        ("q", "qd"), "a", (_TWIST,), _RATES,
        _acceleration, lambda w, name, frame: tangents(_by_rates(w, name, frame), w.state.velocity),
    ),
    "velocity": (
        "[velocity of its origin; angular velocity] of {{name}}, {at}",
        ("q", "qd"), "V", (_TWIST,), "m/s and rad/s", _velocity, _by_rates,
    ),
    "acceleration": (
        "[acceleration of its origin; angular acceleration] of {{name}}, {at}, without gravity{rate}",
        ("q", "qd", "qdd"), "A", (_TWIST,), _RATES,
        lambda w, name, frame: _acceleration(w, name, frame, w.state.qdd),
        lambda w, name, frame: tangents(_by_rates(w, name, frame), w.state.acceleration),
    ),
}  # fmt: skip
"""Text, arguments, result, axes and units, and the two formulations."""


def _row(kind: str, frame: str) -> Output:
    text, arguments, result, axes, units, recursive, by_rates = KINDS[kind]
    usual = frame == "aligned"
    return Output(
        text.format(at=WORDS[frame], rate="" if usual else ", the rate of its velocity there"),
        arguments, result, axes, units, "same",
        {
            "recursive": Formulation(partial(recursive, frame=frame)),
            "differentiation": by_differentiation(partial(by_rates, frame=frame)),
        },
        place="point",
        default_in="load" if usual and kind in ("jacobian", "jdot_qdot") else "request",
    )  # fmt: skip


IN_FRAMES: Mapping[str, Mapping[str, Output]] = {frame: {kind: _row(kind, frame) for kind in KINDS} for frame in WORDS}
"""Rows by the word for the frame, then by name."""

MOVING = IN_FRAMES["aligned"]
