"""Integrators that go step by step: SciPy's, and SUNDIALS through scikit-sundae.

Samples inside of steps, events, projection at their ends, and getting nowhere are the same for all. SciPy has explicit
Runge-Kutta methods, and implicit ones for stiff systems; of SUNDIALS there are CVODE's multistep methods, BDF for stiff
systems and Adams for others, and IDA, which takes the equations with multipliers as they are, see
`symdyn.simulation.equations.implicit`.

References: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I (1993), DOP853; II (1996), Radau IIA;
Shampine and Reichelt, The MATLAB ODE suite (1997), BDF; Petzold, Automatic selection of methods (1983), LSODA;
Hindmarsh et al., SUNDIALS: Suite of nonlinear and differential/algebraic equation solvers (2005).
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from functools import partial
from io import StringIO
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.graph import reachable
from symdyn.simulation.equations.control_loop import ControllerError
from symdyn.simulation.equations.implicit import Implicit, slopes_in_turn
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate.integration import (
    SAME,
    SHARE,
    Hit,
    InitialValueProblem,
    IntegrationError,
    Method,
    Piece,
)
from symdyn.simulation.integrate.watch import IntegrationStep, Watch

Resume = Callable[[float, Array], None]


def follow(
    problem: InitialValueProblem, steps: Iterator[IntegrationStep], resume: Resume, slack: float = 1.0
) -> Iterator[Piece]:
    """Yield a piece a step: its samples, events on its interpolant, and projection at its end.

    Steps are made when they are asked for. They `resume` from another state than that of the last one where a
    projection has moved it, which waits for `slack` times its limit: multistep methods lose their past then; and where
    a controller was due.
    """
    events, pace, loop = Watch(problem), Pace(problem), problem.system.loop
    nq, nu = problem.system.nq, problem.system.nu
    seen = 0
    yield Piece(problem.times[:1], problem.x[None], (), (problem.begin, problem.x), 0, 0)
    for step in steps:
        if not np.all(np.isfinite(step.x1)):
            raise IntegrationError(f"the motion leaves what doubles hold after t = {step.t0:g} s")
        pace.check(step)
        step, hits = events.until_bend(step)  # noqa: PLW2901
        stop = next((hit for hit in hits if problem.halts(hit.event)), None)
        end = step.t1 if stop is None else stop.t
        first, last = np.searchsorted(problem.times, (step.t0, end), side="right")
        inside = problem.times[first:last]
        x = step.at(inside) if len(inside) else np.empty((0, len(problem.x)))
        if len(inside) and inside[-1] == step.t1:
            x[-1] = step.x1
        projected = (problem.project(one) for one in x)
        kept = np.array([a if b is None else b for a, b in zip(x, projected, strict=True)]).reshape(x.shape)
        now = step.x1 if stop is None else stop.x
        if loop is not None:
            loop.look(step.t0, end, step.states)
        used, seen = step.evaluations - seen, step.evaluations
        if stop is not None:
            yield Piece(inside, kept, _until(hits, stop), (end, now), 1, used, True)
            return
        moved = problem.project(step.x1, slack) if step.t1 < problem.until else None
        after = step.x1 if moved is None else moved
        yield Piece(inside, kept, tuple(hits), (step.t1, after), 1, used)
        due = loop is not None and loop.halt(step.t1, after[:nq], after[nq : nq + nu])
        if moved is not None or due or events.bent is not None:
            resume(step.t1, after)
            jumps = events.restart(step.t1, after)
            stopped = any(problem.halts(hit.event) for hit in jumps)
            if jumps:
                yield Piece(problem.times[:0], x[:0], tuple(jumps), (step.t1, after), 0, 0, stopped)
            if stopped:
                return


def _until(hits: Sequence[Hit], stop: Hit) -> tuple[Hit, ...]:
    """Return the events until one that halts, which is the last; those at the same time but for rounding among them."""
    before = (hit for hit in hits if hit is not stop and hit.t <= stop.t * (1 + SAME))
    return (*(replace(hit, t=min(hit.t, stop.t)) for hit in before), stop)


class Pace:
    """Notices an integrator that gets nowhere, by how far the last steps have come."""

    STEPS = 3000
    """After so many steps it is looked."""

    MOST = 1e7
    """Steps that the rest of the way may take where a force jumps: at rest, as in dry friction, it holds the state."""

    LEAST = 1e-9
    """Part of the time by which so many steps must advance it: less is a motion that goes beyond all bounds."""

    def __init__(self, problem: InitialValueProblem) -> None:
        self.jumps = problem.system.once(_jumps)
        self.until, self.begin, self.steps = problem.until, problem.begin, 0

    def check(self, step: IntegrationStep) -> None:
        """Raise IntegrationError where the last steps lead nowhere."""
        self.steps += 1
        if self.steps < self.STEPS:
            return
        way = step.t1 - self.begin
        if self.jumps and (self.until - step.t1) * self.steps > self.MOST * way:
            raise IntegrationError(
                f"the motion sticks at t = {step.t1:g} s, where a force with sign jumps to and fro; write a steep "
                "tanh(v/0.01) in place of sign(v), or give the joint friction with smoothing"
            )
        if way <= self.LEAST * step.t1:
            raise IntegrationError(
                f"the motion goes beyond all bounds, or a formula has no real value, after t = {step.t1:.9g} s: "
                f"{self.steps} steps have advanced the time by {way:.1g} s"
            )
        self.begin, self.steps = step.t1, 0


def _jumps(system: StateEquations) -> bool:
    return any(node.jumps for node in reachable(system.program["rates"].function.entries))


MULTISTEP = ("BDF", "LSODA")

IMPLICIT = ("Radau", *MULTISTEP)
"""Those that ask for the derivative of the rates."""

NEAR = 1e-9
"""Step, over the time or 1 s, at which a controller that has no value any more ends a run."""

SMALLEST_SCIPY = 100 * float(np.finfo(np.float64).eps)
"""The smallest relative tolerance that SciPy takes."""


def run_scipy(problem: InitialValueProblem, name: str) -> Iterator[Piece]:
    """Yield the pieces of the motion by the integrator that SciPy calls `name`.

    Raises:
        IntegrationError: the step has become too small, or there are no rates to go on with.
    """
    from scipy import integrate

    kind = getattr(integrate, name)
    share = SHARE if name in MULTISTEP else 1.0
    options: dict[str, Any] = {"rtol": max(share * problem.rtol, SMALLEST_SCIPY), "atol": share * problem.atol}
    if name in IMPLICIT:
        options["jac"] = slopes_in_turn(problem.system)
    solver: Any = kind(problem.system.rates, problem.begin, problem.x, problem.bound, **options)
    spent = 0

    def steps() -> Iterator[IntegrationStep]:
        nonlocal solver, spent
        size = math.inf
        while solver.status == "running":
            size = min(size, getattr(solver, "h_abs", None) or solver.step_size or math.inf, problem.bound - solver.t)
            y = solver.y
            try:
                message = solver.step()
            except ControllerError:  # a step is tried ahead of where the law has no value: go as near as can be
                if size <= NEAR * max(1.0, abs(solver.t)):
                    raise
                spent, size = spent + solver.nfev, size / 4
                solver = kind(problem.system.rates, solver.t, solver.y, problem.bound, first_step=size, **options)
                continue
            size = math.inf
            if solver.status == "failed":
                raise IntegrationError(f"{name} cannot go on after t = {solver.t:g} s: {message.rstrip('.')}")
            yield IntegrationStep(
                solver.t_old, solver.t, solver.y.copy(), _Interpolant(solver), spent + solver.nfev,
                partial(sooner, solver.t_old, y),
            )  # fmt: skip

    def sooner(t: float, x: Array, until: float) -> IntegrationStep | None:
        nonlocal spent
        if name in MULTISTEP or problem.system.loop is not None:
            return None
        one: Any = kind(problem.system.rates, t, x, until, first_step=until - t, **options)
        times, curves = [t], list[Any]()
        while one.status == "running":
            if one.step():  # it has failed
                return None
            times, curves = [*times, one.t], [*curves, one.dense_output()]
        spent += one.nfev
        whole = integrate.OdeSolution(times, curves)
        return IntegrationStep(t, until, one.y, lambda at: np.asarray(whole(at)).T, spent + solver.nfev)

    def resume(t: float, x: Array) -> None:
        nonlocal solver, spent
        spent += solver.nfev
        size = None
        if solver.status == "running":  # else its last step was cut short
            size = min(getattr(solver, "h_abs", None) or solver.step_size, problem.bound - t)
        if not np.isfinite(problem.system.rates(t, x)).all():  # of these SciPy would look for a first step for ever
            raise IntegrationError(f"{name} cannot go on after t = {t:g} s: accelerations have no finite value there")
        solver = kind(problem.system.rates, t, x, problem.bound, first_step=size, **options)

    return follow(problem, steps(), resume, 1e5 if name in MULTISTEP else 1.0)


class _Interpolant:
    """The states inside the last step; DOP853 needs three more evaluations, which are spent when they are asked for."""

    def __init__(self, solver: Any) -> None:
        self.solver, self.curve = solver, None

    def __call__(self, times: Array) -> Array:
        if self.curve is None:
            self.curve = self.solver.dense_output()
        return np.asarray(self.curve(times), dtype=np.float64).T  # type: ignore[misc]


def _scipy(name: str, text: str, rtol: float) -> Method:
    share = SHARE if name in MULTISTEP else 1.0
    run, multistep = partial(run_scipy, name=name), name in MULTISTEP
    return Method("SciPy", text, "scipy", "", rtol, run, finest=SMALLEST_SCIPY / share, multistep=multistep)


SCIPY = {
    "dop853": _scipy("DOP853", "explicit Runge-Kutta method of order 8", 1e-10),
    "rk45": _scipy("RK45", "explicit Runge-Kutta method of order 5", 1e-8),
    "rk23": _scipy("RK23", "explicit Runge-Kutta method of order 3", 1e-6),
    "radau": _scipy("Radau", "implicit Runge-Kutta method of order 5, for stiff systems", 1e-8),
    "bdf": _scipy("BDF", "backward differentiation formulas, for stiff systems", 1e-8),
    "lsoda": _scipy("LSODA", "Adams and BDF methods, changed as the system is stiff or not", 1e-9),
}


SMALLEST_CVODE, SMALLEST_IDA = 1e-15, 1e-12
"""The finest tolerances that the methods get along with; below, IDA's equations are not solved to it."""

