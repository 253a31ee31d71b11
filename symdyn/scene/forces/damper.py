"""A viscous damper: c1 v + c3 v³ + … against the rate v of its way, at a joint or between two points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.graph import Expr
from symdyn.scene.forces.attachments import End, Ends, as_keys
from symdyn.scene.forces.force_kind import ForceKind, Mark, Pull
from symdyn.scene.values.element import Strut
from symdyn.scene.values.entry import Entry, Number, entry, shown
from symdyn.scene.values.key import Key, Stand, coefficients
from symdyn.scene.values.quantity import Quantity, spell


@dataclass(frozen=True)
class Damper(Strut):
    """A viscous damper: force = c1 v + c3 v³ + …, against the rate v of a joint or of the distance of two points.

    Attributes:
        damping: c1, c3, c5, …; N s/m or N m s/rad, …
    """

    damping: tuple[Quantity, ...] = ()

    kind = "damper"


def _force(damper: Damper, x: Expr, v: Expr) -> Expr:
    graph, power = v.graph, v
    total = graph.zero
    for c in damper.damping:
        total = total + c.express(graph) * power
        power = power * v * v
    return total


def _check(damper: Damper, stand: Stand) -> None:
    """Report a negative coefficient where it is the only one."""
    value = stand.value(damper.damping[0]) if len(damper.damping) == 1 else None
    if value is not None and value < 0:
        stand.fault(f"damping = {shown(damper.damping[0])} is negative; give zero or more")


POT = ((0.65, 1.0), (0.35, 1.0), (0.35, -1.0), (0.65, -1.0))

RODS = (((0.0, 0.0), (0.35, 0.0)), ((0.52, 0.0), (1.0, 0.0)))

DAMPER = ForceKind(
    section="dampers",
    noun=Damper,
    letter="v",
    parts=(
        Ends(),
        Key[tuple[Quantity, ...]](
            "damping",
            coefficients,
            (),
            letters=("c",),
            unit=("N m s/rad", "N s/m"),
            each=("rad^2/s^2", "m^2/s^2"),
            text="damping of {}",
            positive=True,
        ),
    ),
    needs=("damping",),
    missing="damping is missing; write damping = 10, or a list of coefficients of v, v**3, ...",
    law=Pull(_force),
    law_words=lambda damper: f"damping {', '.join(map(spell, damper.damping))}",
    words={"en": "damper", "sk": "tlmič"},
    lost="a damper, which acts in the equations",
    mark=Mark(
        strokes=((1.6, (*RODS, POT)), (3.0, (((0.52, 0.8), (0.52, -0.8)),))),
        curl=((1.7, -0.4), (1.7, 1.2 * pi), 3.2),
        side=-0.7,
        page="damper",
    ),
    check=_check,
)


def damper(
    name: str,
    *,
    joint: str | None = None,
    ends: tuple[End, End] | None = None,
    damping: Number | Sequence[Number],
) -> Entry:
    """Declare a viscous damper: c1, or c1, c3, ... of the force c1 v + c3 v^3 + ...; ends as in `spring`."""
    check_arguments(damper, locals(), SceneError)
    return entry("dampers", name, joint=joint, **as_keys(ends), damping=damping)
