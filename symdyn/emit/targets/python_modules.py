"""Targets that are modules of Python: NumPy's, heyoka's, CasADi's.

The NumPy module runs with NumPy alone, for one state or a batch of them. Every function is written once, for people to
read, with bare `sin` and `cos`. For one state, or as few as 16, the module runs that text over plain floats: NumPy's
calls on so short arrays take longer. For a batch it records, the first time, which NumPy calls the text comes to, and
makes them on blocks of states with `out=`: all intermediate results share a few rows of one work space, used again and
again while they lie in the cache. Nothing is allocated line by line, and no text is compiled.

The heyoka module has functions that are heyoka's expressions, and the equations of motion of its integrator.

    import two_link_heyoka, heyoka
    start, pars = [0.1, 0.2, 0, 0], [1, 1, 1, 1, 9.81, 0, 0]
    run = heyoka.taylor_adaptive(two_link_heyoka.dynamics(), start, pars=pars, compact_mode=True)
    run.propagate_until(10.0)

The CasADi module has functions that are CasADi's, of SX expressions, and needs CasADi alone. Where a program has a
function's derivatives too, they are its Jacobian: CasADi asks for it, and differentiates nothing. `casadi.external`
takes C: our own, and around it the interface by which CasADi calls.
"""

from __future__ import annotations

import builtins
import keyword
from collections.abc import Mapping, Sequence
from functools import cache, partial
from importlib.resources import files
from itertools import accumulate
from math import prod

from symdyn.dynamics import Argument, Function
from symdyn.dynamics.mechanism import TIME
from symdyn.emit.code.identifiers import function_names, names_of_c
from symdyn.emit.code.spelling import OPERATORS, REALS, SINGLE, TABLE, Printer, Real, Spelling, call, digits
from symdyn.emit.code.target import ArgumentText, Draft, FunctionText, Target, alone
from symdyn.emit.render import in_docstring, render
from symdyn.emit.targets.c.c_and_cpp import HEADER_ONLY, C
from symdyn.frozen import dataclass
from symdyn.graph import Op
from symdyn.program import Program
from symdyn.scene import Scene
from symdyn.scene.values import velocity_name

FUNCTIONS: Mapping[Op, tuple[str, str, str]] = {
    Op.SIN: ("sin", "math.sin", "numpy.sin"),
    Op.COS: ("cos", "math.cos", "numpy.cos"),
    Op.SQRT: ("sqrt", "math.sqrt", "numpy.sqrt"),
    Op.EXP: ("exp", "math.exp", "numpy.exp"),
    Op.LOG: ("log", "math.log", "numpy.log"),
    Op.TANH: ("tanh", "math.tanh", "numpy.tanh"),
    Op.SIGN: ("sign", "_sign", "numpy.sign"),
    Op.ATAN2: ("atan2", "math.atan2", "numpy.arctan2"),
    Op.POW: ("pow", "math.pow", "numpy.power"),
    Op.SELECT: ("select", "_select", "_select_rows"),
}
"""Names, and what each stands for among plain floats and among arrays; `abs` is Python's for both."""

NUMPY_SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(name, op.arity) for op, (name, _, _) in FUNCTIONS.items()},
    Op.ABS: call("abs"),
    Op.TABLE: TABLE,
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

PYTHON = (*keyword.kwlist, *(name for name in dir(builtins) if not name.startswith("_")))
"""Reserved words, and what is there unasked."""

NUMPY_WORDS = frozenset((*PYTHON, "collections", "functools", "math", "numpy"))
"""Those, and what the module imports."""


def _write_numpy(draft: Draft) -> dict[str, str]:
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
    keywords=NUMPY_WORDS,
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: Printer(NUMPY_SPELLINGS, partial(digits, real=real)),
    comment=in_docstring,
    write=_write_numpy,
    beside=alone,
    shortens=(),
    loops=False,
)


HEYOKA_SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(f"heyoka.{op.name.lower()}") for op in (Op.SIN, Op.COS, Op.SQRT, Op.EXP, Op.LOG, Op.TANH)},
    **{op: call(f"heyoka.{op.name.lower()}", 2) for op in (Op.ATAN2, Op.POW)},
}

HEYOKA_LACKS: Mapping[Op, str] = {
    Op.SIGN: "a Taylor series does not step over a jump; give dry friction a smoothing, or take another target",
    Op.ABS: "a Taylor series does not step over a corner; write sqrt(x**2 + e**2), e small, or take another target",
    Op.SELECT: "a Taylor series does not step over a corner; write a smooth formula, or take another target",
}

