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
"""

from __future__ import annotations

from dataclasses import replace

from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.spatial import Mat, Transform, add


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
