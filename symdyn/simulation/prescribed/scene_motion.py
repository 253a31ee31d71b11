"""The motion of a scene: a law a coordinate, from formulas, named laws, TOML or CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import quaternions
from symdyn.errors import SimulateError
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Faults, acceleration_name, suggestion, velocity_name
from symdyn.simulation.prescribed.entries import Entries, read_entries
from symdyn.simulation.prescribed.forces import ForceTable
from symdyn.simulation.prescribed.formulas_in_time import parameter_values
from symdyn.simulation.prescribed.function_laws import read_function
from symdyn.simulation.prescribed.motion_laws import Law, column_law, read_law
from symdyn.simulation.prescribed.numbers_in_time import Columns, sample_times


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
    for where, name, read in [
        *((where, name, partial(read_law, text, values, unit=units.get(name, ""))) for where, name, text in said.texts),
        *(("motion", name, partial(read_function, law)) for name, law in said.functions),
    ]:
        if name not in known:
            whose = f"{name} is not a coordinate" if name else "a function moves a coordinate; give it by name"
            faults.add(where, f"{whose}; {suggestion(name, known)}")
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
    letters = [(one.name, table) for one in scene.inputs for table in said.tables if one.name in table.values]
    return SceneMotion(laws, quasi, {name: ForceTable(table.t, table.values[name]) for name, table in letters})


def motion_times(entries: Sequence[str], paths: Sequence[str], until: float | None, every: float | None) -> Array:
    """Return the times of samples: those asked for, else the rows of the one table of motions and paths.

    Raises:
        SimulateError: neither a time of the end nor one table, or times that are none.
    """
    faults = Faults("")
    named = [(entry.partition("=")[2] or entry).strip() for entry in paths]  # points have tables too, after their names
    tables = [entry for entry in (*entries, *named) if "=" not in entry and Path(entry).suffix.lower() == ".csv"]
    if until is None and len(tables) == 1 and every is None:
        return Columns.read(Path(tables[0])).t
    if until is None and len(tables) == 1:
        until = float(Columns.read(Path(tables[0])).t[-1])
    if until is None:
        faults.add("", "until when? give --until, the time of the end in seconds")
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
