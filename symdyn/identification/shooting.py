"""A run over the samples of a log, and how it depends on its start and on parameters, for output error.

    ẋ = f(t, x, p)        Ṡ = ∂f/∂x S + ∂f/∂p        classical Runge-Kutta, m steps between two samples

Steps stand on the samples, where tables of forces have their corners. What is differentiated is the map that was
computed, its steps as they are: a search sees one function and its own derivative. A closed mechanism is brought back
to its loops at every sample.

Reference: Bock, Numerical treatment of inverse problems in chemical reaction kinetics (1981).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import IdentifyError, SymdynError
from symdyn.scene import Scene, bind
from symdyn.simulation import Flow, Forces

MOST_STEPS = 128
"""Steps between two samples beyond which a motion is too fast for them."""

CLOSE = 1e-5
"""By which part of their range coordinates may differ between m and 2 m steps."""

FORGETS = 1e6
"""A move of a start that grows by more than this is lost in rounding and noise."""

CLOSINGS, CLOSED = 8, 1e-10
"""Newton steps that close the loops at a start, and the coordinate by which the last of them may move it."""

Nodes = tuple[float, Array, Array, Array]
"""Length of a step, and what tables give at its beginning, middle and end."""


@dataclass(frozen=True)
class ShootingRun:
    """A run at the samples.

    Attributes:
        x: states, shape (N, nx).
        S: their derivatives by independent positions and velocities of the start, then parameters, shape (N, k, nx).
    """

    x: Array
    S: Array


@dataclass(frozen=True)
class Shooting:
    """One piece of a log, ready to be run at any values.

    Attributes:
        scene: the mechanism, its parameters bound.
        parameters: names of those that are varied.
        forces: what drives it.
        t: times of the samples, s, shape (N,).
        start: state that moves of the start are counted from, shape (nx,).
        chosen: independent positions and velocities.
        steps: between two samples.
        nodes: steps with what tables give at them, shape (N - 1, steps).
    """

    scene: Scene
    parameters: tuple[str, ...]
    forces: Forces
    t: Array
    start: Array
    chosen: tuple[list[int], list[int]]
    steps: int
    nodes: tuple[tuple[Nodes, ...], ...]

    def along(self, values: Mapping[str, float]) -> Flow:
        """Return the flow at values of the parameters.

        Raises:
            SymdynError: values that the scene cannot have.
        """
        scene = bind(self.scene, values) if values else self.scene
        return Flow.of(scene, self.forces, self.start[: len(scene.coordinates)], self.parameters)

    def grown(self, run: ShootingRun | None) -> float:
        """Return how many times moves of the start have grown until the end of a run."""
        count = len(self.chosen[0]) + len(self.chosen[1])
        return 0.0 if run is None else float(np.abs(run.S[-1, :count]).max())

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Names of the independent positions and velocities of the start."""
        along = self.along({})
        return along.starting(self.start, self.chosen)[2][: -len(self.parameters) or None]

    def run(self, values: Mapping[str, float], moves: Array) -> ShootingRun | None:
        """Return the run at values of the parameters, its start moved by independent positions and velocities.

        None where there is none: values that the scene cannot have, loops that do not close, a state without a value.
        """
        try:
            with np.errstate(all="ignore"):
                along = self.along(values)
                x = self._moved(along, moves)
                ways, changes, _ = along.starting(x, self.chosen)
                return self._followed(along, x, ways, changes)
        except (SymdynError, np.linalg.LinAlgError):
            return None

    def _moved(self, along: Flow, moves: Array) -> Array:
        system, nq = along.system, along.system.nq
        ways, _, _ = along.starting(self.start, self.chosen)
        x = self.start + moves @ ways[: len(moves)]
        for part in system.quaternions:
            x[part] /= np.linalg.norm(x[part])
        if system.closed and not system.linear:
            for _ in range(CLOSINGS):
                before = x
                x = np.concatenate(system.on_manifold(x[:nq], x[nq:]))
                if np.abs(x - before).max() < CLOSED:
                    return x
            raise IdentifyError("the loops do not close")
        return x

    def _followed(self, along: Flow, x: Array, ways: Array, changes: Array) -> ShootingRun | None:
        system, nq = along.system, along.system.nq
        xs, S = np.empty((len(self.t), len(x))), np.empty((len(self.t), *ways.shape))
        xs[0], S[0] = x, ways
        for k, nodes in enumerate(self.nodes):
            t = float(self.t[k])
            for h, *given in nodes:
                x, ways = _step(along, (t, h), x, (ways, changes), given)
                t += h
            if not np.all(np.isfinite(x)):
                return None
            if system.closed and not system.linear:
                x = np.concatenate(system.on_manifold(x[:nq], x[nq:]))
            xs[k + 1], S[k + 1] = x, ways
        return ShootingRun(xs, S) if np.all(np.isfinite(S)) else None

    def until(self, count: int) -> Shooting:
        """Return the first samples alone."""
        return replace(self, t=self.t[:count], nodes=self.nodes[: count - 1])

    def refined(self, values: Mapping[str, float], moves: Array) -> Shooting:
        """Return it with as many steps between samples as the run needs.

        Raises:
            IdentifyError: no number is enough.
        """
        here, coarse = self, self.run(values, moves)
        while here.steps < MOST_STEPS:
            finer = with_steps(here, 2 * here.steps)
            fine = finer.run(values, moves)
            if fine is not None and coarse is not None:
                size = np.ptp(fine.x, axis=0) + 1e-3
                if np.all(np.abs(fine.x - coarse.x) <= CLOSE * size) or self.grown(fine) > FORGETS:
                    return here
            here, coarse = finer, fine
        raise IdentifyError(
            f"{self.scene.name}: {MOST_STEPS} steps between two samples do not follow the motion; it is too fast for "
            "the samples, stiff, or has no value on the way: give other values or starts, or more samples a second"
        )


