"""What a name is varied over: lists of values and distributions, a row of `DISTRIBUTIONS` each, read without `eval`.

    m1=linspace(1,2,100)  k=geomspace(1,100,5)  n=[1, 2, 5]                      lists
    m1=uniform(1,2)  k=normal(100, sigma=5)  k=lognormal(median=100,sigma=0.1)   distributions
    m1=tolerance(5 %)  m1=tolerance()            a tolerance as in the scene, or the scene's own

Arguments are formulas in parameters of the scene, by place or by name: `m1=normal(m1, 0.05*m1)`. Every distribution is
its quantile function, so that any design in the unit cube becomes values; a list takes its values with equal chance.
Inputs are independent of each other: correlated ones are no part of this grammar; declare what they share as a
parameter of its own, and vary that.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.errors import suggestion
from symdyn.frozen import dataclass
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import Faults, FormulaError, Letter, Parameter, question, read_tolerance, shorten, split_commas
from symdyn.simulation.prescribed import read_number

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
        description: what it is, with its arguments, one line.
        values: the values of a list, from its arguments; None of a distribution.
        quantile: of a distribution, from probabilities and its arguments; None of a list.
        fault: what is wrong with arguments, "" for nothing.
        defaults: of arguments that may be left out.
        plain: of arguments that are numbers whatever the unit of what is varied.
    """

    keys: tuple[str, ...]
    description: str
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
    """What one name is varied over."""

    name: str  # of a parameter, a coordinate or a velocity at the start, or a symbol in a force
    text: str  # as a user writes it, behind the name
    kind: str = ""  # a key of `DISTRIBUTIONS`; "" of a list as it stands
    arguments: tuple[tuple[str, float], ...] = ()  # of the kind, by key
    listed: tuple[float, ...] = ()  # values of a list as it stands

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


Over = Mapping[str, Any] | Iterable[str] | str

TOLERANCE = "tolerance"

FORMS = "; ".join([*(f"{name}({','.join(kind.keys)})" for name, kind in DISTRIBUTIONS.items()), f"{TOLERANCE}(5 %)"])
"""What a name may be varied over beside a list."""

PLAIN = Parameter("", unit="1")
"""What an argument is of that is not in the unit of what is varied."""

FORM = 'write such as "m1=linspace(1,2,5)", "k=lognormal(median=10,sigma=0.1)" or "n=[1, 2, 5]"'

_CALL = re.compile(r"(?P<kind>[A-Za-z]\w*)\s*\((?P<inside>.*)\)\Z", re.DOTALL)
_NAMED = re.compile(r"(?P<key>[A-Za-z]\w*)\s*=(?!=)(?P<text>.*)\Z", re.DOTALL)
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")


def read_over(scene: Scene, over: Over, letters: Iterable[str], faults: Faults) -> tuple[Distribution, ...]:
    """Return what names are varied over, in their order.

    Args:
        scene: whose parameters arguments may name; those with a tolerance are what is varied where nothing is given.
        over: texts "NAME=DISTRIBUTION"; or by name a text, a number, a list or array of numbers, a `Distribution`.
        letters: that may be varied beside parameters, coordinates and velocities.
        faults: takes what is wrong.
    """
    there = (*(one.name for one in scene.parameters), *scene.coordinates, *scene.first_order, *letters)
    found: dict[str, Distribution] = {}
    pairs = _pairs(over, faults)
    if not pairs and not faults.lines:
        pairs = [(one.name, f"{TOLERANCE}()") for one in scene.parameters if one.tolerance]
        if not pairs:
            faults.add("over", f"nothing is varied, and no parameter of {scene.name} has a tolerance; {FORM}")
    for name, said in pairs:
        if name in found:
            faults.add("over", f"{name} is given twice, as {found[name].text} and as {shorten(str(said))}")
            continue
        if name not in there:
            faults.add("over", scene.derived_words(name) or f"{name} is not known; {suggestion(name, there)}")
        one = said if isinstance(said, Distribution) else _read(scene, name, said, faults)
        if one is not None:
            found[name] = one
    return tuple(found.values())


def check_unbound(over: Over, given: Mapping[str, object] | None, faults: Faults) -> None:
    """Tell of names that are varied and given one value too, which their distributions do not name."""
    for name, said in _pairs(over, Faults("")):
        if given is not None and name in given and not re.search(rf"\b({name}|{TOLERANCE})\b", str(said)):
            faults.add(argument("values"), f"{name} is varied; leave it out here")


def _pairs(over: Over, faults: Faults) -> list[tuple[str, Any]]:
    if isinstance(over, Mapping):
        return [(str(name), said) for name, said in over.items()]
    found: list[tuple[str, Any]] = []
    listed = [split_commas(str(one)) for one in ([over] if isinstance(over, str) else over)]
    for text in [part for some in listed for part in (some if all("=" in one for one in some) else [",".join(some)])]:
        name, equals, said = (part.strip() for part in str(text).partition("="))
        if equals and said and _NAME.match(name):
            found.append((name, said))
        else:
            faults.add("over", f'"{text}" names nothing that is varied; {FORM}')
    return found


