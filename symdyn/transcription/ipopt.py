"""IPOPT solves a problem, through the one that comes in CasADi's wheel (extra `optimal`), from one or several starts.

CasADi sees five functions, f, ∂f, g, ∂g and the Hessian of σ f + λᵀ g, whose values are computed here, and the patterns
of the last two. Equations between unknowns that are all given, as at the start of a closed mechanism, are left out once
they are found to hold.

Starts are drawn by a seed:

    q(t) = q_guess(t) + Σ_k a_k sin(k π t/T)        k = 1 … WAVES, a_k drawn: N(0, 1) size / k

with velocities and accelerations of that motion; the ends stay. A solver finds a place where the conditions of first
order hold, at best an optimum among neighbouring motions: which one depends on the start. The optima that all starts
led to are kept.

References: Wächter and Biegler, On the implementation of an interior-point filter line-search algorithm for large-scale
nonlinear programming, Math. Programming 106 (2006) 25; Andersson et al., CasADi, Math. Programming Computation 11
(2019) 1.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from operator import index
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.errors import SimulateError, quoted
from symdyn.extras import install
from symdyn.scene import SceneUnits
from symdyn.scene.values import spell
from symdyn.simulation import opened
from symdyn.transcription.local import PLACES
from symdyn.transcription.solution import Searched, Solution, lagrangian

if TYPE_CHECKING:
    from symdyn.transcription.transcribed import Collocation

WAVES = 4
"""Half waves that a motion which is drawn has beside the guess."""

SIZES = {"rad": math.pi / 2, "m": 0.5, "1": 0.3}
"""Of what is drawn for a coordinate without bounds, by its unit."""

MOST_STARTS = 10_000

ALIKE, NEAR = 1e-6, 1e-3
"""Costs over their size, and coordinates over the largest or 1, that are those of one optimum."""


def drawn(problem: Collocation, guess: Array, starts: int, seed: int) -> list[Array]:
    """Return z to start from, each of shape (size,): the guess, then those drawn by the seed."""
    random = np.random.default_rng(seed)
    return [guess, *(_one(problem, guess, random) for _ in range(starts - 1))]


def _one(problem: Collocation, guess: Array, random: np.random.Generator) -> Array:
    place, grid = problem.place, problem.grid
    z, n = guess.copy(), place["q"].shape[1]
    if len(place["T"]):
        least, most = problem.lower[place["T"]], problem.upper[place["T"]]
        z[place["T"]] = np.exp(random.uniform(np.log(least), np.log(most)))
    duration = problem.durations(z)[grid.phase][:, None]
    k = np.arange(1, WAVES + 1)
    a = random.standard_normal((WAVES, n)) * _sizes(problem) / k[:, None]
    turns = k * math.pi
    angle = grid.share[:, None] * turns
    z[place["q"]] += np.sin(angle) @ a
    if place["u"].shape[1] == n:  # velocities are rates of coordinates
        z[place["u"]] = guess[place["u"]] + np.cos(angle) @ (a * turns[:, None]) / duration
        z[place["a"]] = (
            guess[place["a"]] - np.sin(angle[grid.stage]) @ (a * turns[:, None] ** 2) / duration[grid.stage] ** 2
        )
    else:
        numbers = opened(problem.scene).numbers()
        z[place["q"]] = [numbers.normalised(q) for q in z[place["q"]]]
    return np.clip(z, problem.lower, problem.upper)


def _sizes(problem: Collocation) -> Array:
    """Return how far coordinates are moved, shape (nq,): half of what their bounds leave, else by their unit."""
    inside = problem.place["q"][1:-1] if len(problem.place["q"]) > 2 else problem.place["q"]
    least, most = problem.lower[inside].max(axis=0), problem.upper[inside].min(axis=0)
    usual = np.array([SIZES.get(unit, 1.0) for unit in SceneUnits(problem.scene).coordinates])
    bounded = np.isfinite(most - least)
    return np.where(bounded, np.minimum(np.where(bounded, most - least, 0.0) / 2, 2 * usual), usual)


def best_of(solutions: Sequence[Solution], seed: int | None) -> Solution:
    """Return the best of what starts led to, the other optima beside it, best first; the first where none ended."""
    groups: list[list[Solution]] = []
    for one in sorted((one for one in solutions if one.success), key=lambda one: one.objective):
        group = next((group for group in groups if _same(group[0], one)), None)
        if group is None:
            groups.append([one])
        else:
            group.append(one)
    failed = tuple(sorted(Counter(one.status for one in solutions if not one.success).items()))
    if not groups:
        return replace(solutions[0], searched=Searched(len(solutions), seed, (), failed))
    led = tuple((group[0].objective, len(group)) for group in groups)
    searched = Searched(len(solutions), seed, led, failed)
    best, *others = (replace(group[0], searched=searched) for group in groups)
    return replace(best, others=tuple(others))


def _same(one: Solution, other: Solution) -> bool:
    """Tell whether two solutions are one optimum."""
    if abs(one.objective - other.objective) > ALIKE * max(abs(one.objective), abs(other.objective), ALIKE):
        return False
    q, p = (x.z[x.problem.place["q"]] for x in (one, other))
    return bool(np.abs(q - p).max(initial=0.0) <= NEAR * max(1.0, float(np.abs(q).max(initial=0.0))))


DEFAULTS: dict[str, Any] = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "no_nlp_grad": True}
"""Options of CasADi's `nlpsol`; the solver is silent unless it is asked to talk."""

