"""The CasADi target: a module whose functions are CasADi's, of SX expressions, and which needs CasADi alone.

Where a program has a function's derivatives too, they are its Jacobian: CasADi asks for it, and differentiates nothing.
"""

from __future__ import annotations

import builtins
import keyword
from collections.abc import Mapping
from functools import partial
from math import prod

from symdyn.emit.code.identifiers import names_of_c
from symdyn.emit.code.operators import OPERATORS, Printer, Spelling, call
from symdyn.emit.code.real import digits
from symdyn.emit.code.source_text import FunctionText
from symdyn.emit.code.target import Draft, Target, alone
from symdyn.emit.escape import in_docstring
from symdyn.emit.render import render
from symdyn.emit.targets.casadi.external import external_text
from symdyn.emit.targets.casadi.jacobians import jacobians
from symdyn.graph import Op

SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(f"casadi.{op.name.lower()}") for op in (Op.SIN, Op.COS, Op.SQRT, Op.EXP, Op.LOG, Op.TANH, Op.SIGN)},
    Op.ABS: call("casadi.fabs"),
    Op.ATAN2: call("casadi.atan2", 2),
}

BUILTINS = tuple(name for name in dir(builtins) if not name.startswith("_"))

HELPERS = ("matrix_of", "jacobian_of", "function_of")
"""What the module has for itself, with a stroke before it, as what writes out a function."""

OF_C = """auto char const default do double enum extern float goto inline int long main register restrict short signed
sizeof static struct switch typedef union unsigned void volatile acos acosh asin asinh atan atan2 atanh cbrt ceil cos
cosh erf exp exp2 expm1 fabs fdim floor fma fmax fmin fmod hypot isgreater isless log log2 log10 memcpy
sign_of exp_of remainder rint round sin sinh sqrt tan tanh trunc symdyn_turned symdyn_zeros"""
"""Reserved words of C, and what <math.h> and the file for `casadi.external` have."""

KEYWORDS = frozenset(
    (*keyword.kwlist, *BUILTINS, *HELPERS, *OF_C.split(), "casadi", "functions", "os", "save", "sys")
)  # fmt: skip
"""Reserved words, what is there unasked, and what the module has and imports."""

EXTERNAL = "external"


def _write(draft: Draft) -> dict[str, str]:
    """Return the module."""
    blocks = jacobians(draft.program, KEYWORDS)
    results = {function.name: _result(function) for function in draft.page.functions}
    values = {
        "page": draft.page,
        "about": draft.about,
        "name": f"{draft.stem}_casadi",
        "results": results,
        "rows": {f.name: f.shape[0] if f.shape else 1 for f in draft.page.functions},
        "columns": {f.name: prod(f.shape[1:]) for f in draft.page.functions},
        "jacobians": blocks,
    }
    files = {f"{draft.stem}_casadi.py": render("casadi/module.py.jinja", values)}
    if draft.option == EXTERNAL:
        files[f"{draft.stem}_external.c"] = external_text(draft, blocks, results)
    return files


def _result(function: FunctionText) -> str:
    """Return what CasADi calls the result: no two of a function's arguments and results are called alike."""
    taken = {argument.name for argument in function.arguments}
    return function.result if function.result.isidentifier() and function.result not in taken else "out"


CASADI = Target(
    name="casadi",
    title="CasADi",
    text="functions of CasADi, which differentiates, maps and optimises them, in doubles",
    reals=("double",),
    options={EXTERNAL: "our C too, compiled for casadi.external"},
    files={"{stem}_casadi.py": str, "{stem}_external.c": str},
    first=0,
    keywords=KEYWORDS | names_of_c(),
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
