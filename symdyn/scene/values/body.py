"""A body of a scene: its mass, inertia, particles and outline, where things stand on it, and how they are turned.

An inertia matrix I about the centre of mass belongs to some distribution of mass when tr(I)/2 · 1 - I, the matrix of
second moments ∫ r rᵀ dm, is positive semidefinite. In principal moments: none is negative, and none is more than the
sum of the other two (Wensing, Kim & Slotine 2018). Principal minors decide it, exactly where all numbers are rational.

Of turns it is told which multiples of π an angle is, what brings the z axis to a direction, and where a placement
leads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations
from math import isfinite

from symdyn.errors import listed
from symdyn.frozen import dataclass
from symdyn.graph import Graph, Op
from symdyn.scene.values import folding
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, Value, Vector, spell
from symdyn.spatial import Transform, Vec


@dataclass(frozen=True)
class Pose:
    """A placement as a product of elementary motions, read from left to right.

    Attributes:
        steps: pairs of "Tx", "Ty", "Tz" (m), "Rx", "Ry" or "Rz" (rad) and an amount; () is the identity.
    """

    steps: tuple[tuple[str, Quantity], ...] = ()

    def transform(self, graph: Graph) -> Transform:
        result = Transform.unit(graph)
        for kind, amount in self.steps:
            result = result @ Transform.elementary(kind, amount.express(graph))
        return result

    def inverse(self) -> Pose:
        return Pose(inverse_steps(self.steps))


UNMOVED = Pose()
"""Where a frame itself is."""

ELEMENTARY = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")


@dataclass(frozen=True)
class Particle:
    """A point mass fixed to a body: mass in kg, place in body coordinates, m."""

    mass: Quantity
    at: Vector


@dataclass(frozen=True)
class Outline:
    """What a body looks like, a word of the scene: for pictures, no part of the equations.

    Attributes:
        type: a key of `OUTLINES`.
        sizes: its lengths by name, m; those that are left out follow from the inertia.
        axis: that it is round about, or lies along (a rod) or across (a plate), in body coordinates; None: the inertia
            tells.
    """

    type: str
    sizes: tuple[tuple[str, Quantity], ...] = ()
    axis: Vector | None = None


Share = tuple[float, float, float]


@dataclass(frozen=True)
class OutlineKind:
    """A word of the key `shape`.

    Attributes:
        sizes: what its lengths are called, m; each by shares c of the principal moments I1 <= I2 <= I3 about the
            centre of mass, of which it is the root of (c1 I1 + c2 I2 + c3 I3) / mass.
        ways: how many directions it extends in, of those of I1, I2, I3 in order.
        half: whether sizes are whole lengths, of which pictures draw half to each side.
        axis: the principal moment about whose axis it is round, or along or across which it lies; None: it has none.
        rolls: whether the rim of what rolls looks like it already.
    """

    sizes: Mapping[str, Share]
    ways: int
    half: bool = False
    axis: int | None = None
    rolls: bool = True


OUTLINES: Mapping[str, OutlineKind] = {
    "rod": OutlineKind({"length": (0, 0, 12)}, 1, half=True, axis=0, rolls=False),
    "disc": OutlineKind({"radius": (0, 0, 2)}, 2, axis=2),
    "ring": OutlineKind({"radius": (0, 0, 1)}, 2, axis=2),
    "ball": OutlineKind({"radius": (0, 0, 5 / 2)}, 3),
    "plate": OutlineKind({"width": (0, 12, 0), "height": (12, 0, 0)}, 2, half=True, axis=2, rolls=False),
    "point": OutlineKind({}, 0),
}
"""Thin rods, discs and plates, a thin ring, a full ball (tables of moments of inertia in any textbook)."""


@dataclass(frozen=True)
class Body:
    """A rigid body: an extended mass, point masses, or both.

    Attributes:
        mass: mass of the extended part, kg; the particles come on top.
        com: its centre of mass in body coordinates, m; None when `first_moment` is declared.
        first_moment: mass times centre of mass, kg m; None when `com` is declared.
        inertia: matrix entries (xx, yy, zz, xy, xz, yz) along the body axes, kg m^2; products enter as matrix
            entries, the negative of the textbook's D.
        about: "com" or "frame" (the origin of the body frame): the point that `inertia` refers to.
        particles: point masses fixed to the body.
        allow_invalid_inertia: the user knows that no real body has this inertia and wants it all the same.
        shape: what it looks like; None: as its inertia tells.
        text: a description, which lessons and pictures call it by.
        texts: the same in other languages: ("sk", description).
    """

    name: str
    mass: Quantity = Quantity.ZERO
    com: Vector | None = NULL
    first_moment: Vector | None = None
    inertia: tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity] = (Quantity.ZERO,) * 6
    about: str = "com"
    particles: tuple[Particle, ...] = ()
    allow_invalid_inertia: bool = False
    shape: Outline | None = None
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()

    @property
    def centre(self) -> Vector:
        """The centre of mass of the extended part in body coordinates, m."""
        x, y, z = self.com or (folding.div(h, self.mass) for h in self.first_moment or NULL)
        return (x, y, z)

    def mass_moment(self, graph: Graph) -> Vec:
        """Return m r of the extended mass, kg m, body frame."""
        if self.first_moment is not None:
            x, y, z = self.first_moment
            return (x.express(graph), y.express(graph), z.express(graph))
        assert self.com is not None
        m, (x, y, z) = self.mass.express(graph), self.com
        return (m * x.express(graph), m * y.express(graph), m * z.express(graph))


Matrix = list[list[Value]]

TOO_LARGE = "its entries are beyond the largest double"
"""The condition that no inertia breaks on paper: the matrix, or what it is moved to, has no value."""

ROUNDING = 1e-12
"""Slack relative to the largest entry when some entry is a float; exact numbers get none."""

SMALLEST = Fraction(1, 10**17)
"""By how much principal moments may break a condition, kg m^2: less is the rounding of whoever wrote them down."""

PLAINLY = 0.1
"""A moment below zero is told where it is at least this part of what the triangle inequality is broken by, the worse of
both: beside that it may be rounding of a zero."""


def mass_faults(body: Body, values: Mapping[str, Value]) -> list[str]:
    """Return what is wrong with the masses of a body, as far as the values are known."""
    faults = []
    masses = [("mass", body.mass)] + [(f"particles[{k}]: mass", p.mass) for k, p in enumerate(body.particles)]
    for label, quantity in masses:
        mass = _known([quantity], values)
        if mass and mass[0] < 0:
            by = f"{spell(quantity)} = " if quantity.symbols else ""
            cure = f"correct {listed(quantity.symbols)}" if by else "give a mass of zero or more"
            faults.append(f"{label} = {by}{_short(mass[0])} is negative; {cure}")
    return faults


def inertia_fault(body: Body, values: Mapping[str, Value]) -> tuple[str, str] | None:
    """Return what is wrong with the inertia of a body and what would mend it, None if a body can have it."""
    try:
        matrix = central_inertia(body, values)
        if matrix is None:
            mass = _known([body.mass], values)
            if mass and mass[0] == 0 and body.first_moment and any(_known(body.first_moment, values) or ()):
                return "first_moment is not zero but the mass is", "give a mass"
            return None
        condition = impossible(matrix)
    except OverflowError:
        condition = TOO_LARGE
    if condition is None:
        return None
    about = "as given" if body.about == "com" else "moved to the centre of mass"
    return f"inertia ({about}) is not physically consistent: {condition}", "check the numbers and inertia_about"


def central_inertia(body: Body, values: Mapping[str, Value]) -> Matrix | None:
    """Return the inertia matrix of the extended part about its centre of mass, kg m^2; None if it is not known.

    From the frame to the centre of mass: I_com = I_frame - (h·h 1 - h hᵀ) / m, with the first moment h = m r.
    """
    entries = _known(body.inertia, values)
    if entries is None:
        return None
    xx, yy, zz, xy, xz, yz = entries
    matrix: Matrix = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    if body.about == "com":
        return matrix
    mass, moment = _known([body.mass], values), _first_moment(body, values)
    if mass is None or moment is None:
        return None
    if not any(moment):
        return matrix
    if mass[0] == 0:
        return None
    square = sum((h * h for h in moment), start=Fraction(0))
    for i in range(3):
        for j in range(3):
            matrix[i][j] -= ((square if i == j else 0) - moment[i] * moment[j]) / mass[0]
    return matrix


def impossible(matrix: Matrix) -> str | None:
    """Return the condition that an inertia matrix about the centre of mass breaks, None if a body can have it."""
    if _is_plain(matrix):
        return None
    largest = max(max(x, -x) for row in matrix for x in row)
    if not largest:
        return None
    if not all(isinstance(x, Fraction) or isfinite(x) for row in matrix for x in row):
        return TOO_LARGE
    slack = SMALLEST / (largest if isinstance(largest, Fraction) else Fraction(largest))
    scaled = [[x / largest + (slack if i == j else 0) for j, x in enumerate(row)] for i, row in enumerate(matrix)]
    half = (scaled[0][0] + scaled[1][1] + scaled[2][2]) / 2
    moments = [[(half if i == j else Fraction(0)) - scaled[i][j] for j in range(3)] for i in range(3)]
    if _semidefinite(scaled) and _semidefinite(moments):
        return None
    if any(matrix[i][j] for i, j in combinations(range(3), 2)):
        import numpy as np

        found = np.linalg.eigvalsh(np.array(matrix, dtype=float)).tolist()
        rounding = ROUNDING * max(map(abs, found))
        small, middle, large = (x if abs(x) > rounding else 0.0 for x in found)
        names, kind = ("I1", "I2", "I3"), "principal moments"
    else:
        ordered = sorted(range(3), key=lambda k: matrix[k][k])
        small, middle, large = (float(matrix[k][k]) for k in ordered)
        labels = ("Ixx", "Iyy", "Izz")
        names, kind = (labels[ordered[0]], labels[ordered[1]], labels[ordered[2]]), "moments"
    shown = ", ".join(f"{name} = {_short(x)}" for name, x in zip(names, (small, middle, large), strict=True))
    short = large - middle - small
    if small < 0 and -small >= PLAINLY * short:
        return f"of its {kind} {shown}, {names[0]} is negative (it must be positive semidefinite)"
    part = f"{100 * short / large:.3g} %" if short > ROUNDING * large else "less than 1e-10 %"
    across = ", ".join("J" if name == names[2] else "J/2" for name in ("Ixx", "Iyy", "Izz"))
    flat = f", and a flat body has [{across}]" if small == middle == 0 else ""
    broken = f"break the triangle inequality {names[0]} + {names[1]} >= {names[2]} by {part}"
    return f"its {kind} {shown} {broken} ({names[0]} + {names[1]} = {_short(small + middle)}){flat}"


def _is_plain(m: Matrix) -> bool:
    """Tell whether a matrix is exact, diagonal and that of a body, as nearly all are."""
    (a, d, e), (_, b, f), (_, _, c) = m
    if d or e or f or not (type(a) is type(b) is type(c) is Fraction):
        return False
    return a >= 0 and b >= 0 and c >= 0 and a <= b + c and b <= c + a and c <= a + b


def _semidefinite(m: Matrix) -> bool:
    """Tell whether all seven principal minors are not negative; the entries are of order one."""
    slack = 0.0 if all(isinstance(x, Fraction) for row in m for x in row) else ROUNDING
    determinant = (
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    )
    minors = [m[i][i] * m[j][j] - m[i][j] * m[i][j] for i, j in combinations(range(3), 2)]
    return all(minor >= -slack for minor in (m[0][0], m[1][1], m[2][2], *minors, determinant))


def _first_moment(body: Body, values: Mapping[str, Value]) -> list[Value] | None:
    if body.first_moment is not None:
        return _known(body.first_moment, values)
    place, mass = _known(body.com or (), values), _known([body.mass], values)
    return None if place is None or mass is None else [mass[0] * x for x in place]


def _known(quantities: Sequence[Quantity], values: Mapping[str, Value]) -> list[Value] | None:
    """Return all values, None if one is unknown or does not exist (which is reported where the formula stands)."""
    try:
        found = [quantity.at(values) for quantity in quantities]
    except FormulaError:
        return None
    known = [value for value in found if value is not None]
    return known if len(known) == len(found) else None


def _short(value: Value) -> str:
    return f"{float(value):.6g}"


Step = tuple[str, Quantity]

RIGHT = folding.mul(Quantity.number(Fraction(1, 2)), Quantity.PI)


def turns(angle: Quantity) -> Fraction | None:
    """Return k of an angle k π, None for any other angle."""
    if angle == Quantity.ZERO:
        return Fraction(0)
    if angle == Quantity.PI:
        return Fraction(1)
    if angle.op is Op.NEG:
        inner = turns(angle.args[0])
        return None if inner is None else -inner
    if angle.op is Op.MUL and angle.args[1] == Quantity.PI:
        return folding.fraction(angle.args[0])
    return None


def plus(a: Quantity, b: Quantity) -> Quantity:
    """Return the sum of two angles; multiples of π add up to one."""
    x, y = turns(a), turns(b)
    return folding.add(a, b) if x is None or y is None else folding.mul(Quantity.number(x + y), Quantity.PI)


def quarter_turns(angle: Quantity) -> int | None:
    """Return k of an angle k π/2, modulo four; None for any other angle."""
    found = turns(angle)
    return int(found * 2) % 4 if found is not None and (found * 2).denominator == 1 else None


def inverse_steps(steps: Sequence[Step]) -> tuple[Step, ...]:
    """Return the steps that undo a placement."""
    return tuple((kind, folding.neg(amount)) for kind, amount in reversed(steps))


def towards(axis: Vector) -> tuple[Step, ...]:
    """Return a rotation that takes z to the direction of an axis of any length, free of symbols."""
    x, y, z = axis
    if x == Quantity.ZERO and y == Quantity.ZERO:
        return (("Rx", Quantity.PI),) if _negative(z) else ()
    if y == Quantity.ZERO and z == Quantity.ZERO:
        return (("Ry", folding.neg(RIGHT) if _negative(x) else RIGHT),)
    if x == Quantity.ZERO and z == Quantity.ZERO:
        return (("Rx", RIGHT if _negative(y) else folding.neg(RIGHT)),)
    across = folding.power(folding.add(folding.mul(x, x), folding.mul(y, y)), Quantity.number(Fraction(1, 2)))
    return (("Rz", folding.function(Op.ATAN2, y, x)), ("Ry", folding.function(Op.ATAN2, across, z)))


def _negative(x: Quantity) -> bool:
    value = x.at({})
    assert value is not None, "an axis is free of symbols"
    return value < 0


def circular(op: Op, angle: Quantity) -> Quantity:
    """Return sin or cos (the operation) of an angle, as a number where it is rational."""
    value = folding.function(op, angle).express(Graph())
    return Quantity.number(value.value) if value.op is Op.CONSTANT else folding.function(op, angle)  # type: ignore[arg-type]


def cosine_and_sine(angle: Quantity) -> tuple[Quantity, Quantity]:
    """Return cosine and sine of an angle, whole numbers at right angles."""
    k = quarter_turns(angle)
    if k is None:
        return folding.function(Op.COS, angle), folding.function(Op.SIN, angle)
    return Quantity.number((1, 0, -1, 0)[k]), Quantity.number((0, 1, 0, -1)[k])


def translation(pose: Pose) -> Vector:
    """Return where a placement puts the origin, m."""
    r = list(NULL)
    for kind, amount in reversed(pose.steps):
        k = "xyz".index(kind[1])
        if kind[0] == "T":
            r[k] = folding.add(r[k], amount)
            continue
        i, j = (k + 1) % 3, (k + 2) % 3
        if r[i] == r[j] == Quantity.ZERO:
            continue
        c, s = cosine_and_sine(amount)
        r[i], r[j] = (
            folding.add(folding.mul(c, r[i]), folding.neg(folding.mul(s, r[j]))),
            folding.add(folding.mul(s, r[i]), folding.mul(c, r[j])),
        )
    return (r[0], r[1], r[2])
