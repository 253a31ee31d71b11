"""The section of a report about the identified scene: its bodies, and how sure they are."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

import numpy as np

from symdyn.errors import printable
from symdyn.identification import charts
from symdyn.identification.physical import Physical
from symdyn.identification.report_sections import Picture, ReportTable, Section, figure
from symdyn.identification.scene import Identified
from symdyn.identification.unknowns import ten_of_body

MOST_BODIES = 24
"""Bodies whose ellipsoids are drawn."""


def scene_section(made: Identified) -> Section:
    """Return what became of the scene."""
    tables, pictures = [], list[Picture]()
    if made.named is not None:
        one = made.named
        rows = tuple(
            (name, figure(before), figure(value), figure(error, 2) if isfinite(error) else "not told")
            for name, before, value, error in zip(one.names, one.before, one.values, one.errors, strict=True)
        )
        heads = ("parameter", "before", "after", "standard error")
        tables.append(ReportTable("Parameters with names", heads, (False, True, True, True), rows))
    legend: tuple[tuple[str, str], ...] = ()
    if made.physical is not None:
        tables.append(_bodies(made.physical))
        acting = _acting(made.physical)
        tables += [acting] if acting.rows else []
        pictures = list(_ellipsoids(made.physical))
        legend = (("c0 dash", "as declared"), ("c1", "identified"))
    words = tuple(printable(note, keep="") for note in made.notes)
    if pictures:
        words += (
            "Ellipsoids are solid ones of even density with the same mass, centre of mass and inertia, in the frame "
            "of the body.",
        )
    return Section("The identified scene", words, tuple(tables), tuple(pictures), legend, small=True)


def _bodies(physical: Physical) -> ReportTable:
    rows = []
    before, after = physical.unknowns.ten(physical.unknowns.values), physical.unknowns.ten(physical.values)
    margins = zip(physical.before, physical.margins, strict=True)
    for name, was, now, (old, new) in zip(physical.unknowns.bodies, before, after, margins, strict=True):
        for label, ten, margin in (("before", was, old), ("after", now, new)):
            mass, centre, moments, _ = ten_of_body(ten)
            rows.append((name, label, figure(mass), *map(figure, centre), *map(figure, moments), figure(margin, 2)))
    heads = ("body", "", "mass, kg", "x, m", "y, m", "z, m", "I1, kg m\u00b2", "I2", "I3", "margin")
    caption = (
        "Masses, centres of mass and principal moments about them; margin: smallest eigenvalue of the pseudo-inertia "
        "by its trace, above zero for what a body can be"
    )
    return ReportTable(caption, heads, (False, False, *(True,) * 8), tuple(rows))


def _acting(physical: Physical) -> ReportTable:
    count = 10 * len(physical.unknowns.bodies)
    known = physical.unknowns
    rows = tuple(
        (name, figure(before), figure(after))
        for name, before, after in zip(known.names[count:], known.values[count:], physical.values[count:], strict=True)
    )
    return ReportTable(
        "Friction, armatures and what else acts", ("parameter", "before", "after"), (False, True, True), rows
    )


def _ellipsoids(physical: Physical) -> Iterator[Picture]:
    before, after = physical.unknowns.ten(physical.unknowns.values), physical.unknowns.ten(physical.values)
    for name, was, now in list(zip(physical.unknowns.bodies, before, after, strict=True))[:MOST_BODIES]:
        for i, j, words in ((0, 1, "xy"), (0, 2, "xz")):
            shown = []
            for kind, ten in (("c0 dash", was), ("c1", now)):
                mass, centre, _, spread = ten_of_body(ten)
                if mass > 0 and np.isfinite(spread).all():
                    shown.append((kind, centre[[i, j]], 5 * spread[np.ix_([i, j], [i, j])]))
            if shown:
                told = f"{name}: inertia ellipsoid before and after, seen along {'zy'[words == 'xz']}"
                yield Picture(charts.ellipses(told, f"{words[0]}, m", f"{words[1]}, m", shown), name)
