"""What a page draws: points and directions as functions of the position, and the marks that use them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from symdyn.draw.force_arrows import from_zero
from symdyn.draw.outlines import drawn, gears, outline, strings, touching
from symdyn.dynamics.mechanism import vector
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS, unit
from symdyn.scene.values import Element, Load, Strut
from symdyn.spatial import Mat, Vec, add, cross, scale, sub

AROUND, BLADE = 2, 1
"""How far a plane is drawn around what touches it: in radii of a wheel; m around a blade."""


@dataclass(frozen=True)
class Mark:
    """Something to draw.

    Attributes:
        kind: "link", "particle", "com" or "point"; "turn", "slide" or "weld", a joint; "support" or "rail", where one
            stands on the ground; "frame", "load", "spring" or "damper", "spring_turn" and the like for one in a joint
            ("spring_zero" begins at the zero of a slide, "spring_slide" behind it), "wheel", the rim of what rolls;
            "ball", its outline; "rod", "disc", "ring" or "plate", what a body looks like; or "plane", what wheels and
            blades touch; "floor", the plane of what opens and closes.
        rows: of `drawn_points` that it needs, points first, then directions.
        body: number of the body that it belongs to, which is its colour; -1 for the ground.
        text: the name of a point or a load.
        joint: the name of the joint whose symbol it is.
    """

    kind: str
    rows: tuple[int, ...]
    body: int
    text: str
    joint: str = ""


@dataclass(frozen=True)
class Measured:
    """A coordinate that is drawn: whether it slides, its name, and rows of `drawn_points`.

    Attributes:
        at, axis: a point, and a unit direction, that it turns about or slides along.
        tips: points of the body that it moves, one of which its zero line is drawn for.
    """

    slides: bool
    name: str
    at: int
    axis: int
    tips: tuple[int, ...]


class Sheet:
    """Rows of `drawn_points` and the marks that use them.

    Attributes:
        rows: points and directions, ground frame.
        points: rows that are points and no directions.
        gravity: row that is the acceleration of free fall.
        marks: in the order of drawing.
        coordinates: those that are drawn.
    """

    def __init__(self, scene: Scene, graph: Graph, values: Mapping[str, float], outlined: Collection[str]) -> None:
        """Collect everything of a scene; what is drawn is what pictures show.

        The bodies `outlined` are drawn as what they look like at these values of parameters.
        """
        self.rows: list[Vec] = []
        self.points: list[int] = []
        self.marks: list[Mark] = []
        self.found = drawn(scene, graph, values)
        self._hinges: dict[str, tuple[tuple[int, ...], bool, str]] = {}
        self._number = {body.name: k for k, body in enumerate(scene.bodies)} | {Scene.GROUND: -1}
        self.gravity = self._direction(self.found["gravity",])
        starts = {joint.child: self._point(self.found["moved", joint.name][9:]) for joint in scene.joints}
        tips: dict[str, list[int]] = {name: [] for name in (Scene.GROUND, *(body.name for body in scene.bodies))}
        self.marks += [*self._planes(scene), *self._outlines(scene, graph, values, outlined)]
        joints = list(self._joints(scene, starts, tips))
        self._strings = strings(scene, values)
        masses = [*self._wheels(scene, values), *self._masses(scene, starts, tips)]
        acting = list(self._acting(scene, tips))
        for body in scene.bodies:
            for tip in tips[body.name]:
                self.marks.append(self._made("link", (starts[body.name], tip), body.name))
        self.marks += [*masses, *joints, *acting]
        self.coordinates = list(self._coordinates(scene, starts, tips))

    def _point(self, at: Sequence[Expr]) -> int:
        self.points.append(len(self.rows))
        return self._direction(at)

    def _direction(self, way: Sequence[Expr]) -> int:
        x, y, z = way
        self.rows.append((x, y, z))
        return len(self.rows) - 1

    def _made(self, kind: str, rows: tuple[int, ...], body: str, text: str = "", joint: str = "") -> Mark:
        return Mark(kind, rows, self._number[body], text, joint)

    def _joints(self, scene: Scene, starts: dict[str, int], tips: dict[str, list[int]]) -> Iterator[Mark]:
        """Yield supports, symbols and frames of all joints; links reach to where joints begin."""
        for joint in (*scene.joints, *scene.loops):
            fixed = self.found["fixed", joint.name]
            at = self._point(fixed[9:])
            tips[joint.parent].append(at)
            way = self._direction(_turned(fixed, vector(joint.axis, fixed[0].graph)))
            moved = self.found["moved", joint.name]
            if closes := joint in scene.loops:
                place = self._point(moved[9:])
                tips[joint.child].append(place)
            else:
                place = starts[joint.child]
            sign = JOINTS[joint.type].mark.sign
            self._hinges[joint.name] = ((at, place, way), sign.slides, joint.child)
            if sign.line:
                self.marks.append(self._made("link", (at, place), Scene.GROUND))
            lies = sign.slides and any(mark.kind == "floor" for mark in self.marks)  # it may slide along that
            if sign.shape and joint.parent == Scene.GROUND and not lies:
                self.marks.append(self._made("rail" if sign.slides else "support", (at, way), Scene.GROUND))
            if sign.shape:
                yield self._made(sign.shape, (place, way, at), joint.child, joint=joint.name)
            if not closes:
                yield self._made("frame", (place, *(self._direction(moved[k:9:3]) for k in range(3))), joint.child)

    def _coordinates(self, scene: Scene, starts: dict[str, int], tips: dict[str, list[int]]) -> Iterator[Measured]:
        """Yield turns and slides that are a coordinate each."""
        for joint in scene.moving:
            for key, (_, *line) in self.found.items():
                if key[:2] == ("step", joint.name) and key[4]:
                    at, axis = self._direction(line[:3]), self._direction(line[3:])
                    ends = tuple(tips[joint.child]) or (starts[joint.child],)
                    yield Measured(bool(key[3]), str(key[4]), at, axis, ends)

    def _planes(self, scene: Scene) -> Iterator[Mark]:
        """Yield what wheels and blades touch: a point of it, what touches it, and two ways as long as is drawn."""
        for row in touching(scene):
            radius, opens = self.found.get(("radius", row)), row not in scene.contacts
            if not (radius or row.plane.declared or opens):
                continue
            frame = self.found["frame", row.plane.body]
            graph = frame[0].graph
            normal = unit(row.plane.normal, graph)
            first = _across(normal)
            reach = AROUND * radius[0] if radius else graph.constant(BLADE)
            sizes = ((first, reach), (cross(normal, first), reach), *([(normal, graph.one)] if opens else ()))
            ways = [self._direction(_turned(frame, scale(size, way))) for way, size in sizes]
            rows = (self._direction(self.found["plane", row]), self._direction(self.found["end", row, 0]), *ways)
            yield self._made("floor" if opens else "plane", rows, row.plane.body)

    def _wheels(self, scene: Scene, values: Mapping[str, float]) -> Iterator[Mark]:
        """Yield rims of what rolls or meshes: the centre, and two points a quarter turn apart that turn with it."""
        for row in (*touching(scene), *gears(scene, values)):
            if ("radius", row) not in self.found:
                continue
            (radius,), at = self.found["radius", row], self.found["end", row, 0]
            centre = self._point(at)
            x, _, z = Mat.identity(radius.graph)
            axes = [unit(row.axis, radius.graph)] if row.axis else [z, x]
            for axis in axes:
                rim = self._rim(centre, at, row.place.body, radius, axis)
                yield rim
            if row.axis is None:
                yield self._made("ball", rim.rows[:2], row.place.body)

    def _outlines(
        self, scene: Scene, graph: Graph, values: Mapping[str, float], outlined: Collection[str]
    ) -> Iterator[Mark]:
        """Yield what bodies look like: the centre, and both ends of every way that they extend in."""
        for body in scene.bodies:
            known = outline(scene, body, graph, values) if body.name in outlined else None
            if known is None:
                continue
            look, centre, ways = known
            name, frame = body.name, self.found["frame", body.name]
            at = add(_turned(frame, centre), (frame[9], frame[10], frame[11]))
            turned = [_turned(frame, way) for way in ways]
            rows = [self._point(at)]
            rows += [self._point(add(at, way)) for way in turned] + [self._point(sub(at, way)) for way in turned]
            yield self._made("particle" if look == "point" else look, tuple(rows), name)
            if len(ways) == 3:
                yield self._made("ring", tuple(rows), name)

    def _masses(self, scene: Scene, starts: dict[str, int], tips: dict[str, list[int]]) -> Iterator[Mark]:
        for body in scene.bodies:
            for k in range(len(body.particles)):
                at = self._point(self.found["particle", body.name, k][1:])
                tips[body.name].append(at)
                yield self._made("particle", (at,), body.name)
            if ("com", body.name) in self.found:
                at = self._point(self.found["com", body.name])
                tips[body.name].append(at)
                yield self._made("com", (at,), body.name)
        for point in scene.points:
            at = self._point(self.found["point", point.name][9:])
            tips[point.body].append(at)
            yield self._made("point", (at, starts.get(point.body, at)), point.body, point.name)

    def _acting(self, scene: Scene, tips: dict[str, list[int]]) -> Iterator[Mark]:
        acting: tuple[Element, ...] = (*self._strings, *scene.loads)
        for one in acting:
            if ("tangent", one, 0) in self.found:
                yield from self._rope(one, tips)
                continue
            rows = tuple(self._point(self.found["end", one, k]) for k in range(len(one.ends)))
            for end, row in zip(one.ends, rows, strict=True):
                tips[end.body].append(row)
            if isinstance(one, Load):
                yield self._made("load", (*rows, self._direction(self.found["force", one])), one.place.body, one.name)
            elif rows:
                yield self._made(FORCES[one.kind].lines.page, rows, Scene.GROUND)
            else:
                assert isinstance(one, Strut), "it is at a joint"
                rows, slides, child = self._hinges[one.joint]
                joint = next(joint for joint in scene.joints if joint.name == one.joint)
                where = "turn" if not slides else "zero" if from_zero(scene, joint) else "slide"
                yield self._made(f"{FORCES[one.kind].lines.page}_{where}", rows, child)

    def _rope(self, rope: Element, tips: dict[str, list[int]]) -> Iterator[Mark]:
        """Yield the straight parts of a rope, and the rims of its wheels."""
        for k, end in enumerate(rope.ends):
            at = self.found["end", rope, k]
            if end.turn:
                graph = at[0].graph
                yield self._rim(self._point(at), at, end.body, end.radius.express(graph), unit(end.axis, graph))
            else:
                tips[end.body].append(self._point(at))
        for k in range(0, 2 * len(rope.ends) - 2, 2):
            rows = tuple(self._point(self.found["tangent", rope, k + i]) for i in (0, 1))
            yield self._made("link", rows, Scene.GROUND)

    def _rim(self, centre: int, at: Sequence[Expr], body: str, radius: Expr, axis: Vec) -> Mark:
        """Return the rim of a wheel: its centre, and two points a quarter turn apart that turn with its body."""
        first, frame = _across(axis), self.found["frame", body]
        rim = [_turned(frame, scale(radius, way)) for way in (first, cross(axis, first))]
        ends = [self._point([a + b for a, b in zip(at, way, strict=True)]) for way in rim]
        return self._made("wheel", (centre, *ends), body)


def _turned(frame: Sequence[Expr], way: Vec) -> Vec:
    """Return a direction given in a frame, of which the first nine entries are R."""
    a, b, c, d, e, f, g, h, i = frame[:9]
    return Mat(((a, b, c), (d, e, f), (g, h, i))) @ way


def _across(axis: Vec) -> Vec:
    """Return a unit vector perpendicular to a unit axis, one of the frame's axes if it can be."""
    graph = axis[0].graph
    level = next((k for k in range(3) if axis[k].is_zero), None)
    if level is None:
        return cross(axis, (graph.zero, graph.zero, graph.sqrt(1 / (1 - axis[2] * axis[2]))))
    x, y, z = (graph.one if k == level else graph.zero for k in range(3))
    return (x, y, z)
