"""Outlines as moves, lines and cubic curves, for programs that know no circles."""

from __future__ import annotations

import re

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
