"""Files of a certificate, each written once, and compilers at work while proofs run.

A compiler is a process of its own, so that what it takes is the longer of two times and not their sum. Modules come out
in the order of the targets, as if one had been built after the other.

Fixed text of code for many states is measured: every length from none to three blocks gives the states one by one.
Blocks, what is left over, columns and rows are no arithmetic, so they are not proved but run: at each length, in each
way that the target has, next to one state a call, with an entry behind the result that nothing may touch.

The text of targets' files is read back and proved.
"""

from __future__ import annotations

import ctypes
import random
from collections.abc import Container, Mapping, Sequence
from concurrent.futures import Future
from math import prod
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Redraw
from symdyn.arguments import argument
from symdyn.dynamics import Function, row_of
from symdyn.dynamics.outputs import POSE
from symdyn.emit import TARGETS, Sources, emit
from symdyn.emit.code import REALS
from symdyn.errors import BuildError, EmitError, MissingProgram
from symdyn.frozen import dataclass, replace
from symdyn.program import Program, Sampling, shared
from symdyn.runtime import RUNNERS, Commands, bind_rows
from symdyn.verdict import Unclaimed, Verdict
from symdyn.verify.written.proof import Files, Written, printed, prove_texts, unshown
from symdyn.verify.written.readers import READERS, languages


@dataclass(frozen=True)
class Modules:
    """What was built of a program."""

    built: dict[str, Any]  # modules by target
    missing: tuple[Unclaimed, ...]  # targets that this machine cannot run, and what it lacks
    refused: str = ""  # the words of what refused the code, behind which nothing more was built; "" for nothing


