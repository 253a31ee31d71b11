"""Recursive Newton-Euler algorithm: inverse dynamics of a kinematic tree, one frame at a time along factored links.

Reference: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), eq. (9.86)-(9.97); the matrix U
after Balafoutis and Patel, Dynamic Analysis of Robot Manipulators (1991), section 5.4.

    i, p        a moving body 1..n and its parent, p < i; body 0 is the ground
    w, dw, a    angular velocity, angular acceleration, acceleration of the origin of frame i, in frame i
    U           [ω̇]× + [ω]× [ω]×: a + U r is the acceleration of a point r of the body
    m, h, J     moments of body i about the origin of frame i
    f, n        force on body i by its parent and moment about the origin of frame i, in frame i

Gravity is the acceleration -g of the ground, so no body needs a weight. Joint axes are z axes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symdyn.dynamics.recursive.held_runs import Held, held_joints
from symdyn.dynamics.recursive.lean_tree import LeanTree
from symdyn.dynamics.recursive.link_motion import LinkMotion, carried, moving
from symdyn.dynamics.recursive.moments import Moments
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, Wrench, add, cross, neg, scale, sub, zero_vector


def rnea(
    tree: LeanTree,
    qd: Sequence[Expr],
    qdd: Sequence[Expr],
    gravity: bool = True,
    acting: Sequence[Wrench] = (),
    holding: bool = True,
    summing: bool = True,
) -> list[Expr]:
    """Return τ = M(q) q̈ + c(q, q̇) + g(q) less what acts on the bodies; N m or N; positive accelerates.

    Zeros for q̇ or q̈ leave their terms out of the graph. Wrenches (f, n) from outside act on the ground and every body,
    each in its frame. `holding` lets last bodies stay in axes that do not turn with their joints: fewer operations but
    where every inertia is a column of its own. `summing` lets moments leave runs of parallel axes on a joint of the
    ground in one turn, and J of their bodies stay in the run's axes: fewer but where columns or derivatives share them.
    """
    still = zero_vector(tree.graph)
    if holding:
        tree, acting = held_tips(tree, acting)
    rate, acceleration = tree.rates(qd), tree.accelerations(qd, qdd)
    ends, held = tree.ends, held_joints(tree) if summing else {}
    apart = _apart(tree, held) if any(not x.is_zero for x in qd) else {}
    motion = [moving(still, still, neg(tree.gravity) if gravity else still)]
    for i in tree.outward():  # pass 1: motion, ground to tips
        before, moves = motion[tree.parent[i]], (tree.slides[i], rate[i], acceleration[i], ends[i])
        motion.append(carried(before, tree.link[i], *moves, summing=True, alone=summing, bare=i in apart))
    moments = _moments_apart(tree, motion, held, apart, rate, acceleration)
    body = tuple(replace(one, J=Mat((still, still, still))) if i in apart else one for i, one in enumerate(tree.body))
    forces = transmitted(replace(tree, body=body), motion, acceleration, acting, held, moments)
    for ball in tree.balls:
        for k, moment in zip(ball.velocities, ball.forces(qd, qdd), strict=True):
            forces[k] = forces[k] + moment
    return forces


def held_tips(tree: LeanTree, acting: Sequence[Wrench] = ()) -> tuple[LeanTree, Sequence[Wrench]]:
    """Return the tree with last bodies in axes that do not turn with their joints where that pays, and what acts."""
    for i in sorted(set(tree.outward()).difference(tree.parent)):
        if not tree.slides[i] and _turns_lightly(tree.body[i]):
            tree, acting = _held(tree, i, acting)
    return tree, acting


def _held(tree: LeanTree, i: int, acting: Sequence[Wrench]) -> tuple[LeanTree, Sequence[Wrench]]:
    """Return the tree with body i in axes that do not turn with its joint, and what acts on all bodies.

    For the last body of a branch h and J turn for 12 multiplications. In its own axes ω, U z and the acceleration turn
    outwards and its wrench inwards, for 20, and five products of ω are new, not three.
    """
    body, link, wrench, turn = list(tree.body), list(tree.link), list(acting), tree.link[i].turn
    body[i], link[i] = turn.moments_back(body[i]), link[i].at_rest(False)
    if wrench:
        wrench[i] = Wrench(turn.back(wrench[i][0]), turn.back(wrench[i][1]))
    return replace(tree, body=tuple(body), link=tuple(link)), wrench


def _apart(tree: LeanTree, held: Mapping[int, Held]) -> dict[int, Moments]:
    """Return J of the bodies on held joints that carry others, in axes that do not turn with their joints.

    There ω is q̇ of the joint on the ground along one axis and a sum of rates along another, so that two of its
    products vanish, and n is asked for in two directions, not three: of a body of its own 10 additions are saved for 1
    multiplication more, and what depends on q alone is one with M.
    """
    still = zero_vector(tree.graph)
    bodies = {i: Moments(tree.graph.zero, still, tree.body[i].J) for i in held if i in tree.parent}
    return {i: held[i].turn.moments_back(body) for i, body in bodies.items() if _has_products(body)}


def _has_products(body: Moments) -> bool:
    (_, xy, xz), (_, _, yz), _ = body.J
    return not (xy.is_zero and xz.is_zero and yz.is_zero)


def _moments_apart(
    tree: LeanTree,
    motion: Sequence[LinkMotion],
    held: Mapping[int, Held],
    apart: Mapping[int, Moments],
    rate: Sequence[Expr],
    acceleration: Sequence[Expr],
) -> dict[int, Vec]:
    """Return the moments that give J of `_apart` its motion, in the axes of each joint's foot."""
    rates, moments = dict[int, tuple[Expr, Expr]](), dict[int, Vec]()
    for i, one in held.items():
        v, dv = rates.get(tree.parent[i], (tree.graph.zero, tree.graph.zero))
        rates[i] = v + rate[i], dv + acceleration[i]
        if i in apart:
            moved = carried(motion[one.below], one.foot, False, *rates[i], ends=True)
            moments[i] = balance(apart[i], moved)[0]
    return moments


