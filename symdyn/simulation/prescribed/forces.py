"""Driving forces over time and the prescribed motion of a scene: what users give, read and checked.

A force is a formula in t, q and q̇, a constant, a function, or a column of a CSV file. Tables of forces are
interpolated by PCHIP, which is once differentiable and does not overshoot at steps. Before its first and after its last
row a table keeps its value.

A motion is a law for each coordinate, from formulas, named laws, TOML, functions or CSV.

Reference: Fritsch and Butland, A method for constructing local monotone piecewise cubic interpolants (1984).
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.errors import SimulateError, suggestion
from symdyn.frozen import dataclass, field, replace
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import Faults, acceleration_name, force_unit, question, substituted, velocity_name
from symdyn.simulation.prescribed.courses import ForceTable, formulas_of, rate_of, tables_of, with_its_rates
from symdyn.simulation.prescribed.entries import Entries, read_entries
from symdyn.simulation.prescribed.formulas_in_time import (
    Columns,
    bound,
    counted,
    jump_of,
    parameter_values,
    read_formula,
    sample_times,
)  # fmt: skip
from symdyn.simulation.prescribed.motion_laws import Law, column_law, read_function, read_law, required_arguments


@dataclass(frozen=True)
class ForceFunction:
    """A function that returns driving forces.

    Attributes:
        names: of the forces that it returns.
        where: what it is called in messages.
        of: the function, of time, s, coordinates, shape (nq,), and velocities, shape (nv,).
    """

    names: tuple[str, ...]
    where: str
    of: Callable[[float, Array, Array], Any]

    def number(self, name: str, t: float, q: Array, u: Array) -> float:
        """Return one of what it returns; SimulateError where that is something else than a number each."""
        try:
            found = np.asarray(self.of(t, q, u), dtype=np.float64).ravel()
        except Exception as fault:
            raise SimulateError(f"{self.where}: the function has no value at t = {t:g} s: {fault}") from None
        if len(found) != len(self.names):
            told = f"{self.where}: the function returned {counted(len(found), 'number')} at t = {t:g} s"
            rates = "; of a formula or a table the rates follow" * (self.names[1:2] == (f"{self.names[0]}_dot",))
            raise SimulateError(f"{told}; it returns {len(self.names)}: {', '.join(self.names)}{rates}")
        return float(found[self.names.index(name)])


@dataclass(frozen=True)
class Forces:
    """Driving forces; zero where nothing is said.

    Attributes:
        formulas: by index of the velocity, or behind velocities of the input: formulas in t, coordinates, velocities
            and parameters; of drives in inputs too.
        tables: by index of the velocity: functions of t.
        fed: indices of the velocities to whose force a controller or a function adds.
        functions: of t, or of t, q and u: which forces they return, and what they are called in messages.
    """

    formulas: Mapping[int, Quantity] = field(default_factory=dict)
    tables: Mapping[int, ForceTable] = field(default_factory=dict)
    fed: tuple[int, ...] = ()
    functions: tuple[ForceFunction, ...] = ()

    @property
    def outside(self) -> tuple[int, ...]:
        """Indices of the velocities whose force, or a part of it, comes as a number from outside the equations."""
        return tuple(dict.fromkeys((*self.tables, *self.fed)))

    @property
    def form(self) -> tuple[tuple[tuple[int, Quantity], ...], tuple[int, ...]]:
        """What of them is written into equations: formulas, and to which ones something comes from outside."""
        return tuple(self.formulas.items()), self.outside

    def formula(self, k: int) -> Quantity:
        """Return the formula of a velocity's driving force, zero where it has none."""
        return self.formulas.get(k, Quantity.ZERO)

    def check_differentiable(self, faults: Faults) -> None:
        """Add a fault for every function, which has no derivatives."""
        for one in self.functions:
            faults.add(one.where, "a function has no derivatives; write a formula")

    def tabulated(self, times: Array, n: int) -> Array:
        """Return what the tables give at `times`, shape (..., n); zero where there is none."""
        found = np.zeros((*np.shape(times), n))
        for k, table in self.tables.items():
            found[..., k] = table(times)
        return found


