"""What is uncertain, to first order: means and covariances of parameters and of starts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import KINDS
from symdyn.errors import quoted
from symdyn.scene import Scene
from symdyn.scene.values import Faults, suggestion
from symdyn.simulation import state_names
from symdyn.study.distributions import Distribution
from symdyn.study.varied import read_over

POINTS = 100_000
"""Probabilities that moments of a distribution are taken over: midpoints of as many equal parts."""

SYMMETRIC = 1e-9
"""Part of its largest entry by which a covariance may be unlike its transpose, or have a negative eigenvalue."""


@dataclass(frozen=True, eq=False)
class Spread:
    """What is uncertain.

    Attributes:
        names: parameters, positions and velocities at the start, shape (k,).
        means: of those that have one of their own, by name; others are as the scene says.
        covariance: shape (k, k).
    """

    names: tuple[str, ...]
    means: Mapping[str, float]
    covariance: Array

    def moved(self, scene: Scene) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
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
        over: texts "NAME=DISTRIBUTION"; or by name such a text, or a number, which is a standard deviation; nothing for
            all parameters that have a tolerance.
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
            faults.add(
                "covariance", f"is {len(found.covariance)} × {len(found.covariance)}, of {len(found.names)} names"
            )
    parameters = [one.name for one in scene.parameters]
    known = [*parameters, *(state_names(scene) if starts else ())]
    every = [*parameters, *state_names(scene)]
    for name in found.names:
        if name in every and name not in known:
            faults.add("over", f"{name} is given by the motion; only parameters can be uncertain there")
        elif name not in every and not (name in scene.coordinates or name in found.means):
            faults.add("over", f"{name} is no parameter, and no position or velocity; {suggestion(name, known)}")
        elif name not in every:
            faults.add("over", f"{name} cannot be moved by itself; {suggestion(name, known)}")
    return found if len(faults.lines) == before else None


def _independent(scene: Scene, over: Mapping[str, Any] | Iterable[str] | str, faults: Faults) -> Spread:
    """Return what is uncertain where nothing is correlated."""
    over = dict(over.items()) if hasattr(over, "items") else over  # a series of pandas has them, too
    spreads, texts = dict[str, float](), over if isinstance(over, str | Mapping) else tuple(over)
    if isinstance(over, Mapping):
        spreads = {str(name): float(x) for name, x in over.items() if KINDS["float"].takes(x)}
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