def _turns_lightly(body: Moments) -> bool:
    """Tell whether a turn about z fills at most one pair of zeros among h and J."""
    (x, y, _), ((xx, xy, xz), (_, yy, yz), _) = body.h, body.J
    filled = (x.is_zero != y.is_zero, xz.is_zero != yz.is_zero, xy.is_zero and xx is not yy)
    return sum(filled) < 2


def transmitted(
    tree: LeanTree,
    motion: Sequence[LinkMotion],
    acceleration: Sequence[Expr],
    acting: Sequence[Wrench] = (),
    held: Mapping[int, Held] | None = None,
    apart: Mapping[int, Vec] | None = None,
) -> list[Expr]:
    """Return the forces on the velocities, shape (n,), that give all bodies their motions; balls without rotors.

    Where sums of the angles of a run of `held` joints are known, moments across it go to the joint on the ground in one
    turn. Moments `apart` are those of some of these joints in axes of their feet.
    """
    held, zero = held or {}, tree.graph.zero
    wrench = [balance(body, moved) for body, moved in zip(tree.body, motion, strict=True)]
    for i, (f, n) in enumerate(acting):
        wrench[i] = (sub(wrench[i][0], n), sub(wrench[i][1], f))
    tau = [tree.graph.zero] * len(tree.parent)
    for i, (x, y, z) in (apart or {}).items():
        g = held[i].below  # z goes down the run
        wrench[i] = (add(wrench[i][0], (zero, zero, z)), wrench[i][1])
        wrench[g] = (add(wrench[g][0], held[i].foot.back((x, y, zero))), wrench[g][1])
    for i in tree.inward():  # pass 2: force, tips to ground
        p, (n, f), link = tree.parent[i], wrench[i], tree.link[i]
        tau[i] = (f[2] if tree.slides[i] else n[2]) + tree.armature[i] * acceleration[i]
        if p in held and i in held and motion[i].foot:
            (x, y, z), rise, g = n, link.rise, held[i].below
            across = held[i].turn.back((x - rise * f[1], y + rise * f[0], zero))
            wrench[g] = (add(wrench[g][0], held[i].foot.back(across)), wrench[g][1])
            n, link = (zero, zero, z), replace(link, rise=zero)
        n, f = link.wrench_back(n, f)
        wrench[p] = (add(wrench[p][0], n), add(wrench[p][1], f))
    return tree.gather(tau)


def balance(body: Moments, motion: LinkMotion) -> tuple[Vec, Vec]:
    """Return the wrench (n, f) that gives a body its motion: Newton's and Euler's equations about the frame's origin.

    f = m a + U h,    n = h × a + axis of (U J - J Uᵀ), row by row U_y·J_z - U_z·J_y and so on.
    """
    U, J = motion.U, body.J
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = J
    zy, xz2, yx = motion.spread
    if not (xz.is_zero or yz.is_zero) and yx is U[1][1] - U[0][0]:
        yx = -(zy + xz2)  # both are there; of U's entries one may not be asked for
    about_z = U[1][0] * body.polar if U[0][1] is -U[1][0] else U[1][0] * xx - U[0][1] * yy
    turning = (
        U[2][0] * xy - U[1][0] * xz + zy * yz + U[2][1] * yy - U[1][2] * zz,
        U[0][1] * yz - U[2][1] * xy + xz2 * xz + U[0][2] * zz - U[2][0] * xx,
        U[1][2] * xz - U[0][2] * yz + yx * xy + about_z,
    )
    f = add(scale(body.m, motion.a), U @ body.h)
    return add(turning, cross(body.h, motion.a)), f
