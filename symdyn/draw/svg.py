"""Drawings as SVG text, of mechanisms and of lines, dots and texts alone: the same drawing gives the same bytes.

Looks are those of the style sheet.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from symdyn.draw.places import Array, Label, Put
from symdyn.draw.shapes import ENGLISH, Item, Shape, Title, arrow, dot, path
from symdyn.draw.style import FONT, Text, lowered, style
from symdyn.emit import in_html
from symdyn.errors import DrawError
from symdyn.frozen import dataclass, field
from symdyn.unlocked import cached_property

MARGIN = 12.0
ROOM = 18.0  # of a frame that goes with bodies, around them: for joints, and the ground below


@dataclass(frozen=True)
class Drawing:
    """What a picture shows, at N moments.

    Attributes:
        title: of the picture, for readers and screen readers.
        items: in any order; `order` sorts them.
        labels: where the names are.
        camera: by how much the frame goes with what travels, shape (N, 2); None of a frame that stands.
    """

    title: str
    items: tuple[Item, ...]
    labels: tuple[Put, ...]
    camera: Array | None = None

    @cached_property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, width and height that hold everything at every moment; of a frame that goes, what it goes with."""
        low, high = np.full(2, np.inf), np.full(2, -np.inf)
        for shape in (shape for item in self.items if self.holds(item) for shape in item.shapes):
            flat = self.framed(shape.points).reshape(-1, 2)
            room = (shape.size if shape.kind != "path" else shape.size / 2) + (0.0 if self.camera is None else ROOM)
            low, high = np.minimum(low, flat.min(axis=0) - room), np.maximum(high, flat.max(axis=0) + room)
        for box in map(self.framed, (one.box for one in self.labels)):
            low = np.minimum(low, box[:, 0].min(axis=0))
            high = np.maximum(high, box[:, 1].max(axis=0))
        if not np.isfinite(low).all():
            low, high = np.zeros(2), np.zeros(2)
        low, high = np.floor(low - MARGIN), np.ceil(high + MARGIN)
        return float(low[0]), float(low[1]), float(high[0] - low[0]), float(high[1] - low[1])

    def holds(self, item: Item) -> bool:
        """Tell whether the frame is as large as an item: one that goes with bodies leaves the ground behind."""
        return self.camera is None or item.layer == 2 or item.id.startswith("body-")

    def framed(self, points: Array) -> Array:
        """Return points, shape (N, K, 2), as the frame shows them."""
        return points if self.camera is None else np.asarray(points - self.camera[:, None])

    def corner(self, moment: int = 0) -> tuple[float, float]:
        """Return left and top of the frame at a moment."""
        x, y = (0.0, 0.0) if self.camera is None else self.camera[moment]
        return self.box[0] + float(x), self.box[1] + float(y)


def order(items: Sequence[Item], moment: int) -> list[int]:
    """Return the items from the back to the front."""

    def depth(item: Item) -> float:
        return round(float(item.depth[min(moment, len(item.depth) - 1)]), 3)

    return sorted(range(len(items)), key=lambda k: (items[k].layer, depth(items[k])))


def svg(
    drawing: Drawing,
    prefix: str = "",
    scheme: str = "auto",
    tag: Callable[[Shape | Put], str] | None = None,
    titles: Mapping[str, str] = ENGLISH,
) -> str:
    """Return a drawing at its first moment; `tag` gives attributes for a shape or label, such as ` data-k="3"`."""
    left, top, width, height = (number(x) for x in (*drawing.corner(), *drawing.box[2:]))
    title = in_html(drawing.title)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="symdyn" role="img" aria-label="{title}" '
        f'viewBox="{left} {top} {width} {height}" width="{width}" height="{height}">',
        f"<title>{title}</title>",
        f"<style>\n{style(scheme)}</style>",
        f'<rect class="sheet" {_sheet(drawing)}/>',
    ]
    tagged = tag or (lambda _: "")
    for k in order(drawing.items, 0):
        item = drawing.items[k]
        marked = f' data-item="{k}"' if tag else ""
        lines.append(f'<g id="{name(prefix + item.id)}"{marked}><title>{in_html(item.title.sentence(titles))}</title>')
        lines += [element(shape, tagged(shape)) for shape in item.shapes]
        lines.append("</g>")
    lines += [_label(one, prefix, tagged(one)) for one in drawing.labels]
    return "\n".join([*lines, "</svg>", ""])