class Building:
    """The files of a program, and the modules that they make."""

    def __init__(self, program: Program, real: str, accuracy: str = "") -> None:
        """Start with nothing written; accuracy as for `emit`."""
        self.program, self.real, self.accuracy = program, real, accuracy
        small = [
            one for one in program.routines if not (one.function.request and row_of(one.function.request)[0].is_large)
        ]
        whole = len(small) == len(program.routines)
        self._usual = program if whole else replace(program, routines=tuple(small))
        self._written: dict[tuple[bool, str, str], Sources] = {}
        self._begun: dict[tuple[bool, str, str], Future[Any]] = {}
        self._commands, most = Commands(), max(1, sum(runner.aside for runner in RUNNERS.values()))
        self._threads = self._commands.threads(most)

    def __enter__(self) -> Building:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait for the compilers; stop them where nobody wants any longer what they make."""
        if kind is not None:
            self._commands.stop()
        self._threads.shutdown(cancel_futures=True)

    def written(self, target: str, option: str, part: Program | None = None) -> Sources:
        """Return the files of a target, of the whole program or a part of it."""
        key = self._key(target, option, part)
        if key not in self._written:
            self._written[key] = emit(part or self.program, target, self.real, option=option, accuracy=self.accuracy)
        return self._written[key]

    def options(self, target: str, every: bool = False) -> tuple[str, ...]:
        """Return the options of a target that are looked at: what is measured, or `every` one that has the accuracy."""
        measured = RUNNERS[target].measured if target in RUNNERS else ""
        row = TARGETS[target]
        wanted = dict.fromkeys((measured, "", *row.options) if every else (measured,))
        if not self.accuracy:
            return tuple(wanted)
        having = tuple(one for one in wanted if one in row.shortens) or row.shortens[:1]
        return having or tuple(wanted)  # which is refused in words

    def begin(self, targets: Sequence[str], many: Container[str] = ()) -> None:
        """Let compilers start on what a certificate measures of targets, and on code for `many` states of these."""
        there = [name for name in targets if name in RUNNERS and RUNNERS[name].aside]
        for name in sorted(there, key=lambda name: not RUNNERS[name].usual):  # first what takes longest
            if self._part(name).routines:
                self._begin(name, self.options(name)[0], self._part(name))
            if name in many:
                self._begin(name, RUNNERS[name].many, self.program)

    def compiled(self, target: str, option: str, part: Program | None = None) -> tuple[Sources, Any]:
        """Return the files of a target, and the module that they make.

        Raises:
            BuildError: no compiler, or its own words when it refuses.
        """
        sources = self.written(target, option, part)
        begun = self._begun.get(self._key(target, option, part))
        return sources, RUNNERS[target].run(sources) if begun is None else begun.result()

    def modules(self, targets: Sequence[str]) -> Modules:
        """Return the built modules of targets, what of them cannot be run here, and what refused the code."""
        built: dict[str, Any] = {}
        missing: list[Unclaimed] = []
        for name in targets:
            if name not in RUNNERS or not self._part(name).routines:
                continue
            try:
                _, built[name] = self.compiled(name, self.options(name)[0], self._part(name))
            except MissingProgram as fault:
                missing.append(Unclaimed(f"the error of {TARGETS[name].title}", str(fault)))
            except BuildError as fault:
                return Modules(built, tuple(missing), str(fault))
        return Modules(built, tuple(missing))

    def _begin(self, target: str, option: str, part: Program) -> None:
        key = self._key(target, option, part)
        if key not in self._begun:
            try:
                sources = self.written(target, option, part)
            except (MissingProgram, BuildError):
                return  # the same words come again where they are waited for
            self._begun[key] = self._threads.submit(RUNNERS[target].run, sources)

    def _part(self, name: str) -> Program:
        return self._usual if RUNNERS[name].usual else self.program

    def _key(self, target: str, option: str, part: Program | None) -> tuple[bool, str, str]:
        return part is None or part is self.program, target, option


def requested_targets(targets: Sequence[str] | None, real: str, accuracy: str = "") -> tuple[str, ...]:
    """Return the targets to measure: those named, else what has type and accuracy and is not for those who ask."""
    if targets is None:
        quick = {name for name, runner in RUNNERS.items() if not runner.by_name_only}
        having = {name for name, row in TARGETS.items() if real in row.reals and (row.shortens or not accuracy)}
        return tuple(name for name in TARGETS if name in quick & having)
    if len(targets) == 0:
        raise EmitError("no target is asked for: the list is empty; name some, or leave targets out")
    for name in targets:
        row = TARGETS[name]
        if row.functions is not None:
            raise EmitError(f"target {name} ({row.text}) has no functions to call; measure {' or '.join(RUNNERS)}")
        if real not in row.reals:
            raise EmitError(f"real type {real!r}: target {name} takes {' or '.join(row.reals)} alone")
    return tuple(dict.fromkeys(targets))


def unmeasured(targets: Sequence[str]) -> list[Unclaimed]:
    """Return the errors that we measure on no machine: of these targets nothing is claimed in numbers."""
    titles = [TARGETS[name].title for name in targets if name not in RUNNERS]
    return [Unclaimed(f"the error of {title}", f"not measured: symdyn runs no {title}") for title in titles]


def run_nowhere(program: Program, targets: Sequence[str], measured: Container[str]) -> list[Unclaimed]:
    """Return the functions of a program that are not among those measured, though some of these targets run here."""
    runs = [TARGETS[name].title for name in targets if name in RUNNERS]
    names = [
        one.function.name for one in program.routines if one.function.entries and one.function.name not in measured
    ]
    return [Unclaimed(f"the error of {name}", f"{', '.join(runs)} leaves it out") for name in names if runs]


def modules_of(program: Program, real: str, targets: Sequence[str]) -> Modules:
    """Return the built modules by name, and what is missing here or refuses the code."""
    with Building(program, real) as building:
        building.begin(targets)
        return building.modules(targets)


COLUMNS, ROWS = "columns", "rows"

WAYS: Mapping[str, Mapping[str, str]] = {
    "c": {COLUMNS: "batch", ROWS: "rows"},
    "cpp": {COLUMNS: "batch", ROWS: "rows"},
    "rust": {ROWS: "rows"},
}
"""Targets whose code for many states is run: how states may lie, and how functions of C end that take them so."""

LONGEST = 3 * REALS["double"].lanes
"""States of three blocks: no target has longer ones than C."""

NEAR = {"double": 1e-6, "float": 1e-2}
"""Share of a result's largest entry by which both ways may differ: a wrong place is off by all of it."""

