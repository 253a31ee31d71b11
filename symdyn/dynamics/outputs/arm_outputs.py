"""Inverse kinematics of arms of six axes, every branch in closed form: a row of OUTPUTS.

    h[i], c[i]   direction of axis i, the ground's first, and a point on it, where all angles are zero
    R0, p0       the frame there; [R p] the pose that is asked for, G = R R0ᵀ, x' = p + G (x - p0) for a point x
    E[i], E(n)   turn about axis i by q[i], about n; R = E[1] ... E[6] R0, an angle as its sine s and cosine c
    n            direction of axes that are parallel, h[2]

*Spherical wrist*, of axes 4, 5, 6 that meet in a point B, with 2 and 3 parallel; and *three parallel axes* 2, 3, 4 with
5 and 6 that meet in B. What meets there does so at right angles. Two solutions each time:

    n·E[1]ᵀ (B' - c[1]) = n·(B - c[1])       a turn that brings a point into a plane: q1
    E[2] (b + E[3] a) = w                    two links in that plane, |b + E[3] a| = |w| tells q3, then directions q2
    E(h) E[5] E[6] = M                       h ⟂ h[5] ⟂ h[6]; M h[6] tells h's angle and q5, M h[5] then q6

M is (E[1] E[2] E[3])ᵀ G with h = h[4]; of parallel axes E[1]ᵀ G with h = n, whose angle is q2 + q3 + q4, told first.

Radicands are below zero out of reach. One within `SPENT` of the square that it is left of is zero, there two branches
meet. A direction without length has another's angle, or zero. What is proved is the last entry of such selects.

References: Murray, Li and Sastry, Robotic Manipulation (1994), section 3.2; Elias and Wen, IK-Geo (2025).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from symdyn.dynamics.mechanism.kinematics import joints_below, pose, tree_placed
from symdyn.dynamics.mechanism.linear_solve import vanishes
from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.contact_outputs import where
from symdyn.dynamics.outputs.frame_outputs import MOVING
from symdyn.dynamics.outputs.named_functions import POSE, direction
from symdyn.dynamics.outputs.output import Formulation, Output
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError, listed
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Op, reachable, substitute
from symdyn.scene.values import velocity_name
from symdyn.spatial import Mat, Vec, add, cross, dot, scale, sub

SPENT, SHORT, STRAIGHT = Fraction(3, 10**15), Fraction(1, 10**30), Fraction(1, 10**14)
"""Share of a square below which what is left of it is rounding; lengths below which nothing points anywhere, in a wrist
the sine of its bend."""

BRANCHES = 8


class Turn(NamedTuple):
    """An angle by its sine and cosine."""

    s: Expr
    c: Expr

    @property
    def angle(self) -> Expr:
        """The angle, rad."""
        return self.s.graph.function(Op.ATAN2, self.s, self.c)

    @property
    def back(self) -> Turn:
        return Turn(-self.s, self.c)

    def then(self, other: Turn) -> Turn:
        """Return both turns about one axis."""
        return Turn(self.s * other.c + self.c * other.s, self.c * other.c - self.s * other.s)

    def about(self, h: Vec, x: Vec) -> Vec:
        """Return a vector turned about a direction of length one."""
        along = scale(dot(h, x), h)
        return add(along, add(scale(self.c, sub(x, along)), scale(self.s, cross(h, x))))


@dataclass(frozen=True)
class ArmAngles:
    """Angles of an arm, on the graph of its scene.

    Attributes:
        h, c, R, p: the module's legend.
        lengths: roots of squares, and what they are.
        rows: angles of each branch.
    """

    h: Sequence[Vec]
    c: list[Vec]
    R: Mat
    p: Vec
    lengths: dict[Expr, Expr] = field(default_factory=dict)
    rows: list[list[Expr]] = field(default_factory=list)

    def both(self, x: Expr, k: int) -> Sequence[Expr]:
        """Return a number with either sign, by which branches of angle k differ; a page has a letter for it."""
        return x, -x

    def named(self, turn: Turn, k: int, over: Expr | None = None) -> Turn:
        """Return a turn about axis k, 6 for what is left of a sum, over a length; a page goes on with its angle."""
        return Turn(turn.s / over, turn.c / over) if over is not None else turn

    def noted(self, name: str, x: Expr) -> Expr:
        """Return a number; a page goes on with its name."""
        return x

    def lettered(self, letter: str, v: Vec) -> Vec:
        """Return a vector whose components are noted."""
        return self.noted(f"{letter}_x", v[0]), self.noted(f"{letter}_y", v[1]), self.noted(f"{letter}_z", v[2])

    def turns(self, x: Expr, y: Expr, far: Expr, k: int) -> Iterator[Turn]:
        """Yield turns about axis k with x cos + y sin = far, none where x and y are always zero."""
        graph, whole, far = x.graph, x * x + y * y, self.noted(f"d{k + 1}", far)
        left = whole - far * far
        spent = SPENT * whole - graph.function(Op.ABS, left)
        root = graph.sqrt(where(spent, graph.zero, left))
        for s in self.both(root, k) if not vanishes(whole) else ():
            yield self.named(Turn(y * far + x * s, x * far - y * s), k, whole)

    def direction(
        self, x: Expr, y: Expr, known: Expr | None = None, other: Turn | None = None, k: int = 0
    ) -> tuple[Turn, Expr]:
        """Return the turn from (1, 0) to (x, y), if short another, and the length, if known otherwise; k: a wrist's."""
        graph, found = x.graph, x.graph.sqrt(x * x + y * y)
        if known is not None:
            self.lengths[found] = known
        short, (s, c) = (STRAIGHT if other else SHORT) - found, other or Turn(graph.zero, graph.one)
        length = where(short, graph.one, found)  # all that is not taken is a number
        return Turn(where(short, s, y / length), where(short, c, x / length)), found

    def into_plane(self, u: Vec, n: Vec, d: Expr) -> Iterator[Turn]:
        """Yield turns about the first axis with n·Eᵀ u = d."""
        h = self.h[0]
        slant = dot(h, n)
        x, y = dot(n, u) - slant * dot(h, u), dot(u, cross(h, n))
        far = d - slant * dot(h, u)
        if vanishes(far):
            to, _ = self.direction(x, y)
            for sine, cosine in zip(self.both(to.c, 0), self.both(-to.s, 0), strict=True):
                yield self.named(Turn(sine, cosine), 0)
            return
        yield from self.turns(x, y, far, 0)

    def links(self, n: Vec, b: Vec, a: Vec, w: Vec, square: Expr | None = None) -> Iterator[tuple[Turn, Turn]]:
        """Yield turns of two links across n, E[2] (b + E[3] a) = w, of the length of whose square is known."""
        a, b, w = (sub(x, scale(dot(n, x), n)) for x in (a, b, w))
        w = self.lettered("w", w)
        square = dot(w, w) if square is None else square
        for third in self.turns(dot(a, b), dot(b, cross(n, a)), (square - dot(a, a) - dot(b, b)) / 2, 2):
            e = add(b, third.about(n, a))
            yield self.named(self.direction(dot(e, w), dot(n, cross(e, w)), square)[0], 1), third

    def wrist(self, h: Vec, k: int, M: Callable[[Vec], Vec], other: Turn) -> Iterator[tuple[Turn, Expr, Expr, Expr]]:
        """Yield a turn about h, if any will do another, and angles of E(h) E[k] E[k + 1] = M."""
        middle, last = self.h[k], self.h[k + 1]
        graph, f = middle[0].graph, cross(middle, h)
        u, t = self.lettered("u", M(last)), self.lettered("t", M(middle))
        first, rho = self.direction(dot(u, f), dot(u, middle), other=other, k=k)
        along, off = dot(h, last), dot(f, last)
        rise = dot(u, h)
        bend = self.named(Turn(along * rho - off * rise, along * rise + off * rho), k).angle
        unbent = -bend if vanishes(off) else Turn(-along * rho - off * rise, along * rise - off * rho).angle
        across = sub(scale(first.c, middle), scale(first.s, f))  # h[k] turned about h
        down = add(scale(first.c, f), scale(first.s, middle))
        spin = self.named(Turn(dot(t, sub(scale(rho, h), scale(rise, down))), dot(t, across)), k + 1).angle
        half: Callable[[Expr], Expr] = lambda x: where(x, x - graph.pi, x + graph.pi)  # noqa: E731
        yield first, first.angle, bend, spin
        yield Turn(-first.s, -first.c), half(first.angle), unbent, half(spin)

    def meeting(self, row: Sequence[int]) -> Vec | None:
        """Return the point that axes share, the first two at right angles; None for no such."""
        i, j, *_ = row
        B = add(self.c[i], scale(dot(sub(self.c[j], self.c[i]), self.h[i]), self.h[i]))
        meet = all(vanishes(x) for k in row for x in cross(sub(B, self.c[k]), self.h[k]))
        return B if meet else None

    def across(self, i: int, j: int) -> bool:
        return vanishes(dot(self.h[i], self.h[j]))

    def parallel(self, i: int, j: int) -> bool:
        return all(map(vanishes, cross(self.h[i], self.h[j])))


