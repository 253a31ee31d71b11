"""How a whole run depends on its start and on parameters, at each of its samples: variational equations beside it.

    Ẇ = ∂f/∂x W + ∂f/∂p C        W = ∂x/∂(start, p), a way a column; C says by how much it changes each parameter

They are integrated together with the motion, to tolerances of both, by the flow that `sensitivity` takes; what does not
belong to the state (forces, energies, points, outputs) is told at states and values next to the run, on both sides of
it, and divided by the distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.scene import Scene, bind
from symdyn.scene.values import Faults, listed, suggestion
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.equations.variational import Flow, smooth_flow
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.feedback.gains import state_names
from symdyn.simulation.forward import ready
from symdyn.simulation.gradients import FINEST
from symdyn.simulation.initial import Start
from symdyn.simulation.integrate.method import LIBRARIES_RAISE
from symdyn.simulation.integrator import is_stiff
from symdyn.simulation.prescribed.forces import Forces
from symdyn.simulation.run import Integration
from symdyn.simulation.trajectory import END, Trajectory
from symdyn.simulation.trajectory_builder import trajectory_of

RTOL = 1e-10
"""Relative tolerance of a step, of the motion and of its variations."""

STEP = 1e-5
"""Part of a parameter's size, or 1, by which columns beside the state are told on both sides of a run."""

UNTOLD = frozenset({"work", "energy_error", "loop_error", "loop_rate_error"})
"""Columns that say how well a run was integrated, or what is integrated beside it: of these nothing is told."""


@dataclass(frozen=True, eq=False)
class Variations:
    """A run, and the directions in which it moves where its start or a parameter does.

    Attributes:
        system: the mechanism under its forces.
        run: the motion itself.
        names: positions and velocities at the start, and parameters.
        ways: change of the state, q and then u, over that of each name, shape (N, k, nq + nv).
        rates: likewise of its rate, q̇ and then u̇.
        changes: by how much each name changes each of the flow's parameters, shape (k, at least 1).
    """

    system: StateEquations
    run: Trajectory
    names: tuple[str, ...]
    parameters: tuple[str, ...]
    ways: Array
    rates: Array
    changes: Array

    def slopes(self, columns: Sequence[str]) -> Array:
        """Return the derivatives of columns of the run by each of the names, shape (N, columns, k)."""
        scene = self.run.scene
        nq, nv = len(scene.coordinates), len(scene.velocities)
        exact = [*scene.coordinates, *scene.velocities, *self.run.names[1 + nq + nv : 1 + nq + 2 * nv]]
        parts = np.concatenate([self.ways, self.rates[:, :, nq:]], axis=2)
        found = np.zeros((len(self.run.t), len(columns), len(self.names)))
        beside = [name for name in columns if name not in exact]
        for j, name in enumerate(columns):
            if name in exact:
                found[:, j] = parts[:, :, exact.index(name)]
        if beside:
            at = [j for j, name in enumerate(columns) if name not in exact]
            for k in range(len(self.names)):
                step = self.step(k)
                ahead, behind = (self.beside(k, sign * step) for sign in (1, -1))
                found[:, at, k] = np.array([(ahead[name] - behind[name]) / (2 * step) for name in beside]).T
        return found

    def step(self, k: int) -> float:
        """Return by how much a name may be moved, so that the run moves by little against the size of everything."""
        largest = float(np.abs(self.ways[:, k]).max(initial=0.0))
        return STEP * min(_size(self.system, self.names[k]), 1.0 / largest if largest else 1.0)

    def beside(self, k: int, step: float) -> Trajectory:
        """Return the run as it is to first order where one of the names is moved by a step."""
        run, system = self.run, self.system
        x = np.hstack([run.q, run.qd]) + step * self.ways[:, k]
        x = np.hstack([x, np.zeros((len(x), int(system.works)))])
        moved = {
            name: system.opened.values[name] + step * float(change)
            for name, change in zip(self.parameters, self.changes[k], strict=False)
            if change
        }
        if moved:
            scene = bind(system.scene, moved)
            system = system.at(scene, system.forces)
        found = Integration(run.t, x, (), END, 0, 0, 0.0, 0.0)
        return trajectory_of(system, found, (), (), False)


