"""What of a scene is drawn, as expressions of its coordinates: places of bodies, joints, forces, masses and points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from symdyn.dynamics.mechanism import body_placements, vector
from symdyn.graph import Expr, Graph, Op
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES, in_plane
from symdyn.scene.joints import JOINTS, joint_motion, unit
from symdyn.scene.values import Body, Contact, Element, Joint, Load
from symdyn.spatial import Transform

Key = tuple[Any, ...]  # what, then whose: names, numbers, elements


def drawn(scene: Scene, graph: Graph) -> dict[Key, tuple[Expr, ...]]:
    """Return what is to be evaluated, by a key that says what it is."""
    placed = body_placements(scene, graph)
    wanted: dict[Key, tuple[Expr, ...]] = {("frame", name): _flat(T) for name, T in placed.items()}
    wanted[("gravity",)] = vector(scene.gravity, graph)
    for body in scene.bodies:
        wanted |= _masses(body, placed[body.name], graph)
    for joint in (*scene.joints, *scene.loops):
        wanted |= _joint(joint, joint in scene.loops, placed, graph)
    for point in scene.points:
        wanted["point", point.name] = _flat(placed[point.body] @ point.at.transform(graph))
    for one in scene.elements:
        wanted |= _element(one, placed, graph)
    return wanted


def _element(one: Element, placed: Mapping[str, Transform], graph: Graph) -> dict[Key, tuple[Expr, ...]]:
    """Return where an element acts, the wrench of a load, and the plane that a wheel or a blade touches."""
    wanted: dict[Key, tuple[Expr, ...]] = {
        ("end", one, k): placed[end.body].point(vector(end.at, graph)) for k, end in enumerate(one.ends)
    }
    if isinstance(one, Load):
        R = placed[one.place.body].R if one.frame == "body" else Transform.unit(graph).R
        force, couple = FORCES[one.kind].push.wrench(one, graph)
        wanted |= {("force", one): R @ force, ("couple", one): R @ couple}
    elif isinstance(one, Contact):
        if FORCES[one.kind].rolls:
            wanted["radius", one] = (one.radius.express(graph),)
        if one.axis:
            wanted["axis", one] = placed[one.place.body].R @ vector(one.axis, graph)
        T, normal = placed[one.plane.body], unit(one.plane.normal, graph)
        wanted |= {("normal", one): T.R @ normal, ("along", one): T.R @ in_plane(normal)}
        wanted["plane", one] = T.point(vector(one.plane.at, graph))
    return wanted


def _masses(body: Body, T: Transform, graph: Graph) -> dict[Key, tuple[Expr, ...]]:
    wanted: dict[Key, tuple[Expr, ...]] = {}
    mass = body.mass.express(graph)
    if not mass.is_zero:
        if body.com is not None:
            wanted["com", body.name] = T.point(vector(body.com, graph))
        else:
            x, y, z = body.mass_moment(graph)
            wanted["com", body.name] = T.point((x / mass, y / mass, z / mass))
    for k, particle in enumerate(body.particles):
        at = T.point(vector(particle.at, graph))
        wanted["particle", body.name, k] = (particle.mass.express(graph), *at)
    return wanted


def _joint(joint: Joint, closes: bool, placed: Mapping[str, Transform], graph: Graph) -> dict[Key, tuple[Expr, ...]]:
    name = joint.name
    fixed = placed[joint.parent] @ joint.origin.transform(graph)
    moved = placed[joint.child] @ joint.tip.transform(graph).inverse()
    wanted: dict[Key, tuple[Expr, ...]] = {("fixed", name): _flat(fixed), ("moved", name): _flat(moved)}
    for own, way in JOINTS[joint.type].directions(joint):
        wanted["way", name, own.name] = vector(way, graph)
    at = fixed
    motion = JOINTS[joint.type].anywhere if closes else joint_motion
    for k, move in enumerate(motion(joint, graph).moves):
        at = at @ move.before
        wanted["move", name, k, move.slides] = at.R @ move.axis
        if joint.coordinates and not move.amount.is_zero:
            named = str(move.amount.value) if move.amount.op is Op.SYMBOL else ""
            wanted["step", name, k, move.slides, named] = (move.amount, *at.p, *at.R @ move.axis)
        at = at @ move.placement
    return wanted


def _flat(T: Transform) -> tuple[Expr, ...]:
    return (*T.R[0], *T.R[1], *T.R[2], *T.p)
