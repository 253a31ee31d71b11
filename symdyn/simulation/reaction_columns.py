"""Columns of joint reactions over time: what the parent exerts on the child."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from symdyn.scene import Scene
from symdyn.scene.values.table import Faults
from symdyn.simulation.equations.compiled_routines import requested
from symdyn.simulation.equations.opened import Opened, opened
from symdyn.simulation.multipliers import LOOSE, multiplier_columns
from symdyn.simulation.prescribed.formulas_in_time import TIME

Array = npt.NDArray[np.float64]

AXES = ("body", "joint", "ground")
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
    if isinstance(reactions, str) and reactions not in ("", *AXES):
        faults.add("reactions", f'"{reactions}" are no axes; write body, joint or ground')
    return reactions if isinstance(reactions, str) else "body" if reactions else ""
