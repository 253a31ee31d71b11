"""The text of a Khalil parameter file: `KEY = value` and `KEY = {value, value, ...}`, comments in (* ... *).

Two programs have written such files, SYMORO+ with Mathematica's words (Pi, Cos[t1], ^) and OpenSYMORO with SymPy's
(pi, cos(t1), **). Keys are told apart without regard to case, as the two do not agree on it: Ant, ant.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from symdyn.bounds import BOUNDS
from symdyn.errors import SceneError
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

LONGEST_LIST = BOUNDS["values of a list of a .par file"]
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


# What a sheet must be to be read: rigid joints on a base at rest, with complete lists

IDENTITY = ("1", "0", "0", "0", "0", "1", "0", "0", "0", "0", "1", "0", "0", "0", "0", "1")


@dataclass(frozen=True)
class Counts:
    """How many frames a file has.

    Attributes:
        links: moving links, NL; their frames come first.
        joints: joints, NJ; those beyond the links are cut.
        frames: NF = 2 NJ - NL: every cut joint has a frame on either of the links that it connects.
    """

    links: int
    joints: int
    frames: int

    def lengths(self, key: str) -> tuple[int, ...]:
        """Return how many values a key may have."""
        if key in BASE_KEYS:
            return (16 if key == "z" else 3,)
        if key in SCALAR_KEYS:
            return (1,)
        most = dict.fromkeys((self.links, self.joints, self.frames))
        return (self.frames,) if key in ROW_KEYS else tuple(most)


def count_frames(sheet: Sheet, faults: Faults) -> Counts:
    """Return the numbers of links, joints and frames; those that do not fit together are refused."""
    found = {}
    for key in ("nl", "nj", "nf"):
        text = sheet.values.get(key, ("",))[0]
        if key != "nf" and key not in sheet.values:
            faults.add("", f"{key.upper()} is missing; write such as NL = 6, NJ = 6")
        elif re.fullmatch(r"\d{1,4}", text):
            found[key] = int(text)
        elif key != "nf" or text:
            faults.add("", f"{key.upper()} = {show(text)} is not a whole number; write such as NL = 6, NJ = 6")
    faults.close()
    nl, nj = found["nl"], found["nj"]
    counts = Counts(nl, nj, found.get("nf", 2 * nj - nl))
    if nj < nl or counts.frames != 2 * nj - nl:
        what = f"NL = {nl}, NJ = {nj}, NF = {counts.frames} do not fit together"
        advice = "a file of NL links and NJ joints, NJ - NL of them cut, has NF = 2 NJ - NL frames"
        raise SceneError(f"{faults.source}: {what}: {advice}; correct them")
    for key in KEYS:
        given = sheet.values.get(key)
        if given is not None and len(given) not in counts.lengths(key):
            faults.add("", f"{key} has {len(given)} values; {counts.lengths(key)[0]} are needed")
    for key in ("sigma", "theta", "m"):
        if key not in sheet.values:
            faults.add("", f"{key} is missing; give one value a frame")
    if nj > nl and "ant" not in sheet.values:
        faults.add("", "Ant is missing; where loops are closed it says which links a cut joint connects")
    missing = [key.upper() for key in LINK_KEYS if key not in sheet.values and key not in WRENCH]
    if missing:
        faults.note("", f"{', '.join(missing)} are not given and read as zero")
    return counts


def refuse_motion_of_base(sheet: Sheet, faults: Faults) -> None:
    """Report what moves the base or bends the joints."""
    for key in ("is_floating", "is_mobile"):
        if sheet.values.get(key, ("0",))[0].lower() not in ("0", "false", ""):
            advice = "a free base is not read; write 0 to hold it, and give the scene a free joint in TOML"
            faults.add("", f"{key} = {sheet.values[key][0]}: {advice}")
    for key in ("w0", "wp0", "v0", "vp0"):
        if any(not is_zero(text) for text in sheet.values.get(key, ())):
            shown = show(list(sheet.values[key]))
            faults.add("", f"{key.upper()} = {shown}: the base of a scene is at rest; write zeros")
    for j, text in enumerate(sheet.values.get("eta", ())):
        if not is_zero(text):
            faults.add(f"frame {j + 1}", f"eta = {text}: joints of a scene are rigid; write 0")
    for j, text in enumerate(sheet.values.get("k", ())):
        if not is_zero(text):
            faults.note(f"frame {j + 1}", f"k = {text} is left out: the joint is rigid (eta = 0)")
    if sheet.values.get("z", IDENTITY) != IDENTITY:
        faults.note("", "Z, the place of frame 0 in the world, is left out: no equation depends on it")
    if "g" not in sheet.values:
        faults.add("", "G is missing; give the acceleration of free fall in frame 0, such as {0, 0, -9.81}")


def is_zero(text: str) -> bool:
    """Whether a value is left empty or a zero."""
    return re.fullmatch(r"[+-]?(0+\.?0*|\.0+)|", text) is not None
