"""What is in the columns of a run beside the state: inputs, outputs, reactions, multipliers, tensions of ropes.

They are evaluated from positions, reactions and forces as these came out; functions called `outputs` are derived.
Multipliers are the forces of loops and other constraints:

    f        forces of the spanning tree, as if nothing closed it
    λ        M u̇ + h = τ + Gᵀ λ, found as Gᵀ λ = f - τ, the least one; what a relation between constraints
             leaves open is reported

Multipliers of a loop have the axes of the joint frame on its parent; its wrench acts at the origin of the moved joint
frame, on the child. Those of a contact have its track, the direction across it, and the normal of its plane as axes;
its force acts on its body.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.dynamics import Function, Workspace, derive_one
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import Moving, WrittenDecisions, arguments, reaction_names, touching, unique
from symdyn.dynamics.reactions import carried
from symdyn.errors import SimulateError, suggestion
from symdyn.frozen import replace
from symdyn.graph import Expr, Graph, evaluate, reachable
from symdyn.program import formulate
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import LETTERS
from symdyn.simulation.equations.compiled_routines import Compiled, Opened, compiled, compiled_once, opened, plain
from symdyn.simulation.equations.contact_modes import column_words
from symdyn.simulation.equations.written import written_decisions
from symdyn.simulation.prescribed.forces import ForceFunction, Forces

if TYPE_CHECKING:
    from symdyn.simulation.trajectory import Trajectory


def multipliers(motion: Trajectory, decisions: WrittenDecisions) -> Array:
    """Return λ of the independent rows, N and N m, shape (N, rows), of a motion and all forces that drive it."""
    found = opened(motion.scene)

    def make() -> Compiled:
        w = Workspace(found.scene, found.closing)
        given = [kind for kind, letters in (("inputs", w.inputs), ("internal", w.states)) if letters]
        takes = arguments(w, ("q", "qd", "qdd", TIME, *given))
        forces = plain("forces", w.forces(list(w.state.qdd)), takes)
        return compiled(w.scene, w.graph, (forces, derive_one(w, "constraint_jacobian")))

    made = compiled_once(("multipliers", found.scene, decisions), make)
    f, G = (_over(motion, made, found, routine.function) for routine in made.program.routines)
    return np.asarray(np.einsum("nrk,nk->nr", np.linalg.pinv(G.transpose(0, 2, 1)), f - motion.tau))


def _over(motion: Trajectory, made: Compiled, result: Opened, function: Function) -> Array:
    """Return a compiled function at all samples of a motion, shape (N, ...)."""
    series = {"q": motion.q, "qd": motion.qd, "qdd": motion.qdd, "tau": motion.tau, TIME: motion.t}
    series |= {"inputs": motion.inputs, "internal": motion.own_states}
    values = made.at(result.values)[function.name](*(series[one] for one in made.takes(function.name)))
    return np.broadcast_to(values, (len(motion.t), *function.shape))


def multiplier_columns(motion: Trajectory) -> dict[str, Array]:
    """Return the multipliers of the independent rows as columns.

    They are called `multiplier_LOOP_fx_joint`, along x of the joint frame on the parent; `multiplier_LOOP_force` along
    a direction of its own, such as a rod's; `multiplier_CONTACT_normal`; `multiplier_ROW` of a formula.
    """
    scene = motion.scene
    if not scene.is_constrained:
        return {}
    decisions = written_decisions(scene)
    return dict(zip(decisions.letters, multipliers(motion, decisions).T, strict=True)) if decisions.letters else {}


def reaction_columns(motion: Trajectory, given: bool, axes: str = "body") -> dict[str, Array]:
    """Return force and moment of every joint and loop at the origin of its moved frame, drives included; N and N m.

    They are called `reaction_JOINT_fx`, and in other axes than the body's `reaction_JOINT_fx_joint`, `.._fx_ground`.
    The multipliers of a closed mechanism follow them.

    Args:
        motion: with its driving forces.
        given: whether these give the motion, and more of them may be than it needs; else they are those it takes.
        axes: one of `AXES`.
    """
    scene = motion.scene
    name = "forward_reactions" if scene.is_constrained and (given or not any(scene.drives)) else "reactions"
    ((function, values),) = _unique(motion, (name if axes == "body" else f"{name}:{axes}",), axes)
    values = values.reshape(len(motion.t), -1) + (_of_contacts(motion, axes) if scene.unilaterals else 0.0)
    wrenches = dict(zip(reaction_names(scene, function.unique, axes), values.T, strict=True))
    return wrenches | multiplier_columns(motion)


def _of_contacts(motion: Trajectory, axes: str) -> Array:
    """Return what all reactions owe to the forces of contacts, which are columns of a run, shape (N, 6 joints)."""
    found = opened(motion.scene)
    scene = found.scene
    w = Workspace(scene)
    every = [one for one in touching(w) if one.law.closed is not None]

    def make() -> Compiled:
        rows = [one.law.closed for one in every if one.law.closed is not None]
        kept = [one for one in scene.elements if one not in scene.unilaterals]
        held = Workspace(replace(scene, elements=(*kept, *rows)))
        felt = carried(held.hanging, axes)
        used = [felt[one.law.name][k] for one in every for k in (0, *(one.ways if one.tangents else ()))]
        entries = [entry for each in used for entry in each]
        return compiled(held.scene, held.graph, [plain("felt", entries, arguments(held, ("q", TIME)))])

    made = compiled_once(("of_contacts", scene, axes), make)
    words = [word for one in every for word in column_words(one.law.name, True, len(one.tangents))]
    forces = np.array([motion[word] for word in words])
    (routine,) = made.program.routines
    felt = _over(motion, made, found, routine.function).reshape(len(motion.t), len(words), -1)
    return np.asarray(np.einsum("kn,nkj->nj", forces, felt))


def tension_columns(motion: Trajectory) -> dict[str, Array]:
    """Return the tension of every rope, N, by `tension_ROPE`; DerivationError where one is not unique."""
    requests = tuple(f"tension:{one.name}" for one in opened(motion.scene).scene.ropes)
    return {function.name: values for function, values in _unique(motion, requests)}


def _unique(motion: Trajectory, requests: tuple[str, ...], axes: str = "body") -> list[tuple[Function, Array]]:
    """Return functions that are asked for, of forces that the motion determines, and their values at all samples."""
    found = opened(motion.scene)

    def make() -> Compiled:
        equations = formulate(found.scene, requests, closing=found.closing)
        return compiled(found.scene, equations.graph, equations.functions)

    made = compiled_once((requests, found.scene, choices(motion.scene, axes)), make)
    functions = [routine.function for routine in made.program.routines]
    return [(one, _over(motion, made, found, one)) for one in functions]


def columns_for(motion: Trajectory, names: Iterable[str]) -> dict[str, Array]:
    """Return multipliers, tensions, rates of points, energies and what struts tell, those that are named."""
    names = tuple(names)
    found = multiplier_columns(motion) if any(name.startswith(LETTERS.multiplier) for name in names) else {}
    found |= tension_columns(motion) if any(name.startswith(LETTERS.tension) for name in names) else {}
    return found | columns_of_motion(motion, names)


def columns_of_motion(motion: Trajectory, names: Iterable[str]) -> dict[str, Array]:
    """Return rates of points, energies, lengths and forces of struts as columns, those that are named.

    They follow from the motion alone; a column that a run has is not made again.
    """
    every = {*LETTERS.energies, *LETTERS.of_struts(motion.scene.struts)}
    every |= {name for one in motion.scene.points for name in LETTERS.of_point(one.name)}
    told = [name for name in dict.fromkeys(names) if name in every and name not in motion.names]
    if not told:
        return {}
    w = Workspace(opened(motion.scene).scene)
    moving = Moving(w, lambda: w.state.qdd, list, lambda axes: [], list).expressed([*map(Quantity.symbol, told)])
    series = dict(zip(motion.names, motion.table()[1].T, strict=True)) | dict(opened(motion.scene).values)
    return dict(zip(told, _values(moving, series, motion.t), strict=True))


@lru_cache(maxsize=16)
def choices(scene: Scene, axes: str) -> Hashable:
    """Return rows, velocities and wrenches that numbers choose in a closed mechanism: equal ones are one function."""
    if not scene.is_constrained:
        return None
    found = opened(scene)
    w = Workspace(found.scene, found.closing)
    closing = w.hanging.closing
    place = {node: k for k, node in enumerate(reachable(closing))}
    nodes = tuple((node.op, node.value, *(place[arg] for arg in node.args)) for node in place)
    return written_decisions(scene), w.once(unique, axes), nodes, tuple(place[x] for x in closing)


def output_columns(motion: Trajectory, given: bool) -> dict[str, Array]:
    """Return the outputs of the scene by name, each of shape (N,); `given` as for `reaction_columns`."""
    scene = motion.scene
    if not scene.outputs:
        return {}
    named = dict.fromkeys(name for one in scene.outputs for name in one.formula.symbols)
    series: dict[str, Array] = dict(zip(motion.names, motion.table()[1].T, strict=True))
    axes = scene.reaction_axes
    for one in dict.fromkeys(axes[name] for name in named if name in axes):
        series |= reaction_columns(motion, given, one)
    series |= columns_for(motion, named)
    series |= {name: np.asarray(value) for name, value in opened(scene).values.items()}
    for name in named:
        if name not in series:
            raise SimulateError(f"{scene.name}: outputs: {name} is not known; {suggestion(name, series)}")
    found = formula_values([one.formula for one in scene.outputs], series, motion.t)
    return {one.name: column for one, column in zip(scene.outputs, found, strict=True)}


def input_columns(scene: Scene, forces: Forces, t: Array, q: Array, u: Array) -> dict[str, Array]:
    """Return inputs over a motion, each of shape (N,), as given or said; SimulateError where one has no value."""
    series: dict[str, Array] = {TIME: t} | dict(zip(scene.coordinates, q.T, strict=True))
    series |= dict(zip(scene.velocities, u.T, strict=True))
    series |= {name: np.asarray(value) for name, value in opened(scene).values.items()}
    acting = {name: function for function in forces.functions for name in function.names}
    found: dict[str, Array] = {}
    for k, one in enumerate(scene.inputs, len(scene.velocities)):
        table, formula = forces.tables.get(k), forces.formulas.get(k, one.value)
        if one.name in acting:
            found[one.name] = _of_function(acting[one.name], one.name, t, q, u)
        else:
            (found[one.name],) = formula_values([formula], series, t) if table is None else [table(t)]
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


def formula_values(formulas: Sequence[Quantity], series: Mapping[str, Any], t: Array) -> list[Array]:
    """Return formulas over the rows of columns, each of shape (N,); NaN where one has no value."""
    graph = Graph()
    return _values([one.express(graph) for one in formulas], series, t)


def _values(entries: Sequence[Expr], series: Mapping[str, Any], t: Array) -> list[Array]:
    values = {entry.graph.symbol(name): x for entry in entries[:1] for name, x in series.items()}
    with np.errstate(all="ignore"):
        found = evaluate(entries, Batches(), values)
    return [np.array(np.broadcast_to(np.asarray(x, dtype=np.float64), t.shape)) for x in found]
