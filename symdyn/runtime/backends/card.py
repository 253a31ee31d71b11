"""Kernels on a card: the files of the GPU target and what hosts call of them, compiled by nvcc, and kept.

A kernel takes columns, entry i of all states together, and gives columns; all states have one set of parameters. What
differs by library of arrays is how columns come to it.

Tests compile all this with nvcc, and run it as C++ over arrays on the CPU. It has not been run on a card.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from symdyn.emit import TARGETS, Entries, Sources, emit
from symdyn.errors import ArgumentError
from symdyn.program import Program
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
