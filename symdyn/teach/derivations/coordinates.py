"""Steps: from where each coordinate is counted, and which way is positive, computed where all are zero; lengths."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence

from symdyn.algebra import Form, Function, Power, Symbol
from symdyn.dynamics.mechanism import body_placements, vector
from symdyn.graph import Expr, Graph, Op, gradient, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import elastic
from symdyn.scene.joints import JOINTS, unit
from symdyn.scene.values import Joint
from symdyn.spatial import Transform, Vec, dot, scale, sub
from symdyn.teach.derivations.velocities import folded
from symdyn.teach.document import Formula, Step, Words
from symdyn.teach.lesson import AXES, Lesson, Prose, together
from symdyn.teach.shown_state import Chosen

NEAR = 1e-9


def coordinate_step(lesson: Lesson, graph: Graph, chosen: Chosen) -> Step:
    """Return a table: where each coordinate is zero, and which way it grows; with all coordinates zero."""
    places = _Zero(lesson.scene, graph, chosen)
    rows = []
    for joint in lesson.scene.moving:
        axis = JOINTS[joint.type].axis(joint)
        for k, name in enumerate(joint.coordinates):
            where, way = (
                (_framed(lesson, joint), _part(lesson, joint, k))
                if axis is None
                else (_where(lesson, places, joint), _way(lesson, places, joint))
            )
            rows.append((Symbol(name), where, way))
    table = lesson.table(("coordinate", "zero.head", "way.head"), rows)
    return Step("coordinates", lesson.say("zero"), (table,), show=("angles",))


def _where(lesson: Lesson, places: _Zero, joint: Joint) -> Words:
    """Return where a joint with an axis is at zero."""
    arm = places.arm(joint)
    if JOINTS[joint.type].slides(joint) or arm is None:
        return _framed(lesson, joint)
    before = places.parent_arm(joint)
    if before is not None and _same(arm, before):
        return lesson.say("zero.in_line", child=joint.child, parent=joint.parent)
    return lesson.say("zero.points", child=joint.child, way=_named(lesson, places, arm))


def _framed(lesson: Lesson, joint: Joint) -> Words:
    """Return where a joint without an arm is at zero: where its spring is relaxed, or its frames meet."""
    springs = [one.name for one in elastic(lesson.scene) if one.joint == joint.name]
    if len(springs) == 1:
        q = lesson.state.q[lesson.scene.coordinates.index(joint.coordinates[0])]
        if substitute(gradient(lesson.energy.E, [q]), {q: lesson.graph.zero})[0].is_zero:
            return lesson.say("zero.relaxed")
    key = "zero.slide" if JOINTS[joint.type].slides(joint) else "zero.frames"
    return lesson.say(key, child=joint.child, joint=joint.name)


def _part(lesson: Lesson, joint: Joint, k: int) -> Words:
    """Return what coordinate k of a joint with several is: of a ball a turn of its sequence."""
    sequence = str(dict(joint.shape).get("orientation", ""))
    turn = k - len(joint.coordinates) + len(sequence)
    if JOINTS[joint.type].forbids is None:  # its motion is written
        graph = Graph()
        parts: list[str | Form] = []
        for kind, amount in JOINTS[joint.type].held(joint, Quantity.ZERO):
            key = "way.shift" if kind[0] == "T" else "way.rotate"
            parts += [", ", *lesson.say(key, axis=kind[1], amount=Form.of(amount.express(graph))).parts]
        return lesson.say("way.steps", steps=Words(tuple(parts[1:])))
    if len(sequence) != 3 or turn < 0:
        return lesson.say("way.part", joint=joint.name)
    return lesson.say("way.sequence", axis=sequence[turn], number=str(turn + 1), joint=joint.name)


def _way(lesson: Lesson, places: _Zero, joint: Joint) -> Words:
    """Return which way a joint's coordinate grows."""
    key = "way.slide" if JOINTS[joint.type].slides(joint) else "way.turn"
    return lesson.say(key, way=_named(lesson, places, places.axis(joint), places.axis_nodes(joint)))


def _named(lesson: Lesson, places: _Zero, way: Sequence[float], nodes: Sequence[Expr] = ()) -> str | Words:
    """Return the name of a direction of the ground, or its components, in letters by `nodes` of length 1."""
    if places.down is not None:
        for key, sign in (("down", 1.0), ("up", -1.0)):
            if _same(way, [sign * x for x in places.down]):
                return lesson.text(f"direction.{key}")
    for k, axis in enumerate(AXES):
        if abs(abs(way[k]) - 1) < NEAR:
            return lesson.text("direction.along" if way[k] > 0 else "direction.against", axis=axis)
    if nodes and _same(way, places.chosen.of(*nodes)) and any(Form.of(x).symbols for x in nodes):
        return lesson.say("direction.any", components=together([Form.of(x) for x in nodes]))
    return lesson.text("direction.any", components=", ".join(map(lesson.written, way)))


