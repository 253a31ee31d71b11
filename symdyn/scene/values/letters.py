"""Letters of formulas: parameters, inputs, states of one's own; and signals, formulas with a name.

A state has a formula for its rate, such as the current of a motor:

    ṡ = rate(t, q, u, s, w, p)          s(0) = value
    s⁺ = to(t, q, u, s, w, p)           where `when` passes zero
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar, TypeAlias

from symdyn.errors import UnknownNameError, suggestion
from symdyn.frozen import dataclass, field
from symdyn.scene.values.quantity import Quantity
from symdyn.scene.values.tolerance import Tolerance


class Named(tuple[Any, ...]):
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
        unit: the coherent unit of its value, e.g. "V"; "" where none is given.
        latex: how to print it; None derives it from the name.
        text: a description for tables.
        texts: the same in other languages: ("sk", description).
        written: the unit that its writer chose, such as "mV", where it is not `unit`, in which the value is.
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
        text: a description for tables.
        texts: the same in other languages: ("sk", description).
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
    """A jump of a state.

    Attributes:
        when: formula whose passage of zero it is.
        to: formula of the state behind it, in what there is before it.
        way: "up" where `when` turns positive, "down" where it turns negative, "both".
    """

    when: Quantity
    to: Quantity = Quantity.ZERO
    way: str = WAYS[0]


@dataclass(frozen=True)
class StateVariable:
    """A state that is no coordinate and no velocity.

    Attributes:
        name: as formulas write it.
        rate: formula in coordinates, velocities, states, inputs, parameters and t.
        value: where it starts, a formula in parameters.
        reset: where it jumps; None: nowhere.
        unit: the coherent unit of its value, e.g. "A"; "" where none is given.
        latex: how to print it; None derives it from the name.
        text: a description for tables.
        texts: the same in other languages: ("sk", description).
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
