"""Contacts of a robot whose file has none: feet, by the names of their links."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from symdyn.arguments import checked
from symdyn.errors import SceneError, choice
from symdyn.scene.scene_files import SceneLike, scene_of
from symdyn.scene.values import Place, PlaneContact
from symdyn.scene.values.body import translation
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import Quantity


@checked(SceneError)
def with_contacts(scene: SceneLike, places: Sequence[str], friction: float = 1.0) -> Scene:
    """Return a scene in which points may touch the plane z = 0 of the ground, a contact of the name of each.

    Args:
        scene: the mechanism; what opens and closes in it already comes first.
        places: points of the scene, or bodies, whose origins they are then.
        friction: Coulomb's coefficient; without any they touch along the normal alone, but for `held_dynamics`, which
            holds all directions.

    Raises:
        SceneError: there is no such place, one is given twice, or a contact has its name.
    """
    scene = scene_of(scene)
    known = {body.name: Place(body.name) for body in scene.bodies}
    known |= {point.name: Place(point.body, translation(point.at)) for point in scene.points}
    taken = {one.name for one in scene.unilaterals}
    faults = list[str]()
    for name in places:
        if name not in known:
            faults.append(f"{scene.name}: there is no body or point {name!r}; {choice(name, known)}")
        elif name in taken:
            faults.append(f"{scene.name}: contacts.{name} is there already; leave it out")
        taken.add(name)
    if not 0 <= friction < float("inf"):
        faults.append(f"{scene.name}: friction = {friction:g} is no coefficient; give a number, 0 or above")
    if faults:
        raise SceneError(faults)
    mu = Quantity.number(Fraction(str(float(friction))))
    added = tuple(PlaneContact(name, friction=mu, place=known[name]) for name in places)
    return replace(scene, elements=(*scene.elements, *added))
