"""Log-log plots as SVG text: points with a word each, series with a colour each; colours follow the reader's theme.

Plain text is enough for a few dozen points, needs no plotting library, and can be read on any page: a point tells its
word when the pointer rests on it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from symdyn.emit import in_html

WIDTH, HEIGHT = 540, 330
LEFT, RIGHT, TOP, BOTTOM = 74, 16, 34, 48
COLUMN, LINE = 230, 20
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
    """One point: where it is, what is told about it, whether it is marked by a ring, whether it is hollow."""

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


def log_log(title: str, x_label: str, y_label: str, series: Sequence[Series], floor: float = 1e-17) -> str:
    """Return a plot as an SVG element; what is zero or less stands at the `floor`, what is not finite is left out."""
    shown = [_placed(one, floor) for one in series]
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


def _placed(series: Series, floor: float) -> Series:
    dots = tuple(
        Dot(max(dot.x, floor), max(dot.y, floor), dot.text, dot.marked, dot.hollow)
        for dot in series.dots
        if math.isfinite(dot.x) and math.isfinite(dot.y)
    )
    return replace(series, dots=dots)


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
