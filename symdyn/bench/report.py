"""Reports of what was measured: one HTML page with its pictures inside, Markdown, and JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from symdyn.bench.case import Stress
from symdyn.bench.measurements import Bench, Curve, Measured, MotionPrecision, Point
from symdyn.bench.plots import Dot, Series, log_log
from symdyn.emit.escape import in_html, in_markdown
from symdyn.emit.render import render
from symdyn.verify.certificate import finite

COLUMNS = ("implementation", "operations", "generate s", "compile s", "ns a state", "error 99 %", "best")
DEEPER = ("implementation", "states", "ulp", "of own bound", "backward")
ERRORS = (
    "Errors are the 99th percentile over sampled states of the largest error of an entry, relative to the largest "
    "entry, against the same graph at 50 digits, in the worst region. Rings mark what no other implementation beats in "
    "both time and error; hollow points are float."
)
SPREADS = (
    "For every region: median, 99 % and maximum over the states of the error in ulps of the largest entry; of an "
    "entry's error over its own running error bound, which knows the condition of the output (below 1 the code is as "
    "good as rounding every operation once allows); and of the backward error of accelerations, in roundoffs."
)


def as_json(facts: Mapping[str, Any]) -> str:
    """Return facts as JSON; what is infinite or no number is null."""
    return json.dumps(finite(facts), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def pictures(bench: Bench) -> dict[str, str]:
    """Return a plot of time against error for every function, and work against precision, by name."""
    made = {function: time_against_error(bench, function) for function in bench.functions}
    if bench.motion is not None:
        made["trajectory"] = work_against_precision(bench.motion)
        made["energy"] = work_against_drift(bench.motion)
    return {name: text for name, text in made.items() if text}


def time_against_error(bench: Bench, function: str) -> str:
    """Return the plot of one function: a colour a way, hollow points are float, rings are Pareto-best."""
    groups: dict[str, list[Dot]] = {}
    for one in bench.measured:
        if one.function == function:
            text = f"{one.label}: {nanoseconds(one.call)} ns, {one.relative:.1e}"
            groups.setdefault(one.way, []).append(Dot(one.call, one.relative, text, one.best, one.real == "float"))
    series = [Series(way, tuple(dots)) for way, dots in groups.items()]
    return log_log(f"{bench.scene}: {function}", "ns a state", "relative error, 99 %", series)


def work_against_precision(motion: MotionPrecision) -> str:
    """Return the plot of the error of a trajectory's end against the time that it took."""
    title = f"{motion.until:g} s of motion: work and precision"
    return log_log(title, "seconds", "error at the end", _lines(motion.precision, motion))


def work_against_drift(motion: MotionPrecision) -> str:
    """Return the plot of the drift of the energy against the time that it took."""
    title = f"{motion.later:g} s of motion: drift of the energy"
    return log_log(title, "seconds", "largest drift over the energy", _lines(motion.drift, motion))


def _lines(curves: Sequence[Curve], motion: MotionPrecision) -> list[Series]:
    """Return lines whose colours are the same in both pictures."""
    methods = [curve.method for curve in motion.precision]
    return [
        Series(
            curve.method,
            tuple(
                Dot(
                    p.seconds,
                    p.error,
                    f"{curve.method}, rtol {p.tolerance:.0e}: {p.seconds:.2g} s, {p.error:.1e}",
                    p.best,
                )
                for p in curve.points
            ),
            joined=True,
            colour=methods.index(curve.method),
        )
        for curve in curves
    ]


def nanoseconds(time: float) -> str:
    """Return a time with three digits, without an exponent."""
    return f"{time:.3g}" if time < 1000 else f"{time:.0f}"


