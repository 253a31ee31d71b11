"""`uncertainty`: what is uncertain in parameters and starts, carried to motions and forces to first order.

    motion     x' = f(t, x, p)           variational equations at all samples (symdyn.simulation.variations)
    forces     τ = ID(q, u, u̇, p)        ∂ID/∂p along the motion, which is held (`inverse_dynamics_by_parameters`)

It takes one run and its derivatives where Monte Carlo takes thousands of runs. It is exact for what depends on the
uncertain in proportion, and blind to skewness, to means that move, and to what jumps: take `sweep` and `ensemble`.
`beside` puts both next to each other: they differ where it is not linear.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import sqrt
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import KINDS, with_fields
from symdyn.errors import SimulateError, quoted, suggestion
from symdyn.frozen import dataclass
from symdyn.scene import Scene, SceneLike, SceneUnits
from symdyn.scene.values import Faults
from symdyn.simulation import Problem, Run, Uncertainty, measure_slopes, state_names
from symdyn.simulation.prescribed import Entries, parameter_values, read_number
from symdyn.study.distributions import Distribution, read_over
from symdyn.study.runs import Runs

POINTS = 100_000
"""Probabilities that moments of a distribution are taken over: midpoints of as many equal parts."""

SYMMETRIC = 1e-9
"""Part of its largest entry by which a covariance may be unlike its transpose, or have a negative eigenvalue."""


@dataclass(frozen=True, eq=False)
class Spread:
    """What is uncertain."""

    names: tuple[str, ...]  # parameters, positions and velocities at the start, shape (k,)
    means: Mapping[str, float]  # of those that have one of their own, by name; others are as in the scene
    covariance: Array  # shape (k, k)

    def means_by_kind(self, scene: Scene) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
        """Return the means of parameters, of coordinates and of velocities at the start."""
        parameters = [one.name for one in scene.parameters]
        kinds: tuple[dict[str, float], ...] = ({}, {}, {})
        for name, mean in self.means.items():
            place = 0 if name in parameters else 2 if name in scene.velocities else 1
            kinds[place][name] = mean
        return kinds[0], kinds[1], kinds[2]


def moments(one: Distribution) -> tuple[float, float]:
    """Return mean and standard deviation of a distribution, those of its quantiles.

    >>> from symdyn.scene import example
    >>> low = read_over(example("pendulum"), "m=uniform(0, 6)", (), Faults(""))[0]
    >>> [round(x, 6) for x in moments(low)]
    [3.0, 1.732051]
    """
    values = one.values
    drawn = one.at((np.arange(POINTS) + 0.5) / POINTS) if values is None else values
    return float(drawn.mean()), float(drawn.std())


def read_spread(
    scene: Scene,
    over: Mapping[str, Any] | Iterable[str] | str,
    covariance: npt.ArrayLike | None,
    faults: Faults,
    starts: bool = True,
) -> Spread | None:
    """Return what is uncertain; None after a fault.

    Args:
        scene: the mechanism.
        over: texts "NAME=DISTRIBUTION"; or by name such a text, or a standard deviation, a number in SI or "1 g";
            nothing for all parameters that have a tolerance.
        covariance: shape (k, k); then `over` is k names.
        faults: takes what is wrong.
        starts: whether positions and velocities at the start may be uncertain.
    """
    before = len(faults.lines)
    if covariance is None:
        found = _independent(scene, over, faults)
    else:
        found = Spread(tuple([over] if isinstance(over, str) else over), {}, _covariance(covariance, faults))
        if len(found.covariance) != len(found.names):
            size = len(found.covariance)
            faults.add("covariance", f"is {size} × {size}, of {len(found.names)} names")
    parameters = [one.name for one in scene.parameters]
    known = [*parameters, *(state_names(scene) if starts else ())]
    every = [*parameters, *state_names(scene)]
    for name in found.names:
        if name in every and name not in known:
            faults.add("over", f"{name} is given by the motion; only parameters can be uncertain there")
        elif name not in every and not (name in scene.coordinates or name in found.means):
            told = f"{name} is no parameter, and no position or velocity; {suggestion(name, known)}"
            faults.add("over", scene.derived_words(name) or told)
        elif name not in every:
            faults.add("over", f"{name} cannot be moved by itself; {suggestion(name, known)}")
    return found if len(faults.lines) == before else None


def _independent(scene: Scene, over: Mapping[str, Any] | Iterable[str] | str, faults: Faults) -> Spread:
    """Return what is uncertain where nothing is correlated."""
    over = dict(over.items()) if hasattr(over, "items") else over  # a series of pandas has them, too
    spreads, texts = dict[str, float](), over if isinstance(over, str | Mapping) else tuple(over)
    if isinstance(over, Mapping):
        values, units = parameter_values(scene), SceneUnits(scene)
        for name, x in ((str(name), x) for name, x in over.items()):
            if KINDS["float"].takes(x) or (isinstance(x, str) and x[:1].isdigit() and x[-1:] != "%"):
                spreads[name] = read_number(x, values, f"over {name}", faults, units.letter(name), spread=True) or 0.0
        texts = {str(name): x for name, x in over.items() if str(name) not in spreads}
    for name, spread in spreads.items():
        if not (np.isfinite(spread) and spread >= 0):
            faults.add(f"over {name}", f"{spread:g} is no standard deviation; give one that is not negative")
    read = read_over(scene, texts, state_names(scene), faults) if texts or not spreads else ()
    told = {one.name: moments(one) for one in read}
    order = [name for name in over if name in told or name in spreads] if isinstance(over, Mapping) else list(told)
    sizes = [told[name][1] if name in told else spreads[name] for name in order]
    means = {name: told[name][0] for name in order if name in told}
    return Spread(tuple(order), means, np.diag(np.square(sizes)) if sizes else np.zeros((0, 0)))


def _covariance(given: npt.ArrayLike, faults: Faults) -> Array:
    try:
        found = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        faults.add("covariance", f"{quoted(given)} is no matrix of numbers")
        return np.zeros((0, 0))
    if found.ndim != 2 or found.shape[0] != found.shape[1] or not np.all(np.isfinite(found)):
        faults.add("covariance", f"has the shape {found.shape}; give a square matrix of finite numbers")
        return np.zeros((0, 0))
    size = float(np.abs(found).max(initial=0.0))
    if np.abs(found - found.T).max(initial=0.0) > SYMMETRIC * size:
        faults.add("covariance", "is not symmetric")
    elif len(found) and np.linalg.eigvalsh(found)[0] < -SYMMETRIC * size:
        faults.add("covariance", "has a negative eigenvalue, so that a combination would have a negative variance")
    return found


@with_fields(Problem)
def uncertainty(
    scene: SceneLike | Problem,
    over: Mapping[str, Any] | Iterable[str] | str = (),
    *,
    covariance: npt.ArrayLike | None = None,
    until: float | None = None,
    every: float | None = None,
    columns: str | Sequence[str] = (),
    motion: Entries | None = None,
    path: Entries = (),
    times: npt.ArrayLike = (),
    **fields: Unpack[Problem.Fields],
) -> Uncertainty:
    """Return standard deviations of a run's columns at all its samples, to first order.

    >>> import symdyn
    >>> found = symdyn.uncertainty(symdyn.example("cart_pole"), {"mp": 0.01, "theta": 0.02}, until=1)
    >>> found["x"].shape, float(found["sd_theta"][0])
    ((201,), 0.02)
    >>> along = symdyn.uncertainty(symdyn.example("cart_pole"), "mp=uniform(0.2, 0.3)",
    ...     motion=["x=t**2", "theta=0"], times=[0, 1], columns="F")
    >>> along["sd_F"].round(5).tolist()
    [0.05774, 0.05774]

    Args:
        scene: the mechanism, its parameters bound; or a `Problem`.
        over: what is uncertain: texts "NAME=DISTRIBUTION" as `sweep` takes them; or by name such a text, or a number,
            which is a standard deviation about the scene's value. A name is a parameter, or an independent position or
            velocity at the start; nothing for all parameters that have a tolerance. What has a distribution has its
            mean in the run.
        **fields: of `Problem`.
        covariance: of the names in `over`, shape (k, k), where they are correlated.
        until: time of the end of a run, s; None for 10.
        every: seconds between samples of a run; None for 200 of them.
        columns: names of columns or patterns; none for coordinates, velocities, outputs and driving forces.
        motion: laws of coordinates as `inverse` takes them: the motion is held, forces are uncertain, and no run is
            made: `until`, `start_rates` and `every` are refused.
        path: as for `inverse`.
        times: s, of the motion.
        start: coordinates at the start as for `simulate`; they are held where a parameter moves.

    Raises:
        SimulateError: with every fault of the arguments; forces that have no derivative; or a run that fails.
        SceneError: a value that the scene cannot have.
        UnknownNameError: a column that is none.
        DerivationError: there are no such dynamics.
    """
    problem, run = Problem.requested(uncertainty, locals())
    scene, faults = problem.scene, Faults("")
    if motion is None:
        unread = [name for name, given in (("path", path), ("times", times)) if np.asarray(given, dtype=object).size]
        faults.lines += [f"{name}: it belongs to a motion, and none is given; leave it out" for name in unread]
    else:
        given = {"start_rates": problem.start_rates, "until": until, "every": every}
        unread = [name for name, one in given.items() if one is not None]
        faults.lines += [f"{name}: it belongs to a run, and a motion is given; leave it out" for name in unread]
    spread = faults.taken(lambda: read_spread(scene, over, covariance, faults, starts=motion is None), None)
    faults.lines[:] = dict.fromkeys(faults.lines)
    faults.close(SimulateError)
    assert spread is not None, "what is missing is a fault"
    problem = problem.with_values(*spread.means_by_kind(scene))
    wanted = (columns,) if isinstance(columns, str) else tuple(columns)
    names, C = spread.names, spread.covariance
    if motion is not None:
        return Uncertainty.of_forces(problem, names, C, motion, path, times, wanted)
    return Uncertainty.of_run(problem, run, names, C, wanted)


NEAR = 0.1
"""Part by which two standard deviations may differ, beside what so few runs leave open."""


@dataclass(frozen=True)
class Beside:
    """The standard deviation of one measure, two ways."""

    measure: str  # its name
    first_order: float  # by derivatives
    runs: float  # of the runs that have a value
    shares: Mapping[str, float]  # which part of the former's square each name is to blame for
    near: bool  # whether they agree as far as so many runs can show


def beside(
    runs: Runs, problem: Problem, run: Run, over: Mapping[str, Any] | Iterable[str] | str, measures: Sequence[str]
) -> tuple[Beside, ...]:
    """Return the standard deviations of measures to first order beside those of runs of that problem and run.

    Other arguments are as of `sweep`; of the run only `until` and `every` are looked at.

    Raises:
        SimulateError: with every fault; or a measure without a value at the means.
    """
    scene, faults = problem.scene, Faults("")
    spread = faults.taken(lambda: read_spread(scene, over, None, faults), None)
    faults.close(SimulateError)
    assert spread is not None, "what is missing is a fault"
    named = [text.partition("=") for text in measures]
    names = [name.strip() for name, _, _ in named]
    formulas = [formula.strip() if equals else name for name, equals, formula in named]
    slopes = measure_slopes(problem.with_values(*spread.means_by_kind(scene)), run, formulas, spread.names)
    lacking = [name for name, row in zip(names, slopes, strict=True) if not np.all(np.isfinite(row))]
    if lacking:
        raise SimulateError(f"{scene.name}: to first order there is no value of {', '.join(lacking)}")
    told = []
    for name, row in zip(names, slopes, strict=True):
        parts = row * (spread.covariance @ row)
        first, many = sqrt(max(float(parts.sum()), 0.0)), runs.sd(name)
        shares = {
            one: float(part / parts.sum()) if first else 0.0 for one, part in zip(spread.names, parts, strict=True)
        }
        count = max(len(runs.known(name)), 2)
        near = abs(many - first) <= (NEAR + 3 / sqrt(2 * count)) * max(first, many)
        told.append(Beside(name, first, many, shares, near))
    return tuple(told)