def _spherical_wrist(arm: ArmAngles, T: Sequence[Expr], B: Vec) -> Iterator[list[Expr]]:
    n, c = arm.h[1], arm.c
    crossing = arm.meeting((0, 1)) if arm.across(0, 1) else None
    c[0], c[1] = (c[0], c[1]) if crossing is None else (crossing, crossing)
    G, at = _asked(arm, T, B)
    u, d, unturned = arm.lettered("b", sub(at, c[0])), dot(n, sub(B, c[0])), Turn(n[0].graph.zero, n[0].graph.one)
    square = None if crossing is None else dot(u, u) - d * d
    for first in arm.into_plane(u, n, d):
        w = sub(add(first.back.about(arm.h[0], u), c[0]), c[1])
        for second, third in arm.links(n, sub(c[2], c[1]), sub(B, c[2]), w, square):
            for _, *rest in arm.wrist(arm.h[3], 4, _before(arm, first, second.then(third), G), unturned):
                yield [first.angle, second.angle, sense(arm, 2) * third.angle, *rest]


def _three_parallel(arm: ArmAngles, T: Sequence[Expr], B: Vec) -> Iterator[list[Expr]]:
    n, c = arm.h[1], arm.c
    G, at = _asked(arm, T, B)
    u, off, unturned = arm.lettered("b", sub(at, c[0])), sub(B, c[3]), Turn(n[0].graph.zero, n[0].graph.one)
    for first in arm.into_plane(u, n, dot(n, sub(B, c[0]))):
        way = sub(add(first.back.about(arm.h[0], u), c[0]), c[1])
        beside = dot(off, way) - dot(n, off) * dot(n, way)
        along, _ = arm.direction(beside, dot(n, cross(off, way)))  # of a straight wrist: as near, or far, as can be
        for lean, _, *rest in arm.wrist(n, 4, _before(arm, first, unturned, G), along):
            for second, third in arm.links(n, sub(c[2], c[1]), sub(c[3], c[2]), sub(way, lean.about(n, off))):
                fourth = arm.named(lean.then(second.then(third).back), 6).angle
                yield [first.angle, second.angle, sense(arm, 2) * third.angle, sense(arm, 3) * fourth, *rest]


