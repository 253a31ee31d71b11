"""Newton's method for closed loops, how closed and how independent a position is, and words for constraint rows.

    r, R, G      residuals, their rates and the constraint rows: loop_numbers.py
    σ            singular values of G, made dimensionless by a characteristic length

Newton's step is the shortest one (the pseudo-inverse of R), so that redundant rows do no harm, and it is halved until
the residual falls. Where an axis has turned round the residual vanishes too, but its rate is no longer the power of the
joint's wrenches.

Rank, planarity, redundancy and zero rows are decided at generic configurations, closed positions away from the start:
a start is often special (straight, level, two angles equal), and a position that does not close the loops says nothing
about a mechanism that does.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops.constraint_rows import Label
from symdyn.dynamics.loops.sparse_rows import is_large, triangular
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, reachable
from symdyn.scene import Scene

if TYPE_CHECKING:
    from symdyn.dynamics.loops.loop_numbers import Numbers


def unbound(scene: Scene, entries: Sequence[Expr]) -> list[str]:
    """Return the names of the free parameters that entries depend on."""
    names = {node.value for node in reachable(entries) if node.op is Op.SYMBOL}
    return [parameter.name for parameter in scene.free_parameters if parameter.name in names]


def spoken(numbers: Numbers, q: Array) -> tuple[str, ...]:
    """Return what every row of G forbids: its owner, and a direction in the axes of the joint frame on the parent."""
    labels = numbers.constraints.labels
    wrenches = {k: one.wrench for k, one in enumerate(labels) if one.wrench is not None and not one.name}
    found = numbers.at([x for pair in wrenches.values() for part in pair for x in part], q).reshape(-1, 2, 3)
    known = dict(zip(wrenches, found, strict=True))

    def words(k: int, label: Label) -> str:
        if k not in known:
            return label.name or "constraint"
        force, moment = known[k]
        return in_words(force, moment if label.loop else np.zeros(3))  # a contact's acts where it touches

    return tuple(f"{one.owner}: {words(k, one)}" for k, one in enumerate(labels))


def missed(label: Label, numbers: Numbers, q: Array, by: float) -> str:
    """Return by how much a residual misses zero: "its gap along y is 25.8 m", "its direction about x is off by 0.3"."""
    assert label.wrench is not None, "a formula of the user has no residual"
    if label.is_rope:
        return f"its length is off by {by:.3g} m"
    force, moment = (numbers.at(part, q) for part in label.wrench)
    if np.abs(force).max() > 1e-12:
        return f"its gap along {direction_words(force)} is {by:.3g} m"
    return f"its direction about {direction_words(moment)} is off by {by:.3g}"


def in_words(force: Array, moment: Array) -> str:
    """Return a wrench in words, such as "force along x"."""
    if np.abs(force).max() > 1e-12:
        pitch = " with its moment" if np.abs(moment).max() > 1e-12 else ""
        return f"force along {direction_words(force)}{pitch}"
    return f"moment about {direction_words(moment)}"


def direction_words(vector: Array) -> str:
    """Return x, -x, y, .. where the vector lies along one, else its components."""
    unit = vector / np.linalg.norm(vector)
    for k, name in enumerate("xyz"):
        if abs(abs(unit[k]) - 1) < 1e-12:
            return name if unit[k] > 0 else f"-{name}"
    return "(" + ", ".join(f"{x + 0.0:.4g}" for x in unit) + ")"


CLOSED = 1e-9
"""Largest residual of a closed loop, over the size of the mechanism."""

STEPS, HALVINGS = 60, 12
WIDEST = 0.5  # radians that one step may turn a joint by, so that the branch of the guess is kept

NEGLIGIBLE = 1e-8
"""Singular values below it, over the largest, are zero."""

NOISE = 1e-6
"""The largest singular value below which all of them are rounding: entries of a dimensionless G are about 1."""

SHORT = 1e-9
"""Levers this much below the extent of the mechanism are rounding."""

CONFIGURATIONS, LEGS = 2, 2
"""How many generic configurations, and in how many legs each is come to."""

WIDE = 0.4
"""The longest leg, rad, or characteristic lengths."""

SHORTER = 6
"""How often a leg is halved until it leads to a closed position."""


def newton(numbers: Numbers, q: Array, locked: Sequence[int]) -> Array:
    """Return where Newton's method with line search ends, closed or not."""
    angular = numbers.angular_velocities
    free = np.array([k for k in range(numbers.state.n) if k not in set(locked)], dtype=int)
    r = numbers.residual(q)
    for _ in range(STEPS):
        size = float(r @ r)
        if not len(free) or not len(r) or size == 0.0:
            break
        step = np.zeros(numbers.state.n)
        step[free] = shortest(numbers.residual_rates(q)[:, free], -r, 1e-10)
        largest = float(np.max(np.abs(step[angular]), initial=0.0))
        if not np.isfinite(largest):
            break
        factor = min(1.0, WIDEST / largest) if largest else 1.0
        for _ in range(HALVINGS):
            tried = numbers.retract(q, factor * step)
            left = numbers.residual(tried)
            if float(left @ left) < size:
                break
            factor /= 2
        else:
            break
        q, r = tried, left
    return q


