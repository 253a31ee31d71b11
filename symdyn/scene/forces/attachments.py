"""Where elements act: at a joint or between points, along a rope, at a place of a body, at a plane."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from symdyn.errors import suggestion
from symdyn.scene.forces.force_kind import Scope
from symdyn.scene.values.body import translation
from symdyn.scene.values.entry import Entry, EntryReader, plain, show, shown
from symdyn.scene.values.joint import Contact, Place, Plane, Strut
from symdyn.scene.values.key import PLACED, KeyedQuantity, Names, Part, Stand, along, indexed
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, Vector, spell
from symdyn.scene.values.shape import (
    NAMED,
    NUMBER,
    VECTOR,
    Shape,
    choice_of,
    described,
    exactly_one,
    not_both,
    several,
    table_shape,
)

End = str | Place | Mapping[str, object]
"""What a user writes for an end in Python."""

OF_THE_TREE = "write [joints.{}] in its place, and [[loop]] for another joint of the loop"

ADVICE = 'write joint = "NAME", or from and to, each the name of a body or point or { body = "NAME", at = [0, 0, 0] }'


AT_BODY: Mapping[str, Shape] = {
    "body": described('name of a body, or "ground"', NAMED),
    "point": described("name of a point, in place of body and at", NAMED),
    "at": described("place in the frame of the body, m", VECTOR),
}

BODY_OR_POINT = [
    exactly_one(("body",), ("point",)),
    {"if": {"required": ["point"]}, "then": {"properties": {"at": False}}},
]

END: Shape = {
    "description": "name of a body or point, or { body = NAME, at = [0, 0, 0] }",
    "anyOf": [NAMED, {**table_shape(AT_BODY), "allOf": BODY_OR_POINT}],
}


TURNS = {"left": 1, "right": -1}
"""How a rope turns around a wheel, seen with the wheel's axis towards the eye."""

WHEEL: Mapping[str, Shape] = {
    **AT_BODY,
    "radius": described("of a wheel that the rope runs around, m", NUMBER),
    "axis": described("of that wheel, in the frame of the body; z when left out", VECTOR),
    "turn": described("how the rope turns around it, seen with the axis towards the eye", choice_of(*TURNS)),
}

ROUTE = (
    'write through = ["hook", "pulley", "load"], each the name of a body or point or { body = "NAME", at = [0, 0, 0] '
    '}, or a wheel, { body = "NAME", radius = 0.1, turn = "left" }'
)


class Through(Part):
    """The places that a rope runs through."""

    words: Mapping[str, Shape] = {
        "through": {
            "description": "places that it runs through, in order: points, and wheels with a radius",
            **several({"anyOf": [NAMED, {**table_shape(WHEEL), "allOf": BODY_OR_POINT}]}, 2, 99),
        }
    }
    rules = ({"required": ["through"]},)

    def fields(self, table: EntryReader, scope: Scope) -> dict[str, Any]:
        raw = plain(table.raw.get("through"))
        if not isinstance(raw, (list, tuple)) or len(raw) < 2:
            told = " is missing" if raw is None else f" = {show(raw)} is no list of two places or more"
            table.fault(f"through{told}; {ROUTE}")
            return {}
        return {"ends": tuple(_via(table, f"through[{k}]", one, scope) for k, one in enumerate(raw))}

    def raw(self, one: Any, scope: Scope) -> dict[str, object]:
        return {"through": [table_of(place) | _around(place) for place in one.ends]}

    def numbers(self, one: Any, slides: bool = True) -> Iterator[KeyedQuantity]:
        """Return where the places are, and the radii of wheels."""
        for k, place in enumerate(one.ends):
            yield from (KeyedQuantity(f"through[{k}].at{index}", x, unit="m") for index, x in indexed(place.at))
            if place.turn:
                yield KeyedQuantity(f"through[{k}].radius", place.radius, unit="m")

    def named(self, one: Any, what: str, letter: str, k: int, names: Names, slides: bool = False) -> Any:
        """Return it with its places, and the radii of wheels, named."""
        if what != "geometry":
            return one
        ends = []
        for i, place in enumerate(one.ends):
            called = named_place(place, one.name, f"_{letter}{k}_{i}", names)
            if called.turn:
                text = f"radius of a wheel of {one.name}"
                called = replace(called, radius=names.of(called.radius, f"r_{letter}{k}_{i}", "m", text, True))
            ends.append(called)
        return replace(one, ends=tuple(ends))

    def check(self, one: Any, stand: Stand) -> None:
        """Report places of no body, ends that do nothing, and wheels without a size."""
        for k, place in enumerate(one.ends):
            known_end(f"through[{k}]", place.body, stand)
            if place.turn:
                size = stand.value(place.radius)
                if size is not None and size <= 0:
                    stand.fault(
                        f"through[{k}]: radius = {shown(place.radius)} is that of no wheel; give one above zero"
                    )
                stand.direction(f"through[{k}]: axis", place.axis, "turn the body's frame")
        last = len(one.ends) - 2
        for k in sorted({0, last}) if one.ends else ():
            a, b = one.ends[k : k + 2]
            if a.body and a.body == b.body and not (a.turn or b.turn):
                stand.fault(
                    f'through[{k}] and through[{k + 1}] are on one body, "{a.body}", so that this end of the rope '
                    f"never changes and does nothing; {'begin' if k == 0 else 'end'} with through[{k + (k == 0)}]"
                )