EXACT = 18
"""Velocities up to which second derivatives are computed unasked, those of a quadruped; beyond, compilers take long."""

CLOSE = 1e-6
"""Largest residual of an equation between unknowns that are given."""


def solve(
    problem: Collocation,
    guess: Sequence[float] | Array | None,
    exact: bool | None,
    starts: int,
    seed: int,
    options: Mapping[str, Any],
) -> Solution:
    """Return what IPOPT finds; all as of `Collocation.solve`."""
    try:
        z = problem.guess if guess is None else np.asarray(guess, dtype=np.float64)
    except (TypeError, ValueError):
        raise SimulateError(f"guess = {quoted(guess)}: give an array of {problem.size} numbers") from None
    if z.shape != (problem.size,):
        raise SimulateError(f"guess: has the shape {z.shape}; the problem has {problem.size} unknowns")
    (starts, seed) = (_whole("starts", starts, 1), _whole("seed", seed, 0))
    if starts > MOST_STARTS:
        raise SimulateError(f"starts = {quoted(starts)}: give at most {MOST_STARTS}")
    found = []
    for k, start in enumerate(drawn(problem, z, starts, seed)):
        if not k or _has_values(problem, start):
            found.append(_solved(problem, start, exact, options))
    return best_of(found, seed if starts > 1 else None)


def _whole(name: str, given: int, least: int) -> int:
    """Return a whole number that `solve` takes."""
    try:
        found = index(given)
    except TypeError:
        found = least - 1
    if not least <= found or isinstance(given, bool):
        raise SimulateError(f"{name} = {quoted(given)}: give a whole number, {least} or more")
    return found


def _has_values(problem: Collocation, z: Array) -> bool:
    """Tell whether everything that IPOPT asks for has a value."""
    with np.errstate(all="ignore"):
        parts = [problem.residual(z), problem.jacobian_values(z), problem.gradient(z), np.array([problem.objective(z)])]
    return all(np.isfinite(part).all() for part in parts)


def _solved(problem: Collocation, z: Array, exact: bool | None, options: Mapping[str, Any]) -> Solution:
    """Return what IPOPT finds from one start; errors as of `solve`."""
    try:
        import casadi
    except ImportError:
        raise SimulateError(
            f"solving needs IPOPT, which comes with CasADi: {install('optimal')}; or hand the problem's residual, "
            "jacobian_values, objective and gradient to another solver"
        ) from None
    if not _has_values(problem, z):
        raise SimulateError("guess: the equations, the cost or their slopes have no value there; give another guess")
    _contradictions(problem, z)
    kept = problem.binding
    inside = kept[problem.jacobian_rows]
    rows = np.cumsum(kept)[problem.jacobian_rows[inside]] - 1
    x, p = casadi.Sparsity.dense(problem.size), casadi.Sparsity.dense(0, 0)
    one, g = casadi.Sparsity.dense(1), casadi.Sparsity.dense(int(kept.sum()))
    columns = problem.jacobian_columns[inside]
    pattern = casadi.Sparsity.triplet(int(kept.sum()), problem.size, rows.tolist(), columns.tolist())
    order = np.lexsort((rows, columns))  # CasADi stores column by column
    value = _callback("f", [x], [one], lambda z: [problem.objective(z)])
    equations = _callback("g", [x], [g], lambda z: [problem.residual(z)[kept]])
    slope = _callback("df", [x, p], [one, x], lambda z, _: [problem.objective(z), problem.gradient(z)], "grad")
    slopes = _callback(
        "dg",
        [x, p],
        [g, pattern],
        lambda z, _: [problem.residual(z)[kept], problem.jacobian_values(z)[inside][order]],
        "jac",
    )
    settings = {
        **DEFAULTS,
        "grad_f": slope,
        "jac_g": slopes,
        **{f"ipopt.{name}": setting for name, setting in options.items()},
    }
    if len(problem.scene.velocities) <= EXACT if exact is None else exact:
        settings["hess_lag"] = _hessian(problem, kept, [x, p, one, g])
    else:
        settings["ipopt.hessian_approximation"] = "limited-memory"
    symbol = casadi.MX.sym("x", problem.size)
    nlp = {"x": symbol, "f": value(symbol), "g": equations(symbol)}
    try:
        solver = casadi.nlpsol("solver", "ipopt", nlp, settings)
        began = time.perf_counter()
        with np.errstate(all="ignore"):  # a step that leads where nothing has a value is made shorter
            found = solver(
                x0=z, lbx=problem.lower, ubx=problem.upper, lbg=problem.rows_lower[kept], ubg=problem.rows_upper[kept]
            )
    except RuntimeError as fault:
        words = str(fault).strip().splitlines()[-1]
        told = words.rpartition(".cpp:")[2].partition(": ")[2] or words
        own = "guess, starts=8 and seed are ours, others its own, such as max_iter=500; intervals=50 is collocation's"
        raise SimulateError(f"IPOPT: {told}; {own}") from None
    wall = time.perf_counter() - began
    stats, z = solver.stats(), np.array(found["x"], dtype=np.float64).ravel()
    objective, miss = float(problem.objective(z)), violation(problem, z)
    status, iterations = str(stats["return_status"]), int(stats["iter_count"])
    multipliers = np.zeros(problem.rows)
    multipliers[kept] = np.array(found["lam_g"], dtype=np.float64).ravel()
    return Solution(problem, z, multipliers, objective, miss, bool(stats["success"]), status, iterations, wall)


