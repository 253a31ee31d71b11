"""Columns of joint reactions over time: what the parent exerts on the child."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from symdyn.build.load import load_program
from symdyn.program import formulate, lower
from symdyn.scene import Scene
from symdyn.simulation.reading import TIME

Array = npt.NDArray[np.float64]

LOOSE = "_not_unique"
"""Ends the names of columns that rigid bodies do not determine; their numbers are one choice among many."""


def reaction_columns(
    scene: Scene, t: Array, q: Array, qd: Array, qdd: Array, tau: Array, given: bool, axes: str = "body"
) -> dict[str, Array]:
    """Return force and moment of every joint and loop at the origin of its moved frame, drives included; N and N m.

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
    from symdyn.dynamics.reactions.loose import COMPONENTS

    closed = bool(scene.loops or scene.rows)
    name = "forward_reactions" if closed and (given or not any(scene.drives)) else "reactions"
    program = lower(formulate(scene, (name if axes == "body" else f"{name}:{axes}",)))
    calls, _ = load_program(program, lean=True)
    (routine,) = program.routines
    known = {"q": q, "qd": qd, "qdd": qdd, "tau": tau, TIME: t}
    (call,) = calls.values()
    found = np.asarray(call(*(known[argument.name] for argument in routine.function.arguments)))
    found = np.broadcast_to(found, (len(t), *found.shape[-2:]))
    names = [joint.name for joint in (*scene.joints, *scene.loops)]
    unique = routine.function.unique or (True,) * (6 * len(names))
    return {
        f"reaction_{name}_{component}{'' if unique[6 * i + k] else LOOSE}": found[:, i, k]
        for i, name in enumerate(names)
        for k, component in enumerate(COMPONENTS)
    }
