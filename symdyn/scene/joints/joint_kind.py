"""What every joint type tells the algorithms.

A joint's motion is a product of *elementary joints*: turns about and slides along axes, constant placements in between.
Each carries a body of the tree that the recursions run over, so that they know nothing but turns and slides.

    amount     its position in terms of the joint's coordinates, rad or m
    rate       its rate, Σ coefficient · velocity
    bias       its acceleration less Σ coefficient · (rate of velocity), quadratic in the velocities

The rate of a position is what it says. A ball moves by a rotation matrix in front of three turns that stay at zero and
whose rates are the body's angular velocity; the same turns of a gimbal accelerate by products of velocities that those
of a ball do not have, so that the bias takes them away. Bodies, and what they exert on each other, cannot tell.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), sections 4.4 and 4.5.

What a joint looks like: its symbol as parts that pictures know how to draw, and its sign on pages of lessons.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph
from symdyn.scene.values.body import Pose, Step
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key
from symdyn.scene.values.quantity import Quantity, Vector
from symdyn.spatial import Mat, Transform, Vec, Wrench, scale


@dataclass(frozen=True)
class MarkPart:
    """One part of a symbol.

    Attributes:
        shape: a key of `PARTS` in `symdyn.draw.ground`.
        half: its size from its middle, in halves of a symbol's width; 0 for shapes of one size.
        way: its direction: a key of the joint that is one, or "x", "y", "z" of the joint frame.
    """

    shape: str
    half: float = 0.0
    way: str = "axis"


@dataclass(frozen=True)
class PageSign:
    """How pages of lessons draw a joint."""

    shape: str = ""  # what their script draws; "" for nothing
    slides: bool = False  # whether it slides on a rail, along which a spring in it lies
    line: bool = False  # whether a line joins its ends


TURN, SLIDE, WELD, LINE = PageSign("turn"), PageSign("slide", slides=True), PageSign("weld"), PageSign(line=True)


@dataclass(frozen=True)
class JointMark:
    """The symbol of a joint: what it leaves free."""

    parts: tuple[MarkPart, ...]  # of the symbol, from below
    flat: tuple[MarkPart, ...] = ()  # of the symbol face-on in a planar picture; () for the same ones
    sign: PageSign = TURN  # on pages of lessons


@dataclass(frozen=True)
class ElementaryJoint:
    """One turn or slide: a joint of one degree of freedom."""

    slides: bool  # whether it is a slide
    axis: Vec  # unit vector
    amount: Expr  # as in the module's legend; zero where the velocity is not the rate of a position
    before: Transform  # placement in front of it, constant or (a ball's) a function of the coordinates
    rate: tuple[tuple[int, Expr], ...]  # pairs (velocity of the joint from 0, coefficient)
    bias: tuple[tuple[int, int, Expr], ...] = ()  # triples (velocity, velocity, coefficient) of the quadratic form

    @property
    def placement(self) -> Transform:
        graph = self.amount.graph
        if self.slides:
            return Transform(Mat.identity(graph), scale(self.amount, self.axis))
        return Transform.turn(self.axis, self.amount)


@dataclass(frozen=True)
class JointMotion:
    """Motion of a joint, from the joint frame to the moved joint frame.

    Attributes:
        joints: elementary joints in order, from the parent's side.
        tail: constant placement behind the last of them.
        rates: rate of every coordinate in terms of coordinates and velocities, shape (nq,).
        brackets: (j, i, l, value) for [X_j, X_i] = Σ value X_l, of velocities that are no rates of coordinates.
    """

    joints: tuple[ElementaryJoint, ...]
    tail: Transform
    rates: tuple[Expr, ...]
    brackets: tuple[tuple[int, int, int, int], ...] = ()

    @property
    def placement(self) -> Transform:
        """Placement of the moved joint frame in the joint frame."""
        result: Transform | None = None
        for part in self.joints:
            step = part.before @ part.placement
            result = step if result is None else result @ step
        return self.tail if result is None else result @ self.tail

    def blocks(self, first: int) -> list[tuple[int, ...]]:
        """Return the numbers of elementary joints that belong together, in order; the first one's is `first`."""
        together = [{j, i, m} for j, i, m, _ in self.brackets]
        found: list[tuple[int, ...]] = []
        for i in range(len(self.joints)):
            pair = {k for one in self.joints[max(0, i - 1) : i + 1] for k, _ in one.rate}
            before = found.pop() if found and any(pair <= one for one in together) else ()
            found += [()] * bool(before) + [(*before, first + i)]
        return found


