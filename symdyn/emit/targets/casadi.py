"""The CasADi target: a module whose functions are CasADi's, of SX expressions, and which needs CasADi alone.

Where a program has a function's derivatives too, they are its Jacobian: CasADi asks for it, and differentiates nothing.
"""

from __future__ import annotations

import builtins
import keyword
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from itertools import accumulate
from math import prod

from symdyn.dynamics.roads.named_functions import DRIVES, Argument, Function
from symdyn.emit.code.identifiers import function_names
from symdyn.emit.code.operators import OPERATORS, Printer, Spelling, call
from symdyn.emit.code.real import digits
from symdyn.emit.code.source_text import FunctionText
from symdyn.emit.code.target import Draft, Target, alone
from symdyn.emit.escape import in_docstring
from symdyn.emit.render import render
from symdyn.graph import Op
from symdyn.program import Program
from symdyn.program.assemble import PARAMS
from symdyn.scene import Scene

SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(f"casadi.{op.name.lower()}") for op in (Op.SIN, Op.COS, Op.SQRT, Op.EXP, Op.LOG, Op.TANH, Op.SIGN)},
    Op.ABS: call("casadi.fabs"),
    Op.ATAN2: call("casadi.atan2", 2),
}

BUILTINS = tuple(name for name in dir(builtins) if not name.startswith("_"))

HELPERS = ("matrix_of", "jacobian_of", "function_of")
"""What the module has for itself, with a stroke before it, as what writes out a function."""

KEYWORDS = frozenset((*keyword.kwlist, *BUILTINS, *HELPERS, "casadi", "functions", "os", "save", "sys"))
"""Reserved words, what is there unasked, and what the module has and imports."""

MOVED = ("q", "qd", "qdd", DRIVES)
"""Arguments along which a function that takes them has all derivatives at once, in their order there."""

WHOLE, BLOCK, PARAMETERS = "_derivatives", "_by_", "parameters"
"""Behind the name of a function: what has all of its derivatives, and those by one argument."""


@dataclass(frozen=True)
class Block:
    """Columns of a function of a program that are the derivatives of another one by one of its arguments.

    Attributes:
        function: its name in the module.
        first, end: the columns, the last one left out.
    """

    function: str
    first: int
    end: int


def _write(draft: Draft) -> dict[str, str]:
    """Return the module."""
    values = {
        "page": draft.page,
        "about": draft.about,
        "name": f"{draft.stem}_casadi",
        "results": {function.name: _result(function) for function in draft.page.functions},
        "rows": {f.name: f.shape[0] if f.shape else 1 for f in draft.page.functions},
        "columns": {f.name: prod(f.shape[1:]) for f in draft.page.functions},
        "jacobians": jacobians(draft.program),
    }
    return {f"{draft.stem}_casadi.py": render("casadi/module.py.jinja", values)}


def _result(function: FunctionText) -> str:
    """Return what CasADi calls the result: no two of a function's arguments and results are called alike."""
    taken = {argument.name for argument in function.arguments}
    return function.result if function.result.isidentifier() and function.result not in taken else "out"


def jacobians(program: Program) -> dict[str, dict[str, Block]]:
    """Return the blocks of Jacobians that a program has: by function, and by argument of it.

    Only where a column is the plain partial derivative by an entry of the argument, in order. Where velocities are no
    rates of coordinates, or coordinates follow others, CasADi differentiates.
    """
    every = [routine.function for routine in program.routines]
    legal = function_names([function.name for function in every], KEYWORDS)
    found = [_blocks(f, dict(zip(legal, every, strict=True)), program.scene) for f in every]
    return {name: blocks for name, blocks in zip(legal, found, strict=True) if blocks}


def _blocks(function: Function, every: Mapping[str, Function], scene: Scene) -> dict[str, Block]:
    """Return the blocks of a function's Jacobian that stand in other functions, by argument."""
    labels = {argument.name: _labels(argument, scene) for argument in function.arguments}
    moved = [name for name in labels if name in MOVED]
    wanted = {WHOLE: moved, **{f"{BLOCK}{PARAMETERS if name == PARAMS else name}": [name] for name in labels}}
    blocks: dict[str, Block] = {}
    for name, other in every.items():
        along = wanted.get(other.name.removeprefix(function.name), [])
        columns = other.labels[-1] if len(other.labels) == 2 else ()
        same = [one.name for one in other.arguments] == [*labels]
        if same and along and columns == tuple(label for one in along for label in labels[one]):
            ends = list(accumulate(len(labels[one]) for one in along))
            for one, first, end in zip(along, [0, *ends], ends, strict=False):
                blocks.setdefault(one, Block(name, first, end))
    return blocks


def _labels(argument: Argument, scene: Scene) -> tuple[str, ...]:
    """Return how the columns of plain derivatives by an argument are labelled."""
    if argument.name == DRIVES:
        return tuple(f"force on {name}" for name in scene.velocities)
    return tuple(str(symbol.value) for symbol in argument.symbols)


CASADI = Target(
    name="casadi",
    title="CasADi",
    text="functions of CasADi, which differentiates, maps and optimises them, in doubles",
    reals=("double",),
    options={},
    files={"{stem}_casadi.py": str},
    first=0,
    keywords=KEYWORDS,
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: Printer(SPELLINGS, partial(digits, real=real)),
    comment=in_docstring,
    write=_write,
    beside=alone,
)
