"""Runs of parallel axes on a joint of the ground, seen in axes that do not turn with the run.

The joint on the ground feels one component of what comes from the run. To have it alone, wrenches and second moments J
leave the run in one turn by the sum of its angles; shifts across the run are seen where the body next to them is:

    J in frame p = R J Rᵀ + p uᵀ + u pᵀ        R J Rᵀ by the sum of angles, the rest with the J of body p
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics.recursive.links import Link, PlanarTurn
from symdyn.dynamics.recursive.moments import Moments
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, add, zero_vector


@dataclass(frozen=True)
class Held:
    """A joint of a run on a joint of the ground; see the module's legend.

    Attributes:
        below: the joint on the ground.
        foot: the first link of the run without its joint and its rise.
        turn: from the frame of the joint to the axes at the end of `foot`.
        way: from there to the origin of the joint's frame, in these axes, m.
    """

    below: int
    foot: Link
    turn: PlanarTurn
    way: Vec

    def felt(self, n: Vec, f: Vec, at: Vec) -> Expr:
        """Return what the joint on the ground feels of a wrench in the joint's axes, whose n_z it need not know.

        The moment n counts from the point `at`, m, seen from the joint's origin.
        """
        x, y, z = add(self.way, self.turn.back(at))
        n, f = self.turn.back((n[0] - z * f[1], n[1] + z * f[0], n[2])), self.turn.back(f)
        n = (n[0] + y * f[2], n[1] - x * f[2], n[2] + x * f[1] - y * f[0])
        return self.foot.wrench_back(n, f)[0][2]

    def felt_here(self, n: Vec, f: Vec) -> Expr:
        """Return what the joint on the ground feels of a wrench about the joint's origin, in axes of `foot`."""
        x, y, z = self.way
        n = (n[0] + y * f[2] - z * f[1], n[1] + z * f[0] - x * f[2], n[2] + x * f[1] - y * f[0])
        return self.foot.wrench_back(n, f)[0][2]

    def moments_back(self, body: Moments) -> Moments:
        """Return moments about the joint's origin in axes of `foot` in the frame of the joint on the ground."""
        return self.foot.moments_back(body.shifted(self.way))


def held_runs(tree: ReducedTree) -> dict[int, Held]:
    """Return the joints of runs of two and more parallel axes at a right angle to a joint of the ground."""
    held = _held_joints(tree)
    return held if any(tree.parent[i] in held for i in held) else {}


def _held_joints(tree: ReducedTree) -> dict[int, Held]:
    """Return the joints at a right angle to a joint of the ground, and runs of joints parallel to them."""
    held: dict[int, Held] = {}
    zero, one = tree.graph.zero, tree.graph.one
    for i in tree.outward():
        p, link = tree.parent[i], tree.link[i]
        if tree.slides[i] or not p:
            continue
        if p in held and not link.fixed:
            x, y, z = held[p].turn.back(link.shift)
            way = add(held[p].way, (x, y, z + link.rise))
            held[i] = Held(held[p].below, held[p].foot, held[p].turn.after(link.turn), way)
        elif not tree.parent[p] and not tree.slides[p] and link.is_right and link.axis[2].is_zero:  # not turned by π
            foot = Link(link.shift, link.fixed, PlanarTurn(2, one, zero), zero)
            held[i] = Held(p, foot, link.turn, (zero, zero, link.rise))
    return held


def inward(link: Link, body: Moments, held: Moments) -> tuple[Moments, Moments]:
    """Return what lies beyond a link of a run for the body that carries it: what keeps the run's axes, and the rest.

    Args:
        link: a link between parallel axes.
        body: what lies beyond, in the frame at the link's end.
        held: the same in the run's axes.
    """
    zero = link.rise.graph.zero
    lifted = held.shifted((zero, zero, link.rise + link.shift[2]))
    (x, y, _), (a, b, _), m = link.shift, link.back(body.h), body.m
    u = (a + m / 2 * x, b + m / 2 * y, lifted.h[2])
    J = Mat.symmetric(x * u[0] * 2, y * u[1] * 2, zero, x * u[1] + y * u[0], x * u[2], y * u[2])
    still = zero_vector(link.rise.graph)
    return Moments(zero, still, lifted.J), Moments(m, (a + m * x, b + m * y, u[2]), J)
