"""What is asked of a mechanism, `Problem`, and how far and how exactly it is integrated, `Run`: each read once.

Public functions take the fields of both as keywords, or a `Problem` in place of the scene. `Problem.requested` reads
them for all; what else a function takes, it reads itself.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypedDict

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import SympyExpression, check_arguments, native, suggesting
from symdyn.errors import SimulateError
from symdyn.frozen import InitVar, dataclass, replace
from symdyn.scene import Quantity, Scene, scene_of, with_values
from symdyn.scene.values import Faults, formula_text
from symdyn.shown import Suggesting
from symdyn.simulation.equations.contact_modes import column_names
from symdyn.simulation.initial import Start, Values, by_name, read_start
from symdyn.simulation.integrate import FINEST, named
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.forces import Forces, at_start, read_forces, read_inputs
from symdyn.simulation.prescribed.formulas_in_time import in_seconds, parameter_values, read_seen, sample_times
from symdyn.unlocked import cached_property

SMALLEST = 1e-300
"""The smallest absolute tolerance that means anything."""


@suggesting
@dataclass(frozen=True, eq=False)
class Problem(Suggesting):
    """What is asked of a mechanism, for calls that share it: each takes one in place of the scene and of these fields.

    >>> import symdyn
    >>> swung = symdyn.Problem(symdyn.example("pendulum"), start={"q1": 0.3}, values={"b": 0.1})
    >>> symdyn.simulate(swung, until=1).q.shape, symdyn.linearize(swung, anywhere=True).A.shape
    ((201, 1), (2, 2))

    Forces and start are read where they are first needed, and then kept; whoever reads them tells their faults.

    Args:
        scene: the mechanism; it keeps the values of its parameters but for those that are given.
        forces: driving forces and inputs, formulas in t, coordinates and velocities such as "tau1=-2*q1, tau2=1", or a
            .toml or .csv file. From `read_forces`, or what that takes.
        start: where it starts, such as "q1=0.3,q2=pi/2", in place of the scene's. By coordinate or velocity; or all.
        start_rates: velocities there, such as "q1=2". Formulas by velocity.
        values: of parameters, in place of those that the scene gives: numbers or formulas by name.

    Raises:
        SimulateError: what is of another kind, or numbers of many runs.
        SceneError: a value that the scene cannot have, or of no parameter.
    """

    class Fields(TypedDict, total=False):
        """What it takes beside the scene, as keywords."""

        forces: Forces | Entries
        start: Values | Start | None
        start_rates: Values | None
        values: Mapping[str, object] | None

    scene: Scene
    forces: Forces | Entries = ()
    start: Values | Start | None = None
    start_rates: Values | None = None
    values: InitVar[Mapping[str, object] | None] = None

    def __post_init__(self, values: Mapping[str, object] | None) -> None:
        check_arguments(Problem, {**vars(self), "values": values}, SimulateError)
        _check_one({"start": self.start, "start rates": self.start_rates, "values": values})
        if self.whole is not None and self.start_rates is not None:
            raise SimulateError("start_rates: the start is a whole state, which has velocities; leave them out")
        object.__setattr__(self, "scene", scene_of(self.scene, values))

    @classmethod
    def requested(
        cls, function: Callable[..., object], arguments: Mapping[str, Any], *others: str
    ) -> tuple[Problem, Run]:
        """Return what a public function is asked for, its arguments checked.

        Args:
            function: the one that was called; its first argument is `scene`.
            arguments: by name, as `locals()` has them at its head.
            others: arguments that have the name of a field, and are none.

        Raises:
            SimulateError: with every argument of another kind; or a field of a Problem beside one.
            SceneError: with every fault of a scene's file, or a value that the scene cannot have.
        """
        arguments = in_seconds({**arguments, "fields": in_seconds(arguments.get("fields") or {})})
        given, usual = check_arguments(function, arguments, SimulateError), inspect.signature(function).parameters
        own, of_run = (
            {
                name: value
                for name, value in given.items()
                if name in noun.Fields.__annotations__ and name not in others and value is not usual[name].default
            }
            for noun in (cls, Run)
        )
        scene = arguments["scene"]
        if not isinstance(scene, Problem):
            return cls(scene_of(scene), **own), Run(**of_run)
        if own:
            raise SimulateError([f"{name}: the Problem says its own; leave it out, or give a scene" for name in own])
        return scene, Run(**of_run)

    @cached_property
    def driving(self) -> Forces:
        """The forces, read; SimulateError with every fault."""
        return self.forces if isinstance(self.forces, Forces) else read_forces(self.scene, self.forces)

    @cached_property
    def inputs(self) -> Forces:
        """What is given of inputs, where forces are looked for; SimulateError with every fault."""
        return self.forces if isinstance(self.forces, Forces) else read_inputs(self.scene, self.forces)

    @cached_property
    def initial(self) -> Start:
        """The state at t = 0, consistent with loops and prescribed motions; SimulateError with every fault."""
        inputs = at_start(self.scene, self.driving) if self.scene.rates else {}
        return read_start(self.scene, self.start, self.start_rates, inputs)

    def posed(
        self, run: Run, faults: Faults, reports: Sequence[str] = (), finest: float = FINEST
    ) -> tuple[Forces, Start, tuple[Quantity, ...], Array]:
        """Return forces, start, and what `Run.checked` returns; whatever is wrong is among the faults."""
        forces = faults.taken(lambda: self.driving, Forces())
        start = faults.taken(lambda: self.initial, Start(np.zeros(0), np.zeros(0)))
        return forces, start, *faults.taken(lambda: run.checked(self.scene, reports, finest), ((), np.zeros(1)))

    @property
    def as_read(self) -> Problem:
        """The same, from the whole state that its start is read as."""
        return replace(self, forces=self.driving, start=self.initial, start_rates=None)

    def with_values(
        self, values: Mapping[str, object], start: Mapping[str, object], start_rates: Mapping[str, object]
    ) -> Problem:
        """Return it at other values, and from another start, of what is named; SimulateError of a whole state."""
        there = replace(self, scene=with_values(self.scene, values))
        if not (start or start_rates):
            return there
        own, own_rates = self.by_name
        return replace(there, start={**own, **start}, start_rates={**own_rates, **start_rates})

    @property
    def whole(self) -> Array | None:
        """The coordinates of a whole state that it starts from, at which things are decided in numbers; else None."""
        return self.start.q if isinstance(self.start, Start) else None

    @property
    def by_name(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Formulas and numbers of the start by coordinate and by velocity; SimulateError with every fault."""
        faults = Faults("")
        found = by_name(self.start, "start", faults), by_name(self.start_rates, "start rates", faults)
        faults.close(SimulateError)
        return dict(found[0]), dict(found[1])

    @property
    def given(self) -> dict[str, object]:
        """What is said beside the scene, by field; no forces and no names say nothing."""
        each = {"forces": self.forces, "start": self.start, "start_rates": self.start_rates}
        nothing: tuple[object, ...] = ("", (), [], {}, Forces(), None)
        plain = {name for name, one in each.items() if isinstance(one, str | Sequence | Mapping | Forces | None)}
        return {name: one for name, one in each.items() if not (name in plain and one in nothing)}

    def refused(self, why: str, *names: str) -> Problem:
        """Return it; SimulateError where fields are given for which a call has no use."""
        if unread := [f"{name}: {why}; leave it out" for name in names if name in self.given]:
            raise SimulateError(unread)
        return self


