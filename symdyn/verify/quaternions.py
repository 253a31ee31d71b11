"""Claims about quaternions hold on the unit sphere: there they are compared.

    e = u² / |u|²    is a unit quaternion for any u, rational in its four numbers

so that a field or a random point, which know no unit length, can be asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.dynamics.mechanism import quaternions
from symdyn.graph import Expr, Graph, reachable, substitute
from symdyn.scene import Scene
from symdyn.verify.equality import Claim


def on_unit_sphere(scene: Scene, claims: Sequence[Claim]) -> list[Claim]:
    """Return the claims with u² / |u|² in place of every quaternion of the scene, u named as it was."""
    groups = quaternions(scene)
    return [_on_sphere(claim, groups) for claim in claims] if groups else list(claims)


def _on_sphere(claim: Claim, groups: Sequence[tuple[str, ...]]) -> Claim:
    left, right = (_substituted(side, groups) for side in (claim.left, claim.right))
    return replace(claim, left=left, right=right)


def _substituted(entries: Sequence[Expr], groups: Sequence[tuple[str, ...]]) -> tuple[Expr, ...]:
    if not entries:
        return ()
    values: dict[Expr, Expr] = {}
    names = {node.value for node in reachable(entries)}
    for group in groups:
        if names.intersection(group):
            values |= _unit(entries[0].graph, group)
    return tuple(substitute(entries, values))


def _unit(graph: Graph, names: tuple[str, ...]) -> dict[Expr, Expr]:
    """Return u² / |u|² for u = (w, x, y, z)."""
    u = [graph.symbol(name) for name in names]
    w, x, y, z = u
    square = w * w + x * x + y * y + z * z
    e = ((w * w - x * x - y * y - z * z) / square, *(2 * w * part / square for part in (x, y, z)))
    return dict(zip(u, e, strict=True))
