"""What is decided about closed loops before their equations are written, once, at assembled positions.

    rows           an independent set of constraint rows, those of G; zero rows (a planar loop's out of its plane) and
                   rows that depend on others are redundant
    partition      independent and dependent velocities: G_d u_d = -G_i u_i

What a mechanism is in general, its rank and its zero rows, two generic configurations decide; the start may be special,
and is compared with them. Constraint rows and dependent velocities are chosen by pivots (Gram-Schmidt, the largest
remainder first), so that the square matrix G_d is as far from singular as a choice can make it at the start, or at a
generic configuration where the start has less rank. The choice is static: the generated code divides by determinants of
blocks, which vanish where the dependent velocities are determined no more. Without loops any position can be come to,
and velocities that are determined at all of them go first: a disc that rolls turns its axes through.

Reference: Wehage and Haug, Generalized coordinate partitioning for dimension reduction in analysis of constrained
dynamic systems, J. Mechanical Design 104 (1982).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops import sparse_rows
from symdyn.dynamics.loops.assembly import Assembly
from symdyn.dynamics.loops.newton import NEGLIGIBLE, NOISE, spoken
from symdyn.dynamics.loops.partition import LoopChoices, Partition, blocks, drives_of, over_actuated
from symdyn.dynamics.loops.sparse_rows import is_large, triangular
from symdyn.errors import DerivationError, choice, listed
from symdyn.frozen import dataclass
from symdyn.scene import Scene

if TYPE_CHECKING:
    from symdyn.dynamics.loops.loop_numbers import Numbers

EVEN = 0.9
"""Pivots this close to the largest are as good: of them the first is taken, so that rounding does not choose."""

POSITIONS, SURE = 16, 0.2
"""Random positions without loops, and the smallest singular value of G_d over the largest of G that will do at all."""

CHOICES = 1000
"""Sets of dependent velocities that are tried at all these positions."""

NOTHING = 1e-9
"""Rows this much below the largest have no effect."""

INVOLVED = 1e-7
"""Shares of a row in a relation of rows, of unit length, below it are zero."""

WEAK = 0.02
"""Velocities with drives become dependent where the others would leave a pivot this much below the largest."""


@dataclass(frozen=True)
class LoopDecisions:
    """The decisions.

    Attributes:
        assembly: the position that they were made at.
        independent_rows: an independent set of constraint rows, ascending; no matter which velocities are independent.
        zero_rows: rows that are identically zero.
        redundant: other rows, which depend on the independent ones.
        names: what each row is, in words, shape (all rows,).
        partition: of forward dynamics.
        fails: whether, without loops, its dependent velocities are undetermined at some positions, so that equations
            take all rows at once: a blade has a heading at which the velocity along x is none of its own.
        actuated: of inverse dynamics, velocities with drives or prescribed motions independent; None where none fits.
        fault: why there is none, and inverse dynamics is not unique.
    """

    assembly: Assembly
    independent_rows: tuple[int, ...]
    zero_rows: tuple[int, ...]
    redundant: tuple[int, ...]
    names: tuple[str, ...]
    partition: Partition
    fails: bool
    actuated: Partition | None
    fault: str = ""


def loop_decisions_at(numbers: Numbers, assembly: Assembly, closing: LoopChoices) -> LoopDecisions:
    """Return the decisions at an assembled position.

    Raises:
        DerivationError: angles are singular at every position, or the user's independent coordinates do not fit.
    """
    singular = numbers.singular_angles(np.array(assembly.regular), everywhere=True)
    if singular:
        raise DerivationError(f"{numbers.scene.name}: {singular}")
    found = [numbers.dimensionless(np.array(q), assembly.length) for q in (assembly.regular, *assembly.configurations)]
    sizes = np.max([np.abs(G).max(axis=1, initial=0.0) for G in found], axis=0)
    zero_rows = tuple(k for k, size in enumerate(sizes) if size <= NOTHING * sizes.max(initial=NOISE))
    some = [k for k in range(len(sizes)) if k not in set(zero_rows)]
    G = found[0]
    basis = tuple(sorted(some[i] for i in pivots(unit_rows(G[some]), [list(range(len(some)))], assembly.rank)[0]))
    names = spoken(numbers, np.array(assembly.regular))
    choices = [one[list(basis)] for one in found]
    partition = _partition(numbers, basis, choices, closing.independent, assembly.length)
    fails = not closing.independent and _fails(numbers, basis, choices[0], partition.dependent, assembly.length)
    actuated, fault = _actuated(numbers, basis, choices, partition)
    redundant = tuple(k for k in some if k not in basis)
    return LoopDecisions(assembly, basis, zero_rows, redundant, names, partition, fails, actuated, fault)


def indeterminate_rows(numbers: Numbers, assembly: Assembly) -> tuple[int, ...]:
    """Return the rows with indeterminate multipliers, those that a λ with Gᵀ λ = 0 changes somewhere.

    Generic configurations decide, since at a start a relation may leave a row out.
    """
    indeterminate = np.zeros(len(numbers.constraints.labels), dtype=bool)
    for q in map(np.array, (assembly.regular, *assembly.configurations)):
        G = numbers.dimensionless(q, assembly.length)
        working = np.flatnonzero(G.any(axis=1))
        if is_large(G[working]):
            found = triangular(G[working], NEGLIGIBLE)
            shares = found.relations()
            scales = 1.0 / np.sqrt(1.0 + np.square(shares).sum(axis=1))
            indeterminate[np.setdiff1d(np.arange(len(G)), working)] = True
            indeterminate[working[list(found.dependent)]] = True
            largest = np.abs(shares * scales[:, None]).max(axis=0, initial=0.0)
            indeterminate[working[list(found.independent)]] |= largest > INVOLVED
            continue
        U, _, _ = np.linalg.svd(G)
        indeterminate |= np.abs(U[:, assembly.rank :]).max(axis=1, initial=0.0) > INVOLVED
    return tuple(np.flatnonzero(indeterminate).tolist())


def pivots(rows: Array, stages: Sequence[Sequence[int]], count: int) -> tuple[list[int], float]:
    """Return `count` rows, of shape (k, n), as independent as can be, and the smallest pivot over the largest.

    The next stage of those to choose from comes when a stage has only weak ones left.
    """
    if is_large(rows):
        chosen, sizes = sparse_rows.pivots(rows, stages, count, WEAK)
        return chosen, _quality(chosen, sizes, count)
    left = rows.copy()
    chosen, sizes = [], []
    top = float(np.linalg.norm(rows, axis=1).max(initial=0.0))
    for place, stage in enumerate(stages):
        weakest = WEAK * top if place + 1 < len(stages) else 0.0
        while len(chosen) < count:
            open_ones = [k for k in stage if k not in chosen]
            lengths = np.linalg.norm(left[open_ones], axis=1)
            best = float(lengths.max(initial=0.0))
            if best <= weakest:
                break
            k = open_ones[int(np.argmax(lengths >= EVEN * best))]
            e = left[k] / np.linalg.norm(left[k])
            left = left - np.outer(left @ e, e)
            chosen.append(k)
            sizes.append(best)
    return chosen, _quality(chosen, sizes, count)


def _quality(chosen: Sequence[int], sizes: Sequence[float], count: int) -> float:
    """Return the smallest pivot over the largest, 0 where there are too few."""
    return min(sizes, default=1.0) / (max(sizes, default=1.0) or 1.0) if len(chosen) == count else 0.0


def unit_rows(G: Array) -> Array:
    """Return rows of unit length; one of rounding errors, which is zero in fact, stays small."""
    lengths = np.linalg.norm(G, axis=1, keepdims=True)
    return np.asarray(G / np.maximum(lengths, NOTHING * lengths.max(initial=0.0) or 1.0))


# Partitions


def _partition(
    numbers: Numbers, basis: Sequence[int], choices: Sequence[Array], requested: Sequence[str], length: float
) -> Partition:
    """Return the user's partition, or the one that conditioning chooses, those with drives independent if they can be.

    The `choices` are the rows of the `basis` where it is made, and at generic ones; dimensionless, shape (m, n).
    """
    scene, n, m = numbers.scene, numbers.state.n, len(basis)
    if requested:
        return _made(numbers, basis, _wanted(scene, requested, choices[0]))
    prescribed = scene.prescribed_velocities
    every = [k for k in reversed(range(n)) if k not in prescribed]  # of equals, those near the ground stay independent
    passive = [k for k in every if not scene.drives[k]]
    sure = _sure(numbers, basis, choices[0], passive, length)
    if sure:
        return _made(numbers, basis, [k for k in range(n) if k not in sure])
    chosen = _dependent(choices, [passive, every] if len(passive) < len(every) else [every])
    if chosen is None:
        names = ", ".join(joint.name for joint in scene.joints if joint.motion is not None)
        raise DerivationError(
            f"{scene.name}: the loops do not let the joints {names} follow their prescribed motions independently; "
            f"leave {n - m} of them prescribed at most"
            if names
            else f"{scene.name}: no velocities determine the others at any closed position that was found; give a start"
        )
    return _made(numbers, basis, [k for k in range(n) if k not in chosen])


def _dependent(choices: Sequence[Array], stages: Sequence[Sequence[int]]) -> list[int] | None:
    """Return velocities that constraint rows determine, chosen at the first position where they do, None if nowhere."""
    for G in choices:
        chosen, quality = pivots(G.T, stages, len(G))
        if quality > NEGLIGIBLE:
            return chosen
    return None


def _sure(numbers: Numbers, basis: Sequence[int], G: Array, among: Sequence[int], length: float) -> tuple[int, ...]:
    """Return dependent velocities that rows without loops determine at every position best, () if none do it well."""
    m = len(basis)
    if numbers.scene.loops or not 0 < m <= len(among) or comb(len(among), m) > CHOICES:
        return ()
    rows = _drawn(numbers, basis, G, length)
    if rows is None:
        return ()
    top = float(np.linalg.svd(rows, compute_uv=False).max())
    choices = list(combinations(among, m))
    worst = [float(np.linalg.svd(rows[:, :, list(one)], compute_uv=False).min()) for one in choices]
    best = max(worst)
    if best <= SURE * top:
        return ()
    return next(one for one, value in zip(choices, worst, strict=True) if value >= EVEN * best)


def _fails(numbers: Numbers, basis: Sequence[int], G: Array, dependent: Sequence[int], length: float) -> bool:
    """Whether constraint rows without loops leave dependent velocities nearly undetermined at some position."""
    rows = None if numbers.scene.loops or not basis else _drawn(numbers, basis, G, length)
    if rows is None:
        return False
    top = float(np.linalg.svd(rows, compute_uv=False).max())
    return bool(np.linalg.svd(rows[:, :, list(dependent)], compute_uv=False).min() <= SURE * top)


def _drawn(numbers: Numbers, basis: Sequence[int], G: Array, length: float) -> Array | None:
    """Return rows at a position, G, and at random ones, shape (positions, m, n); None where some have none."""
    try:
        drawn = [numbers.dimensionless(numbers.drawn(seed), length)[list(basis)] for seed in range(POSITIONS)]
    except DerivationError:  # a formula has no value somewhere
        return None
    return np.stack([G, *drawn])


def _wanted(scene: Scene, requested: Sequence[str], G: Array) -> list[int]:
    m, n = G.shape
    velocities = list(scene.velocities)
    known = {name: k for k, name in enumerate(velocities)} | {
        name.removesuffix("_dot"): k for k, name in enumerate(velocities)
    }
    for name in requested:
        if name not in known:
            told = choice(name, velocities)
            raise DerivationError(f"{scene.name}: independent: there is no velocity {name!r}; {told}")
    independent = list(dict.fromkeys(known[name] for name in requested))
    freedoms = f"{n - m} degree{'s' * (n - m != 1)} of freedom"
    if len(independent) != n - m:
        raise DerivationError(f"{scene.name}: independent: {', '.join(requested)} given, but it has {freedoms}")
    forgotten = [velocities[k] for k in scene.prescribed_velocities if k not in independent]
    if forgotten:
        raise DerivationError(f"{scene.name}: independent: {', '.join(forgotten)} are prescribed, so add them")
    dependent = [k for k in range(n) if k not in independent]
    values = np.linalg.svd(G[:, dependent], compute_uv=False)
    if m and values[-1] <= NEGLIGIBLE * values[0]:
        better = [k for k in range(n) if k not in pivots(G.T, [range(n - 1, -1, -1)], m)[0]]
        names = ", ".join(velocities[k].removesuffix("_dot") for k in better)
        raise DerivationError(
            f"{scene.name}: independent: {', '.join(requested)} do not determine the other velocities at the assembled "
            f"position, the smallest singular value is {values[-1]:.3g}; {names} would"
        )
    return independent


def _actuated(
    numbers: Numbers, basis: Sequence[int], choices: Sequence[Array], partition: Partition
) -> tuple[Partition | None, str]:
    """Return the partition of inverse dynamics, or why there is none."""
    scene, n, m = numbers.scene, numbers.state.n, len(basis)
    actuated = scene.actuated_velocities
    if set(actuated) <= set(partition.independent):
        return partition, ""
    free = n - m
    if len(actuated) > free:
        return None, over_actuated(scene, free)
    chosen = _dependent(choices, [[k for k in reversed(range(n)) if k not in actuated]])
    if chosen is None:
        if held := _held(numbers, basis, choices[-1], actuated):
            return None, held
        against = f"the drives {drives_of(scene, actuated)} work against each other"
        return None, f"{against}, where {free} degrees of freedom remain; drive other joints"
    return _made(numbers, basis, [k for k in range(n) if k not in chosen]), ""


def _held(numbers: Numbers, basis: Sequence[int], G: Array, actuated: Sequence[int]) -> str:
    """Return what lets a driven velocity not move, and which; "" where each can move alone."""
    ties = [numbers.constraints.labels[k].words for k in basis]
    sets = {words: [k for k, one in enumerate(ties) if one == words] for words in ties}
    for words, rows in {**sets, f"{listed(sets)} together": [*range(len(G))]}.items():
        fixed = np.linalg.pinv(G[rows]) @ G[rows]
        for k in (k for k in actuated if fixed[k, k] > 1.0 - INVOLVED):
            name, what = numbers.scene.velocities[k].removesuffix("_dot"), drives_of(numbers.scene, [k])
            return f"{name}, which {what} drives, is held by {words}; correct what it joins, or drive other joints"
    return ""


def _made(numbers: Numbers, basis: Sequence[int], independent: Sequence[int]) -> Partition:
    dependent = [k for k in range(numbers.state.n) if k not in set(independent)]
    rows = [numbers.constraints.G[k] for k in basis]
    uses = [[k for k in dependent if not row[k].is_zero] for row in rows]
    return Partition(tuple(independent), tuple(dependent), tuple(blocks(uses)))
