r"""A drawing for programs that know no SVG: painted by matplotlib's renderers, or a picture of pdfTeX.

Outlines become moves, lines and cubic curves. Painted are PNG, PDF, and the frames of a film. Shapes are ours, dot for
dot as SVG. Between two moments a shape is where the straight way between both leads, as it is where SVG moves by
itself. A file's ending says what it is: SVG as it is returned, PDF and PNG painted.

For pdfTeX shapes are drawn by \pdfliteral in the colours of its style sheet, and labels set by TeX. Read are paths of
M, L, V, A (a quarter turn) and Z, circles, ellipses and labels, which is what `svg` writes.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Callable, Iterator, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from defusedxml import ElementTree

from symdyn.draw.places import Array, Put
from symdyn.draw.plots import import_matplotlib, outlined, require, saved, settings
from symdyn.draw.shapes import Shape
from symdyn.draw.style import SCHEMES, Look, look_of, lowered, plain
from symdyn.draw.svg import Drawing, order
from symdyn.emit import Contents, in_latex, write_file
from symdyn.errors import DrawError

KAPPA = 0.5523  # control points of a quarter circle
Curve = tuple[str, list[tuple[float, float]]]
"""M, L, C or Z, and the points that follow it: one, one, three, none."""


def ellipse(x: float, y: float, a: float, b: float) -> list[Curve]:
    """Return an ellipse around a point, with half its width and half its height."""
    found: list[Curve] = [("M", [(x + a, y)])]
    for p, q, u, v in ((1, 0, 0, 1), (0, 1, -1, 0), (-1, 0, 0, -1), (0, -1, 1, 0)):
        ends = [(p + KAPPA * u, q + KAPPA * v), (u + KAPPA * p, v + KAPPA * q), (u, v)]
        found.append(("C", [(x + a * i, y + b * j) for i, j in ends]))
    return [*found, ("Z", [])]


def curves(d: str) -> list[Curve]:
    """Return a path of M, L, V, A (a quarter turn about (0, 0)) and Z, which is what pictures are written with."""
    found: list[Curve] = []
    x = y = 0.0
    for verb, rest in re.findall(r"([MLVAZ])([^MLVAZ]*)", d):
        values = [float(one) for one in rest.replace(",", " ").split()]
        if verb == "Z":
            found.append(("Z", []))
        elif verb == "A":
            u, v = values[5], values[6]
            found.append(("C", [(x + KAPPA * u, y + KAPPA * v), (u + KAPPA * x, v + KAPPA * y), (u, v)]))
            x, y = u, v
        else:
            x, y = (x, values[0]) if verb == "V" else (values[0], values[1])
            found.append(("M" if verb == "M" else "L", [(x, y)]))
    return found


WIDTH, HEIGHT = 300.0, 230.0  # bp, at most
SCALE = 0.62  # bp a unit, at most: labels are 17 units high
SVG = "{http://www.w3.org/2000/svg}"
Point = tuple[float, float]


def tex_picture(svg: str) -> str:
    """Return a picture environment."""
    root = ElementTree.fromstring(svg)
    left, top, width, height = map(float, root.attrib["viewBox"].split())
    scale = min(SCALE, WIDTH / width, HEIGHT / height)
    shapes: list[str] = []
    labels: list[str] = []
    for element, (dx, dy) in _walk(root, (0.0, 0.0)):
        own = {name: element.attrib[name] for name in ("stroke-width",) if name in element.attrib}
        look = look_of(element.tag.removeprefix(SVG), element.attrib.get("class", ""), **own)
        if element.tag == f"{SVG}text":
            x, y = float(element.attrib["x"]) + dx, float(element.attrib["y"]) + dy
            place = f"{scale * (x - left):.2f},{scale * (top + height - y):.2f}"
            colour = look.get("fill", "#000000")[1:].upper()
            labels.append(rf"\put({place}){{\hbox to 0pt{{\hss\color[HTML]{{{colour}}}{_label(element)}\hss}}}}")
        elif element.tag.removeprefix(SVG) in ("path", "circle", "ellipse"):
            shapes.append(_shape(element, look, (dx, dy)))
    frame = f"{scale:.4f} 0 0 {-scale:.4f} {-scale * left:.2f} {scale * (top + height):.2f} cm"
    drawn = "\n".join(one for one in shapes if one)
    body = "\n".join([rf"\put(0,0){{\pdfliteral{{q {frame} 1 j", drawn, "Q}}", *labels])
    size = f"({scale * width:.1f},{scale * height:.1f})"
    return f"{{\\setlength{{\\unitlength}}{{1bp}}\\begin{{picture}}{size}\n{body}\n\\end{{picture}}}}"


def _walk(element: Element, shift: Point) -> Iterator[tuple[Element, Point]]:
    """Yield every element with the translation that it stands in."""
    moved = re.match(r"translate\(([-\d.]+) ([-\d.]+)\)", element.attrib.get("transform", ""))
    if moved and element.tag in (f"{SVG}g", f"{SVG}path", f"{SVG}ellipse"):
        shift = (shift[0] + float(moved[1]), shift[1] + float(moved[2]))
    yield element, shift
    for child in element:
        yield from _walk(child, shift)


# Shapes


def _shape(element: Element, look: Look, shift: Point) -> str:
    fill, stroke = look.get("fill", "none"), look.get("stroke", "none")
    if fill == stroke == "none":
        return ""
    paint = {(True, True): "B", (True, False): "f", (False, True): "S"}[fill != "none", stroke != "none"]
    cap = 1 if look.get("stroke-linecap") == "round" else 0
    dash = look.get("stroke-dasharray", "none")
    state = [f"{float(look.get('stroke-width', '1')):.2f} w {cap} J [{'' if dash == 'none' else dash}] 0 d"]
    state += [f"{_colour(fill)} rg"] if fill != "none" else []
    state += [f"{_colour(stroke)} RG"] if stroke != "none" else []
    return " ".join(["q", f"1 0 0 1 {shift[0]:.2f} {shift[1]:.2f} cm", *state, _way(element), paint, "Q"])


def _colour(text: str) -> str:
    return " ".join(f"{int(text[k : k + 2], 16) / 255:.3f}" for k in (1, 3, 5))


def _way(element: Element) -> str:
    read = element.attrib
    if element.tag == f"{SVG}path":
        return _told(curves(read["d"]))
    if element.tag == f"{SVG}circle":
        r = float(read["r"])
        return _told(ellipse(float(read["cx"]), float(read["cy"]), r, r))
    turned = re.search(r"rotate\(([-\d.]+)\)", read.get("transform", ""))
    angle = math.radians(float(turned[1])) if turned else 0.0
    c, s = math.cos(angle), math.sin(angle)
    return f"{c:.4f} {s:.4f} {-s:.4f} {c:.4f} 0 0 cm {_told(ellipse(0, 0, float(read['rx']), float(read['ry'])))}"


# An outline is told by the same letters in both languages, but for their place.
OPERATORS = {"M": "m", "L": "l", "C": "c", "Z": "h"}


def _told(outline: list[Curve]) -> str:
    return " ".join(" ".join([*(f"{x:.2f} {y:.2f}" for x, y in points), OPERATORS[verb]]) for verb, points in outline)


# Labels


def _label(element: Element) -> str:
    runs = [("", 0, element.text or "")]
    level = 0.0
    for child in element:
        level += float(child.attrib.get("dy", 0))
        lowered = 0 if "font-size" not in child.attrib else -1 if level > 0 else 1
        runs.append((child.attrib.get("class", ""), lowered, child.text or ""))
        runs.append(("", 0, child.tail or ""))
    text = ""
    for face, lowered, piece in runs:
        if piece:
            shown = _run(face, piece)
            text += f"{{}}{'_' if lowered < 0 else '^'}{{{shown}}}" if lowered else shown
    return f"${text}$"


def _run(face: str, piece: str) -> str:
    if face == "i" or (len(piece) == 1 and not piece.isascii()):
        return "".join(map(_sign, piece))
    if face == "t":
        return rf"\mathtt{{{in_latex(piece)}}}"
    return piece if re.fullmatch(r"[\d.,+ ]*", piece) else rf"\textrm{{{in_latex(piece)}}}"


def _sign(character: str) -> str:
    name = unicodedata.name(character, "")
    greek = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", name)
    if greek:
        word = greek[2].lower().replace("lamda", "lambda")
        return f"\\{word if greek[1] == 'SMALL' else word.capitalize()} "
    marks = {"·": r"\cdot ", "−": "-", "°": r"^{\circ}", "×": r"\times "}
    return marks.get(character, character if character.isascii() else "")


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
    if drawing.camera is not None:
        x, y = (float(one) for one in between(drawing.camera, moment))
        left, top = left + x, top + y
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
    """Return the path of a picture; DrawError of an ending that no picture has, or what paints it is not installed."""
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
    write_file(path, PICTURES[path.suffix.lower()](drawing, text, scheme), DrawError)
