"""What acts on a run from outside of its equations, the rows that it gives the run, and what is told of it.

Where a controller takes samples, a run has a row wherever a force may change, if no other rows are asked for. Where
samples are few, a period is divided, so that there are `SAMPLES` rows at least.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.scene import Scene
from symdyn.simulation.columns import apart
from symdyn.simulation.equations.control_loop import SAME, Loop, lateness
from symdyn.simulation.equations.controller import Placed, placed, placed_function, read_feedback
from symdyn.simulation.equations.saturation import saturation_report
from symdyn.simulation.initial import Start
from symdyn.simulation.prescribed.forces import Forces, force_names
from symdyn.simulation.prescribed.formulas_in_time import SAMPLES
from symdyn.simulation.trajectory import Trajectory


@dataclass(frozen=True)
class Control:
    """What acts on a run from outside of its equations: a controller, and functions that forces are given by.

    It says at which times the run has samples, and what is told of the controller in the end.

    Attributes:
        controller: None where there is none.
        functions: forces that are functions.
    """

    controller: Placed | None = None
    functions: tuple[Placed, ...] = ()

    @property
    def laws(self) -> tuple[Placed, ...]:
        """All of them, the controller first."""
        return (*(() if self.controller is None else (self.controller,)), *self.functions)

    @property
    def places(self) -> tuple[int, ...]:
        """The indices of the forces and inputs on which they act."""
        return tuple(dict.fromkeys(k for law in self.laws for k in law.places))

    @property
    def sampled(self) -> Placed | None:
        """The controller if it takes samples."""
        return self.controller if self.controller is not None and self.controller.feedback.period is not None else None

    def samples(self, until: float, every: float | None, usual: Array) -> Array:
        """Return the times of a run's samples: the usual ones, or the controller's where nobody asks for others."""
        return usual if self.sampled is None or every is not None else sampled_rows(self.sampled, until)

    def notes(self, times: Array) -> list[str]:
        """Return what is said of what has no effect, and of controller's samples that lie between those."""
        if self.controller is None:
            return []
        feedback, found = self.controller.feedback, []
        if len(feedback.initial) and not (self.sampled and feedback.delay):
            found.append("feedback: initial has no effect: without a period and a delay the first force acts at once")
        return found if self.sampled is None else found + hidden(self.sampled, times)

    def begun(self, scene: Scene, initial: Start, until: float) -> Loop | None:
        """Return them at work at the start of a run, None where there are none."""
        if not self.laws:
            return None
        first, *beside = self.laws
        found = Loop(first, len(scene.coordinates), len(scene.velocities), until, len(scene.inputs), beside)
        with np.errstate(all="ignore"):  # what has no value is told
            found.start(initial.q, initial.u)
        return found

    def reported(self, trajectory: Trajectory, x: Array, forces: Forces, loop: Loop | None) -> Trajectory:
        """Return a run, of states (N, nx), with what is told of the controller.

        That are columns of what it computed, which columns are under zero-order hold, and saturations.
        """
        if self.controller is None or loop is None:
            return trajectory
        cuts, end = loop.cuts, float(trajectory.t[-1])
        others = tuple(k for one in self.functions for k in one.places)
        n = trajectory.q.shape[1] + trajectory.qd.shape[1]
        with np.errstate(all="ignore"):
            told = loop.columns(trajectory.t, trajectory.q, trajectory.qd, x[:, n : n + loop.nz])
        extra = apart(trajectory.scene, {**trajectory.extra, **told})
        held: tuple[str, ...] = ()
        if self.sampled is not None:
            held = (*held_columns(trajectory.scene, forces, self.sampled, others), *list(extra)[-len(told) :])
        notes = (*trajectory.notes, *saturation_report(cuts, end))
        return replace(trajectory, extra=extra, held=held, saturations=cuts.until(end), notes=notes)


def control(scene: Scene, feedback: object, forces: Forces, until: float) -> Control:
    """Return what acts from outside, from what `simulate` is given.

    Raises:
        SimulateError: with every fault, one line each.
    """
    controller = None if feedback is None else placed(scene, read_feedback(scene, feedback), until)
    return Control(controller, tuple(placed_function(scene, one, until) for one in forces.functions))


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
        f"up to {int(unseen.max())} between two: the columns show the last one; {argument('every', period)} shows all"
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
