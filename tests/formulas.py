"""Hand-made equations for tests: every operation, empty shapes, unused arguments."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial

import numpy as np

from symdyn.dynamics.outputs.named_functions import Argument, Equations, Function
from symdyn.emit import TARGETS
from symdyn.emit.code.spelling import REALS
from symdyn.graph import Expr, Graph, Op, Piecewise, reachable, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Parameter

QUARTER = Parameter("b", Quantity.number(Fraction(1, 4)))

PIECES = ((1, 2, 0), (1, 2, -3), (0, -4, 6), (Fraction(-2, 3), 0, 0))
CURVE = Piecewise(
    "bent", (Fraction(-1), Fraction(0), Fraction(1, 3)), tuple(tuple(Fraction(c) for c in one) for one in PIECES)
)
"""A parabola, another one and straight lines beyond."""


def argument(name: str, symbols: Sequence[Expr], unit: str = "rad") -> Argument:
    return Argument(name, tuple(symbols), f"entries of {name}", (unit,) * len(symbols))


def function(name: str, arguments: Sequence[Argument], shape: tuple[int, ...], entries: Sequence[Expr]) -> Function:
    return Function(name, f"values of {name}", tuple(arguments), "r", shape, tuple(entries), "N m", "by hand")


def every_op(scene: str = "every op") -> Equations:
    """Return functions that use every `Op`: a matrix, a scalar, an empty matrix, a zero, a vector as long as q."""
    g = Graph()
    q, qd, m = [g.symbol(f"q{i}") for i in (1, 2)], [g.symbol(f"qd{i}") for i in (1, 2)], g.symbol("mass")
    s, c = g.sin(q[0]), g.cos(q[0] + q[1])
    u, v = qd
    matrix = [
        s * c * m + g.symbol("b") * u,
        -(s + c) / (u - v * g.sqrt(2) / 2 + 4),
        g.zero,
        g.function(Op.SIGN, u) * g.cos(g.pi * Fraction(37, 180)) - (v - (u - s)),
        g.function(Op.ATAN2, s, c) - g.function(Op.ABS, c) * g.pi * v,
        -g.function(Op.TANH, v - (u - s)) + g.function(Op.EXP, s) * g.function(Op.LOG, 2 + c) - g.sqrt(m + u * u),
    ]
    looked_up = g.lookup(CURVE, v - u) + g.lookup(CURVE.derivative, v - u) * m
    arguments = (argument("q", q), argument("qd", qd, "rad/s"), argument("params", [m], "kg"))
    functions = (
        function("matrix", arguments, (2, 3), matrix),
        function("scalar", arguments, (), [m * u * u / 2 + v / 3]),
        function("empty", arguments, (1, 0), []),
        function("nothing", arguments, (2,), [g.zero, g.zero]),
        function(
            "chosen",
            arguments,
            (2,),
            [g.function(Op.SELECT, u - v, s * u, c) + looked_up, g.function(Op.POW, 1 + u * u, m - Fraction(1, 3)) - s],
        ),
        function("rotated", arguments, (2,), [c * q[0] - s * q[1], s * q[0] + c * q[1]]),
    )
    return Equations(Scene(scene, (Parameter("mass", unit="kg", text="of the load"), QUARTER)), g, functions)


def one_in_another() -> Equations:
    """Return every operator inside every other, on either side, and a sign; each stands once, so in place."""
    g = Graph()
    of_two = [Expr.__add__, Expr.__sub__, Expr.__mul__, Expr.__truediv__, partial(g.function, Op.POW)]
    q = [g.symbol(f"q{k}") for k in range(1, 163)]
    fresh = iter(q)
    entries = [g.function(Op.POW, -next(fresh), -next(fresh))]
    for inner in of_two:
        entries.append(-inner(next(fresh), next(fresh)))
        for outer in of_two:
            entries.append(outer(inner(next(fresh), next(fresh)), next(fresh)))
            entries.append(outer(next(fresh), inner(next(fresh), next(fresh))))
    return one(entries, q)


def spoken(target: str, real: str = "double", equations: Equations | None = None) -> Equations:
    """Return `every_op`, or other equations, as a target holds it in a type: with all operations but those it lacks."""
    whole = equations or every_op()
    lacks = {*TARGETS[target].lacks, *REALS[real].lacks}
    lacks |= {Op.TABLE} if Op.SELECT in lacks else set()  # tables are written by choices
    made = [replace(f, entries=_without(f.entries, lacks)) for f in whole.functions]
    assert _operations(made) == _operations(whole.functions) - lacks
    return replace(whole, functions=tuple(made))


def _without(entries: Sequence[Expr], lacks: Collection[Op]) -> tuple[Expr, ...]:
    """Return entries with the first operand in place of every operation that is lacking."""
    first = {node: node.args[0] for node in reachable(entries) if node.op in lacks}
    return _without(substitute(entries, first), lacks) if first else tuple(entries)


def _operations(functions: Iterable[Function]) -> set[Op]:
    return {node.op for function in functions for node in reachable(function.entries)}


def one(entries: Sequence[Expr], symbols: Sequence[Expr], scene: Scene | None = None) -> Equations:
    """Return one function `f(q)` with the given entries."""
    f = function("f", [argument("q", symbols)], (len(entries),), entries)
    return Equations(scene or Scene("hand"), symbols[0].graph, (f,))


def states(equations: Equations, name: str, count: int = 5, seed: int = 1) -> list[np.ndarray]:
    """Return arguments of a function for `count` random states, entries between 0.2 and 2."""
    rng = np.random.default_rng(seed)
    return [rng.uniform(0.2, 2.0, (count, len(a.symbols))) for a in equations[name].arguments]
