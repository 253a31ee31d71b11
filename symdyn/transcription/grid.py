"""Where the unknowns of a problem stand in one vector z, and the equations in another.

node     an end of an interval, N + 1 of them
stage    a place where the dynamics holds
point    a node or a stage, P of them, in the order of time

z = [q of all points | u of all points | a, λ, τ of all stages | slacks of all nodes but the first | p | T]
g = [balance of all stages | defects of q, then of u, of each interval | held of all nodes | path of all nodes]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.transcription.tableaux import Method

Places = NDArray[np.int64]
"""Indices."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Points, nodes and stages of a mesh, and how they hang together.

    Attributes:
        widths: h_n / T of every interval, shape (N,).
        share: t / T of every point, shape (P,).
        node: points that are nodes, shape (N + 1,).
        stage: points that are stages, shape (S,).
        of: of[n, j] is the stage, among the stages, that stage j of interval n is; shape (N, s).
        target: target[n, r] is the point that defect r of interval n ends at, the end last; shape (N, R).
        weights: weights[r, j] of stage j in defect r, shape (R, s).
        quadrature: weight of every stage in an integral, over T; shape (S,).
    """

    widths: Array
    share: Array
    node: Places
    stage: Places
    of: Places
    target: Places
    weights: Array
    quadrature: Array


def grid(method: Method, mesh: Array) -> Grid:
    """Return the grid of a method over a mesh of rising shares of time, 0 … 1."""
    count, inner, s = len(mesh) - 1, list(method.inner), len(method.c)
    step = len(inner) + 1
    widths = np.diff(mesh)
    node = step * np.arange(count + 1)
    between = node[:-1, None] + 1 + np.arange(len(inner))
    places = {i: between[:, k] for k, i in enumerate(inner)}
    places |= {0: node[:-1]} if method.starts else {}
    places |= {s - 1: node[1:]} if method.ends else {}
    at = np.stack([places[j] for j in range(s)], axis=1)
    stage = np.unique(at)
    of = np.searchsorted(stage, at)
    c, b = (np.array([float(x) for x in row]) for row in (method.c, method.b))
    share = np.empty(step * count + 1)
    share[node] = mesh
    share[between] = mesh[:-1, None] + widths[:, None] * c[inner]
    A = np.array([[float(x) for x in row] for row in method.A])
    quadrature = np.zeros(len(stage))
    np.add.at(quadrature, of, widths[:, None] * b)
    target = np.concatenate([between, node[1:, None]], axis=1)
    return Grid(widths, share, node, stage, of, target, np.vstack([A[inner], b]), quadrature)


def numbered(shapes: Mapping[str, tuple[int, ...]]) -> tuple[dict[str, Places], int]:
    """Return the places of parts that stand one behind the other, each of its shape, and how many there are."""
    found: dict[str, Places] = {}
    first = 0
    for name, shape in shapes.items():
        size = int(np.prod(shape))
        found[name] = np.arange(first, first + size).reshape(shape)
        first += size
    return found, first


def sliced(places: Places) -> slice | Places:
    """Return places that are equally far apart as a slice, which views and does not copy; others as they are."""
    steps = np.diff(places)
    if len(places) < 2 or np.any(steps != steps[0]):
        return places
    return slice(int(places[0]), int(places[-1]) + 1, int(steps[0]))
