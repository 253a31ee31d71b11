"""Motions in a notebook: their plots, and how they ended."""

from __future__ import annotations

from typing import Literal

import numpy as np

from symdyn.extras import EXTRAS, install
from symdyn.identification import Excitation
from symdyn.notebook.page import Cell, Markup, folded, head, note, notes, picture, table, verdict
from symdyn.simulation import Ensemble, Trajectory
from symdyn.transcription import Collocation, Solution

MOST = 20_000
"""Points of curves beyond which dots make a smaller picture than lines."""


def trajectory(found: Trajectory) -> list[Markup]:
    """Return the plots of a motion, how it ended, and how well the laws of mechanics were kept."""
    count = len(found.t)
    span = f"t = {found.t[0]:g} to {found.t[-1]:g} s, {count} samples" if count else "no samples"
    method = f", {found.method}" if found.method else ""
    ended = [] if found.complete else [verdict(False, f"ended by: {found.stopped}")]
    monitors = [(words, float(value)) for words, value in found.monitor_rows]
    lines = found.cut_lines
    events = [(event.formula, event.t, "ended the run" if event.stops else "") for event in found.events]
    return [
        head(found.scene.name, span + method),
        *ended,
        _plots(found),
        table(("event", "t, s", ""), events),
        folded("saturation", table(("",), [(line,) for line in lines])) if lines else Markup(""),
        folded("how well the laws of mechanics were kept", table(("", ""), monitors)) if monitors else Markup(""),
        *notes(found.notes),
    ]


def excitation(found: Excitation) -> list[Markup]:
    """Return how well an exciting motion tells base parameters, its plots, and how near it comes to its limits."""
    rows: list[tuple[str, Cell]] = [
        ("condition number", found.condition),
        ("condition number of columns of length 1", found.scaled_condition),
        ("-ln det", found.determinant),
        ("least distance to a limit, of half its room", found.margin),
    ]
    limits = [
        (one.bound.name, one.bound.low, one.low, one.high, one.bound.high, one.bound.unit, "reached" * one.active)
        for one in found.reached
    ]
    starts = [(f"{k + 1}", one.before, one.after, "" if one.keeps else "leaves limits")
              for k, one in enumerate(found.starts)]  # fmt: skip
    return [
        head(found.scene.name, f"exciting motion, {found.family}, {found.terms} terms, {found.period:g} s"),
        table(("", ""), rows),
        _plots(found.run),
        folded("limits", table(("", "lower", "least", "largest", "upper", "unit", ""), limits)),
        folded("starts of the search", table(("", f"{found.criterion} as drawn", "as found", ""), starts)),
        *notes(found.notes),
    ]


def _plots(found: Trajectory) -> Markup:
    if not len(found.t):
        return Markup("")
    if not EXTRAS["plot"].there:
        return note(f"plots need matplotlib: {install('plot')}")
    kind: Literal["svg", "png"] = "svg" if len(found.t) * len(found.names) <= MOST else "png"
    return picture(found.drawn(kind), kind, f"plots of {found.scene.name}", dark=False)


def collocation(found: Collocation) -> list[Markup]:
    """Return what is looked for, and how large a problem it is."""
    rows: list[tuple[str, Cell]] = [
        ("intervals", len(found.grid.widths)), ("method", found.method.text), ("unknowns", found.size),
        ("equations", found.rows), ("forces", ", ".join(found.drives) or "none"),
        ("parameters", ", ".join(found.free) or "none"),
    ]  # fmt: skip
    return [head(found.scene.name, "a motion that is looked for"), table(("", ""), rows), *notes(found.notes)]


def solution(found: Solution) -> list[Markup]:
    """Return the motion that was found, and what the solver says."""
    rows: list[tuple[str, Cell]] = [
        ("objective", found.objective), ("largest miss of a bound or an equation", found.violation),
        ("iterations", found.iterations), ("duration, s", found.duration), *found.parameters.items(),
    ]  # fmt: skip
    return [
        head(found.problem.scene.name, "a motion that a solver found"),
        verdict(found.success, found.status),
        table(("", ""), rows),
        table(("optima", "objective"), [(k, one.objective) for k, one in enumerate(found.optima, 1)])
        if found.others
        else Markup(""),
        *notes(found.notes),
        _plots(found.motion),
    ]


def ensemble(found: Ensemble) -> list[Markup]:
    """Return how many runs there are, how they ended, and the spread of what was measured of them."""
    count = len(found)
    ended = [(word, int((found.stopped == k).sum())) for k, word in enumerate(found.words)]
    rows: list[tuple[str, Cell, Cell, Cell]] = []
    for name in (*found.varied, *found.measures):
        x = found[name][np.isfinite(found[name])]
        if len(x):
            rows.append((name, float(x.min()), float(np.median(x)), float(x.max())))
    return [
        head(found.scene.name, f"{count} runs, {found.method}"),
        table(("", "least", "median", "largest"), rows),
        table(("ended by", "runs"), [one for one in ended if one[1]]),
        *notes(found.notes),
    ]
