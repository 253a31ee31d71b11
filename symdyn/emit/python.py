"""The NumPy target: one module that runs with NumPy alone, for one state or a batch of them.

Every function is written once, for people to read, with bare `sin` and `cos`. For one state the module runs that text
over plain floats. For a batch it records, the first time, which NumPy calls the text comes to, and makes them on blocks
of states with `out=`: all intermediate results share a few rows of one work space, used again and again while they lie
in the cache. Nothing is allocated line by line, and no text is compiled.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial

from symdyn.emit.names import stem
from symdyn.emit.page import FunctionText, compose
from symdyn.emit.real import Real, digits
from symdyn.emit.render import render
from symdyn.emit.spelling import OPERATORS, Printer, Spelling, call
from symdyn.graph import Op
from symdyn.program import Program

NUMPY: Mapping[Op, Spelling] = {
    **OPERATORS,
    Op.SIN: call("sin"),
    Op.COS: call("cos"),
    Op.SQRT: call("sqrt"),
    Op.EXP: call("exp"),
    Op.LOG: call("log"),
    Op.TANH: call("tanh"),
    Op.ABS: call("abs"),
    Op.SIGN: call("sign"),
    Op.ATAN2: call("atan2", 2),
}

BRANCHES: Mapping[str, tuple[str, str]] = {
    "sin": ("math.sin", "numpy.sin"),
    "cos": ("math.cos", "numpy.cos"),
    "sqrt": ("math.sqrt", "numpy.sqrt"),
    "exp": ("math.exp", "numpy.exp"),
    "log": ("math.log", "numpy.log"),
    "tanh": ("math.tanh", "numpy.tanh"),
    "sign": ("_sign", "numpy.sign"),
    "atan2": ("math.atan2", "numpy.arctan2"),
}
"""What each name stands for among plain floats and among arrays; `abs` is Python's for both."""

BLOCK = 4096
"""States that are computed at a time: enough to hide the cost of a NumPy call, few enough for the cache."""


def emit_numpy(program: Program, real: Real, command: str) -> tuple[tuple[str, str], ...]:
    """Return the one file of the NumPy target, by name."""
    page = compose(program, Printer(NUMPY, partial(digits, real=real)), command)
    used = {function.name: _used(function) for function in page.functions}
    every = [name for name in BRANCHES if any(name in names for names in used.values())]
    values = {
        "page": page,
        "about": render("common/about.txt.jinja", {"page": page}).rstrip("\n"),
        "dtype": real.dtype,
        "block": BLOCK,
        "branches": [(name, *BRANCHES[name]) for name in every],
        "used": used,
    }
    return ((f"{stem(program.scene.name)}.py", render("numpy/module.py.jinja", values)),)


def _words(code: str) -> list[str]:
    """Return the names in a piece of code, in order."""
    return re.findall(r"[A-Za-z_]\w*", code)


def _used(function: FunctionText) -> list[str]:
    """Return the mathematical functions that a function calls."""
    called = {word for line in function.steps + function.outputs for word in _words(line.code)}
    return [name for name in BRANCHES if name in called]
