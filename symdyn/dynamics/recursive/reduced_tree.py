"""The reduced tree: the mechanism of a scene in link frames that the generator chooses, its inertias regrouped.

The same mechanism, cheaper placements: every frame is moved along and turned about its joint's axis, which leaves the
joint as it is, so that

    T_pi = Rz(γ) Tz(ε) Rx(α) Tx(d) Rz(θ) Tz(r)       θ = θ0 + q (revolute) or r = r0 + q (prismatic)

and for one child of every body γ = ε = 0: on a chain for all. Between parallel axes r and ε are one; it moves on to the
ground where all axes below are parallel, else it stays as far out as it is, where fewer forces have to be known. The
frame of a tip is turned and shifted until θ0 = r0 = 0.

    B[i]      placement of joint frame i in frame p, joint at zero, both with z along their axes
    n         common normal of both axes, in frame p: (cos γ, sin γ, 0)

Axes that reduced by little only (sin α below `LITTLE`) have a common normal far away, whose r and ε would cancel each
other at the cost of digits: there r = ε = 0, and the shift has three components.

Exact or not at all: γ and α are kept as cosines and sines, which are entries of B or roots of fractions. Where an axis
leans by parameters about two axes, or the normal needs a root of something irrational, that placement keeps its
declared rotation and shift; so does a shift by a formula that does not divide.

Reference: Khalil and Kleinfinger, A new geometric notation for open and closed-loop robots (ICRA 1986).

Inertia that exerts no force on a joint goes to the body that carries it: fewer parameters, the same motion.

    revolute    what lies on the axis: m, h_z and J_zz
    prismatic   everything that turns only: J

The rest is what the equations of motion depend on, the base parameters: for a revolute joint h_x, h_y and five of J,
for a prismatic one m and h. What falls into the ground does no work, but it has a place: its constant part of P
stays in the ground's own moments, so that energies keep their values.

Reference: Gautier and Khalil, Direct calculation of minimum set of inertial parameters of serial robots, IEEE
Transactions on Robotics and Automation 6 (1990); here by second moments J in place of the inertia I = tr(J) 1 - J.

Gain of regrouping (operations; ns one state a call, a state of a batch):

                          puma560                 arm7                   chain8
    inverse dynamics       -12 %; -5 %, -11 %      -12 %; -7 %, -5 %      -13 %; -9 %, -8 %
    forward dynamics      -7.1 %; -2 %,  -5 %     -6.7 %; -4 %, -5 %     -7.3 %; -6 %, -7 %

Frames whose axis passes through a point that no joint moves have their origins there. A factored transform puts the
origin of a frame where the next axis comes nearest, at the joint offset r. If the axis meets all axes below in one
point, as in a shoulder of two or three joints, the origin stays there and the next transform shifts along z as well:

    Rz(θ) Tz(r) | Tx(d) Rx(α)        Rz(θ) | Tz(r) Tx(d) Rx(α)

Gravity alone accelerates such an origin, and the force there is not needed.

Gain (operations; ns one state a call, a state of a batch), where first axes meet in a point:

                          arm7                    chain8             puma560
    inverse dynamics      -1.5 %; -2 %, -1 %      -1.2 %; -1 %,  0     0
    forward dynamics      -1.0 %; -3 %, -1 %      -0.7 %; +1 %, +1 %   0

The last body of a branch may have unrotated axes, which are fixed in its parent. The recursions turn ω, U z and the
acceleration into a body's axes and its wrench out of them again, for 20 multiplications, and five products of ω are new
there. In unrotated axes, h and J of the last body turn in their place, for 12, and three products are new. Where a turn
would fill more than one pair of zeros among both, as with diagonal inertias and a mass centre on an axis, it costs
more: such a body is left as it is.

Gain (operations; ns one state a call, a state of a batch):

                          puma560                  arm7                 chain8
    inverse dynamics      -5.9 %; -18 %, -14 %     -2.5 %; -3 %, -1 %   -1.9 %;  0,   -1 %
    forward dynamics      -3.9 %; -22 %, -10 %     -3.7 %; -3 %, -1 %   -2.5 %; -5 %,  0
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from symdyn.dynamics.mechanism.tree import Topology, Tree, has_symbols, rational, settle, values_of
from symdyn.dynamics.recursive.links import GeneralTurn, JointTransform, Moments, PlanarTurn, Turn, moments_of
from symdyn.frozen import dataclass, fields, replace
from symdyn.graph import Expr, Graph, Op
from symdyn.spatial import Mat, Transform, Vec, Wrench, add, dot, zero_vector

Angle = tuple[Expr, Expr]  # cosine and sine

LITTLE = Fraction(1, 8)


@dataclass(frozen=True)
class ReducedTree(Topology):
    """A tree whose frames have z along their joints' axes.

    Attributes:
        X: X[i] is the transform from frame i to frame p, the joint's motion included; entry 0 is the identity.
        slides: whether joint i is prismatic.
        body: moments of body i about the origin of frame i, everything welded to it included.
        moved: moved[i] is the placement of frame i in the frame that the scene declares.
    """

    X: tuple[JointTransform, ...]
    slides: tuple[bool, ...]
    body: tuple[Moments, ...]
    moved: tuple[Transform, ...]

    @property
    def without_gravity(self) -> ReducedTree:
        return replace(self, gravity=zero_vector(self.graph))

    def along_axis(self, i: int, wrench: tuple[Vec, Vec]) -> Expr:
        """Return Sᵀ f, the force along joint i of a wrench (moment, force) in frame i."""
        n, f = wrench
        return f[2] if self.slides[i] else n[2]


@dataclass(frozen=True)
class _Placement:
    """A placement B as Rz(γ) T(shift) · fixed · Rz(θ) Tz(r), where γ and ε = shift_z are left to the parent's frame."""

    gamma: Angle
    shift: Vec
    fixed: tuple[Turn, ...]
    theta: Angle
    offset: Expr


