"""Springs, dampers, loads and rows in Python: the same words as in a TOML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.scene.element import Place
from symdyn.scene.python_values import Number, Three, entry
from symdyn.scene.quantity import Quantity
from symdyn.scene.table import Entry

End = str | Place | Mapping[str, object]


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
    return entry("springs", name, joint=joint, **_ends(ends), stiffness=stiffness, free=free, preload=preload)


def damper(
    name: str,
    *,
    joint: str | None = None,
    ends: tuple[End, End] | None = None,
    damping: Number | Sequence[Number],
) -> Entry:
    """Declare a viscous damper: c1, or c1, c3, ... of the force c1 v + c3 v^3 + ...; ends as in `spring`."""
    return entry("dampers", name, joint=joint, **_ends(ends), damping=damping)


def load(
    name: str,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    force: Three | None = None,
    couple: Three | None = None,
    frame: str | None = None,
) -> Entry:
    """Declare a wrench on a body.

    Args:
        name: of the load.
        body: that it acts on.
        at: the place in body coordinates, m; the origin when left out.
        point: that it acts at, in place of body and place.
        force: N, formulas in t, parameters, coordinates and velocities.
        couple: N m, the same.
        frame: "ground" or "body", whose axes the components are along; the ground's when left out.
    """
    return entry("loads", name, body=body, at=at, point=point, force=force, couple=couple, frame=frame)


def row(name: str, formula: str | Quantity) -> Entry:
    """Declare a constraint on velocities: a formula, linear in them, that vanishes."""
    return entry("rows", name, formula=formula)


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
    return entry("rows", name, type="knife_edge", body=body, at=at, point=point, axis=axis, plane=plane)


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
    where = {"body": body, "at": at, "point": point}
    more = {"plane": plane, "normal": normal, "components": components}
    return entry("rows", name, type="rolling", **where, axis=axis, radius=radius, **more)


def _ends(ends: tuple[End, End] | None) -> dict[str, object]:
    return {} if ends is None else {"from": ends[0], "to": ends[1]}
