"""Units: the one table of their names and prefixes, and the reader of what is written with them.

    product   N m   N*m   N·m   Nm           quotient   N/m   m/s/s   W/(m K); not N/m s, which may be read in two ways
    power     m^2   m**2   m²   s^-1   s-1   (m/s)^2    nothing    1

A unit is an exact fraction times a power of π of the coherent unit of the International System (SI), in which
everything is computed. Radians are written where they help, and are 1. Sources: BIPM, The International System of
Units, 9th edition (2019), tables 4, 7 and 8; the inch and the pound of 1959.

Words for units that are no symbols of them, and what whoever writes them means.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from fractions import Fraction
from functools import cache, lru_cache

from symdyn.errors import nearest
from symdyn.frozen import dataclass, replace
from symdyn.graph import Op
from symdyn.scene.values import folding
from symdyn.scene.values.dimension import (
    AMOUNT,
    BRIGHTNESS,
    CURRENT,
    FORCE,
    LENGTH,
    MASS,
    NUMBER,
    POWER,
    TEMPERATURE,
    TIME,
    TORQUE,
    VOLTAGE,
    Dimension,
    product,
)
from symdyn.scene.values.quantity import FormulaError, Quantity, spell

SPELLED = {
    "meter": "m", "metre": "m", "millimeter": "mm", "millimetre": "mm", "gram": "g", "kilogram": "kg", "kilo": "kg",
    "second": "s", "sec": "s", "minute": "min", "hour": "h", "newton": "N", "joule": "J", "watt": "W", "pascal": "Pa",
    "volt": "V", "ampere": "A", "amp": "A", "hertz": "Hz", "radian": "rad", "degree": "deg", "revolution": "rev",
    "inch": "in", "inche": "in", "foot": "ft", "feet": "ft", "pound": "lb", "kelvin": "K", "mps": "m/s",
    "kph": "km/h", "mph": "km/h (1 mph is 1.609344 km/h)", "mile": "km (1 mile is 1.609344 km)", "nm": "N m",
    "centimeter": "cm", "centimetre": "cm", "kilometer": "km", "kilometre": "km", "kmh": "km/h", "cc": "cm^3",
    "litre": "dm^3", "liter": "dm^3",
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
        if first in known and last in known and known[first] != known[last] and not first.endswith(last):
            return f"{first} {last}{f'^{power}' if power else ''}"
    return None if len(name) == 1 else nearest(name, known) or SPELLED.get(nearest(word, SPELLED) or "")


LONGEST = 60
LARGEST_POWER = 9

PREFIXES = {
    "p": Fraction(1, 10**12), "n": Fraction(1, 10**9), "u": Fraction(1, 10**6), "m": Fraction(1, 1000),
    "c": Fraction(1, 100), "d": Fraction(1, 10), "da": Fraction(10), "h": Fraction(100), "k": Fraction(1000),
    "M": Fraction(10**6), "G": Fraction(10**9),
}  # fmt: skip

Powers = tuple[tuple[str, Fraction], ...]


class UnitError(FormulaError):
    """Text that is no unit, or a unit of another kind than was asked for: what was found and what would work."""


@dataclass(frozen=True)
class Unit:
    """A unit.

    Attributes:
        text: as it was written.
        scale: how many times π**turns of the coherent unit it is.
        turns: the power of π in it, 1 of degrees and turns.
        dimension: what it measures; the radian is 1.
        coherent: the coherent unit, as powers of units of SI and of rad.
        cycles: the power of cycles in it, 1 of Hz: a cycle is no radian, and 2 π of them only where one says so.
    """

    text: str
    scale: Fraction = Fraction(1)
    turns: int = 0
    dimension: Dimension = NUMBER
    coherent: Powers = ()
    cycles: int = 0

    @property
    def factor(self) -> Quantity:
        """How many of the coherent unit it is, exactly."""
        return folding.mul(
            folding.constant(self.scale), folding.power(Quantity.PI, folding.constant(Fraction(self.turns)))
        )

    @property
    def size(self) -> float:
        """How many of the coherent unit it is, as a double."""
        if not self.turns:
            return float(self.scale)
        return self.scale.numerator * math.pi**self.turns / self.scale.denominator

    @property
    def is_coherent(self) -> bool:
        """Whether it is one of the coherent unit, so that numbers in it are in SI."""
        return self.scale == 1 and not self.turns

    @property
    def si(self) -> str:
        """The coherent unit: the text itself where it is one, "m" of "mm", "rad/s" of "rpm"."""
        return self.text if self.is_coherent else self.coherent_text

    @property
    def coherent_text(self) -> str:
        """The coherent unit as a product of powers."""
        return product(list(self.coherent))

    @property
    def radians(self) -> Fraction:
        return dict(self.coherent).get("rad", Fraction(0))

    def __mul__(self, other: Unit) -> Unit:
        powers = dict(self.coherent)
        for name, power in other.coherent:
            powers[name] = powers.get(name, Fraction(0)) + power
        return Unit(
            f"{self.text} {other.text}",
            self.scale * other.scale,
            self.turns + other.turns,
            self.dimension * other.dimension,
            tuple((name, power) for name, power in powers.items() if power),
            self.cycles + other.cycles,
        )

    def __pow__(self, power: int) -> Unit:
        return Unit(
            f"{self.text}^{power}",
            self.scale**power,
            self.turns * power,
            self.dimension**power,
            tuple((name, own * power) for name, own in self.coherent if power),
            self.cycles * power,
        )

    @staticmethod
    @lru_cache(1024)
    def read(text: str) -> Unit:
        """Return a unit.

        >>> Unit.read("kN/m").scale, Unit.read("kN/m").si, Unit.read("N m s/rad").dimension.text
        (Fraction(1000, 1), 'N/m', 'N m s')

        Raises:
            UnitError: it is none.
        """
        plain = " ".join(text.translate(_PLAIN).replace("**", "^").split())
        if not plain:
            raise UnitError("is empty; give a unit, such as mm")
        if len(plain) > LONGEST:
            raise UnitError(f'"{plain[:20]}..." has {len(plain)} characters, and is no unit; {LONGEST} are enough')
        if plain.strip("[]() ").lower() in PLAIN_NUMBER:
            raise UnitError(f'"{plain}" is no unit; write 1, or leave it out')
        if AFFINE.search(plain):
            raise UnitError(f"{plain} counts from a zero of its own, so that no factor leads to SI; give kelvins, K")
        reader = _Reader(plain)
        found = reader.product()
        if reader.at < len(plain):
            raise reader.refusal("breaks off")
        return replace(found, text=" ".join(text.split()))

    def misfit(self, unit: Unit, number: str = "") -> str | None:
        """Return what is wrong with a value in it where another is asked for, or None where it can be converted.

        Args:
            unit: of what it is for.
            number: the value as it was written, for the two readings of cycles.
        """
        if self.dimension != unit.dimension:
            told = f"is in {self.text}, and {unit.text} is asked for"
            in_time = re.search(r"\bt\b", self.text) and not re.search(r"\bt\b", unit.text)
            named = re.sub(r" ?\*? ?\bt\b.*", "", self.text)
            write = f'in a formula write SI, or name it: w = "{number or 3} {named}" in parameters, and w*t'
            return f"{told}; a unit stands behind a number alone: {write}" if in_time and named else told
        if self.cycles == unit.cycles or unit.dimension == NUMBER:
            return None
        count = number or "3"
        try:
            size = float(Fraction(count)) * float(self.scale)
        except (ValueError, ZeroDivisionError, OverflowError):
            return f"is in {self.text}, which are cycles, and {unit.text} is asked for; one cycle is 2*pi rad"
        if self.cycles:
            return (
                f"is in cycles, and {unit.text} is asked for: {count} {self.text} is {size:.6g} cycles a second, "
                f"{2 * size:.6g}*pi rad/s = {2 * math.pi * size:.6g}; or did you mean {size:.6g} rad/s?"
            )
        return f"is in {self.text}, and cycles, {unit.text}, are asked for; one cycle is 2*pi rad"


def si(name: str, dimension: Dimension, prefixes: str = "") -> tuple[Unit, str]:
    """Return a row of the table: a coherent unit, and the prefixes that it takes."""
    return Unit(name, dimension=dimension, coherent=((name, Fraction(1)),)), prefixes


def many(name: str, count: str | Fraction, of: Unit, turns: int = 0, prefixes: str = "") -> tuple[Unit, str]:
    """Return a row of the table: so many times π**turns of another unit."""
    return replace(of, text=name, scale=of.scale * Fraction(count), turns=of.turns + turns), prefixes


_M, _S, _KG, _A, _N, _RAD, _V, _PA, _OHM = (
    Unit(name, dimension=dimension, coherent=((name, Fraction(1)),))
    for name, dimension in (
        ("m", LENGTH), ("s", TIME), ("kg", MASS), ("A", CURRENT), ("N", FORCE), ("rad", NUMBER), ("V", VOLTAGE),
        ("Pa", FORCE / LENGTH**2), ("ohm", VOLTAGE / CURRENT),
    )
)  # fmt: skip
_IN, _FT, _LB = (many(*row)[0] for row in (("in", "0.0254", _M), ("ft", "0.3048", _M), ("lb", "0.45359237", _KG)))
_LBF = many("lbf", "4.4482216152605", _N)[0]
_MM, _CM = (many(*row)[0] for row in (("mm", "0.001", _M), ("cm", "0.01", _M)))

ROWS: tuple[tuple[Unit, str], ...] = (
    (Unit("1"), ""),
    si("kg", MASS),
    many("g", "0.001", _KG, prefixes="n u m"),
    many("t", "1000", _KG),
    si("m", LENGTH, "p n u m c d k"),
    si("s", TIME, "p n u m"),
    many("min", "60", _S),
    many("h", "3600", _S),
    si("A", CURRENT, "n u m k"),
    si("K", TEMPERATURE, "m"),
    si("mol", AMOUNT, "m"),
    si("cd", BRIGHTNESS),
    si("rad", NUMBER, "u m"),
    many("deg", "1/180", _RAD, 1),
    many("°", "1/180", _RAD, 1),
    many("arcmin", "1/10800", _RAD, 1),
    many("arcsec", "1/648000", _RAD, 1),
    many("gon", "1/200", _RAD, 1),
    many("rev", "2", _RAD, 1),
    many("turn", "2", _RAD, 1),
    many("rpm", "1/30", _RAD * _S**-1, 1),
    many("rps", "2", _RAD * _S**-1, 1),
    (Unit("Hz", dimension=TIME**-1, coherent=(("Hz", Fraction(1)),), cycles=1), "m k M G"),
    si("N", FORCE, "u m c da k M"),
    (replace(_N * _M, text="Nm"), "u m k M"),
    (replace(_N * _CM, text="Ncm"), ""),
    (replace(_N * _MM, text="Nmm"), ""),
    (replace(_N * _S, text="Ns"), "m k"),
    (replace(_N * _M * _S, text="Nms"), "m k"),
    si("J", TORQUE, "u m k M G"),
    si("W", POWER, "u m k M G"),
    si("Pa", FORCE / LENGTH**2, "m h k M G"),
    many("bar", "100000", _PA, prefixes="m"),
    si("C", CURRENT * TIME, "n u m"),
    si("V", VOLTAGE, "n u m k"),
    si("ohm", VOLTAGE / CURRENT, "u m k M"),
    many("Ω", "1", _OHM, prefixes="u m k M"),
    si("F", CURRENT * TIME / VOLTAGE, "p n u m"),
    si("H", VOLTAGE * TIME / CURRENT, "n u m"),
    si("T", VOLTAGE * TIME / LENGTH**2, "n u m"),
    si("Wb", VOLTAGE * TIME, "u m"),
    (_IN, ""),
    (_FT, ""),
    (_LB, ""),
    (_LBF, ""),
    many("oz", "1/16", _LB),
    many("slug", Fraction("4.4482216152605") / Fraction("0.3048"), _KG),
    (replace(_LBF * _IN**-2, text="psi", coherent=_PA.coherent), ""),
    many("kgf", "9.80665", _N),
    (Unit("%", Fraction(1, 100)), ""),
    (Unit("count"), ""),
    (Unit("counts"), ""),
)
"""Units, and the prefixes that each takes."""

AFFINE = re.compile(r"(?:(?:deg|degrees?|°)[ ]*[CF]|℃|℉|[Cc]elsius|[Ff]ahrenheit)(?![A-Za-z])")
"""Temperatures that count from a zero of their own."""

_PLAIN = str.maketrans(
    {"µ": "u", "μ": "u", "Ω": "Ω", "·": "*", "⋅": "*", "×": "*", "−": "-"}
    | dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True))
)

_WHOLE = r"-?[0-9]+(?:[.][0-9]+)?|\(-?[0-9]+(?:[.][0-9]+)?\)"
_TOKEN = re.compile(
    rf"[ ]*(?:(?P<name>[^\W\d_]+|[°%]|1(?![0-9]))(?:(?:[ ]*\^[ ]*)?(?P<power>{_WHOLE}))?"
    r"|(?P<sign>[*/()]))"
)
_POWER = re.compile(rf"[ ]*\^[ ]*({_WHOLE})")
_BETWEEN = re.compile(r"(?<=\w)[ ]?[.-][ ]?(?=[^\W\d_])")


@cache
def units() -> dict[str, Unit]:
    """Return all units by name, prefixes in front."""
    found = {unit.text: unit for unit, _ in ROWS}
    for unit, prefixes in ROWS:
        for prefix in prefixes.split():
            name = prefix + unit.text
            assert name not in found, f"{name} would be two units"
            found[name] = replace(unit, text=name, scale=unit.scale * PREFIXES[prefix])
    return found


class _Reader:
    """Reads one unit from left to right."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0

    def product(self) -> Unit:
        """Return factors up to a closing bracket or the end."""
        found, below, last = Unit("1"), False, ""
        while self.at < len(self.text) and self.text[self.at :].strip()[:1] != ")":
            token = self.token()
            sign = token["sign"]
            if sign in ("*", "/"):
                if last in ("", "*", "/"):
                    raise self.refusal(f"has nothing before {sign}" if last == "" else "has two signs together")
                last, below = sign, below or sign == "/"
                continue
            if below and last != "/":
                raise self.refusal("may be read in two ways: write W/(m K) or W K/m")
            factor = self.bracket() if sign == "(" else self.named(token["name"], token["power"] or "")
            power = 1 if sign == "(" else self.power(token["power"])
            found *= factor ** (-power if last == "/" else power)
            last = "unit"
        if last in ("", "*", "/"):
            raise self.refusal("breaks off")
        return found

    def bracket(self) -> Unit:
        found = self.product()
        if self.text[self.at :].strip()[:1] != ")":
            raise self.refusal("lacks a bracket")
        self.at = self.text.index(")", self.at) + 1
        behind = _POWER.match(self.text, self.at)
        if behind is None:
            return found
        self.at = behind.end()
        return found ** self.power(behind[1])

    def power(self, text: str | None) -> int:
        """Return a power as it was written, 1 of none."""
        try:
            power = int(text.strip("()")) if text else 1
        except ValueError:
            raise self.refusal(f"has a power that is no whole number, {text}") from None
        if abs(power) > LARGEST_POWER:
            raise self.refusal(f"has a power beyond {LARGEST_POWER}")
        return power

    def token(self) -> re.Match[str]:
        found = _TOKEN.match(self.text, self.at)
        if found is None or found["sign"] == ")":
            raise self.refusal("is no unit")
        self.at = found.end()
        return found

    def named(self, name: str, power: str) -> Unit:
        if name not in units():
            near = meant_by(name, power, {known: unit.dimension for known, unit in units().items()})
            meant = f"did you mean {near}?" if near else "there are such as mm, kg, N/m, deg, rpm"
            meant = f"write * before {name}" if name in folding.UNARY_FUNCTIONS else meant
            raise UnitError(f"{name} is no unit; {meant}")
        return units()[name]

    def refusal(self, what: str) -> UnitError:
        meant = _BETWEEN.sub(" ", self.text.strip("[] "))
        if meant != self.text and meant.strip():
            return UnitError(f'"{self.text}" is no unit; write {meant}')
        return UnitError(f'"{self.text}" {what}; give a unit such as mm, kN/m, N m s/rad or kg m^2')


