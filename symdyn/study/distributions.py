"""What a name is varied over: lists of values and distributions, a row of `DISTRIBUTIONS` each, read without `eval`.

    m1=linspace(1,2,100)  k=geomspace(1,100,5)  n=[1, 2, 5]                      lists
    m1=uniform(1,2)  k=normal(100, sigma=5)  k=lognormal(median=100,sigma=0.1)   distributions
    m1=tolerance(5 %)  m1=tolerance()            as the scene says a tolerance, or the one that it says

Arguments are formulas in parameters of the scene, by place or by name: `m1=normal(m1, 0.05*m1)`. Every distribution is
its quantile function, so that any design in the unit cube becomes values; a list takes its values with equal chance.
Inputs are independent of each other: correlated ones are no part of this grammar; declare what they share as a
parameter of its own, and vary that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from symdyn.algebra import Array

LONGEST_LIST = 10_000_000
"""Values that one list may have; they are held in memory."""

LEAST, MOST = 2.0**-54, 1 - 2.0**-53
"""Probabilities that quantiles are taken at: a normal distribution has none at 0 and at 1."""

Arguments = Mapping[str, float]


@dataclass(frozen=True)
class DistributionKind:
    """A way to vary a name.

    Attributes:
        keys: of its arguments, in their order; those with `defaults` may be left out.
        says: what it is, with its arguments, one line.
        values: the values of a list, from its arguments; None of a distribution.
        quantile: of a distribution, from probabilities and its arguments; None of a list.
        fault: what is wrong with arguments, "" for nothing.
        defaults: of arguments that may be left out.
        plain: of arguments that are numbers whatever the unit of what is varied.
    """

    keys: tuple[str, ...]
    says: str
    values: Callable[[Arguments], Array] | None = None
    quantile: Callable[[Array, Arguments], Array] | None = None
    fault: Callable[[Arguments], str] = lambda _: ""
    defaults: Arguments = ()  # type: ignore[assignment]
    plain: tuple[str, ...] = ()


def _counted(one: Arguments) -> str:
    if one["count"] != int(one["count"]) or not 1 <= one["count"] <= LONGEST_LIST:
        return f"count = {one['count']:g} is no number of values, 1 to {LONGEST_LIST}"
    return ""


def _geometric(one: Arguments) -> str:
    if not one["start"] * one["stop"] > 0:
        return f"it goes from {one['start']:g} to {one['stop']:g}; begin and end on the same side of zero"
    return _counted(one)


def _ordered(*keys: str) -> Callable[[Arguments], str]:
    def fault(one: Arguments) -> str:
        wrong = [(a, b) for a, b in pairwise(keys) if not one[a] <= one[b]]
        return "; ".join(f"{a} = {one[a]:g} is above {b} = {one[b]:g}" for a, b in wrong)

    return fault


def _above_zero(key: str, one: Arguments) -> str:
    return "" if one[key] > 0 else f"{key} = {one[key]:g} is not positive"


def _spread(one: Arguments) -> str:
    return "" if one["sigma"] >= 0 else f"sigma = {one['sigma']:g} is negative; give the standard deviation"


def _cut(one: Arguments) -> str:
    if spread := _spread(one):
        return spread
    if not one["low"] < one["high"]:
        return f"low = {one['low']:g} is not below high = {one['high']:g}"
    low, high = _share(_mirrored(one) if one["low"] > one["mean"] else one)
    if not high - low > 0:
        return f"nothing of it lies between low = {one['low']:g} and high = {one['high']:g}"
    return ""


def _share(one: Arguments) -> tuple[float, float]:
    """Return the probabilities below both ends of a normal distribution that is cut off in its lower half."""
    scale = max(one["sigma"], 1e-300) * math.sqrt(2)
    low, high = (0.5 * math.erfc((one["mean"] - one[key]) / scale) for key in ("low", "high"))
    return low, high


def _mirrored(one: Arguments) -> dict[str, float]:
    return {"mean": -one["mean"], "sigma": one["sigma"], "low": -one["high"], "high": -one["low"]}


def _normal(u: Array, one: Arguments) -> Array:
    from scipy.special import ndtri

    if one["low"] > one["mean"]:  # above the mean probabilities crowd below 1, where doubles have no digits left
        return np.asarray(-_normal(1 - u, _mirrored(one)))
    low, high = _share(one)
    found: Array = one["mean"] + one["sigma"] * ndtri(np.clip(low + u * (high - low), LEAST * high, MOST))
    return np.clip(found, one["low"], one["high"])


def _lognormal(u: Array, one: Arguments) -> Array:
    from scipy.special import ndtri

    return np.asarray(one["median"] * np.exp(one["sigma"] * ndtri(u)))


def _triangular(u: Array, one: Arguments) -> Array:
    low, mode, high = one["low"], one["mode"], one["high"]
    width = high - low
    if width == 0:
        return np.full_like(u, low)
    peak = (mode - low) / width
    rising = low + np.sqrt(u * width * (mode - low))
    return np.asarray(np.where(u < peak, rising, high - np.sqrt((1 - u) * width * (high - mode))))


DISTRIBUTIONS: Mapping[str, DistributionKind] = {
    "linspace": DistributionKind(
        ("start", "stop", "count"),
        "count values from start to stop, evenly",
        lambda one: np.linspace(one["start"], one["stop"], int(one["count"])),
        fault=_counted,
        plain=("count",),
    ),
    "geomspace": DistributionKind(
        ("start", "stop", "count"),
        "count values from start to stop, each the same multiple of the last",
        lambda one: np.geomspace(one["start"], one["stop"], int(one["count"])),
        fault=_geometric,
        plain=("count",),
    ),
    "logspace": DistributionKind(
        ("start", "stop", "count"),
        "the same from 10**start to 10**stop",
        lambda one: np.logspace(one["start"], one["stop"], int(one["count"])),
        fault=_counted,
        plain=("start", "stop", "count"),
    ),
    "uniform": DistributionKind(
        ("low", "high"),
        "any value between low and high alike",
        quantile=lambda u, one: np.asarray(one["low"] + u * (one["high"] - one["low"])),
        fault=_ordered("low", "high"),
    ),
    "loguniform": DistributionKind(
        ("low", "high"),
        "any order of magnitude between low and high alike",
        quantile=lambda u, one: np.asarray(one["low"] * (one["high"] / one["low"]) ** u),
        fault=lambda one: _above_zero("low", one) or _ordered("low", "high")(one),
    ),
    "normal": DistributionKind(
        ("mean", "sigma", "low", "high"),
        "a normal distribution; nothing outside low and high, where they are given",
        quantile=_normal,
        fault=_cut,
        defaults={"low": -math.inf, "high": math.inf},
    ),
    "lognormal": DistributionKind(
        ("median", "sigma"),
        "log(value / median) is normal with standard deviation sigma",
        quantile=_lognormal,
        fault=lambda one: _above_zero("median", one) or _spread(one),
        plain=("sigma",),
    ),
    "triangular": DistributionKind(
        ("low", "mode", "high"),
        "between low and high, most often at mode",
        quantile=_triangular,
        fault=_ordered("low", "mode", "high"),
    ),
}
"""By the word that is written. A list in square brackets, `[1, 2, 5]`, is a list of values as it stands."""


@dataclass(frozen=True)
class Distribution:
    """What one name is varied over.

    Attributes:
        name: of a parameter, a coordinate or a velocity at the start, or a letter of a force.
        text: as a user writes it, behind the name.
        kind: a key of `DISTRIBUTIONS`; "" of a list as it stands.
        arguments: of the kind, by key.
        listed: values of a list as it stands.
    """

    name: str
    text: str
    kind: str = ""
    arguments: tuple[tuple[str, float], ...] = ()
    listed: tuple[float, ...] = ()

    @property
    def values(self) -> Array | None:
        """The values of a list, shape (n,); None of a distribution."""
        if not self.kind:
            return np.array(self.listed)
        listed = DISTRIBUTIONS[self.kind].values
        return None if listed is None else listed(dict(self.arguments))

    def at(self, u: Array) -> Array:
        """Return the quantiles of probabilities in [0, 1), shape (n,); of a list each value with equal chance."""
        if (values := self.values) is not None:
            return np.asarray(values[np.minimum((u * len(values)).astype(np.int64), len(values) - 1)])
        quantile = DISTRIBUTIONS[self.kind].quantile
        assert quantile is not None, "what is no list is a distribution"
        return quantile(np.clip(u, LEAST, MOST), dict(self.arguments))
