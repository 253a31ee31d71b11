"""Starts of a search for optimal motions, drawn by seed, and which optima they led to.

    q(t) = q_guess(t) + Σ_k a_k sin(k π t/T)        k = 1 … WAVES, a_k drawn: N(0, 1) size / k

with velocities and accelerations of that motion; the ends stay. What a solver finds is a place where the conditions of
first order hold, an optimum among motions next to it at best: which one depends on where the search began.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symdyn.algebra import Array
from symdyn.scene import SceneUnits
from symdyn.simulation import opened
from symdyn.transcription.solution import Searched, Solution
from symdyn.transcription.transcribed import Collocation

WAVES = 4
"""Half waves that a motion which is drawn has beside the guess."""

SIZES = {"rad": math.pi / 2, "m": 0.5, "1": 0.3}
"""Of what is drawn for a coordinate without bounds, by its unit."""

ALIKE, NEAR = 1e-6, 1e-3
"""Costs over their size, and coordinates over the largest or 1, that are those of one optimum."""


def drawn(problem: Collocation, guess: Array, starts: int, seed: int) -> list[Array]:
    """Return z to start from, each of shape (size,): the guess, then those drawn by the seed."""
    random = np.random.default_rng(seed)
    return [guess, *(_one(problem, guess, random) for _ in range(starts - 1))]


def _one(problem: Collocation, guess: Array, random: np.random.Generator) -> Array:
    place, grid = problem.place, problem.grid
    z, n = guess.copy(), place["q"].shape[1]
    if len(place["T"]):
        least, most = problem.lower[place["T"]], problem.upper[place["T"]]
        z[place["T"]] = np.exp(random.uniform(np.log(least), np.log(most)))
    duration = problem.time(z)
    k = np.arange(1, WAVES + 1)
    a = random.standard_normal((WAVES, n)) * _sizes(problem) / k[:, None]
    turns = k * math.pi
    angle = grid.share[:, None] * turns
    z[place["q"]] += np.sin(angle) @ a
    if place["u"].shape[1] == n:  # velocities are rates of coordinates
        z[place["u"]] = guess[place["u"]] + np.cos(angle) @ (a * turns[:, None]) / duration
        z[place["a"]] = guess[place["a"]] - np.sin(angle[grid.stage]) @ (a * turns[:, None] ** 2) / duration**2
    else:
        numbers = opened(problem.scene).numbers()
        z[place["q"]] = [numbers.normalised(q) for q in z[place["q"]]]
    return np.clip(z, problem.lower, problem.upper)


def _sizes(problem: Collocation) -> Array:
    """Return how far coordinates are moved, shape (nq,): half of what their bounds leave, else by their unit."""
    inside = problem.place["q"][1:-1] if len(problem.place["q"]) > 2 else problem.place["q"]
    least, most = problem.lower[inside].max(axis=0), problem.upper[inside].min(axis=0)
    usual = np.array([SIZES.get(unit, 1.0) for unit in SceneUnits(problem.scene).coordinates])
    bounded = np.isfinite(most - least)
    return np.where(bounded, np.minimum(np.where(bounded, most - least, 0.0) / 2, 2 * usual), usual)


def best_of(solutions: Sequence[Solution], seed: int | None) -> Solution:
    """Return the best of what starts led to, the other optima beside it, best first; the first where none ended."""
    groups: list[list[Solution]] = []
    for one in sorted((one for one in solutions if one.success), key=lambda one: one.objective):
        group = next((group for group in groups if _same(group[0], one)), None)
        if group is None:
            groups.append([one])
        else:
            group.append(one)
    failed = tuple(sorted(Counter(one.status for one in solutions if not one.success).items()))
    if not groups:
        return replace(solutions[0], searched=Searched(len(solutions), seed, (), failed))
    led = tuple((group[0].objective, len(group)) for group in groups)
    searched = Searched(len(solutions), seed, led, failed)
    best, *others = (replace(group[0], searched=searched) for group in groups)
    return replace(best, others=tuple(others))


def _same(one: Solution, other: Solution) -> bool:
    """Tell whether two solutions are one optimum."""
    if abs(one.objective - other.objective) > ALIKE * max(abs(one.objective), abs(other.objective), ALIKE):
        return False
    q, p = (x.z[x.problem.place["q"]] for x in (one, other))
    return bool(np.abs(q - p).max(initial=0.0) <= NEAR * max(1.0, float(np.abs(q).max(initial=0.0))))
