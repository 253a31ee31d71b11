"""Targets for array languages, which count from 1: MATLAB with Octave, and Julia, a preview.

MATLAB takes a package of functions, one a file; many states are columns.

    +<scene>/Contents.m       what `help <scene>` shows in MATLAB
    +<scene>/mass_matrix.m    M = <scene>.mass_matrix(q, params)

Every line computes a row of numbers, one a state, so that the interpreter is asked once for all states. With option
"mex" the functions are called likewise and compute nothing themselves:

    <scene>_mex.c             what MATLAB and Octave call, by columns too
    <scene>.c, <scene>.h      the C target's batch code, which that calls

Julia takes a module that needs nothing, generic in the type of numbers, one state a call.

    include("two_link.jl")
    M = two_link.mass_matrix(q, params)
    two_link.mass_matrix!(M, q, params)

A literal of Julia is a Float64, which would make a Float64 of all that is computed with it: constants are converted to
the type of the arguments, T(9.81). The text is proved and never run, since no Julia is at hand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

from symdyn.emit.code.spelling import ATOM, OPERATORS, PRODUCT, REALS, SIGN, Printer, Spelling, call, digits
from symdyn.emit.code.target import BATCH, Contents, Draft, FunctionText, Line, Target
from symdyn.emit.render import in_comment, in_julia_docstring, in_percent_comment, render
from symdyn.emit.targets.c.c_and_cpp import SELECT_HELPER, C
from symdyn.errors import EmitError
from symdyn.graph import ELEMENTARY, Expr, Op
from symdyn.program import Program, Routine, assemble, shared

MATLAB_SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    Op.MUL: Spelling("{} .* {}", PRODUCT, (PRODUCT, SIGN)),
    Op.DIV: Spelling("{} ./ {}", PRODUCT, (PRODUCT, SIGN)),
    **{op: call(op.name.lower()) for op in (*ELEMENTARY, Op.ABS, Op.SIGN)},
    Op.SQRT: call("sqrt_of"),
    Op.LOG: call("log_of"),
    Op.ATAN2: call("atan2", 2),
    Op.POW: call("pow_of", 2),
    Op.SELECT: call("select_of", 3),
}

OWN: Mapping[Op, str] = {Op.SQRT: "sqrt", Op.LOG: "log"}
"""What MATLAB makes complex where a real result is none; the functions of ours are NaN there."""

REAL_ALONE = frozenset((Op.ABS, Op.SIGN, Op.ATAN2, Op.POW, Op.SELECT))
"""What is something else of complex numbers, or nothing; all other functions may be differentiated by complex steps."""

LONGEST = 63
"""Characters of a name that MATLAB tells apart (`namelengthmax`)."""

RESERVED = """break case catch classdef continue else elseif end for function global if otherwise parfor persistent
return spmd switch try while
__FILE__ __LINE__ arguments do end_try_catch end_unwind_protect endarguments endclassdef endenumeration endevents endfor
endfunction endif endmethods endparfor endproperties endspmd endswitch endwhile enumeration events methods properties
unwind_protect unwind_protect_cleanup until"""
"""Words of MATLAB, then those of Octave and of classes."""

USED = """Contents abs atan2 class columns_of cos error exp imag isfloat isreal log log_of nargin ndims out pow_of real
reshape select_of sign sin single size sqrt sqrt_of states sum tanh zeros"""
"""What a file calls by its name, and that of the file of all."""

DEVICES = [f"{port}{number}" for port in ("com", "lpt") for number in range(10)]
"""Names that no file has on Windows, with those in MATLAB_WORDS."""

MATLAB_WORDS = frozenset((*RESERVED.split(), *USED.split(), "aux", "con", "nul", "prn", *DEVICES))


MEX = "mex"

FLAGS = "-O3 -march=native -ffp-contract=fast -fopenmp-simd -fno-math-errno"
"""What vector code takes of GCC and Clang."""


def _write_matlab(draft: Draft) -> dict[str, Contents]:
    """Return the package: its contents, then a file for every function, then C where that computes."""
    folder, mex = f"+{draft.stem}", draft.option == MEX
    about = {"about": draft.about, "package": draft.stem, "mex": mex, "flags": FLAGS}
    files: dict[str, Contents] = {f"{folder}/Contents.m": render("matlab/Contents.m.jinja", about)}
    for function in draft.page.functions:
        if len(function.name) > LONGEST:
            raise EmitError(
                f"function {function.name} has a name of {len(function.name)} characters; MATLAB knows no more than "
                f"{LONGEST}: rename what it is called after"
            )
        values = {"page": draft.page, "function": function, "package": draft.stem, "mex": mex}
        told = render("matlab/help.txt.jinja", values).rstrip("\n")
        values |= {
            "help": in_percent_comment(told),
            "entries": _entries(function),
            "own": [name for op, name in OWN.items() if op in function.operations],
            "real": bool(REAL_ALONE & function.operations),
        }
        files[f"{folder}/{function.name}.m"] = render("matlab/function.m.jinja", values)
    return files | (_gateway(draft) if mex else {})


def _gateway(draft: Draft) -> dict[str, Contents]:
    """Return the function of C that MATLAB calls, and the batch code that it calls."""
    code = C.draft(by_columns(draft.program), REALS["double"], draft.page.command, BATCH)
    functions = []
    for function, plain in zip(draft.page.functions, code.page.functions, strict=True):
        names = [argument.name for argument in function.arguments]
        common = shared(names)
        functions.append(
            {
                "name": function.name,
                "called": plain.name,
                "arguments": function.arguments,
                "common": names.index(common) if common else -1,
                "shape": function.shape,
                "size": len(function.outputs),
            }
        )
    values = {
        "about": C.comment(render("common/about.txt.jinja", {"page": code.page, "sines": None}).rstrip("\n")),
        "package": draft.stem,
        "flags": FLAGS,
        "functions": functions,
        "operands": max((1, *(len(function.arguments) for function in draft.page.functions))),
        "rank": max((1, *(len(function.shape) for function in draft.page.functions))),
        "longest": LONGEST,
    }
    return {f"{draft.stem}_mex.c": render("matlab/gateway.c.jinja", values), **C.write(code)}


def by_columns(program: Program) -> Program:
    """Return a program whose results are those of another, transposed: entries as MATLAB stores them."""
    functions = []
    for routine in program.routines:
        function = routine.function
        entries = tuple(function.entries[place] for place in _by_columns(function.shape))
        functions.append(replace(function, shape=function.shape[::-1], entries=entries, solve=None))
    return assemble(program.scene, program.graph, tuple(functions))


def _entries(function: FunctionText) -> list[tuple[int, Line]]:
    """Return each entry of a result with its row: columns one after the other, as MATLAB stores a matrix."""
    rows = {place: row for row, place in enumerate(_by_columns(function.shape), start=1)}
    return [(rows[place], line) for place, line in enumerate(function.outputs)]


def _by_columns(shape: Sequence[int]) -> list[int]:
    """Return the places of entries that are kept row by row, column by column."""
    every = list(product(*map(range, shape)))
    return sorted(range(len(every)), key=lambda place: every[place][::-1])


MATLAB = Target(
    name="matlab",
    title="MATLAB",
    text="functions for MATLAB and Octave, a column for each state; single is computed in single",
    options={MEX: "functions that call our C, which is compiled by the mex of either"},
    files={"+{stem}/Contents.m": str, "+{stem}/{function}.m": str, "{stem}_mex.c": str, **C.files},
    first=1,
    keywords=MATLAB_WORDS,
    printer=lambda real: Printer(MATLAB_SPELLINGS, partial(digits, real=real)),
    comment=in_percent_comment,
    write=_write_matlab,
)


JULIA_SPELLINGS = {
    **OPERATORS,
    **{op: call(op.name.lower()) for op in (*ELEMENTARY, Op.ABS, Op.SIGN)},
    Op.ATAN2: call("atan", 2),
    Op.POW: Spelling("{}^{}", SIGN, (ATOM, ATOM)),
    Op.SELECT: call(SELECT_HELPER, 3),
}

JULIA_WORDS = """abstract baremodule begin break catch const continue do else elseif end export false finally for
function global if import in isa let local macro module mutable outer primitive public quote return struct true try type
using where while
Array Base DimensionMismatch T abs atan cos eltype eval exp float include length log out promote_type select_of sign sin
sincos size sqrt tanh throw typeof undef"""
"""Reserved words, and what the module itself calls by its name."""


def _write_julia(draft: Draft) -> dict[str, str]:
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
    files={"{stem}.jl": str},
    first=1,
    keywords=frozenset(JULIA_WORDS.split()),
    printer=lambda real: Printer(JULIA_SPELLINGS, lambda value: f"T({digits(value, real)})"),
    comment=partial(in_comment, prefix="# "),
    write=_write_julia,
)
