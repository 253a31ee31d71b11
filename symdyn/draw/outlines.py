"""What bodies look like: the rod, disc, ring, ball or plate that a scene says, or whose inertia a body has.

A guess is drawn where one inertia means one thing, on a body that carries no other one and does not roll on a rim that
is drawn already, not much larger than the mechanism, and with no joint in a ball or in the course of a rod. Sizes:
`OUTLINES`. A thick rotor, which turns about the axis that it is round about, is drawn as a disc; a body that holds the
next one at its own centre as the ring of a gimbal around it.

What is drawn of a scene, places of bodies, joints, forces, masses and points, are expressions of its coordinates.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics.mechanism import Taut, body_placements, vector
from symdyn.errors import DerivationError, SymdynError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, evaluate, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES, in_plane
from symdyn.scene.joints import JOINTS, joint_motion, unit
from symdyn.scene.values import OUTLINES, Body, Contact, Element, Joint, Load, Place, PlaneContact
from symdyn.spatial import Mat, Transform, Vec, cross, dot, scale, sub, zero_vector

BEYOND = 1e150  # what is drawn, m or N, whose squares still are doubles

ALIKE = 0.01  # share of the largest principal moment within which moments are equal, as of rounded ones
TOUCH = 1e-6  # of the sum of two radii, by which their circles may miss each other
LARGEST = 1.5  # half a size, or a radius, that is guessed: in extents of the mechanism


Formed = tuple[str, Vec, tuple[Vec, ...]]
"""A key of `OUTLINES`, a centre, and ways as in `Outlined`, as formulas in parameters."""


@dataclass(frozen=True)
class Outlined:
    """What a body looks like, in body coordinates."""

    look: str  # a key of `OUTLINES`
    centre: Array  # its centre of mass, m, shape (3,)
    ways: tuple[Array, ...]  # from there half a length of it along each of its ways, or radii of it, m, shape (3,) each


def outlines(
    scene: Scene, parameters: Mapping[str, float], seats: Mapping[str, Array], extent: float
) -> dict[str, Outlined]:
    """Return what bodies look like, by name; those of which nothing is known are left out.

    Args:
        scene: any scene.
        parameters: values of all of them.
        seats: where bodies have the joints that carry them, in their coordinates, m, shape (3,), by name.
        extent: of the mechanism, m: guesses are not much larger; 0 where it has none.
    """
    graph = Graph()
    found = {}
    for body in scene.bodies:
        made = outline(scene, body, graph, parameters)
        if made is None:
            continue
        kind, centre, ways = made
        numbers = _numbers([*centre, *(x for way in ways for x in way)], parameters)
        if numbers is None:
            continue
        at, *drawn = numbers.reshape(-1, 3)
        sizes = [float(np.linalg.norm(way)) for way in drawn]
        made_of = Outlined(kind, at, tuple(drawn))
        if all(size > 0 for size in sizes) and (body.shape or _fits(made_of, sizes, seats[body.name], extent)):
            found[body.name] = made_of
    return found


def _fits(guess: Outlined, sizes: Sequence[float], seat: Array, extent: float) -> bool:
    """Return whether a guess may be drawn: not too large, and no joint inside a ball or in the course of a rod."""
    off, size = float(np.linalg.norm(seat - guess.centre)), max(sizes)
    if extent > 0 and size > LARGEST * extent:
        return False
    return guess.look not in ("ball", "rod") or not ALIKE * size < off < (1 - 2 * ALIKE) * size


def outline(scene: Scene, body: Body, graph: Graph, parameters: Mapping[str, float]) -> Formed | None:
    """Return type, centre and ways of what a body looks like as formulas, in body coordinates; None where unknown.

    Type and directions are those at values of the parameters, sizes follow their formulas.
    """
    said = body.shape
    if said is None and (ring := _gimbal(scene, body, graph, parameters)) is not None:
        return ring
    rim = any(FORCES[row.kind].rolls and row.place.body == body.name for row in scene.contacts)
    carries = any(body.name in (joint.parent, joint.child) for joint in scene.loops) or any(
        joint.parent == body.name for joint in scene.joints
    )
    if (said is None and (rim or carries)) or (rim and said is not None and OUTLINES[said.type].rolls):
        return None
    mass = body.mass.express(graph)
    if mass.is_zero:
        centre: Vec = vector(body.com, graph) if body.com else zero_vector(graph)
    else:
        centre = vector(body.com, graph) if body.com is not None else scale(1 / mass, body.mass_moment(graph))
    tensor = _about_centre(body, graph, mass, centre)
    known = _numbers([mass, *(x for row in tensor for x in row), *centre], parameters)
    if known is None:
        return None
    m, moments, axes = float(known[0]), *_principal(known[1:10].reshape(3, 3), known[10:])
    kind = said.type if said else _guess(m, moments)
    if kind is None and _is_rotor(scene, body, moments, axes[:, 2]):
        kind = "disc"
    if kind is None:
        return None
    row = OUTLINES[kind]
    axis = _numbers(vector(said.axis, graph), {}) if said and said.axis else None
    if axis is not None and row.axis is not None:
        axes = _around(axes, axis / np.linalg.norm(axis), row.axis)
    ways = [_constant(graph, way) for way in axes.T]
    own = [dot(way, tensor @ way) for way in ways]
    given = dict(said.sizes) if said else {}
    lengths = []
    for name, shares in row.sizes.items():
        if name in given:
            length = given[name].express(graph)
        elif mass.is_zero:
            return None
        else:
            total = sum((graph.constant(Fraction(c)) * x for c, x in zip(shares, own, strict=True) if c), graph.zero)
            length = graph.sqrt(total / mass)
        lengths.append(length * graph.constant(Fraction(0.5)) if row.half else length)
    if not lengths:
        return kind, centre, ()
    sizes = lengths if len(lengths) == row.ways else lengths * row.ways
    return kind, centre, tuple(scale(size, way) for way, size in zip(ways, sizes, strict=False))


WIRE = 40  # pieces of a curve that a joint runs along
ROUND = 1.2  # radii of a gimbal's ring and of what turns in it


def _gimbal(scene: Scene, body: Body, graph: Graph, parameters: Mapping[str, float]) -> Formed | None:
    """Return the ring of a gimbal, in the plane of its axes and around what it carries; None for any other body."""
    (seat,) = (joint for joint in scene.joints if joint.child == body.name)
    carried = [joint for joint in scene.joints if joint.parent == body.name]
    if len(carried) != 1 or body.particles or scene.loops or not all(map(_central, (seat, *carried))):
        return None
    (inner,) = (one for one in scene.bodies if one.name == carried[0].child)
    first, second = vector(seat.axis, graph), vector(carried[0].axis, graph)
    normal, within = cross(first, second), outline(scene, inner, graph, parameters)
    if within is None or not within[2] or all(x.is_zero for x in normal):
        return None
    centre, way = within[1], within[2][0]
    if not all(x.is_zero for x in centre):
        return None
    radius = graph.sqrt(dot(way, way)) * graph.constant(Fraction(str(ROUND)))
    ways = (first, cross(normal, first))
    return "ring", centre, tuple(scale(radius / graph.sqrt(dot(one, one)), one) for one in ways)


def _central(joint: Joint) -> bool:
    """Return whether a joint turns about one axis through the origins of the frames of both of its bodies."""
    return tuple(JOINTS[joint.type].coordinates(joint)) == ("rad",) and not (*joint.origin.steps, *joint.tip.steps)


def _is_rotor(scene: Scene, body: Body, moments: Array, axis: Array) -> bool:
    """Return whether a body is round about the axis that it turns about, and flatter than a ball."""
    low, middle, high = moments
    (seat,) = (joint for joint in scene.joints if joint.child == body.name)
    if not (low > 0 and middle - low <= ALIKE * high < high - middle) or not _central(seat):
        return False
    way = _numbers(vector(seat.axis, Graph()), {})
    return way is not None and float(np.linalg.norm(np.cross(way, axis))) < ALIKE * float(np.linalg.norm(way))


def _guess(mass: float, moments: Array) -> str | None:
    """Return what has these principal moments I1 <= I2 <= I3, if only one thing has."""
    low, middle, high = moments
    if not (mass > 0 and high > 0 and low >= -ALIKE * high):
        return None
    if high - low <= ALIKE * high:
        return "ball"
    if high - middle <= ALIKE * high and low <= ALIKE * high:
        return "rod"
    if abs(low + middle - high) <= ALIKE * high:
        return "disc" if middle - low <= ALIKE * high else "plate"
    return None


def _principal(tensor: Array, centre: Array) -> tuple[Array, Array]:
    """Return principal moments in ascending order and their axes as columns; axes of the body where they can be.

    Of a rod's moments that do not tell its axis, the one along the centre of mass stands first.
    """
    if not np.abs(tensor - np.diag(np.diag(tensor))).max() > 1e-9 * np.abs(tensor).max():
        moments, axes = np.diag(tensor), np.eye(3)
        along = -np.abs(centre)
        order = np.lexsort((along, np.round(moments / (np.abs(moments).max() or 1.0), 6)))
        return moments[order], axes[:, order]
    moments, axes = np.linalg.eigh(tensor)
    signs = np.sign(axes[np.abs(axes).argmax(axis=0), range(3)])
    return moments, axes * signs


def _around(axes: Array, axis: Array, place: int) -> Array:
    others = [axes[:, k] for k in range(3)]
    first = max((other - (other @ axis) * axis for other in others), key=lambda x: round(float(np.linalg.norm(x)), 9))
    first = first / np.linalg.norm(first)
    ways = [first, np.cross(axis, first)]
    ways.insert(place, axis)
    return np.stack(ways, axis=1)


def _about_centre(body: Body, graph: Graph, mass: Expr, centre: Vec) -> Mat:
    """Return the inertia of the extended part about its centre of mass, along the axes of the body."""
    xx, yy, zz, xy, xz, yz = (entry.express(graph) for entry in body.inertia)
    if body.about == "frame":
        x, y, z = centre
        xx, yy, zz = xx - mass * (y * y + z * z), yy - mass * (x * x + z * z), zz - mass * (x * x + y * y)
        xy, xz, yz = xy + mass * x * y, xz + mass * x * z, yz + mass * y * z
    return Mat.symmetric(xx, yy, zz, xy, xz, yz)


def _numbers(entries: Sequence[Expr], parameters: Mapping[str, float]) -> Array | None:
    if not entries:
        return np.zeros(0)
    graph = entries[0].graph
    values = {graph.symbol(name): float(value) for name, value in parameters.items()}
    try:
        found = np.array(evaluate(entries, Floats(), values), dtype=np.float64)
    except (ArithmeticError, ValueError, KeyError, SymdynError):
        return None
    return found if np.isfinite(found).all() and np.abs(found).max(initial=0.0) < BEYOND else None


def _constant(graph: Graph, way: Array) -> Vec:
    x, y, z = (graph.constant(Fraction(float(entry))) for entry in way)
    return (x, y, z)


Key = tuple[Any, ...]  # what, then whose: names, numbers, elements


def drawn(scene: Scene, graph: Graph, values: Mapping[str, float] = {}) -> dict[Key, tuple[Expr, ...]]:
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
    for one in (*scene.elements, *touching(scene), *gears(scene, values), *belts(scene, values)):
        wanted |= _element(one, scene, placed, graph)
    return wanted


def touching(scene: Scene) -> tuple[Contact, ...]:
    """Return what touches planes: rows, and what opens and closes as the rows that hold it, sticking unless smooth."""
    found = [*scene.contacts]
    for one in scene.unilaterals:
        if isinstance(one, PlaneContact):
            rough = any(x not in (None, Quantity.ZERO) for x in (one.friction, one.static))
            found.append(one.closed if rough else replace(one.closed, components=("normal",)))
    return tuple(found)


def strings(scene: Scene, values: Mapping[str, float] = {}) -> tuple[Element, ...]:
    """Return what runs along a line: springs, dampers, and ropes, which may be slack."""
    slack = (one for one in scene.unilaterals if one.is_taut)
    return (*scene.struts, *scene.lasting_ropes, *slack, *belts(scene, values))


def _pairs(scene: Scene, values: Mapping[str, float]) -> Iterator[tuple[tuple[Place, Place], float, float, float]]:
    """Yield the wheels of joints that follow others by radii, how far their centres are apart, and their radii, m."""
    joints = {joint.child: joint for joint in scene.joints}
    fixed = ((x.name, x.value.at({})) for x in scene.parameters if x.value is not None)
    values = {name: float(x) for name, x in fixed if x is not None} | dict(values)
    for joint in scene.joints:
        if joint.coupling is None or not joint.coupling.wheels:
            continue
        first, second = joint.coupling.wheels
        graph = Graph()
        near, far = (joints[end.body].origin.transform(graph).p for end in (first, second))
        apart, radii = sub(far, near), [end.radius.express(graph) for end in (first, second)]
        known = _numbers([graph.sqrt(dot(apart, apart)), *radii], values)
        if known is not None:
            yield (first, second), known[0], known[1], known[2]


def gears(scene: Scene, values: Mapping[str, float] = {}) -> tuple[Contact, ...]:
    """Return the pitch circles of wheels that mesh, as what rolls: two a pair, which touch."""
    return tuple(
        Contact(f"{one.body}_{other.body}_{end.body}", "rolling", Place(end.body), end.axis, end.radius)
        for (one, other), apart, r, s in _pairs(scene, values)
        if min(abs(apart - r - s), abs(apart - abs(r - s))) < TOUCH * (r + s)
        for end in (one, other)
    )


def belts(scene: Scene, values: Mapping[str, float]) -> Iterator[Element]:
    """Yield the belts of joints that follow others by radii: around both wheels, where neither is inside the other."""
    for (first, second), apart, r, s in _pairs(scene, values):
        if apart <= (1 + TOUCH) * (r + s) or second.turn < 0:
            continue
        belt = FORCES["rope"].noun(f"{first.body}_{second.body}", ends=(first, second, first))
        try:
            Taut(scene, graph := Graph()).tangents(belt.ends, body_placements(scene, graph))
        except DerivationError:  # they do not lie in one plane
            continue
        yield belt


def _element(one: Element, scene: Scene, placed: Mapping[str, Transform], graph: Graph) -> dict[Key, tuple[Expr, ...]]:
    """Return where an element acts, the wrench of a load, the plane that a wheel or a blade touches, and ropes.

    Of a rope these are the ends of its straight parts, and the axis of every wheel, backwards where it turns right.
    """
    wanted: dict[Key, tuple[Expr, ...]] = {
        ("end", one, k): placed[end.body].point(vector(end.at, graph))
        for k, end in enumerate((scene.seated(one).place,) if isinstance(one, Load) else one.ends)
    }
    if len(one.ends) > 2 or one.is_taut:
        wanted |= {("tangent", one, k): at for k, at in enumerate(Taut(scene, graph).tangents(one.ends, placed))}
        for k, end in enumerate(one.ends):
            axis = vector(end.axis, graph)
            wanted |= {("spin", one, k): placed[end.body].R @ scale(end.turn, axis)} if end.turn else {}
    if isinstance(one, Load):
        R = placed[one.place.body].R if one.frame == "body" else Transform.unit(graph).R
        force, couple = FORCES[one.kind].push.wrench(one, scene, graph)
        wanted |= {("force", one): R @ force, ("couple", one): R @ couple}
    elif isinstance(one, Contact):
        if FORCES[one.kind].rolls and one.radius != Quantity.ZERO:
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


def _wire(joint: Joint, graph: Graph) -> list[Vec]:
    """Return points of the curve that a joint's moved frame runs along, in the joint frame, in order.

    Between its limits; where it has none, half a turn or 1 m to both sides of its start.
    """
    half = graph.pi if JOINTS[joint.type].coordinates(joint) == ("rad",) else graph.one
    start = joint.start[0].express(graph) if joint.start else graph.zero
    low, high = (
        start + sign * half if limit is None else limit.express(graph)
        for limit, sign in ((joint.limits.lower, -1), (joint.limits.upper, 1))
    )
    q, p = graph.symbol(joint.coordinates[0]), joint_motion(joint, graph).placement.p
    places = (low + Fraction(k, WIRE) * (high - low) for k in range(WIRE + 1))
    return [(x[0], x[1], x[2]) for x in (substitute(p, {q: place}) for place in places)]


def _joint(joint: Joint, closes: bool, placed: Mapping[str, Transform], graph: Graph) -> dict[Key, tuple[Expr, ...]]:
    name = joint.name
    fixed = placed[joint.parent] @ joint.origin.transform(graph)
    moved = placed[joint.child] @ joint.tip.transform(graph).inverse()
    wanted: dict[Key, tuple[Expr, ...]] = {("fixed", name): _flat(fixed), ("moved", name): _flat(moved)}
    for own, way in JOINTS[joint.type].directions(joint):
        wanted["way", name, own.name] = vector(way, graph)
    if any(part.shape == "wire" for part in JOINTS[joint.type].mark.parts) and len(joint.coordinates) == 1:
        wanted["wire", name] = tuple(x for at in _wire(joint, graph) for x in fixed.point(at))
    at = fixed
    motion = JOINTS[joint.type].anywhere if closes else joint_motion
    for k, part in enumerate(motion(joint, graph).joints):
        at = at @ part.before
        axis = at.R @ part.axis
        wanted["move", name, k, part.slides] = axis
        for i, x in () if closes else part.rate:
            v = scale(x, axis)
            twist: tuple[Expr, ...] = (*v, *zero_vector(graph)) if part.slides else (*cross(v, sub(moved.p, at.p)), *v)
            before = wanted.get(("twist", name, i), (graph.zero,) * 6)
            wanted["twist", name, i] = tuple(map(Expr.__add__, before, twist))
        if joint.coordinates and not part.amount.is_zero:
            named = str(part.amount.value) if part.amount.op is Op.SYMBOL else ""
            wanted["step", name, k, part.slides, named] = (part.amount, *at.p, *axis)
        at = at @ part.placement
    return wanted


def _flat(T: Transform) -> tuple[Expr, ...]:
    return (*T.R[0], *T.R[1], *T.R[2], *T.p)
