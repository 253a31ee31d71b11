"""What a few letters of an MJCF file make the compiler fill memory with, counted before it sees them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf

from symdyn.bounds import BOUNDS
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values.table import Faults

RESOLUTIONS = {"cone": (0,), "wedge": (0, 1), "plate": (0, 1)}
"""Which parameters of a built-in mesh its corners are the product of; of all others they are the first one squared."""

ADVICE = {
    "heights of the hfields of an MJCF file": "no equation depends on a height field: delete it",
    "corners of the built-in meshes of an MJCF file": 'give the body <inertial pos="..." mass="..."/> instead',
}


def check_made(elements: Iterable[XmlElement], faults: Faults) -> None:
    """Report height fields and built-in meshes that are larger than is read, all of them together."""
    made = dict.fromkeys(ADVICE, 0.0)
    lines: dict[str, int] = {}
    copies = 1
    for element in elements:
        copies += element.tag == "attach"
        for what, count in _made(element).items():
            made[what] += count
            lines.setdefault(what, element.line)
    for what, count in made.items():
        if count * copies > BOUNDS[what]:
            found = f"{count * copies:.0f}" if count < 10**9 else f"{count * copies:.0e}"
            most = f"{BOUNDS[what]} are the most that is read"
            faults.add(f"line {lines[what]}", f"makes {found} {what}; {most}; {ADVICE[what]}")


def _made(element: XmlElement) -> Mapping[str, float]:
    """Return how much an element makes, by what."""
    heights, corners = ADVICE
    given = element.attributes
    if element.tag == "hfield":
        return {heights: _number(given.get("nrow", "0")) * _number(given.get("ncol", "0"))}
    if element.tag == "mesh" and "params" in given:
        numbers = [_number(word) for word in given["params"].split()] or [0.0]
        product = 1.0
        for k in RESOLUTIONS.get(given.get("builtin", ""), (0, 0)):
            product *= numbers[min(k, len(numbers) - 1)]
        return {corners: product}
    return {}


def _number(word: str) -> float:
    """Return the size of a number, without end where it is none that is read."""
    try:
        found = abs(float(word))
    except ValueError:
        return inf
    return found if found < 1e100 else inf