def held(scene: Scene, forces: Forces, until: float) -> tuple[str, ...]:
    """Return what is to be said of tables that do not reach from 0 to `until`, and of ends of springs that jump.

    Raises:
        SimulateError: one of them is that of an input with rates, which it says nowhere else.
    """
    names, spans = force_names(scene), {k: (table.t[0], table.t[-1]) for k, table in forces.tables.items()}
    for k, table in forces.tables.items():
        if table.spline is not None and (table.t[0] > 0 or table.t[-1] < until):
            raise SimulateError(
                f"forces: {names[k]} has rates, and its table goes from {table.t[0]:g} s to {table.t[-1]:g} s; give "
                f"rows for the whole run, from 0 to {until:g} s"
            )
    values = parameter_values(scene) if scene.rates else {}
    jumps = {names[k]: jump_of(bound(one, values)) for k, one in forces.formulas.items() if names[k] in scene.rates}
    steps = (
        f"{name} has a step at t = {at:.6g} s; what it does at once to a spring is missing in the energy balance"
        for name, at in jumps.items()
        if at is not None
    )
    return tuple(steps) + tuple(
        f"the table of {names[k]} goes from {first:g} s to {last:g} s; outside, the force is that of its nearest row"
        for k, (first, last) in spans.items()
        if first > 0 or last < until
    )


def drive_names(scene: Scene) -> tuple[str, ...]:
    """Return a name for every driving force, shape (nv,): its own, else tau_ and its velocity's."""
    return tuple(
        drive or f"tau_{velocity.removesuffix('_dot')}"
        for drive, velocity in zip(scene.drives, scene.velocities, strict=True)
    )


def force_names(scene: Scene) -> tuple[str, ...]:
    """Return a name for every driving force, and then for every input: what indices of `Forces` count."""
    return (*drive_names(scene), *(one.name for one in scene.inputs))


def force_units(scene: Scene) -> tuple[str, ...]:
    """Return the units of what `force_names` names."""
    told = SceneUnits(scene).inferred
    forces = (scene.shown_unit(force_unit(unit)) for unit in SceneUnits(scene).velocities)
    return (*forces, *(told[one.name] for one in scene.inputs))


