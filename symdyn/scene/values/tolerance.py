"""How far the value of a parameter may be off, as the scene says it: "5 %", "0.1 mm", 0.02.

The plain word says bounds, and any value between them alike: who states a tolerance and no more knows no more. With
`{ sigma = "1 %" }` it is the standard deviation of a normal distribution.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from decimal import Decimal

from symdyn.frozen import dataclass
from symdyn.scene.values.quantity import FormulaError
from symdyn.scene.values.unit import Unit

PERCENT = "%"

WORDS = ("within", "sigma")

FORM = 'give such as "5 %", "0.1 mm" or 0.02, or { sigma = "1 %" }'

LONGEST = 60

_TEXT = r"(?a)(?:±|\+-|\+/-)?\s*(?P<number>\d+\.?\d*(?:[eE][+-]?\d{1,3})?|\.\d+(?:[eE][+-]?\d{1,3})?)\s*(?P<unit>.*)"


@dataclass(frozen=True)
class Tolerance:
    """How far a value may be off.

    Attributes:
        number: as written: half the width of what is allowed, or the standard deviation; above zero.
        unit: of the number: "%" of the value, a unit, or "" for that of the parameter.
        sigma: whether it is the standard deviation of a normal distribution.
    """

    number: str
    unit: str = ""
    sigma: bool = False

    @property
    def text(self) -> str:
        """As a scene writes it, "5 %"."""
        return f"{self.number} {self.unit}".rstrip()

    def size(self, value: float, unit: str) -> float:
        """Return the amount in the coherent unit of its parameter, which has this value."""
        if self.unit == PERCENT:
            return abs(value) * float(self.number) / 100
        scale = Unit.read(self.unit).size / Unit.read(unit).size if self.unit not in ("", unit) else 1.0
        return float(self.number) * scale


def read_tolerance(raw: object, unit: str) -> Tolerance:
    """Return the tolerance of a parameter in this unit, in which a bare number is.

    >>> read_tolerance("5 %", "kg").size(2, "kg"), read_tolerance("0.5 mm", "m").size(2, "m")
    (0.1, 0.0005)

    Raises:
        FormulaError: it is none, or of another unit.
    """
    if isinstance(raw, Tolerance):
        return raw
    if isinstance(raw, Mapping):
        if len(raw) != 1 or next(iter(raw)) not in WORDS or isinstance(next(iter(raw.values())), Mapping):
            raise FormulaError(f"has {', '.join(map(str, raw)) or 'nothing'} in it; {FORM}")
        ((word, inside),) = raw.items()
        found = read_tolerance(inside, unit)
        return Tolerance(found.number, found.unit, word == "sigma")
    if isinstance(raw, bool) or not isinstance(raw, str | int | float | Decimal):
        raise FormulaError(f"is no tolerance; {FORM}")
    match = re.fullmatch(_TEXT, str(raw).strip()) if len(str(raw)) <= LONGEST else None
    if match is None:
        raise FormulaError(f"is no tolerance above zero; {FORM}")
    number, own = match["number"], match["unit"].strip()
    if not 0 < float(number) < math.inf:
        raise FormulaError(f"is no tolerance above zero; {FORM}")
    if own not in ("", PERCENT, unit) and not (unit and Unit.read(own).misfit(Unit.read(unit)) is None):
        said = f"its parameter is in {unit}" if unit else "its parameter has no unit"
        raise FormulaError(f"is in {own}, and {said}; {FORM}")
    chosen = "" if not unit or Unit.read(unit).is_coherent else unit
    return Tolerance(number, own or chosen)
