"""A rope from outside: a tendon that stiffens exponentially, as soft tissue does (Fung, 1967).

T = tension (exp(rise ε) - 1)     E = tension free (exp(rise ε) - 1 - rise ε) / rise     ε = (L - free) / free
"""

from __future__ import annotations

from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op
from symdyn.scene import Quantity
from symdyn.scene.forces import FORCES
from symdyn.scene.forces.attachments import Through
from symdyn.scene.forces.force_kind import Pull
from symdyn.scene.values import Strut, spell
from symdyn.scene.values.key import number


@dataclass(frozen=True)
class FungRope(Strut):
    """A rope through places and around wheels; `free` is its length without tension, m, `tension` in N."""

    tension: Quantity = Quantity.ZERO
    rise: Quantity = Quantity.ONE
    free: Quantity = Quantity.ONE

    kind = "fung"
    is_taut = True


def _stretched(rope: FungRope, x: Expr) -> tuple[Expr, Expr, Expr, Expr]:
    tension, rise, free = (one.express(x.graph) for one in (rope.tension, rope.rise, rope.free))
    return tension, rise, free, rise * (x - free) / free


def _force(rope: FungRope, x: Expr, v: Expr) -> Expr:
    tension, _, _, strain = _stretched(rope, x)
    return tension * (x.graph.function(Op.EXP, strain) - 1)


def _energy(rope: FungRope, x: Expr) -> Expr:
    tension, rise, free, strain = _stretched(rope, x)
    return tension * free / rise * (x.graph.function(Op.EXP, strain) - 1 - strain)


FORCES["fung"] = replace(
    FORCES["elastic"],
    noun=FungRope,
    letter="fu",
    parts=(
        Through(),
        number("tension", "N", letters=("ft",), text="tension of {}", positive=True),
        number("rise", "1", letters=("fr",), text="rise of {}", above_zero="does not stiffen; give one above zero"),
        number("free", "m", letters=("fl",), text="free length of {}", above_zero="is no length; give one above zero"),
    ),
    needs=("tension",),
    missing="tension is missing; write tension = 10, in newtons",
    law=Pull(_force, _energy),
    law_words=lambda rope: f"tension {spell(rope.tension)}, rise {spell(rope.rise)}, free {spell(rope.free)}",
    words={"en": "tendon", "sk": "šľacha"},
)
