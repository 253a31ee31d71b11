"""Letters of formulas: parameters, inputs, states of one's own; and signals, formulas with a name.

A state has a formula for its rate, such as the current of a motor:

    ṡ = rate(t, q, u, s, w, p)          s(0) = value
    s⁺ = to(t, q, u, s, w, p)           where `when` passes zero

How far the value of a parameter may be off, as the scene says it: "5 %", "0.1 mm", 0.02.

The plain word says bounds, and any value between them alike: who states a tolerance and no more knows no more. With
`{ sigma = "1 %" }` it is the standard deviation of a normal distribution.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from decimal import Decimal
from typing import Any, ClassVar, TypeAlias

from symdyn.errors import UnknownNameError, suggestion
from symdyn.frozen import dataclass, field
from symdyn.scene.values.quantity import FormulaError, Quantity
from symdyn.scene.values.unit import Unit
from symdyn.shown import Suggesting

PERCENT = "%"

WORDS = ("within", "sigma")

FORM = 'give such as "5 %", "0.1 mm" or 0.02, or { sigma = "1 %" }'

LONGEST = 60

_TEXT = r"(?a)(?:±|\+-|\+/-)?\s*(?P<number>\d+\.?\d*(?:[eE][+-]?\d{1,3})?|\.\d+(?:[eE][+-]?\d{1,3})?)\s*(?P<unit>.*)"


@dataclass(frozen=True)
class Tolerance:
    """How far a value may be off."""

    number: str  # as written: half the width of what is allowed, or the standard deviation; above zero
    unit: str = ""  # of the number: "%" of the value, a unit, or "" for that of the parameter
    sigma: bool = False  # whether it is the standard deviation of a normal distribution

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


class Named(tuple[Any, ...], Suggesting):
    """What a scene has several of, by its number or by its name: `scene.parameters["m"]`."""

    __slots__ = ()

    def __getitem__(self, which: Any) -> Any:
        """Return one, or some of a slice; UnknownNameError for a name that is none."""
        if not isinstance(which, str):
            return super().__getitem__(which)
        known = {getattr(one, "name", ""): one for one in self}
        if which not in known:
            raise UnknownNameError(f"there is no {which}; {suggestion(which, known)}")
        return known[which]

    def keys(self) -> tuple[str, ...]:
        """Return the names."""
        return tuple(getattr(one, "name", "") for one in self)


@dataclass(frozen=True)
class Parameter:
    """A named constant of the scene.

    Attributes:
        name: as formulas write it.
        value: its value, free of symbols unless it is derived; None leaves it an argument of every generated function.
        positive: an assumption that printing and certificates may use.
        unit: the coherent unit of its value, e.g. "kg"; "" where none is said.
        latex: how to print it; None derives it from the name.
        text: a description for tables.
        texts: the same in other languages: ("sk", description).
        tolerance: how far the value may be off, for sweeps; no part of the equations.
        written: the unit that its writer chose, such as "mm", where it is not `unit`, in which the value is.
        of: the letter whose rate it is, where it stands for an input; "" of all others.
    """

    name: str
    value: Quantity | None = None
    positive: bool = False
    unit: str = ""
    latex: str | None = None
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()
    tolerance: Tolerance | None = None
    written: str = field(default="", compare=False)
    of: str = ""


@dataclass(frozen=True)
class Input:
    """A symbol whose value is given over time from outside, such as a motor's voltage; forces and loads may use it.

    With rates it is the first of two or three inputs, of which the others are its derivatives by time, named as those
    of a coordinate: road, road_dot, road_ddot.

    Attributes:
        name: as formulas write it.
        value: where none is given over time, free of symbols.
        unit, latex, text, texts, written: as of a `Parameter`.
        rates: how many of its rates are inputs too, 0 to 2.
        of: the input whose rate it is; "" of one that is given.
    """

    name: str
    value: Quantity = Quantity.ZERO
    unit: str = ""
    latex: str | None = None
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()
    written: str = field(default="", compare=False)
    rates: int = 0
    of: str = ""


@dataclass(frozen=True)
class Signal:
    """A formula with a name: an output, which may use positions of points and reactions, see `grammar`; or a signal.

    Attributes:
        name: of its column, and behind "output:"; of a signal as other formulas write it.
        formula: in coordinates, velocities, accelerations, drives, inputs, parameters, t, points and reactions.
        unit: for tables, e.g. "m".
        text, texts: as of a `Parameter`.
    """

    name: str
    formula: Quantity
    unit: str = ""
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()


WAYS = ("both", "up", "down")
"""Which passages of zero count."""


@dataclass(frozen=True)
class Reset:
    """A jump of a state."""

    when: Quantity  # formula whose passage of zero it is
    to: Quantity = Quantity.ZERO  # formula of the state behind it, in what there is before it
    way: str = WAYS[0]  # "up" where `when` turns positive, "down" where it turns negative, "both"


@dataclass(frozen=True)
class StateVariable:
    """A state that is no coordinate and no velocity.

    Attributes:
        name: as formulas write it.
        rate: formula in coordinates, velocities, states, inputs, parameters and t.
        value: where it starts, a formula in parameters.
        reset: where it jumps; None: nowhere.
        unit, latex, text, texts: as of a `Parameter`.
    """

    name: str
    rate: Quantity
    value: Quantity = Quantity.ZERO
    reset: Reset | None = None
    unit: str = ""
    latex: str | None = None
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()

    written: ClassVar[str] = ""
    of: ClassVar[str] = ""
    """Its rate is computed, so that its unit is of SI."""

    @property
    def rate_unit(self) -> str:
        """The coherent unit of its rate, "" where it has none."""
        return f"{'1' if self.unit in ('', '1') else self.unit}/s" if self.unit else ""


def resets_of(states: Iterable[StateVariable]) -> dict[tuple[Quantity, str], dict[str, Quantity]]:
    """Return by when states jump, and which way that passes zero, which ones do, and to what."""
    found: dict[tuple[Quantity, str], dict[str, Quantity]] = {}
    for one in states:
        if one.reset is not None:
            found.setdefault((one.reset.when, one.reset.way), {})[one.name] = one.reset.to
    return found


Letter: TypeAlias = Parameter | Input | StateVariable
"""What has a value, and a unit."""
