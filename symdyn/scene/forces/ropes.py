"""Ropes: through points of bodies and around wheels, of a length that they keep, or elastic.

A rope has no mass and slides without friction through its points and around its wheels, so that its tension is the
same everywhere. Where it does not slip on a wheel, it is two ropes that end there. It pulls and never pushes: the
equations are those of a taut rope, and runs tell where it would push, but of one that may be slack, which is a contact
whose gap is what its places leave of its length.

    L     length: straight parts from tangent point to tangent point, and r · (wrap angle) around every wheel
    T     tension, N: the multiplier of length - L = 0, or the law of a spring by L, beside which damping may stand
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.frozen import dataclass, replace
from symdyn.scene.forces.applied_forces import DAMPER, SPRING, Damper, Spring
from symdyn.scene.forces.attachments import End, Through
from symdyn.scene.forces.force_kind import ForceKind, Hold
from symdyn.scene.forces.unilateral import RESTITUTION, check_law
from symdyn.scene.values.entry import Entry, Number, entry
from symdyn.scene.values.joint import Place, Row
from symdyn.scene.values.key import Stand, number
from symdyn.scene.values.quantity import Quantity, spell
from symdyn.scene.values.unilateral import Unilateral


@dataclass(frozen=True)
class Rope(Row):
    """A rope that keeps its length along the places that it runs through: a constraint on positions."""

    ends: tuple[Place, ...] = ()  # the places, points or wheels, in its order
    length: Quantity = Quantity.ZERO  # from the first of them to the last, m

    kind = "rope"
    is_taut = True


def _route(ends: Sequence[Place]) -> str:
    """Return the bodies that a rope runs along."""
    return ", ".join(f"{end.body} (r = {spell(end.radius)})" if end.turn else end.body for end in ends)


ROPE = ForceKind(
    section="ropes",
    noun=Rope,
    letter="c",
    parts=(
        Through(),
        number(
            "length",
            "m",
            example="length = 2",
            above_zero="is that of no rope; give one above zero",
            letters=("L",),
            text="length of {}",
            positive=True,
            geometry=True,
        ),
    ),
    law=Hold(lambda rope: rope.length),
    law_words=lambda rope: f"keeps its length {spell(rope.length)} through {_route(rope.ends)}",
    words={"en": "rope", "sk": "lano"},
    lost="a rope, which acts in the equations",
)


@dataclass(frozen=True)
class SlackRope(Unilateral):
    """A rope that keeps no more than its length: slack, or taut with a tension that is not negative.

    Attributes:
        ends, length: as of a `Rope`; the gap is the length less what its places take, m.
    """

    ends: tuple[Place, ...] = ()
    length: Quantity = Quantity.ZERO

    kind = "slack"
    is_taut = True

    @property
    def closed(self) -> Rope:
        """The rope while it is taut."""
        return Rope(self.name, self.ends, self.length)


def _check_slack(one: SlackRope, stand: Stand) -> None:
    """Report what a contact may not have, and wheels, which a slack rope leaves."""
    check_law(one, stand)
    if any(end.turn for end in one.ends):
        stand.fault("a rope that may be slack leaves a wheel, and its length jumps there; let it run through points")


SLACK = replace(
    ROPE,
    noun=SlackRope,
    letter="k",
    parts=(*ROPE.parts, RESTITUTION),
    law_words=lambda rope: f"{ROPE.law_words(rope)} at most, restitution {spell(rope.restitution)}",
    words={"en": "rope that may be slack", "sk": "lano, ktoré sa môže uvoľniť"},
    check=_check_slack,
)


@dataclass(frozen=True)
class ElasticRope(Spring):
    """A rope that pulls as a spring does by its length; see `Spring`."""

    kind = "elastic"
    is_taut = True


ELASTIC = replace(
    SPRING,
    section="ropes",
    noun=ElasticRope,
    letter="e",
    parts=(Through(), *SPRING.parts[1:]),
    words={"en": "elastic rope", "sk": "pružné lano"},
    lost=ROPE.lost,
)


@dataclass(frozen=True)
class RopeDamping(Damper):
    """What resists the rate of the length of a rope, beside the rope itself; see `Damper`."""

    kind = "damping"


DAMPING = replace(
    DAMPER,
    section="ropes",
    noun=RopeDamping,
    letter="d",
    parts=(Through(), *DAMPER.parts[1:]),
    words={"en": "damping of a rope", "sk": "tlmenie lana"},
    lost=ROPE.lost,
)


def rope(name: str, through: Sequence[End], length: Number, restitution: Number | None = None, text: str = "") -> Entry:
    """Declare a rope that keeps its length, or, with a restitution, one that may be slack.

    Args:
        name: of the rope.
        through: the places that it runs through, each the name of a body or point, {"body": name, "at": [x, y, z]}, or
            a wheel {"body": name, "at": centre, "radius": r, "axis": [0, 0, 1], "turn": "left" or "right"}.
        length: from the first place to the last, m.
        restitution: 0 to 1, with which it becomes taut.
        text: a description, as of `spring`.
    """
    return entry("ropes", type=None if restitution is None else "slack", **locals())


def elastic_rope(
    name: str,
    through: Sequence[End],
    *,
    stiffness: Number | Sequence[Number] | None = None,
    free: Number | None = None,
    preload: Number | None = None,
    text: str = "",
) -> Entry:
    """Declare a rope that pulls as `spring` does by its length along the places of `rope`."""
    check_arguments(elastic_rope, locals(), SceneError)
    return entry("ropes", type="elastic", **locals())


def rope_damping(name: str, through: Sequence[End], damping: Number | Sequence[Number], text: str = "") -> Entry:
    """Declare what resists the rate of the length along the places of `rope`, as `damper` does."""
    return entry("ropes", type="damping", **locals())
