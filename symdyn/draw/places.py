"""Where everything of a scene is that a picture shows, at one position or at many at once.

All arrays have a leading axis of N positions; vectors and rotations are in the ground frame, lengths in m.

Labels go near what they name, clear of each other, and on as few lines as can be. Every label tries places around its
anchor, near ones first. A place costs what lies under it and how far away it is; one on another label is not taken at
all, and a label that finds none worth reading is left out (its group still has a title).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.algebra import Batches
from symdyn.draw.outlines import BEYOND, Key, Outlined, drawn, gears, outlines, strings, touching
from symdyn.draw.style import FONT, Text
from symdyn.errors import DrawError
from symdyn.frozen import dataclass
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Contact, Element, Joint
from symdyn.unlocked import cached_property

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class Frame:
    """A frame: columns of R, shape (N, 3, 3), are its axes; p, shape (N, 3), is its origin."""

    R: Array
    p: Array

    def point(self, x: Array) -> Array:
        """Return a point given in the frame, shape (N, 3)."""
        return self.p + self.direction(x)

    def direction(self, v: Array) -> Array:
        return np.asarray(np.einsum("nij,nj->ni", self.R, np.broadcast_to(v, self.p.shape)))

    def inside(self, x: Array) -> Array:
        """Return a point of the ground frame in this one, shape (N, 3)."""
        return np.asarray(np.einsum("nji,nj->ni", self.R, x - self.p))


@dataclass(frozen=True)
class FrameStep:
    """One turn or slide of a joint by an amount, shape (N,), rad or m, from `at` about or along `axis`."""

    slides: bool
    at: Array
    axis: Array
    amount: Array
    name: str  # the coordinate that the amount is; "" where it is a formula


@dataclass(frozen=True)
class JointAxis:
    """A joint in place: the joint frame on its parent, and the moved joint frame on its child.

    Attributes:
        ways: its directions, unit vectors, by key.
        steps: what its coordinates do; () for a joint that closes a loop or follows another one.
        closes: whether it closes a loop.
        turns, slides: directions of everything that it allows, unit vectors.
        twists: velocity of `moved.p` and angular velocity at a unit of each of its own velocities, shape (N, 6).
        wire: points of the curve that it runs along, shape (N, K, 3); None for no curve.
    """

    joint: Joint
    fixed: Frame
    moved: Frame
    ways: dict[str, Array]
    steps: tuple[FrameStep, ...]
    closes: bool
    turns: tuple[Array, ...]
    slides: tuple[Array, ...]
    twists: tuple[Array, ...]
    wire: Array | None = None


@dataclass(frozen=True)
class Placed:
    """A body in place: its frame, and where its masses are."""

    name: str
    frame: Frame
    com: Array | None  # centre of mass of the extended part; None where it has no mass
    particles: tuple[tuple[float, Array], ...]  # mass in kg, and place


@dataclass(frozen=True)
class PlacedContact:
    """A plane in place, and what touches it."""

    at: Array  # a point of the plane
    normal: Array  # unit vector
    along: Array  # a direction of the plane that turns with its body, unit vector: "along" of a ball
    spot: Array  # the centre of the wheel, or the point of the blade
    across: Array | None  # of a blade, the direction of its force, unit vector; of a wheel None
    drawn: bool  # whether the plane is: a blade's where the scene declares it


@dataclass(frozen=True)
class Places:
    """A scene in place; `ends` holds the points that struts and loads act at, `acting` force and couple of loads.

    `routes` holds the points that ropes are drawn through, by straight parts, the ends of each last.

    `wheels` holds the rims of what rolls: centre, unit axis (None for a ball) and radius in m, by the name of the row.
    `touches` holds what wheels, balls and blades touch, likewise. `outlines` holds what bodies look like, by name.
    """

    count: int
    ground: Frame
    bodies: tuple[Placed, ...]
    hinges: tuple[JointAxis, ...]
    points: dict[str, tuple[str, Frame]]
    ends: dict[Element, tuple[Array, ...]]
    routes: dict[Element, tuple[tuple[Array, ...], ...]]
    acting: dict[Element, tuple[Array, Array]]
    wheels: dict[str, tuple[Array, Array | None, float]]
    touches: dict[str, PlacedContact]
    gravity: Array
    outlines: dict[str, Outlined]

    def body(self, name: str) -> Placed:
        return next(body for body in self.bodies if body.name == name)

    @property
    def spots(self) -> list[Array]:
        """Where joints, masses and points are, shape (N, 3) each."""
        spots = [at for hinge in self.hinges for at in (hinge.fixed.p, hinge.moved.p)]
        spots += [body.com for body in self.bodies if body.com is not None]
        spots += [at for body in self.bodies for _, at in body.particles]
        return spots + [frame.p for _, frame in self.points.values()]

    @property
    def reach(self) -> float:
        """The largest distance of joints, masses and points along an axis at all positions, m; 1 if there is none."""
        return float(np.ptp(np.concatenate(self.spots), axis=0).max()) or 1.0 if self.spots else 1.0

    @property
    def extent(self) -> float:
        """The largest width of the mechanism along an axis of the ground frame at the first position, m; 0 of a point.

        How far a body is from a ground that it flies over is none of it.
        """
        far = [hinge.fixed.p for hinge in self.hinges if len(hinge.turns) == len(hinge.slides) == 3]
        spots = [at[0] for at in self.spots if not any(at is one for one in far)]
        return float(np.ptp(spots, axis=0).max()) if spots else 0.0


def places(scene: Scene, q: Array, parameters: Mapping[str, float]) -> Places:
    """Return where everything is at positions q, shape (N, nq), in the scene's order; rad, m or 1.

    Velocities are zero, and so is time; all free parameters have values. Behind coordinates may stand inputs and t, all
    of them, where these move supports.

    Raises:
        DrawError: q has another shape, or a formula has no real value there.
    """
    columns = (*scene.coordinates, *(one.name for one in scene.inputs), "t")
    if q.ndim != 2 or q.shape[1] not in (len(scene.coordinates), len(columns)):
        names = ", ".join(scene.coordinates)
        raise DrawError(f"{scene.name}: positions have shape {q.shape}; give (N, {len(scene.coordinates)}): {names}")
    graph = Graph()
    wanted = drawn(scene, graph)
    known: dict[str, Any] = dict.fromkeys(scene.velocities, np.float64(0))
    known |= {str(node.value): np.float64(x) for node, x in scene.at_time(graph).items()}
    known |= dict(zip(columns, q.T, strict=False))
    known |= {name: np.float64(value) for name, value in parameters.items()}
    values = {graph.symbol(name): value for name, value in known.items()}
    entries = [entry for group in wanted.values() for entry in group]
    unknown = [node for node in reachable(entries) if node.op is Op.SYMBOL and node not in values]
    assert not unknown, f"the scene's check lets no unknown symbol {unknown} through"
    try:
        with np.errstate(all="ignore"):
            found = evaluate(entries, Batches(), values)
        table = np.stack([np.broadcast_to(np.asarray(x, dtype=np.float64), (len(q),)) for x in found], axis=1)
    except (ArithmeticError, ValueError) as fault:
        raise DrawError(f"{scene.name}: a formula has no real value at this position ({fault})") from fault
    if not np.isfinite(table).all():
        row = int(np.argmin(np.isfinite(table).all(axis=1)))
        raise DrawError(f"{scene.name}: a formula has no real value at q = {q[row].tolist()}; give another position")
    if np.abs(table).max(initial=0.0) > BEYOND:
        far = f"a length or a force is beyond {BEYOND:g}, its square beyond the largest double"
        raise DrawError(f"{scene.name}: {far}; choose units that keep numbers smaller")
    arrays, first = {}, 0
    for key, group in wanted.items():
        arrays[key] = table[:, first : first + len(group)]
        first += len(group)
    gathered = _gathered(scene, graph, arrays, len(q))
    seats = {
        hinge.joint.child: gathered.body(hinge.joint.child).frame.inside(hinge.moved.p)[0]
        for hinge in gathered.hinges
        if not hinge.closes
    }
    gathered.outlines.update(outlines(scene, parameters, seats, gathered.extent))
    return gathered


def _gathered(scene: Scene, graph: Graph, arrays: Mapping[Key, Array], count: int) -> Places:
    def frame(*key: str) -> Frame:
        return Frame(arrays[key][:, :9].reshape(count, 3, 3), arrays[key][:, 9:])

    bodies = []
    for body in scene.bodies:
        grains = [arrays["particle", body.name, k] for k in range(len(body.particles))]
        particles = tuple((float(grain[0, 0]), grain[:, 1:]) for grain in grains)
        bodies.append(Placed(body.name, frame("frame", body.name), arrays.get(("com", body.name)), particles))
    hinges = []
    for joint in (*scene.joints, *scene.loops):
        fixed, moved = frame("fixed", joint.name), frame("moved", joint.name)
        own = [(key, x) for key, x in arrays.items() if key[0] in ("step", "move") and key[1] == joint.name]
        steps = tuple(FrameStep(key[3], x[:, 1:4], x[:, 4:7], x[:, 0], key[4]) for key, x in own if key[0] == "step")
        ways = {
            key.name: unit((moved if key.turned else fixed).direction(arrays["way", joint.name, key.name]))
            for key, _ in JOINTS[joint.type].directions(joint)
        }
        moves = [(key[3], unit(x)) for key, x in own if key[0] == "move"]
        turns, slides = (tuple(x for slide, x in moves if slide is kind) for kind in (False, True))
        twists = tuple(arrays[key] for key in sorted(key for key in arrays if key[:2] == ("twist", joint.name)))
        wire = arrays["wire", joint.name].reshape(count, -1, 3) if ("wire", joint.name) in arrays else None
        hinges.append(JointAxis(joint, fixed, moved, ways, steps, joint in scene.loops, turns, slides, twists, wire))
    return Places(
        count,
        frame("frame", Scene.GROUND),
        tuple(bodies),
        tuple(hinges),
        {point.name: (point.body, frame("point", point.name)) for point in scene.points},
        {
            one: tuple(arrays["end", one, k] for k in range(len(one.ends)))
            for one in (*strings(scene), *scene.loads)
            if one.ends
        },
        {
            one: tuple(_straight(one, k, arrays) for k in range(len(one.ends) - 1))
            for one in strings(scene)
            if ("tangent", one, 0) in arrays
        },
        {load: (arrays["force", load], arrays["couple", load]) for load in scene.loads},
        {row.name: wheel for row in (*touching(scene), *gears(scene)) if (wheel := _wheel(row, arrays)) is not None},
        {row.name: _touch(row, arrays) for row in touching(scene)},
        arrays["gravity",][0],
        {},
    )


def _straight(rope: Element, k: int, arrays: Mapping[Key, Array]) -> tuple[Array, ...]:
    """Return what lies around the wheel before straight part k of a rope, if there is one, and its two ends."""
    start, end = arrays["tangent", rope, 2 * k], arrays["tangent", rope, 2 * k + 1]
    if not k or ("spin", rope, k) not in arrays:  # a rope that begins on a wheel is wound up there
        return (start, end)
    centre, n = arrays["end", rope, k], unit(arrays["spin", rope, k])
    out, to = arrays["tangent", rope, 2 * k - 1] - centre, start - centre
    sine, cosine = np.einsum("ni,ni->n", n, np.cross(out, to)), np.einsum("ni,ni->n", out, to)
    angle = np.arctan2(sine, cosine) % (2 * np.pi)
    across = np.cross(n, out)
    arc = [centre + np.cos(x)[:, None] * out + np.sin(x)[:, None] * across for x in np.multiply.outer(ARC, angle)]
    return (*arc, start, end)


def _wheel(row: Contact, arrays: Mapping[Key, Array]) -> tuple[Array, Array | None, float] | None:
    if ("radius", row) not in arrays:
        return None
    return arrays["end", row, 0], unit(arrays["axis", row]) if row.axis else None, float(arrays["radius", row][0, 0])


def _touch(row: Contact, arrays: Mapping[Key, Array]) -> PlacedContact:
    across = unit(arrays["axis", row]) if row.axis and ("radius", row) not in arrays else None
    normal, along = unit(arrays["normal", row]), unit(arrays["along", row])
    drawn = "normal" in row.components or row.plane.declared
    return PlacedContact(arrays["plane", row], normal, along, arrays["end", row, 0], across, drawn)


def unit(vectors: Array) -> Array:
    """Return vectors with length 1, those of no length as they are; shape (..., 3) or (..., 2)."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0))


