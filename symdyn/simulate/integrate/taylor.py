"""heyoka's adaptive Taylor method: the graph in its expressions, compiled by LLVM for steps of any order.

Every operation of the graph has its row in `WORDS`; those that branch (abs, sign) have none, nor have tables.

Reference: Biscani and Izzo, Revisiting high-order Taylor methods for astrodynamics and celestial mechanics (2021).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra.numeric import Arithmetic
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.simulate.integrate.method import Hit, IntegrationError, Method, Piece, Problem
from symdyn.simulate.reading import TIME
from symdyn.simulate.system import System

Array = npt.NDArray[np.float64]

WORDS: Mapping[Op, str] = {
    Op.SIN: "sin",
    Op.COS: "cos",
    Op.SQRT: "sqrt",
    Op.EXP: "exp",
    Op.LOG: "log",
    Op.TANH: "tanh",
    Op.ATAN2: "atan2",
}
"""heyoka's names of functions; sums, products and quotients are Python's operators."""

COMPACT = 250
"""Operations from which on loops are compiled in place of straight code, which would take long."""

PATIENCE = 0.05
"""Seconds that a stretch of steps may take before the caller hears of it."""

PI = Fraction("3.14159265358979323846264338327950288419716939937510")

SMALLEST = float(np.finfo(np.float64).eps)


class Expressions(Arithmetic):
    """heyoka's expressions as an algebra."""

    def __init__(self, real: Callable[[Fraction], Any] = float) -> None:
        """Import heyoka; constants are rounded by `real`."""
        import heyoka

        self.heyoka: Any = heyoka
        self.real = real

    def constant(self, value: Fraction) -> Any:
        """Return a rounded constant as an expression."""
        return self.heyoka.expression(self.real(value))

    def pi(self) -> Any:
        """Return π as an expression."""
        return self.constant(PI)

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return node.op(args)."""
        return getattr(self.heyoka, WORDS[node.op])(*args)


def refuses(system: System) -> str:
    """Return why the Taylor method does not apply to a system, "" if it does."""
    if system.forces.tables:
        return "a force is a table, which has no derivatives of high order"
    branches = sorted({node.op.name.lower() for node in _nodes(system) if node.op in (Op.ABS, Op.SIGN)})
    return f"{' and '.join(branches)} in the equations branch" if branches else ""


def size(system: System) -> int:
    """Return how many operations are compiled."""
    return sum(bool(node.args) for node in _nodes(system))


def _nodes(system: System) -> list[Expr]:
    routines = [r.function for r in system.program.routines if r.function.name in ("rates", "events")]
    return reachable([entry for function in routines for entry in function.entries])


def translate(
    system: System, name: str = "rates", real: Callable[[Fraction], Any] = float
) -> tuple[list[Any], list[Any]]:
    """Return the variables of the state and the entries of a function as heyoka's expressions.

    W, the work, is a state that nothing depends on. Constants are rounded by `real`.
    """
    algebra = Expressions(real)
    function = system.program[name].function
    symbols = {argument.name: argument.symbols for argument in function.arguments}
    states = [*symbols["q"], *symbols["qd"]]
    names = [str(symbol.value) for symbol in states] + (["work of forces"] if system.works else [])
    variables = [algebra.heyoka.expression(one) for one in names]
    values: dict[Expr, Any] = dict(zip(states, variables, strict=False))
    values[symbols[TIME][0]] = algebra.heyoka.time
    entries = evaluate(function.entries, algebra, values)
    return variables, entries


def integrator(problem: Problem, hits: Callable[[int, float, Any], None] | None = None) -> Any:
    """Return heyoka's integrator of a problem.

    Args:
        problem: what is integrated.
        hits: called with the number of an event that does not stop, its time and the integrator.
    """
    import heyoka

    system = problem.system
    variables, entries = translate(system)
    options: dict[str, Any] = {"tol": max(problem.rtol, SMALLEST), "compact_mode": size(system) > COMPACT}
    if problem.stops:
        _, formulas = translate(system, "events")
        pairs = list(enumerate(zip(formulas, problem.stops, strict=True)))
        options["t_events"] = [heyoka.t_event(formula) for _, (formula, stop) in pairs if stop]
        options["nt_events"] = [
            heyoka.nt_event(formula, lambda ta, t, sign, k=k: hits and hits(k, t, ta))
            for k, (formula, stop) in pairs
            if not stop
        ]
    return heyoka.taylor_adaptive(list(zip(variables, entries, strict=True)), problem.x, **options)


def run(problem: Problem) -> Iterator[Piece]:
    """Yield the pieces of the motion by heyoka's Taylor method.

    Raises:
        IntegrationError: the motion leaves what doubles hold.
    """
    import heyoka

    found: list[Hit] = []

    def hit(event: int, t: float, ta: Any) -> None:
        if t > 0.0:  # heyoka also reports what is zero at the start
            ta.update_d_output(t)
            found.append(Hit(event, t, ta.d_output.copy()))

    ta = integrator(problem, hit)
    callback = {"callback": _Projection(problem)} if problem.project.active else {}
    stopping = [k for k, stop in enumerate(problem.stops) if stop]
    times, done = problem.times, 0
    if times[0] == 0.0:
        done = 1
        yield Piece(times[:1], problem.x[None], (), (0.0, problem.x), 0, 0)
    stretch = _sure_step(ta)
    while ta.time < problem.until:
        clock = time.perf_counter()
        begin = float(ta.time)
        goal = min(begin + stretch, problem.until)
        inside = times[done : np.searchsorted(times, goal, side="right")]
        grid = np.unique(np.concatenate([[begin], inside, [goal]]))
        outcome, _, _, steps, _, states = ta.propagate_grid(grid, **callback)
        stop = -int(outcome) - 1 if -LEAST_EVENT < int(outcome) < 0 else None
        if stop is None and outcome != heyoka.taylor_outcome.time_limit:
            raise IntegrationError(f"the motion leaves what doubles hold after t = {ta.time:g} s")
        now = (float(ta.time), ta.state.copy())
        if stop is not None:
            found.append(Hit(stopping[stop], *now))
        kept = inside[inside <= now[0]]
        x = states[np.searchsorted(grid[: len(states)], kept)] if len(kept) else np.empty((0, len(problem.x)))
        hits, found[:] = tuple(sorted(found, key=lambda one: one.t)), []
        done += len(kept)
        yield Piece(kept, x, hits, now, int(steps), int(steps), stop is not None)
        if stop is not None:
            return
        spent = time.perf_counter() - clock
        stretch = (goal - begin) * min(16.0, PATIENCE / max(spent, PATIENCE / 100))


LEAST_EVENT = 1_000_000
"""Outcomes from -1 down to this one, excluded, are events that stop; those below have other meanings."""


def _sure_step(ta: Any) -> float:
    """Return a step that is short enough at the start.

    heyoka takes it from the last two orders of the series alone. Both vanish at states with symmetries, such as a
    pendulum that starts level and at rest, whose motion has the orders 2, 6, 10, ... only: the step would be far too
    long. The shortest step by any of the orders from 4 on is taken in its place; a step later the symmetry is gone.
    """
    state, begin = ta.state.copy(), ta.time
    ta.step(max_delta_t=SHORTEST, write_tc=True)
    series = np.abs(ta.tc)
    ta.state[:], ta.time = state, begin
    norms = series.max(axis=0)
    size = max(1.0, norms[0])
    orders = np.arange(4, len(norms))
    with np.errstate(divide="ignore"):
        radius = np.min((size / norms[4:]) ** (1.0 / orders))
    return float(radius) / np.e**2


SHORTEST = 1e-200
"""A step that changes nothing, s."""


class _Projection:
    """Brings the state back to its constraints after a step, where it has drifted."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem

    def __call__(self, ta: Any) -> bool:
        moved = self.problem.project(ta.state)
        if moved is not None:
            ta.state[:] = moved
        return True


METHODS = {
    "taylor": Method("heyoka", "Taylor method of adaptive order and step", "heyoka", "taylor", 1e-12, run, refuses)
}
