"""Second derivatives of inverse dynamics of a tree: one recursion, closed expressions for pairs of velocities.

Reference: Singh, Russell and Wensing, Efficient second-order analytical derivatives of rigid-body dynamics, ICRA 2023;
here for joints that move along their own frame, by what a pair of velocities has in common, so that every entry is one
or two products of a force and a motion.

    d, m, s  velocities from the tips inwards: the joint of s carries that of m or is the same, likewise m and d
    S        motion subspace: a twist, rate of the joint's frame
    S', S"   by the motion v, a of the joint's carrier:  S' = v × S,  S" = a × S + v × S'      (a holds -g)
    S*       S' and the rate of S by the motion of the joint's own frame
    I, f     inertia of all that d carries, and the force that moves it
    B        their Coriolis forces: B x = Σ m 2 ω_x × v(r)
    R_x      rate of I where all that d carries moves along x:  R_x = x ×* I - I x ×;   R = R_S of d's S
    Q        R_S' + (S ×* B - B S ×) of d's S' and S

A derivative along X_s turns and shifts all that s carries, and leaves of that

    X_s v = S'_s    X_s a = S"_s + S'_s × v    ∂v/∂u_s = S_s    ∂a/∂u_s = S*_s + S_s × v

while S and I of what s carries stay as they are. With

    W = S_m ×* I S_d         V = R S_m            N = W - V
    Y = S'_m ×* I S_d - R S'_m + S_m ×* Bᵀ S_d    Z = Qᵀ S_m - S_m ×* I S'_d

    i = d:   X_m ∂τ_i/∂u̇_s = W·S_s               ∂²τ_i/∂u_m ∂u_s = N·S_s      X_s ∂τ_i/∂u_m = N·S'_s
             X_m ∂τ_i/∂u_s = Y·S_s + W·S*_s       X_s X_m τ_i = Y·S'_s + W·S"_s
    i = m:   X_d ∂τ_i/∂u̇_s = V·S_s               ∂²τ_i/∂u_d ∂u_s = -N·S_s     X_s ∂τ_i/∂u_d = -N·S'_s
             X_d ∂τ_i/∂u_s = Z·S_s + V·S*_s       X_s X_d τ_i = Z·S'_s + V·S"_s
    i = s:   ∂²τ_i/∂u_d ∂u_m = (V + W)·S_s        X_m ∂τ_i/∂u_d = (S_m ×* h + R S'_m + S'_m ×* I S_d)·S_s
             X_d ∂τ_i/∂u_m = (S_m ×* I S'_d + Q S_m + R S*_m)·S_s
             X_m X_d τ_i = (S_m ×* g + S'_m ×* I S'_d + Q S'_m + R S"_m)·S_s

    h = B S_d + I S*_d       g = B S'_d + I S"_d + S_d ×* f

All other entries vanish, or follow by exchange of derivatives, or of i and that of u̇: M is symmetric. Where velocities
of one joint are no rates of coordinates, as of a ball, X_m and X_s do not commute, and both orders are there. By two
velocities u of one joint, what is not symmetric in them has half of both orders.

Vectors are in the frame of the joint at the ground that carries all others, so that neither its position nor what other
trees do enters. Twists are (angular, linear), forces (moment, force).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import reduce
from typing import NamedTuple

from symdyn.dynamics.recursive.links import GeneralTurn, Moments, SpatialForce, Twist, plus
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.dynamics.recursive.rnea_derivatives import Composite, bracket
from symdyn.frozen import dataclass
from symdyn.graph import Expr
from symdyn.spatial import Mat, Transform, Vec, add, cross, neg, scale, sub, zero_vector


class Ways(NamedTuple):
    """S, S*, S' and S" of one velocity."""

    S: Twist
    twice: Twist
    first: Twist
    second: Twist


@dataclass(frozen=True)
class Reach:
    """What pairs need of the deeper velocity d, beside its `ways`: see the module's legend.

    Attributes:
        momentum, first: I S, I S'.
        couple: moment of Bᵀ S, whose force is zero.
        by_rate, by_position: h, g.
        R_h, R_J: R, which has no mass.
        Q_h, Q_l, Q_P: of Q, first moment and second ones: Q x = (tr(P) ω - Pᵀ ω + h × v, ω × (h + l)).
    """

    momentum: SpatialForce
    first: SpatialForce
    couple: Vec
    by_rate: SpatialForce
    by_position: SpatialForce
    R_h: Vec
    R_J: Mat
    Q_h: Vec
    Q_l: Vec
    Q_P: Mat


