"""From a scene and what is asked of its motion to a problem in numbers: the function `collocation`.

It says where unknowns and equations stand, and what is known of them: bounds, ends, a first guess.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import SympyExpression, argument, suggesting
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import unilaterals_of, with_modes
from symdyn.errors import SimulateError, hint, listed, suggestion, with_own_names
from symdyn.scene import Quantity, Scene, SceneLike, SceneUnits
from symdyn.scene.values import (
    LETTERS,
    Faults,
    FormulaError,
    Input,
    Parameter,
    Unilateral,
    acceleration_name,
    formula_text,
    spell,
    substituted,
    velocity_name,
)
from symdyn.simulation import Problem, Start
from symdyn.simulation.prescribed import drive_names, number_of, parameter_values, read_formula, read_number, read_range
from symdyn.transcription.grid import METHODS, ROWWISE, Grid, grid as grid_of, numbered, read_mesh, read_span
from symdyn.transcription.local import PLACES, Source, Written, remarks, source, taken
from symdyn.transcription.phases import Phase, Sides, bound_schedule, read_phases
from symdyn.transcription.transcribed import Collocation

Range = tuple[float | str | None, float | str | None] | float | str

Number = str | float | SympyExpression
"""A formula in parameters, or a number."""

CLOSE = 1e-9
"""What a start or an end may be beyond its bounds by rounding."""


def known_names(where: str, names: Iterable[str], known: Collection[str], faults: Faults, scene: Scene) -> None:
    """Add a fault for every name that is not known."""
    for name in names:
        if name not in known:
            faults.add(where, f"{name} is not known; {suggestion(name, known, scene)}")


@dataclass
class Layout:
    """Where everything stands, and what is known of it beforehand."""

    scene: Scene
    free: tuple[str, ...]
    written: Written
    grid: Grid
    paths: int
    schedule: tuple[Phase, ...]

    def __post_init__(self) -> None:
        scene, found, grid = self.scene, self.written, self.grid
        N, P, S, K = len(grid.widths), len(grid.share), len(grid.stage), len(self.schedule)
        nq, nv, ns = len(scene.coordinates), len(scene.velocities), len(scene.states)
        self.states = tuple(one.name for one in scene.states)
        self.names = (*drive_names(scene), *(one.name for one in scene.inputs))
        self.place, self.size = numbered(
            {
                "q": (P, nq),
                "s": (P, ns),
                "u": (P, nv),
                "a": (S, nv),
                "multiplier": (S, found.rows),
                "contact": (S, len(found.kinds["contact"])),
                "force": (S, len(found.driven)),
                "slack": (N, len(found.kinds["slack"])),
                "free": (len(self.free),),
                "T": (K * any(one.span[0] < one.span[1] for one in self.schedule),),
                "impulse": (K - 1, len(found.kinds["impulse"])),
            }
        )
        self.row, self.rows = numbered(
            {
                "balance": (S, len(found.entries["balance"])),
                "defects": (N, grid.target.shape[1], nq + ns + nv),
                "held": (N + K, len(found.entries["held"])),
                "path": (N + K, self.paths),
                **{
                    name: ({"stage": S, "node": N + K, "joint": K - 1}[PLACES[name]], len(found.entries.get(name, ())))
                    for name in ROWWISE[3:]
                },
                "stays": (K - 1, nq + ns),
                "time": (int(len(self.place["T"]) > 1),),
            }
        )

    def bounded(
        self, start: Start, bounds: Mapping[str, Range], values: Mapping[str, Quantity], faults: Faults
    ) -> tuple[Array, Array]:
        """Return the bounds of z: those of joints, those that are given, and the start."""
        scene, place = self.scene, self.place
        lower, upper = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        columns = {name: place["q"][:, k] for k, name in enumerate(scene.coordinates)}
        columns |= {name: place["s"][:, k] for k, name in enumerate(self.states)}
        columns |= {name: place["u"][:, k] for k, name in enumerate(scene.velocities)}
        columns |= {acceleration_name(name): place["a"][:, k] for k, name in enumerate(scene.velocities)}
        columns |= {self.names[k]: place["force"][:, i] for i, k in enumerate(self.written.driven)}
        columns |= {name: place["free"][k] for k, name in enumerate(self.free)}
        odd, late = _of_points(scene, slice(9)), _of_points(scene, slice(6, 9))
        for name in filter(odd.__contains__, bounds):
            cure = argument("cost", f"{name}**2") if name in late else argument("path", {name: bounds[name]})
            faults.add("bounds", f"{name} follows from unknowns; hold it by {cure}")
        known_names("bounds", [name for name in bounds if name not in odd], columns, faults, scene)
        units, known = SceneUnits(scene), [name for name in bounds if name in columns]
        given = [
            (name, read_range(bounds[name], f"bounds: {name}", faults, units.letter(name), values, scene))
            for name in known
        ]
        for name, (least, most) in [*_limits(scene, self.names, values), *given]:
            if name not in columns:
                continue
            at = columns[name]
            low, high = np.maximum(lower[at], least), np.minimum(upper[at], most)
            if np.any(low > high):
                limits = f"{np.max(lower[at]):g} … {np.min(upper[at]):g}"
                faults.add(f"bounds: {name}", f"{least:g} … {most:g} leaves nothing of its joint's limits, {limits}")
            else:
                lower[at], upper[at] = low, high
        if len(place["T"]):
            lower[place["T"]], upper[place["T"]] = zip(*(one.span for one in self.schedule), strict=True)
        states = (("q", scene.coordinates, start.q), ("s", self.states, start.s), ("u", scene.velocities, start.u))
        for kind, names, x in states:
            for k, name in enumerate(names):
                self._fix(0, kind, k, name, float(x[k]), "start", lower, upper, faults)
        return lower, upper

    def ended(
        self,
        end: Mapping[str, Number],
        end_rates: Mapping[str, Number],
        resting: Sequence[str],
        values: Mapping[str, Quantity],
        lower: Array,
        upper: Array,
        faults: Faults,
        node: int = -1,
    ) -> Start | None:
        """Fix what is given of the end, or of another node; return a state there for the guess, None without one."""
        speeds: dict[str, Number] = dict.fromkeys(resting, 0)
        units = SceneUnits(self.scene)
        for name, text in end_rates.items():
            speed = velocity_name(name) if velocity_name(name) in self.scene.velocities else name
            if speed in speeds:
                faults.add("end rates", f"{speed} is given twice, as {speeds[speed]} and as {text}")
            speeds[speed] = text
        places = {
            kind: {name: (kind, k) for k, name in enumerate(names)}
            for kind, names in (("q", self.scene.coordinates), ("s", self.states), ("u", self.scene.velocities))
        }
        for where, given, names in (("end", end, places["q"] | places["s"]), ("end rates", speeds, places["u"])):
            odd = [name for name in given if name in places["u"] and name not in names]
            for name in odd:
                faults.add(where, f"{name} is a velocity; give it by {argument('end_rates', {name: given[name]})}")
            known_names(where, [name for name in given if name not in odd], names, faults, self.scene)
            for name, text in given.items():
                x = read_number(text, values, f"{where}: {name}", faults, units.letter(name), self.scene)
                if name in names and x is not None:
                    self._fix(node, *names[name], name, x, where, lower, upper, faults)
        if faults.lines:
            return None
        try:
            return Problem(self.scene, start=end).initial
        except SimulateError:
            return None

    def asked(
        self, lower: Array, upper: Array, path: Array, span: tuple[float, float], functions: Source
    ) -> tuple[Sides, Array]:
        """Return all bounds: those of z, of formulas of the path, of the time, of contacts; and the law of impacts."""
        sides = Sides(self.place, self.row, lower, upper, np.zeros(self.rows), np.zeros(self.rows))
        sides.rows_lower[self.row["path"]], sides.rows_upper[self.row["path"]] = path.T
        sides.rows_lower[self.row["time"]], sides.rows_upper[self.row["time"]] = span
        return sides, bound_schedule(sides, functions, self.schedule, self.grid)

    def _fix(
        self, node: int, kind: str, k: int, name: str, x: float, where: str, lower: Array, upper: Array, faults: Faults
    ) -> None:
        """Give an unknown at the start or the end its value; one beyond its bounds is a fault."""
        column = self.place[kind][self.grid.node[node], k]
        if not lower[column] - CLOSE <= x <= upper[column] + CLOSE:
            faults.add(where, f"{name} = {x:g} is beyond its bounds {lower[column]:g} … {upper[column]:g}")
        lower[column] = upper[column] = x

    def guessed(self, first: Start, ends: Sequence[Start | None], values: Mapping[str, Quantity]) -> Array:
        """Return z of straight ways from the start to the end of each phase, where that is known, free of forces."""
        z, place, share, phase = np.zeros(self.size), self.place, self.grid.share[:, None], self.grid.phase
        known = {0: first} | {k: one for k, one in enumerate(ends, start=1) if one is not None}

        def knots(kind: str) -> Array:
            given = np.stack([getattr(one, kind) for one in known.values()])
            return np.stack([np.interp(range(len(ends) + 1), [*known], x) for x in given.T] or [[]], axis=-1)

        durations = np.array([sum(one.span) / 2 for one in self.schedule])
        for kind in ("q", "s"):
            at = knots(kind)
            if place[kind].size:
                z[place[kind]] = at[phase] + share * np.diff(at, axis=0)[phase]
        for column, k in zip(place["force"].T, self.written.driven, strict=True):
            if k >= len(first.u):
                one = self.scene.inputs[k - len(first.u)]
                z[column] = number_of(one.value, values, f"inputs.{one.name}", Faults("")) or 0.0
        if len(first.q) == len(first.u):
            z[place["u"]] = np.diff(knots("q"), axis=0)[phase] / durations[phase, None]
        z[place["T"]] = durations[: len(place["T"])]
        z[place["free"]] = [number_of(values[n], values, f"parameters.{n}", Faults("")) or 0.0 for n in self.free]
        return z


def _of_points(scene: Scene, some: slice) -> tuple[str, ...]:
    """Return some of the nine names of every point."""
    return tuple(name for one in scene.points for name in LETTERS.of_point(one.name)[some])


def _limits(
    scene: Scene, drives: Sequence[str], values: Mapping[str, Quantity]
) -> list[tuple[str, tuple[float, float]]]:
    found: list[tuple[str, tuple[float, float]]] = []
    for joint in scene.moving:
        if len(joint.rates) != 1 or len(joint.coordinates) != 1:
            continue
        given = joint.limits
        k = scene.velocities.index(joint.rates[0])

        def value(x: Quantity | None, none: float, joint: str = joint.name) -> float:
            number = None if x is None else number_of(x, values, f"joints.{joint}.limits", Faults(""))
            return none if number is None else number

        speed, effort = value(given.velocity, np.inf), value(given.effort, np.inf)
        found.append((joint.coordinates[0], (value(given.lower, -np.inf), value(given.upper, np.inf))))
        found += [(joint.rates[0], (-speed, speed)), (drives[k], (-effort, effort))]
    return found


def _resting(
    scene: Scene, end: Mapping[str, Number], end_rates: Mapping[str, Number] | Literal["free"] | None
) -> tuple[dict[str, Number], list[str]]:
    """Return velocities that are given at the end, and those that are zero there, as positions alone are given."""
    if end_rates == "free":
        return {}, []
    given = dict(end_rates or {})
    told = {velocity_name(name) for name in given} | {*given}
    ended = [(joint, [q for q in joint.coordinates if q in end]) for joint in scene.moving]
    found = [u for joint, some in ended if some for u in joint.velocities or map(velocity_name, some)]  # a ball's own
    left = {name for name, x in given.items() if x == "free" and {name, velocity_name(name)} & {*scene.velocities}}
    return {name: x for name, x in given.items() if name not in left}, [u for u in found if u not in told]


@suggesting
def collocation(
    scene: SceneLike | Problem,
    until: float | str | tuple[float | str, float | str],
    intervals: int | Sequence[float] = 50,
    method: str = "hermite_simpson",
    cost: str | SympyExpression = "",
    final_cost: str | SympyExpression = "",
    start: Mapping[str, Number] | Start | None = None,
    start_rates: Mapping[str, Number] | None = None,
    end: Mapping[str, Number] | None = None,
    end_rates: Mapping[str, Number] | Literal["free"] | None = None,
    bounds: Mapping[str, Range] | None = None,
    path: Mapping[str, Range] | None = None,
    free: str | Sequence[str] = (),
    phases: Sequence[Mapping[str, object]] | None = None,
    values: Mapping[str, object] | None = None,
) -> Collocation:
    """Return an optimal control problem in numbers: the equations of a motion from a start to an end.

    Formulas are in t, coordinates, velocities, states, parameters, drives, inputs that are free, signals, and points of
    the scene as `point_tip_x` and `point_tip_x_dot`; of the cost also in accelerations, `x_ddot`, `point_tip_x_ddot`.

    >>> import symdyn
    >>> problem = symdyn.collocation(symdyn.example("cart_pole"), until=2, intervals=10, cost="F**2",
    ...     end={"x": 1})
    >>> problem
    <Collocation of cart_pole: 10 intervals of 2 s in all; 147 unknowns, 122 equations; unknown: F
        at the end x = 1, x_dot = 0; not given: theta, theta_dot>

    Args:
        scene: the mechanism, its parameters bound; or a `Problem`, without forces. Its drives are unknowns, its inputs
            held where the scene has them but for those that are free.
        until: time of the end, s; or two times between which it is free.
        intervals: how many of equal length; or the shares of time where they end, 0 … 1.
        method: a key of `METHODS`.
        cost: what is integrated over time and made small.
        final_cost: what is made small at the end, without drives and inputs.
        start: coordinates and states at t = 0, as for `simulate`; what is not given is as the scene says.
        start_rates: velocities, likewise.
        end: coordinates, which come to rest there as the start is at rest, and states that are given at the end; the
            others are free, and so are their velocities.
        end_rates: velocities there that are another, {"x": 1}, or "free", {"x": "free"}; "free" alone leaves all free.
        bounds: smallest and largest value by the name of a coordinate, its rates, a state, a drive, or of what is
            free, "5 deg" too; None for none; one alone is the largest size. They narrow joints' limits.
        path: likewise of formulas without drives, inputs and accelerations, held at all ends of intervals.
        free: names of parameters that are unknown, and of inputs that are so over time; a scene's values are the guess.
        phases: of a scene with contacts, stops or dry friction, what they do one phase after another, mappings such as
            {"closed": "foot"}, {} where all is open: `closed`, a name or names, which stick where there is friction;
            `slips`, {name: 1 or -1}, the sign of the slip; `strikes`, what strikes where the phase begins, and of
            what bounces with friction the sign of its slip behind, {name: 1, -1 or 0}; `duration` and `intervals`, its
            own; `end`, coordinates where it ends. What closes strikes, unnamed. `until` is the time of all of them.
        values: as of `Problem`.

    Raises:
        SimulateError: with every fault of the arguments, one line each.
        DerivationError: the equations do not exist, or have no derivative.
    """
    problem, _ = Problem.requested(collocation, locals(), "until", "method")
    declared = problem.refused("drives are unknowns, and inputs held", "forces").scene
    if not declared.velocities:
        raise SimulateError(f"{declared.name}: nothing moves: no joint has a coordinate")
    laws = _phased(declared, phases)
    free = (free,) if isinstance(free, str) else tuple(dict.fromkeys(free))
    if jumping := [one.name for one in declared.states if one.reset is not None]:
        raise SimulateError(
            f"{declared.name}: collocation knows no resets, and there is one of {listed(jumping)}: where a state jumps "
            "has to be known beforehand; take it out, or solve from jump to jump, each with its own start"
        )
    if rated := [one.name for one in declared.inputs if one.name in free and (one.rates or one.of)]:
        raise SimulateError(
            f"free: {listed(rated)}: an input with rates follows from its rates; declare it as a state with its rate "
            'as an input, such as [states.x] rate = "v", and let v be free'
        )
    try:
        problem = replace(problem, scene=declared.held(free))
    except FormulaError as fault:
        raise SimulateError(f"{declared.name}: an input that the scene holds: {fault}") from None
    scene, faults = problem.scene, Faults("")
    first = faults.taken(lambda: problem.initial, Start(np.zeros(0), np.zeros(0)))
    numbers = parameter_values(scene)
    mesh = read_mesh(intervals, faults)
    if method not in METHODS:
        faults.add("", f"method {method} is not known; {suggestion(method, METHODS)}")
    inputs = [one.name for one in scene.inputs]
    known_names("free", free, (*numbers, *(one.name for one in declared.inputs)), faults, scene)
    for words in filter(None, map(scene.derived_words, free)):
        faults.add("free", words)
    free = tuple(name for name in free if name not in inputs)
    span = read_span(until, faults)
    kept = [one for one in declared.inputs if one.name not in inputs]
    formulas = _read(
        scene, kept, {"path": tuple(path or ()), "running": (cost,), "final": (final_cost,)}, numbers, faults
    )
    schedule: tuple[Phase, ...] = (Phase(mesh, span),)
    if phases is not None:
        schedule = read_phases(scene, phases, mesh, span, laws, faults)
        scene = replace(with_modes(scene), states=scene.states)
    faults.close(SimulateError)
    functions = source(scene, free, tuple(formulas.items()))
    rates, resting = _resting(scene, end or {}, end_rates)
    limits = [
        read_range(
            one, f"path: {name}", faults, Parameter("", unit=SceneUnits(scene).of_formula(formula, {})), numbers, scene
        )
        for (name, one), formula in zip((path or {}).items(), formulas["path"], strict=False)
    ]
    given = {"start": problem.start, "start rates": problem.start_rates, "end": end, "end rates": rates}
    holds = tuple(f"input {one.name} is held at {spell(one.value)} {one.unit}".rstrip() for one in kept)
    rests = f'at rest at the end, where positions are given: {listed(resting)} = 0; end_rates="free" leaves them free'
    notes = (
        *([] if cost or final_cost else ["no cost: any motion that keeps all conditions will do"]),
        *([rests] if resting else []), *holds, *first.notes,
        *taken(scene, free, {k: x for k, x in given.items() if isinstance(x, Mapping)}), *remarks(functions),
    )  # fmt: skip
    grid = grid_of(METHODS[method], [one.mesh for one in schedule])
    made = Layout(scene, free, functions.written, grid, len(limits), schedule)
    lower, upper = made.bounded(first, bounds or {}, numbers, faults)
    closing = np.flatnonzero(np.diff(grid.phase[grid.starts], append=-1))  # the last interval of each phase
    asked = [*((one.end, {}, []) for one in schedule[:-1]), ({**schedule[-1].end, **(end or {})}, rates, resting)]
    ends = [
        made.ended(goal, speeds, still, numbers, lower, upper, faults, node)
        for (goal, speeds, still), node in zip(asked, grid.ends[closing].tolist(), strict=True)
    ]
    faults.close(SimulateError)
    sides, law = made.asked(lower, upper, np.reshape(limits, (-1, 2)), span, functions)
    guess = np.clip(made.guessed(first, ends, numbers), lower, upper)
    driven = functions.written.driven
    return Collocation(
        problem.scene, METHODS[method], grid, free, tuple(made.names[k] for k in driven), driven, made.place, made.row,
        made.size, made.rows, sum(span) / 2, *sides[2:], guess, functions, notes, schedule, law,
    )  # fmt: skip


def _phased(scene: Scene, phases: Sequence[Mapping[str, object]] | None) -> tuple[Unilateral, ...]:
    replace(scene, elements=()).refuse_contacts("collocation", SimulateError)
    laws = unilaterals_of(scene) if phases is not None else ()
    if phases is None and scene.unilaterals:
        names = listed(one.name for one in scene.unilaterals)
        told = f'say which are closed in each phase, such as phases=[{{"closed": "{scene.unilaterals[0].name}"}}, {{}}]'
        raise SimulateError(f"{scene.name}: contacts open and close, and there is {names}; {told}")
    if phases is not None and not (laws and phases):
        what = "there is none in the list" if laws else "there is no contact, stop or dry friction"
        raise SimulateError(f"{scene.name}: phases: {what}; leave phases out, or say what is closed in each")
    return laws


FORCES = ("F", "f", "u", "tau", "M", "force", "torque")
"""What drives are called elsewhere."""


def _read(
    scene: Scene,
    kept: Sequence[Input],
    given: Mapping[str, Sequence[str | SympyExpression]],
    values: Mapping[str, Quantity],
    faults: Faults,
) -> dict[str, tuple[Quantity, ...]]:
    states, points = [x.name for x in scene.states], (*_of_points(scene, slice(6)), *LETTERS.of_struts(scene.struts))
    state = (TIME, *scene.coordinates, *scene.velocities, *states, *values, *scene.definitions, *points)
    rates, check = (*map(acceleration_name, scene.velocities), *_of_points(scene, slice(6, 9))), SceneUnits(scene).check
    way = f"what is to be found are drives, and inputs that are free: {argument('free', *[x.name for x in kept[:1]])}"
    held = f"; and no inputs, {listed(one.name for one in kept)}: they keep their values; {way}" if kept else ""
    acting = (*filter(None, scene.drives), *(one.name for one in scene.inputs))
    drives, neither = f"and drives are {listed(acting)}" if acting else "", "and no force or acceleration"
    advice: dict[str, Callable[[str], str]] = {
        "path": lambda _: f"{neither}; {argument('bounds')} limits those of joints{held}",
        "running": lambda _: f"{drives}{held}".lstrip("; "),
        "final": lambda _: f"{neither}, whose cost is over time: {argument('cost')}{held}",
    }
    words, found = {"running": "cost", "final": "final cost"}, dict[str, tuple[Quantity, ...]]()
    for name, texts in given.items():
        where, allowed = words.get(name, name), (*state, *((*acting, *rates) if name == "running" else ()))
        told = [formula_text(one) for one in texts if one]
        begun = [one.partition("(")[0].replace(" ", "_") for one in told if name in words]
        alien = [one.rstrip("0123456789_") for one in re.findall(r"[A-Za-z_]\w*", " ".join(told)) if one not in allowed]
        meant = [hint("costs", one) for one in begun if not {*re.findall(r"[A-Za-z_]\w*", one)} & {*allowed}]
        meant += [hint("costs", one) for one in alien if one in FORCES]
        if said := [one for one in meant if one and (name == "running" or "DRIVE" not in one)]:
            faults.add(where, with_own_names(said[0], scene))
            told = []
        read = [read_formula(text, allowed, where, faults, advice[name], scene=scene) for text in told]
        found[name] = tuple(substituted(one, scene.definitions) for one in read if one is not None)
        for one in found[name]:
            check(one, where, faults)
    return found
