"""Tensors of PyTorch on a card: launchers in C, on the stream that PyTorch computes on.

A tensor (n, m) whose memory is that of a contiguous (m, n) is columns, and is taken where it lies; another one is
copied on its card. Results are such tensors, so that what one function returns the next one takes without a copy.
Nothing waits, and nothing leaves the card.

Kernels on a card: the files of the GPU target and what hosts call of them, compiled by nvcc, and kept.

A kernel takes columns, entry i of all states together, and gives columns; all states have one set of parameters. What
differs by library of arrays is how columns come to it: `torch_card.py`, `jax_card.py`.

Tests compile all this with nvcc, and run it as C++ over arrays on the CPU. It has not been run on a card.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from math import prod
from pathlib import Path
from typing import Any

import torch

from symdyn.emit import TARGETS, Entries, Sources, emit
from symdyn.errors import ArgumentError, BuildError
from symdyn.program import Program, shared
from symdyn.runtime.backends.words import Word
from symdyn.runtime.compiler import CUDA, NOTHING, find_compiler
from symdyn.runtime.library import SUFFIX, LibraryKind, load_library

GPU = TARGETS["gpu"]

Files = Mapping[str, str]

PLAIN = LibraryKind(SUFFIX, NOTHING, ("cuda",), ctypes.CDLL)


@dataclass(frozen=True)
class Kernels:
    """What makes what a library of arrays calls of a program's kernels, for one architecture; equal ones make it once.

    Attributes:
        machine: the architecture, as the compiler calls it.
        build: returns the library of files for an architecture, and its path.
        write: returns files and what is called there, of sources of target "gpu".
        open: returns what is called, of sources, these entries, and the library and its path.
    """

    machine: str
    build: Callable[[Files, str], tuple[Path, ctypes.CDLL]]
    write: Callable[[Sources], Entries]
    open: Callable[[Sources, Entries, Path, ctypes.CDLL], Any]

    def __call__(self, program: Program, real: str, _: tuple[int, ...]) -> Any:
        """Return what is called of a program's kernels in one real type."""
        sources = emit(program, GPU.name, real)
        entries = self.write(sources)
        return self.open(sources, entries, *self.build(entries.files, self.machine))


def compiled(files: Files, machine: str, kind: LibraryKind = PLAIN) -> tuple[Path, ctypes.CDLL]:
    """Return the library that nvcc makes for an architecture, kept as all that compilers make, and its path.

    Raises:
        BuildError: nvcc is not there, or refuses.
    """
    path, library = load_library(files, replace(find_compiler(language=CUDA), machine=(f"-arch={machine}",)), kind=kind)
    return path, library


def architecture(capability: Sequence[int]) -> str:
    """Return what nvcc calls cards of a compute capability.

    >>> architecture((9, 0))
    'sm_90'
    """
    return "sm_{}{}".format(*capability)


def several(function: str, place: Any, name: str, count: int) -> ArgumentError:
    """Return what is said where states on a card have sets of parameters of their own."""
    return ArgumentError(
        f"{function}: on {place} one {name} is for all states, and there are {count}; "
        "call it once for each, or on the CPU"
    )


Array = Any

REALS = {torch.float64: "double", torch.float32: "float"}


@dataclass(frozen=True)
class Card:
    """How kernels come to devices of one type.

    Attributes:
        machine: returns the architecture of a device, as the compiler calls it.
        build: returns the library of files for an architecture, and its path.
        chosen: makes a device the current one for a while.
        stream: returns the stream that work for a device goes to now, as a pointer.
    """

    machine: Callable[[Any], str]
    build: Callable[[Mapping[str, str], str], tuple[Path, ctypes.CDLL]]
    chosen: Callable[[Any], AbstractContextManager[Any]]
    stream: Callable[[Any], int]


def launch(card: Card, word: Word, given: Sequence[Array]) -> Array:
    """Return what a word computes, (..., *its shape), of tensors on one card with equal leading dimensions, or 1.

    Raises:
        ArgumentError: several sets of parameters; a kernel takes one for all states.
        BuildError: there is no compiler, it refuses, or the card does.
    """
    function, device, dtype = word.routine.function, given[0].device, given[0].dtype
    common = shared(word.names)
    fronts = [one.shape[: one.ndim - len(core)] for (_, core), one in zip(word.arguments, given, strict=True)]
    leading = tuple(torch.broadcast_shapes(*fronts))
    columns = []
    for (name, core), one in zip(word.arguments, given, strict=True):
        if name == common:
            columns.append(_set(function.name, name, one, len(core)))
        else:
            columns.append(one.expand(leading + core).reshape(prod(leading), prod(core)).T.contiguous())
    states, size = prod(leading), len(function.entries)
    out = torch.empty((size, states), dtype=dtype, device=device)
    run = word.code.ready(REALS[dtype], kernels(card, device))[word.place]
    with card.chosen(device):
        said = run(card.stream(device), states, *(one.data_ptr() for one in columns), out.data_ptr())
    if said:
        raise BuildError(f"{function.name}: {device} refused the kernel: {said.decode(errors='replace')}")
    return out.T.reshape(leading + word.shape)


def kernels(card: Card, device: Any) -> Kernels:
    """Return what makes launchers for a device."""
    return Kernels(card.machine(device), card.build, Entries.of, _launchers)


def _launchers(sources: Sources, made: Entries, _: Path, library: ctypes.CDLL) -> list[Callable[..., bytes]]:
    """Return a launcher for every function: of a stream, the number of states, and pointers."""
    found = []
    for name, routine in zip(made.symbols.values(), sources.program.routines, strict=True):
        run = getattr(library, name)
        pointers = [ctypes.c_void_p] * (len(routine.function.arguments) + 1)
        run.argtypes, run.restype = [ctypes.c_void_p, ctypes.c_size_t, *pointers], ctypes.c_char_p
        found.append(run)
    return found


def _set(function: str, name: str, given: Array, rank: int) -> Array:
    """Return the one set of parameters that all states have; dimensions in front that repeat it are left out."""
    front = given.ndim - rank
    for axis in range(front):
        if given.shape[axis] != 1 and given.stride(axis) != 0:
            raise several(function, given.device, name, given.shape[axis])
    return given[(slice(1),) * front].contiguous()


CARDS: dict[str, Card] = {
    "cuda": Card(
        lambda device: architecture(torch.cuda.get_device_capability(device)),
        compiled,
        torch.cuda.device,
        lambda device: torch.cuda.current_stream(device).cuda_stream,
    ),
}
"""By type of device; one that has no row has no kernels."""
