"""The CasADi target: a module whose functions are CasADi's, of SX expressions, and which needs CasADi alone.

Where a program has a function's derivatives too, they are its Jacobian: CasADi asks for it, and differentiates nothing.

`casadi.external` takes C: our own, and around it the interface by which CasADi calls.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from itertools import accumulate
from math import prod

from symdyn.dynamics import Argument, Function
from symdyn.emit.code.identifiers import function_names, names_of_c
from symdyn.emit.code.operators import OPERATORS, Printer, Spelling, call
from symdyn.emit.code.real import digits
from symdyn.emit.code.target import Draft, FunctionText, Target, alone
from symdyn.emit.render import in_docstring, render
from symdyn.emit.targets.c.c99 import HEADER_ONLY, C
from symdyn.emit.targets.python_modules import PYTHON
from symdyn.graph import Op
from symdyn.program import Program
from symdyn.scene import Scene

MOVED = ("q", "qd", "qdd", "tau")
"""Arguments along which a function that takes them has all derivatives at once, in their order there."""

WHOLE, BLOCK, PARAMETERS = "_derivatives", "_by_", "parameters"
"""Behind the name of a function: what has all of its derivatives, and those by one argument."""


@dataclass(frozen=True)
class JacobianBlock:
    """Columns of a function of a program that are the derivatives of another one by one of its arguments.

    Attributes:
        function: its name in the module.
        first, end: the columns, the last one left out.
    """

    function: str
    first: int
    end: int


def jacobians(program: Program, keywords: frozenset[str]) -> dict[str, dict[str, JacobianBlock]]:
    """Return the blocks of Jacobians that a program has: by function, and by argument of it.

    Only where a column is the plain partial derivative by an entry of the argument, in order. Where velocities are no
    rates of coordinates, or coordinates follow others, CasADi differentiates.
    """
    every = [routine.function for routine in program.routines]
    legal = function_names([function.name for function in every], keywords)
    found = [_blocks(f, dict(zip(legal, every, strict=True)), program.scene) for f in every]
    return {name: blocks for name, blocks in zip(legal, found, strict=True) if blocks}


def _blocks(function: Function, every: Mapping[str, Function], scene: Scene) -> dict[str, JacobianBlock]:
    """Return the blocks of a function's Jacobian that stand in other functions, by argument."""
    labels = {argument.name: _labels(argument, scene) for argument in function.arguments}
    moved = [name for name in labels if name in MOVED]
    wanted = {WHOLE: moved, **{f"{BLOCK}{PARAMETERS if name == Program.PARAMS else name}": [name] for name in labels}}
    blocks: dict[str, JacobianBlock] = {}
    for name, other in every.items():
        along = wanted.get(other.name.removeprefix(function.name), [])
        columns = other.labels[-1] if len(other.labels) == 2 else ()
        same = [one.name for one in other.arguments] == [*labels]
        if same and along and columns == tuple(label for one in along for label in labels[one]):
            ends = list(accumulate(len(labels[one]) for one in along))
            for one, first, end in zip(along, [0, *ends], ends, strict=False):
                blocks.setdefault(one, JacobianBlock(name, first, end))
    return blocks


def _labels(argument: Argument, scene: Scene) -> tuple[str, ...]:
    """Return how the columns of plain derivatives by an argument are labelled."""
    if argument.name == "tau":
        return tuple(f"force on {name}" for name in scene.velocities)
    return tuple(str(symbol.value) for symbol in argument.symbols)


@dataclass(frozen=True)
class Array:
    """An argument or a result of CasADi: its name and shape."""

    name: str
    rows: int
    columns: int


@dataclass(frozen=True)
class Called:
    """One function that CasADi calls.

    Attributes:
        name: how the library shows it.
        inputs, outputs: what it takes and returns.
        body: lines of C.
        work: numbers that it needs beside.
    """

    name: str
    inputs: tuple[Array, ...]
    outputs: tuple[Array, ...]
    body: tuple[str, ...]
    work: int