def variations(run: Trajectory, forces: Forces, start: Start, names: Sequence[str], rtol: float = RTOL) -> Variations:
    """Return how a run moves where names at its start, or parameters, move.

    Args:
        run: what `simulate` has found.
        forces: what drove it.
        start: the state that it started from.
        names: independent positions and velocities at the start as `sensitivity` calls them, and parameters.
        rtol: relative tolerance.

    Raises:
        SimulateError: a name that is none of these; forces that have no derivative; or an integration that fails.
    """
    scene = run.scene
    _check(scene, forces, names)
    system = state_equations(scene, forces, (), start.q)
    x = np.concatenate([start.q, start.u, np.zeros(int(system.works))])
    ready(system, x)
    every = [one.name for one in scene.parameters]
    along = smooth_flow(system, tuple(name for name in names if name in every))
    ways, changes, columns = along.starting(x[: along.size])
    lacking = [name for name in names if name not in columns]
    if lacking:
        raise SimulateError(
            f"{scene.name}: {', '.join(lacking)} at the start follows others through the loops; independent there are "
            f"{listed(columns[: len(columns) - len(along.parameters)])}"
        )
    rows = [columns.index(name) for name in names]
    sizes = np.array([_size(system, name) for name in names])[:, None]
    stiff = is_stiff(system, x, float(run.t[-1]))
    moved, rates = _integrated(along, x[: along.size], ways[rows] * sizes, changes[rows] * sizes, run.t, stiff, rtol)
    return Variations(system, run, tuple(names), along.parameters, moved / sizes, rates / sizes, changes[rows])


def _check(scene: Scene, forces: Forces, names: Sequence[str]) -> None:
    """Raise SimulateError with every name that is not known, and every force without derivatives."""
    faults = Faults("")
    every = [*state_names(scene), *(one.name for one in scene.parameters)]
    for name in names:
        if name not in every:
            faults.add(scene.name, f"{name} is no parameter, and no position or velocity; {suggestion(name, every)}")
    forces.check_differentiable(faults)
    faults.close(SimulateError)


def _size(system: StateEquations, name: str) -> float:
    """Return what a change of a name is measured by: its size, of a parameter, or 1."""
    return abs(system.opened.values.get(name, 1.0)) or 1.0


def _integrated(
    along: Flow, x: Array, ways: Array, changes: Array, times: Array, stiff: bool, rtol: float
) -> tuple[Array, Array]:
    """Return the ways and their rates at times, shapes (N, k, nx) each.

    Raises:
        SimulateError: they have no finite value on the way.
    """
    from scipy.integrate import solve_ivp

    n, k = len(x), len(ways)

    def rates(t: float, y: Array) -> Array:
        return np.concatenate([along.rates(t, y[:n]), along.along(t, y[:n], y[n:].reshape(k, n), changes).ravel()])

    def slopes(t: float, y: Array) -> Array:  # without second derivatives
        return np.asarray(np.kron(np.eye(1 + k), along.slopes(t, y[:n])[0]), dtype=np.float64)

    options: dict[str, Any] = {"method": "Radau", "jac": slopes} if stiff else {"method": "DOP853"}
    rtol = max(rtol, FINEST)
    begin, end = float(times[0]), float(times[-1])
    why = "a derivative has no finite value"
    found = np.empty((0, 0))
    try:
        with np.errstate(all="ignore"):
            y = np.concatenate([x, ways.ravel()])
            solved = solve_ivp(rates, (begin, end), y, t_eval=times, rtol=rtol, atol=rtol, **options)
        found, why = solved.y.T, why if solved.success else str(solved.message).rstrip(".")
    except LIBRARIES_RAISE as fault:
        why = str(fault)
    if len(found) != len(times) or not np.all(np.isfinite(found)):
        raise SimulateError(f"{along.system.scene.name}: variations of the run to t = {end:g} s: {why}")
    moved = found[:, n:].reshape(len(times), k, n)
    each = zip(times.tolist(), found[:, :n], moved, strict=True)
    return moved, np.array([along.along(t, at, W, changes) for t, at, W in each])
