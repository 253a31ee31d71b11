"""A motion as a page that needs nothing else: a picture, its positions at every moment, and a small player.

For pages that take pictures alone there is an SVG picture that moves by SMIL, without a script.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Protocol, runtime_checkable

import numpy as np

from symdyn.arguments import checked, native
from symdyn.draw.force_arrows import with_corner
from symdyn.draw.pictures import HtmlText, body_names, lines, mechanism
from symdyn.draw.places import Array, Places, Put, places, put
from symdyn.draw.shapes import Item, Shape, Title, path
from symdyn.draw.stage import Stage, View, pose, values_of
from symdyn.draw.svg import Drawing, number, order, svg
from symdyn.emit import in_html, render
from symdyn.errors import DrawError
from symdyn.scene import Scene, SceneLike, scene_of

Indices = np.ndarray[Any, np.dtype[np.intp]]
Rows = list[list[int]]

RATE = 30.0  # moments a second that are kept where nothing else is said
MOST = 1800  # moments in all
FINE = 120.0  # moments a second of the paths that points leave
SAMPLES = 6  # moments at which labels keep clear of lines


@runtime_checkable
class Moved(Protocol):
    """A scene in motion, as a run is: times t, s, positions q, and inputs, shapes (N,), (N, nq) and (N, ni)."""

    @property
    def scene(self) -> Scene: ...
    @property
    def t(self) -> Array: ...
    @property
    def q(self) -> Array: ...
    @property
    def inputs(self) -> Array: ...


def motion_of(
    scene: SceneLike | Moved, times: Sequence[float] | Array | None, positions: Sequence[Sequence[float]] | Array | None
) -> tuple[Scene, Sequence[float] | Array, Sequence[Sequence[float]] | Array]:
    """Return a scene, times and positions, those of a run or those that are given; DrawError where they are not."""
    if isinstance(scene, Moved):
        if times is not None or positions is not None:
            raise DrawError(f"{scene.scene.name}: a run has times and positions of its own; leave others out")
        moved = (scene.inputs, scene.t[:, None]) if scene.scene.supports else ()
        return scene.scene, scene.t, np.hstack([scene.q, *moved])
    if times is None or positions is None:
        raise DrawError("a scene moves by times and positions: give both behind it, or a run alone")
    return scene_of(scene), times, positions


@checked(DrawError)
def animation(
    scene: SceneLike | Moved,
    times: Sequence[float] | Array | None = None,
    positions: Sequence[Sequence[float]] | Array | None = None,
    parameters: Mapping[str, float] | None = None,
    view: tuple[float, float] | None = None,
    scheme: str = "auto",
    fps: float = RATE,
    loop: bool = True,
) -> str:
    """Return a motion as a page with a slider, play and pause, a choice of speeds, and keys for all of them.

    The page keeps `fps` moments a second of real time, 1800 at most, fewer where the motion has fewer. Named points
    leave their paths. A reader who prefers reduced motion starts it by hand.

    >>> import symdyn
    >>> page = symdyn.animation(symdyn.example("cart_pole"), [0, 1], [[0, 0], [0.5, 1]])
    >>> page[:15]
    '<!DOCTYPE html>'

    Args:
        scene: a run; or any scene, and how it moves.
        times: of a scene, increasing, s; shape (N,).
        positions: of a scene, q at every time, shape (N, nq).
        parameters: values of parameters; those without any are as in `picture`.
        view: azimuth and elevation of the viewer in degrees; None chooses.
        scheme: "auto", "light" or "dark".
        fps: moments a second that are kept.
        loop: whether it begins again at its end.

    Raises:
        DrawError: shapes that do not fit, times that do not increase, a rate that is none, or no real value at a
            position.
    """
    (fps,), (scene, times, positions) = native(float, fps), motion_of(scene, times, positions)
    drawing, t = moving(scene, times, positions, parameters, view, fps)
    text, table, depths = tagged(drawing, scheme, len(t))
    data = {"t": [round(float(x - t[0]), 6) for x in t], "first": round(float(t[0]), 6), "x": table, "order": depths}
    data |= {} if loop else {"once": True}
    data |= {} if drawing.camera is None else {"view": _frames(drawing)}
    page = render(
        "draw/animation.html.jinja",
        {
            "title": in_html(scene.name),
            "picture": text,
            "data": json.dumps(data, separators=(",", ":"), allow_nan=False),
            "dark": scheme == "dark",
            "auto": scheme == "auto",
        },
    )
    return HtmlText(page)


def moving(
    scene: Scene,
    times: Sequence[float] | Array,
    positions: Sequence[Sequence[float]] | Array,
    parameters: Mapping[str, float] | None,
    view: tuple[float, float] | None,
    fps: float = RATE,
    most: int = MOST,
) -> tuple[Drawing, Array]:
    """Return a motion as a drawing at the moments that are kept, and their times; see `animation`."""
    if not 0 < fps < np.inf:
        raise DrawError(f"{scene.name}: {fps:g} moments a second; give a number above 0, such as {RATE:g}")
    fine, ways, values = moments(scene, times, positions, parameters, max(fps, FINE), most)
    kept = _kept(fine, fps, most)
    t, q = fine[kept], ways[kept]
    stage = Stage(scene, q, values, view)
    found, (seen, camera) = stage.places, stage.filmed(t)
    items, labels = mechanism(scene, found, seen)
    items = (*_traces(places(scene, ways, values), seen), *items)
    sampled = np.linspace(0, len(t) - 1, min(SAMPLES, len(t))).astype(int)
    segments = lines(items, len(t))[sampled]
    named = [*labels, *body_names(found, seen)]
    few = [type(one)(one.id, one.text, one.at[sampled], one.gap, one.away, one.look) for one in named]
    puts = put(few, segments)
    whole = {one.id: one for one in named}
    drawing = Drawing(scene.name, items, tuple(Put(whole[one.label.id], one.offset) for one in puts), camera)
    shown = segments if camera is None else segments - camera[sampled][:, None, None]
    return with_corner(drawing, scene, found, seen, shown), t


def moments(
    scene: Scene,
    times: Sequence[float] | Array,
    positions: Sequence[Sequence[float]] | Array,
    parameters: Mapping[str, float] | None,
    fps: float,
    most: int = MOST,
) -> tuple[Array, Array, dict[str, float]]:
    """Return the moments of a motion that are kept, the positions there, and values of all parameters."""
    t, q = as_arrays(scene, times, positions)
    kept, given = _kept(t, fps, most), dict(parameters or {})
    values = values_of(scene, given)
    if scene.loops and any(parameter.name not in given for parameter in scene.free_parameters):
        values = pose(scene, parameters=given)[1]
    return t[kept], q[kept], values


def as_arrays(
    scene: Scene, times: Sequence[float] | Array, positions: Sequence[Sequence[float]] | Array
) -> tuple[Array, Array]:
    """Return times and positions as arrays, shapes (N,) and (N, nq); errors as of `animation`."""
    try:
        t, q = (np.asarray(x if hasattr(x, "__array__") else list(x), np.float64) for x in (times, positions))
    except (TypeError, ValueError, OverflowError) as fault:
        raise DrawError(f"{scene.name}: times or positions are no numbers: {fault}") from None
    if t.ndim != 1 or len(t) == 0 or q.ndim != 2 or len(q) != len(t):
        raise DrawError(
            f"{scene.name}: times have shape {t.shape} and positions {q.shape}; give (N,) and (N, "
            f"{len(scene.coordinates)}) with N at least 1"
        )
    if not np.isfinite(t).all() or np.any(np.diff(t) <= 0):
        raise DrawError(f"{scene.name}: times must be finite and increase from each one to the next")
    if not np.isfinite(q).all():
        row = int(np.argmin(np.isfinite(q).all(axis=1)))
        raise DrawError(f"{scene.name}: the position at t = {t[row]:.6g} is not finite; cut the motion before it")
    return t, q


def _kept(t: Array, fps: float, most: int) -> Indices:
    """Return which moments are kept: those nearest to a grid of `fps` a second."""
    count = int(min(most, max(2, round((t[-1] - t[0]) * fps) + 1)))
    if len(t) <= count:
        return np.arange(len(t))
    grid = np.linspace(t[0], t[-1], count)
    after = np.clip(np.searchsorted(t, grid), 1, len(t) - 1)
    return np.unique(np.where(grid - t[after - 1] < t[after] - grid, after - 1, after))


def _traces(result: Places, view: View) -> tuple[Item, ...]:
    items = []
    for name, (_, frame) in result.points.items():
        way = view.flat(frame.p)
        if float(np.ptp(way, axis=0).max(initial=0.0)) > 1.0:
            shape = path("trace", way[None], size=1.0)
            items.append(Item(f"trace-{name}", Title("path of point {name}", name=name), 0, np.zeros(1), (shape,)))
    return tuple(items)


def tagged(drawing: Drawing, scheme: str, count: int) -> tuple[str, list[list[int]], list[list[Any]]]:
    """Return the picture with numbered moving parts, their numbers at every moment, and changes of their order.

    Numbers are tenths of a unit: the points of a path, the middle of a dot or sign, of a disc middle, minor radius and
    angle, of a label its anchor. A change of order is the moment and the items from back to front.
    """
    columns: list[Array] = []
    known: dict[bytes, int] = {}

    def tag(one: Shape | Put) -> str:
        if isinstance(one, Put):
            kind, flat, more = "label", one.label.at, ""
        else:
            kind, flat = one.kind, one.points.reshape(len(one.points), -1)
            more = f' data-parts="{" ".join(map(str, one.parts))}"' if one.parts else ""
            more += ' data-closed="1"' if one.closed else ""
            if len(one.tilt):
                flat = np.concatenate([flat, np.broadcast_to(one.tilt, (len(flat), 2))], axis=1)
        whole = np.floor(flat * 10 + 0.5 + 1e-4).astype(int)
        if len(whole) == 1 or not np.any(whole != whole[0]):
            return ""
        key = whole.tobytes()
        if key not in known:
            known[key] = sum(column.shape[1] for column in columns)
            columns.append(whole)
        return f' data-k="{known[key]}" data-kind="{kind}"{more}'

    text = svg(drawing, "", scheme, tag)
    table = np.concatenate(columns, axis=1) if columns else np.zeros((count, 0), dtype=int)
    changes: list[list[Any]] = []
    for moment in range(count):
        now = order(drawing.items, moment)
        if not changes or changes[-1][1] != now:
            changes.append([moment, now])
    return text, table.tolist(), changes


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
        return TAGGED.sub(r"<\g<element> \g<before>\g<after>\g<end>>", text)
    clock = f'dur="{t[-1] - t[0]:.6g}s"{_key_times(t)} {REPEATED[loop]}'
    if frames := _frames(drawing):
        moved = f'<animate attributeName="viewBox" values="{";".join(frames)}" {clock}/>'
        text = text.replace("</title>", f"</title>\n{moved}", 1)
    return TAGGED.sub(partial(_animated, rows, clock), text)


REPEATED = {True: 'repeatCount="indefinite"', False: 'fill="freeze"'}


def _frames(drawing: Drawing) -> list[str]:
    """Return the frame of a drawing at every moment, as SVG has it."""
    corners = (drawing.corner(k) for k in range(0 if drawing.camera is None else len(drawing.camera)))
    return [" ".join(map(number, (*corner, *drawing.box[2:]))) for corner in corners]


def _key_times(t: Array) -> str:
    """Return when each moment is, over the whole; nothing for even steps."""
    shares = (t - t[0]) / (t[-1] - t[0])
    if np.abs(shares - np.linspace(0, 1, len(t))).max() < 1e-4:
        return ""
    return f' keyTimes="{";".join(f"{x:.5g}" for x in shares)}"'


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


def _put(rows: Rows, k: int, clock: str, parts: Sequence[int], end: str) -> str:
    values = _values(rows, lambda row: f"{row[k] / 10:g} {row[k + 1] / 10:g}")
    return f'<animateTransform attributeName="transform" type="translate" {values} {clock}/>'


def _disc(rows: Rows, k: int, clock: str, parts: Sequence[int], end: str) -> str:
    """Return what moves a circle in space; its angle jumps by half a turn, so that nothing is in between."""
    jump = ' calcMode="discrete"'
    angles = _values(rows, lambda row: f"{row[k + 3] / 10:g}")
    return (
        _put(rows, k, clock, parts, end)
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
