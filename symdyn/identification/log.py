"""A log: measured coordinates and driving forces of a scene over time, read from columns by name and checked.

    t                       s
    q1, ...                 coordinates; rad or m
    q1_dot, ...             velocities, where they were measured; else they are differentiated
    q1_ddot, ...            accelerations, likewise
    tau1, F, ...            driving forces, as `drive_names` calls them: N m or N, what `simulate` writes

Other columns are left alone. All faults of all logs are told together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import IdentifyError, SimulateError
from symdyn.identification.units import in_si, looks_off
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Faults, acceleration_name, listed, nearest, shorten
from symdyn.simulation.prescribed import Columns, drive_names, read_entries

SHORTEST = 20
"""Rows that a log needs at least, so that something can be filtered."""

SHORTEST_STEP, LONGEST_STEP = 1e-15, 1e15
"""Between which samples are apart, s: what is beyond has no spectrum in doubles."""

LARGEST = 1e30
"""Size of what is measured, in SI: squares of it and of its derivatives are doubles."""


@dataclass(frozen=True)
class Log:
    """What was measured of one motion.

    Attributes:
        source: the file, or "data", for messages.
        t: times, s, shape (N,), strictly rising.
        q: coordinates, shape (N, nq); rad or m.
        qd: velocities, shape (N, nv), None where they are to be differentiated.
        qdd: accelerations, shape (N, nv), None likewise.
        tau: driving forces, shape (N, nv), zero where a joint is passive; N m or N, or what a drive shows instead.
        notes: what is doubtful, one line each.
    """

    source: str
    t: Array
    q: Array
    qd: Array | None
    qdd: Array | None
    tau: Array
    notes: tuple[str, ...] = ()


def read_logs(scene: Scene, data: Any, units: Mapping[str, str] | None = None) -> tuple[Log, ...]:
    """Return the logs that data hold.

    Args:
        scene: the mechanism.
        data: path of a CSV file, arrays by name, a data frame or run, or a list of such, a log each.
        units: of columns that are not in SI with radians, by name or pattern, such as {"q*": "deg"}.

    Raises:
        IdentifyError: with every fault, one line each.
    """
    if isinstance(data, Log):
        return (data,)
    if isinstance(data, Sequence) and not isinstance(data, str) and all(isinstance(one, Log) for one in data) and data:
        return tuple(data)
    faults = Faults("")
    try:
        said = read_entries(data, "data", faults, known(scene))
    except SimulateError as error:
        raise IdentifyError(error.faults) from None
    for where, name, _ in said.texts:
        faults.add(where, f"{name}: a log is a CSV file or arrays over t, not a formula")
    for name, _ in said.functions:
        faults.add("data", f"{name or 'a function'}: a log is a CSV file or arrays over t, not a function")
    if not said.tables and not faults.lines:
        faults.add("data", "is no log; give a CSV file with the columns t, " + ", ".join(expected(scene)))
    drives = [drive for drive in scene.drives if drive]
    tables = [in_si(table, units or {}, drives, SceneUnits(scene).letters, faults) for table in said.tables]
    logs = [one for table in tables if (one := _log(scene, table, faults)) is not None]
    faults.close(IdentifyError)
    return tuple(logs)


def expected(scene: Scene) -> tuple[str, ...]:
    """Return the columns beside t that a log of a scene must have."""
    return (*scene.coordinates, *(drive for drive in scene.drives if drive))


def known(scene: Scene) -> tuple[str, ...]:
    """Return all columns beside t that a log of a scene may have and that are read."""
    rates = scene.velocities
    return (*scene.coordinates, *rates, *(acceleration_name(name) for name in rates), *drive_names(scene))


def _log(scene: Scene, table: Columns, faults: Faults) -> Log | None:
    """Return one log, None after a fault."""
    source = table.source or "data"
    missing = [name for name in expected(scene) if name not in table.values]
    if missing:
        there = [name for name in table.values if name not in expected(scene)]
        meant = [f"{name} (did you mean {near}?)" if (near := nearest(name, there)) else name for name in missing]
        have = listed([shorten(name) for name in (TIME, *table.values)])
        need = ", ".join((TIME, *expected(scene)))
        faults.add(source, f"has no column {', '.join(meant)}; {scene.name} needs {need}, and it has {have}")
    if len(table.t) < SHORTEST:
        faults.add(source, f"has {len(table.t)} rows; at least {SHORTEST} are needed, some hundred are better")
    if missing or len(table.t) < SHORTEST:
        return None
    before = len(faults.lines)
    step = float(np.median(np.diff(table.t)))
    if not SHORTEST_STEP < step < LONGEST_STEP:
        faults.add(source, f"samples are {step:.3g} s apart, as no log's are; --units t=ms says that t is in ms")
    for name in [name for name in table.values if name in known(scene)]:
        if (most := float(np.abs(table.values[name]).max())) > LARGEST:
            faults.add(source, f"{name} goes to {most:.3g}, as nothing does that is measured; leave such rows out")
    if len(faults.lines) > before:
        return None
    notes: list[str] = []
    qd = _some(table.values, scene.velocities, source, notes)
    qdd = _some(table.values, [acceleration_name(name) for name in scene.velocities], source, notes)
    if qd is None and len(scene.velocities) != len(scene.coordinates):
        faults.add(source, f"has no column {', '.join(scene.velocities)}; velocities of quaternions are to be measured")
        return None
    q = np.stack([table.values[name] for name in scene.coordinates], axis=-1)
    still = np.zeros(len(table.t))
    tau = np.stack([table.values.get(name, still) for name in drive_names(scene)], axis=-1)
    notes += looks_off(scene, source, table.t, q, qd, faults)
    idle = [drive for k, drive in enumerate(scene.drives) if drive and not tau[:, k].any()]
    if idle:
        notes.append(f"{source}: {', '.join(idle)} is zero all the time")
    return Log(source, table.t, q, qd, qdd, tau, tuple(notes))


def _some(values: Mapping[str, Array], names: Sequence[str], source: str, notes: list[str]) -> Array | None:
    """Return columns that may be left out, None where one is, which is noted where others are there."""
    there = [name for name in names if name in values]
    if len(there) == len(names):
        return np.stack([values[name] for name in names], axis=-1)
    if there:
        lacking = ", ".join(name for name in names if name not in values)
        notes.append(f"{source}: has {', '.join(there)} and not {lacking}; all of them are differentiated")
    return None
