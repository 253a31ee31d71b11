"""Paths of points and frames as a user says them: laws, tables, files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from symdyn.errors import SimulateError
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Faults, split_commas, suggestion
from symdyn.simulation.prescribed.entries import Entries, read_entries
from symdyn.simulation.prescribed.formulas_in_time import parameter_values
from symdyn.simulation.prescribed.motion_laws import Law, column_law, read_law
from symdyn.simulation.prescribed.numbers_in_time import Columns, columns_of, counted
from symdyn.simulation.prescribed.point_path import TURNS, PointPath, ScenePath

FREE = "_"
AXES = "xyz"
WAYS = 'give text, such as "0.5, 0.1*t, _", or (times, x), x of shape (N, 3), or (N, 7) with a quaternion behind'


def read_path(scene: Scene, entries: Entries) -> ScenePath:
    """Return the paths that words and files say.

    Args:
        scene: the mechanism, its parameters bound.
        entries: `point=x, y, z` as the legend of point_path.py says, or a .toml file of such lines under [path];
            one or several, or by name, where (times, values) of shapes (N,) and (N, 3), or (N, 7) with a quaternion
            behind, are one too.

    Raises:
        SimulateError: with every fault, one line each.
    """
    values, faults = parameter_values(scene), Faults("")
    found: dict[str, PointPath] = {}
    if isinstance(entries, Mapping):
        for name, x in entries.items():
            if isinstance(x, tuple) and len(x) == 2 and _is_table(x[1]):
                _add(found, name, "path", _from_arrays(str(name), *x, faults), scene, faults)
            elif not isinstance(x, (str, Path)) and not callable(x):
                faults.add(f"path: {name}", f"{type(x).__name__} is no path; {WAYS}")
        entries = {name: x for name, x in entries.items() if isinstance(x, (str, Path)) or callable(x)}
    said = read_entries(entries, "path", faults)
    for one in said.tables:
        faults.add(one.source, "whose path is it? write POINT=FILE.csv, or give (times, values) by name")
    for name, _ in said.functions:
        faults.add(f"path: {name}" if name else "path", f"a function is no path; {WAYS}")
    for where, name, text in said.texts:
        if text.lower().endswith(".csv"):
            path = _from_file(name, text, faults)
        else:
            path = _from_laws(name, text, values, f"{where}: {name}", faults)
        _add(found, name, where, path, scene, faults)
    faults.close(SimulateError)
    return ScenePath(tuple(found.values()))


def _is_table(values: object) -> bool:
    """Tell whether values are rows of numbers."""
    try:
        return np.ndim(values) == 2  # type: ignore[arg-type]
    except ValueError:  # rows of several lengths; whoever reads entries refuses them
        return False


def _add(
    result: dict[str, PointPath], name: str, where: str, path: PointPath | None, scene: Scene, faults: Faults
) -> None:
    known = (*(one.name for one in scene.points), *(one.name for one in scene.bodies))
    if name not in known:
        faults.add(where, f"{name} is no point and no body; {suggestion(name, known)}")
    elif name in result:
        faults.add(where, f"{name} has a path already")
    elif path is not None:
        result[name] = path


def _from_laws(name: str, text: str, values: Mapping[str, Quantity], where: str, faults: Faults) -> PointPath | None:
    before, parts = len(faults.lines), [part.strip() for part in split_commas(text)]
    if len(parts) not in (3, 4):
        faults.add(
            where,
            f'"{text}" has {counted(len(parts), "part")}; a path is x, y, z, such as {name}=0.5, 0.1*t, _ where _ is '
            "free, and rpy(roll, pitch, yaw), quaternion(w, x, y, z) or pointing(z, a, b, c) behind them if it is to "
            "be turned",
        )
        return None
    origin = tuple(None if part == FREE else read_law(part, values, where, faults, "m") for part in parts[:3])
    way, turning, axis = "", list[Law | None](), None
    if len(parts) == 4 and parts[3] != FREE:
        word, bracket, rest = parts[3].partition("(")
        way, inside = word.strip(), split_commas(rest.rstrip().removesuffix(")"))
        if way in TURNS and not (bracket and rest.rstrip().endswith(")")):
            faults.add(where, f'"{parts[3]}" lacks a bracket; write {way}({_takes(way)})')
            return None
        if way not in TURNS:
            faults.add(where, f'"{parts[3]}" says no turning; {suggestion(way, tuple(TURNS))}')
            return None
        if way == "pointing":
            letter, inside = inside[0].strip() if inside else "", inside[1:]
            axis = AXES.find(letter) if len(letter) == 1 else -1
            if letter and axis < 0:
                faults.add(where, f'"{parts[3]}": {letter} is no axis; write pointing(z, 0, 0, -1)')
        if len(inside) != len(TURNS[way]):
            faults.add(where, f'"{parts[3]}": {way} takes ({_takes(way)})')
        else:
            turning = [read_law(part, values, where, faults, "rad") for part in inside]
    if not way and all(law is None for law in origin):
        faults.add(where, f'"{text}" asks for nothing; give a component')
    if len(faults.lines) > before:
        return None
    return PointPath(name, origin, way, tuple(law for law in turning if law is not None), axis)


def _takes(way: str) -> str:
    return "axis, a, b, c" if way == "pointing" else ", ".join(TURNS[way])


def _from_file(name: str, text: str, faults: Faults) -> PointPath | None:
    try:
        table = Columns.read(Path(text))
    except SimulateError as error:
        faults.lines += error.faults
        return None
    return _from_columns(name, table, faults)


def _from_arrays(name: str, times: object, values: object, faults: Faults) -> PointPath | None:
    names, rows = (*AXES, *TURNS["quaternion"]), np.asarray(values)
    if rows.shape[1] not in (3, 7):
        faults.add(
            f"path: {name}", f"an array of shape {rows.shape} is no path; give x, y, z, or w, x, y, z behind them"
        )
        return None
    with faults.noted():
        return _from_columns(name, columns_of(f"path: {name}", times, dict(zip(names, rows.T, strict=False))), faults)
    return None


def _from_columns(name: str, table: Columns, faults: Faults) -> PointPath | None:
    before = len(faults.lines)
    prefixes = [one for one in (f"point_{name}_", "") if any(one + axis in table.values for axis in AXES)]
    prefix = prefixes[0] if prefixes else ""
    origin = tuple(_column(table, prefix + axis) for axis in AXES)
    ways = [
        (way, laws)
        for way in ("rpy", "quaternion")
        for own in dict.fromkeys((prefix, f"point_{name}_", ""))
        if any(laws := [_column(table, own + one) for one in TURNS[way]])
    ]
    way, turning = ways[0] if ways else ("", [])
    missing = [one for one, law in zip(TURNS.get(way, ()), turning, strict=True) if law is None]
    if missing:
        faults.add(table.source, f"{', '.join(missing)} missing; a frame is turned by ({', '.join(TURNS[way])})")
    if not way and all(law is None for law in origin):
        faults.add(table.source, f"has no column of a place, x, y, z or point_{name}_x, ..., and none of a turning")
    if len(faults.lines) > before:
        return None
    return PointPath(name, origin, way, tuple(law for law in turning if law is not None))


def _column(table: Columns, name: str) -> Law | None:
    return column_law(table, name, f"{name}_dot", f"{name}_ddot") if name in table.values else None