def read_forces(scene: Scene, entries: Entries) -> Forces:
    """Return the forces, and inputs, that words, files, tables, arrays and functions say.

    Args:
        scene: the mechanism, its parameters bound.
        entries: `name=formula`, where the name is that of a drive, an input, a coordinate or a velocity, several with
            commas between; a .toml file of them; or a .csv file of columns t and drives or coordinates. Formulas by
            name; beside text and numbers these may be (times, values), or functions of t or of (t, q, u). A function of
            (t, q, u) that returns all forces, then inputs. A data frame, data set or run. Or a list of any of these.

    Raises:
        SimulateError: with every fault, one line each.
    """
    values = parameter_values(scene)
    faults = Faults("")
    formulas: dict[int, Quantity] = {}
    tables: dict[int, ForceTable] = {}
    functions: dict[int, ForceFunction] = {}
    said = read_entries(entries, "forces", faults)
    places = places_of(scene)
    states = (one.name for one in scene.states)
    allowed = (TIME, *scene.coordinates, *scene.velocities, *states, *values, *scene.definitions)
    letters = tuple(one.name for one in scene.inputs if not one.of)
    units = force_units(scene)
    outputs = {one.name for one in scene.outputs}

    def advice(name: str) -> str:
        return "but no outputs: forces make them" if name in outputs else f"or declare it, [inputs.{name}]"

    def place(name: str, where: str) -> int | None:
        k = place_of(scene, places, name, where, faults)
        if k is not None and (k in formulas or k in tables or k in functions):
            faults.add(where, f"{name} has a force already")
            return None
        return k

    for where, name, text in said.texts:
        k = place(name, where)
        known = (*allowed, *(() if name in letters else (one.name for one in scene.inputs)))
        unit = "" if k is None else units[k]
        if where == "forces" and (asked := _asked(scene, entries, name, text)):
            faults.add(where, asked)
        formula = read_formula(text, known, f"{where}: {name}", faults, advice, unit, scene)
        if k is not None and formula is not None:
            told = formulas_of(scene, name, substituted(formula, scene.definitions), where, faults)
            formulas |= {places[one]: course for one, course in told.items()}
    drives = {drive: k for k, drive in enumerate(scene.drives) if drive}
    drives |= {name: places[name] for name in letters}
    for table in said.tables:  # without a column of a drive, those that are called like coordinates
        wanted = [name for name in table.values if name in drives] or [name for name in table.values if name in places]
        if table.every:
            wanted = list(table.values)
        wanted = [name for name in wanted if rate_of(scene, name) not in wanted]
        if not wanted:
            what = "of a drive or an input" if letters else "of a drive"
            faults.add(table.source, f"has no column {what}; {scene.name} has {', '.join(drives) or 'none'}")
        for name in wanted:
            k = place(name, table.source)
            if k is not None:
                tables |= {places[one]: found for one, found in tables_of(scene, name, table, faults).items()}
    for name, function in said.functions:
        led = scene.prescribed_velocities
        names = (name,) if name else tuple(drive for drive, k in drives.items() if k not in led)
        if not names:
            faults.add("forces", f"{scene.name} has no drive; give a joint one")
        found = [place(one, "forces") for one in names]
        names = tuple(rate for one in names for rate in with_its_rates(scene, one))
        counts = (1,) if name in scene.rates else (1, 3)
        one = force_function(names, f"forces: {name}" if name else "forces", function, faults, counts)
        if one is not None and None not in found:
            functions |= {places[rate]: one for rate in names}
    faults.close(SimulateError)
    return Forces(formulas, tables, tuple(functions), tuple(dict.fromkeys(functions.values())))


def _asked(scene: Scene, entries: Entries, name: str, text: str) -> str:
    """Return what text without a unit, or a number of Python, may mean for an input; "" where it is clear."""
    several = entries if isinstance(entries, (list, tuple)) else [entries]
    raw = ChainMap(*(one for one in several if isinstance(one, dict))).get(name, text)
    return next((question(one, raw) for one in scene.inputs if one.name == name), "")


def at_start(scene: Scene, forces: Forces) -> dict[str, Quantity]:
    """Return what inputs with rates are at t = 0, by name: formulas, and numbers of tables and functions."""
    found, still = dict[str, Quantity](), np.zeros(0)
    names = [rate for one in scene.inputs if one.rates for rate in with_its_rates(scene, one.name)]
    for name, k in ((name, places_of(scene)[name]) for name in names):
        told = [float(forces.tables[k](np.zeros(())))] if k in forces.tables else []
        told += [one.number(name, 0.0, still, still) for one in forces.functions if name in one.names]
        if told or k in forces.formulas:
            found[name] = Quantity.number(Fraction(told[0])) if told else forces.formulas[k]
    return found


def force_function(
    names: tuple[str, ...],
    where: str,
    function: Callable[..., Any],
    faults: Faults,
    counts: tuple[int, ...] = (1, 3),
) -> ForceFunction | None:
    """Return a function of t, or of t, q and u, as one of the latter; None after a fault."""
    count = required_arguments(function)
    if count not in (None, *counts):
        usual = "a force is a function of t, or of (t, q, u)"
        told = usual if 3 in counts else f"give one of t that returns {', '.join(names)}"
        faults.add(where, f"the function takes {count} arguments; {told}")
        return None
    return ForceFunction(names, where, partial(_of_time, function) if count == 1 else function)


def _of_time(function: Callable[[float], Any], t: float, q: Array, u: Array) -> Any:
    return function(t)


