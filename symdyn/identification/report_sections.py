"""What reports of identification are made of: tables, pictures, sections."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from symdyn.rounding import in_digits


@dataclass(frozen=True)
class ReportTable:
    """A table of words: its caption, its columns, whether each holds numbers, and its rows."""

    caption: str
    columns: tuple[str, ...]
    numbers: tuple[bool, ...]
    rows: tuple[tuple[str, ...], ...]


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
    tables: tuple[ReportTable, ...] = ()
    pictures: tuple[Picture, ...] = ()
    legend: tuple[tuple[str, str], ...] = ()
    small: bool = False


def figure(value: float, digits: int = 5) -> str:
    """Return a number as a cell shows it."""
    return in_digits(float(value), digits) if isfinite(value) else "\u2013"
