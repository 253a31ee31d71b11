"""The formulations of the outputs of a tree: recursion from body to body, and Lagrange's equations.

Each takes the workspace and returns the entries of a result, row by row; `output_table` says which result each derives.

Turns in differentiation: each component of a vector that has turned is the other's derivative by the angle.

    x' = cos θ x - sin θ y        dx' = cos θ dx - sin θ dy - y' dθ
    y' = sin θ x + cos θ y        dy' = sin θ dx + cos θ dy + x' dθ

That takes six multiplications, forward and in reverse, where products by themselves take eight, and two more for the
rates of the sine and the cosine. In derivatives of turns there are turns again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import combinations, product
from typing import NamedTuple

from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.mechanism.linear_solve import solve
from symdyn.dynamics.mechanism.state import accelerations
from symdyn.dynamics.outputs.recursive_derivatives import COUNTED, coriolis_matrix
from symdyn.dynamics.outputs.workspace import Matrix, Workspace
from symdyn.dynamics.recursive.table_loops import aba_loop
from symdyn.dynamics.recursive.tree_dynamics import aba, rnea
from symdyn.graph import Expr, LocalPartials, Op, operands, reachable, substitute


def flat(matrix: Matrix) -> list[Expr]:
    """Return the entries of a matrix, row by row."""
    return [entry for row in matrix for entry in row]


def _minus(a: list[Expr], b: list[Expr]) -> list[Expr]:
    return [x - y for x, y in zip(a, b, strict=True)]


# Recursive formulations


def forward_aba(w: Workspace) -> list[Expr]:
    """Return q̈ by the articulated-body algorithm."""
    given = zip(w.state.tau, w.pushes, w.elastic.forces, strict=True)
    return aba(w.recursion_tree, w.state.qd, [tau + force - pull for tau, force, pull in given], w.unrotated_loads)


def forward_loop(w: Workspace, compute: Callable[..., list[Expr]] = aba_loop) -> list[Expr]:
    """Return q̈ by that algorithm, or what another one computes, joint by joint from the table."""
    try:
        return compute(w.joint_table, w.state.q, w.state.qd, w.state.tau)
    except ZeroDivisionError:
        w.once(forward_aba)  # which tells the joint that moves no mass
        raise


def forward_crba(w: Workspace) -> list[Expr]:
    """Return q̈ from M by composite bodies, factored as LᵀDL."""
    given = w.prescribed
    if given.place:
        parents = w.tree.velocity_parents(given.free)
        return accelerations(given, parents, w.composite_mass, w.state.tau, w.forces(given.entered(w.zeros)))
    rest = unbalanced(w)
    return solve(w.tree.velocity_parents(), w.composite_mass, rest)


def unbalanced(w: Workspace) -> list[Expr]:
    """Return τ - h, less what prescribed accelerations take."""
    if w.prescribed.place:
        return _minus(list(w.state.tau), w.forces(w.prescribed.entered(w.zeros)))
    bias = rnea(w.recursion_tree, w.state.qd, w.zeros, w.unrotated_loads)
    known = zip(w.state.tau, w.pushes, bias, w.elastic.forces, strict=True)
    return [tau + force - load - pull for tau, force, load, pull in known]


def drives_recursive(w: Workspace) -> list[Expr]:
    """Return the drives, those of prescribed motions solved for."""
    if not w.prescribed.place:
        return list(w.state.tau)
    forces = w.forces(w.once(forward_crba))
    return [forces[k] if k in w.prescribed.place else tau for k, tau in enumerate(w.state.tau)]


SURE = (1.5, 4.5)
"""Pairs of a joint and an ancestor, a joint: up to the first CRBA is cheaper, from the second on ABA."""


def cheaper_forward(w: Workspace) -> str:
    """Return "aba" for long chains: factoring M costs a term for every pair of a joint and an ancestor, ABA does not.

    The counts cross before 2 pairs a joint for parallel axes, before 4.5 for crossed ones; in between both are counted.
    """
    if w.reduced.coupled or w.reduced.spherical_rotors or w.prescribed.place:
        return "crba"
    depth = [0]
    for i in w.reduced.outward():
        depth.append(depth[w.reduced.parent[i]] + 1)
    pairs = (sum(depth) - w.reduced.n) / max(1, w.reduced.n)
    if not SURE[0] < pairs < SURE[1]:
        return "aba" if pairs >= SURE[1] else "crba"
    varying = (*w.state.q, *w.state.qd, *w.state.tau)
    return "aba" if cost(w.once(forward_aba), varying) < cost(w.once(forward_crba), varying) else "crba"


def forward(w: Workspace) -> list[Expr]:
    """Return q̈ by CRBA or ABA, whichever is cheaper."""
    return w.once(forward_aba if w.once(cheaper_forward) == "aba" else forward_crba)


def christoffel_matrix(w: Workspace) -> list[Expr]:
    """Return C(q, u) of the Christoffel symbols of M by composite bodies."""
    return flat(w.composite_christoffel.coriolis_matrix(w.state.qd))


def cheaper_coriolis(w: Workspace) -> str:
    """Return "derivatives" where these take fewer operations than Christoffel symbols, as for seven crossed axes.

    No rule of a small tree's shape tells: branches and parallel axes decide. Both are derived on a graph of their own,
    since programs are written in the order in which nodes are born, and what is only counted must not change that.
    Beyond, symbols grow with the cube of the number of velocities: a chain of 16 takes 7,313 operations for 23,339.
    """
    if w.state.n > COUNTED:
        return "derivatives"
    other = Workspace(w.scene, w.closing)
    varying = (*other.state.q, *other.state.qd)
    rival, own = (cost(other.once(derive), varying) for derive in (coriolis_matrix, christoffel_matrix))
    return "derivatives" if rival < own else "crba"


def _carries_ball(w: Workspace) -> bool:
    """Return whether a joint carries a body whose velocities are no rates of coordinates, such as one on a ball."""
    return any(len(block) > 1 and w.tree.parent[block[0]] > 0 for block in w.tree.block)


def shorter_centrifugal(w: Workspace) -> str:
    """Return "rnea" where a joint carries a ball: in Christoffel symbols little of its brackets cancels."""
    return "rnea" if _carries_ball(w) else "crba"


def shorter_coriolis_times(w: Workspace) -> str:
    """Return "crba" for tops and short linkages: less than one body between a body and the ground, no ball carried.

    The matrix grows with the square of that number at least, the recursion does not.
    """
    between: dict[str, int] = {}
    for joint in w.scene.joints:
        between[joint.child] = between.get(joint.parent, -1) + joint.moves
    numbers = [between[joint.child] for joint in w.scene.joints if joint.moves]
    return "crba" if sum(numbers) < len(numbers) and not _carries_ball(w) else "rnea"


def _unit(w: Workspace, *moving: int) -> list[Expr]:
    return [w.graph.one if i in moving else w.graph.zero for i in range(w.state.n)]


def polarised_centrifugal(w: Workspace) -> list[Expr]:
    """Return k_D from c(q, q̇): column j is c at q̇ = e_j."""
    columns = [w.velocity_forces(_unit(w, j)) for j in range(w.state.n)]
    return [column[i] for i in range(w.state.n) for column in columns]


def polarised_coriolis(w: Workspace) -> list[Expr]:
    """Return k_C from c(q, q̇): column jk is c(e_j + e_k) - c(e_j) - c(e_k)."""
    alone = [w.velocity_forces(_unit(w, j)) for j in range(w.state.n)]
    columns = [
        _minus(_minus(w.velocity_forces(_unit(w, j, k)), alone[j]), alone[k])
        for j, k in combinations(range(w.state.n), 2)
    ]
    return [column[i] for i in range(w.state.n) for column in columns]


def polarised_matrix(w: Workspace) -> list[Expr]:
    """Return C(q, u) from k_D and k_C: C_ij = k_D[i,j] u_j + ½ Σ_k≠j k_C[i,jk] u_k + ½ Σ_kl γ^l_kj M_li u_k."""
    n = range(w.state.n)
    pairs = {pair: position for position, pair in enumerate(combinations(n, 2))}
    k_D, k_C = w.once(polarised_centrifugal), w.once(polarised_coriolis)
    entries = []
    for i in n:
        for j in n:
            mixed = (k_C[i * len(pairs) + pairs[min(j, k), max(j, k)]] * w.state.qd[k] for k in n if k != j)
            turned = (
                w.state.qd[k] * w.composite_mass[m][i] * value
                for k in n
                for m, value in w.directions.brackets.get((k, j), ())
            )
            half = (w.graph.total(mixed) + w.graph.total(turned)) / 2
            entries.append(k_D[i * w.state.n + j] * w.state.qd[j] + half)
    return entries


# Lagrange formulations


def lagrange_forward(w: Workspace) -> list[Expr]:
    """Return q̈ that solves Lagrange's equations."""
    given = w.prescribed
    alone = dict(zip(w.state.qdd, given.entered(w.zeros), strict=True))
    bias = substitute(w.energy.driving_forces(), alone)
    chain = range(-1, len(given.free))
    if given.place:
        return accelerations(given, chain, w.lagrange_mass, w.state.tau, bias)
    return solve(chain, w.lagrange_mass, _minus(list(w.state.tau), bias))


