"""What reports of identification are made of: tables, which the shell prints too, pictures, sections."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, nan
from typing import TYPE_CHECKING

from symdyn.algebra import Array
from symdyn.rounding import in_digits
from symdyn.table import Table

if TYPE_CHECKING:
    from symdyn.identification.identification import Identification


@dataclass(frozen=True)
class Picture:
    """An SVG element, and what stands below it."""

    svg: str
    caption: str


@dataclass(frozen=True)
class Section:
    """A part of the page."""

    title: str
    words: tuple[str, ...] = ()
    tables: tuple[Table[str], ...] = ()
    pictures: tuple[Picture, ...] = ()
    legend: tuple[tuple[str, str], ...] = ()
    small: bool = False


def figure(value: float, digits: int = 5) -> str:
    """Return a number as a cell shows it."""
    return in_digits(float(value), digits) if isfinite(value) else "\u2013"


def parameter_table(identification: Identification) -> Table[str]:
    """Return the base parameters before and after; gains, which have units, have a table of their own."""
    columns = (
        identification.names,
        identification.before,
        identification.after,
        identification.errors,
        identification.interval(),
        identification.regression.identifiable,
    )
    count = len(identification.names) - len(identification.gains)
    rows = []
    for name, before, after, error, interval, told in list(zip(*columns, strict=True))[:count]:
        more = ("not told", "", "", "", "")
        if told:
            more = (*_sure(error, interval, after), figure((after - before) / error if error else nan, 2))
        rows.append((name, figure(before), figure(after), *more))
    heads = ("parameter", "before", "after", *SURE, "moved, in standard errors")
    return Table(heads, rows, range(1, 8), f"Base parameters of {identification.scene.name}")


def gain_table(identification: Identification) -> Table[str]:
    """Return the gains of drives; without rows where there are none."""
    intervals = dict(zip(identification.names, identification.interval(), strict=True))
    rows = [
        (one.drive, one.unit, figure(one.value), *_sure(one.error, intervals[f"gain {one.drive}"], one.value))
        if isfinite(one.error)
        else (one.drive, one.unit, figure(nan), "not told", "", "", "")
        for one in identification.gains
    ]
    return Table(("drive", "unit", "gain", *SURE), rows, range(2, 7), "Gains of drives")


SURE = ("standard error", "95 % from", "to", "% of it")
"""How sure an estimate is."""


def _sure(error: float, interval: Array, value: float) -> tuple[str, str, str, str]:
    low, high = interval
    return figure(error, 2), figure(low), figure(high), figure(100 * error / abs(value), 2) if value else ""


def fit_table(identification: Identification) -> Table[str]:
    """Return how well driving forces are predicted: root mean squares, errors those in the band."""
    rows = [
        (one.drive, one.unit, figure(one.size), figure(one.error, 3), figure(one.percent, 2), figure(one.before, 3),
         figure(one.held_back, 3), figure(one.held_back_percent, 2))
        for one in identification.fits
    ]  # fmt: skip
    heads = ("drive", "unit", "measured", "error", "%", "error before", "error held back", "%")
    return Table(heads, rows, range(2, 8), "Driving forces, root mean squares")
