"""What is measured at contacts of blades, wheels and balls with their planes."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics.loops.cuts import contact, sine
from symdyn.dynamics.mechanism.placements import body_placements
from symdyn.graph import Expr, Graph
from symdyn.scene import Row, Scene
from symdyn.scene.forces import touch_of


@dataclass(frozen=True)
class Gauge:
    """One contact.

    Attributes:
        row: of the scene.
        height: of the lowest point above the plane, m.
        sine: of the angle between the axis of a wheel and the normal; 1 for a ball or a blade.
    """

    row: Row
    height: Expr
    sine: Expr

    @property
    def flat(self) -> str:
        """What is said of a start where the wheel lies flat."""
        return f"contact {self.row.name}: {self._parallel}; give a start at which it leans"

    @property
    def fell_flat(self) -> str:
        """What is said where a motion ends because the wheel lies flat."""
        return f"contact {self.row.name}: the motion came to where {self._parallel}"

    @property
    def _parallel(self) -> str:
        body = self.row.place.body if self.row.place else ""
        return f"{body} lies flat on its plane, its axis along the normal, so that no point of its rim is the lowest"


def gauges(scene: Scene, graph: Graph) -> tuple[Gauge, ...]:
    """Return the gauges of all contacts of a scene."""
    touching = [(row, law) for row in scene.rows if (law := touch_of(row)) is not None]
    placed = body_placements(scene, graph) if touching else {}
    found = []
    for row, law in touching:
        cut = contact(row, graph)
        assert cut is not None, "what touches is cut"
        X = (placed[cut.parent] @ cut.before).inverse() @ placed[cut.child] @ cut.behind
        w = sine(law, row, X)
        found.append(Gauge(row, law.height(row, X, w), w))
    return tuple(found)
