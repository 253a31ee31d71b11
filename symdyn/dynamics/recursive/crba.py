"""Composite-rigid-body algorithm: the mass matrix of a kinematic tree, and a faster form for runs of parallel axes.

    i, j, p     body 1..n, one that carries it, and its parent, p < i
    X[i]        transform across joint i, from frame i to frame p (`links`)
    S_i         axis of joint i: z of frame i, which it turns about or slides along
    C[i]        composite body: everything beyond joint i as one rigid body, in frame i (`links`)
    F           C[i] S_i, its momentum for unit velocity of joint i: (angular, linear), walked down to the base
    H           H_ij = F·S_j, the mass matrix of the moves

`crba` is table 6.2. `crba_in_runs` takes a *run* of parallel axes in one turn, by the sum of their angles, which is
formed by the addition formulas, so that no further sine is evaluated:

    k         the joint at the far end of the run, in whose frame n and f stay
    P         from the origin of frame j to that of frame k, axes of frame k
    Q         the same, in the axes in which link j turns
    turn      from frame k to those axes

Joint j of the run feels n_z + (P × f)_z (or f_z) without any turn; behind the run the wrench is where it would be after
all single turns. What a run needs is computed once for all wrenches that pass it, which pays from three on. A wrench
that starts inside a run takes single turns there, since these are the turns of the composite body. Turns about parallel
axes keep the polar moment J_xx + J_yy, so it is added up separately.

A run on a joint of the ground is seen in axes that do not turn with the run (`held_runs`). The joint on the ground
feels one component of what comes from the run. To have it alone, wrenches and second moments J leave the run in one
turn; shifts across the run are seen where the body next to them is:

    J in frame p = R J Rᵀ + p uᵀ + u pᵀ        R J Rᵀ by the sum of angles, the rest with the J of body p

Gain (operations; ns one state a call, a state of a batch), where there are such runs; other robots keep `crba`:

                          puma560                 arm7, chain8
    M(q)                   -17 %; -8 %, -3 %      0
    forward dynamics      -4.8 %; -1 %, -3 %      0

Of the operations of M of the PUMA, single turns for whole runs save 7 %, leaving in one turn 10 % more, polar moments 5
% more.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 6.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from symdyn.dynamics.recursive.links import Link, Moments, PlanarTurn
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, add, zero_vector


def crba(tree: ReducedTree) -> list[list[Expr]]:
    """Return the mass matrix M(q), shape (n, n), symmetric, so that K = q̇ᵀ M q̇ / 2; kg m^2, kg m or kg.

    It is positive definite unless a massless body ends a branch; entries of joints on different branches are zero.
    """
    X, C, H = tree.link, list(tree.body), dict[tuple[int, int], Expr]()
    for i in tree.inward():
        F = momentum(C[i], tree.slides[i])
        H[i, i] = tree.along_axis(i, F) + tree.armature[i]
        j = i
        while tree.parent[j]:
            F, j = X[j].wrench_back(*F), tree.parent[j]
            H[i, j] = H[j, i] = tree.along_axis(j, F)
        if p := tree.parent[i]:
            C[p] = C[p] + X[i].moments_back(C[i])
    return with_balls(tree, H)


def momentum(body: Moments, slides: bool, polar: Expr | None = None) -> tuple[Vec, Vec]:
    """Return angular momentum about the origin and momentum for unit velocity along z, where `polar` is I_zz."""
    (x, y, _), J, zero = body.h, body.J, body.m.graph.zero
    if slides:
        return (y, -x, zero), (zero, zero, body.m)
    return (-J[0][2], -J[1][2], body.polar if polar is None else polar), (-y, x, zero)


def with_balls(tree: ReducedTree, H: dict[tuple[int, int], Expr]) -> list[list[Expr]]:
    """Return the mass matrix of the velocities for that of the moves, rotors of balls included."""
    M = tree.gather_matrix(H)
    for ball in tree.balls:
        for k, m, value in ball.entries():
            M[k][m] = M[k][m] + value
    return M


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


def crba_in_runs(tree: ReducedTree) -> list[list[Expr]]:
    """Return what `crba` does."""
    C, alone = list(tree.body), list(tree.body)  # all beyond a joint; that less what the joint's run carries
    held, still = held_runs(tree), zero_vector(tree.graph)
    own = [Moments(tree.graph.zero, still, Mat((still, still, still)))] * len(C)  # of a held run, in the run's axes
    polar: list[Expr | None] = [body.polar for body in C]
    H = dict[tuple[int, int], Expr]()
    for i in tree.inward():
        n, f = momentum(C[i], tree.slides[i], polar[i])
        H[i, i] = tree.along_axis(i, (n, f)) + tree.armature[i]
        if i in held:
            own[i] = own[i] + held[i].turn.moments_back(alone[i])
        for j, felt in _walk(tree, i, n, f, held):
            leaves = i in held and j not in held
            H[i, j] = H[j, i] = held[i].felt_here(*momentum(own[i], False, polar[i])) if leaves else felt
        if p := tree.parent[i]:
            here = i in held and p not in held
            beyond = held[i].moments_back(own[i]) if here else tree.link[i].moments_back(C[i])
            if i in held and p in held:
                kept, rest = inward(tree.link[i], C[i], own[i])
                own[p], alone[p] = own[p] + kept, alone[p] + rest
            else:
                alone[p] = alone[p] + beyond
            if tree.parent[p] or not tree.link[i].fixed:
                polar[p] = _sum_of_polar_moments(polar[p], polar[i], tree.link[i], C[i], i in held)
            elif (ours := polar[p]) is not None:  # nobody needs J by its entries
                polar[p] = ours + beyond.polar
            C[p] = C[p] + beyond
    return with_balls(tree, H)


def _sum_of_polar_moments(
    own: Expr | None, beyond: Expr | None, link: Link, body: Moments, shared: bool
) -> Expr | None:
    """Return the polar moment of two bodies, the second one beyond a link; None if axes are not parallel.

    Where products of shifts and h are `shared`, those are added twice; else the shifts are doubled.
    """
    if own is None or link.fixed:
        return None
    turned, (x, y, _) = link.back(body.h), link.shift
    beyond = body.polar if beyond is None else beyond
    a, b = turned[0] + body.m / 2 * x, turned[1] + body.m / 2 * y
    if shared:
        a, b = x * a, y * b
        return own + (beyond + a + b + a + b)
    return own + (beyond + x * 2 * a + y * 2 * b)


@dataclass(frozen=True)
class _Run:
    """A stretch of parallel axes from frame k down to link j; see the module's legend. `rise` is along z in all."""

    P: Vec
    Q: Vec
    turn: PlanarTurn
    rise: Expr


