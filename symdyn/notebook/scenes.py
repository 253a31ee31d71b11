"""A scene in a notebook: its picture, its coordinates and its parameters."""

from __future__ import annotations

from symdyn.draw import picture as drawn
from symdyn.emit.print import value_text
from symdyn.errors import SymdynError
from symdyn.notebook.page import Cell, Markup, beside, head, note, picture, table, together
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import spell


def scene(found: Scene) -> list[Markup]:
    """Return picture and tables of a scene."""
    return [head(found.name, _counts(found)), beside(_picture(found), together(*_tables(found)))]


def _picture(found: Scene) -> Markup:
    try:
        return picture(drawn(found), "svg", f"picture of {found.name}")
    except SymdynError as fault:  # a mechanism that cannot be assembled is still one that has a table
        return note(f"no picture: {fault}")


def _counts(found: Scene) -> str:
    """Return how much there is of what, kinds that there are."""
    counts = {
        "body": len(found.bodies), "coordinate": len(found.coordinates), "loop": len(found.loops),
        "contact": len(found.contacts), "spring or damper": len(found.struts), "load": len(found.loads),
    }  # fmt: skip
    plural = {"body": "bodies", "spring or damper": "springs and dampers"}
    return ", ".join(f"{n} {word if n == 1 else plural.get(word, f'{word}s')}" for word, n in counts.items() if n)


def _tables(found: Scene) -> list[Markup]:
    units = dict(zip(found.coordinates, SceneUnits(found).coordinates, strict=True))
    drives: dict[str, list[str]] = {}
    for joint, drive, unit in SceneUnits(found).each_drive():
        drives.setdefault(joint.name, []).append(", ".join(filter(None, (drive, found.shown_unit(unit)))))
    rows = [
        (
            q,
            found.shown_unit(units[q]),
            joint.name,
            joint.type.replace("_", " "),
            "; ".join(drives.pop(joint.name, ())),
        )
        for joint in found.moving
        for q in joint.coordinates
    ]
    told, looked = SceneUnits(found).told, SceneUnits(found).outputs
    named: list[list[Cell]] = [
        [one.name, "" if one.value is None else value_text(one.value), told[one.name], one.text]
        for one in found.parameters
    ]
    given = [(one.name, spell(one.value), told[one.name], one.text) for one in found.inputs]
    seen = [(one.name, spell(one.formula), looked[one.name], one.text) for one in found.outputs]
    gravity = ", ".join(map(spell, found.gravity))
    return [
        table(("coordinate", "unit", "joint", "type", "drive"), rows),
        table(("parameter", "value", "unit", ""), named),
        table(("input", "unless given", "unit", ""), given),
        table(("output", "formula", "unit", ""), seen),
        note(f"gravity [{gravity}] m/s²"),
    ]
