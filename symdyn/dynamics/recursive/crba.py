"""Composite-rigid-body algorithm: the mass matrix of a kinematic tree, and a faster form for runs of parallel axes.

    i, j, p     body 1..n, one that carries it, and its parent, p < i; body 0 is the base
    X[i]        transform across joint i, from frame i to frame p (`links`); Featherstone's iXλ leads the other way
    S_i         axis of joint i: z of frame i, which it turns about or slides along
    C[i]        composite body: everything beyond joint i as one rigid body, in frame i (`links`)
    F           C[i] S_i, its momentum for unit velocity of joint i, (angular, linear), transformed down to the base
    H           H_ij = F·S_j, the mass matrix of the elementary joints
    M           M_kl = Σ_ij A_ik H_ij A_jl, A_ik being the rate of elementary joint i per unit of velocity k

`crba` is table 6.2. In `crba_in_runs` a wrench crosses a *run* of parallel axes in one rotation, by the sum of their
angles, which is formed by the addition formulas, so that no further sine is evaluated:

    ground ── joint b ──┤ first ├── j ∥ … ∥ k ──┤ … ├── i          joint axes j to k are parallel, and across that of b

    k         outermost joint of the run, in whose frame the wrench (n, f) stays
    P         from the origin of frame j to that of frame k, axes of frame k
    Q         the same, in the axes that X[j] rotates, which joint j has at zero
    turn      from frame k to those axes

The force of joint j in the run is n_z + (P × f)_z (or f_z), without any rotation. What a run needs is computed once for
all wrenches that cross it, which pays from three on. In a run of its own F is transformed joint by joint, as C is.
Rotations about parallel axes keep the polar moment J_xx + J_yy, so it is added up separately.

Of a run across the axis of the ground's joint b (`UnrotatedRun`), b needs one component of each wrench. To have it
alone, wrenches and second moments J go by one rotation R, the sum of the angles, to unrotated axes: those at the start
of the run, which are fixed in body b. Shifts across the run are added in the frame of the body next to them:

    J in frame p = R J Rᵀ + r sᵀ + s rᵀ        R J Rᵀ in unrotated axes, r the shift, the rest with the J of body p

Gain (operations; ns one state a call, a state of a batch), where there are such runs; other robots keep `crba`:

                          puma560                 arm7, chain8
    M(q)                   -17 %; -8 %, -3 %      0
    forward dynamics      -4.8 %; -1 %, -3 %      0

Of the operations of M of the PUMA, rotations across runs save 7 %, unrotated axes 10 % more, polar moments 5 % more.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 6.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from symdyn.dynamics.recursive.links import JointTransform, Moments, PlanarTurn
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, add, zero_vector


def crba(tree: ReducedTree) -> list[list[Expr]]:
    """Return the mass matrix M(q), shape (n, n), symmetric, so that K = q̇ᵀ M q̇ / 2; kg m^2, kg m or kg.

    It is positive definite unless a massless body ends a branch; entries of joints on different branches are zero.
    """
    X, C, H = tree.X, list(tree.body), dict[tuple[int, int], Expr]()
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
    """Return the mass matrix of the velocities for that of the elementary joints, spherical rotors included."""
    M = tree.generalized_matrix(H)
    for ball in tree.spherical_rotors:
        for k, m, value in ball.entries():
            M[k][m] = M[k][m] + value
    return M


@dataclass(frozen=True)
class UnrotatedRun:
    """A joint of a run across a joint of the ground, and the run's unrotated axes; see the module's legend."""

    first: JointTransform  # the transform across the run's first joint, without its rotation and its offset
    turn: PlanarTurn  # from the frame of the joint to the unrotated axes at the end of `first`
    offset: Vec  # from there to the origin of the joint's frame, in unrotated axes, m

    def base_force(self, n: Vec, f: Vec) -> Expr:
        """Return the force along the joint on the ground of a wrench about the joint's origin in unrotated axes."""
        x, y, z = self.offset
        n = (n[0] + y * f[2] - z * f[1], n[1] + z * f[0] - x * f[2], n[2] + x * f[1] - y * f[0])
        return self.first.wrench_back(n, f)[0][2]

    def base_force_rotated(self, n: Vec, f: Vec, at: Vec) -> Expr:
        """Return the same of a wrench about a point `at`, m, of the joint's frame, in its axes; n_z does not matter."""
        x, y, z = add(self.offset, self.turn.back(at))
        n, f = self.turn.back((n[0] - z * f[1], n[1] + z * f[0], n[2])), self.turn.back(f)
        n = (n[0] + y * f[2], n[1] - x * f[2], n[2] + x * f[1] - y * f[0])
        return self.first.wrench_back(n, f)[0][2]

    def moments_back(self, body: Moments) -> Moments:
        """Return moments about the joint's origin in unrotated axes in the frame of the joint on the ground."""
        return self.first.moments_back(body.shifted(self.offset))