def drives_lagrange(w: Workspace) -> list[Expr]:
    """Return the drives by Lagrange's equations, those of prescribed motions solved for."""
    if not w.prescribed.place:
        return list(w.state.tau)
    moving = dict(zip(w.state.qdd, w.once(lagrange_forward), strict=True))
    forces = substitute(w.energy.driving_forces(), moving)
    return [forces[k] if k in w.prescribed.place else tau for k, tau in enumerate(w.state.tau)]


def lagrange_velocity_forces(w: Workspace) -> list[Expr]:
    """Return c = C(q, q̇) q̇ from Christoffel's symbols."""
    C = w.lagrange_christoffel.coriolis_matrix(w.state.qd)
    return [w.graph.dot(row, w.state.qd) for row in C]


class _Term(NamedTuple):
    """± sin(angle) factor, or with the cosine."""

    sign: int
    op: Op
    angle: Expr
    factor: Expr

    @property
    def turned(self) -> _Term:
        """The derivative by the angle, the factor held."""
        return self._replace(sign=-self.sign, op=Op.SIN) if self.op is Op.COS else self._replace(op=Op.COS)

    @property
    def negative(self) -> _Term:
        return self._replace(sign=-self.sign)

    @property
    def by_factor(self) -> Expr:
        circular = self.angle.graph.function(self.op, self.angle)
        return circular if self.sign > 0 else -circular