def reframe(tree: Tree) -> ReducedTree:
    """Return the tree with frames of the generator's choice."""
    graph = tree.graph
    identity = Transform.unit(graph)
    upright = [identity] + [Transform(_towards(tree, i), zero_vector(graph)) for i in tree.outward()]
    moved = list(upright)
    B = [identity] + [settled(upright[tree.parent[i]].inverse() @ tree.base[i] @ upright[i]) for i in tree.outward()]
    free = [True]  # whether a frame may slide down to the ground: all axes below are parallel to its own
    for i in tree.outward():
        free.append(tree.parent[i] == 0 or (free[tree.parent[i]] and B[i].R[0][2].is_zero and B[i].R[1][2].is_zero))
    placed: list[_Placement | None] = [None] * len(tree.parent)
    slid = [False] * len(tree.parent)  # whether a frame has been moved for a child
    for i in tree.inward():
        p = tree.parent[i]
        own = upright[i].inverse() @ moved[i]
        place = _placement(B[i] @ own, free[i], graph)
        if not slid[i]:
            unturned = Transform(_about_z((place.theta[0], -place.theta[1])), (graph.zero, graph.zero, -place.offset))
            moved[i] = upright[i] @ unturned
            place = _Placement(place.gamma, place.shift, place.fixed, _zero(graph), graph.zero)
        if p and not slid[p]:
            slid[p] = True
            along = (graph.zero, graph.zero, place.shift[2])
            moved[p] = upright[p] @ Transform(_about_z(place.gamma), along)
        placed[i] = place
    transforms = [JointTransform(zero_vector(graph), (), _turn(_zero(graph)), graph.zero)]
    for i in tree.outward():
        found = placed[i]
        assert found is not None, "every joint has been placed"
        transforms.append(_across(tree, i, found, upright, moved))
    return ReducedTree(
        **{one.name: getattr(tree, one.name) for one in fields(Topology)},
        X=tuple(transforms),
        slides=(False, *(_slides(tree, i) for i in tree.outward())),
        body=tuple(
            moments_of(inertia.seen_from(settled(T.inverse()))) for inertia, T in zip(tree.inertia, moved, strict=True)
        ),
        moved=tuple(moved),
    )


def settled(T: Transform) -> Transform:
    """Return a placement with its hidden zeros and fractions in the open."""
    x = settle([*T.R[0], *T.R[1], *T.R[2], *T.p])
    return Transform(Mat(((x[0], x[1], x[2]), (x[3], x[4], x[5]), (x[6], x[7], x[8]))), (x[9], x[10], x[11]))


def _slides(tree: Tree, i: int) -> bool:
    return all(entry.is_zero for entry in tree.S[i][0])


def _across(tree: Tree, i: int, place: _Placement, upright: list[Transform], moved: list[Transform]) -> JointTransform:
    """Return the transform to the parent's final frame, with the joint's motion in it."""
    graph, p, q = tree.graph, tree.parent[i], tree.position[i]
    slid = upright[p].inverse() @ moved[p]
    c, s = settle([slid.R[0][0], slid.R[1][0]])
    gamma = _sum(place.gamma, (c, -s))
    rest = _turn(gamma)
    shift = rest.back((place.shift[0], place.shift[1], graph.zero))
    shift = (*settle(shift[:2]), place.shift[2] - slid.p[2])  # type: ignore[assignment]
    turns = place.fixed if gamma[0] is graph.one else (rest, *place.fixed)
    if _slides(tree, i):
        return JointTransform(shift, turns, _turn(place.theta), place.offset + q)
    (c0, s0), c, s = place.theta, graph.cos(q), graph.sin(q)
    return JointTransform(shift, turns, PlanarTurn(2, c * c0 - s * s0, s * c0 + c * s0), place.offset)