def _sheet(drawing: Drawing) -> str:
    """Return place and size of the paper, which is there wherever the frame goes."""
    ways = np.zeros((1, 2)) if drawing.camera is None else drawing.camera
    place, size = drawing.box[:2] + ways.min(axis=0), drawing.box[2:] + np.ptp(ways, axis=0)
    x, y, width, height = (number(float(one)) for one in (*place, *size))
    return f'x="{x}" y="{y}" width="{width}" height="{height}"'


def name(text: str) -> str:
    """Return an id that is legal in XML."""
    return re.sub(r"[^A-Za-z0-9_.-]", "_", text)


def number(x: float) -> str:
    """Return a number with one decimal; ties lie off the grid, so that the last bit of a sine decides nothing."""
    if not math.isfinite(x):
        raise DrawError("a point of the picture is beyond the largest double; choose units that keep numbers smaller")
    return f"{math.floor(x * 10 + 0.5 + 1e-4) / 10:.1f}".removesuffix(".0")


def element(shape: Shape, extra: str = "") -> str:
    """Return the element of a shape at its first moment."""
    flat = shape.points[0]
    common = f'class="{shape.look}"{extra}'
    x, y = number(flat[0, 0]), number(flat[0, 1])
    if shape.kind == "dot":
        return f'<circle {common} stroke-width="1.4" cx="{x}" cy="{y}" r="{shape.size:.2f}"/>'
    if shape.kind == "disc":
        minor, angle = shape.tilt[0]
        turned = f"translate({x} {y}) rotate({number(angle)})"
        return f'<ellipse {common} stroke-width="1.2" transform="{turned}" rx="{shape.size:.2f}" ry="{number(minor)}"/>'
    if shape.kind == "sign":
        return f'<path {common} transform="translate({x} {y})" d="{shape.sign}"/>'
    return f'<path {common} stroke-width="{shape.size:.2f}" d="{_way(shape, flat)}"/>'


def _way(shape: Shape, flat: Array) -> str:
    text, first = "", 0
    for count in shape.parts:
        part = flat[first : first + count]
        text += "M" + "L".join(f"{number(x)} {number(y)}" for x, y in part) + ("Z" if shape.closed else "")
        first += count
    return text


def _label(one: Put, prefix: str, extra: str) -> str:
    label, (x, y) = one.label, one.label.at[0]
    text = label.text
    dx, dy = one.offset[0], one.offset[1] + lowered(text)
    parts = [f'<g id="{name(prefix + label.id)}" transform="translate({number(x)} {number(y)})"{extra}>']
    if one.leader is not None:
        (a, b), (c, d) = one.leader
        parts.append(f'<path class="leader" stroke-width="0.9" d="M{number(a)} {number(b)}L{number(c)} {number(d)}"/>')
    look = f' class="{label.look}"' if label.look else ""
    parts.append(f'<text{look} x="{number(dx)}" y="{number(dy)}">{text.svg()}</text></g>')
    return "".join(parts)


@dataclass
class Diagram:
    """A picture that is made shape by shape; places are in units of the picture, y down."""

    title: str  # for readers and screen readers
    id: str  # of the group of all shapes
    shapes: list[Shape] = field(default_factory=list)
    labels: list[Put] = field(default_factory=list)
    FONT: ClassVar[float] = FONT  # height of letters, units of the picture

    def text(self, text: Text, x: float, y: float) -> None:
        """Put a text with its middle at a point."""
        label = Label(f"label-{len(self.labels)}", text, np.array([[x, y]]), 0.0)
        self.labels.append(Put(label, np.zeros(2)))

    def line(self, look: str, points: npt.ArrayLike, size: float = 1.0) -> None:
        """Draw a line through points, shape (K, 2), so thick."""
        self.shapes.append(path(look, np.array([points], dtype=np.float64), size=size))

    def dot(self, look: str, at: npt.ArrayLike, radius: float) -> None:
        """Draw a dot about a point, shape (2,)."""
        self.shapes.append(dot(look, np.array([at], dtype=np.float64), radius))

    def arrow(self, look: str, tail: npt.ArrayLike, tip: npt.ArrayLike, size: float = 2.4) -> None:
        """Draw an arrow between points, shape (2,), so thick."""
        ends = np.array([[tail], [tip]], dtype=np.float64)
        self.shapes.extend(arrow(look, ends[0], ends[1], size, 10.0))

    def svg(self, prefix: str) -> str:
        """Return it as SVG; `prefix` stands in front of ids."""
        item = Item(self.id, Title("{text}", text=self.title), 1, np.zeros(1), tuple(self.shapes))
        return svg(Drawing(self.title, (item,), tuple(self.labels)), prefix)
