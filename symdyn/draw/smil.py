"""A motion as an SVG picture that moves by SMIL and without a script, for pages that take pictures alone."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from symdyn.draw.animate import RATE, Rows, moving, tagged
from symdyn.draw.places import Array
from symdyn.scene import SceneLike, scene_of

TAGGED = re.compile(
    r'<(?P<element>\w+) (?P<before>[^>]*?) data-k="(?P<k>\d+)" data-kind="(?P<kind>\w+)"'
    r'(?: data-parts="(?P<parts>[\d ]+)")?(?P<closed> data-closed="1")?(?P<after>[^>]*?)(?P<end>/?)>'
)
"""An element that moves, as `tagged` writes it."""


def moving_picture(
    scene: SceneLike,
    times: Sequence[float] | Array,
    positions: Sequence[Sequence[float]] | Array,
    parameters: Mapping[str, float] | None = None,
    view: tuple[float, float] | None = None,
    scheme: str = "auto",
    fps: float = RATE,
    loop: bool = True,
    size: int | tuple[int, int] | None = None,
) -> str:
    """Return a motion as SVG text that plays in real time and begins again at its end, or plays once.

    It has no buttons, and bodies that pass in front of each other keep the order of the first moment: `animation`,
    which takes the same and raises the same, makes a page with both. `size` is its width in pixels, or width and
    height, where nothing around it says another one.
    """
    scene = scene_of(scene)
    drawing, t = moving(scene, times, positions, parameters, view, fps)
    text, rows, _ = tagged(drawing, scheme, len(t))
    if size is not None:
        _, _, wide, high = drawing.box
        width, height = size if isinstance(size, tuple) else (size, round(size * high / wide))
        text = re.sub(r' width="[\d.]+" height="[\d.]+">', f' width="{width}" height="{height}">', text, count=1)
    text = re.sub(r' data-item="\d+"', "", text)
    if len(t) < 2:
        return TAGGED.sub(_still, text)
    clock = f'dur="{t[-1] - t[0]:.6g}s"{_key_times(t)} {REPEATED[loop]}'
    return TAGGED.sub(partial(_animated, rows, clock), text)


REPEATED = {True: 'repeatCount="indefinite"', False: 'fill="freeze"'}


def _key_times(t: Array) -> str:
    """Return when each moment is, over the whole; nothing for even steps."""
    shares = (t - t[0]) / (t[-1] - t[0])
    if np.abs(shares - np.linspace(0, 1, len(t))).max() < 1e-4:
        return ""
    return f' keyTimes="{";".join(f"{x:.5g}" for x in shares)}"'


def _still(match: re.Match[str]) -> str:
    return f"<{match['element']} {match['before']}{match['after']}{match['end']}>"


def _animated(rows: Rows, clock: str, match: re.Match[str]) -> str:
    """Return an element with what moves it inside."""
    k, closing = int(match["k"]), f"</{match['element']}>" if match["end"] else ""
    parts = [int(count) for count in (match["parts"] or "").split()]
    inside = MOVES[match["kind"]](rows, k, clock, parts, "Z" if match["closed"] else "")
    return f"<{match['element']} {match['before']}{match['after']}>{inside}{closing}"


def _values(rows: Rows, write: Callable[[list[int]], str]) -> str:
    return f'values="{";".join(write(row) for row in rows)}"'


def _path(rows: Rows, k: int, clock: str, parts: Sequence[int], end: str) -> str:
    def way(row: list[int]) -> str:
        text, at = "", k
        for count in parts:
            text += "M" + "L".join(f"{row[at + 2 * i] / 10:g} {row[at + 2 * i + 1] / 10:g}" for i in range(count)) + end
            at += 2 * count
        return text

    return f'<animate attributeName="d" {_values(rows, way)} {clock}/>'


def _dot(rows: Rows, k: int, clock: str, parts: Sequence[int], end: str) -> str:
    return "".join(
        f'<animate attributeName="{name}" {_values(rows, lambda row, i=i: f"{row[k + i] / 10:g}")} {clock}/>'  # type: ignore[misc]
        for i, name in enumerate(("cx", "cy"))
    )


def _put(rows: Rows, k: int, clock: str, parts: Sequence[int], end: str, more: str = "") -> str:
    values = _values(rows, lambda row: f"{row[k] / 10:g} {row[k + 1] / 10:g}")
    return f'<animateTransform attributeName="transform" type="translate" {values} {clock}{more}/>'


def _disc(rows: Rows, k: int, clock: str, parts: Sequence[int], end: str) -> str:
    """Return what moves a circle in space; its angle jumps by half a turn, so that nothing is in between."""
    jump = ' calcMode="discrete"'
    angles = _values(rows, lambda row: f"{row[k + 3] / 10:g}")
    return (
        _put(rows, k, clock, parts, end, jump)
        + f'<animateTransform attributeName="transform" type="rotate" additive="sum" {angles} {clock}{jump}/>'
        + f'<animate attributeName="ry" {_values(rows, lambda row: f"{row[k + 2] / 10:g}")} {clock}{jump}/>'
    )


MOVES: Mapping[str, Callable[[Rows, int, str, Sequence[int], str], str]] = {
    "path": _path,
    "dot": _dot,
    "disc": _disc,
    "sign": _put,
    "label": _put,
}
