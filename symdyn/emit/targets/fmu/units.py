"""Units as FMI has them: a name, and what it is in units of SI, where it can be read."""

from __future__ import annotations

import math
import re

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""Names of exponents, in the order of the standard."""

KNOWN: dict[str, tuple[float, dict[str, int]]] = {
    **{name: (1.0, {name: 1}) for name in BASE},
    "1": (1.0, {}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "Pa": (1.0, {"kg": 1, "m": -1, "s": -2}),
    "Hz": (1.0, {"s": -1}),
    "C": (1.0, {"A": 1, "s": 1}),
    "V": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "ohm": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
    "Ω": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
    "F": (1.0, {"kg": -1, "m": -2, "s": 4, "A": 2}),
    "H": (1.0, {"kg": 1, "m": 2, "s": -2, "A": -2}),
    "T": (1.0, {"kg": 1, "s": -2, "A": -1}),
    "Wb": (1.0, {"kg": 1, "m": 2, "s": -2, "A": -1}),
    "deg": (math.pi / 180, {"rad": 1}),
    "g": (0.001, {"kg": 1}),
    "mm": (0.001, {"m": 1}),
    "cm": (0.01, {"m": 1}),
    "km": (1000.0, {"m": 1}),
    "ms": (0.001, {"s": 1}),
    "min": (60.0, {"s": 1}),
    "h": (3600.0, {"s": 1}),
    "mA": (0.001, {"A": 1}),
    "kN": (1000.0, {"kg": 1, "m": 1, "s": -2}),
    "kW": (1000.0, {"kg": 1, "m": 2, "s": -3}),
}
"""Units by name: how many of SI one is, and the exponents of these."""

FACTOR = re.compile(r"([^\W\d_]+|1)(?:(?:\^|\*\*)?(-?\d+))?\Z")


def in_base(unit: str) -> tuple[float, dict[str, int]] | None:
    """Return a unit in those of SI: its factor, and their exponents in the order of `BASE`; None where it is not read.

    A stroke divides by all that stands up to the next one.

    >>> in_base("N m s/rad")
    (1.0, {'kg': 1, 'm': 2, 's': -1, 'rad': -1})
    """
    factor, exponents = 1.0, dict.fromkeys(BASE, 0)
    for place, part in enumerate(unit.split("/")):
        for word in re.split(r"[\s.·*]+", part.replace("**", "^").strip(" ()")):
            found = FACTOR.match(word)
            if found is None or found[1] not in KNOWN:
                return None
            power = int(found[2] or 1) * (-1 if place else 1)
            size, of = KNOWN[found[1]]
            factor *= size**power
            for name, count in of.items():
                exponents[name] += count * power
    return factor, {name: count for name, count in exponents.items() if count}
