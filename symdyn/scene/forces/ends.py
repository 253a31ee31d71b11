"""Where elements act: at a joint or between two points, at a place of a body, at a plane."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from symdyn.scene.forces.keys import along, indexed
from symdyn.scene.forces.kind import PARAMETERS, Part, Scope, Stand
from symdyn.scene.values.element import Place, Strut
from symdyn.scene.values.made_names import Names
from symdyn.scene.values.model import GROUND
from symdyn.scene.values.names import suggestion
from symdyn.scene.values.quantity import NULL, Quantity, Vector
from symdyn.scene.values.table import Table, plain, show
from symdyn.scene.values.translation import translation

End = str | Place | Mapping[str, object]
"""What a user writes for an end in Python."""

ADVICE = 'write joint = "NAME", or from and to, each the name of a body or point or { body = "NAME", at = [0, 0, 0] }'


class Ends(Part):
    """The joint of a strut, or the two points between which it is."""

    keys = ("joint", "from", "to")

    def read(self, table: Table, scope: Scope) -> dict[str, Any]:
        """Return the joint that it is at, or the points that it connects."""
        given = [key for key in self.keys if key in table]
        if given == ["joint"]:
            return {"joint": table.text("joint")}
        if given == ["from", "to"]:
            return {"ends": (_end(table, "from", scope), _end(table, "to", scope))}
        table.fault(f"has {' and '.join(given) or 'neither joint nor from and to'}; {ADVICE}")
        return {}

    def raw(self, one: Strut, scope: Scope) -> dict[str, object]:
        """Return the joint, or both ends as tables."""
        joint: dict[str, object] = {"joint": one.joint} if one.joint else {}
        return joint | {key: table_of(end) for key, end in zip(self.keys[1:], one.ends, strict=False)}

    def numbers(self, one: Strut) -> Iterator[tuple[str, Quantity, int]]:
        """Return where the ends are."""
        for key, end in zip(self.keys[1:], one.ends, strict=False):
            yield from ((f"{key}.at{index}", x, PARAMETERS) for index, x in indexed(end.at))

    def named(self, one: Strut, what: str, letter: str, k: int, names: Names) -> Strut:
        """Return it with the places of its ends named."""
        if what != "geometry":
            return one
        ends = (
            named_place(end, one.name, f"_{letter}{k}{side}", names) for side, end in zip("ft", one.ends, strict=False)
        )
        return replace(one, ends=tuple(ends))

    def check(self, one: Strut, stand: Stand) -> None:
        """Report a joint that is none, or has not one coordinate, and ends that are none, or never part."""
        scene, faults = stand.scene, stand.faults
        bodies = [*(body.name for body in scene.bodies), GROUND]
        if one.joint:
            joints = {joint.name: joint for joint in scene.joints}
            joint = joints.get(one.joint)
            if joint is None:
                stand.fault(f'joint = "{one.joint}" is not a joint of the tree; {suggestion(one.joint, joints)}')
            elif not joint.coordinate and joint.coupling is None:
                many = f"has {len(joint.coordinates)} coordinates" if joint.coordinates else "does not move"
                stand.fault(f'joint = "{one.joint}" {many}; name one with one, or two points by from and to')
        elif not one.ends:
            faults.nameless(stand.where, "joint", one.joint)
        for key, end in zip(self.keys[1:], one.ends, strict=False):
            faults.nameless(stand.where, key, end.body)
            if end.body and end.body not in bodies:
                near = suggestion(end.body, [*bodies, *(point.name for point in scene.points)])
                stand.fault(f'{key} = "{end.body}" is neither a body nor a point; {near}')
        if len(one.ends) == 2 and one.ends[0].body and one.ends[0].body == one.ends[1].body:
            stand.fault(f'from and to are on one body, "{one.ends[0].body}", so that it never changes its length')


class AtBody(Part):
    """A place of a body: the body and at, or a point."""

    keys = ("body", "point", "at")

    def read(self, table: Table, scope: Scope) -> dict[str, Any]:
        """Return the place."""
        return {"place": place_of(table, scope)}

    def raw(self, one: Any, scope: Scope) -> dict[str, object]:
        """Return body and place."""
        return table_of(one.place)

    def numbers(self, one: Any) -> Iterator[tuple[str, Quantity, int]]:
        """Return where it is."""
        yield from ((f"at{index}", x, PARAMETERS) for index, x in indexed(one.place.at))

    def named(self, one: Any, what: str, letter: str, k: int, names: Names) -> Any:
        """Return it with its place named."""
        return (
            replace(one, place=named_place(one.place, one.name, f"_{letter}{k}", names)) if what == "geometry" else one
        )

    def check(self, one: Any, stand: Stand) -> None:
        """Report a body that is none."""
        known_body("body", one.place.body, stand)


def known_body(key: str, body: str, stand: Stand) -> None:
    """Report a body that is none."""
    bodies = [*(one.name for one in stand.scene.bodies), GROUND]
    stand.faults.nameless(stand.where, key, body)
    if body and body not in bodies:
        stand.fault(f'{key} = "{body}" is not a body; {suggestion(body, bodies)}')


def place_of(table: Table, scope: Scope) -> Place:
    """Return the point of a body that `body` and `at`, or `point`, name."""
    if ("body" in table) == ("point" in table):
        table.fault('give body and at, or point; write body = "NAME" and at = [0, 0, 0]')
        return Place("")
    if "body" in table:
        return Place(table.text("body"), table.vector("at"))
    if "at" in table:
        table.fault("at goes with body; a point has a place of its own")
    name = table.text("point")
    if name not in scope.points:
        table.fault(f'point = "{name}" is not a point; {suggestion(name, scope.points)}')
        return Place("")
    return _at_point(name, scope)


def table_of(place: Place) -> dict[str, object]:
    """Return a place as a table says it."""
    return {"body": place.body} | ({"at": place.at} if place.at != NULL else {})


def named_place(place: Place, of: str, where: str, names: Names) -> Place:
    """Return a place with its coordinates named."""
    return replace(place, at=named_shift(place.at, f"place of {of}", where, names))


def named_shift(at: Vector, text: str, where: str, names: Names) -> Vector:
    """Return a shift with its components named."""
    return along(at, ("a", "b", "d"), where, "m", text, names)


def _end(table: Table, key: str, scope: Scope) -> Place:
    raw = plain(table.raw[key])
    if isinstance(raw, Place):
        return raw
    if isinstance(raw, str):
        return _at_point(raw, scope) if raw in scope.points else Place(raw)
    if not isinstance(raw, Mapping):
        table.fault(f"{key} = {show(raw)} is no end; {ADVICE}")
        return Place("")
    return place_of(table.inner(key, AtBody.keys, ADVICE), scope)


def _at_point(name: str, scope: Scope) -> Place:
    return Place(scope.points[name].body, translation(scope.points[name].at))


def as_keys(ends: tuple[End, End] | None) -> dict[str, object]:
    """Return the ends of a strut as keys of its table."""
    return {} if ends is None else {"from": ends[0], "to": ends[1]}
