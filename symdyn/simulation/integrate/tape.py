"""A run as the steps that were taken, and the derivative of these steps, forward and backward.

    X_i = x + h Σ_j a_ij K_j      K_i = f(t + c_i h, X_i)      x' = x + h Σ_i b_i K_i

    forward     δK_i = J_i (δx + h Σ_j a_ij δK_j) + F_i δp            δx' = δx + h Σ_i b_i δK_i
    backward    κ_i = b_i λ' + Σ_j a_ji X̄_j,  X̄_i = h J_iᵀ κ_i        λ = λ' + Σ_i X̄_i,   p̄ += h Σ_i F_iᵀ κ_i

J and F are ∂f/∂x and ∂f/∂p at the stages. What is differentiated is the map from start to end that was computed, its
steps as they are. Forward this is the same Runge-Kutta method applied to the variational equations; backward it is the
transpose of that, which costs nothing per parameter. The lengths of steps are chosen for the motion and for one
variation of it that has a part of everything: a motion at rest takes steps of any length, and what leaves it does not.

References: Bock, Numerical treatment of inverse problems in chemical reaction kinetics (1981), internal numerical
differentiation; Hager, Runge-Kutta methods in optimal control and the transformed adjoint system (2000).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.simulation.equations.variational import Flow
from symdyn.simulation.integrate.method import LIBRARIES_RAISE, IntegrationError

Told = Callable[[float], None]
"""Hears a time or a share."""

UNHEARD: Told = lambda _: None  # noqa: E731

ROOT = math.sqrt(6)

RADAU = (
    np.array([
        [(88 - 7 * ROOT) / 360, (296 - 169 * ROOT) / 1800, (-2 + 3 * ROOT) / 225],
        [(296 + 169 * ROOT) / 1800, (88 + 7 * ROOT) / 360, (-2 - 3 * ROOT) / 225],
        [(16 - ROOT) / 36, (16 + ROOT) / 36, 1 / 9],
    ]),
    np.array([(4 - ROOT) / 10, (4 + ROOT) / 10, 1.0]),
)  # fmt: skip
"""a and c of Radau IIA of order 5; b is the last row of a."""


@dataclass(frozen=True)
class Taken:
    """A step: where it began, its length, and the states of its stages, shape (s, nx)."""

    t: float
    h: float
    stages: Array


@dataclass(frozen=True)
class Tape:
    """Steps of a run by one method.

    Attributes:
        method: its key in `METHODS`.
        a, b, c: its coefficients, shapes (s, s), (s,) and (s,).
        steps: in order.
        x: state at the end, shape (nx,).
    """

    method: str
    a: Array
    b: Array
    c: Array
    steps: tuple[Taken, ...]
    x: Array

    def forward(self, flow: Flow, ways: Array, changes: Array, reported: Told = UNHEARD) -> Array:
        """Return δx at the end, shape (k, nx), of δx at the start, shape (k, nx), and δp, shape (k, np).

        `reported` hears the share of the steps that is done.
        """
        for done, step in enumerate(self.steps, 1):
            ways = ways + step.h * np.einsum("i,ikn->kn", self.b, self._slopes(flow, step, ways, changes))
            reported(done / len(self.steps))
        return ways

    def backward(self, flow: Flow, covectors: Array, reported: Told = UNHEARD) -> tuple[Array, Array]:
        """Return λᵀ ∂(end)/∂(start), shape (k, nx), and λᵀ ∂(end)/∂p, shape (k, np), of λ, shape (k, nx).

        `reported` hears the share of the steps that is done.
        """
        changes = np.zeros((len(covectors), len(flow.parameters)))
        for done, step in enumerate(reversed(self.steps), 1):
            moved, changed = self._pulled(flow, step, covectors)
            covectors, changes = covectors + moved, changes + changed
            reported(done / len(self.steps))
        return covectors, changes

    def _slopes(self, flow: Flow, step: Taken, ways: Array, changes: Array) -> Array:
        """Return δK of all stages, shape (s, k, nx)."""
        s, n = step.stages.shape
        times = (step.t + self.c * step.h).tolist()
        if self._explicit:
            found = np.zeros((s, *ways.shape))
            for i in range(s):
                at = ways + step.h * np.einsum("j,jkn->kn", self.a[i, :i], found[:i])
                found[i] = flow.along(times[i], step.stages[i], at, changes)
            return found
        J = [flow.slopes(t, x)[0] for t, x in zip(times, step.stages, strict=True)]
        right = [flow.along(t, x, ways, changes).T for t, x in zip(times, step.stages, strict=True)]
        solved = np.linalg.solve(self._matrix(J, step.h), np.vstack(right))
        return np.asarray(solved.reshape(s, n, -1).transpose(0, 2, 1), dtype=np.float64)

    def _pulled(self, flow: Flow, step: Taken, covectors: Array) -> tuple[Array, Array]:
        """Return what a step adds to λ and to p̄."""
        s, n = step.stages.shape
        times = (step.t + self.c * step.h).tolist()
        back = np.zeros((s, *covectors.shape))
        changes = np.zeros((len(covectors), len(flow.parameters)))
        if self._explicit:
            for i in reversed(range(s)):
                kappa = self.b[i] * covectors + np.einsum("j,jkn->kn", self.a[i + 1 :, i], back[i + 1 :])
                moved, changed = flow.against(times[i], step.stages[i], kappa)
                back[i], changes = step.h * moved, changes + step.h * changed
            return back.sum(axis=0), changes
        pairs = [flow.slopes(t, x) for t, x in zip(times, step.stages, strict=True)]
        right = np.vstack([step.h * weight * covectors.T for weight in self.b])
        kappa = np.linalg.solve(self._matrix([J for J, _ in pairs], step.h).T, right).reshape(s, n, -1)
        pulled = sum((kappa[i].T @ J for i, (J, _) in enumerate(pairs)), np.zeros_like(covectors))
        return pulled, sum((kappa[i].T @ F for i, (_, F) in enumerate(pairs)), changes)

    @property
    def _explicit(self) -> bool:
        return not np.triu(self.a).any()

    def _matrix(self, J: list[Array], h: float) -> Array:
        """Return 1 - h J_i a_ij, shape (s n, s n)."""
        s, n = len(J), len(J[0])
        blocks = [[(i == j) * np.eye(n) - h * self.a[i, j] * J[i] for j in range(s)] for i in range(s)]
        return np.asarray(np.block(blocks), dtype=np.float64)


def taped(
    flow: Flow,
    x: Array,
    probe: tuple[Array, Array],
    until: float,
    rtol: float,
    atol: float,
    stiff: bool,
    look: Told = UNHEARD,
) -> Tape:
    """Return the run of a system from t = 0 by DOP853, or by Radau where it is stiff.

    The probe is the variation that its steps are chosen for too: δx at the start, shape (nx,), and δp, shape (np,).
    After every step `look` hears the time, and may end the run by an IntegrationError.

    Raises:
        IntegrationError: it cannot go on.
    """
    from scipy.integrate import DOP853, Radau

    kind: Any = Radau if stiff else DOP853
    way, change = probe
    n = len(x)

    def rates(t: float, both: Array) -> Array:
        J, F = flow.slopes(t, both[:n])
        return np.concatenate([flow.rates(t, both[:n]), J @ both[n:] + F @ change])

    def slopes(t: float, both: Array) -> Array:  # without second derivatives
        return np.asarray(np.kron(np.eye(2), flow.slopes(t, both[:n])[0]), dtype=np.float64)

    options = {"jac": slopes} if stiff else {}
    a, c = RADAU if stiff else (kind.A, kind.C)
    b = a[-1] if stiff else kind.B
    steps = []
    try:
        with np.errstate(all="ignore"):
            solver = kind(rates, 0.0, np.concatenate([x, way]), until, rtol=rtol, atol=atol, **options)
            while solver.status == "running":
                message = solver.step()
                h = solver.t - (solver.t_old or 0.0)
                if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
                    words = (message or "a state is not finite").rstrip(".")
                    raise IntegrationError(f"the run cannot go on after t = {solver.t:g} s: {words}")
                inside = solver.Z if stiff else h * (a @ solver.K[: len(b)])
                steps.append(Taken(float(solver.t_old or 0.0), float(h), (solver.y_old + inside)[:, :n]))
                look(float(solver.t))
    except LIBRARIES_RAISE as fault:
        raise IntegrationError(f"the run cannot go on: {fault}") from fault
    return Tape(
        "radau" if stiff else "dop853", np.array(a), np.array(b), np.array(c), tuple(steps), solver.y[:n].copy()
    )