class Pair(NamedTuple):
    """W, V, N, Y, Z of a pair of velocities, and what its forces on s are made with, by kinds of derivatives."""

    W: SpatialForce
    V: SpatialForce
    N: SpatialForce
    Y: SpatialForce
    Z: SpatialForce
    uu: SpatialForce
    uq: SpatialForce
    qu: SpatialForce
    qq: SpatialForce


def force_bracket(x: Twist, f: SpatialForce) -> SpatialForce:
    """Return x ×* f: the rate of a force that moves with x."""
    return add(cross(x[0], f[0]), cross(x[1], f[1])), cross(x[0], f[1])


def minus(a: Twist, b: Twist) -> Twist:
    """Return the difference of two twists, or of two forces."""
    return sub(a[0], b[0]), sub(a[1], b[1])


def pair(d: Reach, m: Ways) -> Pair:
    """Return what the entries of a pair of velocities are made of."""

    def rate(x: Twist) -> SpatialForce:
        return _moved(d.R_J, d.R_h, d.R_h, x)

    own = force_bracket(m.S, d.first)
    bent = plus(force_bracket(m.first, d.momentum), rate(m.first))
    W, V = force_bracket(m.S, d.momentum), rate(m.S)
    turned = force_bracket(m.S, (d.couple, zero_vector(d.couple[0].graph)))
    across = add(d.Q_h, d.Q_l)
    return Pair(
        W,
        V,
        minus(W, V),
        plus(minus(force_bracket(m.first, d.momentum), rate(m.first)), turned),
        minus(_moved(d.Q_P, across, d.Q_h, m.S), own),
        plus(W, V),
        plus(force_bracket(m.S, d.by_rate), bent),
        plus(plus(own, _moved(d.Q_P.T, d.Q_h, across, m.S)), rate(m.twice)),
        plus(
            plus(force_bracket(m.S, d.by_position), force_bracket(m.first, d.first)),
            plus(_moved(d.Q_P.T, d.Q_h, across, m.first), rate(m.second)),
        ),
    )


def _moved(P: Mat, by_speed: Vec, by_turn: Vec, x: Twist) -> SpatialForce:
    """Return (tr(P) ω - P ω + h × v, ω × h) of two first moments h."""
    (a, b, c), (p, q, r), (u, v, w) = P
    (x0, x1, x2), speed = x
    turning = (
        (q + w) * x0 - b * x1 - c * x2,
        (a + w) * x1 - p * x0 - r * x2,
        (a + q) * x2 - u * x0 - v * x1,
    )
    return add(turning, cross(by_speed, speed)), cross(x[0], by_turn)


# From the tree


@dataclass(frozen=True)
class Velocities:
    """The velocities of a tree, which elementary joints have one each.

    Attributes:
        chain: of each velocity all that it depends on, from the ground, its own joint's included.
        shared: of each velocity how many of these belong to its own joint.
    """

    chain: tuple[tuple[int, ...], ...]
    shared: tuple[int, ...]

    @classmethod
    def of(cls, parent: Sequence[int], block: Sequence[Sequence[int]]) -> Velocities:
        """Return those of a tree by its parents and blocks, ground first."""
        chain: dict[int, tuple[int, ...]] = {}
        shared: dict[int, int] = {}
        for joints in filter(None, block):
            before = chain.get(parent[joints[0]], ())
            for i in joints:
                chain[i], shared[i] = (*before, *joints), len(joints)
        order = range(1, len(parent))
        return cls(tuple(tuple(k - 1 for k in chain[i]) for i in order), tuple(shared[i] for i in order))

    @property
    def own(self) -> list[tuple[int, ...]]:
        """The velocities of each one's own joint."""
        return [chain[len(chain) - shared :] for chain, shared in zip(self.chain, self.shared, strict=True)]

    def pairs(self) -> Iterator[tuple[int, int, bool]]:
        """Yield d, m, and whether both belong to one joint, in the order of the packed derivatives."""
        for d, chain in enumerate(self.chain):
            for k, m in enumerate(chain):
                yield d, m, k >= len(chain) - self.shared[d]


