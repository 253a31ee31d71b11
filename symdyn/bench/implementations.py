"""Every way to call one function: C by state, by block and by row, the ufunc, modules of other targets."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.build import RUNNERS, build
from symdyn.build.extension import build_extension
from symdyn.dynamics import Equations
from symdyn.emit import TARGETS, Sources, emit
from symdyn.emit.code.c import BATCH, C
from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.real import REALS
from symdyn.emit.code.ufunc import UFUNC
from symdyn.emit.render import render
from symdyn.errors import MissingCompiler
from symdyn.program import Program, Routine, lower
from symdyn.program.assemble import shared

Array = npt.NDArray[Any]
States = Mapping[str, Array]
Call = Callable[[], object]


@dataclass(frozen=True)
class Implementation:
    """One way to call one function.

    Attributes:
        routine: what it computes.
        way: such as "C batch".
        real, machine: as in `Measured`.
        generate: seconds from the scene to the text.
        compile: seconds to compile it, None where nothing is compiled.
        prepare: takes states and returns a call without arguments, and the array its results are in, shape (N, size)
            in any layout that `read` undoes.
        single: whether a call computes one state and is timed so.
    """

    routine: Routine
    way: str
    real: str
    machine: str
    generate: float
    compile: float | None
    prepare: Callable[[States], tuple[Call, Callable[[], Array]]]
    single: bool = False

    def results(self, states: States) -> Array:
        """Return the results at all states, shape (N, size)."""
        if self.single:
            rows = range(len(next(iter(states.values()))) if states else 1)
            return np.array([self._at({name: _row(value, k) for name, value in states.items()}) for k in rows])
        call, read = self.prepare(states)
        call()
        return read()

    def _at(self, state: States) -> Array:
        call, read = self.prepare(state)
        call()
        return read().ravel()


def _row(value: Array, k: int) -> Array:
    return value[k] if value.ndim == 2 else value


def implementations(
    equations: Equations,
    derived: float,
    machines: Sequence[str],
    reals: Sequence[str],
    everything: bool = True,
    plain: bool = True,
) -> Iterator[Implementation]:
    """Yield every implementation of the one function of `equations`.

    Args:
        equations: of one function.
        derived: seconds that they took.
        machines: "native", "portable", or both; () where there is no compiler.
        reals: "double", "float", or both.
        everything: whether to add what is no other way than C, such as the NumPy module.
        plain: whether to add C files without batch code.

    Raises:
        BuildError: the compiler refuses.
    """
    start = time.perf_counter()
    program = lower(equations)
    derived += time.perf_counter() - start
    if everything:
        for name, runner in RUNNERS.items():
            if runner.batches and name not in ON_MACHINES:
                for real in reals:
                    yield from _module(program, name, real, derived)
    for machine in machines:
        for real in reals if machine == "native" else reals[:1]:
            yield from _c(program, real, machine, derived, ENTRIES, BATCH)
            if everything and plain and machine == "native":
                yield from _c(program, real, machine, derived, ALONE)
        if everything and machine == "native":
            yield from _ufunc(program, reals, machine, derived)


ON_MACHINES = (C.name, UFUNC.name)
"""Targets that are compiled for one machine or another, each with ways of its own."""


def _module(program: Program, target: str, real: str, derived: float) -> Iterator[Implementation]:
    (routine,) = program.routines
    if real not in TARGETS[target].reals:
        return
    start = time.perf_counter()
    sources = emit(program, target, real, option=RUNNERS[target].many)
    generate = derived + time.perf_counter() - start
    call = getattr(RUNNERS[target].run(sources), sources.functions[0])
    for states, single in (("one state", True), ("many states", False)):
        way = f"{TARGETS[target].title} module, {states}"
        yield Implementation(routine, way, real, "", generate, None, _python(routine, call, real), single)


def _ufunc(program: Program, reals: Sequence[str], machine: str, derived: float) -> Iterator[Implementation]:
    (routine,) = program.routines
    start = time.perf_counter()
    sources = emit(program, UFUNC.name)
    generate = derived + time.perf_counter() - start
    start = time.perf_counter()
    try:
        module = build_extension(sources, machine=machine)[1]
    except MissingCompiler:  # there is one, but no headers of Python; the report says so
        return
    compiled = time.perf_counter() - start
    call = getattr(module, sources.functions[0], None)
    for real in reals if call is not None else ():
        for way, single in (("ufunc, one state", True), ("ufunc, many states", False)):
            prepare = _python(routine, call, real)
            yield Implementation(routine, way, real, machine, generate, compiled, prepare, single)


def _python(routine: Routine, function: Any, real: str) -> Callable[[States], tuple[Call, Callable[[], Array]]]:
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


ENTRIES = {"each": "C scalar", BATCH: "C batch", "rows": "C rows"}

ALONE = {"each": "C scalar, plain file"}
"""Without batch code, sines are those of the C library."""


def _c(
    program: Program, real: str, machine: str, derived: float, entries: Mapping[str, str], option: str = ""
) -> Iterator[Implementation]:
    """Yield entries of a C file: its scalar function, and with batch code those for many states."""
    (routine,) = program.routines
    start = time.perf_counter()
    sources = emit(program, C.name, real, option=option)
    generate = derived + time.perf_counter() - start
    library, compiled = _compiled(_with_loop(sources, routine), machine)
    for entry, way in entries.items():
        call = _bound(library, sources, routine, entry)
        prepare = _addressed(routine, call, real, columns=entry == BATCH)
        yield Implementation(routine, way, real, machine, generate, compiled, prepare)


def _compiled(sources: Sources, machine: str) -> tuple[ctypes.CDLL, float]:
    start = time.perf_counter()
    path: Path = build(sources, machine=machine).path
    return ctypes.CDLL(str(path)), time.perf_counter() - start


def _with_loop(sources: Sources, routine: Routine) -> Sources:
    """Return sources whose C file ends with a loop over states that calls the scalar function."""
    function = routine.function
    common = shared([argument.name for argument in function.arguments])

    def code(name: str, scalar: bool, length: int) -> str:
        return name if name == common else f"{name}[k]" if scalar else f"{name} + k * {length}"

    values = {
        "name": f"{stem(sources.program.scene.name)}_{sources.functions[0]}",
        "real": REALS[sources.real].name,
        "size": len(function.entries),
        "arguments": [
            {"name": a.name, "scalar": a.scalar, "code": code(a.name, a.scalar, len(a.symbols))}
            for a in function.arguments
        ],
    }
    (file, text), *others = sources.texts.items()
    return replace(sources, files=((file, text + render("bench/each.c.jinja", values)), *others))


def _bound(library: ctypes.CDLL, sources: Sources, routine: Routine, entry: str) -> Any:
    call = getattr(library, f"{stem(sources.program.scene.name)}_{sources.functions[0]}_{entry}")
    call.argtypes = [ctypes.c_size_t, *[ctypes.c_void_p] * (len(routine.function.arguments) + 1)]
    call.restype = None
    return call


def _addressed(
    routine: Routine, function: Any, real: str, columns: bool
) -> Callable[[States], tuple[Call, Callable[[], Array]]]:
    """Return how an entry for many states is prepared: rows of states, or columns of entries."""
    names = [argument.name for argument in routine.function.arguments]
    common, dtype, size = shared(names), REALS[real].dtype, len(routine.function.entries)

    def prepare(states: States) -> tuple[Call, Callable[[], Array]]:
        count = next((len(states[name]) for name in names if name != common and states[name].ndim == 2), 1)
        arrays = [
            np.array(states[name].T if columns and name != common else states[name], dtype, order="C") for name in names
        ]
        out = np.empty((size, count) if columns else (count, size), dtype)
        places = [ctypes.c_void_p(array.ctypes.data) for array in (*arrays, out)]

        def call(_: Any = (arrays, out)) -> None:  # the arrays live as long as the call
            function(count, *places)

        return call, lambda: out.T if columns else out

    return prepare
