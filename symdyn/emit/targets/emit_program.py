"""The function `emit`: a program in, the contents of files out."""

from __future__ import annotations

import shlex

from symdyn.emit.code.real import ShortSines, find_real
from symdyn.emit.code.target import Sources, Target
from symdyn.emit.targets.c.c99 import C
from symdyn.emit.targets.casadi import CASADI
from symdyn.emit.targets.cpp import CPP
from symdyn.emit.targets.fmu.functional_mockup import FMU
from symdyn.emit.targets.gpu.cuda_opencl import GPU
from symdyn.emit.targets.heyoka import HEYOKA
from symdyn.emit.targets.javascript import JS
from symdyn.emit.targets.json_graph import JSON
from symdyn.emit.targets.julia import JULIA
from symdyn.emit.targets.matlab import MATLAB
from symdyn.emit.targets.numpy import NUMPY
from symdyn.emit.targets.rust import RUST
from symdyn.emit.targets.ufunc import UFUNC
from symdyn.errors import EmitError
from symdyn.graph import growing
from symdyn.program import Program, in_lines
from symdyn.scene.values import spell

ELSEWHERE = {
    "wasm": "a compiler makes WebAssembly of the files of target c: zig cc --target=wasm32-wasi -O3 -s "
    "-mexec-model=reactor -fvisibility=default -rdynamic NAME.c -o NAME.wasm (docs/c.md)",
}
"""What is no target, since others make it of one: how."""


class Targets(dict[str, Target]):
    """Rows by name; one that is not there is refused, with what would work."""

    def __missing__(self, name: str) -> Target:
        """Raise EmitError."""
        instead = ELSEWHERE.get(name) or f"give {' or '.join(self)}"
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
        JSON,
    )
)


@growing()
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
    row = TARGETS[target]
    if not program.routines:
        raise EmitError(f"{program.scene.name}: there is no function to write; name one, such as inverse_dynamics")
    if option and option not in row.options:
        known = f"it has {' or '.join(row.options)}" if row.options else "leave it out"
        raise EmitError(f"target {target} ({row.text}) has no option {option}; {known}")
    number = find_real(real)
    program = program if row.loops_in(number) else in_lines(program)
    if real not in row.reals:
        raise EmitError(
            f"real type {real!r}: target {target} ({row.text}) takes {' or '.join(row.reals)} alone; leave --real out"
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
