"""The C target: C99 without allocation, needing libm alone; one function an output, in double or float.

    void <scene>_<function>(const real *q, ..., const real *params, real *out)                    one state
    void <scene>_<function>_batch(size_t n, const real *q, ..., const real *params, real *out)    structure of arrays
    void <scene>_<function>_rows(size_t n, const real *q, ..., const real *params, real *out)     array of structures

The last two are there with batch=True. Entry i of state k is q[i * n + k] for `_batch` and q[k * length + i] for
`_rows`, in `out` likewise; params, or what was prepared from it, is one set for all states, and `out` overlaps no
argument. Both run blocks of states through loops that compilers vectorise, and take sines and cosines by a routine of
their own; so does the scalar function then, when it needs several.

A long function calls parts of itself: compilers take more than linear time for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from symdyn.emit.c_batch import LANES, batches, cuts
from symdyn.emit.c_sincos import sincos_values
from symdyn.emit.names import stem
from symdyn.emit.page import compose
from symdyn.emit.real import Real, digits
from symdyn.emit.render import render
from symdyn.emit.spelling import OPERATORS, Printer, Spelling, call
from symdyn.graph import Op
from symdyn.program import Program
from symdyn.program.assemble import PARAMS, PREPARED
from symdyn.program.prepare import is_prepared


def spellings(real: Real) -> Mapping[Op, Spelling]:
    """Return the table of C for one real type: sin or sinf."""
    return {
        **OPERATORS,
        Op.SIN: call(f"sin{real.suffix}"),
        Op.COS: call(f"cos{real.suffix}"),
        Op.SQRT: call(f"sqrt{real.suffix}"),
        Op.EXP: call(EXP_HELPER),
        Op.LOG: call(f"log{real.suffix}"),
        Op.TANH: call(f"tanh{real.suffix}"),
        Op.ABS: call(f"fabs{real.suffix}"),
        Op.SIGN: call(SIGN_HELPER),
        Op.ATAN2: call(f"atan2{real.suffix}", 2),
    }


SIGN_HELPER, EXP_HELPER = "sign_of", "exp_of"
"""Functions of our own in the source file, written there when they are called."""

FLAT = {"double": -708, "float": -87}
"""Exponents below which an exponential would be denormal, and raise underflow: it is zero there."""


def emit_c(program: Program, real: Real, command: str, batch: bool = False) -> tuple[tuple[str, str], ...]:
    """Return source and header of the C target, by name; the source comes first.

    Args:
        program: what to compute.
        real: type of all numbers.
        command: for the header.
        batch: whether to add functions over many states.
    """

    def literal(value: Fraction) -> str:
        return f"{digits(value, real)}{real.suffix}"

    printer = Printer(spellings(real), literal)
    page = compose(program, printer, command)
    name = stem(program.scene.name)
    values: dict[str, Any] = {
        "page": page,
        "about": render("common/about.txt.jinja", {"page": page}).rstrip("\n"),
        "stem": name,
        "real": real.name,
        "zero": literal(Fraction(0)),
        "one": literal(Fraction(1)),
        "uses_sign": any(f"{SIGN_HELPER}(" in line.code for f in page.functions for line in f.steps + f.outputs),
        "uses_exp": any(f"{EXP_HELPER}(" in line.code for f in page.functions for line in f.steps + f.outputs),
        "flat": literal(Fraction(FLAT[real.name])),
        "suffix": real.suffix,
        "lanes": LANES,
        "common": PREPARED if is_prepared(program) else PARAMS,
        "batch": batch,
        "codes": batches(program, page, printer, real) if batch else cuts(program, page, printer),
    }
    values["cut"] = any(many and many.parts for many in values["codes"])
    values["sincos"] = any(many and many.sincos for many in values["codes"])
    values |= sincos_values(real.name) if values["sincos"] else {}
    return (
        (f"{name}.c", render("c/source.c.jinja", values)),
        (f"{name}.h", render("c/header.h.jinja", values)),
    )
