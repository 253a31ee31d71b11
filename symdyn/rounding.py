"""How many digits of a number are shown: what is usual at each place, unless somebody asks for another number.

    with showing(12): ...       twelve significant digits wherever numbers are rounded for people
    with showing(ALL): ...      all that doubles have; these are shown so that they read back

What is written for machines (CSV, JSON, generated code) has all digits whatever is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

ALL = 0
MOST = 17
"""Digits that tell any two doubles apart."""

DIGITS = {"all": ALL} | {str(count): count for count in range(1, MOST + 1)}
"""How many may be shown, by their words."""

_ASKED: ContextVar[int | None] = ContextVar("digits", default=None)


@contextmanager
def showing(digits: int | None) -> Iterator[None]:
    """Round to so many significant digits inside, 1 … 17 or `ALL`; None leaves all as usual."""
    before = _ASKED.set(digits)
    try:
        yield
    finally:
        _ASKED.reset(before)


def requested_digits() -> int | None:
    """Return to how many digits numbers are to be rounded, None where that is left to each place."""
    digits = _ASKED.get()
    return MOST if digits == ALL else digits


def digits_or(usual: int) -> int:
    """Return to how many digits numbers are rounded where `usual` is usual.

    >>> digits_or(6)
    6
    >>> with showing(ALL):
    ...     print(digits_or(6))
    17
    """
    digits = requested_digits()
    return usual if digits is None else digits


def in_digits(x: float, usual: int, kind: str = "g") -> str:
    """Return a double with so many significant digits, those of an exponent ("e") or of whichever is shorter ("g").

    >>> in_digits(2 / 3, 3), in_digits(2 / 3, 3, "e")
    ('0.667', '6.67e-01')
    >>> with showing(ALL):
    ...     print(in_digits(2 / 3, 3), in_digits(1.0, 3))
    0.6666666666666666 1
    """
    if _ASKED.get() == ALL:
        return repr(float(x)).removesuffix(".0")
    return f"{x:.{digits_or(usual) - (kind == 'e')}{kind}}"


def finite(value: Any) -> Any:
    """Return a JSON value with null where a number is none, or infinite, for which JSON has no word."""
    if isinstance(value, Mapping):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