def unrotated_runs(tree: ReducedTree) -> dict[int, UnrotatedRun]:
    """Return the joints of runs of two and more parallel axes at a right angle to a joint of the ground."""
    runs = _joints_of_runs(tree)
    return runs if any(tree.parent[i] in runs for i in runs) else {}


def _joints_of_runs(tree: ReducedTree) -> dict[int, UnrotatedRun]:
    """Return the joints at a right angle to a joint of the ground, and runs of joints parallel to them."""
    runs: dict[int, UnrotatedRun] = {}
    zero, one = tree.graph.zero, tree.graph.one
    for i in tree.outward():
        p, X = tree.parent[i], tree.X[i]
        if tree.slides[i] or not p:
            continue
        if p in runs and not X.fixed:
            x, y, z = runs[p].turn.back(X.shift)
            offset = add(runs[p].offset, (x, y, z + X.offset))
            runs[i] = UnrotatedRun(runs[p].first, runs[p].turn.after(X.turn), offset)
        elif not tree.parent[p] and not tree.slides[p] and X.is_right and X.axis[2].is_zero:  # not turned by π
            first = JointTransform(X.shift, X.fixed, PlanarTurn(2, one, zero), zero)
            runs[i] = UnrotatedRun(first, X.turn, (zero, zero, X.offset))
    return runs


def moments_across(X: JointTransform, body: Moments, unrotated: Moments) -> tuple[Moments, Moments]:
    """Return what lies beyond a joint of a run for the body that carries it: in unrotated axes, and in its own frame.

    Args:
        X: a transform between parallel axes.
        body: what lies beyond, in the joint's frame.
        unrotated: the same in unrotated axes.
    """
    zero = X.offset.graph.zero
    lifted = unrotated.shifted((zero, zero, X.offset + X.shift[2]))
    (x, y, _), (a, b, _), m = X.shift, X.back(body.h), body.m
    u = (a + m / 2 * x, b + m / 2 * y, lifted.h[2])
    J = Mat.symmetric(x * u[0] * 2, y * u[1] * 2, zero, x * u[1] + y * u[0], x * u[2], y * u[2])
    zeros = zero_vector(X.offset.graph)
    return Moments(zero, zeros, lifted.J), Moments(m, (a + m * x, b + m * y, u[2]), J)


def crba_in_runs(tree: ReducedTree) -> list[list[Expr]]:
    """Return what `crba` does."""
    C, rotating = list(tree.body), list(tree.body)  # all beyond a joint; of that what is not in `unrotated`
    runs, zeros = unrotated_runs(tree), zero_vector(tree.graph)
    unrotated = [Moments(tree.graph.zero, zeros, Mat((zeros, zeros, zeros)))] * len(C)  # of runs, in their axes
    polar: list[Expr | None] = [body.polar for body in C]
    H = dict[tuple[int, int], Expr]()
    for i in tree.inward():
        n, f = momentum(C[i], tree.slides[i], polar[i])
        H[i, i] = tree.along_axis(i, (n, f)) + tree.armature[i]
        if i in runs:
            unrotated[i] = unrotated[i] + runs[i].turn.moments_back(rotating[i])
        for j, force in _forces(tree, i, n, f, runs):
            on_base = i in runs and j not in runs
            H[i, j] = H[j, i] = runs[i].base_force(*momentum(unrotated[i], False, polar[i])) if on_base else force
        if p := tree.parent[i]:
            run_ends = i in runs and p not in runs
            beyond = runs[i].moments_back(unrotated[i]) if run_ends else tree.X[i].moments_back(C[i])
            if i in runs and p in runs:
                kept, rest = moments_across(tree.X[i], C[i], unrotated[i])
                unrotated[p], rotating[p] = unrotated[p] + kept, rotating[p] + rest
            else:
                rotating[p] = rotating[p] + beyond
            if tree.parent[p] or not tree.X[i].fixed:
                polar[p] = _polar_sum(polar[p], polar[i], tree.X[i], C[i], i in runs)
            elif (ours := polar[p]) is not None:  # J is not needed by its entries
                polar[p] = ours + beyond.polar
            C[p] = C[p] + beyond
    return with_balls(tree, H)


