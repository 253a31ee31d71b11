"""A program whose functions are lines, for languages without loops and for whoever reads entries."""

from __future__ import annotations

from dataclasses import replace

from symdyn.program.formulation import formulate
from symdyn.program.lower import lower
from symdyn.program.routine import Program


def in_lines(program: Program) -> Program:
    """Return the program without loops over tables or rows; functions whose entries were left out are derived now."""
    functions = [routine.function for routine in program.routines]
    if any(function.is_loop_alone for function in functions):
        program = lower(formulate(program.scene, [function.request for function in functions]))
    elif not any(function.loop or function.solve for function in functions):
        return program
    plain = (replace(one, function=replace(one.function, loop=None, solve=None)) for one in program.routines)
    return replace(program, routines=tuple(plain))
