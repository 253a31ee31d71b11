"""All variants of a call of one function: C by state, by block and by row, the ufunc, modules of other targets.

A C file is called by the addresses of arrays: its scalar function in a loop, and those for many states. Times of calls
are measured in turn, round after round, so that a machine that is busy for a while is so for all.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import groupby
from operator import attrgetter
from statistics import median
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.bench.reference import state_of
from symdyn.dynamics import Equations
from symdyn.emit import TARGETS, Sources, emit, render
from symdyn.emit.code import REALS, SINGLE, ShortSines
from symdyn.errors import EmitError, MissingCompiler
from symdyn.frozen import dataclass, replace
from symdyn.program import Program, Routine, lower, shared
from symdyn.runtime import RUNNERS, build, build_extension

Array = npt.NDArray[Any]
States = Mapping[str, Array]
Call = Callable[[], object]
Prepare = Callable[[States], tuple[Call, Callable[[], Array]]]


def addressed_in(
    entries: Mapping[str, str], library: ctypes.CDLL, sources: Sources, real: str
) -> Iterator[tuple[str, Prepare, bool]]:
    """Yield entries of a C file: a loop over its scalar function, and with batch code those for many states."""
    (routine,) = sources.program.routines
    for entry, variant in entries.items():
        call = getattr(library, f"{sources.stem}_{sources.functions[0]}_{entry}")
        call.argtypes = [ctypes.c_size_t, *[ctypes.c_void_p] * (len(routine.function.arguments) + 1)]
        call.restype = None
        yield variant, _addressed(routine, call, real, columns=entry == "batch"), False


def with_loop(sources: Sources, machine: str) -> ctypes.CDLL:
    """Return the library of a C file, and in it a loop over its scalar function."""
    return ctypes.CDLL(str(build(_looped(sources), machine=machine).path))


def as_it_is(sources: Sources, machine: str) -> ctypes.CDLL:
    """Return the library of a C file."""
    return ctypes.CDLL(str(build(sources, machine=machine).path))


def _looped(sources: Sources) -> Sources:
    """Return sources whose C file ends with a loop over states that calls the scalar function."""
    (routine,) = sources.program.routines
    function = routine.function
    common = shared([argument.name for argument in function.arguments])

    def code(name: str, scalar: bool, length: int) -> str:
        return name if name == common else f"{name}[k]" if scalar else f"{name} + k * {length}"

    values = {
        "name": f"{sources.stem}_{sources.functions[0]}",
        "real": REALS[sources.real].name,
        "size": len(function.entries),
        "arguments": [
            {"name": a.name, "scalar": a.scalar, "code": code(a.name, a.scalar, len(a.symbols))}
            for a in function.arguments
        ],
    }
    (file, text), *others = sources.texts.items()
    return replace(sources, files=((file, text + render("bench/each.c.jinja", values)), *others))


def _addressed(routine: Routine, function: Any, real: str, columns: bool) -> Prepare:
    """Return how an entry for many states is prepared: rows of states, or columns of entries."""
    names = [argument.name for argument in routine.function.arguments]
    common, dtype, size = shared(names), REALS[real].dtype, len(routine.function.entries)
    parts = REALS[real].parts

    def prepare(states: States) -> tuple[Call, Callable[[], Array]]:
        count = next((len(states[name]) for name in names if name != common and states[name].ndim == 2), 1)
        given = {name: _in_parts(states[name], parts) for name in names}
        arrays = [
            np.array(given[name].T if columns and name != common else given[name], dtype, order="C") for name in names
        ]
        out = np.empty((size * parts, count) if columns else (count, size * parts), dtype)
        places = [ctypes.c_void_p(array.ctypes.data) for array in (*arrays, out)]

        def call(_: Any = (arrays, out)) -> None:  # the arrays live as long as the call
            function(count, *places)

        def read() -> Array:
            found = out.T if columns else out
            return found if parts == 1 else found.reshape(count, size, parts)

        return call, read

    return prepare


def _in_parts(values: Array, parts: int) -> Array:
    """Return numbers as sums of so many along the last dimension, of which the first is all."""
    if parts == 1:
        return values
    whole = np.zeros((*values.shape, parts))
    whole[..., 0] = values
    return whole.reshape(*values.shape[:-1], -1)


ENTRIES = {"each": "C scalar", "batch": "C batch", "rows": "C rows"}

MANY = {entry: variant for entry, variant in ENTRIES.items() if entry != "each"}
"""For many states alone."""

ALONE = {"each": "C scalar, plain file"}
"""Without batch code, sines are those of the C library."""


@dataclass(frozen=True)
class Implementation:
    """One variant of a call of one function.

    Attributes:
        routine: what it computes.
        variant: such as "C batch".
        real, machine: as in `Measured`.
        generate: seconds from the scene to the text.
        compile: seconds to compile it, None where nothing is compiled.
        prepare: takes states and returns a call without arguments, and the array its results are in, shape (N, size)
            in any layout that `read` undoes; (N, size, 2) where a number is the sum of two.
        single: whether a call computes one state and is timed so.
        accuracy: as for `emit`.
    """

    routine: Routine
    variant: str
    real: str
    machine: str
    generate: float
    compile: float | None
    prepare: Prepare
    single: bool = False
    accuracy: str = ""

    def results(self, states: States) -> Array:
        """Return the results at all states, shape (N, size), or (N, size, 2) where a number is the sum of two."""
        if self.single:
            rows = range(len(next(iter(states.values()))) if states else 1)
            return np.array([self._results(state_of(states, k)).ravel() for k in rows])
        return self._results(states)

    def _results(self, states: States) -> Array:
        call, read = self.prepare(states)
        call()
        return read()


@dataclass(frozen=True)
class Built:
    """How the code of a target is built here and called.

    Attributes:
        target: key in `TARGETS`.
        option: one of its own; "" for none.
        build: takes sources and a machine; returns what has the functions.
        bind: takes that, its sources and a number type; yields variants, how each is prepared, and whether a call
            computes one state.
        machines: whether it is compiled for one machine or another.
        together: whether it takes every number type at once.
        extra: 0 for what is measured of every derivation and for every machine, 2 for what a quick look leaves out.
        accuracy: as for `emit`; measured of functions that take sines.
        real: number type that it is measured in; "" for those that are asked for.
    """

    target: str
    option: str
    build: Callable[[Sources, str], Any]
    bind: Callable[[Any, Sources, str], Iterator[tuple[str, Prepare, bool]]]
    machines: bool = True
    together: bool = False
    extra: int = 1
    accuracy: str = ""
    real: str = ""


def implementations(
    equations: Equations, derived: float, machines: Sequence[str], reals: Sequence[str], extra: int = 2
) -> Iterator[Implementation]:
    """Yield every implementation of the one function of `equations`.

    Args:
        equations: of one function.
        derived: seconds that they took.
        machines: "native", "portable", or both; () where there is no compiler.
        reals: "double", "float", or both.
        extra: how much is measured, see `Built`.

    Raises:
        BuildError: the compiler refuses.
    """
    start = time.perf_counter()
    program = lower(equations)
    derived += time.perf_counter() - start
    for machine in ("", *machines):
        most, some = (0, reals[:1]) if machine == "portable" else (extra, reals)
        here = [one for one in _every() if one.machines == bool(machine) and one.extra <= most]
        for _, rows in groupby(here, key=attrgetter("target")):
            every = tuple(rows)
            for given in [some] if every[0].together else [[real] for real in some]:
                for one in every:
                    if not one.real:
                        yield from _of(one, program, given, machine, derived)
            for one in every:
                if one.real:
                    yield from _of(one, program, (one.real,), machine, derived)


def _every() -> list[Built]:
    """Return how every target that takes many states at once is measured: in variants, or as its runner runs."""
    own = {one.target for one in BUILT}
    modules = [
        Built(name, runner.many, partial(_run, name), partial(_called, f"{TARGETS[name].title} module"), False)
        for name, runner in RUNNERS.items()
        if runner.batches and not runner.by_name_only and name not in own
    ]
    return [*modules, *BUILT]


def _run(target: str, sources: Sources, machine: str) -> Any:
    return RUNNERS[target].run(sources)


def _of(one: Built, program: Program, reals: Sequence[str], machine: str, derived: float) -> Iterator[Implementation]:
    short = ShortSines.find(one.accuracy)
    if reals[0] not in TARGETS[one.target].reals or (short and short.real != reals[0]):
        return
    if short and not program.routines[0].counts.sincos:
        return
    start = time.perf_counter()
    try:
        sources = emit(program, one.target, reals[0], option=one.option, accuracy=one.accuracy)
    except EmitError:
        if one.real:  # it has not all functions
            return
        raise
    generate = derived + time.perf_counter() - start
    start = time.perf_counter()
    try:
        module = one.build(sources, machine)
    except MissingCompiler:  # there is one, but no headers of Python; the report says so
        return
    compiled = time.perf_counter() - start if machine else None
    for real in reals:
        for variant, prepare, single in one.bind(module, sources, real):
            yield Implementation(
                program.routines[0], variant, real, machine, generate, compiled, prepare, single, one.accuracy
            )


def _called(title: str, module: Any, sources: Sources, real: str) -> Iterator[tuple[str, Prepare, bool]]:
    """Yield both variants of a call of a function of Python, if there is one."""
    call = getattr(module, sources.functions[0], None)
    for states, single in (("one state", True), ("many states", False)) if call is not None else ():
        yield f"{title}, {states}", _python(sources.program.routines[0], call, real), single


def _python(routine: Routine, function: Any, real: str) -> Prepare:
    """Return how a Python callable is prepared for states."""
    dtype = REALS[real].dtype

    def prepare(states: States) -> tuple[Call, Callable[[], Array]]:
        given = []
        for argument in routine.function.arguments:
            values = np.ascontiguousarray(states[argument.name], dtype)
            given.append(np.ascontiguousarray(values[..., 0]) if argument.scalar else values)
        held = SimpleNamespace(value=None)

        def call() -> None:
            held.value = function(*given)

        return call, lambda: np.reshape(held.value, (-1, len(routine.function.entries)))

    return prepare


BUILT = (
    Built("c", "batch", with_loop, partial(addressed_in, ENTRIES), extra=0),
    *(
        Built(
            "c",
            "batch",
            with_loop,
            partial(addressed_in, {entry: f"{ENTRIES[entry]} to {accuracy}" for entry in ENTRIES}),
            accuracy=accuracy,
        )
        for accuracy in ShortSines.accuracies()
    ),
    Built("c", "", with_loop, partial(addressed_in, ALONE), extra=2),
    *(
        Built("c", "batch", as_it_is, partial(addressed_in, MANY), extra=2, real=name)
        for name in REALS
        if name not in SINGLE
    ),
    Built(
        "ufunc",
        "",
        lambda sources, machine: build_extension(sources, machine=machine)[1],
        partial(_called, TARGETS["ufunc"].title),
        together=True,
    ),
)
"""Targets that are compiled for one machine or another, each with variants of its own."""


@dataclass(frozen=True)
class Timed:
    """A call, and how many states it computes."""

    call: Callable[[], object]
    states: int


def nanoseconds(timed: Sequence[Timed], rounds: int, seconds: float) -> list[float]:
    """Return the processor time of every call in ns a state: the median of `rounds` samples of `seconds` each."""
    turns = [_turns(one, seconds) for one in timed]
    samples: list[list[float]] = [[] for _ in timed]
    for _ in range(rounds):
        for one, count, found in zip(timed, turns, samples, strict=True):
            found.append(1e9 * _took(one, count) / (count * one.states))
    return [median(found) for found in samples]


def _took(timed: Timed, turns: int) -> float:
    call, every = timed.call, range(turns)
    start = time.thread_time()
    for _ in every:
        call()
    return time.thread_time() - start


def _turns(timed: Timed, seconds: float) -> int:
    """Return how many calls fill a sample; the first ones, which fill caches, are not measured."""
    turns = 1
    while True:
        took = _took(timed, turns)
        if took >= seconds / 4:
            return max(1, round(turns * seconds / took))
        turns *= 4 if took <= 0 else max(2, min(64, int(seconds / took)))
