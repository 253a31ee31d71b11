"""Dry friction of a joint, by Coulomb's and Stribeck's curve. It stands in the joint's own table, under `friction`.

Reference: Olsson et al., Friction models and friction compensation, European Journal of Control 4 (1998).
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.graph import Expr, Op
from symdyn.scene.forces.force_kind import ForceKind, Rub
from symdyn.scene.values.dimension import FORCE_UNITS
from symdyn.scene.values.entry import EntryReader
from symdyn.scene.values.joint import Element
from symdyn.scene.values.key import Key, Stand, number, optional
from symdyn.scene.values.quantity import Quantity, spell
from symdyn.scene.values.shape import NUMBER


@dataclass(frozen=True)
class Friction(Element):
    """Dry friction of the joint of this name, opposed to its rate v; N m or N, rad/s or m/s.

        force = (coulomb + (static - coulomb) exp(-(v / stribeck)^2)) · tanh(v / smoothing)

    Attributes:
        coulomb: size of the force when sliding.
        static: size of the force at the onset of motion; None: as `coulomb`.
        stribeck: rate at which the force falls from one to the other.
        smoothing: rate over which the sign is smoothed; zero is the ideal sign, for inverse dynamics only.
    """

    coulomb: Quantity
    static: Quantity | None = None
    stribeck: Quantity = Quantity.ONE
    smoothing: Quantity = Quantity.ZERO

    kind = "friction"


def _force(dry: Friction, rate: Expr) -> Expr:
    graph = rate.graph
    size = dry.coulomb.express(graph)
    if dry.static is not None:
        slow = rate / dry.stribeck.express(graph)
        size = size + (dry.static.express(graph) - size) * graph.function(Op.EXP, -(slow * slow))
    smoothing = dry.smoothing.express(graph)
    if smoothing.is_zero:
        return size * graph.function(Op.SIGN, rate)
    return size * graph.function(Op.TANH, rate / smoothing)


def _law_words(dry: Friction) -> str:
    law = [f"Coulomb {spell(dry.coulomb)}"]
    law += [f"static {spell(dry.static)}, Stribeck {spell(dry.stribeck)}"] if dry.static is not None else []
    return ", ".join([*law, f"smoothing {spell(dry.smoothing)}" if dry.smoothing != Quantity.ZERO else "ideal sign"])


def _check(dry: Friction, stand: Stand) -> None:
    """Report what is negative, and a rate that is none."""
    known = {x.key: stand.value(x.quantity) for part in FRICTION.parts for x in part.numbers(dry)}
    for key in ("coulomb", "static", "smoothing"):
        if (value := known.get(key)) is not None and value < 0:
            stand.fault(f"friction.{key} = {float(value):.6g} is negative; give zero or more")
    if (value := known["stribeck"]) is not None and value <= 0:
        stand.fault(f"friction.stribeck = {float(value):.6g} is no rate; give one above zero")


RATE = ("rad/s", "m/s")
"""Units at a joint that turns, and at one that slides."""

FRICTION = ForceKind(
    section="friction",
    noun=Friction,
    letter="",
    parts=(
        number(
            "coulomb",
            FORCE_UNITS,
            example="friction = { coulomb = 0.5, static = 0.7, stribeck = 0.1, smoothing = 0.01 }",
            letters=("fc",),
            text="sliding friction of {}",
            positive=True,
        ),
        Key(
            "static",
            optional(EntryReader.quantity),
            None,
            letters=("fs",),
            unit=FORCE_UNITS,
            text="friction of {} at rest",
            positive=True,
            shape=NUMBER,
        ),
        Key(
            "stribeck",
            EntryReader.quantity,
            Quantity.ONE,
            letters=("vs",),
            unit=RATE,
            text="Stribeck rate of {}",
            positive=True,
        ),
        number("smoothing", RATE, letters=("ve",), text="smoothing of the friction of {}", positive=True),
    ),
    law=Rub(_force, jumps=lambda dry: dry.smoothing == Quantity.ZERO),
    law_words=_law_words,
    words={"en": "dry friction, smoothed", "sk": "suché trenie, vyhladené"},
    lost="friction that enters the equations",
    check=_check,
)
