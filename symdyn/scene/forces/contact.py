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

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.scene.direction import direction
from symdyn.scene.element import Plane, Row
from symdyn.scene.folding import FormulaError
from symdyn.scene.forces.ends import AtBody, known_body, named_shift
from symdyn.scene.forces.keys import NUMBER, Form, Key, indexed
from symdyn.scene.forces.kind import PARAMETERS, ForceKind, Part, Rim, Scope, Stand, Touch
from symdyn.scene.joints.blocks import unit
from symdyn.scene.joints.forbidden import forces
from symdyn.scene.made_names import Names
from symdyn.scene.model import GROUND
from symdyn.scene.quantity import NULL, ONE, ZERO, Quantity, Vector, express
from symdyn.scene.spelling import spell
from symdyn.scene.table import Table, plain, show, shown
from symdyn.scene.value import value_of
from symdyn.spatial import Transform, Vec, Wrench, apply, cross, dot, scale, sub

ACROSS: Vector = (ZERO, ONE, ZERO)

COMPONENTS = ("along", "across", "normal")

TILT = "tilt a body that carries it"


# The plane and the components of a wheel's velocity


class OnPlane(Part):
    """The plane that is touched; level where nothing else is said of a plane of the ground that has to be somewhere."""

    def __init__(self, needs_normal: bool) -> None:
        """Say whether the plane has to be somewhere, as a blade's has not."""
        self.needs_normal = needs_normal
        self.keys = ("plane", "normal") if needs_normal else ("plane",)

    def read(self, table: Table, scope: Scope) -> dict[str, Any]:
        """Return the plane that a row declares."""
        declared, where = "plane" in table, table
        if declared:
            advice = "write plane = { at = [0, 0, 0], normal = [0, 0, 1] }"
            advice = f"{advice}, with body = NAME where it is not the ground's"
            where = table.inner("plane", ("body", "at", "normal"), advice)
            if "normal" in table:
                table.fault("normal is given beside plane; write it into plane")
        body = where.text("body", GROUND) if declared else GROUND
        at = where.vector("at") if declared else NULL
        normal = where.vector("normal", Plane().normal)
        if "normal" not in where and self.needs_normal and body != GROUND:
            where.fault(f'normal is missing; a plane on body "{body}" has one of its own, such as normal = [0, 0, 1]')
        elif "normal" not in where and (self.needs_normal or declared):
            if isinstance(scope.level, str):
                where.fault(f"normal is missing, and {scope.level}; write normal = [0, 0, 1]")
            else:
                normal = scope.level
                if normal != Plane().normal:
                    text = ", ".join(spell(x) for x in normal)
                    table.faults.note(table.entry.where, f"its plane is level: normal = [{text}], against gravity")
        return {"plane": Plane(body, at, normal, declared)}

    def raw(self, one: Row, scope: Scope) -> dict[str, object]:
        """Return what a table says of the plane."""
        plane = one.plane
        if not plane.declared:
            return {"normal": plane.normal} if self.needs_normal and plane.normal != scope.level else {}
        fixed = plane.body == GROUND
        said: dict[str, object] = {} if fixed else {"body": plane.body}
        said |= {"at": plane.at} if plane.at != NULL else {}
        return {"plane": said if fixed and plane.normal == scope.level else said | {"normal": plane.normal}}

    def numbers(self, one: Row) -> Iterator[tuple[str, Quantity, int]]:
        """Return where the plane is."""
        yield from ((f"plane.at{index}", x, PARAMETERS) for index, x in indexed(one.plane.at))

    def named(self, one: Row, what: str, letter: str, k: int, names: Names) -> Row:
        """Return the row with the place of its plane named."""
        if what != "geometry":
            return one
        at = named_shift(one.plane.at, f"plane of {one.name}", f"_g{k}", names)
        return replace(one, plane=replace(one.plane, at=at))

    def check(self, one: Row, stand: Stand) -> None:
        """Report a plane of no body, or of the body that touches it, and a normal that is no direction."""
        known_body("plane: body", one.plane.body, stand)
        body = one.place.body if one.place else ""
        if body == one.plane.body == GROUND:
            stand.fault(f"is about {GROUND}, which does not move; name a body")
        elif body and body == one.plane.body:
            stand.fault(f'touches a plane on its own body, "{body}"; name another body')
        if one.axis is not None:
            direction(stand.where, "axis", one.axis, stand.faults, "turn the body's frame")
        key = "plane: normal" if one.plane.declared else "normal"
        direction(stand.where, key, one.plane.normal, stand.faults, TILT)


def _axis(table: Table, key: str, _: object, absent: Vector | None) -> Vector | None:
    return table.vector(key, ACROSS) if key in table else absent


def _usual(ball: bool) -> tuple[str, ...]:
    """Return the components that vanish where nothing is said."""
    return COMPONENTS if ball else Row("").components


def _components(table: Table, key: str, _: object) -> tuple[str, ...]:
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


def _blade(row: Row, X: Transform, w: Expr) -> tuple[Wrench, ...]:
    assert row.axis is not None, "a blade has a direction across it"
    return forces(apply(X.R, unit(row.axis, w.graph)))


