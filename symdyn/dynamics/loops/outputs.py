"""The outputs of closed scenes: the rows of OUTPUTS that only they have, and those that mean more there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symdyn.dynamics.loads import refuse_ideal_friction
from symdyn.dynamics.loops import closed
from symdyn.dynamics.loops.partition import driven_velocities
from symdyn.dynamics.output import Output
from symdyn.dynamics.prescribed import TIME
from symdyn.dynamics.recursive.ldl import moves_no_mass
from symdyn.dynamics.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate


def _flat(matrix: list[list[Expr]]) -> list[Expr]:
    return [entry for row in matrix for entry in row]


# Forward dynamics


def _forward(w: Workspace) -> list[Expr]:
    refuse_ideal_friction(w.scene)
    _massive(w)
    if w.closed.closure.fails:
        return w.closed.together[0]
    reduced = w.closed.motion
    rest = [tau - force for tau, force in zip(w.state.tau, w.forces(list(reduced.s)), strict=True)]
    return closed.accelerations(reduced, w.composite_mass, rest)


def _massive(w: Workspace) -> None:
    """Raise DerivationError where a motion that the loops leave free moves no mass: it names the joint and the body."""
    import numpy as np

    from symdyn.algebra.numeric import Floats

    reduced = w.closed.motion
    if not reduced.independent:
        return
    size = len(reduced.independent)
    known = w.closed.values(w.closed.closure.assembly.typical) | {w.graph.symbol(TIME): 0.0}
    entries = evaluate(_flat(reduced.mass(w.composite_mass)), Floats(), known)
    mass = np.array(entries).reshape(size, size)
    values, vectors = np.linalg.eigh(mass)
    if values[0] > 1e-13 * max(1e-300, abs(values[-1])):
        return
    velocity = reduced.independent[int(np.abs(vectors[:, 0]).argmax())]
    raise DerivationError(moves_no_mass(w.scene, velocity, " of what the loops leave free"))


def _lagrange_forward(w: Workspace) -> list[Expr]:
    refuse_ideal_friction(w.scene)
    return w.closed.lagrange_solution[0]


def _lagrange_multipliers(w: Workspace) -> list[Expr]:
    refuse_ideal_friction(w.scene)
    return w.closed.lagrange_solution[1][: len(w.closed.closure.kept)]


def _multipliers(w: Workspace) -> list[Expr]:
    if w.closed.closure.fails:
        refuse_ideal_friction(w.scene)
        return w.closed.together[1][: len(w.closed.closure.kept)]
    found = w.forces(_forward(w))
    excess = [force - tau for force, tau in zip(found, w.state.tau, strict=True)]
    return closed.multipliers(w.closed.G(w.closed.recursive), w.closed.closure.partition, excess)


def _drives(w: Workspace) -> list[Expr]:
    place, tau = w.prescribed.place, list(w.state.tau)
    if not place:
        return tau
    forces, found = w.forces(_forward(w)), _multipliers(w)
    pairs = list(zip(w.closed.G(w.closed.recursive), found, strict=True))
    for k in place:
        tau[k] = forces[k] - w.graph.total(row[k] * x for row, x in pairs)
    return tau


def _lagrange_drives(w: Workspace) -> list[Expr]:
    tau = list(w.state.tau)
    if w.prescribed.place:
        extra = w.closed.lagrange_solution[1][len(w.closed.closure.kept) :]
        for k, more in zip(w.prescribed.place, extra, strict=True):
            tau[k] = tau[k] + more
    return tau


# Inverse dynamics: forces of the spanning tree, less what the loops carry


def _inverse(w: Workspace) -> list[Expr]:
    partition, G = w.closed.driven, w.closed.G(w.closed.recursive)
    forces = w.forces(list(w.state.qdd))
    carried = closed.solve_transposed(G, partition, forces)
    return _at_drives(w, forces, G, carried)


def _lagrange_inverse(w: Workspace) -> list[Expr]:
    partition, G, forces = w.closed.driven, w.closed.G(w.closed.differentiated), w.closed.lagrange_forces
    transposed = [[row[k] for row in G] for k in partition.dependent]
    carried = closed.solve_normal(transposed, [forces[k] for k in partition.dependent]) if G else []
    return _at_drives(w, forces, G, carried)


def _at_drives(w: Workspace, forces: list[Expr], G: list[list[Expr]], carried: list[Expr]) -> list[Expr]:
    """Return f - Gᵀ λ at the driven velocities, zero at the passive ones; without any drive, at independent ones."""
    driven = driven_velocities(w.scene) or list(w.closed.driven.independent)
    tau = [w.graph.zero] * w.state.n
    for k in driven:
        tau[k] = forces[k] - w.graph.total(row[k] * x for row, x in zip(G, carried, strict=True))
    return tau


# Velocities


def _velocities(w: Workspace) -> list[Expr]:
    T = w.closed.reduction.T
    return [w.graph.total(t * w.state.qd[i] for i, t in row.items()) for row in T]


def _normal_velocities(w: Workspace) -> list[Expr]:
    partition, G, u = w.closed.closure.partition, w.closed.G(w.closed.differentiated), w.state.qd
    result = [u[k] if k in partition.independent else w.graph.zero for k in range(w.state.n)]
    given = [-w.graph.total(row[k] * u[k] for k in partition.independent) for row in G]
    square = [[row[k] for k in partition.dependent] for row in G]
    for k, value in zip(partition.dependent, closed.solve_normal(square, given) if G else [], strict=True):
        result[k] = value
    return result


def _positions(w: Workspace) -> list[Expr]:
    from symdyn.dynamics.loops.positions import positions  # with NumPy, which trees can do without

    return positions(w)


FORCE = "N m (revolute) or N (prismatic)"

ROWS: dict[str, Output] = {
    "constraint_residual": Output(
        "residuals of the loops, which vanish where they are closed",
        ("q",),
        "r",
        lambda n: (-1,),
        "m or 1",
        {
            "recursive": lambda w: w.closed.residual(w.closed.recursive),
            "differentiation": lambda w: w.closed.residual(w.closed.differentiated),
        },
    ),
    "constraint_jacobian": Output(
        "rows G(q) of the loops: G qd = 0, and the multipliers do the power lambda.G qd",
        ("q",),
        "G",
        lambda n: (-1, n),
        "m or 1",
        {
            "recursive": lambda w: _flat(w.closed.G(w.closed.recursive)),
            "differentiation": lambda w: _flat(w.closed.G(w.closed.differentiated)),
        },
    ),
    "constraint_bias": Output(
        "velocity products Gdot qd of the loops: G qdd + Gdot qd = 0",
        ("q", "qd"),
        "gamma",
        lambda n: (-1,),
        "m/s^2 or 1/s^2",
        {
            "recursive": lambda w: w.closed.bias(w.closed.recursive),
            "differentiation": lambda w: w.closed.bias(w.closed.differentiated),
        },
    ),
    "multipliers": Output(
        "multipliers lambda of M qdd + h = tau + G^T lambda: wrenches that parents exert on children at the cuts, at "
        "the origin of the moved joint frame, axes of the joint frame on the parent; of contacts along, across, normal",
        ("q", "qd", "tau"),
        "lambda",
        lambda n: (-1,),
        "N or N m",
        {"crba": _multipliers, "lagrange": _lagrange_multipliers},
    ),
    "tree_forces": Output(
        "forces M(q) qdd + c(q, qd) + g(q) - Q of the spanning tree, as if nothing closed it",
        ("q", "qd", "qdd"),
        "f",
        lambda n: (n,),
        FORCE,
        {"rnea": lambda w: w.forces(list(w.state.qdd)), "lagrange": lambda w: w.closed.lagrange_forces},
    ),
    "velocities": Output(
        "velocities qd that the loops allow, from independent ones",
        ("q", "ui"),
        "qd",
        lambda n: (n,),
        "rad/s or m/s",
        {"partition": _velocities, "normal": _normal_velocities},
    ),
    "positions": Output(
        "positions q at which the loop is closed, from the independent one, on the branch of the start",
        ("qi",),
        "q",
        lambda n: (-1,),
        "rad or m",
        {"closed form": _positions},
    ),
}

CLOSED_ONLY: tuple[str, ...] = tuple(ROWS)
"""Outputs that only closed scenes have."""

_FORWARD = {
    "text": "accelerations qdd of the closed mechanism: M(q) qdd + h = tau + G^T lambda, G qdd + Gdot qd = 0",
    "roads": {"crba": _forward, "lagrange": _lagrange_forward},
}
_INVERSE = {
    "text": "driving forces tau of the closed mechanism for a motion that its loops allow; {undriven}",
    "roads": {"rnea": _inverse, "lagrange": _lagrange_inverse},
}


def closing(outputs: Mapping[str, Output]) -> dict[str, Output]:
    """Return what closed scenes add to the table."""
    forward, inverse = outputs["forward_dynamics"], outputs["inverse_dynamics"]
    drives = outputs["drive_forces"]
    rows = {name: replace(row, exists=lambda scene: scene.is_closed) for name, row in ROWS.items()}
    return {
        "forward_dynamics": replace(forward, closed=replace(forward, **_FORWARD, prefer=None)),  # type: ignore[arg-type]
        "inverse_dynamics": replace(inverse, closed=replace(inverse, **_INVERSE)),  # type: ignore[arg-type]
        "drive_forces": replace(drives, closed=replace(drives, roads={"crba": _drives, "lagrange": _lagrange_drives})),
    } | rows
