"""A system between samples, its inputs held: x(t + T) = Φ x(t) + Γ w(t), in two ways.

    exact        exp([A B; 0 0] T) = [Φ Γ; 0 1]                         at a point where A and B stay
    variations   d/dt [Φ Γ] = A(t) [Φ Γ] + [0 B(t)], Φ(0) = 1, Γ(0) = 0       along the motion from the point

In axes that do not spin with a body, inputs that are its drives are held in these axes.

The second integrates the motion itself beside its variations, and holds where the point is no equilibrium too; at one,
and along a steady motion, both are the same.

Reference: Van Loan, Computing integrals involving the matrix exponential, IEEE Trans. Aut. Control 23 (1978).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.outputs import COLUMNS
from symdyn.errors import LinearizeError
from symdyn.linear.modes import Complexes, pairs_of
from symdyn.linear.spinning import turned
from symdyn.simulation import opened

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization
    from symdyn.linear.prepared import Prepared

TOLERANCE = 1e-12
"""Relative, of a step of the integration; the absolute one is this over the size of a state, at least 1e-2."""


@dataclass(frozen=True)
class Sampled:
    """A system with a period.

    Attributes:
        period: T, s.
        A, B: Φ, shape (nx, nx), and Γ, shape (nx, nw).
    """

    period: float
    A: Array
    B: Array

    @property
    def eigenvalues(self) -> Complexes:
        """Of Φ, largest first; inside the unit circle decays."""
        found = np.linalg.eigvals(self.A).astype(np.complex128)
        return found[np.argsort(-np.abs(found), kind="stable")]

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {"period": self.period, "Phi": self.A.tolist(), "Gamma": self.B.tolist(),
                "eigenvalues": pairs_of(self.eigenvalues)}  # fmt: skip


def check_period(period: float) -> None:
    """Raise LinearizeError for what is no period."""
    if not (math.isfinite(period) and period > 0):
        raise LinearizeError(f"--dt {period:g}: a period is finite and above zero, in s")


def sampled(one: Linearization, period: float) -> Sampled:
    """Return the system with its inputs held between samples, by the matrix exponential.

    Raises:
        LinearizeError: the period is none, or so long that something grows beyond what a double can hold.
    """
    from scipy.linalg import expm  # late: it takes long to load

    check_period(period)
    n, inputs = one.B.shape
    whole = np.zeros((n + inputs, n + inputs))
    whole[:n, :n], whole[:n, n:] = one.A, one.B
    with np.errstate(over="ignore", invalid="ignore"):
        found = expm(whole * period)
    if not np.isfinite(found).all():
        raise LinearizeError(f"--dt {period:g}: something grows beyond all numbers within a period; give a shorter one")
    return Sampled(period, found[:n, :n], found[:n, n:])


def along_a_step(prepared: Prepared, one: Linearization, period: float) -> Sampled:
    """Return the same by variational equations, along the motion from the point.

    Raises:
        LinearizeError: the period is none, or the choice of independent coordinates does not hold for it.
    """
    from scipy.integrate import solve_ivp  # late, too

    check_period(period)
    point, numbers = one.point, opened(one.scene).numbers()
    full = prepared.at(point.q, point.u, point.t)
    labels = COLUMNS["q"](prepared.functions.w)
    n, inputs, nq, nv = len(full.A), full.B.shape[1], len(point.q), len(point.u)

    def rates(t: float, y: Array) -> Array:
        q, u, variations = numbers.normalised(y[:nq]), y[nq : nq + nv], y[nq + nv :].reshape(n, n + inputs)
        here = prepared.at(q, u, t)
        if here.states != full.states:
            raise LinearizeError(
                f"--dt {period:g}: other coordinates have to determine the rest within a period; give a shorter one"
            )
        moved = here.A @ variations
        moved[:, n:] += here.B @ turned(full, labels, one.spin, t - point.t).W if one.spin.any() else here.B
        return np.concatenate([prepared.place(q, u, t).H @ u, here.point.udot, moved.ravel()])

    start = np.concatenate([point.q, point.u, np.eye(n, n + inputs).ravel()])
    run = solve_ivp(rates, (point.t, point.t + period), start, "DOP853", rtol=TOLERANCE, atol=TOLERANCE * 1e-2)
    if not run.success or not np.isfinite(run.y[:, -1]).all():
        raise LinearizeError(f"--dt {period:g}: the motion from the point cannot be followed that long")
    found = run.y[nq + nv :, -1].reshape(n, n + inputs)
    if one.spin.any():  # to the axes that the system is in
        found = np.asarray(np.linalg.solve(turned(full, labels, one.spin, period).X, found), np.float64)
    kept = [full.states.names.index(name) for name in one.states.names]
    return Sampled(period, found[np.ix_(kept, kept)], found[kept, n:])
