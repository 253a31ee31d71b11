"""The C target: C99 without allocation, needing libm alone; one function an output, in double or float."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from symdyn.emit.names import stem
from symdyn.emit.page import compose
from symdyn.emit.real import Real, digits
from symdyn.emit.render import render
from symdyn.emit.spelling import OPERATORS, Printer, Spelling, call
from symdyn.graph import Op
from symdyn.program import Program


def spellings(real: Real) -> Mapping[Op, Spelling]:
    """Return the table of C for one real type: sin or sinf."""
    return {
        **OPERATORS,
        Op.SIN: call(f"sin{real.suffix}"),
        Op.COS: call(f"cos{real.suffix}"),
        Op.SQRT: call(f"sqrt{real.suffix}"),
        Op.EXP: call(f"exp{real.suffix}"),
        Op.LOG: call(f"log{real.suffix}"),
        Op.TANH: call(f"tanh{real.suffix}"),
        Op.ABS: call(f"fabs{real.suffix}"),
        Op.SIGN: call(SIGN_HELPER),
        Op.ATAN2: call(f"atan2{real.suffix}", 2),
    }


SIGN_HELPER = "sign_of"
"""A function of our own in the source file, written there when it is called."""


def emit_c(program: Program, real: Real, command: str) -> tuple[tuple[str, str], ...]:
    """Return source and header of the C target, by name; the source comes first."""

    def literal(value: Fraction) -> str:
        return f"{digits(value, real)}{real.suffix}"

    page = compose(program, Printer(spellings(real), literal), command)
    name = stem(program.scene.name)
    values = {
        "page": page,
        "about": render("common/about.txt.jinja", {"page": page}).rstrip("\n"),
        "stem": name,
        "real": real.name,
        "zero": literal(Fraction(0)),
        "one": literal(Fraction(1)),
        "uses_sign": any(SIGN_HELPER in line.code for f in page.functions for line in f.steps + f.outputs),
    }
    return (
        (f"{name}.c", render("c/source.c.jinja", values)),
        (f"{name}.h", render("c/header.h.jinja", values)),
    )
