"""What a controller is: a law of time and state, what it drives, and how often, how late and how far.

    τ = law(t, q, u)                         all the time, where there is no period
    τ = law(k T, q(k T), u(k T))             at sample times k T; held from k T + delay until the next one comes

A force beyond its limits is cut there. Forces prescribed beside it are added behind the cut.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import Any, TypeAlias

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Faults, ask_for_units
from symdyn.simulation.feedback.gains import Gains, gains_from, read_gains
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

    `limits` are formulas in parameters, largest sizes of forces by name, told as of --limits.

    Raises:
        SimulateError: with every fault, one line each.
    """
    values, units, faults, most = parameter_values(scene), SceneUnits(scene).letters, Faults(""), {}
    with faults.noted():
        ask_for_units(scene.inputs, limits.items(), "--limits")
    for name, text in limits.items():
        formula = read_formula(text, values, f"--limits: {name}", faults, unit=units.get(name, ""))
        if formula is not None:
            most[name] = number_of(formula, values, f"--limits: {name}", faults)
    faults.close(SimulateError)
    more: dict[str, Any] = {"period": period, "delay": delay, "limits": most or None}
    found = replace(read_feedback(scene, file), **{name: x for name, x in more.items() if x is not None})
    placed(scene, found, until)
    return found
