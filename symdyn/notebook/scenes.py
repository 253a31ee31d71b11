"""A scene in a notebook: its picture, its coordinates and its parameters."""

from __future__ import annotations

from symdyn.draw import picture as drawn
from symdyn.emit.print import value_text
from symdyn.errors import SymdynError
from symdyn.notebook.page import Cell, Markup, beside, head, note, picture, table, together
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import spell


def scene(result: Scene) -> list[Markup]:
    """Return picture and tables of a scene."""
    return [head(result.name, _counts(result)), beside(_picture(result), together(*_tables(result)))]


def _picture(result: Scene) -> Markup:
    try:
        return picture(drawn(result), "svg", f"picture of {result.name}")
    except SymdynError as fault:  # a mechanism that cannot be assembled is still one that has a table
        return note(f"no picture: {fault}")


def _counts(result: Scene) -> str:
    """Return how much there is of what, kinds that there are."""
    counts = {
        "body": len(result.bodies), "coordinate": len(result.coordinates), "loop": len(result.loops),
        "contact": len(result.contacts), "spring or damper": len(result.struts), "load": len(result.loads),
    }  # fmt: skip
    plural = {"body": "bodies", "spring or damper": "springs and dampers"}
    return ", ".join(f"{n} {word if n == 1 else plural.get(word, f'{word}s')}" for word, n in counts.items() if n)


def _tables(result: Scene) -> list[Markup]:
    units = dict(zip(result.coordinates, SceneUnits(result).coordinates, strict=True))
    drives: dict[str, list[str]] = {}
    for joint, drive, unit in SceneUnits(result).each_drive():
        drives.setdefault(joint.name, []).append(", ".join(filter(None, (drive, result.shown_unit(unit)))))
    rows = [
        (
            q,
            result.shown_unit(units[q]),
            joint.name,
            joint.type.replace("_", " "),
            "; ".join(drives.pop(joint.name, ())),
        )
        for joint in result.moving
        for q in joint.coordinates
    ]
    told, looked = SceneUnits(result).inferred, SceneUnits(result).outputs
    named: list[list[Cell]] = [
        [one.name, "" if one.value is None else value_text(one.value), told[one.name], one.text]
        for one in result.parameters
    ]
    given = [(one.name, spell(one.value), told[one.name], one.text) for one in result.inputs]
    seen = [(one.name, spell(one.formula), looked[one.name], one.text) for one in result.outputs]
    gravity = ", ".join(map(spell, result.gravity))
    return [
        table(("coordinate", "unit", "joint", "type", "drive"), rows),
        table(("parameter", "value", "unit", ""), named),
        table(("input", "unless given", "unit", ""), given),
        table(("output", "formula", "unit", ""), seen),
        note(f"gravity [{gravity}] m/s²"),
    ]
