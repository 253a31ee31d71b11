"""Rows of a run whose controller takes samples: one wherever a force may change, if nobody asks for others.

Between samples a motion goes on: where they are few, a period is divided, so that there are `SAMPLES` rows at least.
"""

from __future__ import annotations

import math

import numpy as np

from symdyn.algebra import Array
from symdyn.scene import Scene
from symdyn.simulation.feedback.controller import Placed
from symdyn.simulation.feedback.loop import SAME, lateness
from symdyn.simulation.prescribed.forces import Forces, force_names
from symdyn.simulation.prescribed.numbers_in_time import SAMPLES

MOST = 200_000
"""Samples beyond which some have no row of their own, unless that is asked for."""


def sampled_rows(placed: Placed, until: float) -> Array:
    """Return the times of the rows, ascending from 0 to `until`: samples, what lies between, and changes of forces."""
    period = _period(placed)
    count = math.floor(until / period * (1 + 1e-12))
    step = math.ceil(max(1, count) / MOST)
    numbers = np.arange(0, count + 1, step)
    times = numbers * period
    if step == 1:
        parts = math.ceil(SAMPLES * period / until)
        rest = lateness(placed.feedback)[1]
        between = [times + period * k / parts for k in range(1, min(parts, SAMPLES + 1))]
        between += [times + rest] if rest else []
        times = np.concatenate([times, *between])
    times = np.sort(times[times < until - SAME * period], kind="stable")
    apart = np.diff(times, prepend=-math.inf) > SAME * period
    return np.append(times[apart], until)


def hidden(placed: Placed, times: Array) -> list[str]:
    """Return what is said where samples lie between rows at times, nothing where all of them are seen."""
    period = _period(placed)
    late, rest = lateness(placed.feedback)
    acts = np.arange(late, math.floor(times[-1] / period * (1 + 1e-12)) + 1) * period + rest
    acts = acts[acts < times[-1] - SAME * period]
    unseen = np.maximum(np.bincount(np.searchsorted(times, acts - SAME * period), minlength=1) - 1, 0)
    if not unseen.any():
        return []
    return [
        f"the controller takes a sample every {period:g} s, and {int(unseen.sum())} of {len(acts)} lie between rows, "
        f"up to {int(unseen.max())} between two: the columns show the last one; --every {period:g}, in Python "
        f"every={period:g}, shows all"
    ]


def held_columns(scene: Scene, forces: Forces, placed: Placed, others: tuple[int, ...]) -> tuple[str, ...]:
    """Return the columns that are constant from one sample to the next: forces, inputs, and outputs made of them alone.

    `others` are the places of what acts all the time beside the controller.
    """
    names, constant = force_names(scene), {one.name for one in scene.parameters}
    moving = {*forces.tables, *others}

    def still(k: int, held: set[str]) -> bool:
        return k not in moving and set(forces.formula(k).symbols) <= constant | held

    first = len(scene.velocities)
    inputs = {names[k] for k in range(first, len(names)) if k in placed.places and still(k, set())}
    drives = {
        names[k]
        for k in range(first)
        if still(k, inputs) and (k in placed.places or inputs.intersection(forces.formula(k).symbols))
    }
    found = inputs | drives
    outputs = {
        one.name for one in scene.outputs if found.intersection(s := set(one.formula.symbols)) and s <= constant | found
    }
    return tuple(name for name in (*names, *(one.name for one in scene.outputs)) if name in found | outputs)


def _period(placed: Placed) -> float:
    assert placed.feedback.period is not None, "only of controllers that take samples"
    return placed.feedback.period
