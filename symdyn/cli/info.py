"""`symdyn info SCENE`: the tree, the freedoms, the parameters, what each function costs, and what it does not cost.

`--frames` shows the link frames that the generator chose, `--base-parameters` the regrouped inertias as formulas.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING, Any

from symdyn.cli.reading import add_closing, add_formulation, add_reading_options, closing_of, read_scene

if TYPE_CHECKING:
    from symdyn.dynamics import Closing
    from symdyn.scene import Joint, Scene


def register(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the verb."""
    verb = verbs.add_parser("info", help="show the mechanism and what its functions cost", description=__doc__)
    add_reading_options(verb)
    add_formulation(verb)
    add_closing(verb)
    verb.add_argument("--json", action="store_true", help="print JSON")
    alone = verb.add_argument_group("one thing alone")
    alone.add_argument("--frames", action="store_true", help="the link frames that the generator chose")
    alone.add_argument("--base-parameters", action="store_true", help="the regrouped inertias, as formulas")
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what is known about the scene."""
    from symdyn.cli.talk import Waiting, print_json, say

    scene = read_scene(options)
    closing = closing_of(options, scene)
    if options.frames or options.base_parameters:
        with Waiting() as progress:
            progress("regrouping" if options.base_parameters else "choosing frames")
            chosen = parts(scene, options.frames, options.base_parameters)
        if options.json:
            print_json(chosen)
        else:
            show_parts(chosen)
        return 0
    with Waiting() as progress:
        progress("deriving and counting")
        facts, left_out = gather(scene, options.formulation, closing)
    for reason in left_out:
        say(f"symdyn: {reason}")
    if options.json:
        print_json(facts)
    else:
        show(facts)
    return 0


def gather(scene: Scene, road: str | None, closing: Closing) -> tuple[dict[str, Any], list[str]]:
    """Return the facts for JSON, and why some functions are missing."""
    from dataclasses import asdict

    from symdyn.dynamics import available
    from symdyn.program import formulate, lower, prepare, skipped
    from symdyn.program.prepare import is_prepared
    from symdyn.scene import JOINTS, spell

    outputs, left_out = available(scene, closing)
    equations = formulate(scene, outputs, road, closing)
    program = lower(equations)
    prepared = prepare(program)
    first = prepared.routines[0] if is_prepared(prepared) else None
    freedoms = _mobility(scene, closing)
    facts = {
        "name": scene.name,
        "degrees_of_freedom": freedoms["by_rank"] if freedoms else len(scene.velocities),
        "mobility": freedoms,
        "chosen": closing.words,
        "gravity": [spell(component) for component in scene.gravity],
        "joints": [
            {
                "name": joint.name,
                "type": joint.type,
                "parent": joint.parent,
                "child": joint.child,
                "coordinate": joint.coordinate,
                "unit": "".join(JOINTS[joint.type].coordinates(joint)) if joint.moves else "",
                "drive": joint.drive,
                "coordinates": _with_units(joint.coordinates, JOINTS[joint.type].coordinates(joint)),
                "velocities": _with_units(joint.rates, JOINTS[joint.type].velocities(joint), per="s"),
                "drives": list(joint.drives),
                **_beside(joint),
            }
            for joint in scene.joints
        ],
        "acting": acting(scene),
        "loops": [
            {"name": joint.name, "type": joint.type, "parent": joint.parent, "child": joint.child}
            for joint in scene.loops
        ],
        "points": [{"name": point.name, "body": point.body} for point in scene.points],
        "parameters": [
            {"name": p.name, "value": spell(p.value) if p.value else None, "unit": p.unit, "text": p.text}
            for p in scene.parameters
        ],
        "functions": [
            {
                "name": routine.function.name,
                "shape": routine.function.shape,
                "road": routine.function.formulation,
                "operations": asdict(routine.state_counts),
                "prepare": asdict(routine.prepare),
                "binding": {time: asdict(part) for time, part in routine.binding.items()},
            }
            for routine in program.routines
        ],
        "prepare": first and {"values": len(first.function.entries), "operations": asdict(first.counts)},
        "skipped": [
            {
                "step": one.step,
                "why": one.why,
                "saved": None if one.saved is None else {name: asdict(part) for name, part in one.saved.items()},
            }
            for one in skipped(equations, outputs)
        ],
    }
    return facts, left_out


def _mobility(scene: Scene, closing: Closing) -> dict[str, Any] | None:
    """Return the mobility of a scene with loops or rows; None for a tree, and where the loops cannot be closed."""
    from dataclasses import asdict

    from symdyn.dynamics import is_closed
    from symdyn.dynamics.loops.mobility import mobility
    from symdyn.errors import DerivationError

    if not is_closed(scene):
        return None
    try:
        return asdict(mobility(scene, closing))
    except DerivationError:  # `available` has told why
        return None


def parts(scene: Scene, frames: bool, base_parameters: bool) -> dict[str, Any]:
    """Return the chosen frames, the base parameters, or both."""
    from symdyn.emit.base_parameters import base_parameter_texts
    from symdyn.emit.frames import frame_texts

    found: dict[str, Any] = {"name": scene.name}
    if frames:
        found["frames"] = frame_texts(scene)
    if base_parameters:
        found["base_parameters"] = base_parameter_texts(scene)
    return found


def show_parts(found: dict[str, Any]) -> None:
    """Print chosen frames and base parameters for people."""
    from symdyn.cli.talk import print_table

    if "frames" in found:
        columns = ("joint", "as declared", "in the frame of", "link", "moved, in the declared frame")
        rows = [(f["joint"], f["declared"], f["parent"], f["link"], f["moved"] or "-") for f in found["frames"]]
        print_table("Link frames, z along the joint's axis; lengths in m, angles in deg or rad", columns, rows)
    for parameter in found.get("base_parameters", ()):
        print(f"{parameter['name']} = {parameter['formula']}")


def _with_units(names: tuple[str, ...], units: Sequence[str], per: str = "") -> list[dict[str, str]]:
    """Return names of coordinates or velocities with their units; none where a joint follows another one."""
    behind = f"/{per}" if per else ""
    return [{"name": name, "unit": f"{unit}{behind}"} for name, unit in zip(names, units, strict=False)]


def _beside(joint: Joint) -> dict[str, Any]:
    """Return what a joint says beside its place and its motion."""
    from dataclasses import asdict

    from symdyn.scene import spell

    follows = joint.coupling
    limits = {key: getattr(joint.limits, key) for key in asdict(joint.limits)}
    return {
        "mimic": follows
        and {"coordinate": follows.coordinate, "ratio": spell(follows.ratio), "offset": spell(follows.offset)},
        "armature": spell(joint.armature),
        "damping": spell(joint.damping),
        "friction": spell(joint.friction),
        "limits": {key: limit and spell(limit) for key, limit in limits.items()},
    }


def acting(scene: Scene) -> list[dict[str, str]]:
    """Return what acts beside gravity, drives and damping: what it is, its name, where it acts, its law."""
    from symdyn.scene import Place, Quantity, spell

    def row(kind: str, name: str, where: str, law: str) -> dict[str, str]:
        return {"kind": kind, "name": name, "where": where, "law": law}

    def together(vector: tuple[Quantity, ...]) -> str:
        return f"({', '.join(map(spell, vector))})"

    def at(joint: str, ends: tuple[Place, ...]) -> str:
        return f"joint {joint}" if joint else " and ".join(f"{end.body} {together(end.at)}" for end in ends)

    rows = []
    for spring in scene.springs:
        law = [f"stiffness {', '.join(map(spell, spring.stiffness))}", f"free {spell(spring.free)}"]
        rows.append(
            row(
                "spring",
                spring.name,
                at(spring.joint, spring.ends),
                f"{', '.join(law)}, preload {spell(spring.preload)}",
            )
        )
    for damper in scene.dampers:
        law = [f"damping {', '.join(map(spell, damper.damping))}"]
        rows.append(row("damper", damper.name, at(damper.joint, damper.ends), ", ".join(law)))
    for joint in scene.joints:
        if joint.dry is not None:
            dry = joint.dry
            law = [f"Coulomb {spell(dry.coulomb)}"]
            law += [f"static {spell(dry.static)}, Stribeck {spell(dry.stribeck)}"] if dry.static is not None else []
            law += [f"smoothing {spell(dry.smoothing)}"] if spell(dry.smoothing) != "0" else ["ideal sign"]
            rows.append(row("friction", joint.name, at(joint.name, ()), ", ".join(law)))
        if joint.motion is not None:
            rows.append(row("motion", joint.name, at(joint.name, ()), f"{joint.coordinate} = {spell(joint.motion)}"))
    for load in scene.loads:
        law = [f"force {together(load.force)}, couple {together(load.couple)}, axes of the {load.frame}"]
        rows.append(row("load", load.name, at("", (load.place,)), ", ".join(law)))
    return rows


def show(facts: dict[str, Any]) -> None:
    """Print the facts for people."""
    import sys

    from rich.console import Console
    from rich.tree import Tree

    from symdyn.cli.talk import WIDTH, print_table

    free = facts["degrees_of_freedom"]
    freedom = f"{free} degree{'s' * (free != 1)} of freedom"
    print(f"{facts['name']}: {freedom}, gravity ({', '.join(facts['gravity'])}) m/s^2\n")
    branches = {"ground": Tree("ground")}
    for joint in facts["joints"]:
        branches[joint["child"]] = branches[joint["parent"]].add(_label(joint))
    width = None if sys.stdout.isatty() else WIDTH
    Console(width=width, highlight=False, markup=False, emoji=False).print(branches["ground"])
    print()
    if facts["acting"]:
        rows = [tuple(one.values()) for one in facts["acting"]]
        print_table("What acts beside gravity and drives", ("", "name", "where", "law"), rows)
    show_loops(facts)
    if facts["parameters"]:
        rows = [(p["name"], p["value"] or "free", p["unit"], p["text"]) for p in facts["parameters"]]
        print_table("Parameters; free ones are passed as params, in this order", ("name", "value", "unit", ""), rows)
    columns = ("function", "shape", "road", "mul ", "add ", "div ", "sin/cos ", "other ")
    rows = []
    for function in facts["functions"]:
        operations = function["operations"]
        shape = " x ".join(map(str, function["shape"])) or "scalar"
        rows.append((function["name"], shape, function["road"], *(str(count) for count in operations.values())))
    print_table("Operations of one call that depend on the state", columns, rows)
    show_skipped(facts)


def show_loops(facts: dict[str, Any]) -> None:
    """Print what closes the loops, and the mobility with its diagnosis."""
    for loop in facts["loops"]:
        print(f"loop {loop['name']}: {loop['type']} between {loop['parent']} and {loop['child']}")
    found = facts["mobility"]
    if found is None:
        print(end="\n" if facts["loops"] else "")
        return
    counted = f"{found['spatial']} in space (5.20), {found['by_loops']} loop by loop, {found['by_rank']} by rank"
    print(f"mobility: {counted}; independent: {', '.join(found['independent']) or 'none'}")
    if facts["chosen"]:
        print(f"  chosen: {facts['chosen']}")
    for note in found["notes"]:
        print(f"  {note}")
    print()


def show_skipped(facts: dict[str, Any]) -> None:
    """Print what depends on parameters alone, what was left out, and how much that saved, function by function."""
    from symdyn.cli.talk import print_table
    from symdyn.program import Counts

    moved = [(f["name"], str(Counts(**f["prepare"]))) for f in facts["functions"] if any(f["prepare"].values())]
    if moved:
        once = facts["prepare"]
        moved.append((f"prepare, {once['values']} values", str(Counts(**once["operations"]))))
        print_table("On parameters alone; --prepare does it once", ("function", "operations"), moved)
    report = facts["skipped"]
    print_table("Left out or merged", ("step", "why"), [(one["step"], one["why"]) for one in report])
    measured = [one for one in report if one["saved"]]
    rows = [
        (name, *(_saving(one["saved"].get(name)) for one in measured))
        for name in (function["name"] for function in facts["functions"])
        if any(name in one["saved"] for one in measured)
    ]
    title = "What that saved, multiplications/additions (d: divisions, s: sin/cos, o: other); + is what it costs"
    print_table(title, ("function", *(f"{one['step']} " for one in measured)), rows)


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
    return ", ".join(f"{' '.join(names)} in {unit}" for unit, names in parts)


def _label(joint: dict[str, Any]) -> str:
    """Return one line about a joint and the body that it carries."""
    words = [f"{joint['name']}: {joint['type']}"]
    if joint["coordinate"]:
        words.append(f"{joint['coordinate']} in {joint['unit']}")
    elif joint["coordinates"]:
        words.append(_several(joint["coordinates"]))
        words.append(f"velocities {_several(joint['velocities'])}")
        drives = [drive or "none" for drive in joint["drives"]]
        words += [f"drives {' '.join(drives)}"] if any(joint["drives"]) else []
    if joint["mimic"]:
        follows = joint["mimic"]
        words.append(f"follows {follows['coordinate']}: ratio {follows['ratio']}, offset {follows['offset']}")
    words += [f"{key} {joint[key]}" for key in ("armature", "damping", "friction") if joint[key] != "0"]
    limits = joint["limits"]
    if limits["lower"] or limits["upper"]:
        words.append(f"from {limits['lower'] or '-oo'} to {limits['upper'] or 'oo'}")
    words += [f"{key} up to {limits[key]}" for key in ("velocity", "effort") if limits[key]]
    return f"{joint['child']}  ({', '.join(words)})"