def _via(table: EntryReader, key: str, raw: object, scope: Scope) -> Place:
    one = EntryReader(Entry(key, {key: raw}, table.entry.where), table.faults, (key,))
    if not isinstance(raw, Mapping):
        return _end(one, key, scope, ROUTE)
    own = one.inner(key, tuple(WHEEL), ROUTE)
    place = place_of(own, scope)
    if "radius" not in own:
        for word in ("axis", "turn"):
            if word in own:
                own.fault(f"{word} goes with the radius of a wheel; write radius = 0.1, or leave {word} out")
        return place
    turn = own.text("turn")
    if turn not in TURNS:
        told = f'turn = "{turn}" is neither left nor right' if turn else "turn is missing"
        own.fault(f'{told}; write turn = "left" or "right", as the rope turns, seen with the axis towards the eye')
    return replace(place, radius=own.quantity("radius"), axis=own.vector("axis", place.axis), turn=TURNS.get(turn, 1))


def _around(place: Place) -> dict[str, object]:
    """Return what the table of a wheel says beside its place."""
    if not place.turn:
        return {}
    axis = {} if place.axis == Place.axis else {"axis": place.axis}
    return {"radius": place.radius, **axis, "turn": next(word for word, turn in TURNS.items() if turn == place.turn)}


class Ends(Part):
    """The joint of a strut, or the two points between which it is."""

    words: Mapping[str, Shape] = {"joint": described("joint that it is at", NAMED), "from": END, "to": END}
    rules = (exactly_one(("joint",), ("from", "to")),)

    def fields(self, table: EntryReader, scope: Scope) -> dict[str, Any]:
        """Return the joint that it is at, or the points that it connects."""
        given = [key for key in self.keys if key in table]
        if given == ["joint"]:
            return {"joint": table.text("joint")}
        if given == ["from", "to"]:
            return {"ends": (_end(table, "from", scope), _end(table, "to", scope))}
        table.fault(f"has {' and '.join(given) or 'neither joint nor from and to'}; {ADVICE}")
        return {}

    def raw(self, one: Strut, scope: Scope) -> dict[str, object]:
        joint: dict[str, object] = {"joint": one.joint} if one.joint else {}
        return joint | {key: table_of(end) for key, end in zip(self.keys[1:], one.ends, strict=False)}

    def numbers(self, one: Strut, slides: bool = True) -> Iterator[KeyedQuantity]:
        for key, end in zip(self.keys[1:], one.ends, strict=False):
            yield from (KeyedQuantity(f"{key}.at{index}", x, PLACED, "m") for index, x in indexed(end.at))

    def named(self, one: Strut, what: str, letter: str, k: int, names: Names, slides: bool = False) -> Strut:
        if what != "geometry":
            return one
        ends = (
            named_place(end, one.name, f"_{letter}{k}{side}", names) for side, end in zip("ft", one.ends, strict=False)
        )
        return replace(one, ends=tuple(ends))

    def check(self, one: Strut, stand: Stand) -> None:
        """Report a joint that is none, or has not one coordinate, and ends that are none, or never part."""
        scene, faults = stand.scene, stand.faults
        if one.joint:
            joints = {joint.name: joint for joint in scene.joints}
            joint = joints.get(one.joint)
            if joint is None:
                of = next((joint.name for joint in scene.joints if one.joint in joint.coordinates), one.joint)
                way = suggestion(of, joints)
                if faults.told(f"joints.{one.joint}"):  # that it is cut
                    return
                if one.joint in (loop.name for loop in scene.loops if loop.parent != loop.child):
                    way = f"{OF_THE_TREE.format(one.joint)}; or give two points by from and to"
                stand.fault(f'joint = "{one.joint}" is not a joint of the tree; {way}')
            elif not joint.coordinate and joint.coupling is None:
                many = f"has {len(joint.coordinates)} coordinates" if joint.coordinates else "does not move"
                stand.fault(f'joint = "{one.joint}" {many}; name one with one, or two points by from and to')
        elif not one.ends:
            faults.nameless(stand.where, "joint", one.joint)
        constants = {parameter.name for parameter in scene.parameters}
        for key, end in zip(self.keys[1:], one.ends, strict=False):
            known_end(key, end.body, stand)
            moved = next((x for x in end.at if not constants.issuperset(x.symbols)), None)
            if moved is not None and end.body != Scene.GROUND:
                stand.fault(
                    f'{key}.at has {shown(moved)}, which moves on the body "{end.body}"; only a place in space moves '
                    f'as it is told: write body = "{Scene.GROUND}"'
                )
        if len(one.ends) == 2 and one.ends[0].body and one.ends[0].body == one.ends[1].body:
            stand.fault(f'from and to are on one body, "{one.ends[0].body}", so that it never changes its length')


