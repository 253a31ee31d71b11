"""Closed positions away from the start, where a mechanism shows what it is in general.

Rank, planarity, redundancy and rows without effect are decided there: a start is often special (straight, level, two
angles equal), and a position that does not close the loops says nothing about a mechanism that does.
"""

from __future__ import annotations

import random

import numpy as np

from symdyn.dynamics.loops.loop_numbers import Array, Numbers
from symdyn.dynamics.loops.newton import dimensionless, newton, seen_closed, turns_of
from symdyn.errors import DerivationError

PLACES, STEPS = 2, 2
"""How many positions, and in how many steps each is come to."""

WIDE = 0.4
"""The largest part of a step, rad, or characteristic lengths."""

HALVINGS = 6


def generic_places(numbers: Numbers, q: Array, length: float) -> tuple[Array, ...]:
    """Return closed positions that are come to from a closed one along motions that the loops leave free.

    Args:
        numbers: the mechanism, without angles, which would hinder where they are singular.
        q: a closed position.
        length: the characteristic length, m.
    """
    return tuple(_wandered(numbers, q, length, seed) for seed in range(PLACES))


def _wandered(numbers: Numbers, q: Array, length: float, seed: int) -> Array:
    """Return where a walk in one direction ends, as straight as the loops allow; q itself where nothing moves."""
    rng = random.Random(f"{numbers.scene.name}:{seed}")
    scales = np.full(numbers.state.n, length)
    scales[turns_of(numbers)] = 1.0
    way = np.array([rng.uniform(-1, 1) for _ in scales])
    for _ in range(STEPS):
        G = dimensionless(numbers, q, length)
        way = way - np.linalg.lstsq(G, G @ way, rcond=1e-8)[0] if len(G) else way
        size = float(np.abs(way).max(initial=0.0))
        if size < 1e-6:  # the loops hold it
            break
        way = way / size
        q = _stepped(numbers, q, scales * way)
    return q


def _stepped(numbers: Numbers, q: Array, way: Array) -> Array:
    """Return the closed position after the largest step that leads to one; q where none does."""
    step = WIDE
    for _ in range(HALVINGS):
        try:
            near = newton(numbers, numbers.moved(q, step * way), ())
            if seen_closed(numbers, near):
                return near
        except DerivationError:  # a formula has no value there
            pass
        step /= 2
    return q
