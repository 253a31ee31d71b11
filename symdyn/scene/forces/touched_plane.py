"""The plane that a contact touches, as a part of its table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from symdyn.scene.forces.ends import known_body, named_shift
from symdyn.scene.forces.keys import indexed
from symdyn.scene.forces.kind import PARAMETERS, Part, Scope, Stand
from symdyn.scene.values.direction import direction
from symdyn.scene.values.element import Plane, Row
from symdyn.scene.values.made_names import Names
from symdyn.scene.values.model import GROUND
from symdyn.scene.values.quantity import NULL, Quantity
from symdyn.scene.values.spelling import spell
from symdyn.scene.values.table import Table

TILT = "tilt a body that carries it"


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
