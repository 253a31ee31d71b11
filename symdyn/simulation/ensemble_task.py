"""What a mode of many runs is given, what it gives back for a part of them, and how parts are handed out.

Parts have a fixed number of runs, so that the same runs give the same bytes on any number of threads. The mode that
takes whatever `simulate` takes runs one after the other by it, and reads what measures fold from the columns of each.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from threading import Lock
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array, Batches
from symdyn.arguments import argument
from symdyn.dynamics.mechanism import TIME, prescribed, quaternions
from symdyn.errors import MethodError, SymdynError, alike
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Graph, evaluate, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.joints import start_of
from symdyn.scene.values import LETTERS, spell
from symdyn.simulation.equations.controller import Feedback
from symdyn.simulation.forward import simulate
from symdyn.simulation.integrate.integration import END, INTERRUPTED
from symdyn.simulation.measures import Measure, Sums, at_peak, sums_over
from symdyn.simulation.prescribed.forces import Forces, at_start
from symdyn.simulation.trajectory import Trajectory


@dataclass(frozen=True)
class Lanes:
    """The runs of an ensemble.

    Attributes:
        scene: the mechanism, all parameters bound; varied ones at values near those of the runs.
        count: how many runs.
        start, rates: what is given in place of what the scene says, by coordinate and by velocity: formulas, or arrays
            of shape (count,).
        values: of varied parameters by name, shape (count,).
    """

    scene: Scene
    count: int
    start: Mapping[str, Quantity | Array] = field(default_factory=dict)
    rates: Mapping[str, Quantity | Array] = field(default_factory=dict)
    values: Mapping[str, Array] = field(default_factory=dict)

    @property
    def varied(self) -> dict[str, Array]:
        """What differs between runs, by name, shape (count,)."""
        given = (*self.values.items(), *self.start.items(), *self.rates.items())
        return {name: one for name, one in given if isinstance(one, np.ndarray)}

    def parameters(self, part: slice = slice(None)) -> dict[str, Array]:
        """Return the values of all parameters by name, numbers or shape (runs of the part,)."""
        known: dict[str, Any] = {p.name: float(p.value) for p in self.scene.parameters if p.value is not None}
        return known | {name: one[part] for name, one in self.values.items()}

    def states(self, part: slice, inputs: Mapping[str, Quantity]) -> Array:
        """Return where runs of a tree start, shape (runs, nq + nv), inputs as `at_start` has them; unit quaternions."""
        scene, graph = self.scene, Graph()
        moved = prescribed(scene, graph)
        q: list[Any] = [self.start.get(n, x) for n, x in zip(scene.coordinates, start_of(scene).position, strict=True)]
        u: list[Any] = [self.rates.get(n, x) for n, x in zip(scene.velocities, start_of(scene).velocity, strict=True)]
        known = {graph.symbol(name): value for name, value in self.parameters(part).items()}
        known[graph.symbol(TIME)] = np.zeros(())
        told = {one.name: one.value for one in scene.inputs} | dict(inputs)
        placed = {graph.symbol(name): one.express(graph) for name, one in told.items()}
        led = (substitute(some, placed) for some in (moved.position, moved.velocity))
        for k, position, rate in zip(moved.place, *led, strict=True):
            place = scene.coordinates.index(scene.velocities[k].removesuffix("_dot"))
            q[place], u[k] = position, rate
        runs = len(range(self.count)[part])
        found = np.empty((len(q) + len(u), runs))
        with np.errstate(all="ignore"):
            for row, one in zip(found, (*q, *u), strict=True):
                if isinstance(one, np.ndarray):
                    row[:] = one[part]
                else:
                    entry = one.express(graph) if isinstance(one, Quantity) else one
                    row[:] = evaluate([entry], Batches(), known)[0]
        positions, rates = found[: len(q)].T.copy(), found[len(q) :].T.copy()
        names = list(scene.coordinates)
        for group in quaternions(scene):
            turn = slice(names.index(group[0]), names.index(group[0]) + 4)
            with np.errstate(all="ignore"):
                positions[:, turn] /= np.linalg.norm(positions[:, turn], axis=1, keepdims=True)
        return np.hstack([positions, rates])

    def one(self, k: int) -> tuple[dict[str, float], dict[str, Any], dict[str, Any]]:
        """Return values, start and rates of one run, as `simulate` takes them."""
        values = {name: float(one[k]) for name, one in self.values.items()}
        start, rates = (
            {name: float(one[k]) if isinstance(one, np.ndarray) else spell(one) for name, one in given.items()}
            for given in (self.start, self.rates)
        )
        return values, start, rates


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

    @property
    def complete(self) -> npt.NDArray[np.bool_]:
        """Which runs reached their end, shape (n,)."""
        return np.array([why == END for why in self.stopped], dtype=np.bool_)

    @property
    def interrupted(self) -> npt.NDArray[np.bool_]:
        """Which runs a user ended, shape (n,)."""
        return np.array([why == INTERRUPTED for why in self.stopped], dtype=np.bool_)


@dataclass(frozen=True)
class Runner:
    """What runs parts of a task.

    Attributes:
        run: runs some of the runs; several threads may call it at a time, where the mode says so.
        halt: makes all that run end soon.
    """

    run: Callable[[slice], RunBlock]
    halt: Callable[[], None] = lambda: None


@dataclass(frozen=True)
class RunMode:
    """A way to run a task."""

    name: str  # that users read
    text: str  # what it is, one line
    library: str  # whose it is
    part: int  # runs that are handed out at a time
    ready: Callable[[Task], Runner]  # makes what is needed once, and returns what runs a part
    refuses: Callable[[Task], str]  # why it does not apply, "" if it does
    methods: tuple[str, ...] = ()  # of `symdyn.simulation.METHODS` that it stands for; () for all
    threads: bool = True  # whether parts run on threads at the same time


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
        mode: how they are run.
        notes: what a user should know of that.
        feedback: a controller that adds to the forces; None for none.
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
    mode: RunMode
    notes: tuple[str, ...] = ()
    feedback: Feedback | None = None

    @property
    def scene(self) -> Scene:
        return self.lanes.scene

    def begun(self, part: slice) -> Array:
        """Return where runs of a tree start, shape (runs, nq + nv)."""
        return self.lanes.states(part, at_start(self.scene, self.forces) if self.scene.rates else {})

    @property
    def insides(self) -> tuple[Quantity, ...]:
        """The formulas that measures fold, each once."""
        return tuple(dict.fromkeys(one for measure in self.measures for one in measure.insides))

    @property
    def peaks(self) -> tuple[tuple[Quantity, int], ...]:
        """The formulas whose largest (1) or smallest (-1) values count, each once."""
        return tuple(dict.fromkeys(one for measure in self.measures for one in measure.peaks))

    @property
    def until(self) -> float:
        """Time of the end, s."""
        return float(self.times[-1])

    def measured(self, block: RunBlock) -> dict[str, Array]:
        """Return measures of all runs by their texts, shape (runs,) each."""
        known, shape = self.lanes.parameters(), (self.lanes.count,)
        return {one.text: np.broadcast_to(one.value(block.sums, known), shape) for one in self.measures}

    def run(
        self,
        workers: int | None = None,
        progress: Callable[[float], None] | None = None,
        say: Callable[[str], None] | None = None,
    ) -> tuple[RunBlock, float]:
        """Return all runs, and the seconds that they took once all was ready; arguments as of `symdyn.ensemble`.

        Interrupted (Ctrl-C), it returns what was done.
        """
        say = say or (lambda line: None)
        for note in self.notes:
            say(note)
        runner = self.mode.ready(self)
        ready = time.perf_counter()
        found = joined(self, [*_run(self, runner, workers or _cores(), progress)])
        notes = (*found.notes, *self._unseen(found))
        for note in notes:
            say(note)
        return replace(found, notes=(*self.notes, *notes)), time.perf_counter() - ready

    def _unseen(self, block: RunBlock) -> Iterator[str]:
        """Yield what peaks between the samples of the first run change in its measures, where that is much."""
        peaks = [one.text for one in self.measures if one.peaks]
        if not peaks or not self.lanes.count or not block.complete[0] or len(self.times) < 2:
            return
        times = np.linspace(0.0, self.until, FINER * (len(self.times) - 1) + 1)
        finer = replace(self, times=times, every=float(times[1]), keep=False)
        fine = finer.measured(joined(finer, [self.mode.ready(finer).run(slice(0, 1))]))
        for text, seen, there in ((one, self.measured(block)[one][0], fine[one][0]) for one in peaks):
            if np.isfinite([seen, there]).all() and abs(there - seen) > MISSED * abs(there) + self.atol:
                yield (
                    f"{text} of one of the runs is {seen:.6g} at samples {self.times[1]:.3g} s apart, {there:.6g} at "
                    f"{times[1]:.3g} s: peaks lie between samples; give {argument('every', float(f'{times[1]:.3g}'))}"
                )


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _run(task: Task, runner: Runner, workers: int, progress: Callable[[float], None] | None) -> Iterator[RunBlock]:
    """Yield parts in their order; those that an interrupt leaves undone are empty."""
    count, mode = task.lanes.count, task.mode
    parts = [slice(k, min(k + mode.part, count)) for k in range(0, count, mode.part)]
    done: dict[int, RunBlock] = {}
    try:
        for k, block in _parts(parts, runner, workers if mode.threads else 0):
            done[k] = block
            if progress is not None:
                progress(len(done) / len(parts))
    except KeyboardInterrupt:
        pass
    for k, part in enumerate(parts):
        yield done.get(k) or nothing(task, part.stop - part.start)


def _parts(parts: Sequence[slice], runner: Runner, workers: int) -> Iterator[tuple[int, RunBlock]]:
    """Yield parts as they are done, on so many threads, none for this one; of an interrupt those half done too."""
    if workers == 0:
        for k, part in enumerate(parts):
            yield k, runner.run(part)
        return
    pool = ThreadPoolExecutor(min(workers, max(1, len(parts))))
    waiting = {pool.submit(runner.run, part): k for k, part in enumerate(parts)}
    try:
        while waiting:
            for one in wait(waiting, return_when=FIRST_COMPLETED).done:
                yield waiting.pop(one), one.result()
    except KeyboardInterrupt:
        runner.halt()
        pool.shutdown(wait=True, cancel_futures=True)
        yield from ((k, one.result()) for one, k in waiting.items() if not one.cancelled())
        raise
    finally:
        runner.halt()
        pool.shutdown(wait=True, cancel_futures=True)


def nothing(task: Task, count: int) -> RunBlock:
    """Return runs that were not run."""
    nan, scene = np.nan, task.scene
    sums = {one: Sums(*(np.full(count, nan) for _ in Sums.__dataclass_fields__)) for one in task.insides}
    shape = (count, len(task.times), len(scene.coordinates) + len(scene.velocities))
    return RunBlock(
        np.zeros(count), np.full((count, len(scene.coordinates)), nan), np.full((count, len(scene.velocities)), nan),
        (INTERRUPTED,) * count, sums, np.full(shape, nan) if task.keep else None,
    )  # fmt: skip


FINER, MISSED = 8, 1e-3
"""How many times as many samples one run is looked at by, and the share of a measure that they may change untold."""

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
        alike(note for part in parts for note in part.notes),
    )  # fmt: skip


def one_after_other(task: Task) -> Runner:
    """Return what runs a part, one run after the other."""

    def run(part: slice) -> RunBlock:
        runs = range(task.lanes.count)[part]
        found = nothing(task, len(runs))
        t, q, u, sums, samples = found.t, found.q, found.u, found.sums, found.samples
        why, steps, notes = [], 0, dict[str, None]()
        for row, k in enumerate(runs):
            one = _one(task, k, notes)
            if isinstance(one, str):
                why.append(one)
                continue
            if one.stopped == INTERRUPTED:
                raise KeyboardInterrupt
            try:
                told = {name: x for measure in task.measures for name, x in measure.known(one).items()}
            except SymdynError as fault:
                why.append(str(fault))
                continue
            t[row], q[row], u[row] = one.t[-1], one.q[-1], one.qd[-1]
            why.append(_why(one))
            steps += one.steps
            seen = dict(sums_over(task.insides, one, told))
            for inside, sign in task.peaks:
                seen[inside] = at_peak(seen[inside], inside, sign, one)
            for inside, kept in seen.items():
                for name in Sums.__dataclass_fields__:
                    getattr(sums[inside], name)[row] = getattr(kept, name)
            if samples is not None:
                count = min(len(one.t), len(task.times))
                samples[row, :count] = np.hstack([one.q, one.qd])[:count]
        return RunBlock(t, q, u, tuple(why), sums, samples, steps, tuple(notes))

    return Runner(run)


def _one(task: Task, k: int, notes: dict[str, None]) -> Trajectory | str:
    """Return one run, or why there is none."""
    values, start, rates = task.lanes.one(k)
    named = {name for one in task.insides for name in one.symbols}
    try:
        return simulate(
            task.scene, forces=task.forces, start=start, start_rates=rates, values=values or None, until=task.until,
            every=task.every, method=task.method, rtol=task.rtol, atol=task.atol, stops=task.stops,
            ignore_limits=task.ignore_limits, reactions=any(name.startswith(LETTERS.reaction) for name in named),
            feedback=task.feedback, say=notes.setdefault,
        )  # fmt: skip
    except MethodError:  # nor would it apply to another run
        raise
    except SymdynError as fault:
        return " ".join(str(fault).split())


def _why(run: Trajectory) -> str:
    """Return why a run ended in words that many runs share: when it was is told apart."""
    ended = run.events[-1] if run.events and run.events[-1].stops else None
    return _AT.sub("t", run.stopped) if ended is None else ended.formula


_AT = re.compile(r"\bt = [-+.\deinf]+ s\b")


ONE_BY_ONE = RunMode(
    "one by one", "each run by `simulate`", "symdyn", 1, one_after_other, lambda task: "", threads=False
)