@dataclass(frozen=True)
class Run:
    """How far, and how exactly, something is integrated from t = 0 on.

    Args:
        until: time of the end, s.
        every: seconds between samples; None for 200 of them.
        method: taylor (heyoka), dop853, rk45, rk23, radau, bdf, lsoda (SciPy), cvode, adams or ida (SUNDIALS), gauss
            (31 digits), moreau:1e-3 (contacts, by steps of 1e-3 s); None takes the one that fits. A key of
            `symdyn.simulation.METHODS`.
        rtol: relative tolerance of a step, below 1e-16 (to 1e-30) with 31 digits; None takes the method's.
        atol: absolute tolerance of a step; None takes `rtol`.
        stops: formulas of terminal events, in what outputs may name, and in outputs; a zero crossing ends the run.
        ignore_limits: go on where a joint reaches a limit of its position; else the run stops there, with an event.
    """

    class Fields(TypedDict, total=False):
        """What it takes, as keywords."""

        until: float
        every: float | None
        method: str | None
        rtol: float | None
        atol: float | None
        stops: str | Sequence[str | SympyExpression]
        ignore_limits: bool

    class OfProblem(Problem.Fields, Fields, total=False):
        """What it and its problem take, as keywords."""

    until: float = 10.0
    every: float | None = None
    method: str | None = None
    rtol: float | None = None
    atol: float | None = None
    stops: str | Sequence[str | SympyExpression] = ()
    ignore_limits: bool = False

    def __post_init__(self) -> None:
        for name, kind in {"until": float, "every": float, "rtol": float, "atol": float, "ignore_limits": bool}.items():
            object.__setattr__(self, name, *native(kind, getattr(self, name)))
        stops = (self.stops,) if isinstance(self.stops, str) else map(formula_text, self.stops)
        object.__setattr__(self, "stops", tuple(stops))

    def checked(
        self, scene: Scene, reports: Sequence[str] = (), finest: float = FINEST
    ) -> tuple[tuple[Quantity, ...], Array]:
        """Return the formulas of events, those that only report last, and the times of samples, shape (N,).

        `finest` is the finest relative tolerance that there is a method for.

        Raises:
            SimulateError: with every fault, one line each.
        """
        parameter_values(scene)
        faults, formulas = Faults(""), (*self.stops, *reports)
        events = [read_seen(scene, text, "event", faults, column_names(scene)) for text in formulas]
        for text, event in zip(formulas, events, strict=True):
            if event is not None and not event.symbols:
                faults.add("event", f'"{text}" is a constant, which crosses nothing')
        for name, value, least in (("rtol", self.rtol, finest), ("atol", self.atol, SMALLEST)):
            if value is not None and not least <= value < 1:
                faults.add("", f"{name} = {value:g} is not a tolerance; give one between {least:g} and 1, such as 1e-9")
        with faults.noted():
            named(self.method or "taylor")
        times = sample_times(self.until, self.every, faults)
        faults.close(SimulateError)
        return tuple(event for event in events if event is not None), times


def _check_one(specified: Mapping[str, object]) -> None:
    """Raise SimulateError where a number of a run is an array: that is many runs."""
    many = [
        f"{what}: {name} has {np.size(one)} numbers, a run takes one; symdyn.ensemble takes arrays, symdyn.sweep over="
        for what, given in specified.items()
        for name, one in (given.items() if isinstance(given, Mapping) else ())
        if isinstance(one, Sequence | np.ndarray) and not isinstance(one, str) and np.ndim(one) > 0
    ]
    if many:
        raise SimulateError(many)
