"""Quantities that move: a value with its first and second rate, and the formulas of a scene evaluated over them.

    x, v, a      value, rate, second rate along the motion; numbers or arrays

All kinematics of the reference is this one rule: whatever is multiplied out of moving numbers moves as its factors
tell (Leibniz), so that no velocity or acceleration is ever written down by hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np


class Jet:
    """A number or array x with its rates v and a."""

    __array_ufunc__ = None  # so that array * jet is ours

    def __init__(self, x: Any, v: Any = None, a: Any = None) -> None:
        """Rates that are not given are zero."""
        self.x = np.asarray(x, dtype=float)
        self.v = np.zeros_like(self.x) if v is None else np.asarray(v, dtype=float)
        self.a = np.zeros_like(self.x) if a is None else np.asarray(a, dtype=float)

    def __add__(self, other: Any) -> Jet:
        o = jet(other)
        return Jet(self.x + o.x, self.v + o.v, self.a + o.a)

    def __neg__(self) -> Jet:
        return Jet(-self.x, -self.v, -self.a)

    def __sub__(self, other: Any) -> Jet:
        return self + -jet(other)

    def __mul__(self, other: Any) -> Jet:
        return _leibniz(self, jet(other), np.multiply)

    def __matmul__(self, other: Any) -> Jet:
        return _leibniz(self, jet(other), np.matmul)

    def __truediv__(self, other: Any) -> Jet:
        return self * apply("RECIPROCAL", jet(other))

    def __radd__(self, other: Any) -> Jet:
        return jet(other) + self

    def __rsub__(self, other: Any) -> Jet:
        return jet(other) - self

    def __rmul__(self, other: Any) -> Jet:
        return jet(other) * self

    def __rmatmul__(self, other: Any) -> Jet:
        return jet(other) @ self

    def __rtruediv__(self, other: Any) -> Jet:
        return jet(other) / self

    def __getitem__(self, key: Any) -> Jet:
        return Jet(self.x[key], self.v[key], self.a[key])

    @property
    def T(self) -> Jet:
        """The transpose."""
        return Jet(self.x.T, self.v.T, self.a.T)

    @property
    def rate(self) -> Jet:
        """The rate as a jet; its own second rate is not known and not asked for."""
        return Jet(self.v, self.a, np.full_like(self.x, np.nan))


def jet(x: Any) -> Jet:
    """Return a jet as it is, anything else as one that stands still."""
    return x if isinstance(x, Jet) else Jet(x)


def _leibniz(f: Jet, g: Jet, times: Callable[[Any, Any], Any]) -> Jet:
    return Jet(
        times(f.x, g.x), times(f.v, g.x) + times(f.x, g.v), times(f.a, g.x) + 2 * times(f.v, g.v) + times(f.x, g.a)
    )


def cross(f: Jet, g: Jet) -> Jet:
    """Return f × g."""
    return _leibniz(f, g, np.cross)


def stack(entries: list[Jet]) -> Jet:
    """Return an array of jets as one."""
    return Jet(*(np.array([getattr(one, part) for one in entries]) for part in ("x", "v", "a")))


FUNCTIONS: Mapping[str, Callable[[float], tuple[float, float, float]]] = {  # f, f', f''
    "SIN": lambda x: (math.sin(x), math.cos(x), -math.sin(x)),
    "COS": lambda x: (math.cos(x), -math.sin(x), -math.cos(x)),
    "SQRT": lambda x: (math.sqrt(x), 0.5 / math.sqrt(x), -0.25 / x**1.5),
    "EXP": lambda x: (math.exp(x),) * 3,
    "LOG": lambda x: (math.log(x), 1 / x, -1 / x**2),
    "TANH": lambda x: (t := math.tanh(x), 1 - t * t, -2 * t * (1 - t * t)),
    "ABS": lambda x: (abs(x), math.copysign(1, x), 0.0),
    "SIGN": lambda x: (float((x > 0) - (x < 0)), 0.0, 0.0),
    "RECIPROCAL": lambda x: (1 / x, -1 / x**2, 2 / x**3),
}


def apply(name: str, x: Jet) -> Jet:
    """Return a function of a number that moves (the chain rule)."""
    f, slope, bend = FUNCTIONS[name](float(x.x))
    return Jet(f, slope * x.v, slope * x.a + bend * x.v**2)


def angle(y: Jet, x: Jet) -> Jet:
    """Return atan2(y, x): its rate is (x ẏ - y ẋ) / (x² + y²)."""
    rate = (x * y.rate - y * x.rate) / (x * x + y * y)
    return Jet(math.atan2(y.x, x.x), rate.x, rate.v)


ARITHMETIC: Mapping[str, Callable[..., Any]] = {
    "ADD": lambda a, b: a + b,
    "SUB": lambda a, b: a - b,
    "MUL": lambda a, b: a * b,
    "DIV": lambda a, b: a / b,
    "NEG": lambda a: -a,
    "ATAN2": angle,
}


def value(quantity: Any, known: Mapping[str, Any]) -> Jet:
    """Return the value of a declared formula; `known` gives its symbols, jets or numbers."""
    name = quantity.op.name
    if name == "CONSTANT":
        return Jet(float(quantity.value))
    if name == "PI":
        return Jet(math.pi)
    if name == "SYMBOL":
        return jet(known[quantity.value])
    args = [value(one, known) for one in quantity.args]
    return ARITHMETIC[name](*args) if name in ARITHMETIC else apply(name, args[0])


def number(quantity: Any, known: Mapping[str, Any]) -> float:
    """Return the value of a formula that does not move."""
    return float(value(quantity, known).x)