UNTOUCHED = 7.0

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Blocks:
    """How the functions over many states of one target were run."""

    target: str  # which
    option: str  # of the target
    ways: tuple[str, ...]  # how states lay, columns or rows
    functions: int  # how many
    longest: int  # states; every number of them from 0 on was tried
    wrong: str  # function, way and length at which a state came out otherwise; "" for none
    without: tuple[str, ...] = ()  # functions that have a value at none of these states, so that nothing was compared

    @property
    def verdict(self) -> str:
        """One of `symdyn.verdict`: whether all states of every function came out as one by one."""
        return Verdict.of(self.functions * (not self.without), bool(self.wrong))

    @property
    def passed(self) -> bool:
        """Whether all states came out as one by one."""
        return self.verdict in Verdict.HOLD


def run_blocks(building: Building, target: str, seed: int = 1) -> Blocks:
    """Return how the code of one of `WAYS` over many states runs at every length from 0 to three blocks.

    Raises:
        BuildError: no compiler, or its own words when it refuses.
    """
    program, ways, option = building.program, WAYS[target], RUNNERS[target].many
    sources, module = building.compiled(target, option)
    library = ctypes.CDLL(str(module.path))
    opening, count, wrong = sources.stem, 0, ""
    without: list[str] = []
    for name, routine in zip(sources.functions, program.routines, strict=True):
        function = routine.function
        if not function.entries or wrong:
            continue
        count += 1
        arity = len(function.arguments) + 1
        calls = {way: bind_rows(library, f"{opening}_{name}_{ending}", arity) for way, ending in ways.items()}
        compared, wrong = _wrong(function, getattr(module, name), calls, NEAR[building.real], seed)
        without += [] if compared else [name]
    return Blocks(target, option, tuple(ways), count, LONGEST, wrong, tuple(without))


def _states(function: Function, one: Any, seed: int) -> tuple[list[Array], Array]:
    """Return arguments of states and what one at a time gives, in ever wider ranges until some have a value."""
    rng, lot = np.random.default_rng(seed), random.Random(seed)
    common = shared([argument.name for argument in function.arguments])
    given: list[Array] = []
    wanted = np.empty((0, 0))
    for wide in Sampling.WIDER:
        given = [
            np.array([Sampling([a], lot).state(wide)[0] for _ in range(LONGEST)], one.dtype)
            if a.name == POSE
            else rng.uniform(0.5, 2 * wide, (1 if a.name == common else LONGEST, len(a.symbols))).astype(one.dtype)
            for a in function.arguments
        ]
        states = [
            [values[0 if a.name == common else k] for a, values in zip(function.arguments, given, strict=True)]
            for k in range(LONGEST)
        ]
        scalar = [a.scalar for a in function.arguments]
        given_to_one = [[v[0] if single else v for single, v in zip(scalar, s, strict=True)] for s in states]
        wanted = np.array([np.ravel(one(*values)) for values in given_to_one])
        if np.isfinite(wanted).all(axis=1).any():
            break
    return given, wanted


def _wrong(function: Function, one: Any, calls: Mapping[str, Any], near: float, seed: int) -> tuple[int, str]:
    """Return at how many states a function has a value, and where it is off over many of them, "" if nowhere."""
    given, wanted = _states(function, one, seed)
    compared = int(np.isfinite(wanted).all(axis=1).sum())
    for length in range(LONGEST + 1):
        for way, call in calls.items():
            columns = way == COLUMNS
            rows = [values if len(values) == 1 else values[:length] for values in given]
            arrays = [np.ascontiguousarray(values.T if columns and len(values) > 1 else values) for values in rows]
            out = np.full(length * wanted.shape[1] + 1, UNTOUCHED, one.dtype)
            call(length, *(array.ctypes.data for array in arrays), out.ctypes.data)
            size = wanted.shape[1]
            found = out[:-1].reshape((size, length)).T if columns else out[:-1].reshape((length, size))
            if out[-1] != UNTOUCHED or not _close(found, wanted[:length], near):
                return compared, f"{function.name}, {way} of {length} states"
    return compared, ""