def external_text(
    draft: Draft, jacobians: Mapping[str, Mapping[str, JacobianBlock]], results: Mapping[str, str]
) -> str:
    """Return the file; functions of which all derivatives are there have their Jacobian."""
    inner = C.draft(draft.program, draft.real, draft.page.command, HEADER_ONLY)
    (code,) = C.write(inner).values()
    assert isinstance(code, str), "a header is text"
    named = zip(draft.page.functions, inner.page.functions, strict=True)
    inside = {function.name: f"{inner.stem}_{other.name}" for function, other in named}
    functions, whole = [], []
    for function in draft.page.functions:
        functions.append(_plain(function, inside[function.name], results[function.name]))
        blocks = jacobians.get(function.name, {})
        if {*blocks} == {argument.name for argument in function.arguments if argument.length}:
            whole.append(function.name)
            functions.append(_jacobian(function, blocks, inside, draft.page.functions, functions[-1]))
    values = {
        "page": draft.page,
        "name": f"{draft.stem}_external",
        "whole": whole,
        "code": code.rstrip("\n"),
        "longest": max([1, *(argument.length for argument in draft.page.arguments)]),
        "copies": any(one.work for one in functions),
        "functions": functions,
    }
    return render("casadi/external.c.jinja", values)


def _given(function: FunctionText) -> str:
    """Return the arguments of a call of our C."""
    every = [f"arg[{k}] ? arg[{k}] : symdyn_zeros" for k in range(len(function.arguments))]
    return ", ".join(
        f"*({one})" if argument.scalar else one for one, argument in zip(every, function.arguments, strict=True)
    )


def _plain(function: FunctionText, inside: str, result: str) -> Called:
    """Return what computes a function; a matrix is turned, since CasADi's are column by column."""
    rows, columns = (function.shape[0] if function.shape else 1), prod(function.shape[1:])
    turned = rows > 1 and columns > 1
    body = [f"if (res[0]) {inside}({_given(function)}, {'w' if turned else 'res[0]'});"] if rows * columns else []
    if turned:
        body.append(f"if (res[0]) symdyn_turned(w, {rows}, {columns}, 0, {columns}, res[0]);")
    inputs = tuple(Array(argument.name, argument.length, 1) for argument in function.arguments)
    work = rows * columns if turned else 0
    return Called(function.name, inputs, (Array(result, rows, columns),), tuple(body), work)


def _jacobian(
    function: FunctionText,
    blocks: Mapping[str, JacobianBlock],
    inside: Mapping[str, str],
    every: tuple[FunctionText, ...],
    plain: Called,
) -> Called:
    """Return what computes the blocks of a Jacobian, each of our functions once."""
    lengths = {one.name: len(one.outputs) for one in every}
    (result,) = plain.outputs
    rows = result.rows * result.columns
    places = [argument.name for argument in function.arguments]
    body: list[str] = []
    for name in dict.fromkeys(block.function for block in blocks.values()):
        mine = [(places.index(argument), block) for argument, block in blocks.items() if block.function == name]
        wanted = " || ".join(f"res[{k}]" for k, _ in mine)
        body.append(f"if ({wanted}) {inside[name]}({_given(function)}, w);")
        width = lengths[name] // rows
        body += [
            f"if (res[{k}]) symdyn_turned(w, {rows}, {width}, {block.first}, {block.end - block.first}, res[{k}]);"
            for k, block in mine
        ]
    return Called(
        f"jac_{function.name}",
        (*plain.inputs, Array(f"out_{result.name}", result.rows, result.columns)),
        tuple(Array(f"jac_{result.name}_{a.name}", rows, a.length) for a in function.arguments),
        tuple(body),
        max(lengths[block.function] for block in blocks.values()),
    )


SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(f"casadi.{op.name.lower()}") for op in (Op.SIN, Op.COS, Op.SQRT, Op.EXP, Op.LOG, Op.TANH, Op.SIGN)},
    Op.ABS: call("casadi.fabs"),
    Op.ATAN2: call("casadi.atan2", 2),
}

HELPERS = ("matrix_of", "jacobian_of", "function_of")
"""What the module has for itself, with a stroke before it, as what writes out a function."""

OF_C = """auto char const default do double enum extern float goto inline int long main register restrict short signed
sizeof static struct switch typedef union unsigned void volatile acos acosh asin asinh atan atan2 atanh cbrt ceil cos
cosh erf exp exp2 expm1 fabs fdim floor fma fmax fmin fmod hypot isgreater isless log log2 log10 memcpy
sign_of exp_of remainder rint round sin sinh sqrt tan tanh trunc symdyn_turned symdyn_zeros"""
"""Reserved words of C, and what <math.h> and the file for `casadi.external` have."""

KEYWORDS = frozenset((*PYTHON, *HELPERS, *OF_C.split(), "casadi", "functions", "os", "save", "sys"))
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
