"""The NumPy target: one module that runs with NumPy alone, for one state or a batch of them.

Every function is written once, for people to read, with bare `sin` and `cos`. For one state, or as few as 16, the
module runs that text over plain floats: NumPy's calls on so short arrays take longer. For a batch it records, the first
time, which NumPy calls the text comes to, and makes them on blocks of states with `out=`: all intermediate results
share a few rows of one work space, used again and again while they lie in the cache. Nothing is allocated line by line,
and no text is compiled.
"""

from __future__ import annotations

import builtins
import keyword
from collections.abc import Mapping
from functools import cache, partial
from importlib.resources import files

from symdyn.emit.code.operators import OPERATORS, Printer, Spelling, call
from symdyn.emit.code.real import REALS, SINGLE, Real, digits
from symdyn.emit.code.target import Draft, Target, alone
from symdyn.emit.escape import in_docstring
from symdyn.emit.render import render
from symdyn.graph import Op

FUNCTIONS: Mapping[Op, tuple[str, str, str]] = {
    Op.SIN: ("sin", "math.sin", "numpy.sin"),
    Op.COS: ("cos", "math.cos", "numpy.cos"),
    Op.SQRT: ("sqrt", "math.sqrt", "numpy.sqrt"),
    Op.EXP: ("exp", "math.exp", "numpy.exp"),
    Op.LOG: ("log", "math.log", "numpy.log"),
    Op.TANH: ("tanh", "math.tanh", "numpy.tanh"),
    Op.SIGN: ("sign", "_sign", "numpy.sign"),
    Op.ATAN2: ("atan2", "math.atan2", "numpy.arctan2"),
}
"""Names, and what each stands for among plain floats and among arrays; `abs` is Python's for both."""

SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(name, op.arity) for op, (name, _, _) in FUNCTIONS.items()},
    Op.ABS: call("abs"),
}

BLOCK = 4096
"""States that are computed at a time: enough to hide the cost of a NumPy call, few enough for the cache."""

RETURN = """    return numpy.fromiter(entries, numpy.float64).reshape(shape)"""
NARROW = """    with numpy.errstate(over="ignore"):  # what is too large for the type is infinity
        return numpy.fromiter(entries, numpy.float64).reshape(shape)"""
"""How floats of Python become numbers of the type; those of a narrower one may be too large for it."""

ASSIGN = """    results[...] = rows"""
ASSIGN_NARROW = """    with numpy.errstate(over="ignore"):
        results[...] = rows"""
"""The same for a few states."""

BUILTINS = tuple(name for name in dir(builtins) if not name.startswith("_"))

KEYWORDS = frozenset((*keyword.kwlist, *BUILTINS, "collections", "functools", "math", "numpy"))
"""Reserved words, what is there unasked, and what the module imports."""


def _write(draft: Draft) -> dict[str, str]:
    """Return the module."""
    used = {f.name: [op for op in FUNCTIONS if op in f.operations] for f in draft.page.functions}
    values = {
        "page": draft.page,
        "about": draft.about,
        "dtype": draft.real.dtype,
        "block": BLOCK,
        "player": player_text(draft.real, BLOCK),
        "branches": [row for op, row in FUNCTIONS.items() if any(op in ops for ops in used.values())],
        "used": {name: [FUNCTIONS[op][0] for op in ops] for name, ops in used.items()},
    }
    return {f"{draft.stem}.py": render("numpy/module.py.jinja", values)}


@cache
def player_text(real: Real, block: int) -> str:
    """Return `symdyn.emit.targets.player` as it stands in a module of a number type and of blocks of so many states."""
    text = files("symdyn.emit.targets").joinpath("player.py").read_text(encoding="utf-8")
    text = text[text.index("def _run(") :].rstrip("\n")
    if real is not REALS["double"]:
        text = text.replace(RETURN, NARROW).replace(ASSIGN, ASSIGN_NARROW)
    return text.replace("float64", real.dtype).replace("4096", str(block))


NUMPY = Target(
    name="numpy",
    title="NumPy",
    text="a module that runs with NumPy alone, for one state or a batch",
    reals=SINGLE,
    options={},
    files={"{stem}.py": str},
    first=0,
    keywords=KEYWORDS,
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: Printer(SPELLINGS, partial(digits, real=real)),
    comment=in_docstring,
    write=_write,
    beside=alone,
    shortens=(),
    loops=False,
)
