"""How wide a formula in LaTeX will be, and how wide a line is: an A4 page with 20 mm margins at 10 pt."""

from __future__ import annotations

import re

BREAK = "\v"
"""Stands in formulas in front of every + and - at which a line may end."""

LINE = 470.0  # pt: 170 mm less a little for what the estimate misses
INDENT = 20.0

TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[0-9.]|[A-Za-z]|[_^{}]|.", re.DOTALL)

GLYPHS = {  # widths in pt at 10 pt, Computer Modern
    **dict.fromkeys((r"\sin", r"\cos", r"\exp", r"\ln", r"\tanh"), 18.0),
    **dict.fromkeys(("+", "-", "="), 12.3),
    **dict.fromkeys((r"\cdot",), 7.3),
    **dict.fromkeys(("(", ")"), 4.0),
    **dict.fromkeys((r"\bigl", r"\bigr"), 0.7),
    **dict.fromkeys((r"\Bigl", r"\Bigr"), 2.2),
    **dict.fromkeys((r"\biggl", r"\biggr"), 3.4),
    **dict.fromkeys((r"\dot", r"\ddot", r"\mathrm", r"\mathit", r"\mathtt", "{", "}", " ", BREAK, "&"), 0.0),
    r"\,": 1.7,
    r"\quad": 10.0,
    ".": 2.8,
    ",": 4.5,
    r"\sqrt": 8.5,
    "m": 8.8,
    "w": 7.2,
    "M": 10.8,
    **dict.fromkeys("ijl", 4.2),
    **dict.fromkeys("ABCDEFGHIKLNOPQRUVWXYZ", 8.0),
    **dict.fromkeys("0123456789", 5.0),
}
ORDINARY = 5.9  # any other letter
SCRIPT = 0.72


def latex_width(text: str) -> float:
    """Return a slightly generous estimate of the width of a formula, pt at 10 pt."""
    tokens = TOKEN.findall(text)
    width, _ = _measure(tokens, 0)
    return width


def _measure(tokens: list[str], at: int) -> tuple[float, int]:
    """Return the width of tokens up to the brace that closes, and where it stands."""
    total = 0.0
    while at < len(tokens) and tokens[at] != "}":
        token = tokens[at]
        if token in ("_", "^"):
            width, after = _argument(tokens, at + 1)
            subscript_width = width
            if after < len(tokens) and tokens[after] == "^" and token == "_":  # both at one place
                width, after = _argument(tokens, after + 1)
                subscript_width = max(subscript_width, width)
            total, at = total + SCRIPT * subscript_width + 0.5, after
        elif token in (r"\frac", r"\tfrac"):
            upper, after = _argument(tokens, at + 1)
            lower, at = _argument(tokens, after)
            total += max(upper, lower) * (SCRIPT if token == r"\tfrac" else 1) + 2.4
        elif token == "{":
            width, after = _measure(tokens, at + 1)
            total, at = total + width, after + 1
        else:
            total += GLYPHS.get(token, ORDINARY)
            at += 1
    return total, at


def _argument(tokens: list[str], at: int) -> tuple[float, int]:
    while at < len(tokens) and tokens[at] == " ":
        at += 1
    if at < len(tokens) and tokens[at] == "{":
        width, after = _measure(tokens, at + 1)
        return width, after + 1
    return (GLYPHS.get(tokens[at], ORDINARY), at + 1) if at < len(tokens) else (0.0, at)
