"""What comes of many runs in a notebook: quantiles and plots of a study, Sobol's indices, error bars."""

from __future__ import annotations

from typing import Literal

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.extras import EXTRAS, install
from symdyn.notebook.page import Cell, Markup, head, note, notes, picture, table, verdict
from symdyn.simulation import Uncertainty
from symdyn.study import Indices, Study

MOST = 10_000
"""Numbers beyond which dots make a smaller picture than lines."""

SHARES = (0.05, 0.5, 0.95)
"""Quantiles that are shown."""

ROWS = 12
"""Columns of a run whose error bars at the end are shown."""


def study(found: Study) -> list[Markup]:
    """Return how many runs there are, quantiles of their measures, and a plot."""
    body: list[list[Cell]] = [
        [name, found.units.get(name, ""), *(float(x) for x in found.quantiles(name, SHARES))] for name in found.measures
    ]
    failed = [verdict(False, f"{found.failed} of {len(found)} runs failed")] if found.failed else []
    left = [verdict(False, f"{found.left} of {len(found)} runs are not made")] if found.left else []
    names = ", ".join(found.names)
    return [
        head(found.scene, f"{len(found)} runs over {names}, design {found.about.get('design', '')}"),
        *failed,
        *left,
        table(("measure", "unit", *(f"{100 * share:g} %" for share in SHARES)), body),
        _picture(found),
        *notes(found.notes),
    ]


def _picture(found: Study) -> Markup:
    if not any(np.isfinite(column).any() for column in found.measures.values()):
        return note("no run has a value")
    if not EXTRAS["plot"].there:
        return note(f"plots need matplotlib: {install('plot')}")
    kind: Literal["svg", "png"] = "svg" if len(found) <= MOST else "png"
    try:
        drawn = found.drawn(kind)
    except SimulateError as fault:  # too few groups for indices
        return note(str(fault))
    return picture(drawn, kind, f"plots of {found.scene}", dark=False)


def indices(found: Indices) -> list[Markup]:
    """Return Sobol's indices with their intervals."""
    each = zip(found.names, found.first, found.first_interval, found.total, found.total_interval, strict=True)
    body: list[list[Cell]] = [
        [name, float(first), _between(near), float(total), _between(far)] for name, first, near, total, far in each
    ]
    level = f"{100 * found.level:g} % interval"
    return [
        head(found.measure, f"parts of its variance, from {found.groups} groups of runs"),
        table(("name", "first order", level, "total order", level), body),
        *notes(found.notes),
    ]


def _between(interval: Array) -> str:
    return f"{interval[0]:.3g} … {interval[1]:.3g}"


def uncertainty(found: Uncertainty) -> list[Markup]:
    """Return error bars at the end of a run, what they are due to, and a plot."""
    body: list[list[Cell]] = []
    for one in found.columns[:ROWS]:
        shares = zip(found.varied, found.shares(one.name)[-1], strict=True)
        due = ", ".join(f"{name} {100 * part:.3g} %" for name, part in shares)
        body.append([one.name, one.unit, float(found.run[one.name][-1]), float(found[one.name][-1]), due])
    if EXTRAS["plot"].there:
        kind: Literal["svg", "png"] = "svg" if len(found.t) * len(found.names) <= MOST else "png"
        drawn = picture(found.drawn(kind), kind, f"error bars of {found.run.scene.name}", dark=False)
    else:
        drawn = note(f"plots need matplotlib: {install('plot')}")
    return [
        head(found.run.scene.name, f"error bars to first order, by {', '.join(found.varied)}"),
        table(("column", "unit", f"at t = {found.t[-1]:g} s", "standard deviation", "variance is due to"), body),
        drawn,
        *notes(found.notes),
    ]
