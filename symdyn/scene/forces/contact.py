"""Contacts: a blade, a wheel or a ball touches a plane of another body.

    X    placement of the frame at P in that of the plane; P is the blade's point, or the centre O of a wheel
    a    axis of a wheel, or direction across a blade, axes of the plane's body
    n    normal of the plane        w    |a × n|, the sine of the angle between them
    d    from O to the point of the rim that is lowest; -r n for a ball

A contact's wrenches are the forces at the lowest point, moved to O. The one along n has a residual, the height of that
point, n·p - r w, whose rate it is; the others say nothing about places.

Reference: Neimark and Fufaev, Dynamics of Nonholonomic Systems (1972), chapter 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.scene.forces.attachments import AtBody, OnPlane
from symdyn.scene.forces.force_kind import ForceKind, Rim, Touch
from symdyn.scene.joints.blocks import forces, unit
from symdyn.scene.values.entry import Entry, EntryReader, Number, Three, entry, plain, show
from symdyn.scene.values.joint import Contact, Plane
from symdyn.scene.values.key import Key, number
from symdyn.scene.values.quantity import NULL, Quantity, Vector, spell
from symdyn.scene.values.shape import VECTOR, choice_of, several
from symdyn.spatial import Transform, Vec, Wrench, cross, dot, scale, sub

ACROSS: Vector = (Quantity.ZERO, Quantity.ONE, Quantity.ZERO)

COMPONENTS = ("along", "across", "normal")

AXIS_HOLDS = "of the wheel, or across the blade, in the frame of the body; any length but zero"


def _axis(table: EntryReader, key: str, ball: Vector | None) -> Vector | None:
    return table.vector(key, ACROSS) if key in table else ball


def _usual(ball: bool) -> tuple[str, ...]:
    """Return the components that vanish where nothing is said."""
    return COMPONENTS if ball else COMPONENTS[:2]


def _components(table: EntryReader, key: str, _: tuple[str, ...]) -> tuple[str, ...]:
    usual = _usual("axis" not in table)
    raw = plain(table.raw.get(key, usual))
    some = isinstance(raw, (list, tuple)) and raw and all(one in COMPONENTS for one in raw)
    if not isinstance(raw, (list, tuple)) or not some or len(set(raw)) < len(raw):
        table.fault(
            f'{key} = {show(raw)} is not a list of "along", "across" and "normal"; leave it out for '
            f"{' and '.join(usual) if len(usual) == 2 else 'all three'}"
        )
        return usual
    return tuple(raw)


# Wrenches


def _blade(row: Contact, X: Transform, w: Expr) -> tuple[Wrench, ...]:
    assert row.axis is not None, "a blade has a direction across it"
    return forces(X.R @ unit(row.axis, w.graph))


def _rolling(row: Contact, X: Transform, w: Expr) -> tuple[Wrench, ...]:
    graph = w.graph
    n, r = unit(row.plane.normal, graph), row.radius.express(graph)
    if row.axis is None:
        along, d = in_plane(n), scale(-r, n)
        ways = {"along": _at_rim(along, d), "across": _at_rim(cross(n, along), d), "normal": forces(n)[0]}
        return tuple(ways[component] for component in row.components)
    a = X.R @ unit(row.axis, graph)
    if w.is_zero:
        raise DerivationError(
            f"rows.{row.name}: {row.place.body} lies flat on its plane wherever the joints stand, "
            "its axis along the normal, so that no point of its rim is the lowest; turn the axis of the wheel"
        )
    d = scale(-r / w, sub(n, scale(dot(n, a), a)))
    ways = {
        "along": Wrench(scale(1 / w, cross(a, n)), scale(-r, a)),
        "across": _at_rim(scale(1 / w, cross(n, cross(a, n))), d),
        "normal": _at_rim(n, d),
    }
    return tuple(ways[component] for component in row.components)


def _at_rim(force: Vec, d: Vec) -> Wrench:
    return Wrench(force, cross(d, force))


def _rise(row: Contact, X: Transform, w: Expr) -> Expr:
    """Return how far the point of a blade is off its plane, m."""
    return dot(unit(row.plane.normal, w.graph), X.p)


def _height(row: Contact, X: Transform, w: Expr) -> Expr:
    """Return how far the lowest point of a wheel or a ball is off its plane, m."""
    return _rise(row, X, w) - row.radius.express(w.graph) * w


def _lean(row: Contact, X: Transform) -> Vec | None:
    graph = X.p[0].graph
    return cross(X.R @ unit(row.axis, graph), unit(row.plane.normal, graph)) if row.axis else None


def in_plane(n: Vec) -> Vec:
    """Return a unit vector of a plane: its x, unless the normal is along it."""
    graph = n[0].graph
    x, y = (graph.one, graph.zero, graph.zero), (graph.zero, graph.one, graph.zero)
    axis = y if n[1].is_zero and n[2].is_zero else x
    way = sub(axis, scale(dot(axis, n), n))
    return scale(graph.one / graph.sqrt(dot(way, way)), way)


def _words(row: Contact) -> tuple[str, ...]:
    track = {way: "" if row.axis is None else f"force {way} the track" for way in ("along", "across")}
    return tuple((track | {"normal": "normal force"})[component] for component in row.components)


# The kinds


def _three(vector: Vector) -> str:
    return f"[{', '.join(spell(x) for x in vector)}]"


def _where(plane: Plane) -> str:
    return f"the plane of {plane.body} through {_three(plane.at)}, normal {_three(plane.normal)}"


def _law_of_blade(row: Contact) -> str:
    on = f" on {_where(row.plane)}" if row.plane.declared else ""
    return f"{row.place.body} does not slide along its {_three(row.axis or NULL)} at {_three(row.place.at)}{on}"


def _law_of_rolling(row: Contact) -> str:
    kind = f"ball of radius {spell(row.radius)}"
    if row.axis is not None:
        kind = f"wheel of radius {spell(row.radius)} about its {_three(row.axis)}"
    height = "" if "normal" in row.components else "; its height is not held"
    return f"{row.place.body}, a {kind}, rolls on {_where(row.plane)} ({', '.join(row.components)}{height})"


LOST = "a constraint on velocities"

KNIFE_EDGE = ForceKind(
    section="rows",
    noun=partial(Contact, type="knife_edge"),
    letter="r",
    parts=(
        AtBody(),
        Key("axis", EntryReader.vector, ACROSS, example="axis = [0, 1, 0]", names=None, holds=AXIS_HOLDS),
        OnPlane(needs_normal=False),
    ),
    law=Touch(lambda _, X: None, _blade, _rise, lambda _: (False,), lambda _: ("force across the blade",)),
    law_words=_law_of_blade,
    words={"en": "knife edge", "sk": "čepeľ"},
    lost=LOST,
)

ROLLING = ForceKind(
    section="rows",
    noun=partial(Contact, type="rolling"),
    letter="r",
    parts=(
        AtBody(),
        Key("axis", _axis, None, names=None, shape=VECTOR, holds=AXIS_HOLDS),
        number(
            "radius",
            "m",
            example="radius = 0.1",
            above_zero="is that of no wheel; give one above zero",
            letters=("r",),
            text="radius of {}",
            positive=True,
            geometry=True,
        ),
        OnPlane(needs_normal=True),
        Key[tuple[str, ...]](
            "components",
            _components,
            (),
            silent=lambda row: row.components == _usual(row.axis is None),
            holds="of the velocity of the point that touches, which vanish",
            shape=several(choice_of(*COMPONENTS), 1, 9),
        ),
    ),
    law=Touch(_lean, _rolling, _height, lambda row: tuple(one == "normal" for one in row.components), _words),
    law_words=_law_of_rolling,
    words={"en": "rolling contact", "sk": "valenie"},
    lost=LOST,
    mark=Rim(),
)


def knife_edge(
    name: str,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    axis: Three,
    plane: Mapping[str, object] | None = None,
) -> Entry:
    """Declare a point of a body that has no velocity along an axis of the body, the one across the blade.

    With a plane {"body": name, "at": [x, y, z], "normal": [x, y, z]} the velocity is relative to the body that carries
    it, the ground when left out.
    """
    return entry("rows", type="knife_edge", **locals())


def rolling(
    name: str,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    axis: Three | None = None,
    radius: Number,
    plane: Mapping[str, object] | None = None,
    normal: Three | None = None,
    components: Sequence[str] | None = None,
) -> Entry:
    """Declare a wheel, disc or ball that rolls on a plane without slip, see `Row`.

    Args:
        name: of the constraint.
        body: the wheel.
        at: its centre in body coordinates, m; the origin when left out.
        point: its centre, in place of body and place.
        axis: of the wheel, body axes; left out for a ball.
        radius: of the wheel, m.
        plane: {"body": name, "at": [x, y, z], "normal": [x, y, z]}, in coordinates of that body; what is left out is
            the ground, its origin, and the direction against gravity.
        normal: of the plane, in place of `plane`: then the scene does not say where it lies.
        components: of the velocity of its lowest point, those that vanish: of "along", "across" and "normal", the last
            of which holds it at its height too; for a wheel the first two when left out, for a ball all.
    """
    return entry("rows", type="rolling", **locals())
