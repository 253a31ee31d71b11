"""Reports of what was measured: one HTML page with its pictures inside, Markdown, and JSON.

Log-log plots are SVG text: points with a word each, series with a colour each, which follow the reader's theme. That is
enough for a few dozen points, needs no plotting library, and can be read on any page: a point shows its word when the
pointer rests on it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isnan
from typing import TYPE_CHECKING, Any

from symdyn.emit import in_html, in_markdown, render
from symdyn.frozen import dataclass, field, replace
from symdyn.rounding import finite, in_digits
from symdyn.table import Table
from symdyn.verdict import Verdict

if TYPE_CHECKING:
    from symdyn.bench.measurements import Bench, Curve, MotionPrecision, Stress


WIDTH, HEIGHT = 540, 330
LEFT, RIGHT, TOP, BOTTOM = 74, 16, 34, 48
COLUMN, LINE = 230, 20
FLOOR = 1e-17
"""Width and height of a word of the legend, which stands below, so that a narrow page shows all of it."""

STYLE = """
.plot { font: 14px system-ui, sans-serif; display: block; width: 100%; max-width: 44rem; height: auto; }
.plot text { fill: #222; } .plot .axis, .plot .ring { stroke: #222; } .plot .grid { stroke: #ddd; }
.plot .ring { stroke-width: 1.5; } .plot .hollow { fill: #fff; }
@media (prefers-color-scheme: dark) {
.plot text { fill: #ddd; } .plot .axis, .plot .ring { stroke: #ddd; } .plot .grid { stroke: #3a3a3a; }
.plot .hollow { fill: #1b1b1b; }
}
"""
"""No variables of CSS: programs that draw pictures outside browsers do not know them, and paint black."""

COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#ff7f0e", "#9467bd", "#17becf", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22")


@dataclass(frozen=True)
class Dot:
    """One point: where it is, its description, whether it is marked by a ring, whether it is hollow."""

    x: float
    y: float
    text: str
    marked: bool = False
    hollow: bool = False


@dataclass(frozen=True)
class Series:
    """Points of one colour, joined by a line or not; the colour is that of its place if none is said."""

    name: str
    dots: tuple[Dot, ...]
    joined: bool = False
    colour: int | None = None


def log_log(title: str, x_label: str, y_label: str, series: Sequence[Series]) -> str:
    """Return a plot as an SVG element; what is below FLOOR stands there, what is not finite is left out."""
    shown = [_placed(one) for one in series]
    dots = [dot for one in shown for dot in one.dots]
    if not dots:
        return ""
    x, y = (_Axis.around([getattr(dot, name) for dot in dots]) for name in "xy")

    def across(value: float) -> float:
        return LEFT + x.share(value) * (WIDTH - LEFT - RIGHT)

    def up(value: float) -> float:
        return HEIGHT - BOTTOM - y.share(value) * (HEIGHT - TOP - BOTTOM)

    columns = (WIDTH - LEFT) // COLUMN
    height = HEIGHT + LINE * -(-len(shown) // columns)
    size = f'width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}"'
    lines = [f'<svg class="plot" role="img" {size} xmlns="http://www.w3.org/2000/svg">']
    lines += [f"<title>{in_html(title)}</title><style>{STYLE}</style>"]
    lines += [f'<text x="{LEFT}" y="20" font-weight="bold">{in_html(title)}</text>']
    bottom, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    for tick in x.ticks:
        at = f"{across(tick):.1f}"
        lines.append(f'<line class="grid" x1="{at}" x2="{at}" y1="{TOP}" y2="{bottom}"/>')
        lines.append(f'<text x="{at}" y="{bottom + 19}" text-anchor="middle">{_number(tick)}</text>')
    for tick in y.ticks:
        at = f"{up(tick):.1f}"
        lines.append(f'<line class="grid" y1="{at}" y2="{at}" x1="{LEFT}" x2="{right}"/>')
        lines.append(f'<text x="{LEFT - 6}" y="{at}" dy="5" text-anchor="end">{_number(tick)}</text>')
    lines.append(f'<path class="axis" fill="none" d="M{LEFT} {TOP}V{bottom}H{right}"/>')
    middle = (LEFT + right) / 2
    lines.append(f'<text x="{middle:.0f}" y="{HEIGHT - 8}" text-anchor="middle">{in_html(x_label)}</text>')
    turned = f"translate(16 {(TOP + bottom) / 2:.0f}) rotate(-90)"
    lines.append(f'<text transform="{turned}" text-anchor="middle">{in_html(y_label)}</text>')
    for k, one in enumerate(shown):
        colour = COLOURS[(k if one.colour is None else one.colour) % len(COLOURS)]
        if one.joined:
            path = "L".join(f"{across(dot.x):.1f} {up(dot.y):.1f}" for dot in one.dots)
            lines.append(f'<path fill="none" stroke-width="1.5" stroke="{colour}" d="M{path}"/>')
        lines += [_circle(dot, across(dot.x), up(dot.y), colour) for dot in one.dots]
        left, top = LEFT + COLUMN * (k % columns), HEIGHT + LINE * (k // columns) + 8
        lines += [f'<circle cx="{left}" cy="{top}" r="4" fill="{colour}"/>']
        lines += [f'<text x="{left + 10}" y="{top + 5}">{in_html(one.name)}</text>']
    return "\n".join([*lines, "</svg>"])


def _placed(series: Series) -> Series:
    finite = [dot for dot in series.dots if math.isfinite(dot.x) and math.isfinite(dot.y)]
    return replace(series, dots=tuple(replace(dot, x=max(dot.x, FLOOR), y=max(dot.y, FLOOR)) for dot in finite))


def _circle(dot: Dot, x: float, y: float, colour: str) -> str:
    at = f'cx="{x:.1f}" cy="{y:.1f}"'
    fill = f'class="hollow" stroke="{colour}" stroke-width="1.5"' if dot.hollow else f'fill="{colour}"'
    ring = f'<circle class="ring" fill="none" {at} r="7"/>' if dot.marked else ""
    return f"<g><title>{in_html(dot.text)}</title>{ring}<circle {at} r='4' {fill}/></g>"


def _number(value: float) -> str:
    """Return a tick's label: plain digits near one, else a power of ten, which ticks out there are."""
    if 1e-2 <= value <= 1e3:
        return f"{value:g}"
    power = math.floor(math.log10(value) + 1e-9)
    factor = f"{value / 10.0**power:.0f}"
    sign, size = ("\u2212" if power < 0 else ""), abs(power)
    return f'{"" if factor == "1" else factor + "·"}10<tspan dy="-6" font-size="10">{sign}{size}</tspan>'


@dataclass(frozen=True)
class _Axis:
    """A logarithmic axis from 10^low to 10^high."""

    low: float
    high: float

    @staticmethod
    def around(values: Sequence[float]) -> _Axis:
        logs = [math.log10(value) for value in values]
        low, high = math.floor(min(logs) * 2 - 0.3) / 2, math.ceil(max(logs) * 2 + 0.3) / 2
        return _Axis(low, high)

    @property
    def ticks(self) -> list[float]:
        """Powers of ten to label, ten at most; also twice and five times those where there are hardly any."""
        first, last = math.ceil(self.low), math.floor(self.high)
        if last - first >= 2:
            return [10.0**k for k in range(first, last + 1, -(-(last - first + 1) // 10))]
        finer = [factor * 10.0**k for k in range(first - 1, last + 1) for factor in (1, 2, 5)]
        return [tick for tick in finer if self.low <= math.log10(tick) <= self.high]

    def share(self, value: float) -> float:
        """Return where a value stands, 0 at the low end and 1 at the high one."""
        return (math.log10(value) - self.low) / (self.high - self.low)


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
    """A part of a report: a table, and one of each region, which its title names; `choices` stand on pages."""

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
    """Return the plot of one function: a colour a variant, hollow points are float, rings are Pareto-best."""
    groups: dict[str, list[Dot]] = {}
    for one in bench.measured:
        if one.function == function:
            text = f"{one.label}: {one.nanoseconds} ns, {one.relative:.1e}"
            groups.setdefault(one.variant, []).append(Dot(one.call, one.relative, text, one.best, one.real == "float"))
    series = [Series(variant, tuple(dots)) for variant, dots in groups.items()]
    return log_log(f"{bench.scene}: {function}", "ns a state", "relative error, 99 %", series)


def _lines(curves: Sequence[Curve], motion: MotionPrecision) -> list[Series]:
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
    doubt = f"which may be off by {motion.uncertain:.0e}; no smaller error is reported" if motion.uncertain else "exact"
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
