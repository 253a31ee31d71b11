"""Where a tree is cut: joints that close loops, and contacts of blades, wheels and balls with a plane.

    J     joint frame on the parent; for a contact it stands in a point of the plane, axes of the body that carries it
    X     placement of the frame at P, on the child, in J; P is the blade's point, or the centre of a wheel

A wrench (force, moment) acts at P, axes of J.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symdyn.algebra import TrigonometricRing
from symdyn.dynamics.mechanism.placements import body_placements
from symdyn.dynamics.mechanism.state import vector
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Contact, Joint
from symdyn.spatial import Mat, Transform, Wrench, dot

FLAT = 1e-3
"""Sine of the angle between axis and normal of a wheel that lies flat."""


@dataclass(frozen=True)
class Cut:
    """One cut.

    Attributes:
        owner: name of the loop or of the row.
        parent, child: bodies; what carries the plane is the parent of a contact.
        before: placement of J in the parent.
        behind: placement of the frame at P in the child.
        wrenches: what the parent can exert on the child without working, as functions of X.
        residual: likewise what vanishes where the row is kept; zero for a row that does not close.
        closes: for each wrench whether it holds a position, so that its residual means something.
        joint: the joint that closes the loop; None for a contact.
        names: of a contact's wrenches, in words; "" where a direction says it.
    """

    owner: str
    parent: str
    before: Transform
    child: str
    behind: Transform
    wrenches: Callable[[Transform], tuple[Wrench, ...]]
    residual: Callable[[Transform], tuple[Expr, ...]]
    closes: tuple[bool, ...]
    joint: Joint | None
    names: tuple[str, ...] = ()


def cuts(scene: Scene, graph: Graph) -> list[Cut]:
    """Return the cut joints of a scene, and its contacts."""
    return [*(_joint(joint, graph) for joint in scene.loops), *(contact(row, graph) for row in scene.contacts)]


def _joint(joint: Joint, graph: Graph) -> Cut:
    kind = JOINTS[joint.type]
    forbids = kind.forbids
    assert forbids, "the scene's check refuses loops of joints that forbid what has no formula"
    return Cut(
        joint.name,
        joint.parent,
        joint.origin.transform(graph),
        joint.child,
        joint.tip.transform(graph).inverse(),
        lambda X: forbids.wrenches(joint, X),
        lambda X: forbids.residual(joint, X),
        (True,) * kind.class_t(joint),
        joint,
    )


def contact(row: Contact, graph: Graph) -> Cut:
    """Return the cut that a contact makes."""
    law = FORCES[row.kind].touch
    closes = law.closes(row)
    return Cut(
        row.name,
        row.plane.body,
        Transform(Mat.identity(graph), vector(row.plane.at, graph)),
        row.place.body,
        Transform(Mat.identity(graph), vector(row.place.at, graph)),
        lambda X: law.wrenches(row, X, sine(row, X)),
        lambda X: tuple(law.height(row, X, sine(row, X)) if one else graph.zero for one in closes),
        closes,
        None,
        law.words(row),
    )


def sine(row: Contact, X: Transform) -> Expr:
    """Return w of a contact; 1 where a wheel stands upright whatever it does, which the ring decides exactly."""
    graph, lean = X.p[0].graph, FORCES[row.kind].touch.lean(row, X)
    if lean is None:
        return graph.one
    square = dot(lean, lean)
    try:
        ring = TrigonometricRing([square])
        (value,) = evaluate([square], ring, ring.values([square]))
    except DerivationError:  # a motion that is no trigonometric polynomial
        return graph.sqrt(square)
    return graph.one if ring.is_zero(value - 1) else graph.sqrt(square)


@dataclass(frozen=True)
class Gauge:
    """A contact: height of its lowest point, m, and sine of the angle of a wheel's axis and the normal, else 1."""

    row: Contact
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

    def is_flat(self, sine: float) -> bool:
        """Whether a wheel lies flat where the sine has a value."""
        return sine < FLAT

    @property
    def _parallel(self) -> str:
        body = self.row.place.body
        return f"{body} lies flat on its plane, its axis along the normal, so that no point of its rim is the lowest"


def gauges(scene: Scene, graph: Graph) -> tuple[Gauge, ...]:
    """Return the gauges of all contacts of a scene."""
    placed = body_placements(scene, graph) if scene.contacts else {}
    found = []
    for row in scene.contacts:
        cut, law = contact(row, graph), FORCES[row.kind].touch
        X = (placed[cut.parent] @ cut.before).inverse() @ placed[cut.child] @ cut.behind
        w = sine(row, X)
        found.append(Gauge(row, law.height(row, X, w), w))
    return tuple(found)
