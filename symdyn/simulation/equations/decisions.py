"""What numbers decide about closed mechanisms before their equations are written, at values of the parameters.

Decisions are made at assembled positions. Where the start is given for other values, nothing is assembled: it is looked
whether the decisions hold there and a step away from there, and only where they may not are they made anew.
"""

from __future__ import annotations

from functools import lru_cache

from symdyn.dynamics.outputs import WrittenDecisions
from symdyn.scene import Scene
from symdyn.simulation.equations.parametrised import opened


@lru_cache(maxsize=16)
def written_decisions(scene: Scene) -> WrittenDecisions:
    """Return what is decided about the loops and rows of a scene at its values; nothing of a tree.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    if not scene.is_closed:
        return WrittenDecisions()
    return WrittenDecisions.of(opened(scene).numbers(), opened(scene).closing)