SLACK = 1e5
"""A projection makes CVODE begin at order one again: it waits until it is worth that."""


def run_cvode(problem: InitialValueProblem, name: str) -> Iterator[Piece]:
    """Yield the pieces of the motion by CVODE's BDF or Adams methods.

    Raises:
        IntegrationError: CVODE cannot go on; with its words.
    """
    from sksundae.cvode import CVODE

    count, derivative = 0, slopes_in_turn(problem.system)

    def right(t: float, x: Array, out: Array) -> None:
        nonlocal count
        count += 1
        out[:] = problem.system.rates(t, x)

    def slope(t: float, x: Array, rates: Array, out: Array) -> None:
        out[:] = derivative(t, x)

    solver: Any = CVODE(right, method=name, jacfn=slope, **_options(problem, SMALLEST_CVODE))
    return _followed(problem, solver, "CVODE", lambda t, x: (x,), lambda: count)


def run_ida(problem: InitialValueProblem) -> Iterator[Piece]:
    """Yield the pieces of the motion by IDA's BDF methods.

    Raises:
        IntegrationError: IDA cannot go on; with its words.
    """
    from sksundae.ida import IDA

    equations, count = Implicit(problem.system), 0

    def residual(t: float, y: Array, rates: Array, out: Array) -> None:
        nonlocal count
        count += 1
        out[:] = equations.residual(t, y, rates)

    def slope(t: float, y: Array, rates: Array, values: Array, c: float, out: Array) -> None:
        out[:] = equations.slope(t, y, rates, c)

    solver: Any = IDA(residual, jacfn=slope, **_options(problem, SMALLEST_IDA))
    return _followed(problem, solver, "IDA", equations.start, lambda: count)


