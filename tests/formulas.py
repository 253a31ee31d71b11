"""Hand-made equations for tests: every operation, empty shapes, unused arguments."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from symdyn.dynamics.outputs.named_functions import Argument, Equations, Function
from symdyn.graph import Expr, Graph, Op, Piecewise, reachable
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


def held(equations: Equations, lacks: Collection[Op]) -> Equations:
    """Return the equations with zero for every entry that needs what a language lacks."""

    def entry(e: Expr) -> Expr:
        return e.graph.zero if any(node.op in lacks for node in reachable([e])) else e

    functions = [replace(f, entries=tuple(map(entry, f.entries))) for f in equations.functions]
    return replace(equations, functions=tuple(functions))


def one(entries: Sequence[Expr], symbols: Sequence[Expr], scene: Scene | None = None) -> Equations:
    """Return one function `f(q)` with the given entries."""
    f = function("f", [argument("q", symbols)], (len(entries),), entries)
    return Equations(scene or Scene("hand"), symbols[0].graph, (f,))


def states(equations: Equations, name: str, count: int = 5, seed: int = 1) -> list[np.ndarray]:
    """Return arguments of a function for `count` random states, entries between 0.2 and 2."""
    rng = np.random.default_rng(seed)
    return [rng.uniform(0.2, 2.0, (count, len(a.symbols))) for a in equations[name].arguments]