def across(axis: Array) -> Array:
    """Return a unit vector perpendicular to each unit axis, shape (N, 3), always the same one for the same axis."""
    least = np.eye(3)[np.argmin(np.round(np.abs(axis), 6), axis=-1)]
    return unit(np.cross(axis, least))


ARC = np.linspace(0.0, 1.0, 17)[1:-1]
"""Shares of what lies around a wheel, at which a rope is drawn."""

ANGLES = np.radians(np.arange(0, 360, 22.5))
WAYS = (0.0, 5.0, 11.0, 18.0, 27.0, 38.0, 52.0, 70.0)
CROSSING, DISTANCE, TURNED = 16.0, 0.35, 3.0  # what a crossed line, a unit of way, and a turn away cost
DEAREST = 44.0  # what the place of a label may cost: less than three crossed lines
LEADER = 20.0  # from this way on a thin line leads to the label
LED = 8.0  # what such a line costs
ROUGH = 3.0  # room around a label
AT_ONCE, MOMENTS = 16, 4000  # places that are looked at together, and places times moments
SAME = 1e-9  # costs that differ by less are equal

OUTWARDS = np.repeat(WAYS, len(ANGLES))
"""How far out each place that is tried lies, nearest first, shape (places,)."""

DIRECTIONS = np.tile(np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1), (len(WAYS), 1))
"""And in which direction, shape (places, 2)."""