def _before(arm: ArmAngles, first: Turn, lean: Turn, G: Mat) -> Callable[[Vec], Vec]:
    """Return M: what is left of G when the turns before it are taken back."""
    return lambda x: lean.back.about(arm.h[1], first.back.about(arm.h[0], G @ x))


def _asked(arm: ArmAngles, T: Sequence[Expr], B: Vec) -> tuple[Mat, Vec]:
    """Return G, and B' of a pose."""
    R, p = Mat([(T[i], T[i + 1], T[i + 2]) for i in (0, 4, 8)]), (T[3], T[7], T[11])
    return R @ arm.R.T, add(p, R @ (arm.R.T @ sub(B, arm.p)))


def sense(arm: ArmAngles, k: int) -> int:
    """Return whether a parallel axis points as n does, 1, or against it, -1."""
    return 1 if vanishes(dot(arm.h[k], arm.h[1]) - 1) else -1


KINDS = (
    ((1, 2), (3, 4, 5), (3, 4, 5), _spherical_wrist),
    ((1, 2, 3), (1, 4, 5), (4, 5), _three_parallel),
)
"""Classes: axes that are parallel, of which each is at right angles to the next, that meet; what yields branches."""


def arm_angles(w: Workspace, name: str, kind: Callable[..., ArmAngles] = ArmAngles) -> ArmAngles:
    """Return the angles that bring a frame to the pose [R p] of the argument `pose`; DerivationError for other arms."""
    joints, still = joints_below(w.scene, name), dict.fromkeys(w.state.q, w.graph.zero)
    lacks = f"{w.scene.name}: inverse_kinematics:{name}:"
    ways = "symdyn.inverse_kinematics takes more arms, of those with more joints when some are held"
    odd = [joint.name for joint in joints if len(joint.coordinates) != 1 or joint.coupling or joint.motion]
    if odd or len(joints) != 6:
        found = f"{listed(odd)} is another" if odd else f"there are {len(joints)}"
        raise DerivationError(f"{lacks} it is of six joints that turn, each by itself, and {found}; {ways}")
    J = substitute(MOVING["jacobian"].formulations["recursive"].derive(w, name), still)
    places = [w.scene.velocities.index(velocity_name(joint.coordinates[0])) for joint in joints]
    columns = [[J[w.state.n * i + k] for i in range(6)] for k in places]
    v, h = ([(x, y, z) for x, y, z in (one[i : i + 3] for one in columns)] for i in (0, 3))
    T = substitute(pose(tree_placed(w.scene, w.tree, name)), still)
    R, p = Mat([(T[i], T[i + 1], T[i + 2]) for i in (0, 4, 8)]), (T[3], T[7], T[11])
    c = [sub(p, cross(a, b)) for a, b in zip(v, h, strict=True)]
    plain = all(vanishes(dot(b, b) - 1) and vanishes(dot(a, b)) for a, b in zip(v, h, strict=True))  # they turn
    for parallel, across, meet, branches in KINDS if plain else ():
        arm = kind(h, c, R, p)
        fits = not arm.parallel(0, 1) and all(arm.parallel(1, k) for k in parallel)
        B = arm.meeting(meet) if fits and all(arm.across(*two) for two in pairwise(across)) else None
        if B is not None:
            arm.rows.extend(branches(arm, direction(w.graph, POSE, 12), B))
            if arm.rows:  # none with a link of no length
                return arm
    raise DerivationError(
        f"{lacks} it is of arms with a spherical wrist, axes 4, 5, 6 that meet at right angles, and 2, 3 parallel; or "
        f"2, 3, 4 parallel, and 5 at right angles to them and to 6, which it meets; {ways}"
    )


