"""What joints may do as arrays, in the order of coordinates and of velocities."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

from symdyn.arguments import checked
from symdyn.errors import ArgumentError, SceneError, listed
from symdyn.scene.scene_files import SceneLike, scene_of

KEYS = {"lower": -inf, "upper": inf, "velocity": inf, "effort": inf}


@checked(ArgumentError)
def limits(scene: SceneLike, parameters: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return the limits of a scene's joints; infinite where there are none, and of joints of several coordinates.

    >>> import symdyn
    >>> found = symdyn.scene.limits("benchmarks/data/swing_up.toml")
    >>> found["lower"], found["effort"]
    (array([ -2., -inf]), array([20., inf]))

    Args:
        scene: the mechanism.
        parameters: values of parameters that limits name, by name.

    Returns:
        "lower" and "upper" positions, shape (nq,), rad or m; the largest "velocity", rad/s or m/s, and "effort", the
        driving force, N m or N, shape (nv,). `scene.order(names)` says where another tool has them.

    Raises:
        SceneError: the file has faults, or a limit names a parameter without a value.
    """
    import numpy as np

    scene = scene_of(scene, parameters)
    known = {x.name: number for x in scene.parameters if x.value is not None and (number := x.value.at({})) is not None}
    found: dict[str, list[float]] = {key: [] for key in KEYS}
    for joint in scene.moving:
        alone = len(joint.coordinates) == len(joint.rates) == 1
        for key, none in KEYS.items():
            formula: Any = getattr(joint.limits, key) if alone else None
            number = none if formula is None else formula.at(known)
            if number is None:
                free = listed([name for name in formula.symbols if name not in known])
                where = f"{scene.name}: joints.{joint.name}: limits.{key}"
                raise SceneError(f"{where} depends on {free}; give values in parameters")
            count = len(joint.coordinates if key in ("lower", "upper") else joint.rates)
            found[key] += [float(number)] * count
    return {key: np.array(values) for key, values in found.items()}
