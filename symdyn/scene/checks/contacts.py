"""Contacts: blades, wheels and balls touch a plane of another body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.scene.checks.joints import direction
from symdyn.scene.draft import shown
from symdyn.scene.folding import FormulaError
from symdyn.scene.loads import Row
from symdyn.scene.model import GROUND
from symdyn.scene.names import suggestion
from symdyn.scene.table import Faults
from symdyn.scene.value import Value, value_of

TILT = "tilt a body that carries it"


def check_contact(where: str, row: Row, bodies: Sequence[str], values: Mapping[str, Value], faults: Faults) -> None:
    """Report what is wrong with a row that is no formula."""
    for key, body in (("body", row.place.body if row.place else ""), ("plane: body", row.plane.body)):
        faults.nameless(where, key, body)
        if body and body not in bodies:
            faults.add(where, f'{key} = "{body}" is not a body; {suggestion(body, bodies)}')
    if row.place is not None and row.place.body == row.plane.body == GROUND:
        faults.add(where, f"is about {GROUND}, which does not move; name a body")
    elif row.place is not None and row.place.body and row.place.body == row.plane.body:
        faults.add(where, f'touches a plane on its own body, "{row.plane.body}"; name another body')
    if row.axis is not None:
        direction(where, "axis", row.axis, faults, "turn the body's frame")
    direction(where, "plane: normal" if row.plane.declared else "normal", row.plane.normal, faults, TILT)
    if row.type == "rolling":
        try:
            radius = value_of(row.radius, values)
        except FormulaError:
            return  # reported as a formula without a value
        if radius is not None and radius <= 0:
            faults.add(where, f"radius = {shown(row.radius)} is that of no wheel; give one above zero")
