"""Numbers to run a graph over: floats and NumPy batches.

Each is an `Algebra`. Constants are rounded here and nowhere earlier.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from symdyn.errors import NoValueError
from symdyn.graph import ELEMENTARY, Arithmetic, Expr, Op, Piecewise

Array = npt.NDArray[np.float64]


class Floats(Arithmetic):
    """Python floats: one state, no dependencies; what has no value raises `NoValueError`."""

    functions: ClassVar[dict[Op, Callable[..., float]]] = {
        **{op: getattr(math, op.name.lower()) for op in ELEMENTARY},
        Op.ABS: abs,
        Op.SIGN: lambda x: float((x > 0) - (x < 0)),
        Op.ATAN2: math.atan2,
        Op.POW: math.pow,
        Op.SELECT: lambda c, a, b: a if c > 0 else b if c <= 0 else c,
    }

    def constant(self, value: Fraction) -> float:
        return _double(value)

    def div(self, a: float, b: float) -> float:
        try:
            return a / b
        except ZeroDivisionError:
            raise NoValueError(f"{a:.6g}/0 {NO_VALUE}") from None

    def pi(self) -> float:
        return math.pi

    def function(self, node: Expr, args: Sequence[float]) -> float:
        if isinstance(node.value, Piecewise):
            return float(node.value.over(self, args[0]))
        try:
            return self.functions[node.op](*args)
        except (ValueError, OverflowError):
            text = f"{node.op.name.lower()}({', '.join(f'{x:.6g}' for x in args)})"
            raise NoValueError(f"{text} {NO_VALUE}") from None


class Batches(Arithmetic):
    """NumPy arrays, all of one (broadcast) shape: many states at once."""

    functions: ClassVar[dict[Op, Callable[..., Any]]] = {
        **{op: getattr(np, op.name.lower()) for op in ELEMENTARY},
        Op.ABS: np.abs,
        Op.SIGN: np.sign,
        Op.ATAN2: np.arctan2,
        Op.POW: np.power,
        Op.SELECT: lambda c, a, b: np.where(c > 0, a, np.where(c <= 0, b, c)),
    }

    def constant(self, value: Fraction) -> Any:
        return np.float64(_double(value))

    def pi(self) -> Any:
        return np.float64(math.pi)

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        if isinstance(node.value, Piecewise):
            return node.value.over(self, args[0])
        return self.functions[node.op](*args)


NO_VALUE = (
    "has no value; a formula of the scene is asked for where it does not exist, choose a state or a start where it does"
)


def _double(value: Fraction) -> float:
    try:
        return float(value)
    except OverflowError:
        digits = (abs(value.numerator).bit_length() - value.denominator.bit_length()) * 0.30103
        raise NoValueError(
            f"a number of about 1e{digits:.0f} is beyond the largest double, 1.8e308; choose units that keep it smaller"
        ) from None