def read_inputs(scene: Scene, entries: Entries) -> Forces:
    """Return what is said of inputs, as `read_forces` takes it, where driving forces are what is looked for.

    Raises:
        SimulateError: with every fault, one line each; a driving force that is no column of a table.
    """
    read, n = read_forces(scene, entries), len(scene.velocities)
    wrong = [name for k, name in enumerate(force_names(scene)[:n]) if k in (*read.formulas, *read.fed)]
    if wrong:
        given = ", ".join(one.name for one in scene.inputs) or "no input"
        raise SimulateError(f"forces: {', '.join(wrong)}: found from the motion; {scene.name} has {given} to be given")
    return replace(read, tables={k: table for k, table in read.tables.items() if k >= n})


def places_of(scene: Scene) -> dict[str, int]:
    """Return the index of the velocity, or behind velocities of the input, that a name means."""
    found = {velocity: k for k, velocity in enumerate(scene.velocities)}
    found |= {name: found[velocity_name(name)] for name in scene.coordinates if velocity_name(name) in found}
    found |= {drive: k for k, drive in enumerate(scene.drives) if drive}
    return found | {one.name: k for k, one in enumerate(scene.inputs, len(scene.velocities))}


def place_of(scene: Scene, places: Mapping[str, int], name: str, where: str, faults: Faults) -> int | None:
    """Return the index of what a name means, as `places_of` has it; None after a fault."""
    k, of = places.get(name), rate_of(scene, name)
    if of:
        faults.add(where, f"{name} is a rate of {of}, and follows from it; give {of}")
        return None
    if k is None:
        letters = [one.name for one in scene.inputs if not one.of]
        known = [*(drive for drive in scene.drives if drive), *letters] or list(places)
        what = "a drive, an input nor a coordinate" if letters else "a drive nor a coordinate"
        faults.add(where, f"{name} is neither {what}; {suggestion(name, known, scene)}")
    elif k >= len(scene.velocities):
        return k
    elif scene.drives[k] is None:
        faults.add(where, f"{name} is passive; give its joint a drive, or the scene a load")
        return None
    elif k in scene.prescribed_velocities:
        faults.add(where, f"{name} has a prescribed motion, which finds its own force; take one of the two away")
        return None
    return k


@dataclass(frozen=True)
class SceneMotion:
    """Laws by coordinate; where one has none, it rests at its start, or follows the others through closed loops.

    Attributes:
        laws: by name of the coordinate.
        quasi: laws of velocities that are no rates of coordinates (a quaternion's), where a table gives them.
        inputs: by name what a table gives of inputs.
    """

    laws: Mapping[str, Law] = field(default_factory=dict)
    quasi: Mapping[str, Law] = field(default_factory=dict)
    inputs: Mapping[str, ForceTable] = field(default_factory=dict)

    @property
    def span(self) -> tuple[float, float]:
        """First and last time at which all laws are known."""
        spans = [law.span for law in (*self.laws.values(), *self.quasi.values())]
        return max((low for low, _ in spans), default=-np.inf), min((high for _, high in spans), default=np.inf)


