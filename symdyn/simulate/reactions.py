"""Columns of joint reactions over time: what the parent exerts on the child, body axes of the child."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from symdyn.build.load import load_program
from symdyn.program import formulate, lower
from symdyn.scene import Scene
from symdyn.simulate.reading import TIME

Array = npt.NDArray[np.float64]

COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")


def reaction_columns(scene: Scene, t: Array, q: Array, qd: Array, qdd: Array) -> dict[str, Array]:
    """Return force and moment of every joint and loop at the origin of its moved frame, drives included; N and N m."""
    program = lower(formulate(scene, ("reactions",)))
    calls, _ = load_program(program, lean=True)
    (routine,) = program.routines
    known = {"q": q, "qd": qd, "qdd": qdd, TIME: t}
    found = np.asarray(calls["reactions"](*(known[argument.name] for argument in routine.function.arguments)))
    found = np.broadcast_to(found, (len(t), *found.shape[-2:]))
    names = [joint.name for joint in (*scene.joints, *scene.loops)]
    return {
        f"reaction_{name}_{component}": found[:, i, k]
        for i, name in enumerate(names)
        for k, component in enumerate(COMPONENTS)
    }