def _same(a: Sequence[float], b: Sequence[float]) -> bool:
    return math.dist(a, b) < NEAR


class _Zero:
    """A scene with all coordinates zero, in numbers."""

    def __init__(self, scene: Scene, graph: Graph, chosen: Chosen) -> None:
        self.scene, self.graph, self.chosen = scene, graph, chosen
        self.placed: Mapping[str, Transform] = body_placements(scene, graph)
        self.still = {graph.symbol(name): graph.zero for name in scene.coordinates}
        self.down = self._unit(vector(scene.gravity, graph))

    def axis(self, joint: Joint) -> tuple[float, ...]:
        """Return the direction of a joint's axis, ground frame."""
        n = self._unit(self._axis(joint))
        assert n is not None, "an axis has a length"
        return n

    def axis_nodes(self, joint: Joint) -> list[Expr]:
        """Return the same in letters, of any length."""
        return substitute(list(self._axis(joint)), self.still)

    def arm(self, joint: Joint) -> tuple[float, ...] | None:
        """Return the direction from a joint's axis to what its body carries; None where that lies on the axis."""
        (body,) = (one for one in self.scene.bodies if one.name == joint.child)
        T, origin, n = self.placed[joint.child], self._frame(joint).p, self._axis(joint)
        carried = [one for one in self.scene.joints if one.parent == body.name]
        points = [T.point(vector(particle.at, self.graph)) for particle in body.particles]
        points += [T.point(vector(body.com, self.graph))] if body.com is not None else []
        points += [self._frame(one).p for one in carried]
        straight = (one for one in carried if one.moves and JOINTS[one.type].axis(one) is not None)
        slides = [self._axis(one) for one in straight if JOINTS[one.type].slides(one)]
        for way in (*(sub(point, origin) for point in reversed(points)), *slides):
            found = self._unit(sub(way, scale(dot(way, n), n)))
            if found is not None:
                return found
        return None

    def parent_arm(self, joint: Joint) -> tuple[float, ...] | None:
        """Return the same of the joint that carries this one's parent, where both turn about parallel axes."""
        for one in self.scene.joints:
            turns = JOINTS[one.type].axis(one) is not None and not JOINTS[one.type].slides(one)
            if one.child == joint.parent and turns and _same(self.axis(one), self.axis(joint)):
                return self.arm(one)
        return None

    def _frame(self, joint: Joint) -> Transform:
        return self.placed[joint.parent] @ joint.origin.transform(self.graph)

    def _axis(self, joint: Joint) -> Vec:
        axis = JOINTS[joint.type].axis(joint)
        assert axis is not None, "asked of joints with an axis only"
        return self._frame(joint).R @ unit(axis, self.graph)

    def _unit(self, way: Vec) -> tuple[float, ...] | None:
        """Return a vector in numbers with length 1; None for one without length."""
        nodes: list[Expr] = substitute(list(way), self.still)
        values = self.chosen.of(*nodes)
        length = math.hypot(*values)
        return tuple(x / length for x in values) if length > NEAR else None


def length_steps(lesson: Lesson) -> list[Step]:
    """Return the step; none where no such length stands in the equations or in P."""
    page = lesson.page
    return defined_lengths(lesson, page.lengths.used((*page.forms, page.P)))


def defined_lengths(lesson: Prose, defined: Sequence[tuple[str, Form]]) -> list[Step]:
    """Return the step that says what names of the document stand for; none without."""
    if not defined:
        return []
    positive = {one.name for one in lesson.scene.parameters if one.positive}
    blocks = [folded(lesson, Formula(name, _root(form, positive))) for name, form in defined]
    return [Step("lengths", lesson.say("lengths"), tuple(blocks), lesson.say("lengths.reason"))]


def _root(form: Form, positive: Container[str]) -> Form:
    """Return a root of a product of squares as that of what is positive times amounts: √(l² sin² q) is l |sin q|."""
    if not isinstance(form, Function) or form.op is not Op.SQRT:
        return form
    factors = form.args[0].factors
    if not all(isinstance(x, Power) and x.exponent == 2 for x in factors):
        return form
    bases = [x.base for x in factors if isinstance(x, Power)]
    plain = [x for x in bases if isinstance(x, Symbol) and x.name in positive]
    return Form.product((*plain, *(Function(Op.ABS, (x,)) for x in bases if x not in plain)))
