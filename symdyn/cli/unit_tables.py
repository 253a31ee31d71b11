"""What `symdyn info --units` prints: units of letters and columns, and numbers that have to carry a dimension."""

from __future__ import annotations

from typing import Any

from symdyn.cli.talk import print_table
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Letter, spell


def unit_facts(scene: Scene) -> dict[str, Any]:
    """Return letters with their units and how these are known, columns with theirs, and numbers that carry one."""
    units, known = SceneUnits(scene).letters, SceneUnits(scene).dimensions
    joints = {name: joint.name for joint in scene.joints for name in (*joint.coordinates, *joint.rates, *joint.drives)}
    given: tuple[Letter, ...] = (*scene.parameters, *scene.inputs)
    said, names = {one.name for one in given if one.unit}, {one.name for one in given}
    letters = []
    for name, unit in units.items():
        if name in said or name not in names:
            how = "it says so" if name in said else f"joint {joints[name]}" if name in joints else ""
            told_unit = unit if name in said else scene.shown_unit(unit)
            letters.append({"name": name, "unit": told_unit, "known": how})
        elif not scene.dimensionless and (told := known.letter(name)) is not None:
            origin = known.origins[name]
            two = any(name in dict(pair.ratio.letters) for pair in known.disagreeing)
            beside = (
                "" if name in known.certain else ", and another elsewhere" if two else ", by a number taken as plain"
            )
            letters.append({"name": name, "unit": unit or told.text, "known": f"{origin.place.words}{beside}"})
        else:
            letters.append({"name": name, "unit": unit, "known": "nothing tells it"})
    columns = [{"name": name, "unit": unit} for name, unit in SceneUnits(scene).outputs.items()]
    columns += [{"name": name, "unit": scene.shown_unit("m")} for name in scene.point_letters]
    numbers = [
        {"number": spell(one.number), "where": one.place.words, "unit": one.dimension.text}
        for one in ([] if scene.dimensionless else known.carried)
    ]
    return {
        "name": scene.name,
        "checked": not scene.dimensionless,
        "letters": letters,
        "columns": columns,
        "numbers": [one for k, one in enumerate(numbers) if one not in numbers[:k]],
        "doubtful": list(SceneUnits(scene).doubtful),
    }


def show_units(facts: dict[str, Any]) -> None:
    """Print them for people."""
    if not facts["checked"]:
        print(f"{facts['name']}: is without dimensions on purpose, so that none is checked\n")
    rows = [(one["name"], one["unit"], one["known"]) for one in facts["letters"]]
    print_table("Letters", ("name", "unit", "known by"), rows)
    if facts["columns"]:
        print_table("Outputs and points", ("column", "unit"), [tuple(one.values()) for one in facts["columns"]])
    for one in facts["numbers"]:
        print(f"{one['number']} in {one['where']} would have to be {one['unit']}")
    for said in facts["doubtful"]:
        print(said)
