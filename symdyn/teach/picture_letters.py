"""The letters of masses and lengths in the picture of a scene: where each is drawn, and what it measures."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.draw import Lettered
from symdyn.dynamics.mechanism import body_placements, vector
from symdyn.emit.print import latex_symbols
from symdyn.graph import Graph, Op
from symdyn.scene import Quantity, Scene
from symdyn.scene.joints import joint_motion
from symdyn.scene.values import Pose
from symdyn.spatial import Transform, Vec, add, scale
from symdyn.teach.shown_state import Chosen


def picture_letters(scene: Scene, graph: Graph, chosen: Chosen) -> tuple[Lettered, ...]:
    """Return the letters that stand for a mass alone, at its place, and for a length alone, amid it; each once."""
    latex, found = latex_symbols(scene), dict[str, Lettered]()
    for letter, place in (*_masses(scene, graph), *_lengths(scene, graph)):
        if letter not in found:
            found[letter] = Lettered(latex[letter], tuple(chosen.of(*place)))
    return tuple(found.values())


def _masses(scene: Scene, graph: Graph) -> Iterator[tuple[str, Vec]]:
    placed = body_placements(scene, graph)
    for body in scene.bodies:
        T = placed[body.name]
        for particle in body.particles:
            if particle.mass.op is Op.SYMBOL:
                yield str(particle.mass.value), T.point(vector(particle.at, graph))
        if body.mass.op is Op.SYMBOL and body.com is not None:
            yield str(body.mass.value), T.point(vector(body.com, graph))


def _lengths(scene: Scene, graph: Graph) -> Iterator[tuple[str, Vec]]:
    """Yield shifts of joints and places of particles and points along one axis, by one letter."""
    placed = body_placements(scene, graph)
    for joint in scene.joints:
        before = placed[joint.parent]
        yield from _steps(before, joint.origin, graph)
        if joint.tip.steps:
            moved = before @ joint.origin.transform(graph) @ joint_motion(joint, graph).placement
            yield from _steps(moved, joint.tip, graph)
    fixed = [(body.name, particle.at) for body in scene.bodies for particle in body.particles]
    fixed += [(point.body, _shift(point.at)) for point in scene.points if point.body in placed]
    for body, at in fixed:
        named = [_letter(x) for x in at]
        if sum(x != Quantity.ZERO for x in at) == 1 and any(named):
            T = placed[body]
            yield next(filter(None, named)), _middle(T.p, T.point(vector(at, graph)))


def _steps(T: Transform, pose: Pose, graph: Graph) -> Iterator[tuple[str, Vec]]:
    for kind, amount in pose.steps:
        after = T @ Transform.elementary(kind, amount.express(graph))
        if kind[0] == "T" and (letter := _letter(amount)):
            yield letter, _middle(T.p, after.p)
        T = after


def _shift(pose: Pose) -> tuple[Quantity, Quantity, Quantity]:
    """Return the shift of a pose without turns; zeros of any other."""
    shifts = dict(pose.steps)
    if len(shifts) < len(pose.steps) or any(kind[0] != "T" for kind in shifts):
        return (Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)
    return (shifts.get("Tx", Quantity.ZERO), shifts.get("Ty", Quantity.ZERO), shifts.get("Tz", Quantity.ZERO))


def _letter(amount: Quantity) -> str:
    """Return the letter that a quantity or its negative is; "" for any other."""
    inner = amount.args[0] if amount.op is Op.NEG else amount
    return str(inner.value) if inner.op is Op.SYMBOL else ""


def _middle(a: Vec, b: Vec) -> Vec:
    return scale(a[0].graph.one / 2, add(a, b))
