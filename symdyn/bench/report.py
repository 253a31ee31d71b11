"""Reports of what was measured: one HTML page with its pictures inside, Markdown, and JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isnan
from typing import TYPE_CHECKING, Any

from symdyn.bench.plots import Dot, Series, log_log
from symdyn.emit import in_html, in_markdown, render
from symdyn.rounding import finite, in_digits
from symdyn.table import Table
from symdyn.verdict import Verdict

if TYPE_CHECKING:
    from symdyn.bench.case import Stress
    from symdyn.bench.measurements import Bench, Curve, MotionPrecision

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


@dataclass(frozen=True)
class Section:
    """A part of a report: a table, and one of each region, which its title names; `choices` are told on pages."""

    title: str
    tables: Sequence[Table[str]]
    regions: Mapping[str, Table[str]] = field(default_factory=dict)
    pictures: Sequence[str] = ()
    words: Sequence[str] = ()
    choices: Sequence[str] = ()


def pictures(bench: Bench) -> dict[str, str]:
    """Return a plot of time against error for every function, and of work against precision and drift, by name."""
    made = {function: _time_against_error(bench, function) for function in bench.functions}
    if (motion := bench.motion) is not None:
        title = f"{motion.until:g} s of motion: work and precision"
        made["trajectory"] = log_log(title, "seconds", "error at the end", _lines(motion.precision, motion))
        title = f"{motion.later:g} s of motion: drift of the energy"
        made["energy"] = log_log(title, "seconds", "largest drift over the energy", _lines(motion.drift, motion))
    return {name: text for name, text in made.items() if text}


def _time_against_error(bench: Bench, function: str) -> str:
    """Return the plot of one function: a colour a way, hollow points are float, rings are Pareto-best."""
    groups: dict[str, list[Dot]] = {}
    for one in bench.measured:
        if one.function == function:
            text = f"{one.label}: {one.nanoseconds} ns, {one.relative:.1e}"
            groups.setdefault(one.way, []).append(Dot(one.call, one.relative, text, one.best, one.real == "float"))
    series = [Series(way, tuple(dots)) for way, dots in groups.items()]
    return log_log(f"{bench.scene}: {function}", "ns a state", "relative error, 99 %", series)


def _lines(curves: Sequence[Curve], motion: MotionPrecision) -> list[Series]:
    """Return lines whose colours are the same in both pictures."""
    methods = [curve.method for curve in motion.precision]
    found = []
    for curve in curves:
        label = f"{curve.method}, rtol"
        dots = (
            Dot(p.seconds, p.error, f"{label} {p.tolerance:.0e}: {p.seconds:.2g} s, {p.error:.1e}", p.best)
            for p in curve.points
        )
        found.append(Series(curve.method, tuple(dots), joined=True, colour=methods.index(curve.method)))
    return found


def measured_table(bench: Bench, function: str) -> Table[str]:
    """Return what was measured of one function, a row an implementation."""
    rows = [
        (
            one.label,
            str(sum(one.operations.values())),
            f"{one.generate:.2f}",
            "" if one.compile is None else f"{one.compile:.2f}",
            one.nanoseconds,
            Verdict.NOT_SHOWN if isnan(one.relative) else in_digits(one.relative, 2, "e"),
            "yes" if one.best else "",
        )
        for one in bench.measured
        if one.function == function
    ]
    return Table(COLUMNS, rows, range(1, 6))


def _region_table(bench: Bench, function: str, region: str) -> Table[str]:
    """Return the distribution of errors of one function in one region."""
    found = []
    for one in bench.measured:
        for errors in one.errors:
            if (one.function, errors.region) == (function, region):
                spreads = (errors.ulp, errors.condition, errors.backward or ())
                found.append((one.label, str(errors.states), *(", ".join(in_digits(x, 2) for x in s) for s in spreads)))
    return Table(DEEPER, found, range(1, 5))


def _sections(bench: Bench) -> Iterator[Section]:
    """Yield a section a function, and one about trajectories."""
    drawn = pictures(bench)
    for function in bench.functions:
        regions = {name: _region_table(bench, function, name) for name in bench.regions}
        choices = [f"{o.label}: {o.nanoseconds} ns, error {o.relative:.1e}" for o in bench.best(function)]
        shown = [drawn[name] for name in (function,) if name in drawn]
        yield Section(function, [measured_table(bench, function)], regions, shown, (), choices)
    if (motion := bench.motion) is not None:
        tables = curve_tables(motion)
        choices = [
            f"{c.method}, rtol {p.tolerance:.0e}: {p.seconds:.2g} s, error {p.error:.1e}" for c, p in motion.choices
        ]
        shown = [drawn[name] for name in ("trajectory", "energy") if name in drawn]
        yield Section("trajectories", tables, {}, shown, remarks(motion), choices)


def markdown(bench: Bench) -> str:
    """Return the report as Markdown."""
    about = ", ".join(f"{name} {value}" for name, value in bench.about)
    head = [
        f"{about}.",
        "",
        ERRORS,
        "",
        SPREADS,
        "",
        *(f"- *{name}*: {text}" for name, text in bench.regions.items()),
        "",
    ]
    return _markdown(f"{bench.scene}: run time against error", bench.command, head, _sections(bench), bench.notes)


def _markdown(title: str, command: str, head: list[str], sections: Iterable[Section], notes: Sequence[str]) -> str:
    """Return a report as Markdown; notes may quote a compiler, which quotes what a scene says."""
    lines = [f"# {title}", "", *([f"    {command}", ""] if command else []), *head]
    for section in sections:
        lines += [f"## {section.title}", "", *(f"{line}\n" for line in section.words)]
        for table in section.tables:
            lines += [table.markdown(), ""]
        for name, table in section.regions.items():
            lines += [f"In the region *{name}*:", "", table.markdown(), ""]
    lines += [f"Note: {in_markdown(' '.join(note.split()))}\n" for note in notes]
    return "\n".join(lines).rstrip("\n") + "\n"


def remarks(motion: MotionPrecision) -> list[str]:
    """Return what a reader of the trajectories has to know."""
    doubt = f"which may be off by {motion.uncertain:.0e}; no smaller error is told" if motion.uncertain else "exact"
    return [
        f"{motion.until:g} s without drives; errors of the end over the largest entry of the state, at least 1. "
        f"The truth is {motion.reference}, {doubt}.",
        f"{motion.later:g} s without drives; the largest drift of the energy over its largest size, what takes it or "
        "gives it counted.",
        *motion.notes,
    ]


def curve_tables(motion: MotionPrecision) -> tuple[Table[str], Table[str]]:
    """Return how exactly each method ends at each tolerance, and how well it keeps the energy."""
    return _curves(motion.precision, "error at the end"), _curves(motion.drift, "drift of the energy")


def _curves(curves: Sequence[Curve], error: str) -> Table[str]:
    rows = [
        (
            c.method,
            f"{p.tolerance:.0e}",
            in_digits(p.seconds, 3),
            str(p.evaluations),
            in_digits(p.error, 2, "e"),
            "yes" if p.best else "",
        )
        for c in curves
        for p in c.points
    ]
    return Table(("method", "rtol", "seconds", "evaluations", error, "best"), rows, range(1, 5))


def html(bench: Bench) -> str:
    """Return the report as one HTML page that needs nothing else; its template escapes all but pictures."""
    values = {
        "title": f"{bench.scene}: run time against error",
        "command": bench.command,
        "about": [f"{name}: {value}" for name, value in bench.about],
        "words": [ERRORS, SPREADS],
        "sections": list(_sections(bench)),
        "regions": bench.regions,
        "notes": bench.notes,
        "cell": _cell,
    }
    return render("bench/report.html.jinja", values)


def stress_markdown(stress: Stress) -> str:
    """Return the hard cases as Markdown."""
    title = f"{stress.scene or 'Built-in scenes'}: hard cases"
    return _markdown(title, stress.command, [replace(stress.table, title="").markdown(), ""], (), stress.lines)


def stress_html(stress: Stress) -> str:
    """Return the hard cases as one HTML page."""
    values = {
        "title": stress.table.title,
        "command": stress.command,
        "about": [f"{len(stress.cases)} cases, {len(stress.failed)} failed"],
        "words": (),
        "sections": [Section("cases", [replace(stress.table, title="")])],
        "notes": stress.lines,
        "cell": _cell,
    }
    return render("bench/report.html.jinja", values)


def _cell(text: str) -> str:
    """Return a cell of a page; by a verdict in it the page colours the row."""
    return f'<span class="{text}">{text}</span>' if text in ("yes", "pass", "FAIL") else in_html(text)


def files(name: str, page: str, text: str, reported: Mapping[str, Any]) -> dict[str, str]:
    """Return the reports by the names of their files: a page, Markdown, and JSON without what is not finite."""
    facts = json.dumps(finite(reported), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    return {f"{name}.html": page, f"{name}.md": text, f"{name}.json": facts}


def bench_files(bench: Bench) -> dict[str, str]:
    """Return the reports of run time and error by the names of their files."""
    return files("bench", html(bench), markdown(bench), bench.as_dict())


def stress_files(stress: Stress) -> dict[str, str]:
    """Return the reports of hard cases by the names of their files."""
    return files("stress", stress_html(stress), stress_markdown(stress), stress.as_dict())
