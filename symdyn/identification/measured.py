"""Columns of a log that output error takes: times, some coordinates and velocities, forces; and where a run starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import SimulateError
from symdyn.scene import Scene
from symdyn.scene.values import Faults, listed, suggestion, velocity_name
from symdyn.simulation import Forces, Problem
from symdyn.simulation.prescribed import Columns, Entries, drive_names, read_entries

FEWEST = 10
"""Samples that a piece has at least."""

FIRST = 12
"""Samples, at most, through which a line or a parabola guesses where a piece starts."""


@dataclass(frozen=True)
class Measured:
    """A piece of a log.

    Attributes:
        t: times, s, shape (N,).
        x: what was measured, shape (N, m).
        forces: what drives the mechanism.
    """

    t: Array
    x: Array
    forces: Forces


def read_measured(
    problem: Problem, data: Entries, measured: Sequence[str] | None, pieces: int
) -> tuple[tuple[str, ...], tuple[Measured, ...], tuple[str, ...]]:
    """Return the names of the columns that are fitted, the pieces of all logs, and notes.

    Args:
        problem: the mechanism, and what is known of driving forces beside the columns of the logs.
        data: files, arrays by name or tables, one a log.
        measured: names of the columns that are fitted; None for all coordinates and velocities that the logs have.
        pieces: into how many pieces, of a start each, every log is cut.

    Raises:
        SimulateError: with every fault, one line each.
    """
    scene, forces, faults = problem.scene, problem.forces, Faults("")
    known = (*scene.coordinates, *scene.velocities)
    if isinstance(forces, Forces):
        raise SimulateError("forces: logs give some of them; give the others as text or by name, not read")
    logs = [data] if not isinstance(data, (list, tuple)) else data
    tables = list[Columns]()
    for one in logs:
        said = read_entries(one, "data", faults, (*known, *drive_names(scene), *(given.name for given in scene.inputs)))
        tables += said.tables
        if said.texts or said.functions:
            faults.add("data", "formulas and functions measure nothing; give a .csv file, arrays by name, or a table")
    if not tables and not faults.lines:
        faults.add("data", "there is no log; give a .csv file, arrays by name with t, or a table")
    faults.close(SimulateError)
    for name in measured or ():
        if name not in known:
            faults.add("measured", f"{name} is no coordinate or velocity; {suggestion(name, known)}")
    here = [name for name in known if all(name in one.values for one in tables)]
    names = tuple(here if measured is None else dict.fromkeys(measured))
    for one in tables:
        lost = [name for name in names if name not in one.values]
        there = f"it has {listed(tuple(one.values))}" if one.values else "it has none beside t"
        if lost or not names:
            what = f"the column {lost[0]}" if lost else f"column of {listed(known)} that all logs have"
            faults.add(one.source, f"has no {what.removeprefix('the ')}; {there}")
        if len(one.t) < FEWEST * pieces:
            faults.add(one.source, f"has {len(one.t)} rows; {FEWEST} a piece, {FEWEST * pieces} at least, are needed")
    if pieces < 1:
        faults.add("pieces", f"{pieces} is no number of pieces; give 1 or more")
    faults.close(SimulateError)
    found, notes = list[Measured](), dict[str, None]()
    for one in tables:
        drives = [name for name, drive in zip(drive_names(scene), scene.drives, strict=True) if drive]
        drives += [letter.name for letter in scene.inputs]
        columns = {name: one.values[name] for name in drives if name in one.values}
        given = Forces()
        with faults.noted():
            entries = [*forces] if isinstance(forces, list | tuple) else [forces]
            entries += [{TIME: one.t, **columns}] if columns else []
            given = replace(problem, forces=entries).driving
        silent = [name for k, name in enumerate(drives) if name not in columns and k not in given.formulas]
        if silent and "forces" not in problem.given:
            notes[f"{one.source}: no column of {listed(silent)}, which is taken as zero"] = None
        for part in np.array_split(np.arange(len(one.t)), pieces):
            x = np.column_stack([one.values[name][part] for name in names])
            found.append(Measured(one.t[part], x, given))
    faults.close(SimulateError)
    return names, tuple(found), tuple(notes)


def first_state(
    scene: Scene, names: Sequence[str], piece: Measured, guess: tuple[dict[str, Any], dict[str, Any]]
) -> tuple[Array, tuple[str, ...]]:
    """Return a guess of the state at the first sample, shape (nx,), and notes.

    What is measured is read off the first samples, positions' rates too; the rest is as the user says, or the scene.

    Raises:
        SimulateError: with every fault, one line each.
    """
    count = min(FIRST, len(piece.t))
    s = piece.t[:count] - piece.t[0]
    start, rates = dict[str, Any](), dict[str, Any]()
    for name, x in zip(names, piece.x[:count].T, strict=True):
        parts = np.polynomial.polynomial.polyfit(s / s[-1], x, min(2, count - 1))
        if name in scene.coordinates:
            start[name] = float(parts[0])
            rate = velocity_name(name)
            if rate in scene.velocities and rate not in names:
                rates[rate] = float(parts[1] / s[-1])
        else:
            rates[name] = float(parts[0])
    found = Problem(scene, (), start | guess[0], rates | guess[1]).initial
    return np.concatenate([found.q, found.u]), found.notes
