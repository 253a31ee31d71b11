"""What a plot of a run shows: axes of one unit each, their curves, and what these are called."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import UnknownNameError
from symdyn.simulation.columns import ENERGIES, FORCES, Column, missing

if TYPE_CHECKING:
    from symdyn.simulation.trajectory import Trajectory

USUAL = (
    "coordinates",
    "velocities",
    "inputs",
    FORCES,
    "outputs",
    ENERGIES,
    "error of the energy balance",
    "residual of the loops",
)
"""Kinds of columns that are drawn where nobody chooses."""

NOTHING = 1e-12
"""Forces below it, over the largest of them and at least 1 N, are zero: left out where nobody asks for them."""


@dataclass(frozen=True)
class Curve:
    """One curve: its column, its numbers, shape (N,), and what they are counted from."""

    column: Column
    values: Array
    zero: float = 0.0

    @property
    def label(self) -> str:
        """What it is called: a symbol between dollars, or words."""
        symbol = self.column.latex
        name = f"${symbol}$" if symbol else self.column.words
        sign = "\N{MINUS SIGN}" if self.zero > 0 else "+"
        return name + (f" {sign} {abs(self.zero):.5g} {self.column.unit}".rstrip() if self.zero else "")


@dataclass(frozen=True)
class Panel:
    """Curves that share an axis, and so a unit."""

    curves: tuple[Curve, ...]

    @property
    def title(self) -> str:
        """What they are."""
        return ", ".join(dict.fromkeys(one.column.kind for one in self.curves))

    @property
    def unit(self) -> str:
        """Their unit as it is printed, such as "m/s²"."""
        return self.curves[0].column.printed_unit


def panels(trajectory: Trajectory, names: Sequence[str] = ()) -> list[Panel]:
    """Return the axes of a plot, one a unit: of the columns that names choose, or of the usual kinds.

    Raises:
        UnknownNameError: a name or pattern that chooses nothing.
    """
    every, (_, table) = trajectory.columns, trajectory.table()
    numbers = {one.name: x for one, x in reversed(list(zip(every, table.T, strict=True)))}
    if names:
        wanted = chosen([one.name for one in every], names, trajectory.scene.name)
        picked = [one for name in wanted for one in every if one.name == name]
        by_unit = {unit: [one for one in picked if one.unit == unit] for unit in (one.unit for one in picked)}
        groups = list(by_unit.values())
    else:
        still = _zero([one for one in every if one.kind == FORCES], numbers)
        shown = sorted((one for one in every if one.kind in USUAL), key=lambda one: USUAL.index(one.kind))
        moved = [one for one in shown if one.name not in still]
        groups = []
        for _, kind in groupby(moved, key=lambda one: one.kind):
            some = list(kind)
            groups += [[one for one in some if one.unit == unit] for unit in dict.fromkeys(one.unit for one in some)]
    return [Panel(_from_zeros([(one, numbers[one.name]) for one in group])) for group in groups]


def chosen(every: Sequence[str], names: Iterable[str], where: str) -> tuple[str, ...]:
    """Return the columns among all that names and patterns, such as "point_*", choose, in the order they are given.

    Raises:
        UnknownNameError: one that chooses nothing.
    """
    found: list[str] = []
    for name in names:
        wanted = [] if not isinstance(name, str) else [name] if name in every else fnmatch.filter(every, name)
        if not wanted:
            raise UnknownNameError(f"{where}: {missing(name, every)}")
        found += wanted
    return tuple(one for one in dict.fromkeys(found) if one != TIME or TIME in names)


def _zero(forces: Sequence[Column], numbers: dict[str, Array]) -> set[str]:
    """Return the names of forces that are zero all the time."""
    sizes = {one.name: float(np.abs(numbers[one.name]).max(initial=0.0)) for one in forces}
    return {name for name, size in sizes.items() if size <= NOTHING * max(1.0, *sizes.values())}


def _from_zeros(group: Sequence[tuple[Column, Array]]) -> tuple[Curve, ...]:
    """Return curves, energies far from zero counted from their least value, or nobody would see how they move."""
    energies = [x for column, x in group if column.kind == ENERGIES and len(x)]
    moved = max((float(np.ptp(x)) for x in energies), default=0.0)
    found = []
    for column, x in group:
        away = float(np.abs(x).min(initial=np.inf))
        far = column.kind == ENERGIES and len(energies) > 1 and np.isfinite(moved) and away > max(moved, NOTHING)
        zero = float(x.min()) if far else 0.0
        found.append(Curve(column, x - zero, zero))
    return tuple(found)