class AtBody(Part):
    """A place of a body: the body and at, or a point."""

    words = AT_BODY
    rules = BODY_OR_POINT

    def fields(self, table: EntryReader, scope: Scope) -> dict[str, Any]:
        return {"place": place_of(table, scope)}

    def raw(self, one: Any, scope: Scope) -> dict[str, object]:
        return table_of(one.place)

    def numbers(self, one: Any, slides: bool = True) -> Iterator[KeyedQuantity]:
        yield from (KeyedQuantity(f"at{index}", x, unit="m") for index, x in indexed(one.place.at))

    def named(self, one: Any, what: str, letter: str, k: int, names: Names, slides: bool = False) -> Any:
        return (
            replace(one, place=named_place(one.place, one.name, f"_{letter}{k}", names)) if what == "geometry" else one
        )

    def check(self, one: Any, stand: Stand) -> None:
        known_body("body", one.place.body, stand)


def known_end(key: str, body: str, stand: Stand) -> None:
    """Report the end of an element that is neither a body nor a point."""
    bodies = [*(one.name for one in stand.scene.bodies), Scene.GROUND]
    stand.faults.nameless(stand.where, key, body)
    if body and body not in bodies:
        near = suggestion(body, [*bodies, *(point.name for point in stand.scene.points)])
        stand.fault(f'{key} = "{body}" is neither a body nor a point; {near}')


def known_body(key: str, body: str, stand: Stand) -> None:
    """Report a body that is none."""
    bodies = [*(one.name for one in stand.scene.bodies), Scene.GROUND]
    stand.faults.nameless(stand.where, key, body)
    if body and body not in bodies:
        stand.fault(f'{key} = "{body}" is not a body; {suggestion(body, bodies)}')


def place_of(table: EntryReader, scope: Scope) -> Place:
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


