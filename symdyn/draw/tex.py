r"""Pictures for pdfTeX: shapes by \pdfliteral in the colours of its style sheet, labels set by TeX.

Read are paths of M, L, V, A (a quarter turn) and Z, circles, ellipses and labels, which is what `svg` writes. Outlines
become moves, lines and cubic curves, for programs that know no circles.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterator
from xml.etree.ElementTree import Element

from defusedxml import ElementTree

from symdyn.draw.style import Look, look_of
from symdyn.emit import in_latex

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
    """Return a label: runs on the line, below and above it."""
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
