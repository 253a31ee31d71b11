"""The door of this room: a program in, the text of files out."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping

from symdyn.emit.c import emit_c
from symdyn.emit.javascript import emit_js
from symdyn.emit.python import emit_numpy
from symdyn.emit.real import Real, find_real
from symdyn.emit.sources import Sources
from symdyn.emit.ufunc import emit_ufunc
from symdyn.errors import EmitError
from symdyn.program import Program
from symdyn.program.prepare import PREPARE, is_prepared
from symdyn.scene import spell

Emitter = Callable[[Program, Real, str], tuple[tuple[str, str], ...]]

TARGETS: Mapping[str, Emitter] = {"numpy": emit_numpy, "c": emit_c, "ufunc": emit_ufunc, "js": emit_js}


def emit(
    program: Program,
    target: str = "numpy",
    real: str = "double",
    command: str = "",
    batch: bool = False,
    lean: bool = False,
    doubles: bool = False,
) -> Sources:
    """Return the files that compute `program`; the same program gives the same bytes.

    Args:
        program: what to compute.
        target: "numpy", "c", "ufunc" or "js".
        real: "double" or "float".
        command: what the header says to run to make the files again; "" for the plain command line.
        batch: whether C gets functions over many states too; NumPy and ufuncs take batches anyway, JavaScript none.
        lean: whether ufuncs are of double alone and take a batch state by state, to be compiled in a tenth of the time.
        doubles: whether ufuncs are of double alone, to be compiled in half the time; batches are as fast as ever.

    Raises:
        EmitError: an unknown target, a real type that it does not have, batches of JavaScript, no function at all, two
            functions of one name, a constant too large for the type.
    """
    if target not in TARGETS:
        raise EmitError(f"target {target!r} is not known; give {' or '.join(TARGETS)}")
    if not program.routines:
        raise EmitError(f"{program.scene.name}: there is no function to write; name one, such as inverse_dynamics")
    if batch and target == "js":
        raise EmitError("JavaScript computes one state a call; leave out --batch")
    again = command or _command(program, target, real, batch)
    if batch and target == "c":
        return Sources(program, target, real, emit_c(program, find_real(real), again, batch=True))
    if target == "ufunc":
        return Sources(program, target, real, emit_ufunc(program, find_real(real), again, lean, doubles))
    return Sources(program, target, real, TARGETS[target](program, find_real(real), again))


def _command(program: Program, target: str, real: str, batch: bool) -> str:
    """Return the command line that makes the same files."""
    first = is_prepared(program)
    asked = (routine.function for routine in program.routines if not (first and routine.function.name == PREPARE))
    functions = ",".join(function.request or function.name for function in asked)
    precision = "" if real == "double" else f" --real {real}"
    many = " --batch" if batch and target == "c" else ""
    values = [f"{one.name}={spell(one.value)}" for one in program.scene.parameters if one.value is not None]
    bound = f" --bind {shlex.quote(','.join(values).replace(' ', ''))}" if values else ""
    words = f"--target {target}{precision}{many}{' --prepare' if first else ''}"
    return f"symdyn generate {program.scene.name}.toml{bound} {words} --functions {functions}"
