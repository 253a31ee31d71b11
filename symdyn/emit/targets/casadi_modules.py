"""The target CasADi: a module of its functions, and C that it calls.

The module has functions that are CasADi's, of SX expressions, and needs CasADi alone. Where a program has a function's
derivatives too, they are its Jacobian: CasADi asks for it, and differentiates nothing. `casadi.external` takes C: our
own, and around it the interface by which CasADi calls. There products with weights, `_vjp`, are its sweep backwards, of
which `_hessian` and `_derivatives` are the Jacobian, so that Hessians of Lagrangians are ours:

    f           τ(q, q̇, q̈)                                    jac_f            J = [∂τ/∂q | ∂τ/∂q̇ | …]
    adj1_f      λᵀ J of a λ that CasADi gives                jac_adj1_f       [∂²(λᵀ τ) | Jᵀ] by arguments and λ
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import accumulate, product
from math import prod

from symdyn.dynamics import Argument, Function
from symdyn.emit.code.identifiers import function_names, names_of_c
from symdyn.emit.code.spelling import OPERATORS, Printer, Spelling, call, digits
from symdyn.emit.code.target import Draft, FunctionText, Target
from symdyn.emit.render import in_docstring, render
from symdyn.emit.targets.c.c_and_cpp import HEADER_ONLY, C
from symdyn.emit.targets.python_modules import PYTHON
from symdyn.frozen import dataclass, replace
from symdyn.graph import Op
from symdyn.program import Program
from symdyn.scene import Scene

MOVED = ("q", "qd", "qdd", "tau")
"""Arguments along which a function that takes them has all derivatives at once, in their order there."""

WHOLE, BY, PARAMETERS = "_derivatives", "_by_", "parameters"
"""Behind the name of a function: what has all of its derivatives, and those by one argument."""

BACK, BENT, WEIGHTS = "_vjp", "_hessian", "weights"
"""Behind the name of a function: what has those of a sum with weights, once and twice; and what these take."""


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
    wanted = {WHOLE: moved, **{f"{BY}{PARAMETERS if name == Program.PARAMS else name}": [name] for name in labels}}
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
    """An argument or a result of CasADi: its name, its shape, and whether all of it is zero wherever it is asked."""

    name: str
    rows: int
    columns: int
    vanishes: bool = False


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


@dataclass(frozen=True)
class _Inside:
    """Functions of a program by their names in CasADi: as they are, as text, and as our C calls them."""

    made: Mapping[str, Function]
    text: Mapping[str, FunctionText]
    name: Mapping[str, str]

    def call(self, function: str, places: Sequence[int], to: str, wanted: Sequence[int]) -> str:
        """Return a statement that calls one, its arguments at these places, if CasADi wants any of these results."""
        every = [f"arg[{k}] ? arg[{k}] : symdyn_zeros" for k in places]
        given = [
            f"*({one})" if argument.scalar else one
            for one, argument in zip(every, self.text[function].arguments, strict=True)
        ]
        condition = " || ".join(f"res[{k}]" for k in wanted)
        return f"if ({condition}) {self.name[function]}({', '.join([*given, to])});"


def external_text(
    draft: Draft, jacobians: Mapping[str, Mapping[str, JacobianBlock]], results: Mapping[str, str]
) -> str:
    """Return the file; functions of which all derivatives are there have their Jacobian, and their Hessians."""
    inner = C.draft(draft.program, draft.real, draft.page.command, HEADER_ONLY)
    (code,) = C.write(inner).values()
    assert isinstance(code, str), "a header is text"
    names, texts = [one.name for one in draft.page.functions], draft.page.functions
    inside = _Inside(
        dict(zip(names, (one.function for one in draft.program.routines), strict=True)),
        dict(zip(names, texts, strict=True)),
        {name: f"{inner.stem}_{one.name}" for name, one in zip(names, inner.page.functions, strict=True)},
    )
    functions, whole, twice = list[Called](), list[str](), list[str]()
    for function in texts:
        plain = _plain(function, inside, results[function.name])
        functions.append(plain)
        blocks = jacobians.get(function.name, {})
        if blocks and {*blocks} == {argument.name for argument in function.arguments if argument.length}:
            whole.append(function.name)
            functions.append(_jacobian(function, blocks, inside, plain))
            if more := _backwards(function, blocks, inside, plain):
                twice.append(function.name)
                functions += more
    values = {
        "page": draft.page,
        "name": f"{draft.stem}_external",
        "whole": whole,
        "twice": twice,
        "code": code.rstrip("\n"),
        "longest": max([1, *(argument.length for argument in draft.page.arguments)]),
        "copies": any(one.work for one in functions),
        "functions": functions,
    }
    return render("casadi/external.c.jinja", values)


def _turned(place: int, rows: int, width: int, first: int, columns: int, start: str = "w") -> str:
    """Return a statement that copies columns of a matrix, if CasADi wants them."""
    return f"if (res[{place}]) symdyn_turned({start}, {rows}, {width}, {first}, {columns}, res[{place}]);"


def _plain(function: FunctionText, inside: _Inside, result: str) -> Called:
    """Return what computes a function; a matrix is turned, since CasADi's are column by column."""
    rows, columns = (function.shape[0] if function.shape else 1), prod(function.shape[1:])
    turned = rows > 1 and columns > 1
    every = range(len(function.arguments))
    body = [inside.call(function.name, every, "w" if turned else "res[0]", (0,))] if rows * columns else []
    body += [_turned(0, rows, columns, 0, columns)] if turned else []
    inputs = tuple(Array(argument.name, argument.length, 1) for argument in function.arguments)
    work = rows * columns if turned else 0
    return Called(function.name, inputs, (Array(result, rows, columns),), tuple(body), work)


