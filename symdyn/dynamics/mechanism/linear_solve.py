"""Linear equations with many right sides, solved in rows: what code may go over in a loop of vectors, column by column.

    x_t := s x_t - Σ_k f_k x_k

Right sides stand side by side, so that a step takes one number from the left and does the same to all columns. Steps
run in order, and so do the terms of each, as lines would have them; a row that is not given starts at zero.

M q̈ = b is solved by M = Lᵀ D L, without square roots and without fill-in between branches. Elimination starts at the
tips, so that L keeps the zeros of M: row i has entries for the ancestors of joint i only. No pivot is zero everywhere:
that is looked at over a finite field, where x - x in disguise is zero too. A value that is not zero proves that the
function is not: where it vanishes at random points of a field of more than 2^126 elements, it vanishes identically, but
for a chance of about degree / 2^126 a point (see `symdyn.algebra.finite_field`).

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 6.5, tables 6.3 and 6.4.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import isqrt
from random import Random

from symdyn.algebra import FiniteField, Needs, Redraw
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op, reachable
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import spell


@dataclass(frozen=True)
class RowStep:
    """One row after another one."""

    row: int  # t, which row becomes another one
    scale: Expr  # s, by what it is multiplied before
    terms: tuple[tuple[Expr, int], ...]  # (f_k, k), what is taken away, in order


@dataclass(frozen=True, eq=False)
class RowSolve:
    """A matrix whose rows begin with rows of a solution.

    Attributes:
        scene: whose parameters its entries hold.
        sides: right sides and the row that each is before the first step, all of one width; other rows start at zero.
        rows: how many rows there are: those of the result, then more.
        steps: in order.
        beside: entries of the result, row by row, that are no part of the solution; None for those that are.
        switched: whether a state may have many factors that are zero, so that looking pays.
        turned: of a square result that is its rows plus the same, turned: what is added there, by places; None else.
    """

    scene: Scene
    sides: tuple[tuple[int, tuple[Expr, ...]], ...]
    rows: int
    steps: tuple[RowStep, ...]
    beside: tuple[tuple[Expr | None, ...], ...]
    switched: bool = False
    turned: tuple[tuple[int, Expr], ...] | None = None

    @property
    def width(self) -> int:
        return len(self.sides[0][1])

    @property
    def dense(self) -> int:
        """How many products of factors and entries of rows all steps take."""
        return self.width * sum(len(step.terms) for step in self.steps)

    @property
    def products(self) -> int:
        """How many of them do not vanish, which is what lines hold."""
        filled = dict.fromkeys(range(self.rows), 0)  # columns of each row that do not vanish, a bit each
        filled |= {row: sum(1 << c for c, x in enumerate(side) if not x.is_zero) for row, side in self.sides}
        count = 0
        for step in self.steps:
            for row in (row for factor, row in step.terms if not factor.is_zero):
                count += filled[row].bit_count()
                filled[step.row] |= filled[row]
        return count

    @property
    def factors(self) -> tuple[Expr, ...]:
        """What rows are multiplied by, each once, in the order in which it is first taken."""
        all_of_it = (one for step in self.steps for one in (step.scale, *(factor for factor, _ in step.terms)))
        return tuple(dict.fromkeys(all_of_it))

    @staticmethod
    def added(rows: Sequence[Expr], more: Iterable[tuple[int, Expr]]) -> list[Expr]:
        """Return the entries of a square matrix plus the same, turned, and plus `more` at some places."""
        N = isqrt(len(rows))
        found = [rows[N * i + j] + rows[N * j + i] for i in range(N) for j in range(N)]
        for place, entry in more:
            found[place] = found[place] + entry
        return found

    @staticmethod
    def stepped(x: Expr, scale: Expr, taken: Iterable[tuple[Expr, Expr]]) -> Expr:
        """Return s x - Σ f y of one column, in order; zeros are not taken away, and nothing is multiplied by one."""
        if not (scale == scale.graph.one or x.is_zero):
            x = scale * x
        for factor, y in taken:
            if not (factor.is_zero or y.is_zero):
                x = -(factor * y) if x.is_zero else x - factor * y
        return x


POINTS = 2
"""Points at which a function that is zero everywhere is seen to be."""

DRAWS = 40
"""Points that are tried until every root under the function exists in the field."""


def vanishes(node: Expr) -> bool:
    """Tell whether a node is zero for all values of its symbols, wherever it has one.

    What has no value at any point that is tried (a root that exists nowhere in the field) is not called zero.
    """
    if node.is_zero or node.op in (Op.CONSTANT, Op.PI, Op.SYMBOL):
        return node.is_zero
    known = node.graph.found.setdefault("zero everywhere", {})
    if node not in known:
        values = _points(node.graph).values(node)
        known[node] = next(values, 1) == 0 and next(values, 1) == 0
    return bool(known[node])


def _points(graph: Graph) -> _Points:
    """Return the points of a graph, which keep the values that are known there."""
    kept: dict[Expr, _Points] = graph.found.setdefault("points of a field", {})
    if graph.zero not in kept:
        kept[graph.zero] = _Points()
    return kept[graph.zero]


class _Points:
    """Points of one field, with the values of nodes there; begun anew where nodes need more of the field."""

    def __init__(self) -> None:
        self._needs = Needs.of(())
        self._begin()

    def _begin(self) -> None:
        self._prime = self._needs.prime(1)
        self._at: list[tuple[FiniteField, dict[Expr, int]]] = []

    def values(self, node: Expr) -> Iterator[int]:
        """Yield the values of a node at up to POINTS points where it has one."""
        self._meet(node)
        seen = 0
        for k in range(DRAWS):
            if k == len(self._at):
                self._at.append((FiniteField(self._prime, k, self._needs), {}))
            try:
                yield self._value(node, *self._at[k])
            except Redraw:
                continue
            seen += 1
            if seen == POINTS:
                return

    def _meet(self, node: Expr) -> None:
        """Take a field that offers what the node needs."""
        known, have = self._at[0][1] if self._at else {}, self._needs
        want = Needs.of(reachable([node], known))
        divides = have.turn % want.turn == 0 and have.radian % want.radian == 0 and have.atom % want.atom == 0
        if not (divides and set(want.radicands) <= set(have.radicands)):
            self._needs = Needs.of(reachable([node, *known]))
            self._begin()

    @staticmethod
    def _value(node: Expr, field: FiniteField, known: dict[Expr, int]) -> int:
        rng, order = Random(), reachable([node], known)
        for one in order:
            if one.op is Op.SYMBOL and one not in known:
                rng.seed(f"{field.seed}:{one.value}")
                known[one] = rng.randrange(field.p)
        return field.evaluate([node], known, order)[0]


def solve(parent: Sequence[int], M: list[list[Expr]], b: Sequence[Expr]) -> list[Expr]:
    """Return M⁻¹ b, shape (n,), of a symmetric M, shape (n, n); Singular where a pivot is zero everywhere.

    Of the moving bodies 1..n parent[i] < i, entry 0 unused: M[i-1][j-1] is zero unless one of i, j is an ancestor of
    the other. A chain (0, 0, 1, 2, …) promises nothing.
    """
    n = len(b)
    H = [list(row) for row in M]
    for k in range(n, 0, -1):
        pivot = H[k - 1][k - 1]
        if vanishes(pivot):
            raise Singular(k - 1)
        for i in _path(parent, parent[k]):
            if H[k - 1][i - 1].is_zero:
                continue
            a = H[k - 1][i - 1] / pivot
            for j in _path(parent, i):
                H[i - 1][j - 1] = H[i - 1][j - 1] - a * H[k - 1][j - 1]
            H[k - 1][i - 1] = a
    x = list(b)
    for i in range(n, 0, -1):  # Lᵀ y = b
        for j in _path(parent, parent[i]):
            x[j - 1] = x[j - 1] - H[i - 1][j - 1] * x[i - 1]
    x = [x[i] / H[i][i] for i in range(n)]  # D z = y
    for i in range(1, n + 1):  # L x = z
        for j in _path(parent, parent[i]):
            x[i - 1] = x[i - 1] - H[i - 1][j - 1] * x[j - 1]
    return x


@dataclass(frozen=True)
class Factored:
    """M = Lᵀ D L, for many right sides: one reciprocal a pivot in place of a division an entry."""

    graph: Graph  # where the entries live
    parent: Sequence[int]  # as for `solve`
    L: list[list[Expr]]  # entries below the diagonal, row by row; what stands above is no part, and D on it
    reciprocal: list[Expr]  # 1/D

    @property
    def pivots(self) -> list[Expr]:
        return [row[k] for k, row in enumerate(self.L)]

    def solve(self, rows: Sequence[Sequence[Expr]]) -> list[list[Expr]]:
        """Return M⁻¹ times rows, shape (n, m), all columns in step."""
        return self.outward(self.scaled(self.inward(rows)))

    def inward(self, rows: Sequence[Sequence[Expr]]) -> list[list[Expr]]:
        """Return Y with Lᵀ Y = B."""
        x = [list(row) for row in rows]
        for i in range(len(x), 0, -1):
            for j in _path(self.parent, self.parent[i]):
                x[j - 1] = self._less(x[j - 1], i, j, x[i - 1])
        return x

    def scaled(self, rows: Sequence[Sequence[Expr]]) -> list[list[Expr]]:
        """Return Z with D Z = Y."""
        return [[entry * d for entry in row] for row, d in zip(rows, self.reciprocal, strict=True)]

    def outward(self, rows: Sequence[Sequence[Expr]]) -> list[list[Expr]]:
        """Return X with L X = Z."""
        x = [list(row) for row in rows]
        for i in range(1, len(x) + 1):
            for j in _path(self.parent, self.parent[i]):
                x[i - 1] = self._less(x[i - 1], i, j, x[j - 1])
        return x

    def steps(self, at: Sequence[int]) -> tuple[RowStep, ...]:
        """Return the steps of `solve` of rows at places, each with all that is taken from it, what was found last at
        the end: so the sum of a row need not wait for it from the start.
        """  # noqa: D205
        found = (*self.inward_steps(), *self.outward_steps())
        return tuple(RowStep(at[s.row], s.scale, tuple((f, at[k]) for f, k in s.terms)) for s in found)

    def inward_steps(self) -> tuple[RowStep, ...]:
        n, one = range(1, len(self.reciprocal) + 1), self.graph.one
        up = {j: [(i, j) for i in reversed(n) if j in _path(self.parent, self.parent[i])] for j in n}
        found = (RowStep(j - 1, one, self._terms(up[j], 0)) for j in reversed(n))
        return tuple(step for step in found if step.terms)

    def outward_steps(self) -> tuple[RowStep, ...]:
        n = range(1, len(self.reciprocal) + 1)
        down = {i: [(i, j) for j in reversed(_path(self.parent, self.parent[i]))] for i in n}
        return tuple(RowStep(i - 1, self.reciprocal[i - 1], self._terms(down[i], 1)) for i in n)

    def _terms(self, pairs: Sequence[tuple[int, int]], other: int) -> tuple[tuple[Expr, int], ...]:
        """Return the factors at pairs of places, and which row each multiplies."""
        factors = ((self.L[pair[0] - 1][pair[1] - 1], pair[other] - 1) for pair in pairs)
        return tuple((factor, row) for factor, row in factors if not factor.is_zero)

    def _less(self, row: list[Expr], i: int, j: int, other: list[Expr]) -> list[Expr]:
        factor = self.L[i - 1][j - 1]
        return row if factor.is_zero else [a - factor * b for a, b in zip(row, other, strict=True)]

    def inverse(self) -> list[list[Expr]]:
        """Return M⁻¹ = L⁻¹ D⁻¹ L⁻ᵀ, one node for each pair of entries that are equal."""
        n = range(len(self.reciprocal))
        Y = [[self.graph.one if i == j else self.graph.zero for j in n] for i in n]
        for i in n:  # Y = L⁻¹
            for j in _path(self.parent, self.parent[i + 1]):
                Y[i] = self._less(Y[i], i + 1, j, Y[j - 1])
        Z = [[entry * d for entry, d in zip(row, self.reciprocal, strict=True)] for row in Y]
        lower = [[self.graph.dot(Z[i], Y[j]) for j in n[: i + 1]] for i in n]
        return [[lower[max(i, j)][min(i, j)] for j in n] for i in n]


def factored(graph: Graph, parent: Sequence[int], M: list[list[Expr]]) -> Factored:
    """Return the factors of a matrix as `solve` takes it; Singular where a pivot is zero everywhere."""
    L, reciprocal = [list(row) for row in M], []
    for k in range(len(M), 0, -1):
        if vanishes(L[k - 1][k - 1]):
            raise Singular(k - 1)
        reciprocal.append(1 / L[k - 1][k - 1])
        for i in _path(parent, parent[k]):
            if L[k - 1][i - 1].is_zero:
                continue
            a = L[k - 1][i - 1] * reciprocal[-1]
            for j in _path(parent, i):
                L[i - 1][j - 1] = L[i - 1][j - 1] - a * L[k - 1][j - 1]
            L[k - 1][i - 1] = a
    return Factored(graph, parent, L, reciprocal[::-1])


def _path(parent: Sequence[int], i: int) -> list[int]:
    """Return i and its ancestors, down to the last moving body."""
    bodies = []
    while i > 0:
        bodies.append(i)
        i = parent[i]
    return bodies


class Singular(DerivationError):  # noqa: N818  what the matrix is
    """A mass matrix that is singular.

    Attributes:
        velocity: index of the row where elimination ends; of a tree's mass matrix, a velocity that moves no mass.
    """

    def __init__(self, velocity: int) -> None:
        self.velocity = velocity
        super().__init__(
            "forward dynamics does not exist: the mass matrix is singular; give every body that ends a branch a mass "
            "or an inertia"
        )


def moves_no_mass(scene: Scene, velocity: int, of: str = "") -> str:
    """Return the message for a singular mass matrix `of` something: which joint and body to look at."""
    joint = next(joint for joint in scene.joints if scene.velocities[velocity] in joint.rates)
    axis = f"[{', '.join(map(spell, joint.axis))}]"
    unsaid = " (that of a joint without axis)" * (axis == "[0, 0, 1]")
    turns = JOINTS[joint.type].velocities(joint) == ("rad",)
    needed = f" off the axis {axis}{unsaid} or an inertia about it" if turns else " or an inertia"
    return (
        f"{scene.name}: forward dynamics does not exist: a motion of the joint {joint.name}, which carries "
        f"{joint.child}, moves no mass, so that the mass matrix{of} is singular; give {joint.child} a mass"
        f"{needed}, or fix the joint"
    )


# By latency, which is what scalar code waits for: a product or a sum takes 4 cycles, a division about 15, a pair of
# sines about 80. At 8 a division, nearer to what vector units take, all examples and counted robots choose alike.
