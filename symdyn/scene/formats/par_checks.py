"""What a Khalil parameter file must be to be read: a tree of rigid joints on a base at rest, with complete lists."""

from __future__ import annotations

import re

from symdyn.errors import SceneError
from symdyn.scene.formats.par_text import BASE_KEYS, KEYS, LINK_KEYS, SCALAR_KEYS, WRENCH, Sheet
from symdyn.scene.table import Faults, show

IDENTITY = ("1", "0", "0", "0", "0", "1", "0", "0", "0", "0", "1", "0", "0", "0", "0", "1")


def count_frames(sheet: Sheet, faults: Faults) -> int:
    """Return the number of frames of a tree; what is no tree is refused."""
    counts = {}
    for key in ("nl", "nj", "nf"):
        text = sheet.values.get(key, ("",))[0]
        if key != "nf" and key not in sheet.values:
            faults.add("", f"{key.upper()} is missing; write such as NL = 6, NJ = 6")
        elif re.fullmatch(r"\d{1,4}", text):
            counts[key] = int(text)
        elif key != "nf" or text:
            faults.add("", f"{key.upper()} = {show(text)} is not a whole number; write such as NL = 6, NJ = 6")
    faults.close()
    nl, nj = counts["nl"], counts["nj"]
    nf = counts.get("nf", 2 * nj - nl)
    if sheet.values.get("type", ("0",))[0] == "2" or not nl == nj == nf:
        raise SceneError(
            f"{faults.source}: has closed loops (NL = {nl}, NJ = {nj}, NF = {nf}), and closed loops come with "
            "loop joints, which a scene does not have yet; until then cut them: keep the first NL rows of every "
            "list and write Type = 1, NJ = NF = NL"
        )
    for key in KEYS:
        given = sheet.values.get(key)
        if given is not None and len(given) != _length(key, nl):
            faults.add("", f"{key} has {len(given)} values; {_length(key, nl)} are needed")
    for key in ("sigma", "theta", "m"):
        if key not in sheet.values:
            faults.add("", f"{key} is missing; give one value a frame")
    missing = [key.upper() for key in LINK_KEYS if key not in sheet.values and key not in WRENCH]
    if missing:
        faults.note("", f"{', '.join(missing)} are not given and read as zero")
    return nl


def refuse_motion_of_base(sheet: Sheet, faults: Faults) -> None:
    """Report what moves the base or bends the joints."""
    for key in ("is_floating", "is_mobile"):
        if sheet.values.get(key, ("0",))[0].lower() not in ("0", "false", ""):
            advice = "free bases come with free joints, which a scene does not have yet; write 0 to hold the base"
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


def _length(key: str, n: int) -> int:
    """Return how many values a key has in a tree of n frames."""
    if key in BASE_KEYS:
        return 16 if key == "z" else 3
    return 1 if key in SCALAR_KEYS else n
