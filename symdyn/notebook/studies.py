"""What comes of many runs in a notebook: quantiles and plots of them, Sobol's indices, error bars."""

from __future__ import annotations

from collections import Counter
from typing import Literal

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.extras import EXTRAS, install
from symdyn.notebook.page import Cell, Markup, head, note, notes, picture, table, verdict
from symdyn.simulation import Uncertainty
from symdyn.study import Indices, Runs

MOST = 10_000
"""Numbers beyond which dots make a smaller picture than lines."""

SHARES = (0.05, 0.5, 0.95)
"""Quantiles that are shown."""

ROWS = 12
"""Columns of a run whose error bars at the end are shown."""


def runs(result: Runs) -> list[Markup]:
    """Return how many runs there are, how they ended, quantiles of their measures, and a plot."""
    body: list[list[Cell]] = [
        [name, result.units.get(name, ""), *(float(x) for x in result.quantiles(name, SHARES))]
        for name in result.measures or result.outcomes
    ]
    failed = [verdict(False, f"{result.failed} of {len(result)} runs failed")] if result.failed else []
    left = [verdict(False, f"{result.left} of {len(result)} runs are not made")] if result.left else []
    names = ", ".join(result.names)
    whole = len(result.told) == result.failed + result.stopped  # of a sweep the first few are told
    ended = list(Counter(result.told.values()).items()) if whole else []
    return [
        head(result.scene, f"{len(result)} runs over {names}, design {result.about.get('design', '')}"),
        *failed,
        *left,
        table(("measure", "unit", *(f"{100 * share:g} %" for share in SHARES)), body),
        *([table(("ended by", "runs"), ended)] if ended else []),
        _picture(result),
        *notes(result.notes),
    ]


def _picture(result: Runs) -> Markup:
    if not any(result.known(name).size for name in result.measures or result.outcomes):
        return note("no run has a value")
    if not EXTRAS["plot"].there:
        return note(f"plots need matplotlib: {install('plot')}")
    kind: Literal["svg", "png"] = "svg" if len(result) <= MOST else "png"
    try:
        drawn = result.drawn(kind)
    except SimulateError as fault:  # too few groups for indices
        return note(str(fault))
    return picture(drawn, kind, f"plots of {result.scene}", dark=False)


def indices(result: Indices) -> list[Markup]:
    """Return Sobol's indices with their intervals."""
    each = zip(result.names, result.first, result.first_interval, result.total, result.total_interval, strict=True)
    body: list[list[Cell]] = [
        [name, float(first), _between(near), float(total), _between(far)] for name, first, near, total, far in each
    ]
    level = f"{100 * result.level:g} % interval"
    return [
        head(result.measure, f"parts of its variance, from {result.groups} groups of runs"),
        table(("name", "first order", level, "total order", level), body),
        *notes(result.notes),
    ]


def _between(interval: Array) -> str:
    return f"{interval[0]:.3g} … {interval[1]:.3g}"


def uncertainty(result: Uncertainty) -> list[Markup]:
    """Return error bars at the end of a run, what they are due to, and a plot."""
    body: list[list[Cell]] = []
    for one in result.columns[:ROWS]:
        shares = zip(result.varied, result.shares(one.name)[-1], strict=True)
        due = ", ".join(f"{name} {100 * part:.3g} %" for name, part in shares)
        body.append([one.name, one.unit, float(result.run[one.name][-1]), float(result[one.name][-1]), due])
    if EXTRAS["plot"].there:
        kind: Literal["svg", "png"] = "svg" if len(result.t) * len(result.names) <= MOST else "png"
        drawn = picture(result.drawn(kind), kind, f"error bars of {result.run.scene.name}", dark=False)
    else:
        drawn = note(f"plots need matplotlib: {install('plot')}")
    return [
        head(result.run.scene.name, f"error bars to first order, by {', '.join(result.varied)}"),
        table(("column", "unit", f"at t = {result.t[-1]:g} s", "standard deviation", "variance is due to"), body),
        drawn,
        *notes(result.notes),
    ]
