"""Dry friction of a joint, by Coulomb's and Stribeck's curve. It stands in the joint's own table, under `friction`.

Reference: Olsson et al., Friction models and friction compensation, European Journal of Control 4 (1998).
"""

from __future__ import annotations

from symdyn.graph import Expr, Op
from symdyn.scene.forces.keys import NUMBER, Form, Key
from symdyn.scene.values.element import Friction
from symdyn.scene.values.quantity import ONE, ZERO, express
from symdyn.scene.values.spelling import spell

FORCE, RATE = ("N m", "N"), ("rad/s", "m/s")
"""Units at a joint that turns, and at one that slides."""

OPTIONAL = Form(lambda table, key, usual: table.quantity(key) if key in table else usual, None)

KEYS = (
    Key("coulomb", NUMBER, letters=("fc",), unit=FORCE, text="sliding friction of {}", positive=True),
    Key(
        "static",
        OPTIONAL,
        silent=lambda dry: dry.static is None,
        letters=("fs",),
        unit=FORCE,
        text="friction of {} at rest",
        positive=True,
    ),
    Key("stribeck", NUMBER, ONE, letters=("vs",), unit=RATE, text="Stribeck rate of {}", positive=True),
    Key("smoothing", NUMBER, ZERO, letters=("ve",), unit=RATE, text="smoothing of the friction of {}", positive=True),
)

ADVICE = "write friction = { coulomb = 0.5, static = 0.7, stribeck = 0.1, smoothing = 0.01 }"

WORDS = {"en": "dry friction, smoothed", "sk": "suché trenie, vyhladené"}

LOST = "friction that enters the equations"


def rubbing(dry: Friction, rate: Expr) -> Expr:
    """Return the force against a rate v, N or N m; see `Friction`."""
    graph = rate.graph
    size = express(dry.coulomb, graph)
    if dry.static is not None:
        slow = rate / express(dry.stribeck, graph)
        size = size + (express(dry.static, graph) - size) * graph.function(Op.EXP, -(slow * slow))
    smoothing = express(dry.smoothing, graph)
    if smoothing.is_zero:
        return size * graph.function(Op.SIGN, rate)
    return size * graph.function(Op.TANH, rate / smoothing)


def says(dry: Friction) -> str:
    """Return its law in words."""
    law = [f"Coulomb {spell(dry.coulomb)}"]
    law += [f"static {spell(dry.static)}, Stribeck {spell(dry.stribeck)}"] if dry.static is not None else []
    return ", ".join([*law, f"smoothing {spell(dry.smoothing)}" if dry.smoothing != ZERO else "ideal sign"])
