"""A hundred values that no argument, or hardly one, is meant to take: each made anew, since some are used up."""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import sympy

import symdyn


class Mute:
    """What cannot even be shown."""

    def __repr__(self) -> str:
        raise RuntimeError("no")


class Liar:
    """What says of itself that it is a number, a list and text, and is none."""

    def __float__(self) -> float:
        raise ValueError("no")

    def __len__(self) -> int:
        return 3

    def __getitem__(self, key: object) -> object:
        raise KeyError(key)


def recursive() -> list[Any]:
    """Return a list that holds itself."""
    one: list[Any] = [1]
    one.append(one)
    return one


def recursive_table() -> dict[str, Any]:
    """Return a table that holds itself."""
    one: dict[str, Any] = {}
    one["x"] = one
    return one


def deep() -> list[Any]:
    """Return a list in a list, 5,000 levels deep."""
    one: list[Any] = []
    for _ in range(5000):
        one = [one]
    return one


def ragged() -> np.ndarray[Any, Any]:
    """Return an array of rows that differ in length."""
    one = np.empty(2, dtype=object)
    one[:] = [[1, 2], [3]]
    return one


def as_they_are(*values: Any) -> dict[str, Callable[[], Any]]:
    """Return values that nothing uses up, each by how Python writes it."""
    return {f"{one!r:.40}": (lambda one=one: one) for one in values}


WRONG: dict[str, Callable[[], Any]] = {
    **as_they_are("", " ", "x", "mc", "=", "x=", "1/0", "ž", "\0", "\n"),
    "long text": lambda: "a" * 5000,
    "text of brackets": lambda: "(" * 3000,
    "text of NumPy": lambda: np.str_("nothing"),
    **as_they_are(b"", b"ab", bytearray(b"x")),
    **as_they_are(None, True, False, Ellipsis, NotImplemented, 0, 1, -1, 2**63),
    "10**400": lambda: 10**400,
    "-10**400": lambda: -(10**400),
    **as_they_are(1.5, -0.0, math.nan, math.inf, -math.inf, 1.7e308, 5e-324, 1j),
    **as_they_are(*map(Decimal, ("1.5", "NaN", "sNaN", "1e999999"))),
    "fraction": lambda: Fraction(3, 2),
    "long fraction": lambda: Fraction(10**400),
    "symbol": lambda: sympy.Symbol("z"),
    "expression": lambda: sympy.sin(sympy.Symbol("z")),
    "infinity of SymPy": lambda: sympy.oo,
    "nan of SymPy": lambda: sympy.nan,
    "rational": lambda: sympy.Rational(3, 2),
    "matrix": lambda: sympy.Matrix([[1, 2]]),
    "truth of SymPy": lambda: sympy.true,
    **as_they_are(np.float64(1), np.float32("nan"), np.int64(2), np.uint8(255), np.bool_(True), np.complex128(1)),
    "moment": lambda: np.datetime64("2026"),
    "span": lambda: np.timedelta64(3, "s"),
    "masked": lambda: np.ma.masked,
    "masked array": lambda: np.ma.array([1.0, 2.0], mask=[True, False]),
    "array ()": lambda: np.array(2.0),
    "one in an array ()": lambda: np.array(1.0),
    "true in an array ()": lambda: np.array(True),
    "half precision": lambda: np.float16(1),
    "array (0,)": lambda: np.array([]),
    "array (1,)": lambda: np.array([1.5]),
    "array (3,)": lambda: np.zeros(3),
    "array (0, 3)": lambda: np.zeros((0, 3)),
    "array (2, 2)": lambda: np.eye(2),
    "array (2, 2, 2)": lambda: np.ones((2, 2, 2)),
    "array of nan": lambda: np.array([math.nan, math.nan]),
    "array of text": lambda: np.array(["a", "b"]),
    "array of objects": lambda: np.array([None, {}], dtype=object),
    "array of an object": lambda: np.array({}, dtype=object),
    "ragged array": ragged,
    "array of records": lambda: np.zeros(2, dtype=[("t", float), ("x", float)]),
    "array of complex": lambda: np.array([1j, 2]),
    **as_they_are((), [], [None], [1, 2], [0.0, 1.0], ["a"], ["a", 3], [[]]),
    **as_they_are([[1], [2, 3]], [{}], [10**400], [math.nan, 0], ["x=1", "x=2"]),
    "long list": lambda: [0] * 10_000,
    "list in itself": recursive,
    "deep list": deep,
    **as_they_are({}, {1: 2}, {None: 1}, {"nothing": 1}, {"": ""}, {("a",): 1}),
    **as_they_are({"x": None}, {"x": [1, 2]}, {"x": {}}, {"x": "y"}, {"t": [0]}),
    "callable by name": lambda: {"x": len},
    "number beyond by name": lambda: {"x": 10**400},
    "array by name": lambda: {"x": np.array([])},
    "long name": lambda: {"a" * 5000: 1},
    "table in itself": recursive_table,
    **as_they_are(set(), {1}, {"a"}, frozenset({None})),
    "generator": lambda: (x for x in (1, 2)),
    "generator of nothing": lambda: (x for x in ()),
    "generator that fails": lambda: (1 // x for x in (0,)),
    "iterator": lambda: iter(["a"]),
    "range": lambda: range(3),
    "slice": lambda: slice(1),
    "function of nothing": lambda: lambda: 1,
    "function of five": lambda: lambda a, b, c, d, e: a,
    "len": lambda: len,
    "print": lambda: print,
    **as_they_are(int, str, object, type, list, dict, Path, symdyn.Scene),
    "module": lambda: math,
    "error": lambda: ValueError("x"),
    "object": object,
    "mute": Mute,
    "liar": Liar,
    "path": lambda: Path("nowhere.toml"),
    "folder": Path,
    "open text": lambda: io.StringIO("x"),
    "open bytes": lambda: io.BytesIO(b"\xff"),
    "scene": lambda: symdyn.example("pendulum"),
    "scene of nothing": lambda: symdyn.Scene("empty"),
}
"""Values by what they are called in a report."""

FAILING: dict[str, tuple[type[Exception], ...]] = {
    "generator that fails": (ZeroDivisionError,),
    "len": (TypeError,),
    "<class 'int'>": (ValueError,),
    "<class 'list'>": (TypeError,),
    "<class 'dict'>": (TypeError, ValueError),
    f"{Path!r}": (TypeError,),
}
"""Functions and generators that fail when they are used as they may be: what a user's own code raises is the user's."""