def lever_of(numbers: Numbers, q: Array) -> float:
    """Return the characteristic length: the largest lever in G; where none is, the extent of the mechanism, or 1 m."""
    levers, offsets = numbers.levers(q)
    extent = float(offsets.max(initial=0.0))
    largest = float(levers.max(initial=0.0))
    return largest if largest > SHORT * extent else extent or 1.0


# What was found


def open_loop(numbers: Numbers, q: Array) -> str | None:
    """Return why a position is not closed; None if it is."""
    r = np.abs(numbers.residual(q))
    if not len(r) or float(r.max()) <= CLOSED * max(1.0, lever_of(numbers, q)):
        return None
    k = int(r.argmax())
    label = numbers.constraints.labels[k]
    G = numbers.dimensionless(q, lever_of(numbers, q))
    rows = [k for k, row in enumerate(numbers.constraints.G) if not all(entry.is_zero for entry in row)]
    if rows and is_large(G[rows]):
        smallest = triangular(G[rows], NEGLIGIBLE).ends()[1]
    else:
        smallest = float(np.linalg.svd(G[rows], compute_uv=False).min(initial=np.inf if rows else 0.0))
    return (
        f"{label.words} cannot be assembled from this start: {missed(label, numbers, q, r[k])}, the smallest "
        f"singular value of the constraints there is {smallest:.3g}; give another start, or other lengths"
    )


def reversed_loop(numbers: Numbers, q: Array) -> str | None:
    """Return which loop has closed the wrong way round; None if none has."""
    off = np.abs(numbers.residual_rates(q) - numbers.jacobian(q)).max(axis=1, initial=0.0)
    allowed = 1e-4 * max(1.0, lever_of(numbers, q))
    for label, missed_by in zip(numbers.constraints.labels, off, strict=True):
        if label.loop and missed_by > allowed:
            return (
                f"the loop {label.owner} closes in the wrong direction from this start: its axis, or its frame, is "
                "reversed; give a start on the other branch, or turn one of its frames by 180 deg"
            )
    return None


def shortest(A: Array, b: Array, negligible: float) -> Array:
    """Return the shortest x for which A x misses b least; singular values that are negligible are zero."""
    working = A.any(axis=1)
    if is_large(A[working]):
        return triangular(A[working], negligible).shortest(b[working])
    return np.asarray(np.linalg.lstsq(A, b, rcond=negligible)[0])


@dataclass(frozen=True)
class Spectrum:
    """Singular values of a dimensionless G.

    Attributes:
        rank: how many are not zero.
        values: by their place, the largest first: all of them, or the first and the last that is not zero.
    """

    rank: int
    values: Mapping[int, float]

    def value(self, place: int) -> float:
        """Return one of them, 0 for one that is known to be nothing."""
        return self.values.get(place, 0.0)


def spectrum(numbers: Numbers, q: Array, length: float) -> Spectrum:
    """Return the singular values of the dimensionless G at a position."""
    G = numbers.dimensionless(q, length)
    working = G[G.any(axis=1)]
    if working.size and is_large(working):
        found = triangular(working, NEGLIGIBLE)
        largest, smallest = found.ends()
        return Spectrum(len(found.independent), {0: largest, len(found.independent) - 1: smallest})
    values = np.asarray(np.linalg.svd(G, compute_uv=False) if G.size else np.zeros(0))
    return Spectrum(rank_of(values), dict(enumerate(values.tolist())))


def rank_of(values: Array) -> int:
    """Return how many singular values of a dimensionless G are not zero."""
    return int(np.sum(values > NEGLIGIBLE * values.max(initial=NOISE))) if len(values) else 0


def free_motions(G: Array) -> Array:
    """Return an orthonormal basis of the motions that G leaves free, one a row."""
    if not G.size:
        return np.eye(G.shape[1])
    _, values, Vt = np.linalg.svd(G)
    return np.asarray(Vt[rank_of(values) :])


# Generic configurations


def generic_configurations(numbers: Numbers, q: Array, length: float) -> tuple[Array, ...]:
    """Return closed positions that are come to from a closed one along motions that the loops leave free.

    The mechanism is the one in quaternions: angles would hinder where they are singular.
    """
    return tuple(_wandered(numbers, q, length, seed) for seed in range(CONFIGURATIONS))


def _wandered(numbers: Numbers, q: Array, length: float, seed: int) -> Array:
    """Return where a walk in one direction ends, as straight as the loops allow; q itself where nothing moves."""
    rng = random.Random(f"{numbers.scene.name}:{seed}")
    scales = np.full(numbers.state.n, length)
    scales[numbers.angular_velocities] = 1.0
    way = np.array([rng.uniform(-1, 1) for _ in scales])
    for _ in range(LEGS):
        G = numbers.dimensionless(q, length)
        way = way - shortest(G, G @ way, 1e-8) if len(G) else way
        size = float(np.abs(way).max(initial=0.0))
        if size < 1e-6:  # the loops hold it
            break
        way = way / size
        q = _stepped(numbers, q, scales * way)
    return q


def _stepped(numbers: Numbers, q: Array, way: Array) -> Array:
    """Return the closed position after the largest step that leads to one; q where none does."""
    step = WIDE
    for _ in range(SHORTER):
        try:
            near = numbers.newton(numbers.retract(q, step * way), ())
            if numbers.is_closed(near):
                return near
        except DerivationError:  # a formula has no value there
            pass
        step /= 2
    return q
