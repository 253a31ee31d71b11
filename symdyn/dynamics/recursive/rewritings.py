"""Origins at rest: a frame whose axis passes through a point that no joint moves has its origin there.

Factored links put the origin of a frame where the next axis comes nearest, at the link's rise r along its own axis. If
the axis meets all axes below in one point, as in a shoulder of two or three joints, the origin waits in that point and
the next link is shifted along z as well:

    Rz(θ) Tz(r) | Tx(d) Rx(α)        Rz(θ) | Tz(r) Tx(d) Rx(α)

Gravity alone accelerates such an origin, and nobody asks for the force there.

Gain (operations; ns one state a call, a state of a batch), where first axes meet in a point:

                          arm7                    chain8             puma560
    inverse dynamics      -1.5 %; -2 %, -1 %      -1.2 %; -1 %,  0     0
    forward dynamics      -1.0 %; -3 %, -1 %      -0.7 %; +1 %, +1 %   0

Last bodies of branches in axes that do not turn with their joints.

The recursions turn ω, U z and the acceleration into a body's axes and its wrench out of them again, for 20
multiplications, and five products of ω are new there. In axes that stay with the parent's, h and J of the last body
turn in their place, for 12, and three products are new. Where a turn would fill more than one pair of zeros among both,
as with diagonal inertias and a mass centre on an axis, it costs more: such a body is left as it is.

Gain (operations; ns one state a call, a state of a batch):

                          puma560                  arm7                 chain8
    inverse dynamics      -5.9 %; -18 %, -14 %     -2.5 %; -3 %, -1 %   -1.9 %;  0,   -1 %
    forward dynamics      -3.9 %; -22 %, -10 %     -3.7 %; -3 %, -1 %   -2.5 %; -5 %,  0
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.dynamics.recursive.links import Moments
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.spatial import Mat, Transform, Wrench, add


def resting(tree: ReducedTree) -> ReducedTree:
    """Return the tree with origins at rest wherever an axis has such a point."""
    link, body, moved, zero = list(tree.link), list(tree.body), list(tree.moved), tree.graph.zero
    rests = [True]
    for i in tree.outward():
        p, (x, y, z) = tree.parent[i], link[i].shift
        on_axis = not tree.parent[p]  # the ground, and the axis of its joint, on which all points rest
        rests.append(
            not tree.slides[i] and (not p or (rests[p] and x.is_zero and y.is_zero and (on_axis or z.is_zero)))
        )
        rise = (zero, zero, link[i].rise)
        if not p or not rests[i] or rise[2].is_zero:
            continue
        link[i], body[i] = replace(link[i], rise=zero), body[i].shifted(rise)
        moved[i] = moved[i] @ Transform(Mat.identity(tree.graph), (zero, zero, -rise[2]))
        for k in tree.outward():
            if tree.parent[k] == i:
                link[k] = replace(link[k], shift=add(link[k].shift, rise))
    return replace(tree, link=tuple(link), body=tuple(body), moved=tuple(moved))


def held_tips(tree: ReducedTree) -> ReducedTree:
    """Return the tree with last bodies in axes that do not turn with their joints, where that pays."""
    body, link = list(tree.body), list(tree.link)
    for i in _tips(tree):
        body[i], link[i] = link[i].turn.moments_back(body[i]), link[i].at_rest(False)
    return replace(tree, body=tuple(body), link=tuple(link))


def in_held_axes(tree: ReducedTree, acting: Sequence[Wrench]) -> list[Wrench]:
    """Return what acts on the bodies of a tree in the axes of `held_tips`."""
    found = list(acting)
    for i in _tips(tree):
        (force, moment), turn = found[i], tree.link[i].turn
        found[i] = Wrench(turn.back(force), turn.back(moment))
    return found


def _tips(tree: ReducedTree) -> list[int]:
    """Return the last bodies that pay."""
    tips = sorted(set(tree.outward()).difference(tree.parent))
    return [i for i in tips if not tree.slides[i] and _turns_lightly(tree.body[i])]


def _turns_lightly(body: Moments) -> bool:
    """Tell whether a turn about z fills at most one pair of zeros among h and J."""
    (x, y, _), ((xx, xy, xz), (_, yy, yz), _) = body.h, body.J
    filled = (x.is_zero != y.is_zero, xz.is_zero != yz.is_zero, xy.is_zero and xx is not yy)
    return sum(filled) < 2
