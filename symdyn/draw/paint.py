"""A drawing painted by matplotlib's renderers: PNG, PDF, and the frames of a film. Shapes are ours, dot for dot as SVG.

Between two moments a shape is where the straight way between both leads, as it is where SVG moves by itself. A file's
ending says what it is: SVG as it is returned, PDF and PNG painted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.draw.places import Array, Put
from symdyn.draw.plots import import_matplotlib, outlined, require, saved, settings
from symdyn.draw.shapes import Shape
from symdyn.draw.style import SCHEMES, look_of, lowered, plain
from symdyn.draw.svg import Drawing, order
from symdyn.draw.tex import Curve, curves, ellipse
from symdyn.emit import Contents, write
from symdyn.errors import DrawError, EmitError

UNIT = 0.75  # points a unit of the picture: the size that browsers give it
SHARP = 2.0  # pixels a unit of the picture in a PNG whose width nobody chose
HALO = 3.0  # width of the edge around letters
WIDEST = 16384  # pixels of a side, at most

Frame = np.ndarray[Any, np.dtype[np.uint8]]


def painted(drawing: Drawing, kind: str, scheme: str = "auto") -> bytes:
    """Return a drawing at its first moment as a "png" or "pdf" file; the same drawing, the same bytes.

    Raises:
        DrawError: another scheme, or no matplotlib.
    """
    require("pictures in PNG and PDF", "matplotlib")
    _, _, width, height = drawing.box
    scale = UNIT if kind == "pdf" else min(SHARP, WIDEST / max(width, height))
    with settings({}):
        figure = _figure(drawing, scheme, width * scale, height * scale, 0.0)
        return saved(figure, kind, 72)


class Painter:
    """Paints a drawing at any moment as pixels."""

    def __init__(self, drawing: Drawing, size: tuple[int, int], scheme: str = "auto") -> None:
        """Take a drawing, and width and height in pixels; what is left of them beside the drawing is paper."""
        require("films", "matplotlib")
        self.drawing, self.size, self.scheme = drawing, size, scheme

    def __call__(self, moment: float) -> Frame:
        """Return the pixels at a moment, shape (height, width, 3); moments are counted from 0, parts are between."""
        import_matplotlib()
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        with settings({}):
            width, height = self.size
            canvas: Any = FigureCanvasAgg(_figure(self.drawing, self.scheme, width, height, moment))
            canvas.draw()
            return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def _figure(drawing: Drawing, scheme: str, width: float, height: float, moment: float) -> Any:
    """Return a figure of a size in dots, at 72 a inch, on which everything is drawn."""
    import_matplotlib()
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

    class Ours(Artist):  # type: ignore[misc, unused-ignore]
        def draw(self, renderer: Any) -> None:
            _draw(renderer, drawing, scheme, width, height, moment)

    whole = 1e-6  # a size in pixels survives the way through inches
    colours = SCHEMES[plain(scheme)]
    figure = Figure(figsize=((width + whole) / 72, (height + whole) / 72), dpi=72, facecolor=colours["paper"])
    figure.add_artist(Ours())
    return figure


def _draw(renderer: Any, drawing: Drawing, scheme: str, width: float, height: float, moment: float) -> None:
    from matplotlib.transforms import Affine2D

    left, top, wide, high = drawing.box
    scale = min(width / wide, height / high)
    frame = Affine2D().translate(-left - wide / 2, -top - high / 2).scale(scale, -scale)
    pen = _Pen(renderer, plain(scheme), scale, frame.translate(width / 2, height / 2))
    for k in order(drawing.items, round(moment)):
        for shape in drawing.items[k].shapes:
            pen.shape(shape, moment)
    for one in drawing.labels:
        pen.label(one, moment)


class _Pen:
    """Draws shapes and labels with a renderer; `frame` leads from the picture to the renderer's dots."""

    def __init__(self, renderer: Any, scheme: str, scale: float, frame: Any) -> None:
        self.renderer, self.scheme, self.scale, self.frame = renderer, scheme, scale, frame

    def shape(self, shape: Shape, moment: float) -> None:
        """Draw a shape."""
        from matplotlib.transforms import Affine2D

        flat = between(shape.points, moment)
        x, y = (float(one) for one in flat[0])
        if shape.kind == "dot":
            outline, tag, width = ellipse(x, y, shape.size, shape.size), "circle", 1.4
        elif shape.kind == "disc":
            minor, angle = shape.tilt[min(round(moment), len(shape.tilt) - 1)]
            turned = Affine2D().rotate_deg(float(angle)).translate(x, y)
            look = look_of("ellipse", shape.look, self.scheme, **{"stroke-width": "1.2"})
            self.path(_path(ellipse(0, 0, shape.size, float(minor))), look, turned + self.frame)
            return
        elif shape.kind == "sign":
            outline = [(verb, [(x + u, y + v) for u, v in points]) for verb, points in curves(shape.sign)]
            tag, width = "path", 1.0
        else:
            outline, tag, width = _outline(shape, flat), "path", shape.size
        self.path(_path(outline), look_of(tag, shape.look, self.scheme, **{"stroke-width": f"{width:.2f}"}), self.frame)

    def label(self, one: Put, moment: float) -> None:
        """Draw a name, in front of an edge of paper, and the line that leads to it."""
        from matplotlib.path import Path
        from matplotlib.transforms import Affine2D

        x, y = (float(one) for one in between(one.label.at, moment))
        frame = Affine2D().translate(x, y) + self.frame
        if one.leader is not None:
            ends = [(float(u), float(v)) for u, v in one.leader]
            look = look_of("path", "leader", self.scheme, **{"stroke-width": "0.9"})
            self.path(_path([("M", ends[:1]), ("L", ends[1:])]), look, frame)
        text = one.label.text
        found = outlined(text)
        if len(found.vertices):
            letters = Path(found.vertices + one.offset + [0, lowered(text)], found.codes)
            paper = SCHEMES[self.scheme]["paper"]
            self.path(letters, {"fill": "none", "stroke": paper, "stroke-width": f"{HALO:g}"}, frame)
            fill = look_of("text", one.label.look, self.scheme)["fill"]
            self.path(letters, {"fill": fill, "stroke": "none"}, frame)

    def path(self, path: Any, look: dict[str, str], frame: Any) -> None:
        """Draw a path as it looks."""
        from matplotlib.colors import to_rgb

        fill, stroke = look.get("fill", "none"), look.get("stroke", "none")
        pen = self.renderer.new_gc()
        pen.set_antialiased(True)
        pen.set_snap(False)
        pen.set_joinstyle("round")
        pen.set_capstyle("round" if look.get("stroke-linecap") == "round" else "butt")
        pen.set_linewidth(0.0 if stroke == "none" else float(look.get("stroke-width", "1")) * self.scale)
        if stroke != "none":
            pen.set_foreground(stroke)
            dash = look.get("stroke-dasharray", "none")
            if dash != "none":
                pen.set_dashes(0, [float(part) * self.scale for part in dash.split()])
        inside = None if fill == "none" else (*to_rgb(fill), float(look.get("fill-opacity", "1")))
        if inside is not None or stroke != "none":
            self.renderer.draw_path(pen, path, frame, inside)
        pen.restore()