def read_motion(scene: Scene, entries: Entries) -> SceneMotion:
    """Return the motion that words, files, tables, arrays and functions say.

    Args:
        scene: the mechanism, its parameters bound.
        entries: `name=law` for a coordinate, a .toml file of such lines, or a .csv file of columns t, q1, ... with
            rates q1_dot and accelerations q1_ddot where they are known. Laws by name; beside words and numbers these
            may be (times, values), or functions of t that return a position, which is differentiated by differences,
            or (position, rate, acceleration). A data frame, data set or run. Or a list of any of these.

    Raises:
        SimulateError: with every fault, one line each.
    """
    values, units = parameter_values(scene), SceneUnits(scene).letters
    faults = Faults("")
    laws: dict[str, Law] = {}
    quasi: dict[str, Law] = {}
    said, known = read_entries(entries, "motion", faults), scene.coordinates
    reads = partial(read_law, scene=scene)
    for where, name, read in [
        *((where, name, partial(reads, text, values, unit=units.get(name, ""))) for where, name, text in said.texts),
        *(("motion", name, partial(read_function, law)) for name, law in said.functions),
    ]:
        if name not in known:
            whose = f"{name} is not a coordinate" if name else "a function moves a coordinate; give it by name"
            if moved := [", ".join(joint.coordinates) for joint in scene.joints if joint.name == name]:
                whose = f"{whose}, but a joint: it has {moved[0] or 'none'}"
            of = next((one for one in known if velocity_name(one) == name), None)
            told = f"write {of}=30*t for 30 a second" if of else suggestion(name, known)
            faults.add(where, f"{whose}; {told}")
            continue
        if name in laws:
            faults.add(where, f"{name} has a law already, {laws[name].text}")
        law = read(f"{where}: {name}", faults)
        if law is not None:
            laws[name] = law
    for table in said.tables:
        _from_table(scene, table, laws, quasi, faults)
    for group in quaternions(scene):
        missing = [name for name in group if name not in laws]
        if missing and len(missing) < len(group):
            faults.add("motion", f"{', '.join(missing)} missing; a quaternion moves as ({', '.join(group)})")
    faults.close(SimulateError)
    given: dict[str, ForceTable] = {}
    for one, table in ((one, table) for one in scene.inputs for table in said.tables if one.name in table.values):
        given |= {} if one.of else tables_of(scene, one.name, replace(table, curves={}), faults)
    faults.close(SimulateError)
    return SceneMotion(laws, quasi, given)


def motion_times(entries: Sequence[str], until: float | None, every: float | None) -> Array:
    """Return the times of samples: those asked for, else the rows of the one table among motions and paths, as text.

    Raises:
        SimulateError: neither a time of the end nor one table, or times that are none.
    """
    faults = Faults("")
    named = [entry.partition("=")[2].strip() or entry for entry in entries]  # points have tables after their names
    tables = [entry for entry in named if "=" not in entry and Path(entry).suffix.lower() == ".csv"]
    if until is None and len(tables) == 1 and every is None:
        return Columns.read(Path(tables[0])).t
    if until is None and len(tables) == 1:
        until = float(Columns.read(Path(tables[0])).t[-1])
    if until is None:
        faults.add("", f"until when? give {argument('until')}, the time of the end in seconds")
        faults.close(SimulateError)
        until = 0.0
    times = sample_times(until, every, faults)
    faults.close(SimulateError)
    return times


def _from_table(scene: Scene, table: Columns, laws: dict[str, Law], quasi: dict[str, Law], faults: Faults) -> None:
    """Add the laws of the columns of a table; those of forces, and of what the scene itself moves, are left alone."""
    found = [name for name in scene.coordinates if name in table.values]
    own = {name for joint in scene.joints if joint.motion is not None for name in joint.coordinates}
    wanted = [name for name in found if name not in own]
    rates = {velocity_name(name): name for name in scene.coordinates}
    known = {*scene.coordinates, *scene.velocities, *rates, *map(acceleration_name, (*scene.velocities, *rates))}
    known |= {one.name for one in scene.inputs}
    odd = [name for name in table.values if name not in known] if table.every else []
    for name in odd:
        faults.add(table.source, f"{name} is not a coordinate; {suggestion(name, scene.coordinates)}")
    if not found and not odd:
        faults.add(table.source, f"has no column of a coordinate; {scene.name} has {', '.join(scene.coordinates)}")
    for name in wanted:
        rate = velocity_name(name)
        if name in laws:
            faults.add(table.source, f"{name} has a law already, {laws[name].text}")
        laws[name] = column_law(table, name, rate, acceleration_name(rate))
    for name in scene.velocities:
        if name not in rates and name in table.values:
            quasi[name] = column_law(table, name, acceleration_name(name), "")
