"""The text of a Khalil parameter file: `KEY = value` and `KEY = {value, value, ...}`, comments in (* ... *).

Two programs have written such files, SYMORO+ with Mathematica's words (Pi, Cos[t1], ^) and OpenSYMORO with SymPy's
(pi, cos(t1), **). Keys are told apart without regard to case, as the two do not agree on it: Ant, ant.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from symdyn.scene.values.formula import UNARY_FUNCTIONS, split_commas
from symdyn.scene.values.table import Faults, shorten, show

ROW_KEYS = ("ant", "sigma", "b", "d", "r", "gamma", "alpha", "mu", "theta")

LINK_KEYS = (
    "xx", "xy", "xz", "yy", "yz", "zz", "mx", "my", "mz", "m", "ia", "fv", "fs", "fx", "fy", "fz", "cx", "cy", "cz",
)  # fmt: skip

WRENCH = ("fx", "fy", "fz", "cx", "cy", "cz")

JOINT_KEYS = ("qp", "qdp", "gam", "eta", "k")

BASE_KEYS = ("w0", "wp0", "v0", "vp0", "g", "z")

SCALAR_KEYS = ("nf", "nl", "nj", "type", "is_floating", "is_mobile")

KEYS = (*SCALAR_KEYS, *ROW_KEYS, *LINK_KEYS, *JOINT_KEYS, *BASE_KEYS)

LONGEST_LIST = 2_000
MOST_FAULTS = 20

_SPACE = re.compile(r"\s*")
_STATEMENT = re.compile(r"([A-Za-z_]\w*)[ \t]*=[ \t]*(?:\n\s*)?(\{[^{}]*\}|[^{};\s][^{};\n]*)[ \t]*;?")
_REMARK = re.compile(r"\s*(Robotname|Link names|Joint names)\s*=\s*'([^'\n]*)'\s*\Z")
_WORDS = {"Pi": "pi", "PI": "pi", **{name.capitalize(): name for name in UNARY_FUNCTIONS}, "ArcTan2": "atan2"}


@dataclass(frozen=True)
class Sheet:
    """What a file says, value by value, in words that the formula reader takes.

    Attributes:
        remarks: "Robotname", "Link names" and "Joint names", where a comment gives them.
        values: by lower-case key; a single value is a list of one.
    """

    remarks: Mapping[str, str]
    values: Mapping[str, tuple[str, ...]]


def parse_sheet(text: str, faults: Faults) -> Sheet:
    """Return what a file says; keys that are not known are noted, what is no statement is a fault."""
    bare, comments = _without_comments(text, faults)
    remarks = {found[1]: found[2].strip() for comment in comments if (found := _REMARK.match(comment))}
    values: dict[str, tuple[str, ...]] = {}
    at = start = 0
    line = 1
    while (start := _SPACE.match(bare, at).end()) < len(bare) and len(faults.lines) < MOST_FAULTS:  # type: ignore[union-attr]
        line += bare.count("\n", at, start)
        found = _STATEMENT.match(bare, start)
        if found is None:
            what = show(bare[start : start + 200].split("\n", 1)[0])
            faults.add(f"line {line}", f"{what} is no statement; write KEY = value or KEY = {{value, value}}")
            break
        key, where, at = found[1].lower(), f"line {line}", found.end()
        line += bare.count("\n", start, at)
        if key not in KEYS:
            faults.note(where, f"{shorten(found[1])} is not a key of parameter files; it is left out")
        elif key in values:
            faults.add(where, f"{found[1]} is given twice; remove one of them")
        else:
            values[key] = _items(found[2])
            if len(values[key]) > LONGEST_LIST:
                faults.add(where, f"{found[1]} has {len(values[key])} values; {LONGEST_LIST} are allowed")
    return Sheet(remarks, values)


def _without_comments(text: str, faults: Faults) -> tuple[str, list[str]]:
    """Return the text with line breaks in place of comments, and the comments."""
    parts: list[str] = []
    comments: list[str] = []
    at = 0
    while (start := text.find("(*", at)) >= 0:
        end = text.find("*)", start + 2)
        if end < 0:
            faults.add(f"line {text.count(chr(10), 0, start) + 1}", "a comment begins that does not end; write *)")
            return "", comments
        comments.append(text[start + 2 : end])
        parts += [text[at:start], "\n" * comments[-1].count("\n")]
        at = end + 2
    return "".join([*parts, text[at:]]), comments


def _items(raw: str) -> tuple[str, ...]:
    """Return the values between commas outside brackets, in the formula reader's words."""
    text = " ".join(raw.strip().removeprefix("{").removesuffix("}").split())
    text = re.sub(r"[A-Za-z_]\w*", lambda word: _WORDS.get(word[0], word[0]), text)
    text = text.replace("[", "(").replace("]", ")").replace("^", "**")
    return tuple(split_commas(text)) or ("",)
