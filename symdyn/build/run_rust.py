"""Generated Rust as Python callables: the module, compiled behind functions of C."""

from __future__ import annotations

import ctypes
from math import prod

from symdyn.build.c_module import Module, functions_of
from symdyn.build.compiler import RUSTC, find_compiler
from symdyn.build.dialects import CALLS, Needs
from symdyn.build.library import SUFFIX, Kind, load_library
from symdyn.build.warned import check_target
from symdyn.emit import BATCH, RUST, TYPES, Sources, render
from symdyn.emit.code import stem
from symdyn.program import shared


def run_rust(sources: Sources) -> Module:
    """Return the functions of sources that `emit(program, "rust")` made.

    Raises:
        BuildError: sources of another target, or the compiler's own words where it refuses them.
        MissingCompiler: there is no Rust compiler.
    """
    check_target(sources, RUST)
    files, exports = with_calls(sources)
    kind = Kind(SUFFIX, Needs(exports=exports), (), ctypes.CDLL)
    path, library = load_library(files, find_compiler(language=RUSTC), kind=kind)
    return Module(sources.program.scene.name, sources.real, path, functions_of(sources, library))


def with_calls(sources: Sources) -> tuple[dict[str, str], tuple[str, ...]]:
    """Return the module with a file of functions of C that call it, and what these are called."""
    opening = stem(sources.program.scene.name)
    functions = [
        (name, routine.function.arguments, routine.function.shape, prod(routine.function.shape))
        for name, routine in zip(sources.functions, sources.program.routines, strict=True)
    ]
    batch = sources.option == BATCH
    commons = [shared([argument.name for argument in arguments]) for _, arguments, _, _ in functions]
    values = {"batch": batch, "commons": commons, "stem": opening, "real": TYPES[sources.real], "functions": functions}
    exports = tuple(f"{opening}_{name}{end}" for name in sources.functions for end in ("", "_rows")[: 1 + batch])
    return {**sources.texts, f"{opening}{CALLS}.rs": render("rust/calls.rs.jinja", values)}, exports
