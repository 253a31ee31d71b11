"""The NumPy target: one module that runs with NumPy alone, for one state or a batch of them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from symdyn.emit.names import stem
from symdyn.emit.page import compose
from symdyn.emit.real import Real, digits
from symdyn.emit.render import render
from symdyn.emit.spelling import OPERATORS, Printer, Spelling, call
from symdyn.graph import Op
from symdyn.program import Program

NUMPY: Mapping[Op, Spelling] = {
    **OPERATORS,
    Op.SIN: call("numpy.sin"),
    Op.COS: call("numpy.cos"),
    Op.SQRT: call("numpy.sqrt"),
    Op.EXP: call("numpy.exp"),
    Op.LOG: call("numpy.log"),
    Op.TANH: call("numpy.tanh"),
    Op.ABS: call("numpy.abs"),
    Op.SIGN: call("numpy.sign"),
    Op.ATAN2: call("numpy.arctan2", 2),
}


def emit_numpy(program: Program, real: Real, command: str) -> tuple[tuple[str, str], ...]:
    """Return the one file of the NumPy target, by name."""
    page = compose(program, Printer(NUMPY, partial(digits, real=real)), command)
    about = render("common/about.txt.jinja", {"page": page}).rstrip("\n")
    text = render("numpy/module.py.jinja", {"page": page, "about": about, "dtype": real.dtype})
    return ((f"{stem(program.scene.name)}.py", text),)
