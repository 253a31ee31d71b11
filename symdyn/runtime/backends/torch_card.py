"""Tensors of PyTorch on a card: launchers in C, on the stream that PyTorch computes on.

A tensor (n, m) whose memory is that of a contiguous (m, n) is columns, and is taken where it lies; another one is
copied on its card. Results are such tensors, so that what one function returns the next one takes without a copy.
Nothing waits, and nothing leaves the card.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import torch

from symdyn.emit import Entries, Sources
from symdyn.errors import BuildError
from symdyn.program import shared
from symdyn.runtime.backends.card import Kernels, architecture, compiled, several
from symdyn.runtime.backends.words import Word

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
