"""Reports of what was measured: one HTML page with its pictures inside, Markdown, and JSON."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

from symdyn.bench.model import Bench, Curve, Measured, Point
from symdyn.bench.plots import Dot, Series, log_log
from symdyn.bench.stress.model import Stress
from symdyn.emit.render import render
from symdyn.verify.certificate import finite

COLUMNS = ("implementation", "operations", "generate s", "compile s", "ns a state", "error 99 %", "best")
DEEPER = ("implementation", "states", "ulp: median, 99 %, max", "of own bound: median, 99 %, max", "backward: max")


def as_json(facts: Mapping[str, Any]) -> str:
    """Return facts as JSON; what is infinite or no number is null."""
    return json.dumps(finite(facts), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def pictures(bench: Bench) -> dict[str, str]:
    """Return a plot of time against error for every function, and work against precision, by name."""
    made = {function: time_against_error(bench, function) for function in bench.functions}
    if bench.curves:
        made["trajectory"] = work_against_precision(bench.curves)
        made["energy"] = work_against_drift(bench.curves)
    return {name: text for name, text in made.items() if text}


def time_against_error(bench: Bench, function: str) -> str:
    """Return the plot of one function: a colour a way, hollow points are float, rings are Pareto-best."""
    groups: dict[str, list[Dot]] = {}
    for one in bench.measured:
        if one.function == function:
            text = f"{one.label}: {one.call:.3g} ns, {one.relative:.1e}"
            groups.setdefault(one.way, []).append(Dot(one.call, one.relative, text, one.best, one.real == "float"))
    series = [Series(way, tuple(dots)) for way, dots in groups.items()]
    return log_log(f"{bench.scene}: {function}", "ns a state", "relative error, 99th percentile", series)


def work_against_precision(curves: Sequence[Curve]) -> str:
    """Return the plot of the error of a trajectory's end against the time that it took."""
    return log_log("work and precision", "seconds", "error at the end", _lines(curves, lambda point: point.error))


def work_against_drift(curves: Sequence[Curve]) -> str:
    """Return the plot of the drift of the energy against the time that it took."""
    return log_log("drift of the energy", "seconds", "largest drift", _lines(curves, lambda point: point.drift))


def _lines(curves: Sequence[Curve], of: Callable[[Point], float]) -> list[Series]:
    return [
        Series(
            curve.method,
            tuple(Dot(p.seconds, of(p), f"{curve.method}, rtol {p.tolerance:.0e}: {of(p):.1e}") for p in curve.points),
            joined=True,
        )
        for curve in curves
    ]


def rows(bench: Bench, function: str) -> list[tuple[str, ...]]:
    """Return the table of one function, cell by cell as text."""
    return [
        (
            one.label,
            str(sum(one.operations.values())),
            f"{one.generate:.2f}",
            "" if one.compile is None else f"{one.compile:.2f}",
            f"{one.call:.3g}",
            f"{one.relative:.1e}",
            "yes" if one.best else "",
        )
        for one in bench.measured
        if one.function == function
    ]


def regions(bench: Bench, function: str, region: str) -> list[tuple[str, ...]]:
    """Return the distribution of errors of one function in one region."""
    found = []
    for one in bench.measured:
        for errors in one.errors:
            if (one.function, errors.region) == (function, region):
                spreads = [" ".join(f"{x:.2g}" for x in spread) for spread in (errors.ulp, errors.condition)]
                backward = "" if errors.backward is None else f"{errors.backward[2]:.2g}"
                found.append((one.label, str(errors.states), *spreads, backward))
    return found


def best(bench: Bench, function: str) -> list[Measured]:
    """Return the Pareto-best implementations of a function, the fastest first."""
    return sorted((one for one in bench.measured if one.function == function and one.best), key=lambda one: one.call)


def markdown(bench: Bench, links: Mapping[str, str] | None = None) -> str:
    """Return the report as Markdown.

    Args:
        bench: what was measured.
        links: path of the picture of each name of `pictures`, for those that lie in files.
    """
    lines = [f"# {bench.scene}: run time against error", ""]
    lines += [f"    {bench.command}", ""] if bench.command else []
    lines += [f"{', '.join(f'{name} {value}' for name, value in bench.about)}.", ""]
    lines += [
        "Errors are relative to the largest entry of a result: the 99th percentile in the worst of these regions.",
        "",
    ]
    lines += [f"- *{name}*: {text}" for name, text in bench.regions.items()]
    lines += ["", "Best are those that no other implementation beats in both time and error.", ""]
    for function in bench.functions:
        lines += [f"## {function}", ""]
        lines += [f"![time against error of {function}]({links[function]})", ""] if links and function in links else []
        lines += table(COLUMNS, rows(bench, function), numbers=range(1, 6))
    if bench.curves:
        lines += ["## Trajectories", ""]
        lines += [f"![{name}]({links[name]})" for name in ("trajectory", "energy") if links and name in links]
        lines += [""] if links else []
        lines += table(CURVE, curve_rows(bench.curves), numbers=range(1, 6))
    lines += [f"Note: {note}\n" for note in bench.notes]
    return "\n".join(lines).rstrip("\n") + "\n"


