"""The motion of a scene: a law a coordinate, from formulas, named laws, TOML or CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.errors import SimulateError
from symdyn.scene import Scene, acceleration_name, velocity_name
from symdyn.scene.toml import tables_of
from symdyn.scene.values.names import suggestion
from symdyn.scene.values.table import Faults, show
from symdyn.simulation.prescribed.formulas_in_time import close, noted, parameter_values, read_file, words
from symdyn.simulation.prescribed.motion_laws import Law, column_law, read_law
from symdyn.simulation.prescribed.numbers_in_time import Columns, read_columns, sample_times


@dataclass(frozen=True)
class SceneMotion:
    """Laws by coordinate; where one has none, it rests at its start, or follows the others through closed loops.

    Attributes:
        laws: by name of the coordinate.
        quasi: laws of velocities that are no rates of coordinates (a quaternion's), where a table gives them.
    """

    laws: Mapping[str, Law] = field(default_factory=dict)
    quasi: Mapping[str, Law] = field(default_factory=dict)

    @property
    def span(self) -> tuple[float, float]:
        """First and last time at which all laws are known."""
        spans = [law.span for law in (*self.laws.values(), *self.quasi.values())]
        return max((low for low, _ in spans), default=-np.inf), min((high for _, high in spans), default=np.inf)


def read_motion(scene: Scene, entries: str | Sequence[str] | Mapping[str, str]) -> SceneMotion:
    """Return the motion that words and files say.

    Args:
        scene: the mechanism, its parameters bound.
        entries: `name=law` for a coordinate, a .toml file of such lines, or a .csv file of columns t, q1, ... with
            rates q1_dot and accelerations q1_ddot where they are known. One or several; or laws by name.

    Raises:
        SimulateError: with every fault, one line each.
    """
    values = parameter_values(scene)
    faults = Faults("")
    laws: dict[str, Law] = {}
    quasi: dict[str, Law] = {}
    texts, tables = split_entries(listed(entries, "motion"), "motion", faults)
    known = scene.coordinates
    for where, name, text in texts:
        if name not in known:
            faults.add(where, f"{name} is not a coordinate; {suggestion(name, known)}")
            continue
        if name in laws:
            faults.add(where, f"{name} has a law already, {laws[name].text}")
        law = read_law(text, values, f"{where}: {name}", faults)
        if law is not None:
            laws[name] = law
    for table in tables:
        _from_table(scene, table, laws, quasi, faults)
    for group in quaternions(scene):
        missing = [name for name in group if name not in laws]
        if missing and len(missing) < len(group):
            faults.add("motion", f"{', '.join(missing)} missing; a quaternion moves as ({', '.join(group)})")
    close(faults)
    return SceneMotion(laws, quasi)


def motion_times(entries: Sequence[str], until: float | None, every: float | None) -> Array:
    """Return the times of samples: those asked for, else the rows of the one table among `entries`.

    Raises:
        SimulateError: neither a time of the end nor one table, or times that are none.
    """
    faults = Faults("")
    tables = [entry for entry in entries if "=" not in entry and Path(entry).suffix.lower() == ".csv"]
    if until is None and len(tables) == 1 and every is None:
        return read_columns(Path(tables[0])).t
    if until is None and len(tables) == 1:
        until = float(read_columns(Path(tables[0])).t[-1])
    if until is None:
        faults.add("", "until when? give --until, the time of the end in seconds")
        close(faults)
        until = 0.0
    times = sample_times(until, every, faults)
    close(faults)
    return times


def _from_table(scene: Scene, table: Columns, laws: dict[str, Law], quasi: dict[str, Law], faults: Faults) -> None:
    """Add the laws of the columns of a table; those of forces, and of what the scene itself moves, are left alone."""
    found = [name for name in scene.coordinates if name in table.values]
    own = {name for joint in scene.joints if joint.motion is not None for name in joint.coordinates}
    wanted = [name for name in found if name not in own]
    if not found:
        faults.add(table.source, f"has no column of a coordinate; {scene.name} has {', '.join(scene.coordinates)}")
    for name in wanted:
        rate = velocity_name(name)
        if name in laws:
            faults.add(table.source, f"{name} has a law already, {laws[name].text}")
        laws[name] = column_law(table, name, rate, acceleration_name(rate))
    rates = {velocity_name(name) for name in scene.coordinates}
    for name in scene.velocities:
        if name not in rates and name in table.values:
            quasi[name] = column_law(table, name, acceleration_name(name), "")


def listed(entries: object, table: str) -> tuple[str, ...]:
    """Return what may be given as one entry, several, or formulas by name, as entries.

    Raises:
        SimulateError: it is something else.
    """
    if isinstance(entries, str):
        return (entries,)
    if isinstance(entries, Mapping):
        return tuple(f"{name}={text}" for name, text in entries.items())
    if isinstance(entries, Sequence) and all(isinstance(entry, str) for entry in entries):
        return tuple(entries)
    raise SimulateError(
        f'{table}: a {type(entries).__name__} says no {table}; give formulas such as "name = 2*t" as text, several in '
        "a list or by name, or the name of a .toml or .csv file"
    )


def split_entries(
    entries: Sequence[str], table: str, faults: Faults
) -> tuple[list[tuple[str, str, str]], list[Columns]]:
    """Return what words and .toml files say as (where, name, text), and tables of .csv files; `table` is the option."""
    texts: list[tuple[str, str, str]] = []
    tables: list[Columns] = []
    plain: list[str] = []
    for entry in entries:
        suffix = "" if "=" in entry else Path(entry).suffix.lower()
        with noted(faults):
            if suffix == ".csv":
                tables.append(read_columns(Path(entry)))
            elif suffix == ".toml":
                texts += [(entry, name, text) for name, text in _toml(Path(entry), table, faults)]
            else:
                plain.append(entry)
    texts += [(table, name, text) for name, text in words(plain, table, faults).items()]
    return texts, tables


def _toml(path: Path, table: str, faults: Faults) -> list[tuple[str, str]]:
    """Return name and text of every entry of a TOML file, under [table] or without it."""
    root = tables_of(read_file(path), str(path))
    inner = root.get(table, root)
    if not isinstance(inner, Mapping):
        faults.add(str(path), f"{table} = {show(inner)} is not a table; write [{table}] and name = law below")
        return []
    found = []
    for name, value in inner.items():
        if isinstance(value, (str, int, Decimal)) and not isinstance(value, bool):
            found.append((name, str(value)))
        else:
            faults.add(str(path), f"{name} = {show(value)} is neither a number nor a formula in quotes")
    return found
