"""Generated C++ as Python callables: its templates for doubles, compiled behind functions of C."""

from __future__ import annotations

import ctypes

from symdyn.build.c_module import Module, functions_of
from symdyn.build.compiler import CPLUSPLUS, find_compiler
from symdyn.build.dialects import CALLS, Needs
from symdyn.build.library import SUFFIX, Kind, load_library
from symdyn.build.warned import check_target
from symdyn.emit import BATCH, CPP, Sources, namespace, render
from symdyn.emit.code import stem


def run_cpp(sources: Sources) -> Module:
    """Return the functions of sources that `emit(program, "cpp")` made, for doubles.

    Raises:
        BuildError: sources of another target, or the compiler's own words where it refuses them.
        MissingCompiler: there is no C++ compiler.
    """
    check_target(sources, CPP)
    files, exports = with_calls(sources)
    kind = Kind(SUFFIX, Needs(exports=exports), (), ctypes.CDLL)
    path, library = load_library(files, find_compiler(language=CPLUSPLUS), kind=kind)
    return Module(sources.program.scene.name, sources.real, path, functions_of(sources, library))


def with_calls(sources: Sources) -> tuple[dict[str, str], tuple[str, ...]]:
    """Return the header with a file of functions of C that call it, and what these are called."""
    opening = stem(sources.program.scene.name)
    arguments = [routine.function.arguments for routine in sources.program.routines]
    functions = list(zip(sources.functions, arguments, strict=True))
    batch = sources.option == BATCH
    values = {"stem": opening, "space": namespace(opening), "functions": functions, "batch": batch}
    text = render("cpp/calls.cpp.jinja", values)
    endings = ("", "_batch", "_rows") if batch else ("",)
    exports = tuple(f"{opening}_{name}{ending}" for name in sources.functions for ending in endings)
    return {**sources.texts, f"{opening}{CALLS}.cpp": text}, exports
