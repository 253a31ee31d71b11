"""A run as the steps that were taken, and the derivative of these steps, forward and backward.

    X_i = x + h Σ_j a_ij K_j      K_i = f(t + c_i h, X_i)      x' = x + h Σ_i b_i K_i

    forward     δK_i = J_i (δx + h Σ_j a_ij δK_j) + F_i δp            δx' = δx + h Σ_i b_i δK_i
    inside      δx(θ) = δx + h Σ_i b_i(θ) δK_i                        at a part θ of a step, as x(θ) is
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
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.frozen import dataclass, replace
from symdyn.simulation.equations.contact_modes import PASSED, STRIKES
from symdyn.simulation.equations.control_loop import NOTHING
from symdyn.simulation.equations.system import Projection, StateEquations
from symdyn.simulation.equations.variational import Flow
from symdyn.simulation.integrate.integration import LIBRARIES_RAISE, SAME, Hit, InitialValueProblem, IntegrationError
from symdyn.simulation.integrate.watch import IntegrationStep, Watch

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
    """A step.

    Attributes:
        t, h: where it began, and its length.
        stages: the states of its stages, shape (s, nx).
        parts: where in it there are samples.
        jump: ∂x⁺/∂x⁻, shape (nx, nx), and ∂x⁺/∂p, shape (nx, at least 1), of the event at its end; () of none.
    """

    t: float
    h: float
    stages: Array
    parts: tuple[float, ...]
    jump: tuple[Array, ...] = ()


@dataclass(frozen=True)
class Tape:
    """Steps of a run by one method.

    Attributes:
        method: its key in `METHODS`.
        a, b, c: its coefficients, shapes (s, s), (stages that an end takes,) and (s,).
        dense: coefficients of b(θ), see `_inside`.
        steps: in order.
        x: states at the samples, shape (T, nx), at the start and at the end too, and behind an event that ends it.
        end: time of that event, s; None where time ends it.
    """

    method: str
    a: Array
    b: Array
    c: Array
    dense: Array
    steps: tuple[Taken, ...]
    x: Array
    end: float | None = None

    def forward(self, flow: Flow, ways: Array, changes: Array, reported: Told = UNHEARD) -> Array:
        """Return δx at the samples, shape (T, k, nx), of δx at the start, shape (k, nx), and δp, shape (k, np).

        `reported` hears the share of the steps that is done.
        """
        found = [ways]
        for done, step in enumerate(self.steps, 1):
            slopes = self._slopes(flow, step, ways, changes)
            end = ways + step.h * np.einsum("i,ikn->kn", self.b, slopes[: len(self.b)])
            for part in step.parts:
                inside = end if part == 1 else ways + step.h * np.einsum("i,ikn->kn", self._inside(part), slopes)
                found.append(inside)
            ways = end @ step.jump[0].T + changes @ step.jump[1].T if step.jump else end
            reported(done / len(self.steps))
        return np.array(found if self.end is None else [*found, ways])

    def backward(self, flow: Flow, covectors: Array, reported: Told = UNHEARD) -> tuple[Array, Array]:
        """Return λᵀ ∂(end)/∂(start), shape (k, nx), and λᵀ ∂(end)/∂p, shape (k, np), of λ, shape (k, nx).

        `reported` hears the share of the steps that is done.
        """
        changes = np.zeros((len(covectors), len(flow.parameters)))
        for done, step in enumerate(reversed(self.steps), 1):
            if step.jump:
                changes = changes + covectors @ step.jump[1][:, : changes.shape[1]]
                covectors = covectors @ step.jump[0]
            moved, changed = self._pulled(flow, step, covectors)
            covectors, changes = covectors + moved, changes + changed
            reported(done / len(self.steps))
        return covectors, changes

    def _slopes(self, flow: Flow, step: Taken, ways: Array, changes: Array) -> Array:
        """Return δK of all stages, shape (s, k, nx)."""
        s, n = step.stages.shape
        times = (step.t + self.c[:s] * step.h).tolist()
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
        s, n = len(self.b), step.stages.shape[1]
        times = (step.t + self.c[:s] * step.h).tolist()
        back = np.zeros((s, *covectors.shape))
        changes = np.zeros((len(covectors), len(flow.parameters)))
        if self._explicit:
            for i in reversed(range(s)):
                kappa = self.b[i] * covectors + np.einsum("j,jkn->kn", self.a[i + 1 : s, i], back[i + 1 :])
                moved, changed = flow.against(times[i], step.stages[i], kappa)
                back[i], changes = step.h * moved, changes + step.h * changed
            return back.sum(axis=0), changes
        pairs = [flow.slopes(t, x) for t, x in zip(times, step.stages, strict=True)]
        right = np.vstack([step.h * weight * covectors.T for weight in self.b])
        kappa = np.linalg.solve(self._matrix([J for J, _ in pairs], step.h).T, right).reshape(s, n, -1)
        pulled = sum((kappa[i].T @ J for i, (J, _) in enumerate(pairs)), np.zeros_like(covectors))
        return pulled, sum((kappa[i].T @ F for i, (_, F) in enumerate(pairs)), changes)

    def _inside(self, part: float) -> Array:
        """Return b(θ), shape (s,): in powers of θ, of DOP853 in products of θ and 1 - θ by turns."""
        if not self._explicit:
            return np.asarray(part ** np.arange(1, 4) @ self.dense)
        found = np.zeros(len(self.c))
        for k, row in enumerate(self.dense[::-1]):
            found = (found + row) * (1 - part if k % 2 else part)
        return found

    @property
    def _explicit(self) -> bool:
        return not np.triu(self.a).any()

    def _matrix(self, J: list[Array], h: float) -> Array:
        """Return 1 - h J_i a_ij, shape (s n, s n)."""
        s, n = len(J), len(J[0])
        blocks = [[(i == j) * np.eye(n) - h * self.a[i, j] * J[i] for j in range(s)] for i in range(s)]
        return np.asarray(np.block(blocks), dtype=np.float64)


@dataclass(frozen=True)
class Section:
    """Events at which a motion has returned."""

    kinds: tuple[int, ...] = ()  # the system's kinds of events that it is one of; () of none
    sooner: float = 0.0  # s; what is passed before that has just been passed

    def passed(self, events: Sequence[int], system: StateEquations, t: float, x: Array) -> bool:
        """Tell whether events at a state are of it; what is not active passes its plane, and does not strike."""
        here = [k for k in events if k in self.kinds]
        if not here or t <= self.sooner:
            return False
        contact, contacts = system.kinds[here[0]].contact, system.contacts
        if contact is None or contact[1] != STRIKES or contacts is None:
            return True
        found = contacts.numbers(system.evaluate("contacts", t, x), system.nv)
        return bool(found.able[contact[0]]) and tuple(contacts.mode(x, contact[0])) != PASSED

    def first(self, events: Sequence[int]) -> list[int]:
        """Return events with those of it last, whose guard tells when it is passed."""
        return sorted(events, key=lambda k: k in self.kinds)


NOWHERE = Section()


def taped(
    flow: Flow,
    x: Array,
    probe: tuple[Array, Array],
    times: Array,
    rtol: float,
    atol: float,
    stiff: bool,
    look: Told = UNHEARD,
    section: Section = NOWHERE,
) -> Tape:
    """Return the run of a system by DOP853, or by Radau where it is stiff, with samples at times from its start on.

    The probe is the variation that its steps are chosen for too: δx at the start, and δp as `Flow.tangent` takes it.
    After every step `look` hears the time, and may end the run by an IntegrationError. An event of a `section` ends the
    tape, with changes of the state behind it whenever it is passed.

    Raises:
        IntegrationError: it cannot go on.
    """
    from scipy.integrate import DOP853, Radau

    kind: Any = Radau if stiff else DOP853
    way, change = probe
    n = len(x)

    def rates(t: float, both: Array) -> Array:
        return np.concatenate([flow.rates(t, both[:n]), flow.tangent(t, both[:n], both[n:], change)])

    def slopes(t: float, both: Array) -> Array:  # without second derivatives
        return np.asarray(np.kron(np.eye(2), flow.slopes(t, both[:n])[0]), dtype=np.float64)

    options = {"rtol": rtol, "atol": atol, **({"jac": slopes} if stiff else {})}
    a, b, c, within = _radau() if stiff else _dop853()
    steps, found = list[Taken](), [x]
    events, end = _Events(flow, times, rtol, atol, section) if flow.system.jumps or section.kinds else None, None
    try:
        with np.errstate(all="ignore"):
            solver = kind(rates, times[0], np.concatenate([x, way]), times[-1], **options)
            if events is not None:
                events.stand(float(times[0]), x)
            while solver.status == "running":
                old, message = solver.t, solver.step()
                if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
                    words = (message or "a state is not finite").rstrip(".")
                    raise IntegrationError(f"the run cannot go on after t = {solver.t:g} s: {words}")
                hits = [] if events is None else events.within(solver, old)
                if hits and hits[0].t < solver.t:  # the step is taken again, to where the event is, or none at all
                    at_once = hits[0].t <= old
                    end_at, first = (times[-1], {}) if at_once else (hits[0].t, {"first_step": hits[0].t - old})
                    solver = kind(rates, old, solver.y_old, end_at, **first, **options)
                    if not at_once:
                        solver.step()
                step, samples = _taken(solver, float(old), times, a, len(b), n, stiff)
                steps.append(step)
                found += samples
                look(float(solver.t))
                if events is not None and hits and solver.t < times[-1]:
                    passed = [hit.event for hit in hits]
                    if section.passed(passed, flow.system, solver.t, solver.y[:n]):
                        y, *jump = flow.through(section.first(passed), solver.t, solver.y[:n], there=True)
                        steps[-1], end = replace(steps[-1], jump=tuple(jump)), float(solver.t)
                        found.append(y)
                        break
                    passed = [k for k in passed if flow.system.kinds[k].halts]
                    y, *jump = flow.through(passed, solver.t, solver.y[:n])
                    steps[-1] = replace(steps[-1], jump=tuple(jump))
                    both = np.concatenate([y, jump[0] @ solver.y[n:] + jump[1] @ change])
                    events.stand(float(solver.t), y, solver.y[:n], passed)
                    solver = kind(rates, solver.t, both, times[-1], **options)
    except LIBRARIES_RAISE as fault:
        raise IntegrationError(f"the run cannot go on: {fault}") from fault
    return Tape("radau" if stiff else "dop853", a, b, c, within, tuple(steps), np.array(found), end)


def _taken(
    solver: Any, old: float, times: Array, a: Array, stages: int, n: int, stiff: bool
) -> tuple[Taken, list[Array]]:
    """Return the last step of a solver, of length 0 where an event is at once, and states of samples inside."""
    h = float(solver.t - old)
    if not h:
        return Taken(old, 0.0, np.tile(solver.y[:n], (stages, 1)), ()), []
    parts = ((times[(times > old) & (times <= solver.t)] - old) / h).tolist()
    dense = solver.dense_output() if any(part != 1 for part in parts) else None
    found = [solver.y[:n] if part == 1 or dense is None else dense(old + part * h)[:n] for part in parts]
    K = None if stiff else solver.K[:stages] if dense is None else solver.K_extended
    inside = solver.Z if K is None else h * (a[: len(K), : len(K)] @ K)
    return Taken(old, h, (solver.y_old + inside)[:, :n], tuple(parts)), found


class _Events:
    """Looks for events at which something jumps."""

    def __init__(self, flow: Flow, times: Array, rtol: float, atol: float, section: Section) -> None:
        self.system, self.until, self.tolerances = flow.system, float(times[-1]), (rtol, atol)
        self.section = section

    def stand(self, t: float, x: Array, before: Array = NOTHING, passed: Sequence[int] = ()) -> None:
        """Stand at a state, where events may have just passed."""
        kinds, residue = self.system.kinds, self.system.residue(passed, t, before) if passed else {}
        stops, project = tuple(False for _ in kinds), Projection(self.system, self.tolerances[0])
        times = np.array([t, self.until])
        self.watch = Watch(
            InitialValueProblem(self.system, x, times, *self.tolerances, stops, project, residue=residue)
        )

    def within(self, solver: Any, begin: float) -> list[Hit]:
        """Return the first events, at once, of the last step of a solver: jumps, or of the section."""
        n, dense = len(self.watch.problem.x), solver.dense_output()
        step = IntegrationStep(begin, solver.t, solver.y[:n].copy(), lambda times: dense(times).T[:, :n])
        kinds, section = self.system.kinds, self.section
        hits = list(self.watch.within(step))
        hits = [
            one for one in hits if kinds[one.event].halts or (one.event in section.kinds and one.t > section.sooner)
        ]
        return [hit for hit in hits if hit.t <= hits[0].t * (1 + SAME)]


def _dop853() -> tuple[Array, Array, Array, Array]:
    """Return a, b, c of DOP853 with the stages of its dense output, and the rows of that."""
    from scipy.integrate._ivp import dop853_coefficients as of

    first, last, end = np.zeros((3, of.N_STAGES_EXTENDED))
    first[0], last[of.N_STAGES], end[: of.N_STAGES] = 1.0, 1.0, of.B
    return of.A, of.B, of.C, np.array([end, first - end, 2 * end - first - last, *of.D])


def _radau() -> tuple[Array, Array, Array, Array]:
    """Return a, b, c of Radau IIA, and b(θ) in powers of θ: the polynomial through its stages."""
    from scipy.integrate._ivp.radau import P

    a, c = RADAU
    return a, a[-1], c, P.T @ a