HEYOKA_HELPERS = ("array_of", "expressions_of", "pars_of")
"""What the module has for itself, with a stroke before it, as what writes out a function."""

HEYOKA_WORDS = frozenset((*PYTHON, *HEYOKA_HELPERS, "dynamics", "heyoka", "numpy"))
"""Reserved words, what is there unasked, and what the module has and imports."""

MOTION, RATES, WHOLE_STATE = "forward_dynamics", "coordinate_rates", "state_rates"
"""Functions that equations of motion are made of; the second where velocities are no rates of coordinates, the third in
place of both where there are states of one's own."""

STATE = ("q", "qd", "internal")
"""Arguments that are heyoka's variables."""


def _write_heyoka(draft: Draft) -> dict[str, str]:
    """Return the module."""
    scene = draft.program.scene
    there = {function.name: function for function in draft.page.functions}
    plain = scene.velocities == tuple(map(velocity_name, scene.coordinates))
    own = [one.name for one in scene.states]
    wanted = (WHOLE_STATE,) if own else (MOTION,) if plain else (MOTION, RATES)
    values = {
        "page": draft.page,
        "about": draft.about,
        "missing": [name for name in wanted if name not in there],
        "motion": there.get(wanted[0]),
        "own": own,
        "rates": None if plain else there.get(RATES),
        "given": _given([there[name] for name in wanted if name in there]),
        "coordinates": list(scene.coordinates),
        "velocities": list(scene.velocities),
    }
    return {f"{draft.stem}_heyoka.py": render("heyoka/module.py.jinja", values)}


def _given(functions: Sequence[FunctionText]) -> list[tuple[ArgumentText, int]]:
    """Return the arguments beside state and time, and where heyoka's parameters for them begin: free ones first."""
    every = {one.name: one for function in functions for one in function.arguments if one.name not in (*STATE, TIME)}
    ordered = sorted(every.values(), key=lambda one: one.name not in (Program.PARAMS, Program.PREPARED))
    return list(zip(ordered, [0, *accumulate(one.length for one in ordered)], strict=False))


HEYOKA = Target(
    name="heyoka",
    title="heyoka",
    text="expressions of heyoka, ready for its Taylor series, in doubles",
    reals=("double",),
    options={},
    files={"{stem}_heyoka.py": str},
    first=0,
    keywords=HEYOKA_WORDS,
    lacks=HEYOKA_LACKS,
    functions=None,
    tunes=False,
    printer=lambda real: Printer(HEYOKA_SPELLINGS, partial(digits, real=real)),
    comment=in_docstring,
    write=_write_heyoka,
    beside=alone,
    shortens=(),
    loops=False,
)


MOVED = ("q", "qd", "qdd", "tau")
"""Arguments along which a function that takes them has all derivatives at once, in their order there."""

WHOLE, BY, PARAMETERS = "_derivatives", "_by_", "parameters"
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
        if blocks and {*blocks} == {argument.name for argument in function.arguments if argument.length}:
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


def _address(function: FunctionText) -> str:
    """Return the arguments of a call of our C."""
    every = [f"arg[{k}] ? arg[{k}] : symdyn_zeros" for k in range(len(function.arguments))]
    return ", ".join(
        f"*({one})" if argument.scalar else one for one, argument in zip(every, function.arguments, strict=True)
    )


def _plain(function: FunctionText, inside: str, result: str) -> Called:
    """Return what computes a function; a matrix is turned, since CasADi's are column by column."""
    rows, columns = (function.shape[0] if function.shape else 1), prod(function.shape[1:])
    turned = rows > 1 and columns > 1
    given = ", ".join([*([_address(function)] if function.arguments else []), "w" if turned else "res[0]"])
    body = [f"if (res[0]) {inside}({given});"] if rows * columns else []
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
        body.append(f"if ({wanted}) {inside[name]}({_address(function)}, w);")
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
    """Return the module."""
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
    reals=("double",),
    options={EXTERNAL: "our C too, compiled for casadi.external"},
    files={"{stem}_casadi.py": str, "{stem}_external.c": str},
    first=0,
    keywords=CASADI_WORDS | names_of_c(),
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: Printer(CASADI_SPELLINGS, partial(digits, real=real)),
    comment=in_docstring,
    write=_write_casadi,
    beside=alone,
    shortens=(),
    loops=False,
)