def _polar_sum(polar: Expr | None, beyond: Expr | None, X: JointTransform, body: Moments, shared: bool) -> Expr | None:
    """Return the polar moment of two bodies, the second one beyond a joint; None if axes are not parallel.

    Where products of shifts and h are `shared`, those are added twice; else the shifts are doubled.
    """
    if polar is None or X.fixed:
        return None
    turned, (x, y, _) = X.back(body.h), X.shift
    beyond = body.polar if beyond is None else beyond
    a, b = turned[0] + body.m / 2 * x, turned[1] + body.m / 2 * y
    if shared:
        a, b = x * a, y * b
        return polar + (beyond + a + b + a + b)
    return polar + (beyond + x * 2 * a + y * 2 * b)


@dataclass(frozen=True)
class _Run:
    """A run of parallel axes from frame k down to joint j; see the module's legend. `offset` is along z in all."""

    P: Vec
    Q: Vec
    turn: PlanarTurn
    offset: Expr


def _forces(tree: ReducedTree, j: int, n: Vec, f: Vec, runs: Mapping[int, UnrotatedRun]) -> Iterator[tuple[int, Expr]]:
    """Yield every ancestor of joint j with the part along its axis of a wrench in frame j."""
    while tree.parent[j] and not tree.X[j].fixed:
        n, f = tree.X[j].wrench_back(n, f)
        j = tree.parent[j]
        yield j, f[2] if tree.slides[j] else n[2]
    run, k, at = _run_from(tree, j), 0, zero_vector(tree.graph)  # k, at: where a wrench enters an unrotated run
    while tree.parent[j]:
        X, p = tree.X[j], tree.parent[j]
        if not X.fixed:
            run = _extended(run, X, tree.X[p])
        elif k:
            yield p, runs[k].base_force_rotated(n, f, at)
            return
        elif p in runs:
            k, at = p, X.shift
            n, f = _wrench_across(run, replace(X, shift=zero_vector(tree.graph)), n, f)
            n = (n[0], n[1], n[2] + at[0] * f[1] - at[1] * f[0])
            run = _run_from(tree, p)
        else:
            n, f = _wrench_across(run, X, n, f)
            run = _run_from(tree, p)
        j = p
        yield j, f[2] if tree.slides[j] else n[2] + run.P[0] * f[1] - run.P[1] * f[0]


def _run_from(tree: ReducedTree, k: int) -> _Run:
    zeros = zero_vector(tree.graph)
    return _Run(zeros, zeros, tree.X[k].turn, tree.X[k].offset)


def _extended(run: _Run, X: JointTransform, parent: JointTransform) -> _Run:
    """Return the run with its parent joint, which turns before it; a branch may have lifted the parent's frame."""
    graph = X.offset.graph
    shift = (X.shift[0], X.shift[1], graph.zero)
    both = parent.turn.after(run.turn)  # before the rest: programs are written in the order of birth
    offset = run.offset + X.shift[2] + parent.offset
    return _Run(add(run.P, run.turn.out(shift)), parent.turn.back(add(run.Q, shift)), both, offset)


def _wrench_across(run: _Run, X: JointTransform, n: Vec, f: Vec) -> tuple[Vec, Vec]:
    """Return the wrench in the frame that carries the run, whose first transform this is."""
    n = run.turn.back((n[0] - run.offset * f[1], n[1] + run.offset * f[0], n[2]))
    f = run.turn.back(f)
    x, y, _ = run.Q
    n = (n[0] + y * f[2], n[1] - x * f[2], n[2] + x * f[1] - y * f[0])
    zero = run.offset.graph.zero
    return JointTransform(X.shift, X.fixed, PlanarTurn(2, run.offset.graph.one, zero), zero).wrench_back(n, f)
