"""Entries of a C file, called by the addresses of arrays: its scalar function in a loop, and those for many states."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.emit import Sources, render
from symdyn.emit.code import REALS
from symdyn.program import Routine, shared
from symdyn.runtime import build

Array = npt.NDArray[Any]
States = Mapping[str, Array]
Call = Callable[[], object]
Prepare = Callable[[States], tuple[Call, Callable[[], Array]]]


def addressed_in(
    entries: Mapping[str, str], library: ctypes.CDLL, sources: Sources, real: str
) -> Iterator[tuple[str, Prepare, bool]]:
    """Yield entries of a C file: a loop over its scalar function, and with batch code those for many states."""
    (routine,) = sources.program.routines
    for entry, way in entries.items():
        call = getattr(library, f"{sources.stem}_{sources.functions[0]}_{entry}")
        call.argtypes = [ctypes.c_size_t, *[ctypes.c_void_p] * (len(routine.function.arguments) + 1)]
        call.restype = None
        yield way, _addressed(routine, call, real, columns=entry == "batch"), False


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

MANY = {entry: way for entry, way in ENTRIES.items() if entry != "each"}
"""For many states alone."""

ALONE = {"each": "C scalar, plain file"}
"""Without batch code, sines are those of the C library."""
