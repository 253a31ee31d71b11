"""Equations of motion with multipliers, as a differential-algebraic system F(y, ẏ, t) = 0 of index 1.

    y        q, u, W the work of forces, Λ, N, P
    λ = Λ̇    multipliers of the rows G, N and N m
    ν = Ṅ    multipliers of the loops' residuals r; ρ = Ṗ those of the lengths of quaternions e

    q̇ = H (u + Gᵀ ν) + e ρ         M u̇ + h = τ + Gᵀ λ         Ẇ = power
    G u = 0         r(q) = 0         e·e = 1

Positions and velocities are both held to their constraints: ν and ρ vanish on the solution, and make room for r = 0
beside G u = 0 (Gear, Gupta and Leimkuhler). Solved for λ, ν and ρ these equations have index 2. They have index 1 for
Λ, N and P, of which only rates occur (Gear), and that is what IDA is made for. Nothing is divided by a pivot that was
chosen beforehand. Rows that hold no position, of wheels that roll, have no ν. A prescribed motion takes the place of
its force balance, u̇ = p̈, and ν does not move it.

References: Gear, Gupta and Leimkuhler, Automatic integration of Euler-Lagrange equations with constraints (1985); Gear,
Differential-algebraic equation index transformations (1988).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from symdyn.build.load import load_program
from symdyn.dynamics.equations import Equations
from symdyn.dynamics.workspace import Workspace
from symdyn.program import lower
from symdyn.simulate.system import System, drive, function_of

Array = npt.NDArray[np.float64]


class Implicit:
    """F of a system.

    Attributes:
        system: the mechanism under its forces.
        size: length of y.
    """

    def __init__(self, system: System) -> None:
        """Compile M u̇ + h - τ."""
        self.system, w = system, Workspace(system.scene)
        excess = w.forces(list(w.state.qdd))
        excess = [force - drive(w, system.forces, k) for k, force in enumerate(excess)]
        for k, acceleration in zip(w.prescribed.place, w.prescribed.acceleration, strict=True):
            excess[k] = w.state.qdd[k] - acceleration
        functions = (
            function_of(w, "excess", excess, ("q", "qd", "qdd", "tau", "t")),
            function_of(w, "movement", w.state.rates, ("q", "qd")),
        )
        self._calls, _ = load_program(lower(Equations(system.scene, w.graph, functions)), lean=True)
        self._loose = np.array(w.prescribed.free, dtype=int)
        self._holding = np.array(_holding(system), dtype=int)
        lengths = [system.nq, system.nv, int(system.works), system.rows, len(self._holding), len(system.quaternions)]
        self._ends = np.cumsum(lengths)
        self.size = int(self._ends[-1])

    def start(self, t: float, x: Array) -> tuple[Array, Array]:
        """Return y and ẏ at a state that keeps its constraints, shape (nx,)."""
        y, rates = np.zeros(self.size), np.zeros(self.size)
        y[: len(x)], rates[: len(x)] = x, self.system.rates(t, x)
        if self.system.rows:
            _, _, _, multipliers, *_ = np.split(rates, self._ends)
            push = self.system.jacobian(t, x)[:, self._loose].T
            multipliers[:] = np.linalg.lstsq(push, self._excess(t, y, rates)[self._loose], rcond=None)[0]
        return y, rates

    def residual(self, t: float, y: Array, rates: Array) -> Array:
        """Return F, shape (size,)."""
        system = self.system
        q, u, *_ = np.split(y, self._ends)
        speed, _, power, multipliers, nu, rho, _ = np.split(rates, self._ends)
        x, moving, balance = y[: self._ends[2]], u.copy(), self._excess(t, y, rates)
        held = [np.empty(0)] * 2
        if system.rows:
            push = system.jacobian(t, x)[:, self._loose].T
            balance[self._loose] -= push @ multipliers
            moving[self._loose] += push[:, self._holding] @ nu
            held = [system.tell("row_rates", t, x), system.tell("constraint_residual", t, x)[self._holding]]
        found = speed - self._calls["movement"](q, moving)
        for part, stretch in zip(system.quaternions, rho, strict=True):
            found[part] -= q[part] * stretch
        power = power - system.tell("power", t, x).sum() if system.works else power
        lengths = [q[part] @ q[part] - 1.0 for part in system.quaternions]
        return np.concatenate([found, balance, power, *held, lengths])

    def _excess(self, t: float, y: Array, rates: Array) -> Array:
        """Return M u̇ + h - τ, and u̇ - p̈ for a prescribed motion, shape (nv,)."""
        (q, u, *_), (_, accelerations, *_) = np.split(y, self._ends), np.split(rates, self._ends)
        found: Array = self._calls["excess"](q, u, accelerations, self.system.tables(t), t)
        return found


def _holding(system: System) -> list[int]:
    """Return the rows that hold a position."""
    if not system.rows:
        return []
    residual = system.program["constraint_residual"].function
    return [k for k, entry in enumerate(residual.entries) if not entry.is_zero]
