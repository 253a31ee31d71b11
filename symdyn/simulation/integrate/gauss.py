"""Gauss' collocation in double-doubles, for solutions of 28 digits and more: of 16 stages, order 32, with C of our own.

    Y_k = x + h Σ_j a_kj f(t + c_j h, Y_j),      x(t + h) ≈ x + h Σ_j b_j f(t + c_j h, Y_j)

The stages are as many as the states of a block, and found by fixed-point iteration. A step is taken whole and in two
halves, of which the halves are kept. Steps end at samples, so nothing is interpolated; the time of a sample is its
shortest decimal. There are no events, no loops, and no forces from outside the equations. What bends (abs) is refused:
where it does so behind the last stage of a step, neither the step nor its halves see it.

Reference: Hairer, Lubich and Wanner, Geometric numerical integration (2006), II.1.3 and VIII.6.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.arguments import argument
from symdyn.dynamics import Equations, Workspace, derive_one
from symdyn.dynamics.mechanism import TIME
from symdyn.emit import C, emit, render
from symdyn.emit.code import REALS
from symdyn.errors import BuildError
from symdyn.graph import Op, evaluate, reachable, substitute
from symdyn.program import Program, lower
from symdyn.runtime import load_functions
from symdyn.simulation.equations.compiled_routines import acting, function_of, powers
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate.integration import InitialValueProblem, IntegrationError, Method, Piece

FIRST = 1e-3
"""First step, s."""

DD = REALS["dd"]
"""What it computes with."""

MOST = 50
"""Steps after which the caller hears of it."""

SETTLED, AT_REST, ITERATIONS = 1e-2, 10.0, 60
"""Of the iteration, over the tolerance: what ends it, what ends it once it gets no smaller; how many at most."""

FINER = 2.0**-8
"""By how much the halves are taken to be nearer than the whole step; where the order is reached, they are by 2^-32."""

ALMOST = 1 - 1e-6
"""Part of the largest angle from which on a run that gets nowhere has reached it."""

REACHED, PAUSED, STUCK, LOST, HALTED = range(5)


def run(problem: InitialValueProblem) -> Iterator[Piece]:
    """Yield the pieces of the motion, up to a sample each.

    Raises:
        IntegrationError: there is no compiler, or the steps get too short.
    """
    try:
        call = _library(problem.system)
    except BuildError as fault:
        raise IntegrationError(f"method gauss compiles C, and cannot: {fault}") from fault
    low = np.zeros(len(problem.x)) if problem.low is None else problem.low
    state, time, length = np.stack([problem.x, low], 1), np.zeros(2), np.array([min(FIRST, problem.until)])
    counts, halt = np.zeros(2, dtype=np.int64), np.zeros(1, dtype=np.int32)
    begin = state.copy()
    yield Piece(problem.times[:1], begin[None, :, 0], (), (0.0, begin[:, 0]), 0, 0, low=begin[None, :, 1])
    for until in problem.times[1:].tolist():
        why = PAUSED
        while why == PAUSED:
            before = counts.copy()
            why = call(
                state.ctypes.data, time.ctypes.data, length.ctypes.data, until, _beyond(until), problem.rtol,
                problem.atol, MOST, halt.ctypes.data, counts.ctypes.data,
            )  # fmt: skip
            if why in (STUCK, LOST):
                raise IntegrationError(_why_stuck(problem.system, float(time[0]), state[:, 0]))
            here, steps = int(why == REACHED), counts - before
            now = state.copy()
            yield Piece(
                np.full(here, until), now[None, :, 0][:here], (), (float(time[0]), now[:, 0]), int(steps[0]),
                int(steps[1]), low=now[None, :, 1][:here],
            )  # fmt: skip


def _why_stuck(system: StateEquations, t: float, x: Array) -> str:
    """Return why no step leads on from a state, shape (nx,)."""
    function = _program(system).routines[0].function
    place = {"q": x[: system.nq], "qd": x[system.nq :], TIME: np.array([t])}
    values = {
        symbol: float(number)
        for one in function.arguments
        for symbol, number in zip(one.symbols, place.get(one.name, ()), strict=False)
    }
    angles = list(dict.fromkeys(n.args[0] for n in reachable(function.entries) if n.op in (Op.SIN, Op.COS)))
    for angle in angles:
        with suppress(ArithmeticError, ValueError):
            (size,) = evaluate([angle], Floats(), values)
            if abs(size) > ALMOST * 2.0**DD.limit_exponent:
                name = angle.value if angle.op is Op.SYMBOL else "an angle"
                return (
                    f"{name} = {size:.9g} rad at t = {t:.9g} s is too large: sines of 31 digits are there for angles "
                    f"below 2^{DD.limit_exponent} = {2**DD.limit_exponent} rad; start it whole turns nearer to zero, "
                    f"or give {argument('rtol', 1e-16)} or more"
                )
    return (
        f"the steps of the iteration get too short after t = {t:.9g} s: the motion is stiff, leaves what numbers "
        f"hold, or a formula has no real value; give a coarser {argument('rtol')}, which other methods take"
    )


def _beyond(t: float) -> float:
    """Return what the shortest decimal of a time is beyond its double: 0.1 is a tenth of a second."""
    return float(Fraction(repr(t)) - Fraction(t))


def refuses(system: StateEquations) -> str:
    """Return why the method does not apply, "" if it does."""
    if system.closed:
        return "loops are closed, and it has no projection"
    if system.loop is not None or system.forces.outside:
        return "a force comes from outside the equations, with the digits of doubles"
    if any(kind.limit is None and not kind.bends for kind in system.kinds):
        return "it looks for no events"
    found = sorted(node.op.name.lower() for node in reachable(system.program["rates"].function.entries))
    bent = [op.name.lower() for op in (Op.ABS, Op.SELECT, Op.TABLE) if op.name.lower() in found]
    if bent:
        where = "at its points" if bent[0] == Op.TABLE.name.lower() else "where it is zero"
        return f"{bent[0]} bends {where}, which its steps may go past unseen"
    lacking = {Op.SIGN, *DD.lacks}
    named = [name for name in dict.fromkeys(found) if Op[name.upper()] in lacking]
    return f"there is no {', '.join(named)} of 31 digits in it" if named else ""


def _library(system: StateEquations) -> Callable[..., int]:
    program = _program(system)
    sources = emit(program, C.name, "dd", option="batch")
    opening = sources.stem
    values = {
        "stem": opening, "lanes": DD.lanes, "nq": system.nq, "nv": system.nu,
        "nx": system.nq + system.nu + system.works, "settled": SETTLED, "at_rest": AT_REST, "iterations": ITERATIONS,
        "finer": FINER, **tableau(),
    }  # fmt: skip
    name = f"{opening}.c"
    files = {**sources.texts, name: sources.texts[name] + render("gauss/gauss.c.jinja", values)}
    export = f"{opening}_gauss"
    _, found = load_functions(files, (export,))
    call: Any = found[export]
    p, d = ctypes.c_void_p, ctypes.c_double
    call.argtypes, call.restype = [p, p, p, d, d, d, d, ctypes.c_int64, p, p], ctypes.c_int32
    made: Callable[..., int] = call
    return made


def _program(system: StateEquations) -> Program:
    """Return the rates as a program, values of parameters bound to all their digits."""
    w = Workspace(system.scene)
    place = acting(w, system.forces)
    accelerations = substitute(derive_one(w, "forward_dynamics").entries, place)
    drives = substitute(w.state.tau, place)
    work = [w.graph.total(powers(w, drives, place))] if system.works else []
    entries = [*substitute(w.state.rates, place), *accelerations, *substitute(w.state_rates, place), *work]
    rates = function_of(w, "rates", entries, ("q", "qd", TIME))
    return lower(Equations(system.scene, w.graph, (rates,)))


@cache
def tableau() -> dict[str, Any]:
    """Return nodes, weights and coefficients of Gauss' method as text, of 60 digits rounded to double-doubles."""
    from mpmath import MPContext

    c: Any = MPContext()
    c.dps = 60
    legendre = [[c.mpf(1)], [c.mpf(0), c.mpf(1)]]  # by powers
    for n in range(1, DD.lanes):
        up = [c.mpf(0), *((2 * n + 1) * a for a in legendre[n])]
        down = [n * a for a in legendre[n - 1]] + [c.mpf(0)] * (len(up) - n)
        legendre.append([(a - b) / (n + 1) for a, b in zip(up, down, strict=True)])
    roots = sorted(c.re(r) for r in c.polyroots(legendre[DD.lanes][::-1], maxsteps=400, extraprec=400))
    nodes = [(1 + r) / 2 for r in roots]
    c.dps = 120  # Vandermonde's matrix of 16 nodes costs a dozen digits
    powers = c.matrix([[x**k for x in nodes] for k in range(DD.lanes)])
    inverse = c.inverse(powers)

    def integrated(end: Any) -> list[Any]:
        return [c.fsum(end ** (k + 1) / (k + 1) * inverse[j, k] for k in range(DD.lanes)) for j in range(DD.lanes)]

    rows = [integrated(x) for x in nodes]
    return {
        "nodes": _pairs(nodes),
        "weights": _pairs(integrated(c.mpf(1))),
        "columns": [_pairs([row[j] for row in rows]) for j in range(DD.lanes)],
    }


def _pairs(numbers: Sequence[Any]) -> dict[str, list[str]]:
    found = []
    for x in numbers:
        sign, mantissa, exponent, _ = x._mpf_
        found.append(DD.numbers(Fraction((-1) ** sign * int(mantissa)) * Fraction(2) ** int(exponent)))
    return {"high": [repr(high) for high, _ in found], "low": [repr(low) for _, low in found]}


METHODS = {
    "gauss": Method(
        "31 digits", "Gauss' collocation of order 32 in double-doubles", "mpmath", "", 1e-28, run, refuses, False, 1e-30
    )
}