# Turns


def _zero(graph: Graph) -> Angle:
    return (graph.one, graph.zero)


def _sum(a: Angle, b: Angle) -> Angle:
    c, s = settle([a[0] * b[0] - a[1] * b[1], a[1] * b[0] + a[0] * b[1]])
    return c, s


def _turn(angle: Angle) -> PlanarTurn:
    return PlanarTurn(2, *angle)


def _about_z(angle: Angle) -> Mat:
    (c, s), graph = angle, angle[0].graph
    zero = graph.zero
    return Mat(((c, -s, zero), (s, c, zero), (zero, zero, graph.one)))


def _towards(tree: Tree, i: int) -> Mat:
    """Return the shortest rotation that takes z to the axis of joint i."""
    z, s = tree.S[i]
    x, y, c = settle(s if _slides(tree, i) else z)
    return Mat.towards((x, y, c))


# A placement in parts


def _placement(B: Transform, free: bool, graph: Graph) -> _Placement:
    """Return B in parts; see the module's legend. Along a parallel axis not `free` the offset is the joint's own."""
    B = settled(B)
    normal = _normal(B, graph)
    if normal is None:  # the declared rotation and shift
        return _Placement(_zero(graph), B.p, (GeneralTurn(B.R),), _zero(graph), graph.zero)
    gamma, sine = normal
    back = _turn(gamma)
    c, d = B.R[2][2], settle(back.out(B.p))
    theta = settle(back.out((B.R[0][0], B.R[1][0], graph.zero))[:1] + back.out((B.R[0][1], B.R[1][1], graph.zero))[:1])
    fixed = () if c is graph.one else (PlanarTurn(0, c, sine),)
    shift, offset = (d[0], d[1], d[2]), graph.zero
    if sine.is_zero:
        if not free:
            shift, offset = (d[0], d[1], graph.zero), d[2] * c
    else:
        quotient = _quotient(d[1], -sine)
        if quotient is not None:
            offset = quotient
            shift = (d[0], graph.zero, *settle([d[2] - offset * c]))  # type: ignore[assignment]
    return _Placement(gamma, shift, fixed, (theta[0], -theta[1]), offset)


def _normal(B: Transform, graph: Graph) -> tuple[Angle, Expr] | None:
    """Return (cos γ, sin γ) of the common normal and sin α; None if they cannot be had exactly.

    With α = 0 or π the normal points along the shift, so that the shift lies along x.
    """
    x, y = B.R[0][2], B.R[1][2]
    along_x, along_y = _zero(graph), (graph.zero, graph.one)
    if x.is_zero and y.is_zero:
        if B.p[1].is_zero:
            return along_x, graph.zero
        if B.p[0].is_zero:
            return along_y, graph.zero
        return _direction(B.p[0], B.p[1], graph) or along_x, graph.zero
    if x.is_zero:
        return along_x, -y
    if y.is_zero:
        return along_y, x
    gamma = _direction(-y, x, graph)
    if gamma is None:
        return None
    (sine,) = settle([gamma[1] * x - gamma[0] * y])
    return gamma, sine


def _direction(x: Expr, y: Expr, graph: Graph) -> Angle | None:
    """Return the unit vector along (x, y), if its length is the root of a fraction."""
    (square,) = settle([x * x + y * y])
    if rational(square) is None:
        return None
    length = graph.sqrt(square)
    c, s = settle([x / length, y / length])
    return c, s


def _quotient(a: Expr, b: Expr) -> Expr | None:
    """Return a / b where it is sound for all values of the parameters: b is a number or a factor of a."""
    if a.is_zero:
        return a
    if not has_symbols(b):
        return settle([a / b])[0] if abs(values_of([b])[0]) >= LITTLE else None
    sign_a, a = (-1, a.args[0]) if a.op is Op.NEG else (1, a)
    sign_b, b = (-1, b.args[0]) if b.op is Op.NEG else (1, b)
    if a.op is Op.MUL and b in a.args:
        return sign_a * sign_b * (a.args[1] if a.args[0] is b else a.args[0])
    return None