def _branches(w: Workspace, name: str) -> list[Expr]:
    """Return Q row by row, shape (8, nq); of what does not move the frame zero."""
    arm = w.once(arm_angles, name)
    names = [joint.coordinates[0] for joint in joints_below(w.scene, name)]
    found = [dict(zip(names, row, strict=True)) for row in arm.rows]
    return [row.get(one, w.graph.zero) for row in found for one in w.scene.coordinates]


def away_from_guards(outputs: Sequence[Expr], lengths: Mapping[Expr, Expr]) -> list[Expr]:
    """Return angles with the last entry of every select, and what lengths are in place of the roots."""
    known: dict[Expr, Expr] = {}
    for node in reachable([*lengths.values(), *outputs]):
        args = [known[arg] for arg in node.args]
        plain = node.graph.copy(node, args) if args else node
        known[node] = args[-1] if node.op is Op.SELECT else known[lengths[node]] if node in lengths else plain
    return [known[node] for node in outputs]


ARMS: dict[str, Output] = {
    "inverse_kinematics": Output(
        "joint positions of every branch in which {name} is at a pose; NaN in what is out of reach, and one choice of "
        "angles that can be any",
        (POSE,), "Q", (labels.fixed(*(f"branch {k + 1}" for k in range(BRANCHES))), labels.coordinates), "rad",
        "refuse", {"closed": Formulation(_branches)},
        place="point", default_in="request", may_fail="reported",
    ),
}  # fmt: skip
