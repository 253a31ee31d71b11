"""A program as functions that XLA calls: batch code or kernels, with handlers, compiled, loaded and registered."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path

import jax
import jaxlib

from symdyn.emit import C, Entries, Sources, emit
from symdyn.program import Program
from symdyn.runtime.compiler import PATIENCE, find_compiler
from symdyn.runtime.dialects import Needs
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
