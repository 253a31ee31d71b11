"""Forces that are applied: springs, dampers, dry friction, loads.

Dry friction follows Coulomb's and Stribeck's curve, and stands in the joint's own table, under `friction`. Reference:
Olsson et al., Friction models and friction compensation, European Journal of Control 4 (1998).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb, pi
from typing import Literal

from symdyn.arguments import checked, suggesting
from symdyn.errors import SceneError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op
from symdyn.scene.forces.attachments import AtBody, End, Ends, as_keys
from symdyn.scene.forces.force_kind import ForceKind, Mark, Pull, Push, Rub
from symdyn.scene.values.dimension import FORCE_UNITS
from symdyn.scene.values.entry import Entry, EntryReader, Number, Three, entry, shown
from symdyn.scene.values.joint import Element, Load, Strut
from symdyn.scene.values.key import TIMED, Key, Stand, coefficients, number, one_of, optional
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, Quantity, Vector, spell
from symdyn.scene.values.shape import NUMBER
from symdyn.spatial import Vec, Wrench


@dataclass(frozen=True)
class Spring(Strut):
    """A spring, by `SPRING_LAW`; its energy belongs to P; N or N m, N/m or N m/rad and so on."""

    stiffness: tuple[Quantity, ...] = ()
    preload: Quantity = Quantity.ZERO

    kind = "spring"


def _spring_force(spring: Spring, x: Expr, v: Expr) -> Expr:
    graph, way = x.graph, x - spring.free.express(x.graph)
    total, power = spring.preload.express(graph), way
    for k in spring.stiffness:
        total = total + k.express(graph) * power
        power = power * way
    return total


def _energy(spring: Spring, x: Expr) -> Expr:
    """Return preload x + k1 x²/2 + k2 x³/3 + … of the way from the free length."""
    graph, way = x.graph, x - spring.free.express(x.graph)
    total, power = spring.preload.express(graph) * way, way * way
    for m, k in enumerate(spring.stiffness, 2):
        total = total + k.express(graph) * power / m
        power = power * way
    return total


def _over_distance(spring: Spring, square: Expr) -> Expr:
    """Return F / s, a polynomial where the spring does not pull at s = 0, as one of free length zero does not."""
    graph, terms = square.graph, _of_distance(spring, square.graph)
    s = graph.sqrt(square)
    if not terms[0].is_zero:
        return _spring_force(spring, s, graph.zero) / s
    return graph.total(c * _power(s, square, m) for m, c in enumerate(terms[1:]))


def _stored_between(spring: Spring, square: Expr) -> Expr:
    """Return the energy by s²; zero where s is the free length."""
    graph, terms = square.graph, _of_distance(spring, square.graph)
    s = graph.sqrt(square)
    if not terms[0].is_zero:
        return _energy(spring, s)
    ways = [c * _power(s, square, m) / m for m, c in enumerate(terms[1:], 2)]
    return graph.total([*ways, _energy(spring, graph.zero)])


def _of_distance(spring: Spring, graph: Graph) -> list[Expr]:
    """Return c with force = c_0 + c_1 s + c_2 s² + … in terms of the distance s."""
    known = [x.express(graph) for x in (spring.preload, *spring.stiffness)]
    free = spring.free.express(graph)
    terms = []
    for j in range(len(known)):
        power, total = graph.one, graph.zero
        for m in range(j, len(known)):
            total = total + known[m] * comb(m, j) * power
            power = -free * power
        terms.append(total)
    return terms


def _power(s: Expr, square: Expr, m: int) -> Expr:
    """Return s to the power m, by its square as far as that goes: a root has no slope at zero."""
    result = s.graph.one if m % 2 == 0 else s
    for _ in range(m // 2):
        result = result * square
    return result


def _spring_words(spring: Spring) -> str:
    stiffness = ", ".join(map(spell, spring.stiffness))
    return f"stiffness {stiffness}, free {spell(spring.free)}, preload {spell(spring.preload)}"


COILS = 6

ZIGZAG = (
    (0.0, 0.0),
    (0.15, 0.0),
    *((0.15 + 0.7 * (k + 0.5) / (2 * COILS), float((-1) ** k)) for k in range(2 * COILS)),
    (0.85, 0.0),
    (1.0, 0.0),
)

SPRING_LAW = "Q = -(preload + k1 x + k2 x^2 + ..) at a joint, x = q - free; between points a pull, x = length - free"

SPRING = ForceKind(
    section="springs",
    noun=Spring,
    letter="s",
    parts=(
        Ends(),
        Key[tuple[Quantity, ...]](
            "stiffness",
            coefficients,
            (),
            letters=("k",),
            unit=("N m/rad", "N/m"),
            each=("rad", "m"),
            text="stiffness of {}",
            holds=f"k1, or [k1, k2, ..]: {SPRING_LAW}; {{}}",
            positive=True,
        ),
        number("free", ("rad", "m"), letters=("s",), text="free position of {}", holds="where x = 0; {}"),
        number(
            "preload",
            FORCE_UNITS,
            silent=lambda spring: spring.preload == Quantity.ZERO and spring.stiffness,
            letters=("p",),
            text="preload of {}",
            holds=f"force at x = 0: {SPRING_LAW}; {{}}",
        ),
    ),
    needs=("stiffness", "preload"),
    missing="stiffness is missing; write stiffness = 100, or a list of coefficients",
    law=Pull(_spring_force, _energy, _over_distance, _stored_between),
    law_words=_spring_words,
    words={"en": "spring", "sk": "pružina"},
    lost="a spring, which acts in the equations",
    mark=Mark(
        strokes=((1.6, (ZIGZAG,)),),
        curl=((1.5, 0.0), (2.5, 4 * pi), 1.4),
        side=0.7,
        page="spring",
        has_length=lambda spring: spring.free != Quantity.ZERO,
    ),
)


@checked(SceneError)
def spring(
    name: str,
    *,
    joint: str | None = None,
    ends: tuple[End, End] | None = None,
    stiffness: Number | Sequence[Number] | None = None,
    free: Number | None = None,
    preload: Number | None = None,
    text: str = "",
) -> Entry:
    """Declare a spring.

    Args:
        name: of the spring.
        joint: the joint with one coordinate that it is at; or
        ends: the two points that it connects, each the name of a body or point or {"body": name, "at": [x, y, z]}.
        stiffness: k1, or k1, k2, ... of Q = -(preload + k1 x + k2 x^2 + ...), x = q - free, at a joint; between points
            that is a pull, x = length - free.
        free: position or length at which x = 0, rad or m; zero when left out.
        preload: force there, N m or N: a positive one drives q down, or pulls the ends together.
        text: a description, which lessons and pictures call it by.
    """
    law = {"stiffness": stiffness, "free": free, "preload": preload}
    return entry("springs", name, joint=joint, **as_keys(ends), **law, text=text)


# Dampers


@dataclass(frozen=True)
class Damper(Strut):
    """A viscous damper: c1 v + c3 v³ + … against the rate v of a joint or a distance; N s/m or N m s/rad."""

    damping: tuple[Quantity, ...] = ()

    kind = "damper"


def _resistance(damper: Damper, x: Expr, v: Expr) -> Expr:
    graph, power = v.graph, v
    total = graph.zero
    for c in damper.damping:
        total = total + c.express(graph) * power
        power = power * v * v
    return total


def _check_damper(damper: Damper, stand: Stand) -> None:
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
            example="damping = 10, or a list of coefficients of v, v**3, ...",
            letters=("c",),
            unit=("N m s/rad", "N s/m"),
            each=("rad^2/s^2", "m^2/s^2"),
            text="damping of {}",
            holds="c1, or [c1, c3, ..]: Q = -(c1 v + c3 v^3 + ..) at a joint, likewise along a distance; {}",
            positive=True,
        ),
    ),
    law=Pull(_resistance),
    law_words=lambda damper: f"damping {', '.join(map(spell, damper.damping))}",
    words={"en": "damper", "sk": "tlmič"},
    lost="a damper, which acts in the equations",
    mark=Mark(
        strokes=((1.6, (*RODS, POT)), (3.0, (((0.52, 0.8), (0.52, -0.8)),))),
        curl=((1.7, -0.4), (1.7, 1.2 * pi), 3.2),
        side=-0.7,
        page="damper",
    ),
    check=_check_damper,
)


@checked(SceneError)
def damper(
    name: str,
    *,
    joint: str | None = None,
    ends: tuple[End, End] | None = None,
    damping: Number | Sequence[Number],
    text: str = "",
) -> Entry:
    """Declare a viscous damper: c1, or c1, c3, ... of Q = -(c1 v + c3 v^3 + ...), v the rate; ends as in `spring`."""
    return entry("dampers", name, joint=joint, **as_keys(ends), damping=damping, text=text)


@dataclass(frozen=True)
class Friction(Element):
    """Dry friction of the joint of this name, against its rate v; N m or N, rad/s or m/s.

        Q = -(coulomb + (static - coulomb) exp(-(v / stribeck)^2)) · tanh(v / smoothing)

    Attributes:
        coulomb: size of the force when sliding.
        static: size of the force at the onset of motion; None: as `coulomb`.
        stribeck: rate at which the force falls from one to the other.
        smoothing: rate over which the sign is smoothed; zero is the ideal sign, by which a joint sticks and slips.
    """

    coulomb: Quantity
    static: Quantity | None = None
    stribeck: Quantity = Quantity.ONE
    smoothing: Quantity = Quantity.ZERO

    kind = "friction"


def _friction_force(dry: Friction, rate: Expr) -> Expr:
    graph = rate.graph
    size, smoothing = dry.coulomb.express(graph), dry.smoothing.express(graph)
    if dry.static is not None:
        slow = rate / dry.stribeck.express(graph)
        size = size + (dry.static.express(graph) - size) * graph.function(Op.EXP, -(slow * slow))
    return size * (graph.function(Op.SIGN, rate) if smoothing.is_zero else graph.function(Op.TANH, rate / smoothing))


def _friction_words(dry: Friction) -> str:
    law = [f"Coulomb {spell(dry.coulomb)}"]
    law += [f"static {spell(dry.static)}, Stribeck {spell(dry.stribeck)}"] if dry.static is not None else []
    return ", ".join([*law, f"smoothing {spell(dry.smoothing)}" if dry.smoothing != Quantity.ZERO else "ideal sign"])


def _check_friction(dry: Friction, stand: Stand) -> None:
    """Report what is negative, and a rate that is none."""
    known = {x.key: stand.value(x.quantity) for part in FRICTION.parts for x in part.numbers(dry)}
    sticks, slips = known.get("static"), known.get("coulomb")
    for key in ("coulomb", "static", "smoothing"):
        if (value := known.get(key)) is not None and value < 0:
            stand.fault(f"friction.{key} = {float(value):.6g} is negative; give zero or more")
    if (value := known["stribeck"]) is not None and value <= 0:
        stand.fault(f"friction.stribeck = {float(value):.6g} is no rate; give one above zero")
    if known["smoothing"] == 0 and sticks is not None and slips is not None and sticks < slips:
        told = f"friction.static = {float(sticks):.6g} is less than friction.coulomb = {float(slips):.6g}"
        stand.fault(f"{told}; what sticks holds as much as what slips, at least, or give a smoothing")


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
    law=Rub(_friction_force, jumps=lambda dry: dry.smoothing == Quantity.ZERO),
    law_words=_friction_words,
    words={"en": "dry friction, smoothed", "sk": "suché trenie, vyhladené"},
    lost="friction that enters the equations",
    check=_check_friction,
)


def _vector(vector: Vector, graph: Graph) -> Vec:
    x, y, z = (entry.express(graph) for entry in vector)
    return (x, y, z)


def _check_load(load: Load, stand: Stand) -> None:
    if load.place.body == Scene.GROUND:
        stand.fault(f"acts on {Scene.GROUND}, which does not move; name a body")


def _load_words(load: Load) -> str:
    force, couple = (f"({', '.join(map(spell, vector))})" for vector in (load.force, load.couple))
    return f"force {force}, couple {couple}, axes of the {load.frame}"


LOAD = ForceKind(
    section="loads",
    noun=Load,
    letter="w",
    parts=(
        AtBody(),
        Key(
            "force",
            EntryReader.vector,
            NULL,
            silent=lambda load: load.force == NULL and load.couple != NULL,
            letters=("Fx", "Fy", "Fz"),
            unit="N",
            text="force of {}",
            names=TIMED,
        ),
        Key(
            "couple", EntryReader.vector, NULL, letters=("Cx", "Cy", "Cz"), unit="N m", text="couple of {}", names=TIMED
        ),
        one_of("frame", ("ground", "body"), "along whose axes both act on the body, a couple right-handed", "ground"),
    ),
    needs=("force", "couple"),
    missing="has neither force nor couple; write one, such as force = [0, 0, 10]",
    law=Push(lambda load, scene, graph: Wrench(_vector(load.force, graph), _vector(load.couple, graph))),
    law_words=_load_words,
    words={"en": "load", "sk": "zaťaženie"},
    lost="a wrench, which acts in the equations",
    check=_check_load,
)


@suggesting
def load(
    name: str,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    force: Three | None = None,
    couple: Three | None = None,
    frame: Literal["ground", "body"] | None = None,
    text: str = "",
) -> Entry:
    """Declare a wrench on a body.

    Args:
        name: of the load.
        body: that it acts on.
        at: the place in body coordinates, m; the origin when left out; or
        point: that it acts at.
        force: on the body, N, formulas in t, parameters, coordinates and velocities.
        couple: on the body, right-handed, N m, the same.
        frame: "ground" or "body", whose axes the components are along; the ground's when left out.
        text: as of `spring`.
    """
    return entry("loads", **locals())