@dataclass(frozen=True)
class Run:
    """Entries of one pair along s, one kind of derivative.

    Attributes:
        place: of d, m, s and the number of velocities: force, column of the first derivative and of the second one, of
            which there are as many as velocities along q, then u, then u̇.
        terms: members of a `Pair` and of `Ways`, whose product is taken.
        sign: of it.
        whole: whether velocities of the joint of m are among s.
        apart: whether it is there only where d and m belong to different joints.
    """

    place: Callable[[int, int, int, int], tuple[int, int, int]]
    terms: tuple[tuple[str, str], ...]
    sign: int = 1
    whole: bool = True
    apart: bool = False

    def entry(self, here: Pair, s: Ways) -> Expr:
        """Return the entry along one velocity."""
        found = [_product(getattr(here, f), getattr(s, x)) for f, x in self.terms]
        total = found[0].graph.total(found)
        return total if self.sign > 0 else -total


RUNS = (
    Run(lambda d, m, s, n: (d, m, 2 * n + s), (("W", "S"),), whole=False),
    Run(lambda d, m, s, n: (d, n + m, n + s), (("N", "S"),)),
    Run(lambda d, m, s, n: (d, s, n + m), (("N", "first"),)),
    Run(lambda d, m, s, n: (d, m, n + s), (("Y", "S"), ("W", "twice")), whole=False),
    Run(lambda d, m, s, n: (d, m, s), (("Y", "first"), ("W", "second"))),
    Run(lambda d, m, s, n: (m, d, 2 * n + s), (("V", "S"),), apart=True),
    Run(lambda d, m, s, n: (m, n + d, n + s), (("N", "S"),), sign=-1, apart=True),
    Run(lambda d, m, s, n: (m, s, n + d), (("N", "first"),), sign=-1, apart=True),
    Run(lambda d, m, s, n: (m, d, n + s), (("Z", "S"), ("V", "twice")), apart=True),
    Run(lambda d, m, s, n: (m, d, s), (("Z", "first"), ("V", "second")), apart=True),
    Run(lambda d, m, s, n: (s, n + d, n + m), (("uu", "S"),), whole=False),
    Run(lambda d, m, s, n: (s, m, n + d), (("uq", "S"),), whole=False),
    Run(lambda d, m, s, n: (s, d, n + m), (("qu", "S"),), whole=False, apart=True),
    Run(lambda d, m, s, n: (s, d, m), (("qq", "S"),), whole=False),
)
"""Runs of a pair, in the order of the packed derivatives."""

HALVED = 1
"""The run whose entries within one joint have half of both orders."""


def places(velocities: Velocities) -> list[tuple[int, int, int]]:
    """Return force and columns of every packed entry, in order: row k, column j of H of force i is X_j X_k τ_i."""
    n, found = len(velocities.chain), list[tuple[int, int, int]]()
    for d, m, same in velocities.pairs():
        for run in RUNS:
            if not (same and run.apart):
                chain = velocities.chain[m]
                found += [
                    run.place(d, m, s, n) for s in (chain if run.whole else chain[: len(chain) - velocities.shared[m]])
                ]
    return found


def of_one_joint(here: Pair, d: Ways, m: Reach) -> SpatialForce:
    """Return what a pair of velocities of one joint has in place of V + W."""
    return plus(here.W, force_bracket(d.S, m.momentum))


def halved(here: Pair, s: Ways) -> Expr:
    """Return an entry of the run that has half of both orders."""
    return -_product(here.V, s.S)


def _product(f: SpatialForce, x: Twist) -> Expr:
    pairs = [(a, b) for f3, x3 in zip(f, x, strict=True) for a, b in zip(f3, x3, strict=True)]
    return pairs[0][0].graph.total(a * b for a, b in pairs)


def numbers(tree: ReducedTree, qd: Sequence[Expr], qdd: Sequence[Expr]) -> tuple[list[Ways], list[Reach]]:
    """Return what pairs are made of, of every velocity; arguments are as of `pair_runs.PairRuns.of`."""
    zeros = zero_vector(tree.graph)
    still = (zeros, zeros)
    at = _placements(tree)
    velocity, acceleration = [still] * len(tree.parent), [still] * len(tree.parent)
    ways = [Ways(still, still, still, still)] * tree.n
    for block in filter(None, tree.block):
        p, last = tree.parent[block[0]], block[-1]
        v = velocity[p]
        a = acceleration[p]
        if not p:  # in the frame that all is in
            a = (zeros, reduce(lambda x, i: tree.X[i].out(x), block, neg(tree.gravity)))
        subspace = {i: _axis(at[i], tree.slides[i]) for i in block}
        sliding = _sum(subspace, qd)
        velocity[last] = plus(v, sliding)
        acceleration[last] = plus(plus(a, _sum(subspace, qdd)), bracket(v, sliding))
        for i, S in subspace.items():
            first = bracket(v, S)
            twice = plus(first, bracket(velocity[last], S))
            ways[i - 1] = Ways(S, twice, first, plus(bracket(a, S), bracket(v, first)))
    return ways, _reaches(tree, velocity, acceleration, at, ways)


