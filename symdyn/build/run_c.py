"""The C target, compiled and loaded: its functions as Python callables."""

from __future__ import annotations

from symdyn.build.compiler import PATIENCE, find_compiler
from symdyn.build.library import load
from symdyn.build.module import CFunction, Module, bind, bind_rows
from symdyn.build.warned import check_target
from symdyn.emit import Sources, emit
from symdyn.emit.code.c import BATCH, C
from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.real import find_real
from symdyn.program import Program


def build(
    what: Program | Sources,
    compiler: str | None = None,
    real: str = "double",
    patience: float = PATIENCE,
    machine: str = "native",
    threads: int = 1,
) -> Module:
    """Return the compiled functions of a program, or of C sources that `emit` made.

    Args:
        what: a program, which gets code for batches, or sources of C, which carry their own real type.
        compiler: command to compile with; None looks for $CC, cc, gcc, clang and the ziglang package.
        real: "double" or "float", for a program.
        patience: seconds until a compiler that hangs is stopped.
        machine: "native" for code that runs on this machine, "portable" for any of its family.
        threads: on how many threads a large batch is run.

    Raises:
        BuildError: no compiler, or its own words when it refuses.
        EmitError: the program cannot be written in C.
    """
    sources = emit(what, C.name, real, option=BATCH) if isinstance(what, Program) else what
    check_target(sources, C)
    path, library = load(sources.texts, find_compiler(compiler, machine), patience)
    opening, dtype = stem(sources.program.scene.name), find_real(sources.real).dtype
    functions = tuple(
        CFunction(
            name=name,
            arguments=tuple((a.name, a.shape) for a in routine.function.arguments),
            shape=routine.function.shape,
            dtype=dtype,
            text=routine.function.text,
            _call=bind(library, f"{opening}_{name}", [a.scalar for a in routine.function.arguments], dtype),
            _rows=bind_rows(library, f"{opening}_{name}_rows", len(routine.function.arguments) + 1),
            _threads=threads,
        )
        for name, routine in zip(sources.functions, sources.program.routines, strict=True)
    )
    return Module(sources.program.scene.name, sources.real, path, functions)
