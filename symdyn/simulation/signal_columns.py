"""Columns of a motion that a person names: inputs, and outputs as their formulas say, from the columns of the motion.

Functions called `outputs` are derived, `output:NAME` by two formulations; these columns are worked out from places,
reactions and forces as they came out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import SimulateError
from symdyn.graph import Graph, evaluate
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import LETTERS, suggestion
from symdyn.simulation.equations.parametrised import opened
from symdyn.simulation.prescribed.forces import ForceFunction, Forces
from symdyn.simulation.reaction_columns import multiplier_columns, reaction_columns
from symdyn.simulation.trajectory import Trajectory


def output_columns(motion: Trajectory, given: bool) -> dict[str, Array]:
    """Return the outputs of the scene by name, each of shape (N,); `given` as for `reaction_columns`.

    Raises:
        SimulateError: a reaction or multiplier that there is not.
    """
    scene = motion.scene
    if not scene.outputs:
        return {}
    named = dict.fromkeys(name for one in scene.outputs for name in one.formula.symbols)
    known: dict[str, Array] = dict(zip(motion.names, motion.table()[1].T, strict=True))
    axes = scene.reaction_axes
    for one in dict.fromkeys(axes[name] for name in named if name in axes):
        known |= reaction_columns(motion, given, one)
    if any(name.startswith(LETTERS.multiplier) for name in named):
        known |= multiplier_columns(motion)
    known |= {name: np.asarray(value) for name, value in opened(scene).values.items()}
    for name in named:
        if name not in known:
            raise SimulateError(f"{scene.name}: outputs: {name} is not known; {suggestion(name, known)}")
    found = _values([one.formula for one in scene.outputs], known, motion.t)
    return {one.name: column for one, column in zip(scene.outputs, found, strict=True)}


def input_columns(scene: Scene, forces: Forces, t: Array, q: Array, u: Array) -> dict[str, Array]:
    """Return inputs over a motion that is known, each of shape (N,): as given, else as the scene says.

    Raises:
        SimulateError: one has no finite value.
    """
    known: dict[str, Array] = {TIME: t} | dict(zip(scene.coordinates, q.T, strict=True))
    known |= dict(zip(scene.velocities, u.T, strict=True))
    known |= {name: np.asarray(value) for name, value in opened(scene).values.items()}
    acting = {name: function for function in forces.functions for name in function.names}
    found: dict[str, Array] = {}
    for k, one in enumerate(scene.inputs, len(scene.velocities)):
        table, formula = forces.tables.get(k), forces.formulas.get(k, one.value)
        if one.name in acting:
            found[one.name] = _of_function(acting[one.name], one.name, t, q, u)
        else:
            (found[one.name],) = _values([formula], known, t) if table is None else [table(t)]
        wrong = np.flatnonzero(~np.isfinite(found[one.name]))
        if len(wrong):
            raise SimulateError(f"forces: {one.name} has no finite value at t = {t[wrong[0]]:g} s")
    return found


def _of_function(function: ForceFunction, name: str, t: Array, q: Array, u: Array) -> Array:
    """Return what a function says of an input over rows; SimulateError where that is no number."""
    k = function.names.index(name)
    try:
        rows = [np.ravel(function.of(float(at), *state)) for at, *state in zip(t, q, u, strict=True)]
        return np.array([row[k] for row in rows], dtype=np.float64)
    except Exception as fault:  # whatever a user's function raises
        raise SimulateError(f"{function.where}: the function raised {type(fault).__name__}: {fault}") from fault


def _values(formulas: Sequence[Quantity], known: Mapping[str, Array], t: Array) -> list[Array]:
    """Return formulas over the rows of columns, each of shape (N,); NaN where one has no value."""
    graph = Graph()
    values = {graph.symbol(name): known[name] for one in formulas for name in one.symbols}
    with np.errstate(all="ignore"):
        found = evaluate([one.express(graph) for one in formulas], Batches(), values)
    return [np.array(np.broadcast_to(np.asarray(x, dtype=np.float64), t.shape)) for x in found]
