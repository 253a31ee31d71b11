"""Names are printable and each stands for one thing; symbols stand where they may."""

from __future__ import annotations

from symdyn.scene.checks.draft import KINDS, Draft, Use, uses
from symdyn.scene.forces.force_table import FORCES
from symdyn.scene.values.grammar import check_latex
from symdyn.scene.values.joint import acceleration_name
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import CLOCK, check_name, check_scene_name, nearest, suggestion
from symdyn.scene.values.signals import LETTERS
from symdyn.scene.values.table import Faults, show, shown

FAMILIES = {"parameters": "symbol", "bodies": "frame", "points": "frame", "joints": "joint", "loops": "joint"}
FAMILIES |= {"inputs": "symbol", "outputs": "symbol"}
"""Names of one family differ; elements are a family a section."""


def check_names(draft: Draft, faults: Faults) -> None:
    """Report names that no target can print, and those that two things have."""
    scene = draft.scene
    fault = check_scene_name(scene.name)
    if fault:
        faults.add("", f"name = {show(scene.name)} {fault}")
    taken: dict[str, dict[str, str]] = {}
    for kind in KINDS:
        for where, one in zip(draft.where[kind], getattr(scene, kind), strict=True):
            family = FAMILIES.get(kind) or FORCES[one.kind].section
            _claim(faults, taken.setdefault(family, {}), where, "", one.name, family == "symbol")
            if family == "frame" and one.name == Scene.GROUND:
                faults.add(where, "ground is the name of what does not move; choose another")
    declared = [one.latex for one in scene.parameters] + [one.latex for one in scene.inputs]
    for where, latex in zip((*draft.where["parameters"], *draft.where["inputs"]), declared, strict=True):
        fault = check_latex(latex) if latex else None
        if fault:
            faults.add(where, f"latex = {show(latex)} {fault}")
    for kind in ("inputs", "outputs"):
        for where, column in zip(draft.where[kind], getattr(scene, kind), strict=True):
            if LETTERS.has_column(column.name):
                faults.add(where, f"{show(column.name)} is called like a column of runs; choose another name")
    symbols = taken.setdefault("symbol", {})
    for where, joint in zip(draft.where["joints"], scene.joints, strict=True):
        own = [("coordinate", name) for name in joint.coordinates]
        own += [("velocity", name) for name in joint.velocities if not name.endswith("_dot")]
        own += [("drive", name) for name in joint.drives if name]
        for key, name in own:
            _claim(faults, symbols, where, f"{key} = ", name, letter=True)


def _claim(faults: Faults, taken: dict[str, str], where: str, key: str, name: str, letter: bool) -> None:
    fault = check_name(name, letter)
    if fault:
        faults.add(where, f"{key}{show(name)} {fault}")
    elif name in taken:
        faults.add(where, f'{key}"{name}" is already the name of {taken[name]}; choose another name')
    taken.setdefault(name, f"{where} ({key.removesuffix(' = ')})" if key else where)


def check_symbols(draft: Draft, faults: Faults) -> None:
    """Report symbols that are no parameters, where coordinates, velocities or the time may not stand."""
    parameters = {parameter.name: None for parameter in draft.scene.parameters}
    motion = dict.fromkeys(draft.scene.coordinates)
    for velocity in draft.scene.velocities:
        motion |= {velocity: None, acceleration_name(velocity): None}
    for use in uses(draft):
        for name in use.quantity.symbols:
            if name not in parameters and name not in use.allowed:
                why = _why(name, use, parameters, motion, {one.name: None for one in draft.scene.inputs})
                faults.add(use.where, f"{use.key} = {shown(use.quantity)} {why}")


def _why(name: str, use: Use, parameters: dict[str, None], motion: dict[str, None], inputs: dict[str, None]) -> str:
    if name in inputs:
        return f"uses {name}, an input; only forces, loads and outputs may depend on what is given over time"
    if name == CLOCK:
        return "uses t, the time; only forces, loads and prescribed motions may depend on it"
    if name in motion:
        return f"uses {name}, which moves; only the force of a joint, loads and rows may depend on what moves"
    known = [*parameters, *(other for other in (*motion, *inputs) if other in use.allowed)]
    near = nearest(name, sorted(use.allowed))
    known += [near] if near and near not in known else []
    return f"uses the undefined symbol {name}; declare it in parameters ({suggestion(name, known)})"
