"""What a library of sources hands out: functions of C by their names, with the files that it is compiled of."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import prod

from symdyn.emit.code.target import Sources
from symdyn.emit.render import render
from symdyn.emit.targets.c.c99 import C
from symdyn.emit.targets.cpp import CPP, namespace
from symdyn.emit.targets.gpu.cuda_opencl import END, GPU, launchers
from symdyn.emit.targets.rust import RUST, TYPES
from symdyn.emit.targets.xla import on_card, on_cpu
from symdyn.program import shared


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