def _jacobian(function: FunctionText, blocks: Mapping[str, JacobianBlock], inside: _Inside, plain: Called) -> Called:
    """Return what computes the blocks of a Jacobian, each of our functions once."""
    lengths = {block.function: len(inside.text[block.function].outputs) for block in blocks.values()}
    (result,) = plain.outputs
    rows = result.rows * result.columns
    places = [argument.name for argument in function.arguments]
    body: list[str] = []
    for name in dict.fromkeys(block.function for block in blocks.values()):
        mine = [(places.index(argument), block) for argument, block in blocks.items() if block.function == name]
        body.append(inside.call(name, range(len(places)), "w", [k for k, _ in mine]))
        width = lengths[name] // rows
        body += [_turned(k, rows, width, block.first, block.end - block.first) for k, block in mine]
    return Called(
        f"jac_{function.name}",
        (*plain.inputs, Array(f"out_{result.name}", result.rows, result.columns)),
        tuple(Array(f"jac_{result.name}_{a.name}", rows, a.length) for a in function.arguments),
        tuple(body),
        max(lengths.values()),
    )


def _backwards(
    function: FunctionText, blocks: Mapping[str, JacobianBlock], inside: _Inside, plain: Called
) -> list[Called]:
    """Return the sweep backwards of a function, λᵀ J, and its Jacobian; [] where the program lacks a part of them."""
    (result,), inputs = plain.outputs, plain.inputs
    back, bent = f"{function.name}{BACK}", f"{function.name}{BENT}"
    takes = [*(one.name for one in inputs), WEIGHTS]
    there = all(one in inside.text and [a.name for a in inside.text[one].arguments] == takes for one in (back, bent))
    if not there or {block.function for block in blocks.values()} != {whole := f"{function.name}{WHOLE}"}:
        return []
    n, N = len(inputs), max(block.end for block in blocks.values())
    taken = (*range(n), n + 1)  # weights stand behind what the function returns
    weights = Array(f"adj_{result.name}", result.rows, result.columns)
    given = (*inputs, replace(result, name=f"out_{result.name}"), weights)
    slopes = tuple(Array(f"adj_{one.name}", one.rows, 1) for one in inputs)
    at = [blocks[one.name] if one.rows else JacobianBlock(whole, 0, 0) for one in inputs]
    body = [_turned(k, 1, N, one.first, one.end - one.first) for k, one in enumerate(at)]
    sweep = Called(f"adj1_{function.name}", given, slopes, (inside.call(back, taken, "w", range(n)), *body), N)
    H, across = inside.made[bent].entries, n + 2
    found = list[Array]()
    bends, turns = list[tuple[int, str]](), list[tuple[int, str]]()
    for (a, slope), (b, one) in product(enumerate(slopes), enumerate(given)):
        place, rows = across * a + b, at[a].end - at[a].first
        name = f"jac_{slope.name}_{one.name}"
        if b < n:
            first, columns = at[b].first, at[b].end - at[b].first
            zero = all(
                H[N * i + j].is_zero for i in range(at[a].first, at[a].end) for j in range(first, first + columns)
            )
            found.append(Array(name, rows, columns, zero))
            bends += [] if zero else [(place, _turned(place, rows, N, first, columns, f"w + {N * at[a].first}"))]
        else:
            found.append(Array(name, rows, one.rows * one.columns, one is not weights))
            if one is weights:
                copies = f"for (k = 0; k < {one.rows}; k++) symdyn_turned(w + {N} * k, 1, {N}, {at[a].first}, {rows}"
                turns.append((place, f"if (res[{place}]) {copies}, res[{place}] + {rows} * k);"))
    both = [
        inside.call(bent, taken, "w", [k for k, _ in bends]),
        *(line for _, line in bends),
        inside.call(whole, range(n), "w", [k for k, _ in turns]),
        *(line for _, line in turns),
    ]
    given = (*given, *(replace(one, name=f"out_{one.name}") for one in slopes))
    size = N * max(N, result.rows * result.columns)
    return [sweep, Called(f"jac_adj1_{function.name}", given, tuple(found), ("casadi_int k;", *both), size)]


