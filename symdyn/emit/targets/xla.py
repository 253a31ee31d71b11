"""What XLA calls: a handler a function, over the C target's batch code or a kernel, by XLA's interface in C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod
from typing import Any

from symdyn.emit.code.target import Sources
from symdyn.emit.render import render
from symdyn.emit.targets.gpu.cuda_opencl import END, launchers
from symdyn.program import shared

TYPES = {"double": "XLA_FFI_DataType_F64", "float": "XLA_FFI_DataType_F32"}


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
        "dtype": TYPES[sources.real],
        "operands": max((len(one.function.arguments) for one in sources.program.routines), default=1),
        "functions": functions,
    }
