"""Columns over time: joint reactions, what parents exert on children, and multipliers, what closes loops.

    f        forces of the spanning tree, as if nothing closed it
    λ        M u̇ + h = τ + Gᵀ λ, found as Gᵀ λ = f - τ, the least one; what a relation between rows leaves open is told

Axes of multipliers: those of a loop are the joint frame on its parent, and its wrench acts at the origin of the moved
joint frame, on the child. Those of a contact are its track, across it, and the normal of its plane; it acts on its
body.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import numpy.typing as npt

from symdyn.dynamics.loops.loop_decisions import LoopDecisions
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.scene import Scene
from symdyn.scene.values.table import Faults
from symdyn.simulation.equations.compiled_routines import requested
from symdyn.simulation.equations.decisions import WrittenDecisions, loop_decisions, written_decisions
from symdyn.simulation.equations.opened import Opened, opened
from symdyn.simulation.prescribed.formulas_in_time import TIME

Array = npt.NDArray[np.float64]

LOOSE = "_not_unique"
"""Ends the names of columns that rigid bodies do not determine; their numbers are one choice among many."""

REQUESTS = ("tree_forces", "constraint_jacobian")

AXES = {"force along": "f", "moment about": "m"}


def multipliers(scene: Scene, decisions: WrittenDecisions, t: Array, q: Array, u: Array, a: Array, tau: Array) -> Array:
    """Return λ of the kept rows, N and N m, shape (N, rows).

    Args:
        scene: the mechanism, its parameters bound.
        decisions: which rows are kept.
        t: times, s, shape (N,).
        q: positions, shape (N, nq).
        u: velocities, shape (N, nv).
        a: their rates, shape (N, nv).
        tau: driving forces, those of prescribed motions included, shape (N, nv).
    """
    open_scene = opened(scene)
    made = requested(open_scene, REQUESTS, decisions)
    calls, known, found = made.at(open_scene.values), {"q": q, "qd": u, "qdd": a, TIME: t}, {}
    for name in REQUESTS:
        values = calls[name](*(known[argument] for argument in made.takes(name)))
        found[name] = np.broadcast_to(values, (len(t), *made.program[name].function.shape))
    excess = found["tree_forces"] - tau
    back = np.linalg.pinv(found["constraint_jacobian"].transpose(0, 2, 1))
    return np.asarray(np.einsum("nrk,nk->nr", back, excess))


def multiplier_columns(scene: Scene, t: Array, q: Array, u: Array, a: Array, tau: Array) -> dict[str, Array]:
    """Return the multipliers of the kept rows as columns; arguments as for `multipliers`, which decides by itself.

    They are called `multiplier_LOOP_fx_joint`, along x of the joint frame on the parent; `multiplier_LOOP_force` along
    a direction of its own, such as a rod's; `multiplier_CONTACT_normal`; `multiplier_ROW` of a formula.
    """
    if not scene.is_closed:
        return {}
    decisions, numbers = loop_decisions(scene)
    if not decisions.kept:
        return {}
    loose = written_decisions(scene).loose
    values = multipliers(scene, written_decisions(scene), t, q, u, a, tau)
    names = [_name(scene, decisions, numbers, k) for k in decisions.kept]
    many, seen = Counter(names), Counter[str]()
    columns = {}
    for place, (k, name) in enumerate(zip(decisions.kept, names, strict=True)):
        seen[name] += 1
        number = f"_{seen[name]}" if many[name] > 1 else ""
        columns[f"multiplier_{name}{number}{LOOSE if k in loose else ''}"] = values[:, place]
    return columns


def _name(scene: Scene, decisions: LoopDecisions, numbers: Numbers, k: int) -> str:
    label = numbers.constraints.labels[k]
    if not label.loop:
        row = next(row for row in scene.rows if row.name == label.owner)
        return f"{label.owner}_{row.components[label.number]}" if row.place else label.owner
    words = decisions.names[k].removeprefix(f"{label.owner}: ")
    kind, _, axis = words.rpartition(" ")
    if kind in AXES and axis in ("x", "y", "z"):
        return f"{label.owner}_{AXES[kind]}{axis}_joint"
    return f"{label.owner}_{words.partition(' ')[0]}"


FRAMES = ("body", "joint", "ground")
"""What reactions are written in: axes of the child's body, of the joint frame on the parent, of the ground."""


def reaction_columns(
    scene: Scene, t: Array, q: Array, qd: Array, qdd: Array, tau: Array, given: bool, axes: str = "body"
) -> dict[str, Array]:
    """Return force and moment of every joint and loop at the origin of its moved frame, drives included; N and N m.

    They are called `reaction_JOINT_fx`, and in other axes than the body's `reaction_JOINT_fx_joint`, `.._fx_ground`.
    The multipliers of a closed mechanism follow them.

    Args:
        scene: the mechanism.
        t: times, shape (N,).
        q: coordinates, shape (N, nq).
        qd: velocities, shape (N, nv).
        qdd: their rates, shape (N, nv).
        tau: driving forces, shape (N, nv).
        given: whether these give the motion, and more of them may be than it needs; else they are those it takes.
        axes: "body" (of the child), "joint" (of the joint frame on the parent) or "ground".
    """
    name = "forward_reactions" if scene.is_closed and (given or not any(scene.drives)) else "reactions"
    request = name if axes == "body" else f"{name}:{axes}"
    # of a closed mechanism pivots are chosen by numbers, which are not looked at again for other values
    which = Opened(scene, {}) if scene.is_closed else opened(scene)
    made = requested(which, (request,))
    (call,) = made.at(which.values).values()
    function = made.program.routines[0].function
    known = {"q": q, "qd": qd, "qdd": qdd, "tau": tau, TIME: t}
    found = np.asarray(call(*(known[one] for one in made.takes(function.name))))
    found = np.broadcast_to(found, (len(t), *found.shape[-2:]))
    names, components = function.labels
    unique = function.unique or (True,) * (len(names) * len(components))
    ending = "" if axes == "body" else f"_{axes}"
    columns = {
        f"reaction_{name}_{component}{ending}{'' if unique[len(components) * i + k] else LOOSE}": found[:, i, k]
        for i, name in enumerate(names)
        for k, component in enumerate(components)
    }
    return columns | multiplier_columns(scene, t, q, qd, qdd, tau)


def axes_of(reactions: bool | str, faults: Faults) -> str:
    """Return the axes that are asked for, "" for none; what is no axes is a fault."""
    if isinstance(reactions, str) and reactions not in ("", *FRAMES):
        faults.add("reactions", f'"{reactions}" are no axes; write body, joint or ground')
    return reactions if isinstance(reactions, str) else "body" if reactions else ""
