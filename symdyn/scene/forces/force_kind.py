"""What every kind of element tells: its section of a file, its keys, its law, its words, its mark.

A strut's law is a force along its way x, of rate v: it acts against the growth of x. Between points x is their distance
s ≥ 0, and the force over s, which turns the way from one end to the other into a force, may have a value where s has
no direction: such a law gives it by s² itself.

    force      F(x, v), N or N m            over       F / s by s², N/m
    energy     E(x), with F = dE/dx, J      stored     E by s², J; zero where the force of x is

The normal of level ground: against gravity as the scene declares it, whatever values its parameters get later.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph
from symdyn.scene.values.folding import neg, substituted
from symdyn.scene.values.joint import Contact, Element, Row
from symdyn.scene.values.key import Part, Stand
from symdyn.scene.values.letters import Parameter
from symdyn.scene.values.model import Point, Scene
from symdyn.scene.values.quantity import FormulaError, Quantity, Vector, spell
from symdyn.spatial import Transform, Vec, Wrench
from symdyn.unlocked import cached_property

DRAWS, SAME = 6, 1e-12
"""Random values of free parameters at which a direction is looked at, and what it may differ by."""


def level_normal(gravity: Vector, parameters: Sequence[Parameter]) -> Vector | str:
    """Return the direction against gravity, free of symbols; or why it is not decided, for a message.

    Parameters with a value have that value; the direction must be the same whatever the others are.
    """
    given = {p.name: p.value for p in parameters if p.value is not None}
    free = [p for p in parameters if p.value is None]
    text = f"gravity = [{', '.join(spell(x) for x in gravity)}]"
    draws = [given | drawn for drawn in _drawn(free)]
    directions = [found for values in draws if (found := _unit(gravity, values)) is not None]
    if len(directions) < len(draws):
        return f"{text} has no direction"
    if any(math.dist(directions[0], one) > SAME for one in directions):
        names = [p.name for p in free if any(p.name in x.symbols for x in gravity)]
        return f"the direction of {text} depends on {', '.join(names)}, which may be negative"
    lengths = [k for k in range(3) if abs(directions[0][k]) > SAME]
    if len(lengths) == 1:
        up = Quantity.ONE if directions[0][lengths[0]] < 0 else neg(Quantity.ONE)
        x, y, z = (up if k == lengths[0] else Quantity.ZERO for k in range(3))
    else:
        x, y, z = (neg(substituted(entry, draws[0])) for entry in gravity)
    return (x, y, z)


def _drawn(free: Sequence[Parameter]) -> list[dict[str, Quantity]]:
    """Return values of free parameters: ones, ones with either sign, and random ones."""
    from random import Random  # few scenes ask

    rng = Random("gravity")
    sizes = [[1] * len(free), [1] * len(free), *([rng.randint(1, 99) for _ in free] for _ in range(DRAWS))]
    signs = [1, -1, *(rng.choice((-1, 1)) for _ in range(DRAWS))]
    return [
        {p.name: Quantity.number(size if p.positive else sign * size) for p, size in zip(free, some, strict=True)}
        for some, sign in zip(sizes, signs, strict=True)
    ]


def _unit(vector: Vector, values: Mapping[str, Quantity]) -> tuple[float, ...] | None:
    """Return the direction of a vector at values of its symbols; None where it has none."""
    try:
        numbers = [float(substituted(x, values).at({}) or 0) for x in vector]
    except (FormulaError, ZeroDivisionError):
        return None  # reported as a formula without a value
    length = math.hypot(*numbers)
    return tuple(x / length for x in numbers) if length else None


@dataclass(frozen=True)
class Scope:
    """What the tables of elements are read with.

    Attributes:
        points: the scene's, by name.
        gravity, parameters: of the scene; they decide what is level.
    """

    points: Mapping[str, Point]
    gravity: Vector
    parameters: Sequence[Parameter]

    @cached_property
    def level(self) -> Vector | str:
        """The normal of level ground; or why there is none, for a message."""
        return level_normal(self.gravity, self.parameters)


@dataclass(frozen=True)
class Pull:
    """The law of a strut, see the module's legend; one with an energy belongs to P."""

    force: Callable[[Any, Expr, Expr], Expr]
    energy: Callable[[Any, Expr], Expr] | None = None
    over: Callable[[Any, Expr], Expr] | None = None
    stored: Callable[[Any, Expr], Expr] | None = None


@dataclass(frozen=True)
class Push:
    """The law of a load.

    Attributes:
        wrench: its force and couple along the axes of its frame, N and N m.
        carried: what comes on top by the motion of its body, body axes, at its place, from the velocity of that place
            and the angular velocity, body axes; None: nothing.
    """

    wrench: Callable[[Any, Scene, Graph], Wrench]
    carried: Callable[[Any, Scene, Vec, Vec], Wrench] | None = None


@dataclass(frozen=True)
class Rub:
    """The law of what stands in the table of a joint and acts against each of its rates v, with its damping."""

    force: Callable[[Any, Expr], Expr]  # F(v), N m or N
    jumps: Callable[[Any], bool]  # whether it has no value at rest, so that no motion can be integrated with it


