"""A force element from outside: a gas spring, whose gas keeps its temperature and pushes its ends apart.

F = -charge / (x - dead)        E = -charge log(x - dead)        x: position of a joint, or distance of two points
"""

from __future__ import annotations

from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op
from symdyn.scene import Quantity
from symdyn.scene.forces import FORCES
from symdyn.scene.forces.attachments import Ends
from symdyn.scene.forces.force_kind import ForceKind, Mark, Pull
from symdyn.scene.values import Strut, spell
from symdyn.scene.values.key import Stand, number


@dataclass(frozen=True)
class GasSpring(Strut):
    """A gas spring; `charge` is its pressure times its volume, J, `dead` its length where no gas is left, m."""

    charge: Quantity = Quantity.ZERO
    dead: Quantity = Quantity.ZERO

    kind = "gas_spring"


def _room(spring: GasSpring, x: Expr) -> Expr:
    return x - spring.dead.express(x.graph)


def _force(spring: GasSpring, x: Expr, v: Expr) -> Expr:
    return -spring.charge.express(x.graph) / _room(spring, x)


def _energy(spring: GasSpring, x: Expr) -> Expr:
    return -spring.charge.express(x.graph) * x.graph.function(Op.LOG, _room(spring, x))


def _check(spring: GasSpring, stand: Stand) -> None:
    dead = stand.value(spring.dead)
    if dead is not None and dead < 0:
        stand.fault(f"dead = {spell(spring.dead)} is a length below zero; give zero or more")


FORCES["gas_spring"] = ForceKind(
    section="gas_springs",
    noun=GasSpring,
    letter="gs",
    parts=(
        Ends(),
        number(
            "charge",
            "J",
            above_zero="is that of no gas; give one above zero",
            letters=("pv",),
            text="charge of {}",
            positive=True,
        ),
        number("dead", "m", letters=("dl",), text="dead length of {}"),
    ),
    needs=("charge",),
    missing="charge is missing; write charge = 20, pressure times volume in joules",
    law=Pull(_force, _energy),
    law_words=lambda spring: f"charge {spell(spring.charge)}, dead {spell(spring.dead)}",
    words={"en": "gas spring", "sk": "plynová pružina"},
    lost="a gas spring, which acts in the equations",
    mark=Mark(
        strokes=((1.6, (((0.0, 0.0), (0.3, 0.0)), ((0.3, -1.0), (0.3, 1.0), (1.0, 1.0), (1.0, -1.0)))),),
        curl=((1.6, 0.0), (2.2, 3.0), 2.4),
        side=0.7,
        page="damper",
    ),
    check=_check,
)
