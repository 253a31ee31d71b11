"""Times on a command line: seconds, or a number with a unit of time."""

from __future__ import annotations

import argparse

from symdyn.scene import parse
from symdyn.scene.values import FormulaError, Unit, fits


def seconds(text: str) -> float:
    """Return a time in seconds, for `type=` of an option.

    >>> seconds("0.5"), seconds("100 ms"), seconds("1 min")
    (0.5, 0.1, 60.0)

    Raises:
        argparse.ArgumentTypeError: it is no number, or one in a unit that is none of time.
    """
    try:
        return float(text)
    except ValueError:
        pass
    try:
        formula = parse(text)
        fits(formula, Unit.read("s"))
        value = formula.at({})
    except FormulaError as error:
        reason = f"{text} {error}" if str(error).startswith(("is ", "divides ")) else str(error)
        raise argparse.ArgumentTypeError(f"{reason}; give seconds, as 0.5, or a unit too, as 500ms") from None
    if value is None:
        raise argparse.ArgumentTypeError(f"{text} is no number; give seconds, as 0.5, or a unit too, as 500ms")
    return float(value)
