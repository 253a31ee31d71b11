"""Words for units that are no symbols of them, and what whoever writes them means."""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.scene.values.dimension import Dimension
from symdyn.scene.values.names import nearest

SPELLED = {
    "meter": "m", "metre": "m", "millimeter": "mm", "millimetre": "mm", "gram": "g", "kilogram": "kg", "kilo": "kg",
    "second": "s", "sec": "s", "minute": "min", "hour": "h", "newton": "N", "joule": "J", "watt": "W", "pascal": "Pa",
    "volt": "V", "ampere": "A", "amp": "A", "hertz": "Hz", "radian": "rad", "degree": "deg", "revolution": "rev",
    "inch": "in", "inche": "in", "foot": "ft", "feet": "ft", "pound": "lb", "kelvin": "K", "mps": "m/s",
    "kph": "km/h", "mph": "km/h (1 mph is 1.609344 km/h)", "mile": "km (1 mile is 1.609344 km)", "nm": "N m",
    "centimeter": "cm", "centimetre": "cm", "kilometer": "km", "kilometre": "km", "kmh": "km/h", "cc": "cm^3",
    "l": "dm^3", "litre": "dm^3", "liter": "dm^3",
}  # fmt: skip
"""Words for units, which are no symbols, and the symbol that is meant; without an s at the end."""

PLAIN_NUMBER = ("-", "none", "dimensionless", "unitless")
"""Words of people for the unit of a plain number, in brackets or not."""


def meant_by(name: str, power: str, known: Mapping[str, Dimension]) -> str | None:
    """Return the unit that a name may have meant: the symbol of a word, two symbols without a space, or a near one.

    Args:
        name: which is no unit.
        power: as it stands behind the name, "" for none.
        known: units and their dimensions.
    """
    word, singular = name.lower(), name.removesuffix("s")
    if found := SPELLED.get(word) or SPELLED.get(word.removesuffix("s")):
        return found
    if same := next((one for one in known if one.lower() == word), ""):
        return same
    if singular in known and len(singular) > 1:
        return singular
    for k in range(len(name) - 1, 0, -1):
        first, last = name[:k], name[k:]
        if first in known and last in known and known[first] != known[last]:
            return f"{first} {last}{f'^{power}' if power else ''}"
    return nearest(name, known) or SPELLED.get(nearest(word, SPELLED) or "")