def _hessian(problem: Collocation, kept: NDArray[np.bool_], takes: Sequence[Any]) -> Any:
    """Return the function of CasADi that gives the upper triangle of the Lagrangian's Hessian."""
    import casadi

    of = lagrangian(problem)
    every = np.zeros(problem.rows)
    size = problem.size

    def values(z: Array, _: Array, sigma: Array, multipliers: Array) -> list[Array]:
        every[kept] = multipliers
        return [of.values(z, float(sigma[0]), every)]

    pattern = casadi.Sparsity.triplet(size, size, of.rows.tolist(), of.columns.tolist())
    return _callback("ddl", takes, [pattern], values, "hess")


def violation(problem: Collocation, z: Array) -> float:
    """Return the largest miss of a bound or an equation."""
    g = problem.residual(z)
    misses = (problem.lower - z, z - problem.upper, problem.rows_lower - g, g - problem.rows_upper)
    return float(max(np.max(miss, initial=0.0) for miss in misses))


def _contradictions(problem: Collocation, z: Array) -> None:
    """Raise SimulateError where an equation between unknowns that are given does not hold."""
    g = problem.residual(np.where(problem.given, problem.lower, z))
    miss = np.maximum(problem.rows_lower - g, g - problem.rows_upper)
    miss[problem.binding] = 0.0
    worst = int(miss.argmax())
    if miss[worst] > CLOSE:
        kind, at = next((kind, at) for kind, at in problem.row.items() if worst in at)
        node, *place = np.argwhere(at == worst)[0].tolist()
        grid, point = problem.grid, problem.points(PLACES.get(kind, "joint"))[node]
        where = f"t = {problem.times(z)[point]:.6g} s"
        if len(problem.schedule) > 1:  # whose times are guesses
            where = f"{grid.share[point]:.3g} of phase {grid.phase[point] + 1}"
        words = {"held": "loops do not close, or velocities do not fit them"}
        if kind == "path":
            least, most = (f"{x[worst]:.6g}" for x in (problem.rows_lower, problem.rows_upper))
            formula = dict(problem.source.formulas)["path"][place[0]]
            asked = f"{least} to {most}" if least != most else least
            words["path"] = f"of the path {spell(formula)} is {g[worst]:.6g}, and {asked} is asked for"
        words |= {"open": "a contact is below its plane", "stays": "phases do not meet"}
        raise SimulateError(
            f"what is given at {where} contradicts itself, by {miss[worst]:.3g}: "
            f"{words.get(kind, 'forces and motion do not balance')}; give less of that state"
        )


def _callback(
    name: str, takes: Sequence[Any], gives: Sequence[Any], compute: Callable[..., Sequence[Any]], kind: str = ""
) -> Any:
    """Return a function of CasADi that is computed here; what it gives are the entries of its sparsity."""
    import casadi

    names = {
        "": (["x"], [name]),
        "grad": (["x", "p"], ["f", "grad_f_x"]),
        "jac": (["x", "p"], ["g", "jac_g_x"]),
        "hess": (["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]),
    }[kind]

    class Computed(casadi.Callback):
        def __init__(self) -> None:
            casadi.Callback.__init__(self)
            self.construct(f"computed_{name}", {"enable_fd": False})

        def get_n_in(self) -> int:
            return len(takes)

        def get_n_out(self) -> int:
            return len(gives)

        def get_sparsity_in(self, i: int) -> Any:
            return takes[i]

        def get_sparsity_out(self, i: int) -> Any:
            return gives[i]

        def get_name_in(self, i: int) -> str:
            return names[0][i]

        def get_name_out(self, i: int) -> str:
            return names[1][i]

        def eval(self, arguments: Sequence[Any]) -> list[Any]:
            found = compute(*(np.array(one, dtype=np.float64).ravel() for one in arguments))
            return [casadi.DM(sparsity, x) for sparsity, x in zip(gives, found, strict=True)]

    return Computed()
