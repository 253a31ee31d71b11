"""A program as functions that XLA calls: C with batch code and handlers, compiled, loaded and registered."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import replace

import jax
import jaxlib

from symdyn.build.compiler import PATIENCE, find_compiler
from symdyn.build.dialects import Needs
from symdyn.build.library import SUFFIX, Kind, load
from symdyn.emit import emit
from symdyn.emit.targets.c import BATCH, C
from symdyn.emit.targets.xla import handler, handlers
from symdyn.program import Program

REGISTERED: dict[str, ctypes.CDLL] = {}
"""Libraries whose handlers XLA knows, by what they are called there: they stay loaded as long as XLA may call them."""


def register(program: Program, real: str, compiler: str | None, machine: str) -> Mapping[str, str]:
    """Return what XLA calls the functions of a program, by their names; one without entries is not among them.

    A name has the hash of all that the code is made of in it: what JAX keeps compiled on disk finds the same code in
    another process, or none.

    Raises:
        BuildError: no compiler, or its own words when it refuses.
        EmitError: the program cannot be written in this type.
    """
    sources = emit(replace(program, scene=replace(program.scene, name=program.scene.name)), C.name, real, option=BATCH)
    more = handlers(sources)
    names = {name: handler(sources, name) for name in sources.functions}
    texts = {**sources.texts, **more}
    there = {name: symbol for name, symbol in names.items() if f"{symbol}(" in next(iter(more.values()))}
    needs = Needs(headers=(jax.ffi.include_dir(),), exports=tuple(there.values()))
    kind = Kind(SUFFIX, needs, ("xla", jaxlib.__version__), ctypes.CDLL)
    path, library = load(texts, find_compiler(compiler, machine), PATIENCE, kind)
    known = {}
    for (name, symbol), routine in zip(names.items(), program.routines, strict=True):
        if name not in there:
            continue
        known[routine.function.name] = target = f"symdyn_{path.stem}_{symbol}"
        if target not in REGISTERED:
            REGISTERED[target] = library
            jax.ffi.register_ffi_target(target, jax.ffi.pycapsule(getattr(library, symbol)), platform="cpu")
    return known