@dataclass(frozen=True)
class JointBlock:
    """One part of a joint, which the next one follows.

    Attributes:
        coordinates: unit of each coordinate, "rad", "m" or "1".
        velocities: unit of each velocity times seconds, "rad" or "m".
        motion: its motion from the graph, its coordinates and its velocities.
        letters: names of its velocities where they are no rates of coordinates, to be put behind the joint's name.
        axis: of a part that turns about an axis, or slides along one, and does nothing else; else None.
    """

    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    motion: Callable[[Graph, tuple[Expr, ...], tuple[Expr, ...]], JointMotion]
    letters: tuple[str, ...] = ()
    axis: Vector | None = None

    def quaternion_rates(self, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> list[Expr]:
        """Return the rates of a quaternion, behind those of a position if the block has one."""
        X = self.motion(u[0].graph, q, u).placement
        S = X.R @ Mat.skew((u[-3], u[-2], u[-1]))
        w, *vector = q[-4:]
        turning = (S[0][0] + S[1][1] + S[2][2]) / (8 * w)
        twisting = (S[2][1] - S[1][2], S[0][2] - S[2][0], S[1][0] - S[0][1])
        bending = [(twist / 4 - turning * x) / w for twist, x in zip(twisting, vector, strict=True)]
        sliding = X.R @ (u[0], u[1], u[2]) if len(u) == 6 else ()
        return [*sliding, turning, *bending]


@dataclass(frozen=True)
class Forbids:
    """What joints of a type take away.

    Attributes:
        wrenches: what the parent can exert on the child without working: t wrenches at the origin of the moved joint
            frame, axes of the joint frame, for the placement X of the one in the other.
        residual: t numbers that vanish where X is a placement that the joint allows, m or 1; near such a placement
            their rates are the powers of the wrenches per unit.
    """

    wrenches: Callable[[Joint, Transform], tuple[Wrench, ...]]
    residual: Callable[[Joint, Transform], tuple[Expr, ...]]


@dataclass(frozen=True)
class Gimbal:
    """Two or three turns about moving axes that follow each other.

    Attributes:
        first: place of the first of them among the joint's coordinates.
        axes: of the turns, such as "zxz".
        parallel: what is so where they are singular, {0} and {1} the first and the last angle.
        remedy: what to do about it.
    """

    first: int
    axes: str
    parallel: str
    remedy: str


@dataclass(frozen=True)
class JointKind:
    """One joint type.

    Attributes:
        keys: what it takes beside what every joint takes, such as a direction or a pitch.
        blocks: its parts, from the parent's side.
        forbids: what it takes away; None where that has no formula, so that joints of the type close no loop.
        words: what it is called, by language.
        mark: what it looks like.
        turned: the joint from its child to its parent, frames swapped already, with the coordinates and velocities that
            it had; None where that is no joint of the type, since velocities are measured in the child.
        held: what it does at a position, rad or m, as elementary steps; of one with several coordinates, or with none,
            what it does at zero.
        gimbals: its turns whose angles are singular somewhere.
        fault: what is wrong with keys that are right one by one; "" for nothing.
    """

    keys: tuple[Key[Any], ...]
    blocks: Callable[[Joint], tuple[JointBlock, ...]]
    forbids: Forbids | None
    words: Mapping[str, str]
    mark: JointMark
    turned: Callable[[Joint], Joint] | None = None
    held: Callable[[Joint, Quantity], tuple[Step, ...]] = lambda joint, position: ()
    gimbals: Callable[[Joint], tuple[Gimbal, ...]] = lambda joint: ()
    fault: Callable[[Joint], str] = lambda joint: ""

    @property
    def names_coordinates(self) -> bool:
        """Whether its keys hold formulas in its coordinates, which scenes must name then."""
        return any(isinstance(key.default, Pose) for key in self.keys)

    @property
    def has_axis(self) -> bool:
        return any(key.name == "axis" for key in self.keys)

    def directions(self, joint: Joint) -> Iterator[tuple[Key[Vector], Vector]]:
        for key in self.keys:
            value: Any = key.of(joint)
            if isinstance(value, tuple) and all(isinstance(x, Quantity) for x in value):
                yield key, value

    def coordinates(self, joint: Joint) -> tuple[str, ...]:
        """Return the unit of every coordinate, "rad", "m" or "1"."""
        return tuple(unit for block in self.blocks(joint) for unit in block.coordinates)

    def velocities(self, joint: Joint) -> tuple[str, ...]:
        """Return the unit of every velocity times seconds, "rad" or "m"."""
        return tuple(unit for block in self.blocks(joint) for unit in block.velocities)

    def quaternion(self, joint: Joint) -> int | None:
        """Return which of a joint's coordinates is w of a quaternion (w, x, y, z), None if it has none."""
        units = self.coordinates(joint) if joint.coordinates else ()
        return units.index("1") if "1" in units else None

    def axis(self, joint: Joint) -> Vector | None:
        """Return the axis of a joint that turns about it, or slides along it, and does nothing else; else None."""
        blocks = self.blocks(joint)
        return blocks[0].axis if len(blocks) == 1 else None

    def slides(self, joint: Joint) -> bool:
        """Tell whether a joint moves and never turns."""
        return set(self.velocities(joint)) == {"m"}

    def pins(self, joint: Joint) -> bool:
        """Tell whether a joint keeps two points together: among what it transmits are forces in every direction."""
        wrenches = self.forbids.wrenches(joint, Transform.unit(Graph())) if self.forbids else ()
        return sum(all(x.is_zero for x in moment) for _, moment in wrenches) == 3

    def ball(self, joint: Joint) -> bool:
        """Tell whether a joint is any rotation about a point, at which a rotor may be alike about all axes."""
        turns = self.velocities(joint) == ("rad",) * 3  # asked first: an axis, which no ball has, is not checked yet
        return turns and self.pins(joint)

    def class_t(self, joint: Joint) -> int:
        """Return how many of the six relative freedoms the joint takes away (the textbook's connection of class t)."""
        return 6 - len(self.velocities(joint))

    def motion(self, joint: Joint, graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
        parts, i, k = [], 0, 0
        for block in self.blocks(joint):
            nq, nv = len(block.coordinates), len(block.velocities)
            parts.append((k, block.motion(graph, q[i : i + nq], u[k : k + nv])))
            i, k = i + nq, k + nv
        return _joined(parts, graph)

    def anywhere(self, joint: Joint, graph: Graph) -> JointMotion:
        """Return the motion that the joint of a loop allows, at a position without meaning: fixed directions."""
        q = tuple(graph.constant(Fraction(1, k + 2)) for k in range(len(self.coordinates(joint))))
        return self.motion(joint, graph, q, (graph.zero,) * len(self.velocities(joint)))


def _joined(parts: Sequence[tuple[int, JointMotion]], graph: Graph) -> JointMotion:
    """Return parts, each with the number of its first velocity, as one motion."""
    joints: list[ElementaryJoint] = []
    rates: list[Expr] = []
    brackets: list[tuple[int, int, int, int]] = []
    place = Transform.unit(graph)
    for k, part in parts:
        for one in part.joints:
            rate = tuple((k + i, x) for i, x in one.rate)
            bias = tuple((k + i, k + j, x) for i, j, x in one.bias)
            joints.append(replace(one, before=place @ one.before, rate=rate, bias=bias))
            place = Transform.unit(graph)
        place = place @ part.tail
        rates += part.rates
        brackets += [(k + j, k + i, k + m, value) for j, i, m, value in part.brackets]
    return JointMotion(tuple(joints), place, tuple(rates), tuple(brackets))
