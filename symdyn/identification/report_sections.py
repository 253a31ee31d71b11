"""What reports of identification are made of: tables, which the shell prints too, sections, and small plots.

Plots are SVG text: curves over time, bars, ellipses; colours are the page's.

    class   c0 c1 ...   colours of series                 band   a range that is shaded
            axis grid   lines of the frame                dash   what was before

A curve of many samples keeps the least and the largest of each pixel, so that no peak is lost.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import isfinite, nan
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.emit import in_html
from symdyn.frozen import dataclass
from symdyn.rounding import in_digits
from symdyn.table import Table

if TYPE_CHECKING:
    from symdyn.identification.identification import Identification


@dataclass(frozen=True)
class Picture:
    """An SVG element, and what stands below it."""

    svg: str
    caption: str


@dataclass(frozen=True)
class Section:
    """A part of the page."""

    title: str
    words: tuple[str, ...] = ()
    tables: tuple[Table[str], ...] = ()
    pictures: tuple[Picture, ...] = ()
    legend: tuple[tuple[str, str], ...] = ()
    small: bool = False


def figure(value: float, digits: int = 5) -> str:
    """Return a number as a cell shows it."""
    return in_digits(float(value), digits) if isfinite(value) else "\u2013"


def parameter_table(identification: Identification) -> Table[str]:
    """Return the base parameters before and after; gains, which have units, have a table of their own."""
    columns = (
        identification.names,
        identification.before,
        identification.after,
        identification.errors,
        identification.interval(),
        identification.regression.identifiable,
    )
    count = len(identification.names) - len(identification.gains)
    rows = []
    for name, before, after, error, interval, identifiable in list(zip(*columns, strict=True))[:count]:
        more = ("not identifiable", "", "", "", "")
        if identifiable:
            more = (*sure(error, interval, after), figure((after - before) / error if error else nan, 2))
        rows.append((name, figure(before), figure(after), *more))
    heads = ("parameter", "before", "after", *SURE, "moved, in standard errors")
    return Table(heads, rows, range(1, 8), f"Base parameters of {identification.declared.name}")


def frame_table(identification: Identification) -> Table[str]:
    """Return where the frames R1, R2, ... of base parameters are; without rows where there are none."""
    title = "Frames of base parameters: z along the joint's axis, mx = \u03a3 m x, Jxx = \u03a3 m x\u00b2"
    rows = [(name, *where) for name, where in identification.frames.items()]
    return Table(("frame", "body", "joint", "in the frame of the body"), rows, title=title)


def gain_table(identification: Identification) -> Table[str]:
    """Return the gains of drives; without rows where there are none."""
    intervals = dict(zip(identification.names, identification.interval(), strict=True))
    rows = [
        (one.drive, one.unit, figure(one.value), *sure(one.error, intervals[f"gain {one.drive}"], one.value))
        if isfinite(one.error)
        else (one.drive, one.unit, figure(nan), "not identifiable", "", "", "")
        for one in identification.gains
    ]
    return Table(("drive", "unit", "gain", *SURE), rows, range(2, 7), "Gains of drives")


SURE = ("standard error", "95 % from", "to", "% of it")
"""How sure an estimate is."""


def sure(error: float, interval: Array, value: float) -> tuple[str, str, str, str]:
    """Return the cells of `SURE`."""
    low, high = interval
    return figure(error, 2), figure(low), figure(high), figure(100 * error / abs(value), 2) if value else ""


def fit_table(identification: Identification) -> Table[str]:
    """Return how well driving forces are predicted: root mean squares, errors those in the band."""
    rows = [
        (one.drive, one.unit, figure(one.size), figure(one.error, 3), figure(one.percent, 2), figure(one.before, 3),
         figure(one.validation, 3), figure(one.validation_percent, 2))
        for one in identification.fits
    ]  # fmt: skip
    heads = ("drive", "unit", "measured", "error", "%", "error before", "validation error", "%")
    return Table(heads, rows, range(2, 8), "Driving forces, root mean squares")


WIDTH, HEIGHT = 480, 190
LEFT, RIGHT, TOP, BOTTOM = 62, 10, 10, 36
PIXELS = 400
"""Places along x that a curve is shown at; each has two values at most."""


@dataclass(frozen=True)
class Curve:
    """One curve.

    Attributes:
        kind: its class.
        x, y: its points, shape (N,); what is not finite is a gap.
        aside: that the axes are not made for it; where it leaves the picture it stands at the edge.
    """

    kind: str
    x: Array
    y: Array
    aside: bool = False


@dataclass(frozen=True)
class Frame:
    """Where values stand in a picture."""

    low: float
    high: float
    least: float
    most: float
    width: int = WIDTH
    height: int = HEIGHT

    def across(self, x: float) -> float:
        """Return where x stands, px from the left."""
        return LEFT + (x - self.low) / (self.high - self.low) * (self.width - LEFT - RIGHT)

    def up(self, y: float) -> float:
        """Return where y stands, px from the top."""
        return self.height - BOTTOM - (y - self.least) / (self.most - self.least) * (self.height - TOP - BOTTOM)


def curves(
    reported: str, x_label: str, y_label: str, shown: Sequence[Curve], shaded: Sequence[tuple[float, float]] = ()
) -> str:
    """Return curves over one axis as an SVG element.

    Args:
        reported: what the picture shows, for who does not see it.
        x_label: name and unit of what goes across.
        y_label: the same of what goes up.
        shown: in the order of drawing.
        shaded: ranges of x that are marked.
    """
    counted = [one for one in shown if not one.aside]
    frame = _frame(*(np.concatenate([getattr(one, axis) for one in counted]) for axis in "xy"))
    body = [
        f'<rect class="band" x="{_n(frame.across(a))}" y="{TOP}" width="{_n(frame.across(b) - frame.across(a))}" '
        f'height="{HEIGHT - TOP - BOTTOM}"/>'
        for a, b in shaded
    ]
    body += [f'<path class="{one.kind}" d="{_path(one, frame)}"/>' for one in shown]
    return _svg(reported, x_label, y_label, frame, body)


def bars(
    reported: str,
    x_label: str,
    y_label: str,
    edges: Array,
    heights: Array,
    curve: Curve | None = None,
    limit: float = 0.0,
) -> str:
    """Return bars between edges, shape (n + 1,), with heights, shape (n,); a curve over them, and lines at ± limit."""
    heights = np.nan_to_num(heights)
    more = curve.y if curve else np.zeros(0)
    frame = _frame(edges, np.concatenate([heights, [0.0, limit, -limit if limit else 0.0], more]))
    zero = frame.up(0.0)
    body = []
    for a, b, height in zip(edges[:-1], edges[1:], heights, strict=True):
        left, right, top = frame.across(float(a)), frame.across(float(b)), frame.up(float(height))
        y, tall = min(top, zero), abs(zero - top)
        body.append(
            f'<rect class="bar" x="{_n(left + 0.5)}" y="{_n(y)}" width="{_n(max(right - left - 1, 0.5))}" '
            f'height="{_n(tall)}"/>'
        )
    body += [f'<path class="{curve.kind}" d="{_path(curve, frame)}"/>'] if curve else []
    for level in (limit, -limit) if limit else ():
        body.append(f'<path class="c1 dash" d="M{LEFT},{_n(frame.up(level))}H{frame.width - RIGHT}"/>')
    return _svg(reported, x_label, y_label, frame, body)


def ellipses(reported: str, x_label: str, y_label: str, shown: Sequence[tuple[str, Array, Array]]) -> str:
    """Return ellipses as an SVG element, both axes at one scale.

    Args:
        reported: what the picture shows.
        x_label: name and unit of what goes across.
        y_label: the same of what goes up.
        shown: class, centre, shape (2,), and matrix A, shape (2, 2), of the ellipse x^T A^-1 x = 1 about it.
    """
    turn = np.linspace(0, 2 * np.pi, 61)
    outlines = []
    for kind, centre, matrix in shown:
        w, V = np.linalg.eigh(matrix)
        outline = centre[:, None] + V @ (np.sqrt(np.maximum(w, 0))[:, None] * np.stack([np.cos(turn), np.sin(turn)]))
        outlines.append((kind, centre, outline))
    every = np.concatenate([o for _, _, o in outlines] + [np.zeros((2, 1))], axis=1)
    middle, half = (every.max(axis=1) + every.min(axis=1)) / 2, float(np.ptp(every, axis=1).max()) / 2 * 1.08 or 1.0
    side = 240
    frame = Frame(
        middle[0] - half, middle[0] + half, middle[1] - half, middle[1] + half,
        side + LEFT + RIGHT, side + TOP + BOTTOM,
    )  # fmt: skip
    body = []
    for kind, centre, outline in outlines:
        curve = Curve(kind, outline[0], outline[1])
        points = " ".join(
            f"{_n(frame.across(float(a)))},{_n(frame.up(float(b)))}" for a, b in zip(curve.x, curve.y, strict=True)
        )
        body.append(f'<polygon class="{kind}" points="{points}"/>')
        body.append(
            f'<circle class="{kind} point" cx="{_n(frame.across(float(centre[0])))}" '
            f'cy="{_n(frame.up(float(centre[1])))}" r="2.5"/>'
        )
    return _svg(reported, x_label, y_label, frame, body)


def _frame(x: Array, y: Array) -> Frame:
    x, y = x[np.isfinite(x)], y[np.isfinite(y)]
    low, high = (float(x.min()), float(x.max())) if len(x) else (0.0, 1.0)
    least, most = (float(y.min()), float(y.max())) if len(y) else (0.0, 1.0)
    high = high if high > low else low + 1.0
    room = 0.04 * (most - least) if most > least else max(abs(most), 1.0) * 0.5
    return Frame(low, high, least - room, most + room)


def _path(curve: Curve, frame: Frame) -> str:
    """Return the way of a curve, with the least and the largest of each place."""
    x, y = curve.x, np.clip(curve.y, frame.least, frame.most)
    size = max(1, math.ceil(len(x) / PIXELS))
    words, up = list[str](), True
    for k in range(0, len(x), size):
        part = y[k : k + size]
        good = np.flatnonzero(np.isfinite(part))
        if not len(good):
            up = True
            continue
        least, most = int(good[np.argmin(part[good])]), int(good[np.argmax(part[good])])
        for at in sorted({least, most}):
            words.append(f"{'M' if up else 'L'}{_n(frame.across(float(x[k + at])))},{_n(frame.up(float(part[at])))}")
            up = False
    return "".join(words)


def _svg(reported: str, x_label: str, y_label: str, frame: Frame, body: Sequence[str]) -> str:
    right, bottom = frame.width - RIGHT, frame.height - BOTTOM
    lines = []
    for value in _ticks(frame.low, frame.high):
        x = _n(frame.across(value))
        lines.append(f'<path class="grid" d="M{x},{TOP}V{bottom}"/>')
        lines.append(f'<text x="{x}" y="{bottom + 14}" text-anchor="middle">{_word(value)}</text>')
    for value in _ticks(frame.least, frame.most):
        y = _n(frame.up(value))
        lines.append(f'<path class="grid" d="M{LEFT},{y}H{right}"/>')
        lines.append(f'<text x="{LEFT - 5}" y="{y}" dy=".32em" text-anchor="end">{_word(value)}</text>')
    middle = _n((TOP + bottom) / 2)
    lines += [
        f'<text x="{_n((LEFT + right) / 2)}" y="{frame.height - 5}" text-anchor="middle">{in_html(x_label)}</text>',
        f'<text transform="translate(12,{middle}) rotate(-90)" text-anchor="middle">{in_html(y_label)}</text>',
    ]
    edge = f'<path class="axis" d="M{LEFT},{TOP}V{bottom}H{right}"/>'
    label = in_html(reported)
    return (
        f'<svg role="img" aria-label="{label}" viewBox="0 0 {frame.width} {frame.height}">'
        f"<title>{label}</title>{''.join(lines)}{''.join(body)}{edge}</svg>"
    )


def _ticks(low: float, high: float) -> list[float]:
    """Return some four round values in a range."""
    wide = (high - low) / 4
    power = 10.0 ** math.floor(math.log10(wide))
    step = next(k * power for k in (1, 2, 5, 10) if k * power >= wide * 0.999)
    return [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def _word(value: float) -> str:
    return f"{value:.4g}".replace("-", "\u2212")


def _n(x: float) -> str:
    return f"{x:.1f}".removesuffix(".0")
