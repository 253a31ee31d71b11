"""How what a motion takes depends on parameters, the motion being held.

Driving forces have their derivatives as an output of their own. Where the motion itself moves with a parameter (a path
that joints follow, a motion that the scene prescribes), and for other columns, the forces are told on both sides.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import LoopChoices, Workspace, derive_one
from symdyn.errors import DerivationError, SimulateError
from symdyn.runtime import lambdify
from symdyn.simulation.equations.parametrised import opened
from symdyn.simulation.prescribed.forces import drive_names
from symdyn.simulation.prescribed.scene_motion import SceneMotion
from symdyn.simulation.trajectory import Trajectory

DERIVATIVES = "inverse_dynamics_by_parameters"

STEP = 1e-5
"""Part of a parameter's size, or 1, by which it is moved to both sides."""


def force_slopes(
    run: Trajectory,
    reported: Callable[[Mapping[str, float]], Trajectory],
    motion: SceneMotion,
    plain: bool,
    columns: Sequence[str],
    names: Sequence[str],
) -> tuple[Array, tuple[str, ...]]:
    """Return derivatives of columns by parameters, shape (N, columns, k), and notes.

    Args:
        run: the motion at the means.
        reported: the same at other values of parameters.
        motion: its laws.
        plain: whether no path is followed.
        columns: of the run.
        names: of parameters.

    Raises:
        SimulateError: a parameter that decides the form of the equations.
    """
    drives = drive_names(run.scene)
    exact = _exact(run, motion, names) if plain else None
    found = np.zeros((len(run.t), len(columns), len(names)))
    beside = [name for name in columns if exact is None or name not in drives]
    for j, name in enumerate(columns):
        if name not in beside and exact is not None:
            found[:, j] = exact[:, drives.index(name)]
    if not beside:
        return found, ()
    values = opened(run.scene).values
    at = [columns.index(name) for name in beside]
    for k, name in enumerate(names):
        step = STEP * (abs(values[name]) or 1.0)
        sides = [reported({name: values[name] + sign * step}) for sign in (1, -1)]
        if any(len(one.t) < len(run.t) for one in sides):
            raise SimulateError(f"{run.scene.name}: next to {name} = {values[name]:g} the motion has no forces")
        found[:, at, k] = np.array([(sides[0][one] - sides[1][one]) / (2 * step) for one in beside]).T
    return found, (f"by differences, not by derivatives: {', '.join(beside)}",)


def _exact(run: Trajectory, motion: SceneMotion, names: Sequence[str]) -> Array | None:
    """Return ∂τ/∂p, shape (N, nv, k), by its own output; None where there is none along this motion."""
    scene = run.scene
    if scene.led_velocities:
        return None
    given = tuple(name for name in scene.coordinates if name in motion.laws) if scene.is_closed else ()
    choices = LoopChoices(independent=given)
    try:
        labels = derive_one(Workspace(scene, choices), DERIVATIVES).labels
        call = lambdify(scene, DERIVATIVES, closing=choices)
    except DerivationError:
        return None
    columns = labels[1]
    fixed = [name for name in names if name not in columns]
    if fixed:
        raise SimulateError(f"{scene.name}: {', '.join(fixed)} stands in no equation, as zero does; give such as 1e-9")
    known: dict[str, Array] = {"q": run.q, "qd": run.qd, "qdd": run.qdd, "t": run.t, "inputs": run.inputs}
    slopes = call(*(known[one.name] for one in call.operands))
    slopes = np.broadcast_to(slopes, (len(run.t), len(scene.velocities), len(columns)))
    return np.asarray(slopes[:, :, [columns.index(name) for name in names]])
