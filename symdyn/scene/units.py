"""The units of a scene's letters; of coordinates and velocities "rad", "m" or "1" as the joints have them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from symdyn.scene.joints import JOINTS
from symdyn.scene.values.joint import Joint, acceleration_name
from symdyn.scene.values.mapping import map_quantities, quantities_in
from symdyn.scene.values.model import Letter, Scene
from symdyn.scene.values.with_unit import with_unit


def coordinate_units(scene: Scene) -> tuple[str, ...]:
    """Return the unit of every coordinate, shape (nq,)."""
    return tuple(unit for joint in scene.moving for unit in JOINTS[joint.type].coordinates(joint))


def velocity_units(scene: Scene) -> tuple[str, ...]:
    """Return the unit of every velocity but for its second, shape (nv,): "rad" of rad/s."""
    return tuple(unit for joint in scene.moving for unit in JOINTS[joint.type].velocities(joint))


def coordinates_with_units(scene: Scene) -> Iterator[tuple[Joint, str, str]]:
    """Yield every coordinate, in order, with its joint and its unit."""
    for joint in scene.moving:
        yield from (
            (joint, q, unit) for q, unit in zip(joint.coordinates, JOINTS[joint.type].coordinates(joint), strict=True)
        )


def drives_with_units(scene: Scene) -> Iterator[tuple[Joint, str, str]]:
    """Yield every drive, in order, with its joint and its unit, "N m" or "N"."""
    for joint in scene.moving:
        for drive, unit in zip(joint.drives, JOINTS[joint.type].velocities(joint), strict=False):
            if drive:
                yield joint, drive, "N m" if unit == "rad" else "N"


def letter_units(scene: Scene) -> dict[str, str]:
    """Return the coherent unit of every letter that somebody gives a value, "" of one that says none."""
    said: tuple[Letter, ...] = (*scene.parameters, *scene.inputs)
    found = {one.name: one.unit for one in said} | {"t": "s"}
    found |= dict(zip(scene.coordinates, coordinate_units(scene), strict=True))
    for velocity, drive, unit in zip(scene.velocities, scene.drives, velocity_units(scene), strict=True):
        found |= {velocity: f"{unit}/s", acceleration_name(velocity): f"{unit}/s^2"}
        found |= {drive: "N m" if unit == "rad" else "N"} if drive else {}
    return found


def mistakable(scene: Scene) -> tuple[str, ...]:
    """Return what is to be said of values with units in which somebody may see a letter of the scene."""
    letters = letter_units(scene)
    nouns = (scene.gravity, *scene.parameters, *scene.bodies, *scene.joints, *scene.points, *scene.loops)
    told = []
    for one in quantities_in((*nouns, *scene.elements, *scene.inputs, *scene.outputs)):
        both = [name for name in re.findall(r"[^\W\d_]+", one.unit) if name in letters]
        if both:
            told.append(f"{with_unit(one, one.unit)} is a number and a unit: {both[0]} is no letter of the scene there")
    return tuple(dict.fromkeys(told))


def written_in_si(scene: Scene) -> Scene:
    """Return an equal scene that is written in SI, whatever units its writer chose; for what is generated."""
    plain = map_quantities(scene, lambda one: replace(one, unit=""))
    return replace(
        plain,
        parameters=tuple(replace(one, written="") for one in plain.parameters),
        inputs=tuple(replace(one, written="") for one in plain.inputs),
    )
