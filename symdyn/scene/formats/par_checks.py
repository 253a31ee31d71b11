"""What a Khalil parameter file must be to be read: rigid joints on a base at rest, with complete lists."""

from __future__ import annotations

import re
from dataclasses import dataclass

from symdyn.errors import SceneError
from symdyn.scene.formats.par_text import BASE_KEYS, KEYS, LINK_KEYS, ROW_KEYS, SCALAR_KEYS, WRENCH, Sheet
from symdyn.scene.values.table import Faults, show

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