CASADI_SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(f"casadi.{op.name.lower()}") for op in (Op.SIN, Op.COS, Op.SQRT, Op.EXP, Op.LOG, Op.TANH, Op.SIGN)},
    Op.ABS: call("casadi.fabs"),
    Op.ATAN2: call("casadi.atan2", 2),
    Op.POW: call("casadi.power", 2),
    Op.SELECT: call("_select_of", 3),
}

CASADI_HELPERS = ("matrix_of", "jacobian_of", "function_of", "select_of")
"""What the module has for itself, with a stroke before it, as what writes out a function."""

OF_C = """auto char const default do double enum extern float goto inline int long main register restrict short signed
sizeof static struct switch typedef union unsigned void volatile acos acosh asin asinh atan atan2 atanh cbrt ceil cos
cosh erf exp exp2 expm1 fabs fdim floor fma fmax fmin fmod hypot isgreater isless log log2 log10 memcpy
sign_of exp_of select_of remainder rint round sin sinh sqrt tan tanh trunc symdyn_turned symdyn_zeros"""
"""Reserved words of C, and what <math.h> and the file for `casadi.external` have."""

CASADI_WORDS = frozenset((*PYTHON, *CASADI_HELPERS, *OF_C.split(), "casadi", "functions", "os", "save", "sys"))
"""Reserved words, what is there unasked, and what the module has and imports."""

EXTERNAL = "external"


def _write_casadi(draft: Draft) -> dict[str, str]:
    blocks = jacobians(draft.program, CASADI_WORDS)
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
    options={EXTERNAL: "our C too, compiled for casadi.external"},
    files={"{stem}_casadi.py": str, "{stem}_external.c": str},
    keywords=CASADI_WORDS | names_of_c(),
    printer=lambda real: Printer(CASADI_SPELLINGS, partial(digits, real=real)),
    comment=in_docstring,
    write=_write_casadi,
)
