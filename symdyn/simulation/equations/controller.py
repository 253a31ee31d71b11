"""Controllers: a law of time and state, the forces that it drives, its period, delay and limits.

    τ = law(t, q, u)                         all the time, where there is no period
    τ = law(k T, q(k T), u(k T))             at sample times k T; held from k T + delay until the next one comes

A force beyond its limits is cut there, and forces prescribed beside it are added behind the cut. A run reports which
force was cut, at which limit, from when until when. A force that is held is cut from one sample to the next, or not.
One that acts all the time is tested inside every step, and the time at which it passes a limit is found by bisection,
for it may jump.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.errors import SimulateError
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Faults, ask_for_units
from symdyn.simulation.equations.linear_feedback import Gains, gains_from, read_gains
from symdyn.simulation.prescribed.forces import ForceFunction, force_names, force_units, place_of, places_of
from symdyn.simulation.prescribed.formulas_in_time import number_of, parameter_values, read_formula

Law: TypeAlias = Callable[[float, Array, Array], Any]

Said: TypeAlias = "Feedback | Gains | Law | Mapping[str, object] | str | Path"
"""What a controller may be given as."""

LARGEST = 1e7
"""Samples of one run at most."""


@dataclass(frozen=True)
class Feedback:
    """A controller.

    Attributes:
        law: of time, s, coordinates, shape (nq,), and velocities, shape (nv,): the force of every input, shape
            (inputs,), N or N m; a number where there is one input. `Gains` are such a law. Without a period it is asked
            at states that are tried and dropped too, back and forth in time, and must keep nothing; with one it is
            asked once a sample, in order.
        inputs: what it drives, by the names that forces have; () are all drives but those of prescribed motions, and
            where there is none all inputs.
        period: seconds between samples; None is none, the law holds all the time.
        delay: seconds from a sample to its force, whole periods or not; until the first one the force is `initial`.
        limits: largest size, or smallest and largest value, by input.
        initial: forces before the first sample acts, shape (inputs,); () are zeros, or those where gains begin.
    """

    law: Law
    inputs: tuple[str, ...] = ()
    period: float | None = None
    delay: float = 0.0
    limits: Mapping[str, float | Sequence[float]] = field(default_factory=dict)
    initial: Sequence[float] = ()


@dataclass(frozen=True)
class Placed:
    """A controller in its scene.

    Attributes:
        feedback: its law, period and delay.
        names: of the inputs.
        units: of their forces.
        places: index of the velocity of every input, shape (m,).
        least, most: what every force is cut at, shape (m,).
        initial: shape (m,).
        title: what the law is called in messages.
    """

    feedback: Feedback
    names: tuple[str, ...]
    units: tuple[str, ...]
    places: tuple[int, ...]
    least: tuple[float, ...]
    most: tuple[float, ...]
    initial: tuple[float, ...]
    title: str = "feedback: the controller"


def read_feedback(scene: Scene, what: Said) -> Feedback:
    """Return the controller that something says: a law, gains, a .json file of gains or what that holds.

    Raises:
        SimulateError: with every fault of a file or mapping, one line each; or it is none of these.
    """
    if isinstance(what, Feedback):
        return what
    if isinstance(what, (str, Path)):
        gains, more = read_gains(scene, Path(what))
    elif isinstance(what, Mapping):
        gains, more = gains_from(scene, what, "feedback")
    elif isinstance(what, Gains):
        gains, more = what, {}
    elif callable(what):
        return Feedback(what)
    else:
        raise SimulateError(f"feedback: {what!r} is no controller; give a function of (t, q, u), gains or a .json file")
    return Feedback(gains, gains.inputs, **more)


def placed(scene: Scene, feedback: Feedback, until: float) -> Placed:
    """Return a controller in its scene.

    Raises:
        SimulateError: with every fault, one line each.
    """
    faults, places = Faults(""), places_of(scene)
    said = feedback.inputs or getattr(feedback.law, "inputs", ())  # gains name their own
    asked = (said,) if isinstance(said, str) else tuple(said)
    letters = tuple(one.name for one in scene.inputs)
    drives = tuple(one for one in scene.drives if one and place_of(scene, places, one, "", Faults("")) is not None)
    names = asked or drives or letters
    found = [place_of(scene, places, name, "feedback: inputs", faults) for name in names]
    if not names:
        faults.add("feedback", f"{scene.name} has no drive; give a joint one")
    for k in {k for k in found if k is not None and found.count(k) > 1}:
        faults.add("feedback: inputs", f"{force_names(scene)[k]} is named twice")
    _check_times(feedback, until, faults)
    initial = tuple(map(float, feedback.initial)) or getattr(feedback.law, "initial", ()) or (0.0,) * len(names)
    if len(initial) != len(names) or not all(map(math.isfinite, initial)):
        faults.add("feedback: initial", f"{list(initial)} are not {len(names)} finite numbers, one an input")
    ranges = _ranges(feedback, names, faults)
    faults.close(SimulateError)
    least, most = zip(*(ranges[name] for name in names), strict=True)
    at, units = tuple(k for k in found if k is not None), force_units(scene)
    return Placed(feedback, names, tuple(units[k] for k in at), at, least, most, initial)


def placed_function(scene: Scene, function: ForceFunction, until: float) -> Placed:
    """Return a function that forces are given by as what acts all the time."""
    found = placed(scene, Feedback(function.of, function.names), until)
    return replace(found, title=f"{function.where}: the function")


def _check_times(feedback: Feedback, until: float, faults: Faults) -> None:
    period, delay = feedback.period, feedback.delay
    for name, value in (("period", period), ("delay", delay)):
        if not (isinstance(value, Real) or (name == "period" and value is None)):
            faults.add(f"feedback: {name}", f"{value!r} is no number of seconds")
            return
    if not (math.isfinite(delay) and delay >= 0):
        faults.add("feedback: delay", f"{delay:g} s is no delay; give 0 or more")
    elif period is None and delay > 0:
        faults.add(
            "feedback: delay",
            f"{delay:g} s without a period would be a differential equation with delay; give a period too",
        )
    if period is not None and not (math.isfinite(period) and period > 0):
        faults.add("feedback: period", f"{period:g} s is no period; give one above 0")
    elif period is not None and until > LARGEST * period:
        faults.add("feedback: period", f"{period:g} s makes more than {LARGEST:g} samples until {until:g} s")


def _ranges(feedback: Feedback, names: Sequence[str], faults: Faults) -> dict[str, tuple[float, float]]:
    """Return smallest and largest value by input."""
    found = dict.fromkeys(names, (-math.inf, math.inf))
    if not isinstance(feedback.limits, Mapping):
        faults.add("feedback: limits", f"{feedback.limits!r} is no table of sizes by input, such as {{'F': 5}}")
        return found
    for name, limit in feedback.limits.items():
        where = f"feedback: limits: {name}"
        if name not in found:
            faults.add(where, f"is no input of the controller; it has {', '.join(names)}")
            continue
        try:
            ends = (-float(limit), float(limit)) if isinstance(limit, Real) else limit
            least, most = map(float, ends)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            least = most = math.nan
        if not least < most:
            faults.add(where, f"{limit} is neither a size above 0 nor [smallest, largest]")
        else:
            found[name] = (least, most)
    return found


def feedback_of(
    scene: Scene,
    file: str,
    period: float | None,
    delay: float | None,
    limits: Mapping[str, str],
    until: float,
) -> Feedback:
    """Return the controller of a file, with other times and limits; what is None or nothing stays as it is there.

    `limits` are formulas in parameters, largest sizes of forces by name, told as of `limits`.

    Raises:
        SimulateError: with every fault, one line each.
    """
    values, units, faults, most = parameter_values(scene), SceneUnits(scene).letters, Faults(""), {}
    with faults.noted():
        ask_for_units(scene.inputs, limits.items(), argument("limits"))
    for name, text in limits.items():
        formula = read_formula(text, values, f"{argument('limits')}: {name}", faults, unit=units.get(name, ""))
        if formula is not None:
            most[name] = number_of(formula, values, f"{argument('limits')}: {name}", faults)
    faults.close(SimulateError)
    more: dict[str, Any] = {"period": period, "delay": delay, "limits": most or None}
    found = replace(read_feedback(scene, file), **{name: x for name, x in more.items() if x is not None})
    placed(scene, found, until)
    return found


Sides = npt.NDArray[np.int_]
"""Of every force: -1 where it is cut at its least value, 1 where at its most, else 0; shape (m,)."""

LOOKS = np.arange(1, 5) / 4
"""Where in a step a force is looked at that acts all the time, over its length."""

CLOSE = 1e-12
"""Part of a time, or of a second, to which it is narrowed down."""


@dataclass(frozen=True)
class Saturation:
    """A time in which a controller asked for more than a limit allows, and got the limit.

    Attributes:
        name: of the force or input.
        limit: what it was cut at.
        unit: of the limit, "" where it is not known.
        begin, end: from when until when, s.
    """

    name: str
    limit: float
    unit: str
    begin: float
    end: float

    @property
    def words(self) -> str:
        """It in a line."""
        limit = f"{self.limit:g} {self.unit}".rstrip()
        return f"{self.name} is at its limit {limit} from t = {self.begin:.9g} s to t = {self.end:.9g} s"


class Cuts:
    """What is kept of a run in which forces are cut.

    Attributes:
        sides: where they are now.
    """

    def __init__(
        self, names: Sequence[str], units: Sequence[str], least: Sequence[float], most: Sequence[float]
    ) -> None:
        """Take the names of forces, their units and their limits, shape (m,)."""
        self.names, self.units = tuple(names), tuple(units)
        self.least, self.most = np.array(least), np.array(most)
        self.limited = bool(np.isfinite(self.least).any() or np.isfinite(self.most).any())
        self.sides: Sides = np.zeros(len(self.names), dtype=int)
        self._since = np.zeros(len(self.names))
        self._ended: list[Saturation] = []

    def of(self, values: Array) -> Sides:
        """Return on which sides of their limits forces are, shape (m,)."""
        found: Sides = (values > self.most).astype(int) - (values < self.least).astype(int)
        return found

    def change(self, t: float, sides: Sides) -> None:
        """Take note of where forces are from a time on."""
        for k in np.flatnonzero(sides != self.sides):
            self._ended += self._open(int(k), t)
            self._since[k] = t
        self.sides = sides

    def look(self, t0: float, t1: float, requested: Callable[[float], Array]) -> None:
        """Look at forces that act all the time, from a time on at which they were looked at, to a later one."""
        before = t0
        for t in map(float, t0 + (t1 - t0) * LOOKS):
            sides = self.of(requested(t))
            while (sides != self.sides).any():
                k = int(np.flatnonzero(sides != self.sides)[0])
                before, changed = self._narrowed(k, before, t, sides, requested)
                self.change(before, changed)
            before = t

    def _narrowed(
        self, k: int, low: float, high: float, sides: Sides, requested: Callable[[float], Array]
    ) -> tuple[float, Sides]:
        """Return when one of the forces leaves the side on which it is at a time, and where all are then."""
        while high - low > CLOSE * max(1.0, high):
            middle = (low + high) / 2
            found = self.of(requested(middle))
            if found[k] == self.sides[k]:
                low = middle
            else:
                high, sides = middle, found
        return float(high), np.where(np.arange(len(sides)) == k, sides, self.sides)

    def until(self, end: float) -> tuple[Saturation, ...]:
        """Return what there was until a time, in order of time."""
        found = [*self._ended, *(one for k in range(len(self.names)) for one in self._open(k, end))]
        kept = [replace(one, end=min(one.end, end)) for one in found if one.begin < end]
        return tuple(sorted(kept, key=lambda one: one.begin))

    def _open(self, k: int, end: float) -> list[Saturation]:
        """Return the time that ends at a time, nothing where the force is inside its limits."""
        side, begin = int(self.sides[k]), float(self._since[k])
        limit = float((self.most if side > 0 else self.least)[k])
        return [Saturation(self.names[k], limit, self.units[k], begin, end)] if side and end > begin else []


MOST = 20
"""Times that are listed for a reader; a controller may chatter."""


def cut_lines(saturations: Sequence[Saturation]) -> list[str]:
    """Return lines that list such times, the first of many."""
    more = len(saturations) - MOST
    lines = [one.words for one in saturations[:MOST]]
    return [*lines, f"and {more} more, which {argument('json', True, 'run.saturations')} lists"] if more > 0 else lines


def saturation_report(cuts: Cuts, end: float) -> list[str]:
    """Return what is said of every limited force: for which share of the time it was cut, how often, first when."""
    found, lines = cuts.until(end), []
    for name, of, *ends in zip(cuts.names, cuts.units, cuts.least.tolist(), cuts.most.tolist(), strict=True):
        unit = f" {of}" if of else ""
        at = [limit for limit in ends if any(one.name == name and one.limit == limit for one in found)]
        for limit in at:
            these = [one for one in found if one.name == name and one.limit == limit]
            share = 100 * sum(one.end - one.begin for one in these) / end
            often = "" if len(these) == 1 else f", {len(these)} times, the first"
            lines.append(
                f"{name} saturates at its limit {limit:g}{unit} for {share:.3g} % of the time{often} from "
                f"t = {these[0].begin:.6g} s to {these[0].end:.6g} s"
            )
        if not at and np.isfinite(ends).any():
            lines.append(f"{name} never reaches its limits, {ends[0]:g} to {ends[1]:g}{unit}")
    return lines
