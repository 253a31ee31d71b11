"""Controllers: a law of time and state, the forces that it drives, its period, delay and limits.

    τ = law(t, q, u)                         all the time, where there is no period
    τ = law(k T, q(k T), u(k T))             at sample times k T; held from k T + delay until the next one comes

A law may have states of its own, as a linear one between measured signals and forces has (`linear_law`).

A force beyond its limits is cut there, and forces prescribed beside it are added behind the cut.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral, Real
from pathlib import Path
from types import FunctionType
from typing import Any, TypeAlias

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, check_arguments, is_function, suggesting
from symdyn.errors import SimulateError, quoted
from symdyn.frozen import dataclass, field, fields, replace
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Faults, Parameter, velocity_name
from symdyn.shown import Shown
from symdyn.simulation.equations.linear_feedback import Gains, Schedule, gains_from, read_gains, state_names
from symdyn.simulation.equations.linear_law import (
    LinearLaw,
    Signals,
    by_signal,
    matrices_of,
    names_of,
    numbers_by_signal,
)
from symdyn.simulation.prescribed.forces import ForceFunction, force_names, force_units, place_of, places_of
from symdyn.simulation.prescribed.formulas_in_time import in_seconds, parameter_values, read_range
from symdyn.simulation.prescribed.motion_laws import Law as MotionLaw, read_function, read_law, required_arguments

Law: TypeAlias = Callable[[float, Array, Array], Any]
Size: TypeAlias = float | str | Sequence[float | str]

LARGEST = 1e7
"""Samples of one run at most."""


@suggesting
@dataclass(frozen=True, repr=False)
class Feedback(Shown):
    """A controller.

    >>> import symdyn
    >>> hold = symdyn.Feedback(lambda t, q, u: 40 * q[1] + 6 * u[1] + 3 * u[0], "F", period=0.01, limits={"F": 10})
    >>> run = symdyn.simulate(symdyn.example("cart_pole"), until=1, start={"theta": 0.1}, feedback=hold)
    >>> bool(abs(run["F"]).max() <= 10)
    True

    Attributes:
        law: of time, s, coordinates, shape (nq,), and velocities, shape (nv,): the force of every input, shape
            (inputs,), N or N m; a number where there is one input. Without a period it is asked at states that are
            tried and dropped too, back and forth in time, and must keep nothing; with one it is asked once a sample, in
            order. Or gains, a matrix K, a linear system or what has a method `feedback`, as `simulate` takes them.
        inputs: what it drives, by the names that forces have; () are all drives but those of prescribed motions, and
            where there is none all inputs.
        period: seconds between samples, or "10 ms"; None is none, the law holds all the time.
        delay: seconds from a sample to its force, whole periods or not; until the first one the force is `initial`.
        limits: largest size, "500 N*mm" too, or smallest and largest value, by input; of one without its name, too.
        initial: forces before the first sample acts, shape (inputs,); () are zeros, or those where gains begin.
        measures: what a linear system measures: names or formulas of coordinates, velocities, points and outputs; ()
            are the names of its own inputs, else outputs of the scene, or coordinates, if they are as many.
        reference: what each measured signal is to be, by its name: a number, or a formula in t and in what can be
            measured; one for all where there is one signal; else where the system was found. Of gains, where
            coordinates and velocities are to be: numbers, or formulas or functions of t, whose rates are led too.
        noise: standard deviation of what is added to a measured signal at every sample, by its name, "0.1 deg"; of a
            function or gains coordinates and velocities are measured. Normal, independent from sample to sample.
        seed: of the noise; the same, the same run.
        quantisation: steps to which measured signals are rounded at every sample, by name.
    """

    law: Any
    inputs: Sequence[str] = ()
    period: float | None = None
    delay: float = 0.0
    limits: Mapping[str, Size] | Size = field(default_factory=dict)
    initial: Sequence[float] = ()
    measures: Sequence[str] = ()
    reference: Mapping[str, object] | str | float | None = None
    noise: Mapping[str, float | str] = field(default_factory=dict)
    seed: int = 0
    quantisation: Mapping[str, float | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Take one name as several; SimulateError of what is no names, and of times and limits of no controller."""
        names = {name: getattr(self, name) for name in ("inputs", "measures")}
        check_arguments(Feedback, names, SimulateError)
        found: dict[str, Any] = {name: (one,) if isinstance(one, str) else tuple(one) for name, one in names.items()}
        found |= in_seconds({name: getattr(self, name) for name in ("period", "delay")})
        for name, one in found.items():
            object.__setattr__(self, name, one)
        faults, said, one = Faults(""), self.limits, (*found["inputs"], "the force")[0]
        limits = said if isinstance(said, Mapping) else {one: said}
        _ranges({k: one for k, one in limits.items() if _in_numbers(one)}, tuple(limits), faults)
        read = isinstance(self.law, Gains | Schedule | LinearLaw)  # and looked at in their scene
        alone = isinstance(self.law, FunctionType | np.ndarray | Sequence) or getattr(self.law, "period", "") is None
        if not read and (alone or self.period is not None):
            _check_times(self, 0.0, faults)
        faults.close(SimulateError)

    def __repr__(self) -> str:
        settings = "".join(f", {name} = {value!r}" for name, value in self.given.items())
        return f"<Feedback by {getattr(self.law, '__name__', type(self.law).__name__)}{settings}>"

    @property
    def given(self) -> dict[str, Any]:
        """What differs from what is usual, the law aside."""
        usual = Feedback(None)
        names = [one.name for one in fields(self) if one.name != "law"]
        pairs = {name: (getattr(self, name), getattr(usual, name)) for name in names}
        return {name: x for name, (x, y) in pairs.items() if type(x) is not type(y) or x != y}


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
        signals: what a linear law measures; None of others, which are told the state.
        labels: what columns call what is measured: its signals, or coordinates and velocities; shape (p,).
        noise: their standard deviations, shape (p,).
        steps: of their quantisation, 0 for none, shape (p,).
        title: what the law is called in messages.
    """

    feedback: Feedback
    names: tuple[str, ...]
    units: tuple[str, ...]
    places: tuple[int, ...]
    least: tuple[float, ...]
    most: tuple[float, ...]
    initial: tuple[float, ...]
    signals: Signals | None = None
    labels: tuple[str, ...] = ()
    noise: tuple[float, ...] = ()
    steps: tuple[float, ...] = ()
    title: str = "feedback: the controller"


def read_feedback(scene: Scene, what: object) -> Feedback:
    """Return the controller that something says, whose law is a function, `Gains`, a `Schedule` or a `LinearLaw`.

    Raises:
        SimulateError: with every fault, one line each; or it is no controller.
    """
    found = _read(scene, what)
    if found.reference is None or not isinstance(found.law, Gains | Schedule):
        return found
    return replace(found, law=_led(scene, found.law, found.reference), reference=None)


def _led(scene: Scene, law: Gains | Schedule, reference: object) -> Gains | Schedule:
    """Return gains about another place: x0 by coordinate and velocity, numbers, or formulas or functions of t."""
    faults, places = Faults("feedback: reference"), (*scene.coordinates, *scene.velocities)
    values, units = parameter_values(scene), SceneUnits(scene).letters
    laws, still = dict[int, MotionLaw](), dict[int, float]()
    for name, one in by_signal(reference, places, "", faults).items():
        k = places.index(name)
        if is_function(one) or isinstance(one, str):
            led = read_function(one, name, faults) if not isinstance(one, str) else read_law(
                one, values, name, faults, units.get(name, ""), scene
            )  # fmt: skip
            laws |= {} if led is None else {k: led}
        else:
            still |= {places.index(key): x for key, x in numbers_by_signal({name: one}, places, "", faults).items()}
    faults.close(SimulateError)
    rates = {k: places.index(rate) for k in laws if (rate := velocity_name(places[k])) in scene.velocities}

    def at(t: float) -> Gains:
        gains = law if isinstance(law, Gains) else law.at(t)
        x = np.hstack([gains.q0, gains.u0])
        told = {k: one(t) for k, one in laws.items()}
        for k, rate in rates.items():
            x[rate] = told[k][1]
        for k, x0 in (*still.items(), *((k, float(one[0])) for k, one in told.items())):
            x[k] = x0
        return replace(gains, q0=x[: len(gains.q0)], u0=x[len(gains.q0) :])

    end = law.end if isinstance(law, Schedule) else math.inf
    return at(0.0) if isinstance(law, Gains) and not laws else Schedule(at, law.inputs, end)


def _read(scene: Scene, what: object) -> Feedback:
    """Return the controller that something says, its reference as it was given; errors as of `read_feedback`."""
    asked = what if isinstance(what, Feedback) else Feedback(what)
    law, given, faults = asked.law, asked.given, Faults("feedback")
    if isinstance(law, Feedback):
        return _with_settings(read_feedback(scene, law), asked)
    text = isinstance(law, str) and "=" in law and not Path(law).exists()
    formulas = {law.partition("=")[0].strip()} if text else law if isinstance(law, Mapping) else ()
    if formulas and {*formulas} <= {*driven(scene)}:
        raise SimulateError(f"feedback: formulas of the state are forces: {argument('forces', law)}")
    if isinstance(law, Gains | Schedule):
        return replace(Feedback(law, law.inputs), **given)
    if isinstance(law, (str, Path, Mapping)):
        gains, more = gains_from(scene, law, "feedback") if isinstance(law, Mapping) else read_gains(scene, Path(law))
        return replace(Feedback(gains, gains.inputs, **more), **given)
    matrices = matrices_of(law, faults)
    faults.close(SimulateError)
    if matrices is not None:
        return _of_system(scene, asked, matrices)
    if isinstance(law, LinearLaw):
        return asked
    if not isinstance(law, type) and callable(made := getattr(law, "feedback", None)):
        if is_function(found := made()):
            found = Feedback(found)
        if not isinstance(found, Feedback):
            raise SimulateError(f"feedback: feedback() of {quoted(law)} returned {quoted(found)}, which is no Feedback")
        return _with_settings(read_feedback(scene, found), asked)
    if isinstance(law, (list, tuple)) and any(is_function(one) or isinstance(one, Feedback) for one in law):
        raise SimulateError(
            f"feedback: these are {len(law)} controllers, and a run has one; join them: a function of (t, q, u) for "
            "all inputs, or one system by interconnect of python-control"
        )
    if isinstance(law, tuple) and len(law) > 1 and all(np.ndim(one) for one in law) and len({*map(np.shape, law)}) > 1:
        raise SimulateError(
            "feedback: K: a tuple of several matrices, as K, S, E of a design; give K, its first, alone"
        )
    if hasattr(law, "__array__") or isinstance(law, (list, tuple)):
        inputs = asked.inputs or driven(scene)
        K = np.atleast_2d(np.asarray(law, dtype=object))
        said = {"K": K.tolist(), "states": state_names(scene), "inputs": list(inputs)}
        return replace(Feedback(gains_from(scene, said, "feedback")[0], tuple(inputs)), **given)
    if not is_function(law) or isinstance(law, type):
        raise SimulateError(
            f"feedback: {quoted(law)} is no controller; give a function of (t, q, u), a matrix K, gains or a .json "
            "file of them, a regulator, a linear system, or a Feedback of one"
        )
    if not isinstance(law, Gains) and (takes := required_arguments(law)) not in (3, None):
        raise SimulateError(
            f"feedback: the function takes {takes} argument{'s' * (takes != 1)}; a controller is a function of "
            "(t, q, u): time, coordinates and velocities"
        )
    return asked


def _with_settings(found: Feedback, asked: Feedback) -> Feedback:
    """Return a controller with what is asked beside it; SimulateError for a period that it was not designed for."""
    if asked.period not in (None, found.period) and isinstance(found.law, LinearLaw) and found.law.states:
        why = f"has samples every {found.period:g} s" if found.period else "is continuous; give it a period itself"
        advice = "as in lin.lqg(..., period=0.01), pid(..., period=0.01) or system.discretize(0.01)"
        raise SimulateError(f"feedback: period = {asked.period!r}: the controller {why}, {advice}; leave it out here")
    return replace(found, **asked.given)


def _of_system(scene: Scene, asked: Feedback, matrices: Mapping[str, Array]) -> Feedback:
    """Return the controller of a system: its names, if it has any, are those of signals and drives, `dt` its period."""
    faults, dt, given = Faults("feedback"), asked.law.dt, asked.period
    (ins, outs), p = names_of(asked.law), matrices["D"].shape[1]
    likely = (tuple(one.name for one in scene.outputs), scene.coordinates)
    measures = tuple(asked.measures) or ins or next((names for names in likely if len(names) == p), ())
    names = tuple(asked.inputs) or outs or driven(scene)
    if not measures:
        faults.add("", f"say which signals are the inputs of the system, {p} in all: Feedback(system, measures=..)")
    if dt is True and given is None:
        faults.add("", "the system is sampled, but says not how often; give it a dt, or a period, in seconds")
    period = given if dt is True else None if not dt else float(dt)
    if given is not None and given != period:
        why = f"is continuous; discretise it: c2d(system, {given!r}) of python-control, cont2discrete of SciPy"
        faults.add("period", f"the system {why if period is None else f'has samples every {period:g} s'}; leave it out")
    faults.close(SimulateError)
    law = LinearLaw.read(matrices, measures, names, faults)
    faults.close(SimulateError)
    return replace(Feedback(law, names, period, measures=measures), **asked.given)


def driven(scene: Scene) -> tuple[str, ...]:
    """Return what a controller drives that does not say it: all drives but those of prescribed motions, else inputs."""
    places = places_of(scene)
    drives = tuple(one for one in scene.drives if one and place_of(scene, places, one, "", Faults("")) is not None)
    return drives or tuple(one.name for one in scene.inputs if not (one.rates or one.of))


def placed(scene: Scene, feedback: Feedback, until: float, beside: bool = False) -> Placed:
    """Return a controller in its scene, or what acts beside one.

    Raises:
        SimulateError: with every fault, one line each.
    """
    faults, places = Faults(""), places_of(scene)
    names = tuple(feedback.inputs or getattr(feedback.law, "inputs", ()) or driven(scene))  # gains name their own
    where = "feedback: inputs"
    found = [places[name] if beside else place_of(scene, places, name, where, faults) for name in names]
    for name in (name for name in names if name in scene.rates and not beside):
        faults.add(where, f"{name} has rates, which no controller tells; give it in forces")
    if not names:
        faults.add("feedback", f"{scene.name} has no drive; give a joint one")
    for k in {k for k in found if k is not None and found.count(k) > 1}:
        faults.add("feedback: inputs", f"{force_names(scene)[k]} is named twice")
    _check_times(feedback, until, faults)
    said = feedback.initial if len(feedback.initial) else getattr(feedback.law, "initial", ()) or (0.0,) * len(names)
    initial = () if isinstance(said, Mapping | str) else tuple(map(float, said))
    if len(initial) != len(names) or not all(map(math.isfinite, initial)):
        faults.add("feedback: initial", f"{quoted(said)} are not {len(names)} finite numbers, one an input")
    ranges = _ranges(feedback.limits, names, faults, scene)
    signals = _signals(scene, feedback, names, faults)
    state = (*scene.coordinates, *scene.first_order)
    measures, labels = (state, state) if signals is None else (signals.measures, signals.labels)
    noise, steps = (_sizes(scene, feedback, name, measures, faults) for name in ("noise", "quantisation"))
    faults.close(SimulateError)
    least, most = zip(*(ranges[name] for name in names), strict=True)
    at, units = tuple(k for k in found if k is not None), force_units(scene)
    return Placed(
        feedback, names, tuple(units[k] for k in at), at, least, most, initial, signals, labels, noise, steps
    )  # fmt: skip


def placed_function(scene: Scene, function: ForceFunction, until: float) -> Placed:
    """Return a function that forces are given by as what acts all the time."""
    found = placed(scene, Feedback(function.of, function.names), until, beside=True)
    return replace(found, title=f"{function.where}: the function")


def _signals(scene: Scene, feedback: Feedback, names: Sequence[str], faults: Faults) -> Signals | None:
    """Return what a linear law measures; None of others, which are told the whole state."""
    law, measures = feedback.law, tuple(feedback.measures)
    if not isinstance(law, LinearLaw):
        for name in feedback.given.keys() & {"measures", "reference"}:
            faults.add(f"feedback: {name}", "is of linear systems; a function is told the whole state, as gains are")
        return None
    if law.D.shape != (len(names), len(measures)):
        made, told = law.D.shape
        asked = f"{len(names)} ({', '.join(names)}) of {len(measures)} ({', '.join(measures)})"
        faults.add("feedback", f"the law makes {made} of {told} numbers, and {asked} are asked for")
    return Signals.read(scene, measures, feedback.reference, law.y0, faults)


def _sizes(scene: Scene, feedback: Feedback, name: str, measures: Sequence[str], faults: Faults) -> tuple[float, ...]:
    """Return the noise, or the steps, of what is measured, shape (p,)."""
    where, seed = f"feedback: {name}", feedback.seed
    sizes = getattr(feedback, name)
    for drive in [one for one in force_names(scene) if isinstance(sizes, Mapping) and one in sizes]:
        told = f"what disturbs it stands in {argument('forces')}, numbers over time"
        faults.add(where, f"{drive} drives, and {name} is of what is measured; {told}")
        sizes = {one: size for one, size in sizes.items() if one != drive}
    found = numbers_by_signal(sizes, measures, where, faults, scene)
    for signal in (one for one, size in found.items() if size < 0):
        faults.add(where, f"{signal} = {found[signal]:g} is below 0")
    gains = feedback.law.at(0.0) if isinstance(feedback.law, Schedule) else feedback.law
    states = gains.states if isinstance(gains, Gains) and gains.formulas is not None else measures
    for signal in (one for one in found if one not in states):
        faults.add(where, f"{signal} is none of the states of these gains, {', '.join(states)}, so it acts on nothing")
    if found and feedback.period is None:
        faults.add(where, "is of a controller that takes samples; give it a period")
    if not isinstance(seed, Integral) or seed < 0:
        faults.add("feedback: seed", f"{quoted(seed)} is no whole number, 0 or more")
    return tuple(found.get(one, 0.0) for one in measures)


def _in_numbers(limit: Any) -> bool:
    return all(isinstance(x, Real | None) for x in (limit if isinstance(limit, tuple | list) else (limit,)))


def _check_times(feedback: Feedback, until: float, faults: Faults) -> None:
    period, delay = feedback.period, feedback.delay
    for name, value in (("period", period), ("delay", delay)):
        known = isinstance(value, Real) and not isinstance(value, np.timedelta64)
        if not (known or (name == "period" and value is None)):
            faults.add(f"feedback: {name}", f'{value!r} is no number of seconds; write 0.01 or "10 ms"')
            return
    if not (math.isfinite(delay) and delay >= 0):
        faults.add("feedback: delay", f"{delay:g} s is no delay; give 0 or more")
    elif period is None and delay > 0:
        told = f"{delay:g} s without a period would be a differential equation with delay; give a period too"
        faults.add("feedback: delay", told)
    if period is None and getattr(feedback.initial, "__len__", lambda: 1)():
        faults.add("feedback: initial", "is the force before the first sample; give a period too, or leave it out")
    if period is not None and not (math.isfinite(period) and period > 0):
        faults.add("feedback: period", f"{period:g} s is no period; give one above 0")
    elif period is not None and until > LARGEST * period:
        faults.add("feedback: period", f"{period:g} s makes more than {LARGEST:g} samples until {until:g} s")


def _ranges(
    limits: Any, names: Sequence[str], faults: Faults, scene: Scene | None = None
) -> dict[str, tuple[float, float]]:
    found = dict.fromkeys(names, (-math.inf, math.inf))
    letter, values = (SceneUnits(scene).letter, parameter_values(scene)) if scene else (Parameter, {})
    if len(names) == 1 and not isinstance(limits, Mapping):
        limits = {names[0]: limits}
    if not isinstance(limits, Mapping):
        told = f"{{{', '.join(f'{name!r}: 5' for name in names)}}}"
        faults.add("feedback: limits", f"{limits!r} is no table of sizes by input, such as {told}")
        return found
    for name, limit in limits.items():
        where = f"{argument('limits')}: {name}"
        if name not in found:
            faults.add(where, f"is no input of the controller; it has {', '.join(names)}")
            continue
        found[name] = read_range(limit, where, faults, letter(name), values, scene)
    return found


def feedback_of(
    scene: Scene, file: str, period: float | None, delay: float | None, limits: Mapping[str, str] | str, until: float
) -> Feedback:
    """Return the controller of a file, with other times and limits; what is None or nothing stays as it is there.

    `limits` are formulas in parameters, largest sizes of forces by name, or of one force alone, told as of `limits`.

    Raises:
        SimulateError: with every fault, one line each.
    """
    if isinstance(limits, str):
        limits = dict.fromkeys(names := read_feedback(scene, file).inputs, limits)
        if len(names) > 1:
            several = ",".join(f"{name}={limit}" for name, limit in limits.items())
            raise SimulateError(f"{argument('limits')}: a number is of one force; give {several}")
    more: dict[str, Any] = {"period": period, "delay": delay, "limits": limits or None}
    found = replace(read_feedback(scene, file), **{name: x for name, x in more.items() if x is not None})
    placed(scene, found, until)
    return found
