"""What a way to run an ensemble is given, and what it gives back for a part of the runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.scene import Quantity, Scene
from symdyn.simulation.ensemble.lanes import Lanes
from symdyn.simulation.ensemble.measures import Measure, Sums
from symdyn.simulation.prescribed.forces import Forces
from symdyn.simulation.trajectory import INTERRUPTED


@dataclass(frozen=True)
class Task:
    """Runs that are wanted.

    Attributes:
        lanes: where they start and at which values.
        forces: what drives them.
        times: where samples are taken, ascending, from 0 to the end; shape (T,).
        every: seconds between samples, as they were asked for.
        measures: of every run.
        stops: formulas whose zeros end a run.
        rtol, atol: tolerances on a step.
        method: of `symdyn.simulation.METHODS`; None chooses.
        keep: whether samples are kept.
        ignore_limits: whether runs go on where a joint reaches a limit of its position.
    """

    lanes: Lanes
    forces: Forces
    times: Array
    every: float | None
    measures: tuple[Measure, ...]
    stops: tuple[str, ...]
    rtol: float
    atol: float
    method: str | None
    keep: bool
    ignore_limits: bool

    @property
    def scene(self) -> Scene:
        """The mechanism."""
        return self.lanes.scene

    @property
    def insides(self) -> tuple[Quantity, ...]:
        """The formulas that measures fold, each once."""
        return tuple(dict.fromkeys(one for measure in self.measures for one in measure.insides))

    @property
    def until(self) -> float:
        """Time of the end, s."""
        return float(self.times[-1])


@dataclass(frozen=True)
class RunBlock:
    """Some runs, done.

    Attributes:
        t: when each ended, s, shape (n,).
        q, u: where, shapes (n, nq) and (n, nv).
        stopped: why, in words.
        sums: of every formula that is folded.
        samples: states at the times of samples, shape (n, T, nq + nv), NaN behind the end; None where not asked.
        steps: taken in all.
        notes: what a user should know.
    """

    t: Array
    q: Array
    u: Array
    stopped: tuple[str, ...]
    sums: Mapping[Quantity, Sums]
    samples: Array | None = None
    steps: int = 0
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Runner:
    """What runs parts of an ensemble.

    Attributes:
        run: runs some of the runs; several threads may call it at a time, where the way says so.
        halt: makes all that run end soon.
    """

    run: Callable[[slice], RunBlock]
    halt: Callable[[], None] = lambda: None


@dataclass(frozen=True)
class RunMode:
    """A way to run an ensemble.

    Attributes:
        text: what it is, one line.
        library: whose it is.
        part: runs that are handed out at a time.
        ready: makes what is needed once, and returns what runs a part.
        refuses: why it does not apply, "" if it does.
        methods: of `symdyn.simulation.METHODS` that it stands for; () for all.
        threads: whether parts run on threads at the same time.
    """

    text: str
    library: str
    part: int
    ready: Callable[[Task], Runner]
    refuses: Callable[[Task], str]
    methods: tuple[str, ...] = ()
    threads: bool = True


def nothing(task: Task, count: int) -> RunBlock:
    """Return runs that were not run."""
    nan, scene = np.nan, task.scene
    sums = {one: Sums(*(np.full(count, nan) for _ in range(9))) for one in task.insides}
    shape = (count, len(task.times), len(scene.coordinates) + len(scene.velocities))
    return RunBlock(
        np.zeros(count), np.full((count, len(scene.coordinates)), nan), np.full((count, len(scene.velocities)), nan),
        (INTERRUPTED,) * count, sums, np.full(shape, nan) if task.keep else None,
    )  # fmt: skip


_ALONE = Lock()
"""Of parts that run on threads, one at a time asks `simulate`."""


def replaced(task: Task, block: RunBlock, part: slice, which: npt.NDArray[np.bool_], again: Runner) -> RunBlock:
    """Return a part with some of its runs run again."""
    if not which.any():
        return block
    stopped, steps = list(block.stopped), block.steps
    for k in map(int, np.flatnonzero(which)):
        with _ALONE:
            one = again.run(slice(part.start + k, part.start + k + 1))
        block.q[k], block.u[k], block.t[k], stopped[k] = one.q[0], one.u[0], one.t[0], one.stopped[0]
        steps += one.steps
        for inside, kept in block.sums.items():
            for name in Sums.__dataclass_fields__:
                getattr(kept, name)[k] = getattr(one.sums[inside], name)[0]
        if block.samples is not None and one.samples is not None:
            block.samples[k] = one.samples[0]
    return replace(block, stopped=tuple(stopped), steps=steps)


def joined(task: Task, blocks: Sequence[RunBlock]) -> RunBlock:
    """Return parts as one, in their order."""
    parts = [*blocks] or [nothing(task, 0)]

    def together(arrays: Sequence[Any]) -> Array:
        return np.concatenate(arrays)

    names = Sums.__dataclass_fields__
    sums = {
        one: Sums(*(together([getattr(part.sums[one], name) for part in parts]) for name in names))
        for one in task.insides
    }
    return RunBlock(
        together([part.t for part in parts]), together([part.q for part in parts]),
        together([part.u for part in parts]), tuple(why for part in parts for why in part.stopped), sums,
        together([part.samples for part in parts]) if task.keep else None, sum(part.steps for part in parts),
        tuple(dict.fromkeys(note for part in parts for note in part.notes)),
    )  # fmt: skip