def _close(values: Array, requested: Array, near: float) -> bool:
    """Tell whether states came out alike; those that have no value are left out."""
    if not prod(requested.shape):
        return True
    real = np.isfinite(requested).all(axis=1)
    size = np.abs(requested[real]).max(axis=1, keepdims=True, initial=0.0)
    return bool((np.abs(values[real] - requested[real]) <= near * size).all())


NOWHERE = "no point of a field was found at which all functions are defined"


@dataclass(frozen=True)
class Texts:
    """What is known of the files of targets."""

    written: tuple[Written, ...]  # a row a file
    missing: tuple[Unclaimed, ...] = ()  # targets whose files cannot be read on this machine, and what it lacks
    unshown: tuple[Unclaimed, ...] = ()  # what nothing could be compared of, and why


def texts_of(building: Building, targets: Sequence[str], requested: bool, seed: int) -> Texts:
    """Return what is known of the files of `targets`.

    Args:
        building: what is written, with which number type.
        targets: keys of `TARGETS`; those that nothing reads are left out.
        requested: whether they were asked for by name: then files with each option are proved too.
        seed: of primes and points.
    """
    targets = [name for name in targets if name in READERS]
    if not targets:
        return Texts(())
    try:
        how = {name: _arrays_of(name, building.real) for name in targets}
        numbers = {one: printed(building.program, building.real, seed, *one) for one in set(how.values())}
    except Redraw:
        return Texts((), unshown=tuple(Unclaimed(_text_of(name), NOWHERE) for name in targets))
    found: list[Written] = []
    missing: list[Unclaimed] = []
    for name in targets:
        for option in building.options(name, requested):
            try:
                files = files_of(building.written(name, option))
                found += prove_texts(numbers[how[name]], files, languages(name, option))
            except MissingProgram as fault:
                missing.append(Unclaimed(_text_of(name), str(fault)))
                break
    return Texts(tuple(found), tuple(missing))


def unread(targets: Sequence[str]) -> list[Unclaimed]:
    """Return the texts that nothing reads back: of these targets nothing is claimed but numbers."""
    return [Unclaimed(_text_of(name), _not_read_back(name)) for name in targets if name not in READERS]


def read_back(sources: Sources, result: Mapping[str, bytes], seed: int = 1) -> tuple[Written, ...]:
    """Return what is known of the files of a target that were found, by name: these must be `sources`, made now."""
    fresh = files_of(sources)
    files = replace(fresh, contents=result)
    try:
        numbers = printed(sources.program, sources.real, seed, *_arrays_of(sources.target, sources.real))
        return prove_texts(numbers, files, languages(sources.target, sources.option), fresh.contents)
    except Redraw:
        return unshown(files, fresh.contents, NOWHERE)
    except MissingProgram as fault:
        return unshown(files, fresh.contents, str(fault))


def _arrays_of(target: str, real: str) -> tuple[bool, bool]:
    """Return whether a target has loops over tables of joints, and whether it looks up tables of numbers."""
    row, number = TARGETS[target], REALS[real]
    return row.loops_in(number), row.looks_up(number)


def why_unread(target: str) -> str:
    """Return why files of a target are not read back, and what would work; "" for those that are."""
    if target in READERS:
        return ""
    told = argument("targets", [target])
    measured = f", or verify the scene with {told}, which measures it" if target in RUNNERS else ""
    return f"{_not_read_back(target)}; give a folder of files for {' or '.join(READERS)}{measured}"


def _not_read_back(target: str) -> str:
    return f"files of target {target} ({TARGETS[target].text}) are not read back"


def _text_of(target: str) -> str:
    return f"the text of {TARGETS[target].title}"


def files_of(sources: Sources) -> Files:
    """Return the files of a target as readers take them."""
    return Files(sources.target, sources.option, sources.stem, sources.functions, dict(sources))