def _end(table: EntryReader, key: str, scope: Scope, advice: str = ADVICE) -> Place:
    raw = plain(table.raw[key])
    if isinstance(raw, Place):
        return raw
    if isinstance(raw, str):
        return _at_point(raw, scope) if raw in scope.points else Place(raw)
    if not isinstance(raw, Mapping):
        table.fault(f"{key} = {show(raw)} is no end; {advice}")
        return Place("")
    return place_of(table.inner(key, tuple(AT_BODY), advice), scope)


def _at_point(name: str, scope: Scope) -> Place:
    return Place(scope.points[name].body, translation(scope.points[name].at))


def as_keys(ends: tuple[End, End] | None) -> dict[str, object]:
    """Return the ends of a strut as keys of its table."""
    return {} if ends is None else {"from": ends[0], "to": ends[1]}


# The plane that a contact touches

TILT = "tilt a body that carries it"


PLANE: Mapping[str, Shape] = {
    "plane": {
        "description": "the plane: a body, a place on it, and its normal",
        **table_shape({"body": NAMED, "at": VECTOR, "normal": VECTOR}),
    },
    "normal": {"description": "of a plane of the ground through its origin", **VECTOR},
}


class OnPlane(Part):
    """The plane that is touched; level where nothing else is said of a plane of the ground that has to be somewhere."""

    rules = not_both([("plane", "normal")])

    def __init__(self, needs_normal: bool) -> None:
        """Say whether the plane has to be somewhere, as a blade's has not."""
        self.needs_normal = needs_normal
        self.words = {key: shape for key, shape in PLANE.items() if needs_normal or key == "plane"}

    def fields(self, table: EntryReader, scope: Scope) -> dict[str, Any]:
        declared, where = "plane" in table, table
        if declared:
            advice = "write plane = { at = [0, 0, 0], normal = [0, 0, 1] }"
            advice = f"{advice}, with body = NAME where it is not the ground's"
            where = table.inner("plane", ("body", "at", "normal"), advice)
            if "normal" in table:
                table.fault("normal is given beside plane; write it into plane")
        body = where.text("body", Scene.GROUND) if declared else Scene.GROUND
        at = where.vector("at") if declared else NULL
        normal = where.vector("normal", Plane().normal)
        if "normal" not in where and self.needs_normal and body != Scene.GROUND:
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

    def raw(self, one: Contact, scope: Scope) -> dict[str, object]:
        plane = one.plane
        if not plane.declared:
            return {"normal": plane.normal} if self.needs_normal and plane.normal != scope.level else {}
        fixed = plane.body == Scene.GROUND
        said: dict[str, object] = {} if fixed else {"body": plane.body}
        said |= {"at": plane.at} if plane.at != NULL else {}
        return {"plane": said if fixed and plane.normal == scope.level else said | {"normal": plane.normal}}

    def numbers(self, one: Contact, slides: bool = True) -> Iterator[KeyedQuantity]:
        yield from (KeyedQuantity(f"plane.at{index}", x, unit="m") for index, x in indexed(one.plane.at))

    def named(self, one: Contact, what: str, letter: str, k: int, names: Names, slides: bool = False) -> Contact:
        """Return the row with the place of its plane named."""
        if what != "geometry":
            return one
        at = named_shift(one.plane.at, f"plane of {one.name}", f"_g{k}", names)
        return replace(one, plane=replace(one.plane, at=at))

    def check(self, one: Contact, stand: Stand) -> None:
        """Report a plane of no body, or of the body that touches it, and a normal that is no direction."""
        known_body("plane: body", one.plane.body, stand)
        body = one.place.body
        if body == one.plane.body == Scene.GROUND:
            stand.fault(f"is about {Scene.GROUND}, which does not move; name a body")
        elif body and body == one.plane.body:
            stand.fault(f'touches a plane on its own body, "{body}"; name another body')
        if one.axis is not None:
            stand.direction("axis", one.axis, "turn the body's frame")
        key = "plane: normal" if one.plane.declared else "normal"
        stand.direction(key, one.plane.normal, TILT)