@dataclass(frozen=True)
class Label:
    """A name to be put somewhere."""

    id: str  # of its element, without the picture's prefix
    text: Text
    at: Array  # anchor at N moments, shape (N, 2)
    gap: float  # distance from the anchor at which the label may begin
    away: Array | None = None  # preferred direction, shape (2,); None for none
    look: str = ""  # its classes in the style sheet

    @cached_property
    def half(self) -> Array:
        return np.array([self.text.width / 2, FONT * (0.62 if self.text.lowered else 0.5)])


@dataclass(frozen=True)
class Put:
    """A label and the middle of its box as seen from the anchor, shape (2,)."""

    label: Label
    offset: Array

    @property
    def box(self) -> Array:
        """Low and high corner at every moment, shape (N, 2, 2)."""
        middle = self.label.at + self.offset
        return np.stack([middle - self.label.half, middle + self.label.half], axis=1)

    @property
    def leader(self) -> tuple[Array, Array] | None:
        """Ends of the line that leads to a label far from its anchor, seen from the anchor; None for a near one."""
        edge = self.offset - np.clip(self.offset, -self.label.half, self.label.half)
        length = float(np.linalg.norm(edge))
        if length < LEADER + self.label.gap:
            return None
        return edge / length * self.label.gap, edge * (1 - 2 / length)


