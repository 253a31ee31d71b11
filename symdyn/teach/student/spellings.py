r"""Spellings of other programs and of blackboards, in the one way that both checkers parse: one table for both.

    m2.*h2.^2      m2*h2^2                      Sin[q1]        sin[q1]
    q1'(t)         q1'                          \frac{\partial L}{\partial \dot q_1}, dL/dqd1     slopeq1dot, slopeqd1
    d/dt (dL/dqd1)                              rateqd1

A pattern is read by Python and by JavaScript alike; `$1` stands for what it found in its first bracket.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

BY = (
    r"(?:\\d?dot ?\{(?:[^{}]|\{[^{}]*\})*\}(?:_?\{\w+\}|_?[0-9]+)?|\\d?dot ?\\?[A-Za-z]\w*(?:_\{\w+\})?"
    r"|\\?[A-Za-z]\w*(?:_\{\w+\}|\{\})?(?: ?')*)"
)
"""What a derivative is taken by, with its dots."""

PARTIAL = r"(?:\\partial ?|[d∂] ?)"
TIME = r"(?:\\frac ?\{(?:\\mathrm ?\{d\}|d)\} ?\{(?:\\mathrm ?\{d\}|d) ?t\}|d ?/ ?dt)"

SPELLINGS: tuple[tuple[str, str], ...] = (
    (r"\.(?=[*/^'])", ""),
    (r"^ *Eq ?\((.*)\) *$", "equation"),
    (r"(?<![A-Za-z\\])(?:Sin|Cos|Tan|Sqrt)(?=[ \[(])", "lower"),
    (r"('{1,2}) ?\(t\)", "$1"),
    (r"(?<=[\])}])('{1,2})(?= ?\()", "$1"),
    (r"\\[dt]?frac ?\{ ?" + PARTIAL + r"(?:L|\\mathcal ?\{L\}) ?\} ?\{ ?" + PARTIAL + "(" + BY + r") ?\}", "slope"),
    (r"(?<![A-Za-z\\])[d∂]L ?/ ?[d∂] ?(" + BY + ")", "slope"),
    (TIME + r" ?(?:\\left ?)?[(\[{]? ?slope(\w+) ?(?:(?:\\right ?)?[)\]}])?", "rate"),
)
"""Pattern, and what stands for it: "lower" for its small letters, "slope" or "rate" with the name of what it is by."""


def bare(by: str) -> str:
    r"""Return what a derivative is taken by as one word: \dot{q}_1 and q_1' are q1dot."""
    dots = 2 * by.count("\\ddot") + by.count("\\dot") + by.count("'")
    return re.sub(r"\\d?dot(?![A-Za-z])|[\\{}_' ]", "", by) + "dot" * dots


def equated(inside: str) -> str:
    """Return the two arguments of an equation with "=" between them: the comma that stands in no bracket."""
    depth = 0
    for k, letter in enumerate(inside):
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            return f"{inside[:k]}={inside[k + 1 :]}"
    return inside


def replacements(text: str) -> Iterator[tuple[int, int, str]]:
    """Yield, one after the other, what of a text is spelled otherwise: begin, end and the new spelling.

    Each pair holds for the text as the ones before have made it.
    """
    for pattern, means in SPELLINGS:
        shift = 0
        for found in list(re.finditer(pattern, text)):
            new = _meaning(means, found[0], found[1] if found.re.groups else "")
            yield found.start() + shift, found.end() + shift, new
            text = text[: found.start() + shift] + new + text[found.end() + shift :]
            shift += len(new) - len(found[0])


def _meaning(means: str, result: str, inner: str) -> str:
    ways: dict[str, Callable[[], str]] = {
        "": lambda: "",
        "lower": result.lower,
        "$1": lambda: inner,
        "slope": lambda: f"slope{bare(inner)} ",
        "rate": lambda: f"rate{inner} ",
        "equation": lambda: equated(inner),
    }
    return ways[means]()
