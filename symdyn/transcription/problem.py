"""From a scene and what is asked of its motion to a problem in numbers: the function `collocation`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from operator import index

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import SimulateError
from symdyn.scene import Quantity, Scene, SceneLike, SceneUnits
from symdyn.scene.values import Faults, FormulaError, spell, suggestion
from symdyn.simulation import Problem, Start
from symdyn.simulation.prescribed import drive_names, parameter_values, read_formula
from symdyn.transcription.grid import grid
from symdyn.transcription.layout import Layout, Number, Range, ends_of, known_names
from symdyn.transcription.remarks import remarks, taken
from symdyn.transcription.source import source
from symdyn.transcription.tableaux import METHODS
from symdyn.transcription.transcribed import Collocation

MOST = 100_000
"""Intervals that are more than anybody solves."""


def collocation(
    scene: SceneLike | Problem,
    until: float | tuple[float, float],
    intervals: int | Sequence[float] = 50,
    method: str = "hermite_simpson",
    cost: str = "",
    final_cost: str = "",
    start: Mapping[str, Number] | Start | None = None,
    start_rates: Mapping[str, Number] | None = None,
    end: Mapping[str, Number] | None = None,
    end_rates: Mapping[str, Number] | None = None,
    bounds: Mapping[str, Range] | None = None,
    path: Mapping[str, Range] | None = None,
    free: str | Sequence[str] = (),
) -> Collocation:
    """Return the equations of a motion that is looked for, from a start to an end, as a problem in numbers.

    Formulas are in t, coordinates, velocities, parameters, drives by their names (`tau_` and the coordinate for one
    without), and points of the scene as `point_tip_x`.

    >>> import symdyn
    >>> problem = symdyn.collocation(symdyn.example("cart_pole"), until=2, intervals=10, cost="F**2",
    ...     end={"x": 1})
    >>> problem
    <Collocation of cart_pole: 10 intervals of 2 s in all; 147 unknowns, 122 equations; looked for: F>
    >>> problem.guess.shape
    (147,)

    Args:
        scene: the mechanism, its parameters bound; or a `Problem`, without forces. Its drives are unknowns, its inputs
            held where the scene has them.
        until: time of the end, s; or between which two it is looked for.
        intervals: how many of equal length; or the shares of time where they end, 0 … 1.
        method: a key of `METHODS`.
        cost: what is integrated over time and made small.
        final_cost: what is made small at the end, without drives.
        start: coordinates at t = 0, as for `simulate`; what is not given is as the scene says, nothing is free.
        start_rates: velocities, likewise.
        end: coordinates that are given at the end; the others are free.
        end_rates: velocities, likewise.
        bounds: smallest and largest value by the name of a coordinate, velocity, drive or parameter that is free; None
            for none. They narrow those of the joints' limits.
        path: smallest and largest value of formulas without drives, held at all ends of intervals.
        free: name of a parameter that is an unknown, or names; the scene's values are their guess.

    Raises:
        SimulateError: with every fault of the arguments, one line each.
        DerivationError: the equations do not exist, or have no derivative.
    """
    problem, _ = Problem.requested(collocation, locals(), "until", "method")
    declared = problem.refused("drives are looked for, and inputs held", "forces").scene
    if not declared.velocities:
        raise SimulateError(f"{declared.name}: nothing moves: no joint has a coordinate")
    try:
        problem = replace(problem, scene=declared.held())
    except FormulaError as fault:
        raise SimulateError(f"{declared.name}: an input that the scene holds: {fault}") from None
    scene, faults = problem.scene, Faults("")
    first = faults.taken(lambda: problem.initial, Start(np.zeros(0), np.zeros(0)))
    values = parameter_values(scene)
    mesh = _mesh(intervals, faults)
    free = (free,) if isinstance(free, str) else tuple(dict.fromkeys(free))
    if method not in METHODS:
        faults.add("", f"method {method} is not known; {suggestion(method, METHODS)}")
    known_names("free", free, values, faults)
    span = _span(until, faults)
    state = (TIME, *scene.coordinates, *scene.velocities, *values, *scene.point_letters)
    formulas = {
        "path": _formulas(scene, tuple(path or ()), state, "path", faults),
        "running": _formulas(scene, (cost,) if cost else (), (*state, *_drives(scene)), "cost", faults),
        "final": _formulas(scene, (final_cost,) if final_cost else (), state, "final cost", faults),
    }
    faults.close(SimulateError)
    functions = source(scene, free, tuple(formulas.items()))
    found = functions.written
    made = Layout(scene, free, found, grid(METHODS[method], mesh), len(formulas["path"]), span)
    lower, upper = made.bounded(first, bounds or {}, values, faults)
    last = made.ended(end or {}, end_rates or {}, values, lower, upper, faults)
    around = np.array([ends_of(one, f"path: {name}", faults) for name, one in (path or {}).items()]).reshape(-1, 2)
    faults.close(SimulateError)
    rows_lower, rows_upper = np.zeros(made.rows), np.zeros(made.rows)
    rows_lower[made.row["path"]], rows_upper[made.row["path"]] = around.T
    guess = np.clip(made.guessed(first, last, values), lower, upper)
    given = {"start": problem.start, "start rates": problem.start_rates, "end": end, "end rates": end_rates}
    kept = tuple(f"input {one.name} is held at {spell(one.value)} {one.unit}".rstrip() for one in declared.inputs)
    notes = (*kept, *first.notes, *taken(scene, free, {k: x for k, x in given.items() if isinstance(x, Mapping)}))
    return Collocation(
        scene, METHODS[method], made.grid, free, tuple(made.names[k] for k in found.driven), found.driven,
        made.place, made.row, made.size, made.rows, sum(span) / 2, lower, upper, rows_lower, rows_upper, guess,
        functions, (*notes, *remarks(functions)),
    )  # fmt: skip


def _drives(scene: Scene) -> list[str]:
    return [name for name, drive in zip(drive_names(scene), scene.drives, strict=True) if drive]


def _mesh(intervals: int | Sequence[float], faults: Faults) -> Array:
    """Return where intervals end, shares of time, shape (N + 1,)."""
    words = "are a number of them, or rising shares of time from 0 to 1, such as [0, 0.25, 1]"
    try:
        count = index(intervals)  # type: ignore[arg-type]
    except TypeError:
        count = -1
    if 1 <= count <= MOST:
        return np.linspace(0.0, 1.0, count + 1)
    try:
        mesh = np.asarray(intervals, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        mesh = np.zeros(0)
    if mesh.ndim == 1 and 2 <= len(mesh) <= MOST and mesh[0] == 0 and mesh[-1] == 1 and np.all(np.diff(mesh) > 0):
        return mesh
    faults.add("", f"intervals = {intervals}: they {words}; {MOST} are the most")
    return np.linspace(0.0, 1.0, 2)


def _span(until: float | tuple[float, float], faults: Faults) -> tuple[float, float]:
    """Return the smallest and the largest time of the end."""
    try:
        least, most = (float(x) for x in (until if isinstance(until, Sequence) else (until, until)))
    except (TypeError, ValueError):
        least, most = 0.0, 0.0
    if not 0 < least <= most < np.inf:
        faults.add("", f"until = {until} is no time after the start; give a positive one, or a smaller and a larger")
        return 1.0, 1.0
    return least, most


def _formulas(
    scene: Scene, texts: Sequence[str], allowed: Sequence[str], where: str, faults: Faults
) -> tuple[Quantity, ...]:
    read = [read_formula(text, allowed, where, faults) for text in texts]
    found = tuple(one for one in read if one is not None)
    for one in found:
        SceneUnits(scene).check(one, where, faults)
    return found