def between(rows: Array, moment: float) -> Array:
    """Return a row of an array, or one between two of them; what does not move has one row."""
    last = len(rows) - 1
    before = min(int(moment), last)
    share = moment - int(moment)
    if share == 0 or before == last:
        return np.asarray(rows[before])
    return np.asarray(rows[before] * (1 - share) + rows[before + 1] * share)


def _outline(shape: Shape, flat: Array) -> list[Curve]:
    found: list[Curve] = []
    first = 0
    for count in shape.parts:
        points = [(float(x), float(y)) for x, y in flat[first : first + count]]
        found += [("M", points[:1]), *(("L", [point]) for point in points[1:])]
        found += [("Z", [])] if shape.closed else []
        first += count
    return found


def _path(outline: list[Curve]) -> Any:
    from matplotlib.path import Path

    codes = {"M": Path.MOVETO, "L": Path.LINETO, "C": Path.CURVE4}
    vertices: list[tuple[float, float]] = []
    verbs: list[Any] = []
    for verb, points in outline:
        vertices += points or [(0.0, 0.0)]
        verbs += [codes[verb]] * len(points) if points else [Path.CLOSEPOLY]
    return Path(vertices, verbs)


File = str | PathLike[str]

PICTURES: Mapping[str, Callable[[Drawing, str, str], Contents]] = {
    ".svg": lambda drawing, text, scheme: text,
    ".pdf": lambda drawing, text, scheme: painted(drawing, "pdf", scheme),
    ".png": lambda drawing, text, scheme: painted(drawing, "png", scheme),
}
"""Contents of a file by its ending, of a drawing, its SVG text and a colour scheme."""


def check_picture(file: File) -> Path:
    """Return the path of a picture.

    Raises:
        DrawError: an ending that no picture has, or what paints it is not installed.
    """
    path = Path(fspath(file))
    if path.suffix.lower() not in PICTURES:
        raise DrawError(f"{path}: pictures are written to {', '.join(PICTURES)} files")
    if path.suffix.lower() != ".svg":
        require(f"pictures in {path.suffix.lower()} files", "matplotlib")
    return path


def write_picture(file: File, drawing: Drawing, text: str, scheme: str) -> None:
    """Write a drawing, whose SVG text is `text`, to a .svg, .pdf or .png file, all of it or nothing.

    Raises:
        DrawError: another ending, no matplotlib, or a file that cannot be written.
    """
    path = check_picture(file)
    write_whole(path, PICTURES[path.suffix.lower()](drawing, text, scheme))


def write_whole(path: Path, contents: Contents) -> None:
    """Write a file, all of it or nothing.

    Raises:
        DrawError: it cannot be written, and why.
    """
    try:
        write({path.name: contents}, path.parent)
    except EmitError as fault:
        raise DrawError(str(fault)) from None