def _rolling(row: Row, X: Transform, w: Expr) -> tuple[Wrench, ...]:
    graph = w.graph
    n, r = unit(row.plane.normal, graph), express(row.radius, graph)
    if row.axis is None:
        along, d = in_plane(n), scale(-r, n)
        ways = {"along": _at_rim(along, d), "across": _at_rim(cross(n, along), d), "normal": forces(n)[0]}
        return tuple(ways[component] for component in row.components)
    a = apply(X.R, unit(row.axis, graph))
    if w.is_zero:
        raise DerivationError(
            f"rows.{row.name}: {row.place.body if row.place else ''} lies flat on its plane wherever the joints stand, "
            "its axis along the normal, so that no point of its rim is the lowest; turn the axis of the wheel"
        )
    d = scale(-r / w, sub(n, scale(dot(n, a), a)))
    ways = {
        "along": (scale(1 / w, cross(a, n)), scale(-r, a)),
        "across": _at_rim(scale(1 / w, cross(n, cross(a, n))), d),
        "normal": _at_rim(n, d),
    }
    return tuple(ways[component] for component in row.components)


def _at_rim(force: Vec, d: Vec) -> Wrench:
    return force, cross(d, force)


def _rise(row: Row, X: Transform, w: Expr) -> Expr:
    """Return how far the point of a blade is off its plane, m."""
    return dot(unit(row.plane.normal, w.graph), X.p)


def _height(row: Row, X: Transform, w: Expr) -> Expr:
    """Return how far the lowest point of a wheel or a ball is off its plane, m."""
    return _rise(row, X, w) - express(row.radius, w.graph) * w


def _lean(row: Row, X: Transform) -> Vec | None:
    graph = X.p[0].graph
    return cross(apply(X.R, unit(row.axis, graph)), unit(row.plane.normal, graph)) if row.axis else None


def in_plane(n: Vec) -> Vec:
    """Return a unit vector of a plane: its x, unless the normal is along it."""
    graph = n[0].graph
    x, y = (graph.one, graph.zero, graph.zero), (graph.zero, graph.one, graph.zero)
    axis = y if n[1].is_zero and n[2].is_zero else x
    way = sub(axis, scale(dot(axis, n), n))
    return scale(graph.one / graph.sqrt(dot(way, way)), way)


def _words(row: Row) -> tuple[str, ...]:
    track = {way: "" if row.axis is None else f"force {way} the track" for way in ("along", "across")}
    return tuple((track | {"normal": "normal force"})[component] for component in row.components)


# The kinds


def _check_radius(row: Row, stand: Stand) -> None:
    try:
        radius = value_of(row.radius, stand.values)
    except FormulaError:
        return  # reported as a formula without a value
    if radius is not None and radius <= 0:
        stand.fault(f"radius = {shown(row.radius)} is that of no wheel; give one above zero")


def _three(vector: Vector) -> str:
    return f"[{', '.join(spell(x) for x in vector)}]"


def _where(plane: Plane) -> str:
    return f"the plane of {plane.body} through {_three(plane.at)}, normal {_three(plane.normal)}"


def _says_blade(row: Row) -> str:
    assert row.place is not None, "a blade is at a place"
    on = f" on {_where(row.plane)}" if row.plane.declared else ""
    return f"{row.place.body} does not slide along its {_three(row.axis or NULL)} at {_three(row.place.at)}{on}"


def _says_rolling(row: Row) -> str:
    assert row.place is not None, "a wheel is at a place"
    kind = f"ball of radius {spell(row.radius)}"
    if row.axis is not None:
        kind = f"wheel of radius {spell(row.radius)} about its {_three(row.axis)}"
    height = "" if row.touches else "; its height is not held"
    return f"{row.place.body}, a {kind}, rolls on {_where(row.plane)} ({', '.join(row.components)}{height})"


LOST = "a constraint on velocities"

KNIFE_EDGE = ForceKind(
    section="rows",
    noun=partial(Row, type="knife_edge"),
    letter="r",
    parts=(AtBody(), Key("axis", Form(partial(_axis, absent=ACROSS), ACROSS), names=None), OnPlane(needs_normal=False)),
    needs=("axis",),
    missing="axis is missing; write axis = [0, 1, 0]",
    law=Touch(lambda _, X: None, _blade, _rise, lambda _: (False,), lambda _: ("force across the blade",)),
    says=_says_blade,
    words={"en": "knife edge", "sk": "čepeľ"},
    lost=LOST,
)

ROLLING = ForceKind(
    section="rows",
    noun=partial(Row, type="rolling"),
    letter="r",
    parts=(
        AtBody(),
        Key("axis", Form(partial(_axis, absent=None), None), silent=lambda row: row.axis is None, names=None),
        Key("radius", NUMBER, letters=("r",), unit="m", text="radius of {}", positive=True, geometry=True),
        OnPlane(needs_normal=True),
        Key("components", Form(_components, None), silent=lambda row: row.components == _usual(row.axis is None)),
    ),
    needs=("radius",),
    missing="radius is missing; write radius = 0.1",
    law=Touch(_lean, _rolling, _height, lambda row: tuple(one == "normal" for one in row.components), _words),
    says=_says_rolling,
    words={"en": "rolling contact", "sk": "valenie"},
    lost=LOST,
    mark=Rim(),
    check=_check_radius,
)
