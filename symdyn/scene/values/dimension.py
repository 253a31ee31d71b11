"""Dimensions: what a number measures, as exponents of the base quantities of the International System of Units.

The radian is 1, so that a torque and an energy have one dimension, and an angle has none.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from symdyn.frozen import dataclass

BASE = ("kg", "m", "s", "A", "K", "mol", "cd")
"""The units whose exponents a dimension holds, in this order."""

Exponent = int | Fraction
"""A fraction only where it is no integer: dimensions are multiplied at every factor of a formula."""

LONGEST_POWER = 6
"""Characters of an exponent that is printed as it is; a longer one is rounded."""

_NONE: tuple[Exponent, ...] = (0,) * len(BASE)


@dataclass(frozen=True)
class Dimension:
    """What a number measures, by exponents of the units in `BASE`.

    >>> (MASS * LENGTH / TIME**2).text, (MASS * LENGTH**2).text, Dimension().text
    ('N', 'kg m^2', '1')
    """

    exponents: tuple[Exponent, ...] = _NONE

    def __mul__(self, other: Dimension) -> Dimension:
        if other.exponents is _NONE or self.exponents is _NONE:
            return self if other.exponents is _NONE else other
        return Dimension(tuple(a + b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __truediv__(self, other: Dimension) -> Dimension:
        return Dimension(tuple(a - b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __pow__(self, power: Exponent) -> Dimension:
        return Dimension(tuple(_plain(a * power) for a in self.exponents))

    @property
    def powers(self) -> list[tuple[str, Exponent]]:
        return list(zip(BASE, self.exponents, strict=True))

    @property
    def text(self) -> str:
        """A unit of it, by its name where it has one: "N m", "kg m^2/s"; "1" of a plain number."""
        return _NAMES.get(self) or product(self.powers)

    def __str__(self) -> str:
        return self.text


def _plain(power: Exponent) -> Exponent:
    return power if isinstance(power, int) or power.denominator != 1 else power.numerator


def product(powers: Sequence[tuple[str, Exponent]]) -> str:
    """Return a product of powers of units as text.

    >>> product([("W", Fraction(1)), ("m", Fraction(-1)), ("K", Fraction(-1))]), product([("s", Fraction(-2))])
    ('W/(m K)', '1/s^2')
    """
    above = [_power(name, power) for name, power in powers if power > 0]
    below = [_power(name, -power) for name, power in powers if power < 0]
    under = below[0] if len(below) == 1 else f"({' '.join(below)})"
    return (" ".join(above) or "1") + (f"/{under}" if below else "")


def _power(name: str, power: Exponent) -> str:
    told = str(power) if len(str(power)) <= LONGEST_POWER else f"{float(power):.4g}"
    return name if power == 1 else f"{name}^{told}" if power.denominator == 1 else f"{name}^({told})"


MASS, LENGTH, TIME, CURRENT, TEMPERATURE, AMOUNT, BRIGHTNESS = (
    Dimension(tuple(int(k == i) for k in range(len(BASE)))) for i in range(len(BASE))
)
NUMBER = Dimension()
VELOCITY = LENGTH / TIME
ACCELERATION = LENGTH / TIME**2
FORCE = MASS * ACCELERATION
TORQUE = FORCE * LENGTH
POWER = TORQUE / TIME
VOLTAGE = POWER / CURRENT

FORCE_UNITS = ("N m", "N")
"""Of the generalized force at a joint that turns, and at one that slides."""


def force_unit(unit: str) -> str:
    """Return the unit of the generalized force along a coordinate in "rad" or "m"; of a force about or along an axis.

    >>> force_unit("rad"), force_unit("m")
    ('N m', 'N')
    """
    return FORCE_UNITS[unit == "m"]


_NAMES = {
    FORCE: "N",
    TORQUE: "N m",
    POWER: "W",
    FORCE / LENGTH: "N/m",
    FORCE / VELOCITY: "N s/m",
    FORCE * TIME: "N s",
    TORQUE * TIME: "N m s",
    TORQUE * TIME**2: "kg m^2",
    FORCE / LENGTH**2: "Pa",
    VOLTAGE: "V",
    VOLTAGE / CURRENT: "ohm",
    CURRENT * TIME / VOLTAGE: "F",
    VOLTAGE * TIME / CURRENT: "H",
    VOLTAGE * TIME / LENGTH**2: "T",
    FORCE / VOLTAGE: "N/V",
    TORQUE / VOLTAGE: "N m/V",
    FORCE / CURRENT: "N/A",
    TORQUE / CURRENT: "N m/A",
}
"""Dimensions that are known by another name than the product of their base units.

A coulomb is a newton metre a volt, and a weber one an ampere: what stands in formulas of mechanisms are the constants
of motors.
"""
