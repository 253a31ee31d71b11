"""The function `emit`: a program in, the contents of files out.

A library of sources hands out functions of C by their names, with the files that it is compiled of. XLA calls a handler
a function, over the C target's batch code or a kernel, by its own interface in C.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from math import prod
from typing import Any

from symdyn.arguments import argument, suggesting
from symdyn.emit.code.spelling import ShortSines, find_real
from symdyn.emit.code.target import Sources, Target
from symdyn.emit.render import render
from symdyn.emit.targets.acados import ACADOS
from symdyn.emit.targets.array_languages import JULIA, MATLAB
from symdyn.emit.targets.c.c_and_cpp import CPP, C, namespace
from symdyn.emit.targets.c.stack import STACK
from symdyn.emit.targets.casadi_modules import CASADI, EXTERNAL
from symdyn.emit.targets.fmu import FMU
from symdyn.emit.targets.gpu import END, GPU, launchers
from symdyn.emit.targets.javascript import JS
from symdyn.emit.targets.json_graph import JSON
from symdyn.emit.targets.python_modules import HEYOKA, NUMPY
from symdyn.emit.targets.ros2 import ROS2
from symdyn.emit.targets.rust import RUST, TYPES
from symdyn.emit.targets.ufunc import UFUNC
from symdyn.emit.writing import IN_A_SHELL
from symdyn.errors import EmitError, choice, quoted
from symdyn.frozen import dataclass
from symdyn.graph import growing
from symdyn.program import Program, in_lines, shared
from symdyn.scene.values import spell

ELSEWHERE = {
    "wasm": "a compiler makes WebAssembly of the files of target c: zig cc --target=wasm32-wasi -O3 -s "
    "-mexec-model=reactor -fvisibility=default -rdynamic NAME.c -o NAME.wasm (docs/c.md)",
}
"""What is no target, since others make it of one: how."""


SIZED = (STACK,)
"""Options that say a size; 0 where they say none."""


class Targets(dict[str, Target]):
    """Rows by name; one that is not there is refused, with what would work."""

    def __missing__(self, name: str) -> Target:
        instead = ELSEWHERE.get(name) or choice(name, self)
        raise EmitError(f"target {name!r} is not known; {instead}")


TARGETS = Targets(
    (row.name, row)
    for row in (
        NUMPY,
        C,
        UFUNC,
        JS,
        GPU,
        CASADI,
        MATLAB,
        JULIA,
        CPP,
        RUST,
        HEYOKA,
        FMU,
        ACADOS,
        ROS2,
        JSON,
    )
)


@growing()
@suggesting
def emit(
    program: Program,
    target: str = NUMPY.name,
    real: str = "double",
    command: str = "",
    option: str = "",
    accuracy: str = "",
) -> Sources:
    """Return the files that compute `program`; the same program gives the same bytes.

    Args:
        program: what to compute.
        target: a key of `TARGETS`.
        real: number type, "double" or "float"; "dd" for double-doubles, 31 digits, in C.
        command: what the header says to run to make the files again; "" for the plain command line.
        option: one of the target's, such as "batch": C gets functions over many states too.
        accuracy: faster C in double by shorter sines, whose bound the file tells; "" for those of the type.

    Raises:
        EmitError: an unknown target, a real type, an option, an accuracy or an operation that it does not have, no
            function at all, two functions of one name, a constant too large for the type.
    """
    if not isinstance(program, Program):
        raise EmitError(f"program = {quoted(program)}: give a Program; {IN_A_SHELL}")
    row = TARGETS[target]
    if not program.routines:
        raise EmitError(f"{program.scene.name}: there is no function to write; name one, such as inverse_dynamics")
    name, _, size = option.partition("=")
    if option and (name not in row.options or (size and name not in SIZED)):
        known = f"it has {' or '.join(row.options)}" if row.options else "leave it out"
        raise EmitError(f"target {target} ({row.text}) has no option {option}; {known}")
    number = find_real(real)
    beside = option == EXTERNAL and not any(one.function.is_loop_alone for one in program.routines)
    program = program if beside or row.loops_in(number) else in_lines(program, row.rows)
    if real not in row.reals:
        raise EmitError(
            f"real type {real!r}: target {target} ({row.text}) takes {' or '.join(row.reals)} alone; "
            f"leave {argument('real')} out"
        )
    sines = ShortSines.find(accuracy, real)
    if sines and option not in row.shortens:
        raise EmitError(_no_shorter(row, accuracy))
    made = row.draft(program, number, command or _command(program, row, real, option, accuracy), option, sines)
    contents = row.write(made)
    kinds = {name: type(text) for name, text in contents.items()}
    names = tuple(function.name for function in made.page.functions)
    said = {
        pattern.format(stem=made.stem, function=name): kind for pattern, kind in row.files.items() for name in names
    }
    assert kinds.items() <= said.items(), f"target {target} writes other files than it says"
    return Sources(program, target, real, option, names, tuple(contents.items()), accuracy)


def beside(sources: Sources) -> dict[str, str]:
    """Return what a user wants beside sources, by file name: an example with numbers that must come out, and its build.

    Computed in 50 digits at one state; the same sources give the same bytes.
    """
    return dict(TARGETS[sources.target].beside(sources))


def _no_shorter(target: Target, accuracy: str) -> str:
    """Return why a target has no shorter sines as it was asked for, and what has them."""
    if not target.shortens:
        there = " and ".join(name for name, row in TARGETS.items() if row.shortens)
        return (
            f"target {target.name} ({target.text}) takes the sines of its language; accuracy {accuracy} is for targets "
            f"{there}"
        )
    ways = [f"with option {one}" if one else "without an option" for one in target.shortens]
    return (
        f"target {target.name} ({target.text}) has accuracy {accuracy} {' or '.join(ways)}, not as it was asked for: "
        "there sines are the C library's"
    )


def _command(program: Program, target: Target, real: str, option: str, accuracy: str) -> str:
    """Return the command line that makes the same files."""
    first = program.is_prepared
    asked = (
        routine.function for routine in program.routines if not (first and routine.function.name == Program.PREPARE)
    )
    functions = ",".join(function.request or function.name for function in asked)
    precision = "" if real == "double" else f" --real {real}"
    precision += f" --accuracy {accuracy}" if accuracy else ""
    chosen = f" --{option}" if option else ""
    values = [f"{one.name}={spell(one.value)}" for one in program.scene.parameters if one.value is not None]
    bound = f" --bind {shlex.quote(','.join(values).replace(' ', ''))}" if values else ""
    words = f"--target {target.name}{precision}{chosen}{' --prepare' if first else ''}"
    return f"symdyn generate {program.scene.name}.toml{bound} {words} --functions {functions}"


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
    C.name: (lambda sources: sources.texts, ("", "batch", "rows"), ""),
    CPP.name: (_of_cpp, ("", "batch", "rows"), ""),
    RUST.name: (_of_rust, ("", "rows"), ""),
    GPU.name: (launchers, ("",), END),
}
"""By target: its files, which functions there are of each, and how their names end."""