@dataclass(frozen=True)
class Forbid:
    """The law of a row that is a formula, linear in the velocities, that vanishes."""

    formula: Callable[[Any], Quantity]


@dataclass(frozen=True)
class Hold:
    """The law of a row that holds the length of a rope through its places."""

    length: Callable[[Any], Quantity]


@dataclass(frozen=True)
class ContactLaw:
    """The law of a row that is a contact of a place P with a plane; X places the frame at P in that of the plane.

    w is the sine of the angle between the axis of a wheel and the normal; one where there is no such axis.

    Attributes:
        lean: the cross product of axis and normal, unit vectors, whose length is w; None where there is no such axis.
        wrenches: what the plane can exert at P without working, axes of the plane's body, from X and w.
        height: of what touches over the plane, m, from X and w.
        holonomic: for each of the wrenches whether its constraint is holonomic, which that of the height is.
        words: of each of them; "" where a direction says it.
    """

    lean: Callable[[Any, Transform], Vec | None]
    wrenches: Callable[[Any, Transform, Expr], tuple[Wrench, ...]]
    height: Callable[[Any, Transform, Expr], Expr]
    holonomic: Callable[[Any], tuple[bool, ...]]
    words: Callable[[Any], tuple[str, ...]]


@dataclass(frozen=True)
class Mark:
    """How a strut is drawn: lines from one end to the other, or a curl around a joint that turns.

    Attributes:
        strokes: the width of some lines, and their points: the share of the way, and how far they are beside it, in
            halves of a mark.
        curl: radius and angle of both ends of a curve around a joint, in sizes of a mark and radians, and its width.
        side: how far it is beside the axis of a slide, in sizes of a mark.
        page: the drawing that stands for it on pages of lessons: "spring" or "damper".
        has_length: whether the position of a slide is a length of it, so that it begins at the joint's zero.
    """

    strokes: tuple[tuple[float, tuple[tuple[tuple[float, float], ...], ...]], ...]
    curl: tuple[tuple[float, float], tuple[float, float], float]
    side: float
    page: str
    has_length: Callable[[Any], bool] = lambda one: False


@dataclass(frozen=True)
class Rim:
    """How a contact is drawn that rolls: the circle of its radius about its axis, a ball's from everywhere."""


Law = Pull | Push | Rub | Forbid | Hold | ContactLaw


@dataclass(frozen=True)
class ForceKind:
    """One kind of element.

    Attributes:
        section: the tables of a file that declare it, such as "springs", or the key in the table of a joint; kinds that
            share one are told apart by `type`, and the first of them needs none.
        noun: makes an element of its name and of the fields that its parts read.
        letter: in names that are made up for its places.
        parts: its ends and its keys, as they are written.
        needs: keys of which one must be given, where no key says so by itself.
        missing: what is said where none of them is.
        law: what it does.
        law_words: its law in words, for tables.
        words: its name by language.
        lost: what it is, said where a format does not hold it.
        mark: how it is drawn; None for what a picture draws alike for all, as the arrow of a load.
        check: reports what is wrong beside what its parts find.
    """

    section: str
    noun: Callable[..., Element]
    letter: str
    parts: tuple[Part, ...]
    law: Law
    law_words: Callable[[Any], str]
    words: Mapping[str, str]
    lost: str
    needs: tuple[str, ...] = ()
    missing: str = ""
    mark: Mark | Rim | None = None
    check: Callable[[Any, Stand], None] | None = None

    @property
    def pull(self) -> Pull:
        assert isinstance(self.law, Pull), "a strut pulls"
        return self.law

    @property
    def push(self) -> Push:
        assert isinstance(self.law, Push), "a load pushes"
        return self.law

    @property
    def rub(self) -> Rub:
        """The law of what stands in the table of a joint."""
        assert isinstance(self.law, Rub), "it resists a joint"
        return self.law

    @property
    def touch(self) -> ContactLaw:
        assert isinstance(self.law, ContactLaw), "a contact touches"
        return self.law

    @property
    def lines(self) -> Mark:
        """How a kind of struts is drawn."""
        assert isinstance(self.mark, Mark), "a strut has a mark of lines"
        return self.mark

    @property
    def rolls(self) -> bool:
        """Whether it is a kind of contacts that is drawn by the circle of its radius."""
        return isinstance(self.mark, Rim)

    def holonomic(self, contact: Contact) -> bool:
        """Tell whether a contact holds a position too: that of a wheel or a ball on its plane."""
        return any(self.touch.holonomic(contact))

    def length(self, rope: Row) -> Quantity:
        assert isinstance(self.law, Hold), "a rope holds a length"
        return self.law.length(rope)

    def formula(self, row: Row) -> Quantity | None:
        """Return the left side of a row that is a formula, which vanishes; None for a contact or a rope."""
        return self.law.formula(row) if isinstance(self.law, Forbid) else None
