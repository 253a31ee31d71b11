"""Motions in a notebook: their plots, and how they ended."""

from __future__ import annotations

from typing import Literal

from symdyn.extras import EXTRAS, install
from symdyn.identification import Excitation
from symdyn.notebook.page import Cell, Markup, folded, head, note, notes, picture, table, verdict
from symdyn.simulation import Trajectory
from symdyn.transcription import Collocation, Solution

MOST = 20_000
"""Points of curves beyond which dots make a smaller picture than lines."""


def trajectory(result: Trajectory) -> list[Markup]:
    """Return the plots of a motion, how it ended, and how well the laws of mechanics were kept."""
    count = len(result.t)
    span = f"t = {result.t[0]:g} to {result.t[-1]:g} s, {count} samples" if count else "no samples"
    method = f", {result.method}" if result.method else ""
    ended = [] if result.complete else [verdict(False, f"ended by: {result.stopped}")]
    monitors = [(words, float(value)) for words, value in result.monitor_rows]
    lines = result.cut_lines
    events = [(event.formula, event.t, "ended the run" if event.stops else "") for event in result.events]
    return [
        head(result.scene.name, span + method),
        *ended,
        _plots(result),
        table(("event", "t, s", ""), events),
        folded("saturation", table(("",), [(line,) for line in lines])) if lines else Markup(""),
        folded("how well the laws of mechanics were kept", table(("", ""), monitors)) if monitors else Markup(""),
        *notes(result.notes),
    ]


def excitation(result: Excitation) -> list[Markup]:
    """Return how well an exciting motion tells base parameters, its plots, and how near it comes to its limits."""
    rows: list[tuple[str, Cell]] = [
        ("condition number", result.condition),
        ("condition number of columns of length 1", result.scaled_condition),
        ("-ln det", result.determinant),
        ("least distance to a limit, of half its room", result.margin),
    ]
    limits = [
        (one.bound.name, one.bound.low, one.low, one.high, one.bound.high, one.bound.unit, "reached" * one.active)
        for one in result.reached
    ]
    starts = [(f"{k + 1}", one.before, one.after, "" if one.keeps else "leaves limits")
              for k, one in enumerate(result.starts)]  # fmt: skip
    return [
        head(result.scene.name, f"exciting motion, {result.family}, {result.terms} terms, {result.period:g} s"),
        table(("", ""), rows),
        _plots(result.run),
        folded("limits", table(("", "lower", "least", "largest", "upper", "unit", ""), limits)),
        folded("starts of the search", table(("", f"{result.criterion} as drawn", "as found", ""), starts)),
        *notes(result.notes),
    ]


def _plots(result: Trajectory) -> Markup:
    if not len(result.t):
        return Markup("")
    if not EXTRAS["plot"].there:
        return note(f"plots need matplotlib: {install('plot')}")
    kind: Literal["svg", "png"] = "svg" if len(result.t) * len(result.names) <= MOST else "png"
    return picture(result.drawn(kind), kind, f"plots of {result.scene.name}", dark=False)


def collocation(result: Collocation) -> list[Markup]:
    """Return what is looked for, and how large a problem it is."""
    rows: list[tuple[str, Cell]] = [
        ("intervals", len(result.grid.widths)), ("method", result.method.text), ("unknowns", result.size),
        ("equations", result.rows), ("forces", ", ".join(result.drives) or "none"),
        ("parameters", ", ".join(result.free) or "none"),
    ]  # fmt: skip
    return [head(result.scene.name, "a motion that is looked for"), table(("", ""), rows), *notes(result.notes)]


def solution(result: Solution) -> list[Markup]:
    """Return the motion that was found, and what the solver says."""
    rows: list[tuple[str, Cell]] = [
        ("objective", result.objective), ("largest miss of a bound or an equation", result.violation),
        ("iterations", result.iterations), ("duration, s", result.duration), *result.parameters.items(),
    ]  # fmt: skip
    return [
        head(result.problem.scene.name, "a motion that a solver found"),
        verdict(result.success, result.status),
        table(("", ""), rows),
        table(("optima", "objective"), [(k, one.objective) for k, one in enumerate(result.optima, 1)])
        if result.others
        else Markup(""),
        *notes(result.notes),
        _plots(result.motion),
    ]
