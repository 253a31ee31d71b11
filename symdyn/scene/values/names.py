"""Names that survive every target: Python, C, LaTeX and formulas."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable
from difflib import get_close_matches
from heapq import nlargest

FORMULA_NAMES = (
    "pi", "deg", "sin", "cos", "tan", "sqrt", "exp", "log", "tanh", "abs", "sign", "atan2",
)  # fmt: skip

CLOCK = "t"
"""The time of formulas, which no letter can be called."""

C_KEYWORDS = (
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern",
    "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short",
    "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile",
    "while",
)  # fmt: skip

RESERVED = (*C_KEYWORDS, *FORMULA_NAMES)
"""Words of C and of formulas, that no name may be."""

_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")

LONGEST = 60

MOST_KNOWN, MOST_COMPARED = 5000, 50
"""Known names that are looked at for one that a wrong one may have meant, and those that are compared with it."""


def check_name(name: object, letter: bool = False) -> str | None:
    """Return what is wrong with a name and what would work, or None for a good one; a `letter` is one of formulas."""
    fault = check_scene_name(name)
    if fault or not isinstance(name, str):
        return fault
    if keyword.iskeyword(name):
        return f"is a keyword of Python; try {name}1"
    if name in C_KEYWORDS:
        return f"is a keyword of C; try {name}1"
    if name in FORMULA_NAMES:
        return f"is a function or constant of formulas; try {name}1"
    if letter and name == CLOCK:
        return f"is the time in formulas and runs; rename it, such as {name}_0"
    if name.endswith(("_dot", "_ddot")):
        return "ends like a velocity or an acceleration; leave _dot and _ddot to the coordinates"
    return None


def check_scene_name(name: object) -> str | None:
    """Return what is wrong with the name of a scene; it stands in no formula, and may be a word of any language."""
    if not isinstance(name, str):
        return f"is not text but of type {type(name).__name__}; give a name such as m1"
    if not name:
        return "is empty; give a name such as m1"
    if len(name) > LONGEST:
        return f"has {len(name)} characters; {LONGEST} are enough"
    if not _IDENTIFIER.match(name):
        better = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")
        hint = better if better and better[0].isalpha() and check_name(better, letter=True) is None else "link_1"
        return f"is not a plain identifier; use ASCII letters, digits and _ and begin with a letter, such as {hint}"
    if name.startswith("_"):
        return "begins with _, as only names inside generated code do; begin with a letter"
    return None


def nearest(name: object, known: Iterable[str]) -> str | None:
    """Return the known name that `name` was probably meant to be, or None; what is no text meant none.

    Of many names only those are compared that begin and end most like it; a name of a line's length is none.
    """
    if not isinstance(name, str) or len(name) > LONGEST:
        return None
    lowered = {candidate.lower(): candidate for candidate in known}
    meant, candidates = name.lower(), list(lowered)[:MOST_KNOWN]
    if len(candidates) > MOST_COMPARED:
        candidates = nlargest(MOST_COMPARED, candidates, key=lambda candidate: _in_common(meant, candidate))
    found = get_close_matches(meant, candidates, n=1, cutoff=0.6)
    return lowered[found[0]] if found else None


def _in_common(a: str, b: str) -> int:
    """Return how many letters two names have in common at their beginnings and their ends."""
    differ = [x != y for x, y in zip(a, b, strict=False)]
    ahead = differ.index(True) if True in differ else len(differ)
    behind = [x != y for x, y in zip(a[ahead:][::-1], b[ahead:][::-1], strict=False)]
    return ahead + (behind.index(True) if True in behind else len(behind))


def listed(names: Iterable[str], most: int = 12) -> str:
    """Return names as text for a message, shortened when there are many."""
    every = list(names)
    if not every:
        return "none"
    return ", ".join(every[:most]) + (f", ... ({len(every)} in all)" if len(every) > most else "")


def suggestion(name: object, known: Iterable[str]) -> str:
    """Return "did you mean X?" when something known is near, else the known names."""
    every = list(known)
    near = nearest(name, every)
    return f"did you mean {near}?" if near else f"known are {listed(every)}"


def choice(name: object, known: Iterable[str]) -> str:
    """Return all known names, of which a user chooses one, and "did you mean X?" when one of them is near."""
    every = list(known)
    near, all_of_them = nearest(name, every), f"there are {', '.join(every)}"
    return f"did you mean {near}? ({all_of_them})" if near else all_of_them
