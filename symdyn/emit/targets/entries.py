"""What a library of sources hands out: functions of C by their names, with the files that it is compiled of.

XLA calls a handler a function, over the C target's batch code or a kernel, by its own interface in C.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

from symdyn.emit.code.target import Sources
from symdyn.emit.render import render
from symdyn.emit.targets.c.c99 import C
from symdyn.emit.targets.cpp import CPP, namespace
from symdyn.emit.targets.gpu import END, GPU, launchers
from symdyn.emit.targets.rust import RUST, TYPES
from symdyn.program import shared

XLA_TYPES = {"double": "XLA_FFI_DataType_F64", "float": "XLA_FFI_DataType_F32"}


COLUMNS, WEIGHTED = "columns", "weighted"
"""Handlers that multiply a matrix by directions, or by weights from the left."""

Written = tuple[dict[str, str], dict[tuple[str, str], str]]
"""Files by name, and handlers by function and kind."""


def on_cpu(sources: Sources, columns: Sequence[int] = ()) -> Written:
    """Return sources of C with batch code and the file of their handlers; as to `columns` see `xla_entries`."""
    values, kinds = _values(sources), ("", COLUMNS, WEIGHTED) if columns else ("",)
    text = render("jax/handlers.c.jinja", {**values, "columns": columns})
    return {**sources.texts, f"{sources.stem}_xla.c": text}, _made(values, kinds)


def on_card(sources: Sources) -> Written:
    """Return kernels for CUDA with launchers and a handler each as one file.

    Arrays of states are columns there; parameters are one set.
    """
    values, ((name, text),) = _values(sources), launchers(sources).items()
    more = render("jax/card_handlers.cu.jinja", {**values, "end": END})
    return {name: f"{text}\n{more}"}, _made(values, ("",))


def _made(values: Mapping[str, Any], kinds: Sequence[str]) -> dict[tuple[str, str], str]:
    opening = values["stem"]
    return {
        (one["function"], kind): f"{opening}_{one['name']}{kind and '_'}{kind}_xla"
        for one in values["functions"]
        for kind in kinds
    }


def _values(sources: Sources) -> dict[str, Any]:
    """Return what templates of handlers are told."""
    functions = []
    for spelled, routine in zip(sources.functions, sources.program.routines, strict=True):
        arguments = routine.function.arguments
        names = [one.name for one in arguments]
        common = shared(names)
        lengths = [len(one.symbols) for one in arguments]
        if 0 in (*lengths, *routine.function.shape):
            continue
        functions.append(
            {
                "name": spelled,
                "function": routine.function.name,
                "ranks": [len(one.shape) for one in arguments],
                "lengths": lengths,
                "common": names.index(common) if common else -1,
                "rank": len(routine.function.shape),
                "size": prod(routine.function.shape),
            }
        )
    return {
        "stem": sources.stem,
        "real": sources.real,
        "dtype": XLA_TYPES[sources.real],
        "operands": max((len(one.function.arguments) for one in sources.program.routines), default=1),
        "functions": functions,
    }


@dataclass(frozen=True)
class Entries:
    """Files by name, and what a library of them hands out.

    Attributes:
        files: the one to compile first.
        symbols: names of functions of C, by the function that they compute and the kind: "" for one state, "batch" and
            "rows" for many; of XLA "" for states, "columns" and "weighted" for what a matrix gives of directions, or of
            weights from the left.
    """

    files: Mapping[str, str]
    symbols: Mapping[tuple[str, str], str]

    @classmethod
    def of(cls, sources: Sources) -> Entries:
        """Return sources of C, C++, Rust or kernels for CUDA as a library of functions of C.

        Those of kernels are launchers, one each; those of others are called as the C target's are.
        """
        files, kinds, ending = ENTRIES[sources.target]
        some = kinds if sources.batch else ("",)
        names = zip(sources.program.routines, sources.functions, strict=True)
        symbols = {
            (routine.function.name, kind): f"{sources.stem}_{name}{kind and '_'}{kind}{ending}"
            for routine, name in names
            for kind in some
        }
        return cls(files(sources), symbols)

    @classmethod
    def of_xla(cls, sources: Sources, columns: Sequence[int] = ()) -> Entries:
        """Return sources of C with batch code, or kernels for CUDA, with a handler a function, which XLA calls.

        They include XLA's `xla/ffi/api/c_api.h`, which comes with jaxlib. Functions without entries have no handler.

        Args:
            sources: of target "c" with option "batch", or of target "gpu".
            columns: of a function in C that returns a matrix: columns for each argument. It gets handlers more, which
                take directions (k, columns) of each argument, or weights (k, rows), behind its own operands.
        """
        return cls(*(on_cpu(sources, columns) if sources.target == C.name else on_card(sources)))


def _of_c(sources: Sources) -> dict[str, str]:
    return sources.texts


def _of_cpp(sources: Sources) -> dict[str, str]:
    """Return the header with a file of functions of C that call it."""
    arguments = [routine.function.arguments for routine in sources.program.routines]
    functions = list(zip(sources.functions, arguments, strict=True))
    space = namespace(sources.stem)
    values = {"stem": sources.stem, "space": space, "functions": functions, "batch": sources.batch}
    return {**sources.texts, f"{sources.stem}_calls.cpp": render("cpp/calls.cpp.jinja", values)}


def _of_rust(sources: Sources) -> dict[str, str]:
    """Return the module with a file of functions of C that call it."""
    functions = [
        (name, routine.function.arguments, routine.function.shape, prod(routine.function.shape))
        for name, routine in zip(sources.functions, sources.program.routines, strict=True)
    ]
    commons = [shared([argument.name for argument in arguments]) for _, arguments, _, _ in functions]
    values = {"batch": sources.batch, "commons": commons, "stem": sources.stem, "real": TYPES[sources.real]}
    text = render("rust/calls.rs.jinja", {**values, "functions": functions})
    return {**sources.texts, f"{sources.stem}_calls.rs": text}


ENTRIES: Mapping[str, tuple[Callable[[Sources], dict[str, str]], tuple[str, ...], str]] = {
    C.name: (_of_c, ("", "batch", "rows"), ""),
    CPP.name: (_of_cpp, ("", "batch", "rows"), ""),
    RUST.name: (_of_rust, ("", "rows"), ""),
    GPU.name: (launchers, ("",), END),
}
"""By target: its files, which functions there are of each, and how their names end."""
