"""Springs and dampers, at a joint or between two points.

A spring: preload + k1 x + k2 x² + … along the way x from its free length.

A viscous damper: c1 v + c3 v³ + … against the rate v of its way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb, pi

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.graph import Expr, Graph
from symdyn.scene.forces.attachments import End, Ends, as_keys
from symdyn.scene.forces.force_kind import ForceKind, Mark, Pull
from symdyn.scene.values.dimension import FORCE_UNITS
from symdyn.scene.values.entry import Entry, Number, entry, shown
from symdyn.scene.values.joint import Strut
from symdyn.scene.values.key import Key, Stand, coefficients, number
from symdyn.scene.values.quantity import Quantity, spell


@dataclass(frozen=True)
class Spring(Strut):
    """A spring: force = preload + k1 x + k2 x² + …, x the way from `free`; its energy belongs to P.

    At a joint, x is its position less `free`, and the force opposes it; between points, x is their distance less
    `free`, and the force pulls them together.

    Attributes:
        stiffness: k1, k2, …; N/m or N m/rad, N/m² …
        free: position or length at which the polynomial vanishes, rad or m.
        preload: force at x = 0, N or N m.
    """

    stiffness: tuple[Quantity, ...] = ()
    free: Quantity = Quantity.ZERO
    preload: Quantity = Quantity.ZERO

    kind = "spring"


def _force(spring: Spring, x: Expr, v: Expr) -> Expr:
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
        return _force(spring, s, graph.zero) / s
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


def _law_words(spring: Spring) -> str:
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
            positive=True,
        ),
        number("free", ("rad", "m"), letters=("s",), text="free position of {}"),
        number(
            "preload",
            FORCE_UNITS,
            silent=lambda spring: spring.preload == Quantity.ZERO and spring.stiffness,
            letters=("p",),
            text="preload of {}",
        ),
    ),
    needs=("stiffness", "preload"),
    missing="stiffness is missing; write stiffness = 100, or a list of coefficients",
    law=Pull(_force, _energy, _over_distance, _stored_between),
    law_words=_law_words,
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


def spring(
    name: str,
    *,
    joint: str | None = None,
    ends: tuple[End, End] | None = None,
    stiffness: Number | Sequence[Number] | None = None,
    free: Number | None = None,
    preload: Number | None = None,
) -> Entry:
    """Declare a spring.

    Args:
        name: of the spring.
        joint: the joint with one coordinate that it is at; or
        ends: the two points that it connects, each the name of a body or point or {"body": name, "at": [x, y, z]}.
        stiffness: k1, or k1, k2, ... of the force k1 x + k2 x^2 + ..., x the way from `free`.
        free: position or length at which that vanishes, rad or m; zero when left out.
        preload: force there, N m or N.
    """
    check_arguments(spring, locals(), SceneError)
    return entry("springs", name, joint=joint, **as_keys(ends), stiffness=stiffness, free=free, preload=preload)


# Dampers


@dataclass(frozen=True)
class Damper(Strut):
    """A viscous damper: force = c1 v + c3 v³ + …, against the rate v of a joint or of the distance of two points.

    Attributes:
        damping: c1, c3, c5, …; N s/m or N m s/rad, …
    """

    damping: tuple[Quantity, ...] = ()

    kind = "damper"


def _resistance(damper: Damper, x: Expr, v: Expr) -> Expr:
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
            example="damping = 10, or a list of coefficients of v, v**3, ...",
            letters=("c",),
            unit=("N m s/rad", "N s/m"),
            each=("rad^2/s^2", "m^2/s^2"),
            text="damping of {}",
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
