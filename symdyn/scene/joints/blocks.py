"""The parts that joints are made of: turns, slides, screws, a ball, free flight, motions in formulas; what they forbid.

A direction is often given by angles, as (cos a, sin a, 0), and the root that makes it a unit vector would stay in all
that is derived: so lengths that are numbers are told, sin² x + cos² x = 1 and √n √n = n, in small polynomials.

A joint at a fixed position is elementary steps along or about a coordinate axis, between two turns if the axis is
oblique. Turned round, a joint has the same coordinates and velocities, and takes the child back to the parent.

What a joint forbids are wrenches that do no work, and residuals of placement:

    X        placement of the moved joint frame in the joint frame
    A        rotation that takes z to the joint's axis; its columns are directions in the joint frame
    R, p     rotation and translation of X

Wrenches (force, moment) act at the origin of the moved frame; axes of the joint frame.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import product

from symdyn.graph import Expr, Graph, Op, gradient
from symdyn.scene.joints.joint_kind import ElementaryJoint, Forbids, Gimbal, JointBlock, JointMotion
from symdyn.scene.values.body import Pose, Step, inverse_steps, towards
from symdyn.scene.values.entry import EntryReader, show
from symdyn.scene.values.folding import neg
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key
from symdyn.scene.values.quantity import Quantity, Vector
from symdyn.scene.values.shape import choice_of
from symdyn.spatial import Mat, Transform, Vec, Wrench, add, cross, dot, scale, zero_vector

MOST, HIGHEST = 60, 12
"""Nodes or terms, and powers, beyond which nobody looks: the square of a direction has fewer."""

SIGNS = {Op.ADD: (1, 1), Op.SUB: (1, -1), Op.NEG: (-1,)}

Atom = tuple[Op, Expr]  # SIN or COS and its angle; SYMBOL and any other node
Powers = tuple[tuple[Atom, int], ...]
Terms = dict[Powers, Fraction]


def as_number(node: Expr) -> Fraction | None:
    """Return what a node is worth if that is one number everywhere, None if it is not, or too long to tell."""
    found: dict[Expr, Terms] = {}
    for here in _polynomial(node):
        terms = _terms(here, found)
        if terms is None or len(terms) > MOST:
            return None
        found[here] = terms
    if not found:
        return None
    (powers, value), *others = found[node].items() or [((), Fraction(0))]
    return None if others or powers else value


def _polynomial(node: Expr) -> list[Expr]:
    """Return the nodes that a polynomial is made of, arguments first; none of a long one."""
    seen, stack = {node}, [node]
    while stack and len(seen) <= MOST:
        here = stack.pop()
        more = {*here.args} - seen if here.op in SIGNS or here.op is Op.MUL else set()
        seen |= more
        stack += more
    return sorted(seen, key=lambda x: x.index) if len(seen) <= MOST else []


def _terms(node: Expr, found: dict[Expr, Terms]) -> Terms | None:
    """Return a node as a polynomial in sines, cosines and other nodes; None if it is long."""
    result: Terms = {}
    if isinstance(node.value, Fraction):
        _add(result, {}, node.value)
    elif node.op in SIGNS:
        for sign, arg in zip(SIGNS[node.op], node.args, strict=True):
            for powers, a in found[arg].items():
                _add(result, dict(powers), sign * a)
    elif node.op is Op.MUL:
        left, right = (found[arg] for arg in node.args)
        if len(left) * len(right) > MOST:
            return None
        for (p, a), (r, b) in product(left.items(), right.items()):
            both = dict(p)
            for atom, power in r:
                both[atom] = both.get(atom, 0) + power
            if sum(both.values()) > HIGHEST:
                return None
            _add(result, both, a * b)
    else:
        circular = node.op in (Op.SIN, Op.COS)
        _add(result, {(node.op, node.args[0]) if circular else (Op.SYMBOL, node): 1}, Fraction(1))
    return result


def _add(result: Terms, powers: dict[Atom, int], a: Fraction) -> None:
    """Add a term in normal form: no square of a sine, and none of the root of a number."""
    for atom, power in powers.items():
        op, node = atom
        if power < 2:
            continue
        rest = powers | {atom: power - 2}
        if op is Op.SIN:  # sin² = 1 - cos²
            cosine = (Op.COS, node)
            _add(result, rest, a)
            _add(result, rest | {cosine: rest.get(cosine, 0) + 2}, -a)
            return
        if node.op is Op.SQRT and isinstance(node.args[0].value, Fraction):
            _add(result, rest, a * node.args[0].value)
            return
    key = tuple(sorted(((x, n) for x, n in powers.items() if n), key=lambda item: (item[0][1].index, item[0][0].value)))
    total = result.pop(key, Fraction(0)) + a
    if total:
        result[key] = total


AXES: dict[str, Vector] = {
    "x": (Quantity.ONE, Quantity.ZERO, Quantity.ZERO),
    "y": (Quantity.ZERO, Quantity.ONE, Quantity.ZERO),
    "z": (Quantity.ZERO, Quantity.ZERO, Quantity.ONE),
}


# Keys of more than one type


def _orientation(table: EntryReader, name: str, default: str) -> str:
    raw = table.text(name, default)
    axes = len(raw) == 3 and all(letter in "xyz" for letter in raw) and raw[0] != raw[1] != raw[2]
    if raw != "quaternion" and not axes:
        table.fault(
            f'{name} = {show(raw)} is neither "quaternion" nor three axes of which no two neighbours are equal; '
            'write one such as "zyx" or "zxz"'
        )
        return default
    return raw


AXIS: Key[Vector] = Key(
    "axis", EntryReader.vector, AXES["z"], names=None, holds="direction in the frame of the joint, any length but zero"
)

SEQUENCES = tuple("".join(axes) for axes in product("xyz", repeat=3) if axes[0] != axes[1] != axes[2])

ORIENTATION = Key(
    "orientation",
    _orientation,
    "quaternion",
    holds="quaternion, or three axes of turns",
    shape=choice_of("quaternion", *SEQUENCES),
)
"""How any rotation is described: "quaternion", or three axes such as "zyx"."""


# Parts


def unit(axis: Vector, graph: Graph) -> Vec:
    """Return the axis with length 1, exact (with a root where its length is irrational): 1 of (cos a, sin a, 0)."""
    x, y, z = (entry.express(graph) for entry in axis)
    square = dot((x, y, z), (x, y, z))
    number = as_number(square)
    return scale(graph.one / graph.sqrt(number if number and number > 0 else square), (x, y, z))


def turn(axis: Vector) -> JointBlock:
    """Return a rotation about an axis, rad."""

    def motion(graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
        still = Transform.unit(graph)
        return JointMotion((ElementaryJoint(False, unit(axis, graph), q[0], still, ((0, graph.one),)),), still, u)

    return JointBlock(("rad",), ("rad",), motion, axis=axis)


def slide(axis: Vector) -> JointBlock:
    """Return a translation along an axis, m."""

    def motion(graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
        still = Transform.unit(graph)
        return JointMotion((ElementaryJoint(True, unit(axis, graph), q[0], still, ((0, graph.one),)),), still, u)

    return JointBlock(("m",), ("m",), motion, axis=axis)


def screw(axis: Vector, pitch: Quantity) -> JointBlock:
    """Return a rotation about an axis, rad, with an advance along it of `pitch` a turn, m."""

    def motion(graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
        still, z = Transform.unit(graph), unit(axis, graph)
        rise = pitch.express(graph) / (2 * Quantity.PI.express(graph))
        turned = ElementaryJoint(False, z, q[0], still, ((0, graph.one),))
        return JointMotion((turned, ElementaryJoint(True, z, rise * q[0], still, ((0, rise),))), still, u)

    return JointBlock(("rad",), ("rad",), motion)


def shift(axis: Vector, way: Quantity) -> JointBlock:
    """Return a constant translation along an axis, m."""

    def motion(graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
        place = Transform(Mat.identity(graph), scale(way.express(graph), unit(axis, graph)))
        return JointMotion((), place, ())

    return JointBlock((), (), motion)


def aligned(axis: Vector, back: bool = False) -> JointBlock:
    """Return the constant rotation that takes z to an axis, or the one back."""

    def motion(graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
        R = Mat.towards(unit(axis, graph))
        return JointMotion((), Transform(R.T if back else R, zero_vector(graph)), ())

    return JointBlock((), (), motion)


def along(axis: Vector, *blocks: JointBlock) -> tuple[JointBlock, ...]:
    """Return blocks in a frame whose z is along an axis; at zero the moved frame is the fixed one."""
    if axis == AXES["z"]:
        return blocks
    return (aligned(axis), *blocks, aligned(axis, back=True))


def orientation(joint: Joint) -> tuple[JointBlock, ...]:
    """Return a spherical motion as the joint describes it: a quaternion, or three turns about moving axes."""
    described = ORIENTATION.of(joint)
    return (BALL,) if described == ORIENTATION.default else tuple(turn(AXES[letter]) for letter in described)


def gimbals(first: int) -> Callable[[Joint], tuple[Gimbal, ...]]:
    """Return the angles of joints with a spherical motion whose coordinates begin at `first`; a quaternion has none."""

    def found(joint: Joint) -> tuple[Gimbal, ...]:
        axes = ORIENTATION.of(joint)
        if axes == ORIENTATION.default:
            return ()
        another = "zyx" if axes[0] == axes[2] else "zxz"
        remedy = f'describe it by orientation = "quaternion", or by another sequence such as "{another}"'
        return (Gimbal(first, axes, "the axes of {0} and {1} are parallel, so that the angles are singular", remedy),)

    return found


def path(steps: Pose, names: tuple[str, ...], units: tuple[str, ...]) -> JointBlock:
    """Return elementary motions whose amounts are formulas in the coordinates called `names`."""

    def motion(graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
        place, joints = Transform.unit(graph), []
        for kind, amount in steps.steps:
            node = amount.express(graph)
            slopes = gradient(node, q)
            if all(slope.is_zero for slope in slopes):
                place = place @ Transform.elementary(kind, node)
                continue
            rate = tuple((k, slope) for k, slope in enumerate(slopes) if not slope.is_zero)
            curved = [(k, m, x) for k, slope in enumerate(slopes) for m, x in enumerate(gradient(slope, q))]
            bias = tuple(entry for entry in curved if not entry[2].is_zero)
            joints.append(ElementaryJoint(kind[0] == "T", unit(AXES[kind[1]], graph), node, place, rate, bias))
            place = Transform.unit(graph)
        return JointMotion(tuple(joints), place, u)

    return JointBlock(units, units, motion)


# A ball and free flight


def _quaternion_rates(e: tuple[Expr, ...], omega: Vec) -> tuple[Expr, ...]:
    """Return ½ e ∘ (0, ω), ω in the turned frame."""
    (w, x, y, z), (a, b, c) = e, omega
    return (
        -(x * a + y * b + z * c) / 2,
        (w * a + y * c - z * b) / 2,
        (w * b + z * a - x * c) / 2,
        (w * c + x * b - y * a) / 2,
    )


def _spin(graph: Graph, before: Transform, first: int) -> tuple[ElementaryJoint, ...]:
    """Return three turns at zero whose rates are ω in the turned frame, velocities beginning with `first`."""
    still, (a, b, c) = Transform.unit(graph), (first, first + 1, first + 2)
    zero, one, minus = graph.zero, graph.one, graph.constant(-1)
    bias = ((b, c, minus), (a, c, one), (a, b, minus))
    return tuple(
        ElementaryJoint(False, unit(AXES[letter], graph), zero, still if k else before, ((first + k, one),), (bias[k],))
        for k, letter in enumerate("xyz")
    )


def _ball(graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
    turned = Transform(Mat.of_quaternion(q), zero_vector(graph))
    brackets = tuple(bracket for k in range(3) for bracket in _pair(k, (k + 1) % 3, (k + 2) % 3))
    return JointMotion(
        _spin(graph, turned, 0), Transform.unit(graph), _quaternion_rates(q, (u[0], u[1], u[2])), brackets
    )


def _pair(j: int, i: int, m: int, value: int = 1) -> tuple[tuple[int, int, int, int], ...]:
    """Return [X_j, X_i] = value X_m and its opposite."""
    return ((j, i, m, value), (i, j, m, -value))


def _flight(graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
    v, omega, e = (u[0], u[1], u[2]), (u[3], u[4], u[5]), q[3:]
    R, still, one = Mat.of_quaternion(e), Transform.unit(graph), graph.one
    placed = Transform(R, (q[0], q[1], q[2]))
    slides = []
    for k in range(3):  # d(R v)/dt = R (v̇ + ω × v)
        i, j = (k + 1) % 3, (k + 2) % 3
        bias = ((3 + i, j, one), (3 + j, i, -one))
        axis, before = unit(AXES["xyz"[k]], graph), placed if k == 0 else still
        slides.append(ElementaryJoint(True, axis, graph.zero, before, ((k, one),), bias))
    rates = (*(dot(row, v) for row in R), *_quaternion_rates(e, omega))
    brackets: list[tuple[int, int, int, int]] = []
    for k in range(3):  # [ω_k, ω_i] = ω_j and [ω_k, v_i] = v_j
        i, j = (k + 1) % 3, (k + 2) % 3
        brackets += [*_pair(3 + k, 3 + i, 3 + j), *_pair(3 + k, i, j), *_pair(3 + i, k, j, -1)]
    return JointMotion((*slides, *_spin(graph, still, 3)), still, rates, tuple(brackets))


BALL = JointBlock(("1",) * 4, ("rad",) * 3, _ball, ("wx", "wy", "wz"))
"""Orientation by a unit quaternion (w, x, y, z), angular velocity in the turned frame."""

FLIGHT = JointBlock(("m",) * 3 + ("1",) * 4, ("m",) * 3 + ("rad",) * 3, _flight, ("vx", "vy", "vz", "wx", "wy", "wz"))
"""Position and quaternion; velocity of the origin and angular velocity, both in the moved frame."""


Steps = tuple[Step, ...]


def held(joint: Joint, position: Quantity, motion: Callable[[Quantity], Steps]) -> Steps:
    """Return what a joint does at a position along or about its axis; () at zero.

    Args:
        joint: one with an axis.
        position: rad or m.
        motion: steps "R" about and "T" along the axis, of a position in the sense of the axis.
    """
    if position == Quantity.ZERO:
        return ()
    along = [(k, value) for k, x in enumerate(joint.axis) if (value := x.at({})) != 0]
    there: Steps = ()
    if len(along) == 1:
        ((k, value),) = along
        position = position if value is not None and value > 0 else neg(position)
    else:
        k, there = 2, towards(joint.axis)
    return (*there, *((kind + "xyz"[k], amount) for kind, amount in motion(position)), *inverse_steps(there))


def about_opposite(joint: Joint) -> Joint:
    """Return a joint about, or along, the opposite axis."""
    return joint.shaped(axis=opposite(joint.axis))


def opposite(axis: Vector) -> Vector:
    """Return the opposite axis."""
    return (neg(axis[0]), neg(axis[1]), neg(axis[2]))


def forbidding(shifts: str, turns: str = "none") -> Forbids:
    """Return what a joint forbids that takes away shifts and turns: those "along" or "across" its axis, or "all".

    Turns are "all", those about directions "across" the axis, or "none". Forces and moments are along the same ones.
    """

    def wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
        graph = X.p[0].graph
        return forces(*chosen(shifts, joint, graph)) + moments(*chosen(turns, joint, graph))

    def residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
        graph = X.p[0].graph
        gone = offsets(X, *chosen(shifts, joint, graph))
        if turns == "all":
            return gone + turned(X)
        x, y, axis = directions(joint.axis, graph)
        return gone + (leaning(X, axis, x, y) if turns == "across" else ())

    return Forbids(wrenches, residual)


def chosen(which: str, joint: Joint, graph: Graph) -> tuple[Vec, ...]:
    """Return the directions of the joint frame that a word means."""
    if which in ("all", "none"):
        return Mat.identity(graph) if which == "all" else ()
    x, y, axis = directions(joint.axis, graph)
    return (x, y) if which == "across" else (axis,)


def directions(axis: Vector, graph: Graph) -> tuple[Vec, Vec, Vec]:
    """Return two directions across an axis and one along it, the columns of A: of the frame, where the axis is one."""
    e, u = Mat.identity(graph), unit(axis, graph)
    k = next((k for k in range(3) if u[k] in (graph.one, graph.constant(-1))), None)
    return Mat.towards(u).T if k is None else (e[k - 2], e[k - 1], e[k])


def forces(*along: Vec) -> tuple[Wrench, ...]:
    """Return unit forces."""
    return tuple(Wrench(x, zero_vector(x[0].graph)) for x in along)


def moments(*along: Vec) -> tuple[Wrench, ...]:
    """Return unit moments."""
    return tuple(Wrench(zero_vector(x[0].graph), x) for x in along)


def offsets(X: Transform, *along: Vec) -> tuple[Expr, ...]:
    """Return the components of p along directions, m."""
    return tuple(dot(x, X.p) for x in along)


def leaning(X: Transform, axis: Vec, *across: Vec) -> tuple[Expr, ...]:
    """Return the components of axis × R axis along directions: how far the axis leans."""
    lean = cross(axis, X.R @ axis)
    return tuple(dot(x, lean) for x in across)


def turned(X: Transform) -> Vec:
    """Return ½ Σ e × R e: zero without rotation, the rotation vector close to it."""
    graph = X.p[0].graph
    total = zero_vector(graph)
    for e in Mat.identity(graph):
        total = add(total, cross(e, X.R @ e))
    return scale(graph.one / 2, total)