def put(labels: Sequence[Label], segments: Array, most: float = DEAREST) -> tuple[Put, ...]:
    """Return the labels that find a place, in order; earlier ones choose first.

    They keep clear of segments, shape (N, S, 2, 2); a label that finds no place that costs at most so much is left out.
    """
    done: list[Put] = []
    for label in labels:
        boxes = np.stack([one.box for one in done], axis=1) if done else np.zeros((len(segments), 0, 2, 2))
        if (offset := _best(label, segments, boxes, most)) is None:
            continue
        done.append(Put(label, offset))
        if done[-1].leader is not None:
            segments = np.concatenate([segments, _led(done[-1])], axis=1)
    return tuple(done)


def _best(label: Label, segments: Array, boxes: Array, most: float) -> Array | None:
    """Return the offset that costs least; of several, the nearest, and of these the first round the anchor."""
    offsets = np.round(
        DIRECTIONS * (label.gap + OUTWARDS[:, None])
        + np.sign(np.round(DIRECTIONS, 9)) * label.half * np.minimum(1.0, np.abs(DIRECTIONS) * 1.6),
        2,
    )  # all of half a box lies between the anchor's circle and its middle, or none sideways
    costs = OUTWARDS * DISTANCE
    if label.away is not None:
        costs = costs + TURNED * (1 - DIRECTIONS @ label.away)
    (begin, end), (best, least) = (np.min(segments, axis=2), np.max(segments, axis=2)), (-1, most)
    order, several = np.argsort(costs, kind="stable"), max(1, min(AT_ONCE, MOMENTS // len(segments)))
    for block in np.split(order, range(several, len(order), several)):
        if costs[block[0]] > least:
            break
        middles = label.at[:, None] + offsets[block]
        low, high = middles - label.half - ROUGH, middles + label.half + ROUGH
        free = np.logical_not(_overlaps(low, high, boxes))
        far = (begin > np.max(high, axis=1, keepdims=True) + 1) | (end < np.min(low, axis=1, keepdims=True) - 1)
        near = segments[:, np.logical_not(np.all(np.any(far, axis=2), axis=0))]  # most of the work is to cross others
        crossed = np.mean(np.sum(crosses(low, high, near[:, None]), axis=2), axis=0)
        for k, crossings in zip(block[free].tolist(), crossed[free].tolist(), strict=True):
            cost, led = float(costs[k]) + CROSSING * crossings, Put(label, offsets[k])
            if led.leader is not None and cost <= least:
                cost += LED
                leader = _led(led)
                if any(crosses(boxes[:, i, 0], boxes[:, i, 1], leader).any() for i in range(boxes.shape[1])):
                    continue
            if cost < least - SAME or (k < best and cost < least + SAME):
                best, least = k, min(cost, least)
    return offsets[best] if best >= 0 else None


def _led(one: Put) -> Array:
    assert one.leader is not None, "asked only of labels far from their anchors"
    return np.stack([one.label.at + end for end in one.leader], axis=1)[:, None]


def _overlaps(low: Array, high: Array, boxes: Array) -> Array:
    """Return which of the boxes with corners of shape (N, B, 2) meet others, shape (N, K, 2, 2): shape (B,)."""
    others = boxes[:, None]
    apart = (others[..., 1, :] <= low[:, :, None]) | (others[..., 0, :] >= high[:, :, None])
    return np.asarray(np.any(~np.any(apart, axis=3), axis=(0, 2)))


def crosses(low: Array, high: Array, segments: Array) -> Array:
    """Return which segments, shape (..., S, 2, 2), meet which box, corners of shape (..., 2): shape (..., S)."""
    middle, half = (low + high)[..., None, :] / 2, (high - low)[..., None, :] / 2
    a, b = segments[..., 0, :], segments[..., 1, :]
    centre, reach = (a + b) / 2 - middle, (b - a) / 2
    beside = np.any(np.abs(centre) > half + np.abs(reach), axis=-1)
    turned = np.abs(centre[..., 0] * reach[..., 1] - centre[..., 1] * reach[..., 0])
    limit = half[..., 0] * np.abs(reach[..., 1]) + half[..., 1] * np.abs(reach[..., 0])
    return np.asarray(~(beside | (turned > limit)))
