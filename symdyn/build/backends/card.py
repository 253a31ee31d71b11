"""Tensors of PyTorch on a card: the kernels of the GPU target, on the stream that PyTorch computes on.

A kernel takes columns, entry i of all states together. So does a tensor (n, m) whose memory is that of a contiguous
(m, n), and it is taken where it lies; another one is copied on its card. Results are such tensors, so that what one
function returns the next one takes without a copy. Nothing waits, and nothing leaves the card.

Tests compile all this with nvcc, and run it as C++ over tensors on the CPU. It has not been run on a card.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from math import prod
from typing import Any

import torch

from symdyn.build.backends.words import Word
from symdyn.build.compiler import CUDA, NOTHING, find_compiler
from symdyn.build.library import SUFFIX, Kind, load
from symdyn.emit import emit
from symdyn.emit.targets.gpu import GPU
from symdyn.emit.targets.gpu.launchers import launchers
from symdyn.errors import ArgumentError, BuildError
from symdyn.program import Program
from symdyn.program.assemble import shared

Array = Any

REALS = {torch.float64: "double", torch.float32: "float"}


@dataclass(frozen=True)
class Card:
    """How kernels come to devices of one type.

    Attributes:
        machine: returns the architecture of a device, as the compiler calls it.
        build: returns the library of files for an architecture.
        chosen: makes a device the current one for a while.
        stream: returns the stream that work for a device goes to now, as a pointer.
    """

    machine: Callable[[Any], str]
    build: Callable[[Mapping[str, str], str], ctypes.CDLL]
    chosen: Callable[[Any], AbstractContextManager[Any]]
    stream: Callable[[Any], int]


@dataclass(frozen=True)
class Kernels:
    """What makes the launchers of a program, for one architecture."""

    card: Card
    machine: str

    def __call__(self, program: Program, real: str, _: tuple[int, ...]) -> list[Callable[..., bytes]]:
        """Return a launcher for every function: of a stream, the number of states, and pointers."""
        files, names = launchers(emit(program, GPU.name, real))
        library = self.card.build(files, self.machine)
        found = []
        for name, routine in zip(names, program.routines, strict=True):
            run = getattr(library, name)
            pointers = [ctypes.c_void_p] * (len(routine.function.arguments) + 1)
            run.argtypes, run.restype = [ctypes.c_void_p, ctypes.c_size_t, *pointers], ctypes.c_char_p
            found.append(run)
        return found


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
    run = word.code.ready(REALS[dtype], Kernels(card, card.machine(device)))[word.place]
    with card.chosen(device):
        said = run(card.stream(device), states, *(one.data_ptr() for one in columns), out.data_ptr())
    if said:
        raise BuildError(f"{function.name}: {device} refused the kernel: {said.decode(errors='replace')}")
    return out.T.reshape(leading + word.shape)


def _set(function: str, name: str, given: Array, rank: int) -> Array:
    """Return the one set of parameters that all states have; dimensions in front that repeat it are left out."""
    front = given.ndim - rank
    for axis in range(front):
        if given.shape[axis] != 1 and given.stride(axis) != 0:
            raise ArgumentError(
                f"{function}: on {given.device} one {name} is for all states, and there are {given.shape[axis]}; "
                "call it once for each, or on the CPU"
            )
    return given[(slice(1),) * front].contiguous()


def _compiled(files: Mapping[str, str], machine: str) -> ctypes.CDLL:
    """Return the library that nvcc makes, kept as all that compilers make."""
    compiler = replace(find_compiler(language=CUDA), machine=(f"-arch={machine}",))
    library: ctypes.CDLL = load(files, compiler, kind=Kind(SUFFIX, NOTHING, ("cuda",), ctypes.CDLL))[1]
    return library


def _architecture(device: Any) -> str:
    return "sm_{}{}".format(*torch.cuda.get_device_capability(device))


CARDS: dict[str, Card] = {
    "cuda": Card(
        _architecture,
        _compiled,
        torch.cuda.device,
        lambda device: torch.cuda.current_stream(device).cuda_stream,
    ),
}
"""By type of device; one that has no row has no kernels."""
