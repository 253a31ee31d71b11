"""The MATLAB target: a package of functions, one a file, for MATLAB and for Octave; many states are columns.

    +<scene>/Contents.m       what `help <scene>` shows in MATLAB
    +<scene>/mass_matrix.m    M = <scene>.mass_matrix(q, params)

Every line computes a row of numbers, one a state, so that the interpreter is asked once for all states.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from math import prod

from symdyn.emit.code.operators import OPERATORS, PRODUCT, SIGN, Printer, Spelling, call
from symdyn.emit.code.real import digits
from symdyn.emit.code.source_text import FunctionText, Line
from symdyn.emit.code.target import Draft, Target, alone
from symdyn.emit.escape import in_percent_comment
from symdyn.emit.render import render
from symdyn.errors import EmitError
from symdyn.graph import Op

SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    Op.MUL: Spelling("{} .* {}", PRODUCT, (PRODUCT, SIGN)),
    Op.DIV: Spelling("{} ./ {}", PRODUCT, (PRODUCT, SIGN)),
    Op.SIN: call("sin"),
    Op.COS: call("cos"),
    Op.SQRT: call("sqrt_of"),
    Op.EXP: call("exp"),
    Op.LOG: call("log_of"),
    Op.TANH: call("tanh"),
    Op.ABS: call("abs"),
    Op.SIGN: call("sign"),
    Op.ATAN2: call("atan2", 2),
}

OWN: Mapping[Op, str] = {Op.SQRT: "sqrt", Op.LOG: "log"}
"""What MATLAB makes complex where a real result is none; the functions of ours are NaN there."""

REAL_ALONE = frozenset((Op.ABS, Op.SIGN, Op.ATAN2))
"""What is something else of complex numbers, or nothing; all other functions may be differentiated by complex steps."""

LONGEST = 63
"""Characters of a name that MATLAB tells apart (`namelengthmax`)."""

RESERVED = """break case catch classdef continue else elseif end for function global if otherwise parfor persistent
return spmd switch try while
__FILE__ __LINE__ arguments do end_try_catch end_unwind_protect endarguments endclassdef endenumeration endevents endfor
endfunction endif endmethods endparfor endproperties endspmd endswitch endwhile enumeration events methods properties
unwind_protect unwind_protect_cleanup until"""
"""Words of MATLAB, then those of Octave and of classes."""

USED = """Contents abs atan2 class columns_of cos error exp isfloat isreal log log_of nargin ndims out real reshape sign
sin single size sqrt sqrt_of states sum tanh zeros"""
"""What a file calls by its name, and that of the file of all."""

DEVICES = [f"{port}{number}" for port in ("com", "lpt") for number in range(10)]
"""Names that no file has on Windows, with those in KEYWORDS."""

KEYWORDS = frozenset((*RESERVED.split(), *USED.split(), "aux", "con", "nul", "prn", *DEVICES))


def _write(draft: Draft) -> dict[str, str]:
    """Return the package: its contents, then a file for every function."""
    folder = f"+{draft.stem}"
    files = {f"{folder}/Contents.m": render("matlab/Contents.m.jinja", {"about": draft.about, "package": draft.stem})}
    for function in draft.page.functions:
        if len(function.name) > LONGEST:
            raise EmitError(
                f"function {function.name} has a name of {len(function.name)} characters; MATLAB knows no more than "
                f"{LONGEST}: rename what it is called after"
            )
        values = {"page": draft.page, "function": function, "package": draft.stem}
        told = render("matlab/help.txt.jinja", values).rstrip("\n")
        values |= {
            "help": in_percent_comment(told),
            "entries": _entries(function),
            "own": [name for op, name in OWN.items() if op in function.operations],
            "real": bool(REAL_ALONE & function.operations),
        }
        files[f"{folder}/{function.name}.m"] = render("matlab/function.m.jinja", values)
    return files


def _entries(function: FunctionText) -> list[tuple[int, Line]]:
    """Return each entry of a result with its row: columns one after the other, as MATLAB stores a matrix."""
    lengths = function.shape
    rows = []
    for line in function.outputs:
        index = [int(place) - 1 for place in line.target.split(", ")] if lengths else []
        rows.append((1 + sum(place * prod(lengths[:axis]) for axis, place in enumerate(index)), line))
    return rows


MATLAB = Target(
    name="matlab",
    title="MATLAB",
    text="functions for MATLAB and Octave, a column for each state; single is computed in single",
    reals=("double",),
    options={},
    files={"+{stem}/Contents.m": str, "+{stem}/{function}.m": str},
    first=1,
    keywords=KEYWORDS,
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: Printer(SPELLINGS, partial(digits, real=real)),
    comment=in_percent_comment,
    write=_write,
    beside=alone,
)
