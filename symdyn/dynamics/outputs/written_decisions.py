"""Decisions about closed mechanisms that are written into their equations, and whether they hold elsewhere.

Where a start is given for other values of the parameters, nothing is assembled: it is looked whether the decisions hold
there and a step away from there, and only where they may not are they made anew.

One of them is that loops hold dependent coordinates in proportion to independent ones, as parallelograms do, and rows
of them:

    q_d = T q_i + b,    u_d = T u_i        T, b constant

Such a mechanism passes its change points smoothly, where G_d is singular and the partitioned equations are 0/0: with
the constant T in place of -G_d⁻¹ G_i they hold there too, on the branch that the mechanism is assembled in. T and b are
read off the assembled position, b to the last digit of a double, and tried at random values of the independent
coordinates, all round: residuals and rows must vanish there.

Reference: Gonzalez, Dopico, Lugris and Cuadrado, A benchmarking system for MBS simulation software (2006), problem A02,
whose loops all meet a change point at once.
"""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops.loop_decisions import NOTHING, LoopDecisions, indeterminate_rows
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.loops.newton import CLOSED, free_motions, rank_of
from symdyn.dynamics.loops.partition import LoopChoices, Partition
from symdyn.dynamics.loops.reduction import Reduction, accelerations
from symdyn.dynamics.outputs.signal_outputs import multiplier_names
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, field, fields
from symdyn.graph import Expr, substitute
from symdyn.scene import Scene

SAME_RATIO = 1e-9
"""Ratios this near to a simple fraction are it."""

LARGEST = 12
"""Denominator of the ratios."""

TRIED = 6
CLOSED_ALL_ROUND = 1e-12
"""Largest residual at positions tried, over the size of the mechanism or a metre."""


@dataclass(frozen=True)
class LinearLoops:
    """Dependent coordinates in terms of the independent ones.

    Attributes:
        independent, dependent: places of velocities, ascending; coordinates have the same.
        T: ratios, by dependent and then independent velocity; what is missing is zero.
        b: offset of every dependent coordinate, rad or m.
    """

    independent: tuple[int, ...]
    dependent: tuple[int, ...]
    T: dict[int, dict[int, Fraction]] = field(hash=False)
    b: dict[int, Fraction] = field(hash=False)

    def followers(self, w: Workspace) -> dict[Expr, Expr]:
        """Return dependent coordinates and velocities as what they are in terms of independent ones."""
        graph, q, u = w.graph, w.state.q, w.state.qd
        found: dict[Expr, Expr] = {}
        for k in self.dependent:
            ratios = self.T[k].items()
            found[q[k]] = graph.total([*(x * q[j] for j, x in ratios), graph.constant(self.b[k])])
            found[u[k]] = graph.total(x * u[j] for j, x in ratios)
        return found

    def forward_dynamics(self, w: Workspace) -> list[Expr]:
        """Return u̇, shape (nv,), by independent coordinates and velocities: no division by what may vanish."""
        graph, n = w.graph, w.state.n
        T: list[dict[int, Expr]] = [{} for _ in range(n)]
        for j in self.independent:
            T[j][j] = graph.one
        for k, row in self.T.items():
            T[k] |= {j: graph.constant(x) for j, x in row.items()}
        still = (graph.zero,) * n
        values = self.followers(w)
        h = substitute(w.forces(list(still)), values)
        M = substitute([entry for row in w.composite_mass for entry in row], values)
        rows = [M[k : k + n] for k in range(0, n * n, n)]
        rest = [tau - force for tau, force in zip(w.state.tau, h, strict=True)]
        return accelerations(Reduction(self.independent, tuple(T), still), rows, rest)


def linear_loops(numbers: Numbers, decisions: LoopDecisions) -> LinearLoops | None:
    """Return how the loops of a scene hold its dependent coordinates, None where not in constant proportion."""
    state, scene = numbers.state, numbers.scene
    if not scene.loops or scene.constraints or scene.prescribed_velocities or state.rates != state.qd:
        return None
    i, d = list(decisions.partition.independent), list(decisions.partition.dependent)
    G = numbers.jacobian(np.array(decisions.assembly.regular))
    ratios = -np.linalg.lstsq(G[:, d], G[:, i], rcond=None)[0]
    simple = [[Fraction(float(x)).limit_denominator(LARGEST) for x in row] for row in ratios]
    if any(
        abs(float(x) - y) > SAME_RATIO
        for row, exact in zip(ratios, simple, strict=True)
        for y, x in zip(row, exact, strict=True)
    ):
        return None
    q, A = np.array(decisions.assembly.q), np.array([[float(x) for x in row] for row in simple]).reshape(len(d), len(i))
    b = q[d] - A @ q[i]
    size = max(1.0, decisions.assembly.length)
    rng = random.Random(scene.name)
    for _ in range(TRIED):
        q[i] = [rng.uniform(-np.pi, np.pi) for _ in i]
        q[d] = A @ q[i] + b
        rows = numbers.jacobian(q)
        missed = np.abs(rows[:, i] + rows[:, d] @ A).max(initial=0.0)
        if max(missed, np.abs(numbers.residual(q)).max(initial=0.0)) > CLOSED_ALL_ROUND * size:
            return None
    T = {k: {j: x for j, x in zip(i, row, strict=True) if x} for k, row in zip(d, simple, strict=True)}
    return LinearLoops(tuple(i), tuple(d), T, {k: Fraction(float(x)) for k, x in zip(d, b, strict=True)})


