"""What is uncertain in parameters and starts, carried to a run, or to what a motion takes, to first order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.scene import Scene
from symdyn.simulation.columns import FORCES
from symdyn.simulation.error_bars import Uncertainty
from symdyn.simulation.force_slopes import force_slopes
from symdyn.simulation.forward import simulate
from symdyn.simulation.initial import Values, read_start
from symdyn.simulation.inverse_run import inverse
from symdyn.simulation.panels import chosen
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.forces import Forces, read_forces
from symdyn.simulation.prescribed.path_entries import read_path
from symdyn.simulation.prescribed.scene_motion import read_motion
from symdyn.simulation.trajectory import Trajectory
from symdyn.simulation.variations import UNTOLD, variations

USUAL = ("coordinates", "velocities", "outputs", FORCES)
"""Kinds of columns whose uncertainty is told where nobody chooses."""


def uncertain_run(
    scene: Scene,
    names: Sequence[str],
    covariance: Array,
    forces: Forces | Entries,
    until: float,
    start: Values | None,
    start_rates: Values | None,
    every: float | None,
    wanted: Sequence[str],
) -> Uncertainty:
    """Return the uncertainty of a run by that of `names`, shape (k,), of this covariance, shape (k, k).

    `wanted` are columns or patterns, none for the usual ones; other arguments as of `simulate`.

    Raises:
        SimulateError: with every fault of the arguments; forces that have no derivative; or a run that fails.
        UnknownNameError: a column that is none.
    """
    given = forces if isinstance(forces, Forces) else read_forces(scene, forces)
    initial = read_start(scene, start, start_rates)
    notes: list[str] = []
    run = simulate(scene, given, until, initial, every=every, say=notes.append)
    if len(run.t) < 2 and run.complete:
        raise SimulateError(f"{scene.name}: every = {every}: the run to {until:g} s has one sample; give less")
    if len(run.t) < 2:
        raise SimulateError(f"{scene.name}: {run.stopped}; there is nothing to tell the uncertainty of")
    found = variations(run, given, initial, names)
    columns = _columns(run, wanted)
    said = () if run.complete else (f"{run.stopped}: the uncertainty is that of the rows until then",)
    return Uncertainty(run, tuple(names), covariance, columns, found.slopes(columns), (*run.notes, *said))


def _columns(run: Trajectory, wanted: Sequence[str]) -> tuple[str, ...]:
    """Return the columns that are chosen, or the usual ones."""
    if wanted:
        names = chosen(run.names, wanted, run.scene.name)
        lacking = [name for name in names if name in UNTOLD or name == "t"]
        if lacking:
            raise SimulateError(f"{run.scene.name}: {', '.join(lacking)} has no uncertainty that could be told")
        return names
    moving = {one.name for one in run.columns if one.kind == FORCES and run[one.name].any()}
    return tuple(one.name for one in run.columns if one.kind in USUAL and (one.kind != FORCES or one.name in moving))


def uncertain_forces(
    scene: Scene,
    names: Sequence[str],
    covariance: Array,
    motion: Entries,
    path: Entries,
    times: npt.ArrayLike,
    start: Values | None,
    forces: Forces | Entries,
    wanted: Sequence[str],
) -> Uncertainty:
    """Return the uncertainty of what a motion takes; arguments as of `uncertain_run` and `inverse`."""
    laws, ways = read_motion(scene, motion), read_path(scene, path)
    notes: list[str] = []

    def told(values: Mapping[str, float]) -> Trajectory:
        return inverse(scene, laws, times, say=notes.append, values=values, path=ways, start=start, forces=forces)

    run = told({})
    columns = chosen(run.names, wanted, scene.name) if wanted else _columns(run, ())
    if not wanted:
        columns = tuple(name for name in columns if name not in (*scene.coordinates, *scene.velocities))
    slopes, said = force_slopes(run, told, laws, not ways.points, columns, names)
    return Uncertainty(run, tuple(names), covariance, columns, slopes, (*run.notes, *said))
