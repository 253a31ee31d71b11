"""A scene as solids in space: bodies as links, joints, masses, wheels and the ground, each in the frame of its body."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from symdyn.draw.body_shapes import COLOURS, between_ends, carrier, outer, spots
from symdyn.draw.ground import patches
from symdyn.draw.outlines import Outlined
from symdyn.draw.places import Frame, JointAxis, Placed, Places
from symdyn.draw.solids import Solid, along, ball, bar, box, cylinder, patch
from symdyn.draw.style import LIGHT
from symdyn.draw.view import View, vertical
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS

SEEN = 0.5  # how much of it is seen of a surface that may hide joints
JOINT, DARK, FLOOR = "#9aa4af", LIGHT["ink"], "#c5ced8"
LINK, SHAFT, THIN = 0.45, 0.7, 0.15  # half the width of a link, the radius of a joint, and of what is thin, in reaches


def standing(
    scene: Scene, places: Places, view: View, given: Mapping[str, tuple[Solid, ...]]
) -> dict[str, list[Solid]]:
    """Return the solids of every body and of the ground, by name, each in the frame of its body.

    Args:
        scene: any scene.
        places: where everything is, at every moment; solids are made at the first.
        view: says how large joints are.
        given: solids that are known of bodies, such as meshes of a robot: no link or joint is drawn in their place.
    """
    solids: dict[str, list[Solid]] = {Scene.GROUND: list(given.get(Scene.GROUND, ()))}
    for k, body in enumerate(places.bodies):
        colour = LIGHT[f"body{k % COLOURS}"]
        made = given[body.name] if body.name in given else _link(scene, places, body, view, colour)
        solids[body.name] = [*made, *_wheels(scene, places, body, view, colour)]
    frames = {Scene.GROUND: places.ground, **{body.name: body.frame for body in places.bodies}}
    for hinge in places.hinges:
        joint = hinge.joint
        if joint.child not in given:
            solids[joint.child] += _inside(frames[joint.child], _joint(hinge, view))
        if joint.parent not in given:
            solids[joint.parent] += _inside(frames[joint.parent], _rail(hinge, view))
        if (
            Scene.GROUND in (joint.parent, joint.child)
            and JOINTS[joint.type].class_t(joint)
            and Scene.GROUND not in given
        ):
            solids[Scene.GROUND] += _inside(places.ground, _stand(hinge, places, view))
    for row, corners in patches(scene, places):
        owner = row.plane.body
        solids[owner] += _inside(frames[owner], (patch(corners[0], FLOOR),))
    return solids


def _inside(frame: Frame, solids: tuple[Solid, ...]) -> tuple[Solid, ...]:
    """Return solids of the ground frame in the frame of a body, both at the first moment."""
    R, p = frame.R[0], frame.p[0]
    return tuple(one.put(R.T, -R.T @ p) for one in solids)


def _link(scene: Scene, places: Places, body: Placed, view: View, colour: str) -> tuple[Solid, ...]:
    """Return bars from the joint that carries a body to all that is on it, its centre of mass and its particles."""
    start, com = carrier(places, body.name).moved.p, body.com
    tips = outer(start, spots(scene, places, body.name), view)
    made: list[Solid] = []
    if com is not None and not tips:
        tips = outer(start, [com], view)
    elif com is not None and not any(between_ends(start, tip, com, view) for tip in tips):
        made += bar(start[0], com[0], THIN * view.reach, JOINT)
    if (outline := places.outlines.get(body.name)) is not None:
        made += _outlined(outline, body, view, colour)
    for tip in tips:
        made += bar(start[0], tip[0], LINK * view.reach, colour)
    heaviest = max((mass for one in places.bodies for mass, _ in one.particles), default=0.0)
    for mass, at in body.particles:
        share = (max(mass, 0.0) / heaviest) ** (1 / 3) if heaviest > 0 else 1.0
        made.append(ball((0.5 + 0.7 * share) * view.reach, colour).put(np.eye(3), at[0]))
    if com is not None:
        cube = box(np.full(3, 0.62 * view.reach if tips else 1.3 * view.reach), DARK if tips else colour)
        made.append(cube.put(body.frame.R[0], com[0]))
    return _inside(body.frame, tuple(made))


def _outlined(outline: Outlined, body: Placed, view: View, colour: str) -> tuple[Solid, ...]:
    """Return what a body looks like, thin in the ways that it does not extend in, and such that joints are seen."""
    sizes = np.array([*(float(np.linalg.norm(way)) for way in outline.ways), *[0.15 * view.reach] * 3][:3])
    ways = [way / size for way, size in zip(outline.ways, sizes, strict=False)]
    if len(ways) == 1:
        R = along(ways[0])
    else:
        R = np.stack([*ways[:2], np.cross(ways[0], ways[1])], axis=1) if ways else np.eye(3)
    made: dict[str, Callable[[], Solid]] = {
        "rod": lambda: box(np.array([LINK * view.reach, LINK * view.reach, sizes[0]]), colour),
        "disc": lambda: cylinder(sizes[0], sizes[2], colour, SEEN),
        "ring": lambda: cylinder(sizes[0], sizes[2], colour, SEEN / 2),
        "ball": lambda: ball(sizes[0], colour, SEEN),
        "plate": lambda: box(sizes, colour, SEEN),
        "point": lambda: ball(view.reach, colour),
    }
    return (made[outline.look]().put(body.frame.R[0] @ R, body.frame.point(outline.centre)[0]),)


def _wheels(scene: Scene, places: Places, body: Placed, view: View, colour: str) -> tuple[Solid, ...]:
    """Return rims of what rolls, with a spoke that shows how it turns."""
    made: list[Solid] = []
    for row in scene.contacts:
        if row.name not in places.wheels or row.place.body != body.name:
            continue
        centre, axis, radius = places.wheels[row.name]
        if axis is None:
            made.append(ball(radius, colour).put(np.eye(3), centre[0]))
            continue
        R, half = along(axis[0]), 0.25 * view.reach
        made.append(cylinder(radius, half, colour).put(R, centre[0]))
        made.append(box(np.array([0.9 * radius, 0.12 * radius, 1.2 * half]), FLOOR).put(R, centre[0]))
    return _inside(body.frame, tuple(made))


def _joint(hinge: JointAxis, view: View) -> tuple[Solid, ...]:
    """Return a cylinder about the axis of a turn, a box along a slide, a ball where it turns in more ways."""
    at, reach = hinge.moved.p[0], view.reach
    turns, slides = len(hinge.turns), len(hinge.slides)
    if turns == 1:
        return (cylinder(SHAFT * reach, reach, JOINT).put(along(hinge.turns[0][0]), at),)
    if not turns and slides:
        return (box(np.array([0.8, 0.8, 1.3]) * reach, JOINT).put(along(hinge.slides[0][0]), at),)
    if not turns or turns == slides == 3:  # welded, or held by nothing
        return ()
    return (ball(SHAFT * reach, JOINT).put(np.eye(3), at),)


def _rail(hinge: JointAxis, view: View) -> tuple[Solid, ...]:
    """Return what a slide runs on, as long as all its ways."""
    if len(hinge.slides) != 1 or len(hinge.turns) > 1:
        return ()
    axis, start = hinge.slides[0][0], hinge.fixed.p[0]
    ways = np.einsum("ni,ni->n", hinge.moved.p - hinge.fixed.p, hinge.slides[0])
    low, high = min(0.0, float(ways.min())) - 2 * view.reach, max(0.0, float(ways.max())) + 2 * view.reach
    return bar(start + low * axis, start + high * axis, THIN * view.reach, JOINT)


def _stand(hinge: JointAxis, places: Places, view: View) -> tuple[Solid, ...]:
    """Return a plate and the post on it that carries a joint."""
    up, reach = vertical(places.gravity), view.reach
    seat = (hinge.fixed if hinge.joint.parent == Scene.GROUND else hinge.moved).p[0]
    foot = seat - 2.4 * reach * up
    plate = box(np.array([1.8, 1.8, 0.12]) * reach, FLOOR).put(along(up), foot)
    return (plate, *bar(foot, seat, 2 * THIN * reach, JOINT))
