"""The noun that the derivation hands to everybody else: named functions on one graph."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene


@dataclass(frozen=True)
class Argument:
    """One argument of a function: a vector, or one number.

    Attributes:
        name: "q", "qd", "qdd", "tau", "t", "params", or "prepared" in programs that prepare.
        symbols: graph symbols of its entries, shape (len,).
        text: what it is, for headers and docstrings.
        units: unit of each entry, "" where there is none; () where they are not told.
        scalar: whether it is one number and no vector, as time is.
        names: names and conventions of the entries, one line; "" where the text says them.
    """

    name: str
    symbols: tuple[Expr, ...]
    text: str
    units: tuple[str, ...]
    scalar: bool = False
    names: str = ""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape: () for one number."""
        return () if self.scalar else (len(self.symbols),)


@dataclass(frozen=True)
class Function:
    """One generated function: entries of an array as expressions of its arguments.

    Attributes:
        name: as in generated code, e.g. "inverse_dynamics", "pose_tool", or "tree_mass_matrix" of a scene with loops.
        text: what it computes, one line.
        arguments: in calling order; free parameters last, whether used or not.
        result: name of the result, e.g. "tau".
        shape: shape of the result; () for a scalar.
        entries: row-major, length = product of shape.
        units: unit of the result, one line.
        formulation: which road derived it, e.g. "rnea".
        request: what to ask `derive` for, e.g. "pose:tool".
        unique: which entries rigid bodies determine, row-major; () for all. The others are one choice among many.
        labels: what its rows stand for, then its columns; () where nobody says.
    """

    name: str
    text: str
    arguments: tuple[Argument, ...]
    result: str
    shape: tuple[int, ...]
    entries: tuple[Expr, ...]
    units: str
    formulation: str
    request: str = ""
    unique: tuple[bool, ...] = ()
    labels: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True)
class Equations:
    """Named functions of a scene on one graph; `closing` is what was chosen about its loops."""

    scene: Scene
    graph: Graph
    functions: tuple[Function, ...]
    closing: LoopChoices = LoopChoices()  # noqa: RUF009  frozen

    def __getitem__(self, name: str) -> Function:
        """Return the function called `name`, or asked for by it; KeyError if it was not derived."""
        for function in self.functions:
            if name in (function.name, function.request):
                return function
        raise KeyError(f"{name} was not derived; there are {', '.join(f.name for f in self.functions)}")