def shooting(scene: Scene, parameters: tuple[str, ...], forces: Forces, t: Array, start: Array) -> Shooting:
    """Return one piece of a log, ready to be run.

    Raises:
        SimulateError: a force that jumps, or a parameter that the equations cannot be differentiated by.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    along = Flow.of(scene, forces, start[: len(scene.coordinates)], parameters, smooth=True)
    return with_steps(Shooting(scene, parameters, forces, t, start, along.independent(), 1, ()), 1)


def with_steps(piece: Shooting, steps: int) -> Shooting:
    """Return a piece with another number of steps between samples."""
    size = len(piece.scene.velocities) + len(piece.scene.inputs)
    h = np.repeat(np.diff(piece.t) / steps, steps)
    begin = (piece.t[:-1, None] + np.diff(piece.t)[:, None] * np.arange(steps) / steps).ravel()
    tables = [piece.forces.tabulated(begin + part * h, size) for part in (0.0, 0.5, 1.0)]
    each = list(zip(h.tolist(), *tables, strict=True))
    nodes = tuple(tuple(each[k : k + steps]) for k in range(0, len(each), steps))
    return replace(piece, steps=steps, nodes=nodes)


def _step(
    along: Flow, time: tuple[float, float], x: Array, tangent: tuple[Array, Array], given: list[Array]
) -> tuple[Array, Array]:
    """Return the state and its tangents after one step of the classical Runge-Kutta method."""
    (t, h), (S, changes) = time, tangent
    k1, d1 = along.both(t, x, given[0], S, changes)
    k2, d2 = along.both(t + h / 2, x + h / 2 * k1, given[1], S + h / 2 * d1, changes)
    k3, d3 = along.both(t + h / 2, x + h / 2 * k2, given[1], S + h / 2 * d2, changes)
    k4, d4 = along.both(t + h, x + h * k3, given[2], S + h * d3, changes)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), S + h / 6 * (d1 + 2 * d2 + 2 * d3 + d4)
