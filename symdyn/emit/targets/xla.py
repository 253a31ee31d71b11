"""What XLA calls: a handler a function, over the C target's batch code or a kernel, by XLA's interface in C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod
from typing import Any

from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.target import Sources
from symdyn.emit.render import render
from symdyn.emit.targets.gpu.launchers import END, launchers
from symdyn.program import shared

TYPES = {"double": "XLA_FFI_DataType_F64", "float": "XLA_FFI_DataType_F32"}


COLUMNS, WEIGHTED = "_columns", "_weighted"
"""Ends of the names of handlers that multiply a matrix by directions, or by weights from the left."""


def handler(sources: Sources, function: str, kind: str = "") -> str:
    """Return what a handler of one of the functions is called."""
    return f"{stem(sources.program.scene.name)}_{function}{kind}_xla"


def handlers(sources: Sources, columns: Sequence[int] = ()) -> tuple[dict[str, str], list[str]]:
    """Return one file more for sources of C with batch code, by its name, and its handlers.

    It includes XLA's `xla/ffi/api/c_api.h`, which comes with jaxlib. Functions without entries have no handler.

    Args:
        sources: of target "c" with option "batch".
        columns: of a function that returns a matrix: columns for each argument. It gets handlers more, which take
            directions (k, columns) of each argument, or weights (k, rows), behind its own operands.
    """
    values, kinds = _values(sources), ("", COLUMNS, WEIGHTED) if columns else ("",)
    text = render("jax/handlers.c.jinja", {**values, "columns": columns})
    return {f"{values['stem']}_xla.c": text}, _made(sources, values, kinds)


def card_handlers(sources: Sources) -> tuple[dict[str, str], list[str]]:
    """Return kernels for CUDA with launchers and a handler each as one file, by its name, and the handlers.

    Arrays of states are columns there; parameters are one set. It includes the same header.

    Args:
        sources: of target "gpu".
    """
    values, ((name, text),) = _values(sources), launchers(sources)[0].items()
    more = render("jax/card_handlers.cu.jinja", {**values, "end": END})
    return {name: f"{text}\n{more}"}, _made(sources, values, ("",))


def _made(sources: Sources, values: Mapping[str, Any], kinds: Sequence[str]) -> list[str]:
    return [handler(sources, one["name"], kind) for one in values["functions"] for kind in kinds]


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
                "ranks": [len(one.shape) for one in arguments],
                "lengths": lengths,
                "common": names.index(common) if common else -1,
                "rank": len(routine.function.shape),
                "size": prod(routine.function.shape),
            }
        )
    return {
        "stem": stem(sources.program.scene.name),
        "real": sources.real,
        "dtype": TYPES[sources.real],
        "operands": max((len(one.function.arguments) for one in sources.program.routines), default=1),
        "functions": functions,
    }
