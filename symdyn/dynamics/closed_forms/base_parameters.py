"""The base parameters of a scene by name: what its driving forces depend on, as formulas of the declared inertias.

    revolute joint k     mxR<k>, myR<k>                     first moments
                         XXR<k>                             I_xx - I_yy
                         XYR<k>, XZR<k>, YZR<k>, ZZR<k>     entries of the inertia matrix
    prismatic joint k    MR<k>, mxR<k>, myR<k>, mzR<k>      mass and first moments

Bodies that have these inertias in the frames of `chosen_frames`, with I_xx = XX and m = h_z = I_yy = 0 on a revolute
joint and I = 0 on a prismatic one, move as the declared ones do. Parameters that no driving force depends on are left
out, such as all but ZZR of a first joint that turns about the direction of gravity.

    to the parent     m, h_z and diag(I_yy, I_yy, 0) of a body on a revolute joint, I of one on a prismatic joint, and
                      h_x, h_y where a prismatic joint slides along the only direction that the body can turn about

That is the choice of the literature; the recursions run over another one that is as good, J_zz = 0 in place of
I_yy = 0 (`regroup`).

Reference: Gautier and Khalil 1990; Khalil and Dombre (2002), section 9.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

from symdyn.algebra.form import ZERO, Form
from symdyn.dynamics.closed_forms.formulas import formulas
from symdyn.dynamics.mechanism.exact import settle
from symdyn.dynamics.mechanism.tree import Tree
from symdyn.dynamics.recursive.moments import Moments, moments_of
from symdyn.dynamics.recursive.reframe import LeanTree, reframe, settled
from symdyn.dynamics.recursive.rnea import rnea
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.graph import Expr, gradient
from symdyn.scene import Scene
from symdyn.spatial import Inertia, no_inertia, symmetric

TURNING = ("mx", "my", "XX", "XY", "XZ", "YZ", "ZZ")
SLIDING = ("M", "mx", "my", "mz")

DIGITS = 12


def base_parameters(scene: Scene) -> tuple[tuple[str, Expr], ...]:
    """Return name and formula of every base parameter, the ground's side first; kg, kg m and kg m^2.

    No driving force depends on anything else. On some arms with special lengths, or with a slide aslant to the one
    direction that they turn about, the number can be one or two smaller still; for the PUMA 560 these are its 36.
    """
    w = Workspace(scene)
    for parameter in scene.parameters:
        w.graph.symbol(parameter.name)  # before all else, so that forms print them in declared order
    framed = reframe(w.tree)
    names = [f"{name}R{k}" for k in framed.outward() for name in (SLIDING if framed.slides[k] else TURNING)]
    marks = [w.graph.symbol(f"mark of {name}") for name in names]
    forces = rnea(with_base_parameters(framed, marks), w.state.qd, w.state.qdd)
    columns = zip(*(gradient(force, marks) for force in forces), strict=True)
    felt = [any(not slope.is_zero for slope in column) for column in columns]
    found = zip(names, _grouped(w.tree, framed), felt, strict=True)
    return tuple((name, value) for name, value, needed in found if needed and not value.is_zero)


def base_parameter_forms(scene: Scene) -> tuple[tuple[str, Form], ...]:
    """Return the base parameters as formulas to read, collected over the ring of closed forms.

    Numbers are exact, unless an angle of the scene has no exact sine (0.3 rad): then they have 12 digits.

    Raises:
        DerivationError: a function in a formula has no place in that ring.
    """
    named = base_parameters(scene)
    forms = formulas([value for _, value in named], DIGITS)
    return tuple((name, form) for (name, _), form in zip(named, forms, strict=True) if form != ZERO)


def with_base_parameters(tree: LeanTree, values: Sequence[Expr]) -> LeanTree:
    """Return the tree with bodies of these base parameters: seven a revolute joint, four a prismatic one, all named."""
    left, zero = iter(values), tree.graph.zero
    bodies = [moments_of(no_inertia(tree.graph))]
    for k in tree.outward():
        if tree.slides[k]:
            m, x, y, z = islice(left, len(SLIDING))
            bodies.append(Moments(m, (x, y, z), symmetric(*(zero,) * 6)))
        else:
            x, y, xx, xy, xz, yz, zz = islice(left, len(TURNING))
            bodies.append(moments_of(Inertia(zero, (x, y, zero), symmetric(xx, zero, zz, xy, xz, yz))))
    return replace(tree, body=tuple(bodies))


def _grouped(tree: Tree, framed: LeanTree) -> list[Expr]:
    """Return the values of all named parameters, those that nothing depends on included."""
    body = [inertia.seen_from(settled(T.inverse())) for inertia, T in zip(tree.inertia, framed.moved, strict=True)]
    values: list[list[Expr]] = [[] for _ in body]
    for k in framed.inward():
        kept, given = _split(body[k], framed.slides[k], _slides_along_all_turns(framed, k))
        values[k], p = kept, framed.parent[k]
        body[p] = body[p] + given.seen_from(framed.link[k].at_rest(framed.slides[k]).transform)
    return [value for kept in values for value in kept]


def _split(body: Inertia, slides: bool, along_all_turns: bool) -> tuple[list[Expr], Inertia]:
    """Return the named parameters of a body, and what its parent gets."""
    zero, (x, y, z) = body.m.graph.zero, body.h
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.I
    if slides and along_all_turns:
        return [body.m, zero, zero, z], Inertia(zero, (x, y, zero), body.I)
    if slides:
        return [body.m, x, y, z], Inertia(zero, (zero, zero, zero), body.I)
    kept = [x, y, xx - yy, xy, xz, yz, zz]
    return kept, Inertia(body.m, (zero, zero, z), symmetric(yy, yy, zero, zero, zero, zero))


def _slides_along_all_turns(tree: LeanTree, k: int) -> bool:
    """Return whether every joint that turns body k has its axis along z of k, which slides."""
    axis, p = tree.link[k].axis, tree.parent[k]
    while p:
        x, y, z = settle(axis)
        if not tree.slides[p] and not (x.is_zero and y.is_zero):
            return False
        axis, p = tree.link[p].back((x, y, z)), tree.parent[p]
    return True