def _walk(tree: ReducedTree, j: int, n: Vec, f: Vec, held: Mapping[int, Held]) -> Iterator[tuple[int, Expr]]:
    """Yield every ancestor of joint j with the part of a wrench in frame j that its joint feels."""
    while tree.parent[j] and not tree.link[j].fixed:
        n, f = tree.link[j].wrench_back(n, f)
        j = tree.parent[j]
        yield j, f[2] if tree.slides[j] else n[2]
    run, k, at = _start(tree, j), 0, zero_vector(tree.graph)  # k, at: where a wrench has come into a held run
    while tree.parent[j]:
        link, p = tree.link[j], tree.parent[j]
        if not link.fixed:
            run = _extend(run, link, tree.link[p])
        elif k:
            yield p, held[k].felt(n, f, at)
            return
        elif p in held:
            k, at = p, link.shift
            n, f = _leave(run, replace(link, shift=zero_vector(tree.graph)), n, f)
            n = (n[0], n[1], n[2] + at[0] * f[1] - at[1] * f[0])
            run = _start(tree, p)
        else:
            n, f = _leave(run, link, n, f)
            run = _start(tree, p)
        j = p
        yield j, f[2] if tree.slides[j] else n[2] + run.P[0] * f[1] - run.P[1] * f[0]


def _start(tree: ReducedTree, k: int) -> _Run:
    nowhere = zero_vector(tree.graph)
    return _Run(nowhere, nowhere, tree.link[k].turn, tree.link[k].rise)


def _extend(run: _Run, link: Link, below: Link) -> _Run:
    """Return the run with one more link, which turns before the run's; a branch may have lifted the frame below."""
    graph = link.rise.graph
    shift = (link.shift[0], link.shift[1], graph.zero)
    both = below.turn.after(run.turn)  # before the rest: programs are written in the order of birth
    rise = run.rise + link.shift[2] + below.rise
    return _Run(add(run.P, run.turn.out(shift)), below.turn.back(add(run.Q, shift)), both, rise)


def _leave(run: _Run, link: Link, n: Vec, f: Vec) -> tuple[Vec, Vec]:
    """Return the wrench in the frame below the run, whose first link this is."""
    n = run.turn.back((n[0] - run.rise * f[1], n[1] + run.rise * f[0], n[2]))
    f = run.turn.back(f)
    x, y, _ = run.Q
    n = (n[0] + y * f[2], n[1] - x * f[2], n[2] + x * f[1] - y * f[0])
    zero = run.rise.graph.zero
    return Link(link.shift, link.fixed, PlanarTurn(2, run.rise.graph.one, zero), zero).wrench_back(n, f)
