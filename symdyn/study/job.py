"""Jobs of a study in blocks of runs, their results, and the executors that compute blocks, a row of `EXECUTORS` each.

A job holds what a block needs and no more; it is frozen and goes to a worker once.

A block is a function of an importable module, called with a job and a number; it gives the same bytes wherever it runs.
So an executor may lose a worker and do its blocks again, with the same result. What comes back is handed to the caller
one block at a time, each once, in the order in which blocks end; who writes files is the caller.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from hashlib import sha256
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import SympyExpression, is_function, is_sympy
from symdyn.errors import StudyError
from symdyn.extras import install
from symdyn.frozen import dataclass, field
from symdyn.interrupts import interrupts_wait
from symdyn.scene import Scene, SceneUnits, write_text
from symdyn.scene.values import Faults, formula_text, shorten
from symdyn.study.design import Design

if TYPE_CHECKING:
    from distributed import Client

Block = Callable[[Any, int], Any]
"""A function of a module, (job, number of a block) -> what was found, which can be pickled."""

Say = Callable[[str], None]
"""Takes a line for the user."""


class Executor(Protocol):
    """Something that computes blocks."""

    @property
    def workers(self) -> int:
        """How many blocks it computes at the same time."""

    @property
    def place(self) -> str:
        """Where that is, for messages."""

    def results(self, block: Block, job: Any, numbers: Iterable[int]) -> Iterator[tuple[int, Any]]:
        """Yield number and result of every block, each once, as they end; no more than a few are ever held.

        After Ctrl-C no block is begun any more, those that are under way are still yielded, and then it raises. A
        second Ctrl-C does not wait for them.

        Raises:
            KeyboardInterrupt: after Ctrl-C.
            SymdynError: what a block raised; a StudyError where workers or a scheduler are at fault.
        """


@dataclass(frozen=True)
class Here:
    """This process, one block after the other."""

    workers: int = 1
    place: str = "this process"

    def results(self, block: Block, job: Any, numbers: Iterable[int]) -> Iterator[tuple[int, Any]]:
        """Yield number and result of every block, in their order."""
        with interrupts_wait(once=True) as stopped:
            for number in numbers:
                yield number, block(job, number)
                if stopped():
                    raise KeyboardInterrupt


NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

ENDED = "ended"
"""The column behind all others of a table: how a run ended."""


@dataclass(frozen=True)
class Measured:
    """One number of every run."""

    name: str  # of its column
    formula: str  # as the user writes it
    unit: str = ""  # "" where it is not known
    function: Callable[[Any], float] | None = None  # that gives it of a run; its formula is where that stands


@dataclass(frozen=True)
class BlockResult:
    """What came of one block.

    Attributes:
        measures: shape (n, measures).
        codes: how each run ended, shape (n,), of bytes.
        reasons: in words what ended the first few of those that did not reach their end, by number of the run.
        notes: what a user should know, such as the method.
    """

    measures: Array
    codes: Any
    reasons: Mapping[int, str]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Job:
    """A study that is to be made, in blocks of runs.

    Attributes:
        kind: what it is of, "runs" or "places".
        run: what comes of a stretch of it, from the job, the first number and the one behind the last; a function of a
            module, which a worker imports, and what it built stays there.
        scene: the mechanism; what is varied has some value in it.
        design: which values are tried together.
        measures: what is kept of every run.
        requested: options of the kind, by name, each picklable.
        specified: the same as text, for the fingerprint; in order.
        block: runs of one block; the last one may have fewer.
        threads: that a block may use; None for one a core. It changes no number.
    """

    kind: str
    run: Callable[[Job, int, int], BlockResult]
    scene: Scene
    design: Design
    measures: tuple[Measured, ...]
    requested: dict[str, Any] = field(default_factory=dict, hash=False)
    specified: tuple[tuple[str, str], ...] = ()
    block: int = 1024
    threads: int | None = 1

    @property
    def blocks(self) -> int:
        return -(-self.design.count // self.block)

    def span(self, k: int) -> tuple[int, int]:
        """Return the first run of block k, and the one behind its last."""
        return k * self.block, min((k + 1) * self.block, self.design.count)

    @property
    def units(self) -> dict[str, str]:
        """The unit of every column, "" where it is not known."""
        return units_of(self.scene, self.design.names) | {one.name: one.unit for one in self.measures}

    @property
    def scene_text(self) -> str:
        return write_text(self.scene.in_si(), "toml").text

    @property
    def identity(self) -> dict[str, Any]:
        """What decides the numbers, for JSON; equal for jobs whose numbers are equal."""
        return {
            "kind": self.kind,
            "scene_sha256": sha256(self.scene_text.encode()).hexdigest(),
            "design": self.design.kind,
            "count": self.design.count,
            "seed": self.design.seed,
            "names": list(self.design.names),
            "over": {one.name: one.text for one in self.design.over},
            "measures": {one.name: one.formula for one in self.measures},
            "asked": dict(self.specified),
        }


def units_of(scene: Scene, names: Sequence[str]) -> dict[str, str]:
    """Return the units of parameters, coordinates and velocities, "" where it is not known."""
    units = SceneUnits(scene)
    states = dict(zip(scene.coordinates, units.coordinates, strict=True))
    states |= {name: f"{unit}/s" for name, unit in zip(scene.velocities, units.velocities, strict=True)}
    known = units.inferred | {name: scene.shown_unit(unit) for name, unit in states.items()}
    return {name: known.get(name, "") for name in names}


Wanted: TypeAlias = (
    str | Callable[[Any], float] | Sequence[str | SympyExpression | Callable[[Any], float]]
    | Mapping[str, str | SympyExpression | Callable[[Any], float]]
)  # fmt: skip
"""Formulas or functions of a run, alone, in a list, or by the names of their columns."""


def block(job: Job, k: int) -> BlockResult:
    """Return what comes of block k of a job, in any process."""
    return job.run(job, *job.span(k))


def read_measured(measure: Wanted, faults: Faults) -> tuple[Measured, ...]:
    """Return what is kept of every run; what is wrong is among the faults."""
    found: dict[str, Measured] = {}
    several = measure if isinstance(measure, Mapping | Sequence) and not isinstance(measure, str) else [measure]
    for one in several.items() if isinstance(several, Mapping) else (("", one) for one in several):
        given, wanted = one
        if is_function(wanted) and not is_sympy(wanted):
            name, formula, function = given or wanted.__name__, f"{wanted.__module__}.{wanted.__qualname__}", wanted
        else:
            text, function = formula_text(wanted), None
            first, equals, formula = ("", "", text) if given else (part.strip() for part in text.partition("="))
            name, formula = (given or first, formula) if equals or given else 2 * (" ".join(text.split()),)
        call = f"peak={formula}" if function is None else 'measure={"peak": f}'
        if (function or given or formula != name) and not NAME.fullmatch(name):
            faults.add("measure", f'"{shorten(name)}" is no name of a column; use letters and digits, {call}')
        if name in found:
            faults.add("measure", f"{name} is given twice")
        found[name] = Measured(name, formula, function=function)
    if not found:
        faults.add("measure", 'nothing is measured; give such as "max(abs(q1))"')
    return tuple(found.values())


def check_names(measures: Sequence[Measured], names: Sequence[str], faults: Faults) -> None:
    """Add a fault for every measure whose column would have the name of another column."""
    for one in measures:
        if one.name in names or one.name == ENDED:
            what = "how a run ended" if one.name == ENDED else "what is varied"
            faults.add("measure", f"{one.name} is the column of {what}; give it another name, peak={one.formula}")


def impossible(job: Job, values: Array) -> dict[int, str]:
    """Return, by row, why values are none of the scene: parameters above zero that are not."""
    told: dict[int, str] = {}
    positive = {one.name for one in job.scene.parameters if one.positive}
    above = [k for k, name in enumerate(job.design.names) if name in positive]
    if np.isfinite(values).all() and (values[:, above] > 0).all():
        return told
    for name, column in zip(job.design.names, values.T, strict=True):
        wrong = ~(column > 0) if name in positive else ~np.isfinite(column)
        why = "it must be positive" if name in positive else "it must be finite"
        told |= {int(row): f"{name} = {column[row]:g}; {why}" for row in np.flatnonzero(wrong)}
    return told


Opener = Callable[[int | None, Say], AbstractContextManager[Executor]]


def _local(processes: bool, workers: int | None, say: Say) -> AbstractContextManager[Executor]:
    from symdyn.study.cluster import on_this_machine

    return on_this_machine(processes, workers, say)


EXECUTORS: Mapping[str, Opener] = {
    "here": lambda workers, say: nullcontext(Here()),
    "threads": partial(_local, False),
    "processes": partial(_local, True),
}
"""By name; whatever is none of these names is the address of a scheduler."""


def executor(
    where: str | Client = "here", workers: int | None = None, say: Say = lambda line: None
) -> AbstractContextManager[Executor]:
    """Return what computes blocks, for a `with` statement, which ends whatever it began.

    >>> from operator import mul
    >>> with executor() as found:
    ...     sorted(found.results(mul, 10, range(3)))
    [(0, 0), (1, 10), (2, 20)]

    Args:
        where: a key of `EXECUTORS`, the address of a Dask scheduler, such as "tcp://10.0.0.1:8786", or a Client, which
            stays open.
        workers: how many threads or processes; None takes one a core. A scheduler has the workers that it has.
        say: takes a line for the user.

    Raises:
        StudyError: no such place, Dask is not installed; on entering, no scheduler there, workers that do not fit.
    """
    if workers is not None and workers < 1:
        raise StudyError(f"workers: {workers} is none; give 1 or more")
    try:
        if isinstance(where, str) and where in EXECUTORS:
            return EXECUTORS[where](workers, say)
        if isinstance(where, str) and "://" not in where:
            known = ", ".join(EXECUTORS)
            raise StudyError(
                f'scheduler: {where!r} is not known; give {known}, or an address such as "tcp://10.0.0.1:8786"'
            )
        if workers is not None:
            raise StudyError("workers: a scheduler has the workers that it has; leave their number out")
        from symdyn.study.cluster import at_address, of_client

        return at_address(where, say) if isinstance(where, str) else of_client(where, say)
    except ModuleNotFoundError as fault:
        raise StudyError(f"scheduler: {fault.name} is not installed; `{install('sweep')}` does that") from fault