def turns(outputs: Sequence[Expr]) -> LocalPartials:
    """Return how to differentiate what `outputs` are made of: what has turned by its angle and by what it was before.

    Only what has its derivative by the angle among them is read so; all else is differentiated by its operands. Inputs
    have to be symbols or angles, for sines, cosines and their products are passed over.
    """
    nodes = reachable(outputs)
    there = {frozenset(terms): node for node in nodes for terms in _read(node)}

    def slopes(node: Expr) -> Iterable[tuple[Expr, Expr]]:
        for terms in _read(node):
            turned = frozenset(term.turned for term in terms)
            by_angle = there.get(turned)
            if by_angle is None and (against := there.get(frozenset(term.negative for term in turned))):
                by_angle = -against
            if by_angle is not None:  # last, so that what is turned anew stands side by side
                return [*((term.factor, term.by_factor) for term in terms), (terms[0].angle, by_angle)]
        return operands(node)

    return slopes


def _read(node: Expr) -> Iterator[tuple[_Term, ...]]:
    """Yield all ways to read a node as one or two products with sines and cosines of one angle."""
    if node.op in (Op.ADD, Op.SUB):
        signed = list(zip((1, -1 if node.op is Op.SUB else 1), node.args, strict=True))
    else:
        signed = [(1, node)]
    if all(one.op is Op.MUL for _, one in signed):
        ways = (
            [_Term(sign, x.op, x.args[0], y) for x, y in (one.args, one.args[::-1]) if x.op in (Op.SIN, Op.COS)]
            for sign, one in signed
        )
        yield from (terms for terms in product(*ways) if len({term.angle for term in terms}) == 1)
