"""Arrays of JAX on a card: handlers that XLA calls with columns, on the stream that it computes on.

What a handler takes is (entries, states), all leading dimensions one after another. XLA turns rows into that on the
card, and where (7, n) was transposed before, it does neither; what lacks a leading dimension it broadcasts before the
call. Nothing leaves the card. Handlers are compiled with batch code or kernels, loaded and registered here.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import jaxlib

from symdyn.emit import C, Entries, Sources, emit
from symdyn.errors import BuildError
from symdyn.program import Program, shared
from symdyn.runtime.backends.words import Kernels, Word, architecture, compiled, several
from symdyn.runtime.commands import Needs
from symdyn.runtime.compiler import PATIENCE, find_compiler
from symdyn.runtime.library import SUFFIX, LibraryKind, load_library

HEADERS, ABI = (jax.ffi.include_dir(),), ("xla", jaxlib.__version__)
"""Where XLA's header is, and whose it is."""

REGISTERED: dict[str, ctypes.CDLL] = {}
"""Libraries whose handlers XLA knows, by what they are called there: they stay loaded as long as XLA may call them."""


def register(
    program: Program, real: str, columns: Sequence[int], compiler: str | None, machine: str
) -> Mapping[tuple[str, str], str]:
    """Return what XLA calls the handlers of a program, by function and kind; one without entries has none.

    A name has the hash of all that the code is made of in it: what JAX keeps compiled on disk finds the same code in
    another process, or none.

    Raises:
        BuildError: no compiler, or its own words when it refuses.
        EmitError: the program cannot be written in this type.
    """
    sources = emit(program, C.name, real, option="batch")
    entries = Entries.of_xla(sources, columns)
    needs = Needs(headers=HEADERS, exports=tuple(entries.symbols.values()))
    kind = LibraryKind(SUFFIX, needs, ABI, ctypes.CDLL)
    path, library = load_library(entries.files, find_compiler(compiler, machine), PATIENCE, kind)
    return hand_over("cpu", sources, entries, path, library)


def hand_over(
    platform: str, _: Sources, entries: Entries, path: Path, library: ctypes.CDLL
) -> Mapping[tuple[str, str], str]:
    """Return what XLA calls handlers of a library, by function and kind, when it knows them for a platform."""
    known = {}
    for key, symbol in entries.symbols.items():
        known[key] = target = f"symdyn_{path.stem}_{symbol}"
        if target not in REGISTERED:
            REGISTERED[target] = library
            jax.ffi.register_ffi_target(target, jax.ffi.pycapsule(getattr(library, symbol)), platform=platform)
    return known


Array = Any


@dataclass(frozen=True)
class Card:
    """How kernels come to one of JAX's platforms.

    Attributes:
        machine: returns the architecture of its devices, as the compiler calls it.
        build: returns the library of files for an architecture, and its path.
        open: hands a library over to XLA, and returns what it calls the handlers.
    """

    machine: Callable[[], str]
    build: Callable[[Mapping[str, str], str], tuple[Path, ctypes.CDLL]]
    open: Callable[[Sources, Entries, Path, ctypes.CDLL], Mapping[tuple[str, str], str]]

    @property
    def kernels(self) -> Kernels:
        """What makes handlers for the devices that are there."""
        return Kernels(self.machine(), self.build, Entries.of_xla, self.open)


def over_columns(handler: str, platform: str, word: Word, leading: tuple[int, ...], *given: Array) -> Array:
    """Return what a handler computes, (*leading, *shape of the word), of arrays with these dimensions in front, or 1.

    Raises:
        ArgumentError: several sets of parameters; a kernel takes one for all states.
    """
    common, states = shared(word.names), prod(leading)
    columns = []
    for (name, core), one in zip(word.arguments, given, strict=True):
        if name == common:
            count = prod(one.shape[: one.ndim - len(core)])
            if count != 1:
                raise several(word.routine.function.name, platform, name, count)
            columns.append(one.reshape(prod(core), 1))
        else:
            columns.append(_turned(jnp.broadcast_to(one, leading + core), len(leading)).reshape(prod(core), states))
    result = jax.ShapeDtypeStruct((prod(word.shape), states), given[0].dtype)
    found = jax.ffi.ffi_call(handler, result)(*columns)
    return _turned(found.reshape(word.shape + leading), len(word.shape))


def _turned(array: Array, front: int) -> Array:
    """Return an array with so many of its dimensions from the front at the end."""
    return array.transpose(*range(front, array.ndim), *range(front))


def _architecture() -> str:
    """Return the architecture of the cards that JAX sees; of several kinds the oldest, whose code newer ones take."""
    try:
        devices = jax.local_devices(backend="cuda")
    except RuntimeError as fault:
        raise BuildError(
            f"JAX sees no card ({fault}), and kernels are compiled for the one that is there; "
            "lower for the CPU, or where a card is"
        ) from fault
    return architecture(min(tuple(map(int, one.compute_capability.split("."))) for one in devices))


KIND = LibraryKind(SUFFIX, Needs(headers=HEADERS), ("cuda", *ABI), ctypes.CDLL)

CARDS: dict[str, Card] = {"cuda": Card(_architecture, partial(compiled, kind=KIND), partial(hand_over, "CUDA"))}
"""By JAX's name of a platform; one that has no row has no kernels."""
