"""The Julia target, a preview: a module that needs nothing, generic in the type of numbers, one state a call.

    include("two_link.jl")
    M = two_link.mass_matrix(q, params)
    two_link.mass_matrix!(M, q, params)

A literal of Julia is a Float64, which would make a Float64 of all that is computed with it: constants are converted to
the type of the arguments, T(9.81). The text is proved and never run, since no Julia is at hand.
"""

from __future__ import annotations

from functools import partial

from symdyn.emit.code.operators import OPERATORS, Printer, call
from symdyn.emit.code.real import digits
from symdyn.emit.code.target import Draft, FunctionText, Line, Target, alone
from symdyn.emit.escape import in_comment, in_julia_docstring
from symdyn.emit.render import render
from symdyn.graph import Expr, Op
from symdyn.program import Routine

SPELLINGS = {
    **OPERATORS,
    Op.SIN: call("sin"),
    Op.COS: call("cos"),
    Op.SQRT: call("sqrt"),
    Op.EXP: call("exp"),
    Op.LOG: call("log"),
    Op.TANH: call("tanh"),
    Op.ABS: call("abs"),
    Op.SIGN: call("sign"),
    Op.ATAN2: call("atan", 2),
}

KEYWORDS = """abstract baremodule begin break catch const continue do else elseif end export false finally for function
global if import in isa let local macro module mutable outer primitive public quote return struct true try type using
where while
Array Base DimensionMismatch T abs atan cos eltype eval exp float include length log out promote_type sign sin sincos
size sqrt tanh throw typeof undef"""
"""Reserved words, and what the module itself calls by its name."""


def _write(draft: Draft) -> dict[str, str]:
    """Return the module."""
    functions = draft.page.functions
    values = {
        "page": draft.page,
        "about": draft.about,
        "stem": draft.stem,
        "told": [_told(function, bool(function.shape)) for function in functions],
        "told_plain": [_told(function, False) for function in functions],
        "sizes": [_size(function) for function in functions],
        "types": [_type(function) for function in functions],
        "steps": [
            _together(routine, function) for routine, function in zip(draft.program.routines, functions, strict=True)
        ],
    }
    return {f"{draft.stem}.jl": render("julia/module.jl.jinja", values)}


def _told(function: FunctionText, puts: bool) -> str:
    """Return the docstring of a function, or of the one that puts its result; the indent keeps Markdown out."""
    names = ", ".join([*(["out"] if puts else []), *(argument.name for argument in function.arguments)])
    called = f"{function.name}{'!' if puts else ''}({names})"
    told = render("julia/doc.txt.jinja", {"function": function, "called": called, "sized": _size(function)})
    return in_julia_docstring(told.rstrip("\n"))


def _size(function: FunctionText) -> str:
    """Return the size of a result as Julia prints it."""
    return f"({', '.join(map(str, function.shape))}{',' * (len(function.shape) == 1)})"


def _type(function: FunctionText) -> str:
    """Return the type that a function computes in."""
    types = [f"{'typeof' if one.scalar else 'eltype'}({one.name})" for one in function.arguments]
    return f"float(promote_type({', '.join(types)}))" if types else "Float64"


def _together(routine: Routine, function: FunctionText) -> list[Line]:
    """Return the lines of a function, sine and cosine of one angle in one line."""
    pairs: dict[Expr, dict[Op, str]] = {}
    for step in routine.steps:
        if step.node.op in (Op.SIN, Op.COS):
            pairs.setdefault(step.node.args[0], {})[step.node.op] = step.name
    lines = []
    for step, line in zip(routine.steps, function.steps, strict=True):
        pair = pairs.get(step.node.args[0], {}) if step.node.op in (Op.SIN, Op.COS) else {}
        if len(pair) < 2:
            lines.append(line)
        elif step.name == min(pair.values(), key=[one.name for one in routine.steps].index):
            angle = line.code.split("(", 1)[1]
            lines.append(Line(f"{pair[Op.SIN]}, {pair[Op.COS]}", f"sincos({angle}"))
    return lines


JULIA = Target(
    name="julia",
    title="Julia",
    text="a module for Julia, generic in the type of numbers (preview: proved, never run)",
    reals=("double",),
    options={},
    files={"{stem}.jl": str},
    first=1,
    keywords=frozenset(KEYWORDS.split()),
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: Printer(SPELLINGS, lambda value: f"T({digits(value, real)})"),
    comment=partial(in_comment, prefix="# "),
    write=_write,
    beside=alone,
    shortens=(),
    loops=False,
)
