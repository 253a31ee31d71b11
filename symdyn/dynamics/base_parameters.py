"""The base parameters of a scene by name: what its driving forces depend on, as formulas of the declared inertias.

    revolute joint k     mxR<k>, myR<k>                     first moments
                         XXR<k>                             I_xx - I_yy
                         XYR<k>, XZR<k>, YZR<k>, ZZR<k>     entries of the inertia matrix
    prismatic joint k    MR<k>, mxR<k>, myR<k>, mzR<k>      mass and first moments

They refer to the frames that the generator chose (`LeanTree.moved` tells where they are). Parameters that no driving
force depends on are left out, such as all but ZZR of a first joint that turns about the direction of gravity.

Reference: Gautier and Khalil 1990; Khalil and Dombre (2002), section 9.4.
"""

from __future__ import annotations

from dataclasses import replace

from symdyn.dynamics.moments import Moments
from symdyn.dynamics.reframe import LeanTree
from symdyn.dynamics.rnea import rnea
from symdyn.dynamics.workspace import Workspace
from symdyn.graph import Expr, gradient
from symdyn.scene import Scene
from symdyn.spatial import symmetric

Named = tuple[str, Expr]


def base_parameters(scene: Scene) -> tuple[Named, ...]:
    """Return name and formula of every base parameter, the ground's side first; kg, kg m and kg m^2.

    No driving force depends on anything else. On some arms with special lengths the number can be one or two smaller
    still; for the PUMA 560 these are its 36.
    """
    w = Workspace(scene)
    marked, marks = _marked(w.lean)
    slopes = [gradient(tau, [mark for body in marks for mark in body]) for tau in rnea(marked, w.state.qd, w.state.qdd)]
    columns = iter(zip(*slopes, strict=True))
    found: list[Named] = []
    for k, mark in enumerate(marks, start=1):
        felt = [next(columns) for _ in mark]
        body, slides = w.lean.body[k], w.lean.slides[k]
        found += [pair for pair, needed in zip(_named(body, k, slides), _needed(felt, slides), strict=True) if needed]
    return tuple((name, value) for name, value in found if not value.is_zero)


def _named(body: Moments, k: int, slides: bool) -> list[Named]:
    (xx, xy, xz), (_, yy, yz), _ = body.J
    moments = [(f"m{axis}R{k}", h) for axis, h in zip("xyz", body.h, strict=True)]
    if slides:
        return [(f"MR{k}", body.m), *moments]
    inertia = [("XX", yy - xx), ("XY", -xy), ("XZ", -xz), ("YZ", -yz), ("ZZ", xx + yy)]
    return [*moments[:2], *((f"{name}R{k}", value) for name, value in inertia)]


def _needed(felt: list[tuple[Expr, ...]], slides: bool) -> list[bool]:
    """Return which parameters of `_named` matter, from the slopes of all driving forces along each mark.

    J_xx and J_yy that are felt alike are felt through their sum ZZ only.
    """
    some = [any(not slope.is_zero for slope in slopes) for slopes in felt]
    if slides:
        return some
    x, y, xx, yy, xy, xz, yz = some
    return [x, y, felt[2] != felt[3], xy, xz, yz, xx or yy]


def _marked(tree: LeanTree) -> tuple[LeanTree, list[list[Expr]]]:
    """Return the tree with a symbol for every entry of its bodies, and these symbols."""
    graph, zero = tree.graph, tree.graph.zero
    bodies, marks = [tree.body[0]], []
    for i in tree.outward():
        m, x, y, z, xx, yy, xy, xz, yz = (graph.symbol(f"mark {i} {k}") for k in range(9))
        if tree.slides[i]:
            bodies.append(Moments(m, (x, y, z), symmetric(*(zero,) * 6)))
            marks.append([m, x, y, z])
        else:
            bodies.append(Moments(zero, (x, y, zero), symmetric(xx, yy, zero, xy, xz, yz)))
            marks.append([x, y, xx, yy, xy, xz, yz])
    return replace(tree, body=tuple(bodies)), marks
