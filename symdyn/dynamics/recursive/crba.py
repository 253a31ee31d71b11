"""Composite rigid bodies: the mass matrix of a kinematic tree, along factored links.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 6.2.

    i, p     a moving body 1..n and its parent, p < i
    C[i]     moments of everything beyond joint i, as one rigid body, in frame i: m, h, J
    n, f     its momentum for unit velocity of joint i, walked down to the ground, in the frame of body j

    polar    J_xx + J_yy of C[i]

Joint axes are z axes. For a unit turn n = (-J_xz, -J_yz, J_xx + J_yy) and f = z × h; for a unit slide n = h × z and
f = m z. Since n and f turn as J and h do, what both need is one node. Turns about parallel axes keep the polar moment.

A wrench may leap: on its way to the ground it passes a run of parallel axes in one turn, by the sum of their angles.
Joint j of a run feels n_z + (P × f)_z (or f_z), without any turn, P being the way from its origin to the wrench's; and
behind the run the wrench is where it would be after all single turns. Sums of angles are taken by the addition
formulas, so that no sine is evaluated for them. What a run needs is computed once for all wrenches that pass it; it
pays from three on.

    k         the joint at the far end of the run, in whose frame n and f stay
    P         from the origin of frame j to that of frame k, axes of frame k
    Q         the same, in the axes in which link j turns
    turn      from frame k to those axes

The run that a wrench starts in is walked step by step: there its turns are those of the composite body.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from symdyn.dynamics.recursive.held_runs import Held, held_runs, inward
from symdyn.dynamics.recursive.lean_tree import LeanTree
from symdyn.dynamics.recursive.links import Link, PlanarTurn
from symdyn.dynamics.recursive.moments import Moments
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, add, zero_vector


def crba(tree: LeanTree, leaping: bool = False, keeping: bool = False, holding: bool = False) -> list[list[Expr]]:
    """Return the mass matrix M(q), shape (n, n), symmetric, so that K = q̇ᵀ M q̇ / 2; kg m^2, kg m or kg.

    It is positive definite unless a massless body ends a branch; entries of joints on different branches are zero.

    Args:
        tree: the mechanism.
        leaping: pass runs of parallel axes in one turn by the sum of their angles.
        keeping: add polar moments up along parallel axes, in place of adding up the entries of a turned J.
        holding: let what leaves a run of `held_runs` do so in one turn, moments of bodies as well.
    """
    C, alone = list(tree.body), list(tree.body)  # all beyond a joint; that less what the joint's run carries
    held = held_runs(tree) if holding else {}
    H = [Moments(tree.graph.zero, still := zero_vector(tree.graph), Mat((still, still, still)))] * len(C)
    polar: list[Expr | None] = [body.polar if keeping else None for body in C]
    M = [[tree.graph.zero] * tree.n for _ in range(tree.n)]

    def enter(i: int, j: int, value: Expr) -> None:
        """Add the term of moves i and j to the entries of the velocities that they share in."""
        for k, x in tree.A[i]:
            for m, y in tree.A[j]:
                M[k][m] = M[k][m] + x * y * value

    for i in tree.inward():
        n, f = _momentum(C[i], tree.slides[i], polar[i])
        enter(i, i, (f[2] if tree.slides[i] else n[2]) + tree.armature[i])
        if i in held:
            H[i] = H[i] + held[i].turn.moments_back(alone[i])
        for j, felt in _walk(tree, i, n, f, leaping, held):
            own = i in held and j not in held
            value = held[i].felt_here(*_momentum(H[i], False, polar[i])) if own else felt
            enter(i, j, value)
            enter(j, i, value)
        if p := tree.parent[i]:
            here = i in held and p not in held
            beyond = held[i].moments_back(H[i]) if here else tree.link[i].moments_back(C[i])
            if i in held and p in held:
                kept, rest = inward(tree.link[i], C[i], H[i])
                H[p], alone[p] = H[p] + kept, alone[p] + rest
            else:
                alone[p] = alone[p] + beyond
            if tree.parent[p] or not tree.link[i].fixed:
                polar[p] = _sum_of_polar_moments(polar[p], polar[i], tree.link[i], C[i], i in held)
            elif (ours := polar[p]) is not None:  # nobody needs J by its entries
                polar[p] = ours + beyond.polar
            C[p] = C[p] + beyond
    for ball in tree.balls:
        for k, m, value in ball.entries():
            M[k][m] = M[k][m] + value
    return M


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


def _momentum(body: Moments, slides: bool, polar: Expr | None) -> tuple[Vec, Vec]:
    """Return angular momentum about the origin and momentum for unit velocity along z."""
    (x, y, _), J, zero = body.h, body.J, body.m.graph.zero
    if slides:
        return (y, -x, zero), (zero, zero, body.m)
    return (-J[0][2], -J[1][2], body.polar if polar is None else polar), (-y, x, zero)


@dataclass(frozen=True)
class _Run:
    """A stretch of parallel axes from frame k down to link j; see the module's legend. `rise` is along z in all."""

    P: Vec
    Q: Vec
    turn: PlanarTurn
    rise: Expr


def _walk(
    tree: LeanTree, j: int, n: Vec, f: Vec, leaping: bool, held: Mapping[int, Held]
) -> Iterator[tuple[int, Expr]]:
    """Yield every ancestor of joint j with the part of a wrench in frame j that its joint feels."""
    while tree.parent[j] and not (leaping and tree.link[j].fixed):
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


def _start(tree: LeanTree, k: int) -> _Run:
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
