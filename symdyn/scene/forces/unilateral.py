"""Contacts that open and close: a point, a ball or a wheel over a plane of another body, with friction and impacts.

    g    height of the lowest point over the plane, m          n    its Jacobian: ġ = n u
    s    velocity of that point along the plane, s = t u       λ    normal and tangential force, N

    0 ≤ g ⊥ λn ≥ 0                          Signorini: nothing pulls, and what does not touch does not push
    |λt| ≤ μs λn  where s = 0               Coulomb: it sticks
    λt = -μ λn sign(s)  elsewhere           it slips

An impact changes velocities at once, M (u⁺ - u⁻) = nᵀ Λn + tᵀ Λt. By Newton's law ġ⁺ = -e ġ⁻. By Poisson's law there
is a phase of compression, which ends where ġ = 0, and one of expansion, which gives back the part e of its impulse.
With friction Newton's law may gain energy. Where they lie is said as of rows that roll: what is lowest is the same.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5 to 8.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from symdyn.arguments import suggesting
from symdyn.scene.forces.attachments import AtBody, OnPlane
from symdyn.scene.forces.constraints import ACROSS, AXIS_HOLDS, ROLLING, linear_parts
from symdyn.scene.forces.force_kind import Forbid, ForceKind, Rub
from symdyn.scene.values.entry import Entry, EntryReader, Number, Three, entry, shown
from symdyn.scene.values.key import MOTION, Key, Part, Stand, number, one_of, optional
from symdyn.scene.values.quantity import FormulaError, Quantity, spell
from symdyn.scene.values.shape import NUMBER
from symdyn.scene.values.unilateral import DryJoint, GapContact, OneWay, PlaneContact, Stop, Unilateral

LAWS = ("poisson", "newton")

_RADIUS = next(part for part in ROLLING.parts if "radius" in part.keys)

RESTITUTION = number("restitution", "1", letters=("e",), text="restitution of {}", positive=True)

_LAW_OF_CONTACT: tuple[Part, ...] = (
    RESTITUTION,
    number("friction", "1", letters=("mu",), text="friction of {}", positive=True, never_negative=True),
    Key(
        "static",
        optional(EntryReader.quantity),
        None,
        unit="1",
        letters=("mus",),
        text="friction of {} while it sticks",
        positive=True,
    ),
    one_of("law", LAWS, "of impacts", LAWS[0]),
    Key(
        "active",
        optional(EntryReader.quantity),
        None,
        names=MOTION,
        shape=NUMBER,
        holds="above zero where what is open may strike, {}",
    ),
)


def check_law(one: Unilateral, stand: Stand) -> None:
    """Report a restitution that is none, and friction that is less where it sticks."""
    e = stand.value(one.restitution)
    if e is not None and not 0 <= e <= 1:
        stand.fault(f"restitution = {shown(one.restitution)} is not between 0 and 1")
    if one.static is None:
        return
    sticks, slips = stand.value(one.static), stand.value(one.friction)
    if sticks is not None and slips is not None and sticks < slips:
        told = f"static = {shown(one.static)} is less than friction = {shown(one.friction)}"
        stand.fault(f"{told}; what sticks holds as much as what slips, at least")


def _words(one: PlaneContact) -> str:
    size = f" of radius {spell(one.radius)}" if one.radius != Quantity.ZERO else ""
    return f"{one.place.body}, a {one.type}{size}, over a plane of {one.plane.body}, {_law_words(one)}"


def _law_words(one: Unilateral) -> str:
    return f"restitution {spell(one.restitution)}, friction {spell(one.friction)}, {one.law.capitalize()}'s law"


POINT = ForceKind(
    section="contacts",
    noun=partial(PlaneContact, type="point"),
    letter="u",
    parts=(AtBody(), OnPlane(needs_normal=True), *_LAW_OF_CONTACT),
    law=replace(ROLLING.touch, words=lambda _: ("normal force", "", "")),
    law_words=_words,
    words={"en": "contact", "sk": "kontakt"},
    lost="a contact that opens and closes",
    check=check_law,
)

BALL = replace(
    POINT,
    noun=partial(PlaneContact, type="ball"),
    parts=(AtBody(), _RADIUS, OnPlane(needs_normal=True), *_LAW_OF_CONTACT),
    mark=ROLLING.mark,
)

WHEEL = replace(
    BALL,
    noun=partial(PlaneContact, type="wheel"),
    parts=(
        AtBody(),
        Key("axis", EntryReader.vector, ACROSS, example="axis = [0, 1, 0]", names=None, holds=AXIS_HOLDS),
        *BALL.parts[1:],
    ),
)


def _check_gap(one: GapContact, stand: Stand) -> None:
    """Report what `check_law` does, and a tangent that is not linear in velocities."""
    check_law(one, stand)
    if moving := set(one.gap.symbols) & set(stand.scene.velocities):
        told = f"gap = {shown(one.gap)} uses {sorted(moving)[0]}"
        stand.fault(f"{told}; a gap is a formula in coordinates and parameters")
    if one.tangent is None:
        if one.friction != Quantity.ZERO:
            stand.fault('friction acts along a tangent; write tangent = "x_dot - r*phi_dot"')
        return
    try:
        slopes, rest = linear_parts(one.tangent, stand.scene.velocities)
    except FormulaError as error:
        stand.fault(f"tangent = {shown(one.tangent)} is not linear in the velocities: {error}")
        return
    if not rest.is_zero or not slopes:
        stand.fault(f"tangent = {shown(one.tangent)} is no sum of velocities, each times a formula in coordinates")


GAP = replace(
    POINT,
    noun=GapContact,
    parts=(
        number(
            "gap",
            "m",
            example='how far it is open, such as gap = "h0 - r*cos(phi)"',
            names=MOTION,
            holds="how far it is open, a formula in coordinates, {}",
        ),
        Key(
            "tangent",
            optional(EntryReader.quantity),
            None,
            names=MOTION,
            unit="m/s",
            shape=NUMBER,
            holds="the velocity with which it slips, {}",
        ),
        *_LAW_OF_CONTACT,
    ),
    law=Forbid(lambda one: one.gap),
    law_words=lambda one: f"{spell(one.gap)} ≥ 0, {_law_words(one)}",
    check=_check_gap,
)

STOP = ForceKind(
    section="joints",
    noun=Stop,
    letter="",
    parts=(),
    law=Rub(lambda _, rate: rate.graph.zero, jumps=lambda _: False),
    law_words=lambda one: f"{'upper' if one.upper else 'lower'} stop of {one.joint} at {spell(one.at)}",
    words={"en": "stop", "sk": "doraz"},
    lost="a stop",
)
"""What runs make of a limit with a restitution."""

DRY_JOINT = replace(
    STOP,
    noun=DryJoint,
    law_words=lambda one: f"dry friction of {one.joint}",
    words={"en": "dry friction", "sk": "suché trenie"},
    lost="dry friction",
)
"""What runs make of dry friction that is not smoothed."""


ONE_WAY = replace(
    STOP,
    noun=OneWay,
    law_words=lambda one: f"{one.joint} turns or slides one way",
    words={"en": "freewheel", "sk": "voľnobežka"},
    lost="a freewheel",
)
"""What runs make of a joint whose limits say `one_way`."""


@suggesting
def contact(
    name: str,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    axis: Three | None = None,
    radius: Number | None = None,
    plane: Mapping[str, object] | None = None,
    restitution: Number | None = None,
    friction: Number | None = None,
    static: Number | None = None,
    law: str | None = None,
    active: Number | None = None,
    text: str = "",
) -> Entry:
    """Declare a contact of a body with a plane that opens and closes, see `Unilateral`.

    Args:
        name: of the contact.
        body: what touches: a point of it; a ball with a radius, a wheel with a radius and an axis.
        at: the point, or the centre of the ball or the wheel, in body coordinates, m; the origin when left out.
        point: the same, in place of body and place.
        axis: of a wheel, body axes.
        radius: of a ball or a wheel, m.
        plane: {"body": name, "at": [x, y, z], "normal": [x, y, z]}, as of `rolling`.
        restitution: 0 to 1; 0 when left out.
        friction: Coulomb's coefficient while it slips; 0 when left out.
        static: while it sticks; the same when left out.
        law: of impacts, "poisson" when left out, or "newton".
        active: what is open may strike where this formula in coordinates is above zero, and passes elsewhere.
        text: a description, as of `spring`.
    """
    said = dict(locals())
    return entry("contacts", type="point" if radius is None else "ball" if axis is None else "wheel", **said)


@suggesting
def gap_contact(
    name: str,
    gap: Number,
    *,
    tangent: Number | None = None,
    restitution: Number | None = None,
    friction: Number | None = None,
    static: Number | None = None,
    law: str | None = None,
    active: Number | None = None,
    text: str = "",
) -> Entry:
    """Declare a contact by formulas: `gap`, in coordinates, m, and `tangent`, the velocity with which it slips."""
    said = dict(locals())
    return entry("contacts", type="gap", **said)
