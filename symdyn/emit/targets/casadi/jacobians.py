"""Which functions of a program are derivatives of others, column by column: CasADi takes them for its Jacobians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate

from symdyn.dynamics import Argument, Function
from symdyn.emit.code.identifiers import function_names
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
