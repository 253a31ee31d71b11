"""Positions, velocities and accelerations that follow from laws, time after time, as far as it goes (`following`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.simulation.following import Following, Known, Tied
from symdyn.simulation.initial import no_equations
from symdyn.simulation.trajectory import END

AHEAD = 1e-7
"""s by which it is looked ahead for whether a wheel falls or rises."""

THIRDS = 30
"""Steps to a place where a wheel lies flat, each of which leaves two thirds of an interval."""


@dataclass(frozen=True)
class Followed:
    """What follows, at the first R of the times asked for.

    Attributes:
        q, u, a: positions, velocities and accelerations, shapes (R, nq), (R, nv), (R, nv).
        off: largest residual that is left, shape (R,).
        notes: what a user should know.
        stopped: "end", or why nothing follows at the next time.
    """

    q: Array
    u: Array
    a: Array
    off: Array
    notes: tuple[str, ...]
    stopped: str


def followed(
    tied: Tied, given: Sequence[str], laws: Known, quasi: Mapping[int, Known], t: Array, guess: Array
) -> Followed:
    """Return what follows from laws at times, as far as it goes; see the legend of `following`.

    Args:
        tied: the mechanism and its functions.
        given: names of the coordinates with a law.
        laws: their positions, rates and second rates at times (N,), each of shape (N, given).
        quasi: laws of velocities that are no rates of coordinates: value, rate and second rate at times.
        t: times, s, ascending.
        guess: of the coordinates at the first time, shape (nq,).

    Raises:
        SimulateError: laws that contradict the rows at the first time, or leave motions undetermined.
    """
    one, numbers = Following(tied, given, laws, quasi), tied.numbers
    q = one.placed(float(t[0]), guess)
    no_equations(numbers, q)
    notes = one.undetermined(q)
    path = one.integrated(t, q) if one.rolls(q) else None
    rows: list[tuple[Array, Array, Array, float]] = []
    stopped = END
    for now in t.tolist():
        try:
            q = one.placed(now, q if path is None else next(path))
            u = one.velocities(now, q)
            rows.append((q, u, one.accelerations(now, q, u), one.missed(q)))
        except SimulateError as fault:
            if not rows:
                raise
            stopped = str(fault)
            break
    positions, velocities, accelerations, off = (np.array(part) for part in zip(*rows, strict=True))
    fallen = _fallen(one, t, positions, velocities)
    n, stopped = fallen or (len(rows), stopped)
    return Followed(positions[:n], velocities[:n], accelerations[:n], off[:n], notes, stopped)


def _fallen(one: Following, t: Array, q: Array, u: Array) -> tuple[int, str] | None:
    """Return how many rows there are before a wheel comes to lie flat, also between two samples, and what is said.

    w, the sine of the angle between axis and normal, is |sin|: it falls before such a place and rises behind it.
    """
    numbers, found = one.numbers, []
    for k, gauge in enumerate(numbers.gauges):

        def w(at: Array, k: int = k) -> float:
            return float(numbers.at([numbers.gauges[k].sine], at)[0])

        moves = [(w(numbers.moved(at, AHEAD * rate)) - w(at)) for at, rate in zip(q, u, strict=True)]
        for i in range(len(q) - 1):
            if not moves[i] < 0 < moves[i + 1]:
                continue
            low, high = float(t[i]), float(t[i + 1])
            for _ in range(THIRDS):  # a third of the interval less at every step
                left, right = low + (high - low) / 3, high - (high - low) / 3
                one_third, two_thirds = one.placed(left, q[i]), one.placed(right, q[i])
                low, high = (low, right) if w(one_third) < w(two_thirds) else (left, high)
            if gauge.is_flat(w(one.placed(low, q[i]))):
                found.append((i + 1, f"motion: t = {low:.6g} s: {gauge.fell_flat}"))
                break
    return min(found, default=None)