def _options(problem: InitialValueProblem, least: float) -> dict[str, Any]:
    """Return tolerances; SUNDIALS keeps its own warnings, which go to the standard output, to itself."""
    for stream in ("WARNING", "ERROR"):
        os.environ.setdefault(f"SUNLOGGER_{stream}_FILENAME", os.devnull)
    rtol = max(SHARE * problem.rtol, least)
    return {"rtol": rtol, "atol": problem.atol * (rtol / problem.rtol), "max_num_steps": 100_000}


def _followed(
    problem: InitialValueProblem,
    solver: Any,
    title: str,
    whole: Callable[[float, Array], tuple[Array, ...]],
    count: Callable[[], int],
) -> Iterator[Piece]:
    """Yield the pieces of a solver's steps; `whole` makes its own state, whose first part is the problem's."""
    size = len(problem.x)
    solver.init_step(problem.begin, *whole(problem.begin, problem.x))

    t = problem.begin

    def steps() -> Iterator[IntegrationStep]:
        nonlocal t
        again = 0
        while t < problem.until:
            with redirect_stdout(StringIO()):  # where scikit-sundae prints why a step failed, beside returning it
                found = solver.step(problem.bound, method="onestep", tstop=problem.bound)
            again = again + 1 if found.t <= t else 0
            if not found.success or again > 1:
                why = "its steps are too small to move the time" if found.success else found.message.rstrip(".")
                raise IntegrationError(f"{title} cannot go on after t = {t:g} s: {why}")
            if again:  # after a look inside a step SUNDIALS first returns to its end
                continue
            begin, t = t, float(found.t)
            yield IntegrationStep(begin, t, np.array(found.y[:size], dtype=np.float64), inside, count())

    def inside(times: Array) -> Array:
        """Return the states inside the last step."""
        return np.array([solver.step(float(t), method="normal").y[:size] for t in times])

    def resume(at: float, x: Array) -> None:
        nonlocal t
        t = at
        solver.init_step(t, *whole(t, x))

    return follow(problem, steps(), resume, SLACK)


def proportional(system: StateEquations) -> str:
    """Return why IDA does not apply to a system, "" if it does."""
    return "the loops hold coordinates in proportion, and lose rank at their change points" if system.linear else ""


_sundials = partial(Method, "SUNDIALS", module="sksundae", extra="simulate", multistep=True)
_cvode = partial(_sundials, finest=SMALLEST_CVODE / SHARE)

SUNDIALS = {
    "cvode": _cvode("CVODE's BDF, for stiff systems", rtol=1e-8, run=partial(run_cvode, name="BDF")),
    "adams": _cvode("CVODE's Adams methods", rtol=1e-9, run=partial(run_cvode, name="Adams")),
    "ida": _sundials(
        "IDA's BDF, for loops with their multipliers",
        rtol=1e-8,
        run=run_ida,
        refuses=proportional,
        finest=SMALLEST_IDA / SHARE,
    ),
}