def potential_energy(tree: ReducedTree) -> Expr:
    """Return P = -g·Σ m r, J; what is welded to the ground counts, and so does what regrouping has moved there."""
    body = list(tree.body)
    for i in tree.inward():
        p = tree.parent[i]
        body[p] = body[p] + tree.X[i].moments_back(body[i])
    return -dot(tree.gravity, body[0].h)


def regroup(tree: ReducedTree, blocks: bool = True) -> ReducedTree:
    """Return the tree with base parameters in place of the bodies' inertias; without `blocks`, theirs stay."""
    body = list(tree.body)
    whole = {k for block in tree.block if len(block) > 1 for k in block} if not blocks else set[int]()
    for i in tree.inward():
        if i in whole:
            continue
        p = tree.parent[i]
        kept, given = split(body[i], tree.slides[i])
        body[i], body[p] = kept, body[p] + tree.X[i].fixed_part(tree.slides[i]).moments_back(given)
    return replace(tree, body=tuple(body))


def slides_along_all_turns(tree: ReducedTree, k: int) -> bool:
    """Return whether every joint that turns body k has its axis along z of k, which slides."""
    axis, p = tree.X[k].axis, tree.parent[k]
    while p:
        x, y, z = settle(axis)
        if not tree.slides[p] and not (x.is_zero and y.is_zero):
            return False
        axis, p = tree.X[p].back((x, y, z)), tree.parent[p]
    return True


def split(body: Moments, slides: bool) -> tuple[Moments, Moments]:
    """Return what of a body exerts forces on a joint along z, and what does not."""
    zero = body.m.graph.zero
    none = zero_vector(body.m.graph)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.J
    if slides:
        return Moments(body.m, body.h, Mat((none, none, none))), Moments(zero, none, body.J)
    kept = Moments(zero, (body.h[0], body.h[1], zero), Mat.symmetric(xx, yy, zero, xy, xz, yz))
    return kept, Moments(body.m, (zero, zero, body.h[2]), Mat((none, none, (zero, zero, zz))))


def resting(tree: ReducedTree) -> ReducedTree:
    """Return the tree with origins at rest wherever an axis has such a point."""
    X, body, moved, zero = list(tree.X), list(tree.body), list(tree.moved), tree.graph.zero
    rests = [True]
    for i in tree.outward():
        p, (x, y, z) = tree.parent[i], X[i].shift
        on_axis = not tree.parent[p]  # the ground, and the axis of its joint, on which all points rest
        rests.append(
            not tree.slides[i] and (not p or (rests[p] and x.is_zero and y.is_zero and (on_axis or z.is_zero)))
        )
        offset = (zero, zero, X[i].offset)
        if not p or not rests[i] or offset[2].is_zero:
            continue
        X[i], body[i] = replace(X[i], offset=zero), body[i].shifted(offset)
        moved[i] = moved[i] @ Transform(Mat.identity(tree.graph), (zero, zero, -offset[2]))
        for k in tree.outward():
            if tree.parent[k] == i:
                X[k] = replace(X[k], shift=add(X[k].shift, offset))
    return replace(tree, X=tuple(X), body=tuple(body), moved=tuple(moved))


def unrotated_tips(tree: ReducedTree) -> ReducedTree:
    """Return the tree with last bodies in unrotated axes, fixed in their parents, where that pays."""
    body, X = list(tree.body), list(tree.X)
    for i in _tips(tree):
        body[i], X[i] = X[i].turn.moments_back(body[i]), X[i].fixed_part(False)
    return replace(tree, body=tuple(body), X=tuple(X))


def in_unrotated_axes(tree: ReducedTree, acting: Sequence[Wrench]) -> list[Wrench]:
    """Return what acts on the bodies of a tree in the axes of `unrotated_tips`."""
    found = list(acting)
    for i in _tips(tree):
        (force, moment), turn = found[i], tree.X[i].turn
        found[i] = Wrench(turn.back(force), turn.back(moment))
    return found


def _tips(tree: ReducedTree) -> list[int]:
    """Return the last bodies that pay."""
    tips = sorted(set(tree.outward()).difference(tree.parent))
    return [i for i in tips if not tree.slides[i] and _turns_lightly(tree.body[i])]


def _turns_lightly(body: Moments) -> bool:
    """Tell whether a turn about z fills at most one pair of zeros among h and J."""
    (x, y, _), ((xx, xy, xz), (_, yy, yz), _) = body.h, body.J
    filled = (x.is_zero != y.is_zero, xz.is_zero != yz.is_zero, xy.is_zero and xx is not yy)
    return sum(filled) < 2