def _placements(tree: ReducedTree) -> list[Transform]:
    """Return every frame in that of the joint at the ground which carries it, the ground's own first."""
    at = [Transform.unit(tree.graph)] * len(tree.parent)
    for block in filter(None, tree.block):
        if tree.parent[block[0]]:
            for i in block:
                at[i] = at[tree.parent[i]] @ tree.X[i].transform
        else:
            for i in reversed(block[1:]):
                at[tree.parent[i]] = at[i] @ tree.X[i].transform.inverse()
    return at


def _axis(at: Transform, slides: bool) -> Twist:
    """Return the twist of a joint along z of its frame."""
    z = (at.R[0][2], at.R[1][2], at.R[2][2])
    return (zero_vector(z[0].graph), z) if slides else (z, cross(at.p, z))


def _sum(subspace: Mapping[int, Twist], amounts: Sequence[Expr]) -> Twist:
    """Return the twist of joints whose velocities have these amounts."""
    zeros = zero_vector(amounts[0].graph)
    found: Twist = (zeros, zeros)
    for i, (w, v) in subspace.items():
        found = plus(found, (scale(amounts[i - 1], w), scale(amounts[i - 1], v)))
    return found


def _reaches(tree: ReducedTree, velocity: Sequence[Twist], acceleration: Sequence[Twist], at: Sequence[Transform],
             ways: Sequence[Ways]) -> list[Reach]:  # fmt: skip
    """Return what every velocity needs of all that it carries."""
    zeros = zero_vector(tree.graph)
    none = Composite(Moments(tree.graph.zero, zeros, Mat((zeros,) * 3)), Mat((zeros,) * 3), zeros)
    carried, force = [none] * len(tree.parent), [(zeros, zeros)] * len(tree.parent)
    found: dict[int, Reach] = {}
    for i in tree.inward():
        if block := tree.block[i]:
            turn, body, v = GeneralTurn(at[i].R), tree.body[i], velocity[i]
            moments = Moments(body.m, turn.back(body.h), turn.tensor_back(body.J)).shifted(at[i].p)
            twice = (scale(2, v[0]), scale(2, v[1]))
            own = Composite(moments, _second(moments, twice), _first(moments, twice))
            moving = plus(own.inertia(acceleration[i]), force_bracket(v, own.inertia(v)))
            carried[i], force[i] = carried[i] + own, plus(force[i], moving)
            for k in block:
                found[k] = _reach(carried[i], force[i], ways[k - 1])
            p = tree.parent[block[0]]
            carried[p], force[p] = carried[p] + carried[i], plus(force[p], force[i])
    return [found[i] for i in tree.outward()]


def _first(body: Moments, x: Twist) -> Vec:
    """Return Σ m x(r) of a body whose points move along a twist."""
    return add(scale(body.m, x[1]), cross(x[0], body.h))


def _second(body: Moments, x: Twist) -> Mat:
    """Return Σ m r x(r)ᵀ."""
    return Mat(add(scale(h, x[1]), cross(x[0], row)) for h, row in zip(body.h, body.J, strict=True))


def _reach(carried: Composite, force: SpatialForce, way: Ways) -> Reach:
    """Return what a velocity needs of what it carries: composite body, the force that moves it."""
    body, P, (w, v) = carried.body, carried.P, way.S
    along = _second(body, way.S)
    first = _second(body, way.first)
    turned = Mat(cross(w, column) for column in P.T).T + Mat(cross(w, row) for row in P)
    sheared = Mat(scale(x, carried.momentum) for x in v)
    return Reach(
        carried.inertia(way.S),
        carried.inertia(way.first),
        carried.couple(way.S),
        plus(carried.coriolis(w), carried.inertia(way.twice)),
        plus(plus(carried.coriolis(way.first[0]), carried.inertia(way.second)), force_bracket(way.S, force)),
        _first(body, way.S),
        along + along.T,
        _first(body, way.first),
        cross(w, carried.momentum),
        (first + first.T) + (turned + sheared),
    )