def in_si(value: Quantity, unit: Unit) -> Quantity:
    """Return a number of this unit in the coherent one, exactly.

    >>> in_si(Quantity.number(500), Unit.read("mm")).value
    Fraction(1, 2)
    """
    return _times_pi(folding.mul(folding.constant(unit.scale), value), unit.turns)


def out_of_si(value: Quantity, unit: Unit) -> Quantity:
    """Return a number of the coherent unit in this one, exactly; `in_si` undoes it."""
    return folding.mul(folding.constant(1 / unit.scale), _times_pi(value, -unit.turns))


def _times_pi(value: Quantity, power: int) -> Quantity:
    """Return a quantity times a power of π, cancelled where π stands last."""
    for _ in range(abs(power)):
        factor, rest = folding.split(value)
        inverse, undone = (Op.DIV, folding.mul) if power > 0 else (Op.MUL, folding.div)
        if rest.op is inverse and rest.args[1] == Quantity.PI:
            value = folding.mul(folding.constant(factor), rest.args[0])
        elif power < 0 and rest == Quantity.PI:
            value = folding.constant(factor)
        else:
            value = undone(value, Quantity.PI)
    return value


def with_unit(value: Quantity, unit: str) -> str:
    """Return a quantity of SI as a number and a unit."""
    return f"{spell(out_of_si(value, Unit.read(unit)))} {unit}"