def rows(bench: Bench, function: str) -> list[tuple[str, ...]]:
    """Return the table of one function, cell by cell as text."""
    return [
        (
            one.label,
            str(sum(one.operations.values())),
            f"{one.generate:.2f}",
            "" if one.compile is None else f"{one.compile:.2f}",
            nanoseconds(one.call),
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
                spreads = (errors.ulp, errors.condition, errors.backward or ())
                found.append((one.label, str(errors.states), *(", ".join(f"{x:.2g}" for x in s) for s in spreads)))
    return found


def best(bench: Bench, function: str) -> list[Measured]:
    """Return the Pareto-best implementations of a function, the fastest first."""
    return sorted((one for one in bench.measured if one.function == function and one.best), key=lambda one: one.call)


def choices_of(curves: Sequence[Curve]) -> list[tuple[Curve, Point]]:
    """Return the Pareto-best points of all curves, the fastest first."""
    return sorted(((c, p) for c in curves for p in c.points if p.best), key=lambda pair: pair[1].seconds)


def markdown(bench: Bench, links: Mapping[str, str] | None = None) -> str:
    """Return the report as Markdown.

    Args:
        bench: what was measured.
        links: path of the picture of each name of `pictures`, for those that lie in files.
    """
    lines = [f"# {bench.scene}: run time against error", ""]
    lines += [f"    {bench.command}", ""] if bench.command else []
    lines += [f"{', '.join(f'{name} {value}' for name, value in bench.about)}.", ""]
    lines += [ERRORS, "", SPREADS, ""]
    lines += [f"- *{name}*: {text}" for name, text in bench.regions.items()]
    lines += [""]
    for function in bench.functions:
        lines += [f"## {function}", ""]
        lines += [f"![time against error of {function}]({links[function]})", ""] if links and function in links else []
        lines += table(COLUMNS, rows(bench, function), numbers=range(1, 6))
        for region in bench.regions:
            lines += [f"In the region *{region}*:", "", *table(DEEPER, regions(bench, function, region), range(1, 5))]
    if bench.motion is not None:
        lines += ["## trajectories", "", *(f"{line}\n" for line in told(bench.motion))]
        for name, heads, curves in _motions(bench.motion):
            lines += [f"![{name}]({links[name]})", ""] if links and name in links else []
            lines += table(heads, curve_rows(curves), numbers=range(1, 5))
    lines += _notes(bench.notes)
    return "\n".join(lines).rstrip("\n") + "\n"


PRECISION = ("method", "rtol", "seconds", "evaluations", "error at the end", "best")
DRIFT = (*PRECISION[:4], "drift of the energy", "best")


def told(motion: MotionPrecision) -> list[str]:
    """Return what a reader of the trajectories has to know."""
    doubt = f"which may be off by {motion.uncertain:.0e}; no smaller error is told" if motion.uncertain else "exact"
    return [
        f"{motion.until:g} s without drives; errors of the end over the largest entry of the state, at least 1. "
        f"The truth is {motion.reference}, {doubt}.",
        f"{motion.later:g} s without drives; the largest drift of the energy over its largest size, what takes it or "
        "gives it counted.",
        *motion.notes,
    ]


def _motions(motion: MotionPrecision) -> list[tuple[str, tuple[str, ...], tuple[Curve, ...]]]:
    """Return name of the picture, columns and curves of both measures."""
    return [("trajectory", PRECISION, motion.precision), ("energy", DRIFT, motion.drift)]


def curve_rows(curves: Sequence[Curve]) -> list[tuple[str, ...]]:
    """Return the table of trajectories."""
    return [
        (
            c.method,
            f"{p.tolerance:.0e}",
            f"{p.seconds:.3g}",
            str(p.evaluations),
            f"{p.error:.1e}",
            "yes" if p.best else "",
        )
        for c in curves
        for p in c.points
    ]


def _notes(notes: Sequence[str]) -> list[str]:
    """Return notes as Markdown; they may quote a compiler, which quotes what a scene says."""
    return [f"Note: {in_markdown(' '.join(note.split()))}\n" for note in notes]


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
        choices = [
            f"{one.label}: {nanoseconds(one.call)} ns, error {one.relative:.1e}" for one in best(bench, function)
        ]
        shown = [drawn[function]] if function in drawn else []
        sections.append({"title": function, "words": [], "pictures": shown, "choices": choices, "tables": tables})
    if bench.motion is not None:
        shown = [drawn[name] for name, *_ in _motions(bench.motion) if name in drawn]
        tables = [_cells("", heads, curve_rows(curves)) for _, heads, curves in _motions(bench.motion)]
        choices = [
            f"{c.method}, rtol {p.tolerance:.0e}: {p.seconds:.2g} s, error {p.error:.1e}"
            for c, p in choices_of(bench.motion.precision)
        ]
        words = told(bench.motion)
        sections.append(
            {"title": "trajectories", "words": words, "pictures": shown, "choices": choices, "tables": tables}
        )
    about = [f"{name}: {value}" for name, value in bench.about]
    title = f"{bench.scene}: run time against error"
    return page(title, bench.command, about, sections, bench.notes, [ERRORS, SPREADS])


def page(
    title: str,
    command: str,
    about: Sequence[str],
    sections: Sequence[Mapping[str, Any]],
    notes: Sequence[str],
    words: Sequence[str] = (),
) -> str:
    """Return an HTML page; everything but pictures is escaped here."""
    safe = [
        {
            **section,
            "title": in_html(section["title"]),
            "words": [in_html(line) for line in section["words"]],
            "choices": [in_html(choice) for choice in section["choices"]],
        }
        for section in sections
    ]
    values = {
        "title": in_html(title),
        "command": in_html(command),
        "about": [in_html(line) for line in about],
        "words": [in_html(line) for line in words],
        "sections": safe,
        "notes": [in_html(note) for note in notes],
    }
    return render("bench/report.html.jinja", values)


def _cells(caption: str, columns: Sequence[str], cells: Sequence[Sequence[str]]) -> dict[str, Any]:
    return {
        "words": False,
        "caption": in_html(caption),
        "columns": [in_html(column) for column in columns],
        "rows": [[in_html(cell) for cell in row] for row in cells],
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
    lines += _notes(found.notes)
    return "\n".join(lines).rstrip("\n") + "\n"


def stress_html(found: Stress) -> str:
    """Return the hard cases as one HTML page."""
    rows = [(*row[:5], row[6], row[5]) for row in stress_rows(found)]
    table = {**_cells("", (*HARD[:5], HARD[6], HARD[5]), rows), "words": True}
    section = {"title": "cases", "words": [], "pictures": [], "choices": [], "tables": [table]}
    about = [f"{len(found.cases)} cases, {sum(not c.passed for c in found.cases)} failed"]
    return page(f"{found.scene or 'built-in scenes'}: hard cases", found.command, about, [section], found.notes)
