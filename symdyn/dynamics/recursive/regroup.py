"""Inertia that a joint cannot feel goes to the body that carries it: fewer parameters, the same motion.

    revolute    what lies on the axis: m, h_z and J_zz
    prismatic   everything that turns only: J

The rest is what the equations of motion depend on, the base parameters: for a revolute joint h_x, h_y and five of J,
for a prismatic one m and h. What falls into the ground does no work, but it has a place: its constant part of P
stays in the ground's own moments, so that energies keep their values.

Reference: Gautier and Khalil, Direct calculation of minimum set of inertial parameters of serial robots, IEEE
Transactions on Robotics and Automation 6 (1990); here by second moments J in place of the inertia I = tr(J) 1 - J.
"""

from __future__ import annotations

from dataclasses import replace

from symdyn.dynamics.recursive.moments import Moments
from symdyn.dynamics.recursive.reframe import LeanTree
from symdyn.spatial import zero_vector


def regroup(tree: LeanTree) -> LeanTree:
    """Return the tree with base parameters in place of the bodies' inertias."""
    body = list(tree.body)
    for i in tree.inward():
        p = tree.parent[i]
        kept, given = split(body[i], tree.slides[i])
        body[i], body[p] = kept, body[p] + tree.link[i].at_rest(tree.slides[i]).moments_back(given)
    return replace(tree, body=tuple(body))


def split(body: Moments, slides: bool) -> tuple[Moments, Moments]:
    """Return what a joint along z feels of a body, and what it does not."""
    zero = body.m.graph.zero
    none = zero_vector(body.m.graph)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.J
    if slides:
        return Moments(body.m, body.h, (none, none, none)), Moments(zero, none, body.J)
    kept = Moments(zero, (body.h[0], body.h[1], zero), ((xx, xy, xz), (xy, yy, yz), (xz, yz, zero)))
    return kept, Moments(body.m, (zero, zero, body.h[2]), (none, none, (zero, zero, zz)))
