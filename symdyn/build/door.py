"""The doors of this room: compile and load in one call, and a scene's functions without any file in sight."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any, overload

from symdyn.build.compiler import PATIENCE, find_compiler
from symdyn.build.library import load
from symdyn.build.module import CFunction, Module, bind, bind_rows
from symdyn.build.words import warn_once
from symdyn.dynamics import Closing
from symdyn.emit import Sources, emit
from symdyn.emit.names import function_names, stem
from symdyn.emit.real import find_real
from symdyn.errors import BuildError, EmitError, MissingCompiler
from symdyn.program import Program, formulate, lower
from symdyn.scene import Scene

Call = Callable[..., Any]

SLOWER = "until then the functions are those of the NumPy module, which are slower"


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
        what: a program, which gets code for batches, or sources of target "c", which carry their own real type.
        compiler: command to compile with; None looks for $CC, cc, gcc, clang and the ziglang package.
        real: "double" or "float", for a program.
        patience: seconds until a compiler that hangs is stopped.
        machine: "native" for code that runs on this machine, "portable" for any of its family.
        threads: on how many threads a large batch is run.

    Raises:
        BuildError: no compiler, or its own words when it refuses.
        EmitError: the program cannot be written in C.
    """
    sources = emit(what, "c", real, batch=True) if isinstance(what, Program) else what
    if sources.target != "c":
        raise BuildError(f"sources of target {sources.target!r} cannot be compiled; give emit(program, 'c')")
    path, library = load(sources, find_compiler(compiler, machine), patience)
    routines = sources.program.routines
    names = function_names([routine.function.name for routine in routines])
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
        for name, routine in zip(names, routines, strict=True)
    )
    return Module(sources.program.scene.name, sources.real, path, functions)


@overload
def lambdify(scene: Scene, name: str, target: str = "numpy", real: str = "double", closing: Closing = ...) -> Call: ...
@overload
def lambdify(
    scene: Scene, name: tuple[str, ...], target: str = "numpy", real: str = "double", closing: Closing = ...
) -> tuple[Call, ...]: ...
def lambdify(
    scene: Scene,
    name: str | tuple[str, ...],
    target: str = "numpy",
    real: str = "double",
    closing: Closing = Closing(),  # noqa: B008  frozen
) -> Call | tuple[Call, ...]:
    """Return one of the scene's functions, or several, as callables of arrays (n,) or (..., n).

    Args:
        scene: the mechanism.
        name: a function such as "inverse_dynamics" or "pose:tool", or a tuple of them, which gives a tuple.
        target: "numpy", or "c" to compile; where there is no compiler "c" is "numpy" too, and a warning says so, once.
        real: "double" or "float".
        closing: what to choose about closed loops.

    Raises:
        DerivationError: there is no such function.
        EmitError: an unknown target or real type.
        BuildError: target "c" and a compiler that refuses, or that $CC names and is not there.
    """
    if target not in LOADERS:
        raise EmitError(f"target {target!r} is not known; give {' or '.join(LOADERS)}")
    wanted = (name,) if isinstance(name, str) else tuple(name)
    program = lower(formulate(scene, tuple(dict.fromkeys(wanted)), closing=closing))
    names = function_names([routine.function.name for routine in program.routines])
    try:
        module = LOADERS[target](emit(program, target, real, batch=True))
    except MissingCompiler as fault:
        warn_once(f"{fault}\n{SLOWER}")
        module = run_python(emit(program, "numpy", real))
    calls = dict(zip(dict.fromkeys(wanted), (getattr(module, legal) for legal in names), strict=True))
    return calls[name] if isinstance(name, str) else tuple(calls[one] for one in wanted)


def run_python(sources: Sources) -> Any:
    """Return generated Python text as a module that no file stands behind."""
    file_name, text = sources.files[0]
    module = ModuleType(stem(sources.program.scene.name))
    exec(compile(text, f"<{file_name} generated by symdyn>", "exec"), module.__dict__)
    return module


LOADERS: dict[str, Callable[[Sources], Any]] = {"numpy": run_python, "c": build}
