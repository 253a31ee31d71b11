"""`symdyn info SCENE`: the tree, degrees of freedom, parameters, what each function costs, and what it does not cost.

`--schema` prints what editors check scenes by.
`--units` shows what every symbol and column is measured in, and the numbers that have to carry a dimension.
`--frames` shows the link frames that the generator chose, `--base-parameters` the regrouped inertias as formulas.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from itertools import groupby
from operator import itemgetter
from typing import Any

from symdyn.cli.facts import gather, parts
from symdyn.cli.scene_options import closing_of, read_scene
from symdyn.cli.talk import Waiting, answer, asking, print_json, print_table, say, short
from symdyn.dynamics.outputs import Counts
from symdyn.graph import growing
from symdyn.scene import Scene, SceneUnits, schema
from symdyn.scene.values import Letter, spell
from symdyn.table import Table

MOST_NESTED = 200
"""Joints up to which the tree is drawn with its branches; a longer chain would leave the page."""


@growing()  # once over all of it: each time that the collector wakes it walks every node
def run(options: argparse.Namespace) -> int:
    """Print what is known about the scene."""
    if options.schema:
        if options.scene is not None:
            options.parser.error(f"--schema is that of all scenes; leave {options.scene} out")
        answer(schema(), lambda: print_json(schema()))
        return 0
    if options.scene is None:
        options.parser.error("the following arguments are required: SCENE")
    scene = read_scene(options)
    closing = closing_of(options, scene)
    if options.units:
        units = unit_facts(scene)
        answer(units, lambda: show_units(units))
        return 0
    if options.frames or options.base_parameters:
        with Waiting("regrouping" if options.base_parameters else "choosing frames"):
            chosen = parts(scene, options.frames, options.base_parameters)
        answer(chosen, lambda: show_parts(chosen))
        return 0
    with Waiting("deriving and counting"):
        facts, left_out = gather(scene, options.formulation, closing)
    for reason in left_out:
        say(f"symdyn: {reason}")
    answer(facts, lambda: show(facts))
    return 0


def show_parts(result: dict[str, Any]) -> None:
    """Print chosen frames and base parameters for people."""
    if "frames" in result:
        columns = ("joint", "as declared", "in the frame of", "link", "moved, in the declared frame")
        rows = [(f["joint"], f["declared"], f["parent"], f["link"], f["moved"] or "-") for f in result["frames"]]
        title = "Link frames, z along the joint's axis; lengths in m, angles in deg or rad"
        print_table(Table(columns, rows, title=title))
    for parameter in result.get("base_parameters", ()):
        formula = short(parameter["formula"])
        print(f"{parameter['name']} {formula}" if formula[0] == "≈" else f"{parameter['name']} = {formula}")


def show(facts: dict[str, Any]) -> None:
    """Print the facts for people."""
    free = facts["degrees_of_freedom"]
    freedom = f"{free} degree{'s' * (free != 1)} of freedom"
    gravity = f"({', '.join(facts['gravity'])}) {facts['gravity_unit']}".rstrip()
    print(f"{facts['name']}: {freedom}, gravity {gravity}\n")
    if len(facts["joints"]) > MOST_NESTED:
        for joint in facts["joints"]:
            print(f"{joint['parent']} <- {_label(joint)}")
    else:
        print("ground", *_branches(facts["joints"], "ground"), sep="\n")
    print()
    if not facts["points"]:
        print(f"{asking(facts['leaves'])}\n")
    for arm in facts.get("arms", ()):
        print(f"arm of {arm['point']}: {'; '.join(arm['axes'])}\n")
    if facts["acting"]:
        rows = [tuple(one.values()) for one in facts["acting"]]
        print_table(Table(("", "name", "where", "law"), rows, title="What acts beside gravity and drives"))
    show_loops(facts)
    if facts.get("inputs"):
        rows = [(p["name"], _value(p), p["unit"], p["text"]) for p in facts["inputs"]]
        title = "Inputs; passed as inputs, in this order"
        print_table(Table(("name", "unless given", "unit", ""), rows, title=title))
    if facts.get("states"):
        rows = [(p["name"], short(p["rate"]), p["start"], p["unit"], p["text"]) for p in facts["states"]]
        title = "States; passed as internal, in this order"
        print_table(Table(("name", "rate", "start", "unit", ""), rows, title=title))
    if facts.get("outputs"):
        rows = [
            (p["name"], short(p["formula"]), p["unit"], str(p["relative_degree"] or ""), p["text"])
            for p in facts["outputs"]
        ]
        print_table(Table(("name", "formula", "unit", "relative degree", ""), rows, title="Outputs"))
    if facts["parameters"]:
        rows = [(p["name"], _value(p), p["unit"], p["text"]) for p in facts["parameters"]]
        title = "Parameters; free ones are passed as params, in this order"
        print_table(Table(("name", "value", "unit", ""), rows, title=title))
    put_in = (*facts.get("derived", ()), *facts.get("signals", ()))
    if rows := [(p["name"], short(p["formula"]), p["unit"], p["text"]) for p in put_in]:
        title = "Derived parameters and signals; their formulas are put in"
        print_table(Table(("name", "formula", "unit", ""), rows, title=title))
    for said in (*facts.get("values_with_units", ()), *facts.get("doubtful_units", ())):
        print(f"{said}\n")
    columns = ("function", "shape", "formulation", "mul", "add", "div", "sin/cos", "other")
    rows = []
    for function in facts["functions"]:
        operations = function["operations"]
        shape = " x ".join(map(str, function["shape"])) or "scalar"
        rows.append((function["name"], shape, function["formulation"], *(str(count) for count in operations.values())))
    print_table(Table(columns, rows, range(3, 8), "Operations of one call that depend on the state"))
    print(f"with --functions also: {', '.join(facts['on_request'])}\n")
    show_skipped(facts)


def _value(letter: dict[str, Any]) -> str:
    """Return a value in SI, and behind it how it was written, where that is in another unit."""
    told = short(letter["value"] or "free")
    return f"{told} ({letter['written']})" if "written" in letter else told


def show_loops(facts: dict[str, Any]) -> None:
    """Print what closes the loops, and the mobility with its diagnosis."""
    for loop in facts["loops"]:
        print(f"loop {loop['name']}: {loop['type']} between {loop['parent']} and {loop['child']}")
    for row in facts["constraints"]:
        kind = {"formula": "constraint", "rope": "rope"}.get(row["type"], "contact")
        print(f"{kind} {row['name']}: {row['law']}")
    found = facts["mobility"]
    if found is None:
        print(end="\n" if facts["loops"] or facts["constraints"] else "")
        return
    counted = f"{found['spatial']} in space (5.20), {found['by_loops']} loop by loop, {found['by_rank']} by rank"
    print(f"mobility: {counted}; independent: {', '.join(found['independent']) or 'none'}")
    if facts["chosen"]:
        print(f"  chosen: {facts['chosen']}")
    for note in found["notes"]:
        print(f"  {note}")
    if found["loose_reactions"]:
        print(f"  reactions that are not unique, axes of the child: {found['loose_reactions']}")
    print()


def show_skipped(facts: dict[str, Any]) -> None:
    """Print what depends on parameters alone, what was left out, and how much that saved, function by function."""
    moved = [(f["name"], str(Counts(**f["prepare"]))) for f in facts["functions"] if any(f["prepare"].values())]
    if moved:
        once = facts["prepare"]
        moved.append((f"prepare, {once['values']} values", str(Counts(**once["operations"]))))
        title = "On parameters alone; --prepare does it once"
        print_table(Table(("function", "operations"), moved, title=title))
    report = facts["skipped"]
    if not report:
        return
    steps = [(one["step"], one["why"]) for one in report]
    print_table(Table(("step", "why"), steps, title="Left out or merged"))
    measured = [one for one in report if one["saved"]]
    rows = [
        (name, *(_saving(one["saved"].get(name)) for one in measured))
        for name in (function["name"] for function in facts["functions"])
        if any(name in one["saved"] for one in measured)
    ]
    title = "What that saved, multiplications/additions (d: divisions, s: sin/cos, o: other); + is what it costs"
    heads = ("function", *(one["step"] for one in measured))
    print_table(Table(heads, rows, range(1, len(heads)), title))


def _saving(counts: dict[str, int] | None) -> str:
    """Return saved operations as mul/add, and others where there are any; what is spent has a plus sign."""
    if counts is None:
        return ""
    numbers = {key: f"{-n:+d}" if n < 0 else str(n) for key, n in counts.items()}
    others = [
        f" {numbers[key]}{letter}"
        for key, letter in (("divisions", "d"), ("sincos", "s"), ("others", "o"))
        if counts[key]
    ]
    return f"{numbers['multiplications']}/{numbers['additions']}{''.join(others)}"


def _several(named: list[dict[str, str]]) -> str:
    """Return names with units, those of one unit together: "x y z in m, e0 e1 e2 e3 in 1"."""
    parts = [(unit, [one["name"] for one in group]) for unit, group in groupby(named, key=itemgetter("unit"))]
    return ", ".join(f"{' '.join(names)}{unit and f' in {unit}'}" for unit, names in parts)


def _branches(joints: Sequence[dict[str, Any]], parent: str, margin: str = "") -> Iterator[str]:
    """Yield a line for each joint of a body, and of all that it carries."""
    carried = [joint for joint in joints if joint["parent"] == parent]
    for joint in carried:
        mark, below = ("└── ", "    ") if joint is carried[-1] else ("├── ", "│   ")
        yield f"{margin}{mark}{_label(joint)}"
        yield from _branches(joints, joint["child"], margin + below)


def _label(joint: dict[str, Any]) -> str:
    """Return one line about a joint and the body that it carries."""
    words = [f"{joint['name']}: {joint['type']}"]
    if joint["coordinate"]:
        words.append(_several([{"name": joint["coordinate"], "unit": joint["unit"]}]))
    elif joint["coordinates"]:
        words.append(_several(joint["coordinates"]))
        words.append(f"velocities {_several(joint['velocities'])}")
        drives = [drive or "none" for drive in joint["drives"]]
        words += [f"drives {' '.join(drives)}"] if any(joint["drives"]) else []
    if joint["mimic"]:
        follows = joint["mimic"]
        ratios = (f"{q}: ratio {short(ratio)}" for q, ratio in follows["ratios"].items())
        words.append(f"follows {', '.join(ratios)}, offset {short(follows['offset'])}")
    words += [f"{key} {short(joint[key])}" for key in ("armature", "damping", "friction") if joint[key] != "0"]
    limits = {key: value and short(value) for key, value in joint["limits"].items()}
    if limits["lower"] or limits["upper"]:
        words.append(f"from {limits['lower'] or '-oo'} to {limits['upper'] or 'oo'}")
    words += [f"{key} up to {limits[key]}" for key in ("velocity", "effort") if limits[key]]
    return f"{joint['child']}  ({', '.join(words)})"


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
    columns += [{"name": name, "unit": scene.shown_unit("m")} for name in scene.point_names]
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
    print_table(Table(("name", "unit", "known by"), rows, title="Letters"))
    if facts["columns"]:
        columns = [tuple(one.values()) for one in facts["columns"]]
        print_table(Table(("column", "unit"), columns, title="Outputs and points"))
    for one in facts["numbers"]:
        print(f"{one['number']} in {one['where']} would have to be {one['unit']}")
    for said in facts["doubtful"]:
        print(said)
