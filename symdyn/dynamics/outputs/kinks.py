"""Where a function has a kink, in words: behind the text of its derivatives, which are one-sided there or none."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from symdyn.graph import Expr, Op, reachable
from symdyn.scene.values import listed

MOST = 6
"""Names that are told of one kink."""


def kinks(entries: Sequence[Expr], varied: Collection[Expr]) -> str:
    """Return what the text of derivatives says of signs, absolute values, roots and angles; "" without such."""
    moving = set(varied)
    below = _below(entries, moving)
    jumps = [node.args[0] for node in below if node.op in (Op.SIGN, Op.ABS)]
    roots = [node.args[0] for node in below if node.op is Op.SQRT]
    angles = [node for node in below if node.op is Op.ATAN2]
    words = []
    if jumps:
        words.append(
            f"one-sided where a sign or an absolute value turns over, of {_names(jumps, moving)}: there a sign is "
            "taken for constant, an absolute value for flat"
        )
    if roots:
        words.append(f"no number (NaN) where a root vanishes, of {_names(roots, moving)}")
    if angles:
        words.append(f"no number (NaN) where both sides of an atan2 vanish, of {_names(angles, moving)}")
    return "".join(f"; {one}" for one in words)


def _below(entries: Sequence[Expr], varied: Collection[Expr]) -> list[Expr]:
    """Return the nodes that vary."""
    found: dict[Expr, None] = {}
    for node in reachable(entries):
        if node in varied or any(arg in found for arg in node.args):
            found[node] = None
    return list(found)


def _names(of: Iterable[Expr], varied: Collection[Expr]) -> str:
    groups = dict.fromkeys(tuple(sorted(str(x.value) for x in reachable([node]) if x in varied)) for node in of)
    return listed([" and ".join(group) if len(group) < 3 else f"({', '.join(group[:MOST])})" for group in groups], MOST)