CURVE = ("method", "rtol", "seconds", "evaluations", "error at the end", "drift of the energy")


def curve_rows(curves: Sequence[Curve]) -> list[tuple[str, ...]]:
    """Return the table of trajectories."""
    return [
        (c.method, f"{p.tolerance:.0e}", f"{p.seconds:.3g}", str(p.evaluations), f"{p.error:.1e}", f"{p.drift:.1e}")
        for c in curves
        for p in c.points
    ]


def table(columns: Sequence[str], cells: Sequence[Sequence[str]], numbers: Sequence[int] = ()) -> list[str]:
    """Return a Markdown table, columns of `numbers` aligned to the right, and an empty line."""
    rule = ["--:" if k in numbers else "---" for k in range(len(columns))]
    lines = [f"| {' | '.join(columns)} |", f"|{'|'.join(rule)}|"]
    return [*lines, *(f"| {' | '.join(row)} |" for row in cells), ""]


def html(bench: Bench) -> str:
    """Return the report as one HTML page that needs nothing else."""
    drawn = pictures(bench)
    sections = []
    for function in bench.functions:
        tables = [_cells("", COLUMNS, rows(bench, function))]
        for name, text in bench.regions.items():
            tables.append(_cells(f"{name}: {text}", DEEPER, regions(bench, function, name)))
        choices = [f"{one.label}: {one.call:.3g} ns, error {one.relative:.1e}" for one in best(bench, function)]
        shown = [drawn[function]] if function in drawn else []
        sections.append({"title": function, "pictures": shown, "choices": choices, "tables": tables})
    if bench.curves:
        shown = [drawn[name] for name in ("trajectory", "energy") if name in drawn]
        tables = [_cells("", CURVE, curve_rows(bench.curves))]
        sections.append({"title": "trajectories", "pictures": shown, "choices": [], "tables": tables})
    about = [f"{name}: {value}" for name, value in bench.about]
    return page(f"{bench.scene}: run time against error", bench.command, about, sections, bench.notes)


def page(
    title: str, command: str, about: Sequence[str], sections: Sequence[Mapping[str, Any]], notes: Sequence[str]
) -> str:
    """Return an HTML page; everything but pictures is escaped here."""
    safe = [
        {
            **section,
            "title": escape(section["title"]),
            "choices": [escape(choice) for choice in section["choices"]],
        }
        for section in sections
    ]
    values = {
        "title": escape(title),
        "command": escape(command),
        "about": [escape(line) for line in about],
        "sections": safe,
        "notes": [escape(note) for note in notes],
    }
    return render("bench/report.html.jinja", values)


def _cells(caption: str, columns: Sequence[str], cells: Sequence[Sequence[str]]) -> dict[str, Any]:
    return {
        "caption": escape(caption),
        "columns": [escape(column) for column in columns],
        "rows": [[escape(cell) for cell in row] for row in cells],
    }


HARD = ("family", "case", "metric", "bound", "measured", "passed", "worst")


def stress_rows(found: Stress) -> list[tuple[str, ...]]:
    """Return the table of hard cases, cell by cell as text."""
    return [
        (c.family, c.name, c.metric, f"{c.bound:.2g}", f"{c.measured:.2g}", "pass" if c.passed else "FAIL", c.worst)
        for c in found.cases
    ]


def stress_markdown(found: Stress) -> str:
    """Return the hard cases as Markdown."""
    lines = [f"# {found.scene or 'Built-in scenes'}: hard cases", "", f"    {found.command}", ""]
    cells = [[cell.replace("|", "\\|") for cell in row] for row in stress_rows(found)]
    lines += table(HARD, cells, numbers=(3, 4))
    lines += [f"Note: {note}\n" for note in found.notes]
    return "\n".join(lines).rstrip("\n") + "\n"


def stress_html(found: Stress) -> str:
    """Return the hard cases as one HTML page."""
    rows = [(*row[:5], row[6], row[5]) for row in stress_rows(found)]
    table = _cells("", (*HARD[:5], HARD[6], HARD[5]), rows)
    section = {"title": "cases", "pictures": [], "choices": [], "tables": [table]}
    about = [f"{len(found.cases)} cases, {sum(not c.passed for c in found.cases)} failed"]
    return page(f"{found.scene or 'built-in scenes'}: hard cases", found.command, about, [section], found.notes)