WORDS = {
    **dict.fromkeys(("independent_rows", "zero_rows", "redundant", "indeterminate"), "redundant rows"),
    **dict.fromkeys(("partition", "fails"), "independent velocities"),
    "actuated": "what the drives determine",
    "linear": "loops in proportion",
}

CLEAR = 0.03
"""Smallest singular value of G_d over the largest of G with which a choice of independent velocities is kept."""

AWAY, STEPS = 0.03, 4
"""Step, rad or characteristic lengths, after which redundant rows must still be redundant; Newton's steps there."""

LARGEST_RATIOS, SAME = 27720.0, 1e-4
"""The least multiple of 1 to 12, with which ratios of loops in proportion are whole, and how nearly."""


@dataclass(frozen=True)
class WrittenDecisions:
    """The decisions that are written into equations; a tree has none.

    Attributes:
        independent_rows, zero_rows, redundant, partition, fails, actuated: as of `LoopDecisions`.
        indeterminate: constraints whose multipliers are statically indeterminate.
        linear: how loops hold dependent coordinates in proportion, None where not.
        length: the characteristic length, m, at the values that they were made for.
        letters: names of the multipliers of the independent rows, as formulas and columns have them.
    """

    independent_rows: tuple[int, ...] = ()
    zero_rows: tuple[int, ...] = ()
    redundant: tuple[int, ...] = ()
    partition: Partition | None = None
    fails: bool = False
    actuated: Partition | None = None
    indeterminate: tuple[int, ...] = ()
    linear: LinearLoops | None = None
    length: float = field(default=1.0, compare=False)
    letters: tuple[str, ...] = field(default=(), compare=False)

    @classmethod
    def of(cls, numbers: Numbers, closing: LoopChoices) -> WrittenDecisions:
        """Return what is written of decisions about a mechanism; DerivationError where it cannot be assembled."""
        decisions, numbers = numbers.decided(closing)
        names = ("independent_rows", "zero_rows", "redundant", "partition", "fails", "actuated")
        unknown, linear = indeterminate_rows(numbers, decisions.assembly), linear_loops(numbers, decisions)
        found = {name: getattr(decisions, name) for name in names}
        letters = multiplier_names(numbers.scene, decisions, numbers, unknown)
        return cls(**found, indeterminate=unknown, linear=linear, length=decisions.assembly.length, letters=letters)

    def instead_of(self, other: WrittenDecisions) -> str:
        """Return what is said where values before have led to other decisions."""
        changed = [WORDS[f.name] for f in fields(self) if f.compare and getattr(self, f.name) != getattr(other, f.name)]
        words = " and ".join(dict.fromkeys(changed))
        return f"with these values numbers decide otherwise than before about {words}: the equations are written anew"

    def hold(self, numbers: Numbers, q: Array) -> bool:
        """Tell whether they, made for other values, hold for sure where a mechanism starts; False if they may not."""
        partition, length = self.partition, self.length
        if partition is None or self.linear is not None:
            return False
        try:
            here = numbers.dimensionless(q, length)
            if not (numbers.is_closed(q) and _fit(self, here, numbers.scene)):
                return False
            free = free_motions(here)
            if not len(free):
                return True
            scales = np.full(numbers.state.n, length)
            scales[numbers.angular_velocities] = 1.0
            away = numbers.retract(q, AWAY * scales * free.sum(axis=0))
            for _ in range(STEPS):
                r = numbers.residual(away)
                if np.abs(r).max(initial=0.0) <= CLOSED * max(1.0, length):
                    return _fit(self, numbers.dimensionless(away, length), numbers.scene)
                step = np.asarray(np.linalg.lstsq(numbers.residual_rates(away), -r, rcond=1e-10)[0], dtype=np.float64)
                away = numbers.retract(away, step)
        except DerivationError:  # a formula has no value there
            pass
        return False


def _fit(decisions: WrittenDecisions, G: Array, scene: Scene) -> bool:
    """Tell whether the zero rows vanish, the independent ones are so, and all others depend on them."""
    assert decisions.partition is not None, "it was looked"
    basis, dependent = G[list(decisions.independent_rows)], list(decisions.partition.dependent)
    if np.abs(G[list(decisions.zero_rows)]).max(initial=0.0) > NOTHING or rank_of(singular(G)) != len(basis):
        return False
    if not dependent:
        return True
    chosen = singular(basis[:, dependent])
    if chosen[-1] < CLEAR * singular(basis)[0]:
        return False
    if scene.constraints:  # holds no coordinates in proportion
        return True
    ratios = np.linalg.solve(basis[:, dependent], np.delete(basis, dependent, axis=1))
    return not np.all(np.abs(LARGEST_RATIOS * ratios - np.round(LARGEST_RATIOS * ratios)) < SAME)


def singular(G: Array) -> Array:
    """Return the singular values of a matrix, descending; none of one without entries."""
    return np.asarray(np.linalg.svd(G, compute_uv=False) if G.size else np.zeros(0))