def _read(scene: Scene, name: str, specified: Any, faults: Faults) -> Distribution | None:
    where = f"over {name}"
    values = {one.name: one.value for one in scene.parameters if one.value is not None}
    letter = SceneUnits(scene).letter(name)
    if not isinstance(specified, str):
        return _listed(letter, specified, faults)
    if specified.startswith("[") and specified.endswith("]"):
        numbers = [read_number(part, values, where, faults, letter) for part in split_commas(specified[1:-1])]
        if not numbers:
            faults.add(where, f"{specified} lists nothing; {FORM}")
        known = [one for one in numbers if one is not None]
        return Distribution(name, specified, listed=tuple(known)) if known and len(known) == len(numbers) else None
    call = _CALL.match(specified)
    if call is not None and call["kind"] == TOLERANCE:
        return _toleranced(scene, name, call["inside"].strip(), faults)
    if call is None or call["kind"] not in DISTRIBUTIONS:
        there = (*DISTRIBUTIONS, TOLERANCE)
        near = suggestion(call["kind"], there) if call else f"{FORM}; {suggestion('', there)}"
        if specified[:1].isdigit() and specified[-1:] == "%":
            near = f'write "tolerance({specified})" or "normal({name}, {specified[:-1]}/100*{name})"'
        faults.add(where, f'"{specified}" is no list of values and no distribution; {near}')
        return None
    kind = DISTRIBUTIONS[call["kind"]]
    arguments = _arguments(call["kind"], split_commas(call["inside"]), values, where, faults, letter)
    if arguments is None:
        return None
    if fault := kind.fault(arguments):
        faults.add(where, f"{specified}: {fault}")
        return None
    found = Distribution(name, specified, call["kind"], tuple(arguments.items()))
    with np.errstate(all="ignore"):
        if (listed := found.values) is not None and not np.isfinite(listed).all():
            faults.add(where, f"{specified}: a value is beyond the largest double, 1.8e308; make them smaller")
            return None
    return found


def _toleranced(scene: Scene, name: str, specified: str, faults: Faults) -> Distribution | None:
    """Return what a tolerance means of the value that a parameter has: the one that is given, or the scene's own."""
    where = f"over {name}"
    parameter = next((one for one in scene.parameters if one.name == name), None)
    if parameter is None:
        faults.add(where, f"{name} is no parameter, and a tolerance is of one; write uniform(low, high)")
        return None
    try:
        if specified and (asked := question(parameter, specified.removeprefix("±"))):
            faults.add(where, asked)
            return None
        tolerance = read_tolerance(specified, parameter.unit) if specified else parameter.tolerance
    except FormulaError as error:
        faults.add(where, f"tolerance({specified}) {error}")
        return None
    if tolerance is None or parameter.value is None:
        what = "tolerance" if tolerance is None else "value that it could be off from"
        faults.add(
            where,
            f"{name} has no {what}; give it, such as tolerance(5 %)"
            if tolerance is None
            else f"{name} has no {what}; give it one, as in {argument('values', {name: 1})}",
        )
        return None
    value = float(parameter.value.at({}) or 0)
    size, text = tolerance.size(value, parameter.unit), f"{TOLERANCE}({tolerance.text})"
    if size == 0:
        faults.add(where, f"{tolerance.text} of {name} = 0 is nothing; give the deviation in its unit, such as 0.01")
        return None
    if parameter.positive and not tolerance.sigma and value - size <= 0:
        faults.add(where, f"{text} reaches down to {value - size:g}, and {name} is positive; make it smaller")
        return None
    if tolerance.sigma:
        return Distribution(
            name,
            f"normal({value!r},{size!r})",
            "normal",
            (("mean", value), ("sigma", size), ("low", -math.inf), ("high", math.inf)),
        )
    return Distribution(
        name, f"uniform({value - size!r},{value + size!r})", "uniform", (("low", value - size), ("high", value + size))
    )


def middle(given: Any) -> Any:
    """Return the one of numbers that stands for all where a unit is asked for; what is no array as it is."""
    return np.sort(given, axis=None)[np.size(given) // 2] if np.ndim(given) and np.size(given) else given


def _listed(letter: Letter, specified: Any, faults: Faults) -> Distribution | None:
    try:
        numbers = np.asarray(specified, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        faults.add(f"over {letter.name}", f"{shorten(repr(specified))} is no list of numbers; {FORM}")
        return None
    if numbers.ndim > 1 or not numbers.size or not np.all(np.isfinite(numbers)):
        why = "is empty" if not numbers.size else "is no list" if numbers.ndim > 1 else "holds what is not finite"
        faults.add(f"over {letter.name}", f"the array {why}; give finite numbers, shape (n,)")
        return None
    if asked := question(letter, middle(numbers)):
        faults.add(f"over {letter.name}", asked)
    listed = tuple(np.atleast_1d(numbers).tolist())
    return Distribution(letter.name, shorten(str(list(listed))), listed=listed)


def _arguments(
    called: str, parts: Sequence[str], values: Mapping[str, Quantity], where: str, faults: Faults, letter: Letter
) -> dict[str, float] | None:
    """Return arguments by key, in the order of the kind; None after a fault."""
    kind, texts, before = DISTRIBUTIONS[called], dict[str, str](), len(faults.lines)
    form = f"{called}({', '.join(kind.keys)}): {kind.description}"
    for place, part in enumerate(parts):
        named = _NAMED.match(part)
        key = named["key"] if named else kind.keys[place] if place < len(kind.keys) else ""
        if not key or key not in kind.keys:
            faults.add(where, f"{part} is no argument of {form}")
        elif key in texts:
            faults.add(where, f"{key} is given twice, as {texts[key]} and as {part}; {form}")
        else:
            texts[key] = named["text"] if named else part
    missing = [key for key in kind.keys if key not in texts and key not in dict(kind.defaults)]
    if missing:
        faults.add(where, f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing; {form}")
    if letter.written and set(kind.plain) >= set(kind.keys):
        faults.add(where, f"{letter.name} is given in {letter.written}, and {form}; write geomspace with units")
    found = {
        key: read_number(text, values, where, faults, PLAIN if key in kind.plain else letter)
        for key, text in texts.items()
    }
    if len(faults.lines) > before:
        return None
    return {key: value for key in kind.keys if (value := found.get(key, dict(kind.defaults).get(key))) is not None}
