"""Checks of a scene as a whole: names, tree, loops, symbols, values, physics. Every fault is reported.

Names are printable and each stands for one thing; symbols stand where they may.

Joints and what acts: directions, signs and starts, and what their rows know to be wrong.

Joints hang every body on ground, each on one joint; what closes a loop connects two bodies.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from fractions import Fraction

from symdyn.arguments import argument
from symdyn.errors import hint, listed, nearest, suggestion
from symdyn.graph import Graph, Op
from symdyn.scene.declaration.dimensions import SceneUnits, check_units
from symdyn.scene.declaration.draft import KINDS, Draft, Use, judge, uses
from symdyn.scene.forces.flows import changing
from symdyn.scene.forces.force_table import FORCES
from symdyn.scene.joints.joint_table import JOINTS, RESISTING
from symdyn.scene.values.body import mass_faults
from symdyn.scene.values.entry import Faults, show, shown
from symdyn.scene.values.grammar import CLOCK, LETTERS, check_latex, check_name, check_scene_name
from symdyn.scene.values.joint import Joint, Strut, acceleration_name
from symdyn.scene.values.key import Key, Stand
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity, Value

FAMILIES = {"parameters": "symbol", "bodies": "frame", "points": "frame", "joints": "joint", "loops": "joint"}
FAMILIES |= dict.fromkeys(("inputs", "outputs", "derived", "states", "signals"), "symbol")
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
            if kind == "inputs" and one.of:  # called by rule, as velocities are
                continue
            family = FAMILIES.get(kind) or FORCES[one.kind].section.replace("ropes", "constraints")
            _claim(faults, taken.setdefault(family, {}), where, "", one.name, family == "symbol")
            if family == "frame" and one.name == Scene.GROUND:
                faults.add(where, "ground is the name of what does not move; choose another")
    places = (where for kind in ("parameters", "inputs", "states") for where in draft.where[kind])
    printed = [(where, letter.latex) for where, letter in zip(places, scene.letters, strict=True)]
    joints = zip(draft.where["joints"], scene.joints, strict=True)
    for where, latex in (*printed, *((where, latex) for where, joint in joints for _, latex in joint.latex)):
        if latex and (fault := check_latex(latex)):
            faults.add(where, f"latex = {show(latex)} {fault}")
    for kind in ("inputs", "outputs", "states", "signals"):
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
                why = _why(name, use, draft.scene, motion)
                faults.add(use.where, f"{use.key} = {shown(use.quantity)} {why}")


def _why(name: str, use: Use, scene: Scene, motion: dict[str, None]) -> str:
    parameters, given = (dict.fromkeys(one.name for one in some) for some in (scene.parameters, scene.given))
    later = {*map(acceleration_name, scene.velocities), *filter(None, scene.drives), *scene.reaction_axes}
    if use.where.startswith(("states.", "signals.")) and name in later:
        return (
            f"uses {name}, which follows from forces: an algebraic loop; use coordinates, velocities, states, inputs, t"
        )
    if use.key.startswith(("mass", "inertia")) and (name in motion or name == CLOCK or name in given):
        return f"uses {name}; {changing(use.where, scene)}"
    if name in given:
        if name in (one.name for one in scene.states):
            return f"uses {name}, a state; only forces, loads, masses, rates, signals and outputs may depend on it"
        if use.key == "motion" or ".at[" in use.key:
            least = 2 if use.key == "motion" else 1
            return f"uses {name}, an input without its rates; write rates = {least} in [inputs.{name}]"
        return f"uses {name}, an input; only forces, loads and outputs may depend on what is given over time"
    if name == CLOCK:
        return "uses t, the time; only forces, loads and prescribed motions may depend on it"
    if name in motion:
        if use.key == "motion":
            return f'uses {name}, which moves; write mimic = {{ joint = "leader", ratio = 2 }} for what follows a joint'
        return f"uses {name}, which moves; only the force of a joint, loads and rows may depend on what moves"
    for one in scene.inputs:
        if name in (of := (f"{one.name}_dot", f"{one.name}_ddot")):
            return f"uses {name}, a rate of the input; write rates = {of.index(name) + 1} in [inputs.{one.name}]"
    if name in (one.name for one in scene.outputs):
        return f"uses {name}, an output; move it to [signals], which other formulas may use"
    known = [*parameters, *(other for other in (*motion, *given) if other in use.allowed)]
    over_time = f", or [inputs.{name}] over time" if CLOCK in use.allowed else ""
    near = nearest(name, sorted(use.allowed), scene)
    known += [near] if near and near not in known else []
    if not near and use.where.startswith("outputs.") and (place := re.fullmatch(r"point_(\w+)_[xyz](_d?dot)?", name)):
        body = next((one.name for one in reversed(scene.bodies)), "NAME")
        return f'uses {name}, of no point; write [points.{place[1]}] with body = "{body}"'
    if constant := hint("characters", name):
        return f"uses the undefined symbol {name}; {constant}"
    return f"uses the undefined symbol {name}; declare it in parameters ({suggestion(name, known, scene)}){over_time}"


def check_joints(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Report what is wrong with the joints, one by one."""
    for section in ("joints", "loops"):
        for where, joint in zip(draft.where[section], getattr(draft.scene, section), strict=True):
            stand = Stand(where, draft.scene, values, faults)
            _shape(joint, stand)
            _signs(joint, stand)
            _start(joint, stand)
            if joint.motion is not None and not any(joint.drives):
                what = f"motion = {shown(joint.motion)} prescribes what no drive can hold"
                stand.fault(f"{what}: the joint is passive; leave out drive = false, or the motion")


def _shape(joint: Joint, stand: Stand) -> None:
    """Directions are directions, and what the keys of the type say fits together."""
    kind = JOINTS[joint.type]
    fine = [stand.direction(key.name, way) for key, way in kind.directions(joint)]
    if all(fine) and (amiss := kind.fault(joint)):
        stand.fault(amiss)
    for key in (*kind.keys, *RESISTING):
        key.check(joint, stand)


def _signs(joint: Joint, stand: Stand) -> None:
    """What acts fits together, and limits leave room."""
    if joint.dry and (check := FORCES[joint.dry.kind].check):
        check(joint.dry, stand)
    lower, upper = joint.limits.lower, joint.limits.upper
    if lower is not None and upper is not None:
        low, high = stand.value(lower), stand.value(upper)
        if low is not None and high is not None and low > high:
            stand.fault(f"limits.lower = {shown(lower)} is above limits.upper = {shown(upper)}; swap them")
    begin = (*joint.start, Quantity.ZERO)[0]
    asked = len(joint.coordinates) == 1 and (joint.start or stand.faults.own)
    for limit, word, side in ((lower, "below limits.lower", 1), (upper, "above limits.upper", -1)) if asked else ():
        at, size = stand.value(begin), None if limit is None else stand.value(limit)
        if limit is not None and size is not None and at is not None and side * size > side * at:
            stand.faults.note(stand.where, f"start = {shown(begin)} is {word} = {shown(limit)}")
    if joint.limits.one_way and len(joint.rates) != 1:
        stand.fault(f"limits.one_way is of a joint with one velocity of its own, and this has {len(joint.rates)}")
    e = joint.limits.restitution
    if e is None:
        return
    if (size := stand.value(e)) is not None and not 0 <= size <= 1:
        stand.fault(f"limits.restitution = {shown(e)} is not between 0 and 1")
    if lower is None and upper is None:
        stand.fault("limits.restitution goes with lower or upper, which the joint strikes; give one of them")


def _start(joint: Joint, stand: Stand) -> None:
    first = JOINTS[joint.type].quaternion(joint)
    if first is None or not joint.start:
        return
    if all(stand.value(x) == 0 for x in joint.start[first : first + 4]):
        shift = "" if len(joint.start) == 4 else f", entries {first + 1} to {first + 4},"
        stand.fault(f"start: the quaternion (w, x, y, z){shift} has zero length; give one such as 1, 0, 0, 0")


def note_angles(scene: Scene, faults: Faults) -> None:
    """Note plain numbers of degrees where angles in radians stand: multiples of 15 beyond a turn; of limits, usual."""
    angles = {coordinate for _, coordinate, unit in SceneUnits(scene).each_coordinate() if unit == "rad"}
    usual = (30, 45, 60, 90, 120, 135, 150, 180, 270, 360)
    for joint in (*scene.joints, *scene.loops):
        turned = [x for kind, x in (*joint.origin.steps, *joint.tip.steps) if kind.startswith("R")]
        turned += [x for q, x in zip(joint.coordinates, joint.start, strict=False) if q in angles]
        ends = [x for x in (joint.limits.lower, joint.limits.upper) if x and _in_degrees(x) and abs(float(x)) in usual]
        turned += ends if len(ends) == 2 and angles.intersection(joint.coordinates) else []
        if (said := next(filter(_in_degrees, turned), None)) is not None:
            told = f'the angle {shown(said)} is in rad, many turns; in degrees write "{shown(said)} deg"'
            faults.note(f"joints.{joint.name}", told)


def _in_degrees(x: Quantity) -> bool:
    return not x.unit and isinstance(x.value, Fraction) and 7 < abs(x.value) <= 360 and x.value % 15 == 0


def check_elements(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Report what is wrong with the elements, one by one: places before numbers, and then what their kind knows."""
    for where, one in zip(draft.where["elements"], draft.scene.elements, strict=True):
        kind, stand = FORCES[one.kind], Stand(where, draft.scene, values, faults)
        for part in sorted(kind.parts, key=lambda part: isinstance(part, Key)):
            part.check(one, stand)
        if kind.check is not None:
            kind.check(one, stand)
        if isinstance(one, Strut) and len(one.ends) == 2 and not one.is_rope and not faults.lines:
            _acts(one, stand)


def _acts(strut: Strut, stand: Stand) -> None:
    """Report an end that a joint between both bodies leaves where it is: its length never changes."""
    g = Graph()
    at = {one.body: (x.express(g), y.express(g), z.express(g)) for one in strut.ends for x, y, z in (one.at,)}
    for joint in (*stand.scene.joints, *stand.scene.loops):
        if {joint.parent, joint.child} == {*at} and joint.coupling is None and JOINTS[joint.type].coordinates(joint):
            motion = JOINTS[joint.type].anywhere(joint, g).placement
            seen = joint.origin.inverse().transform(g).point(at[joint.parent])
            for p in (seen, joint.tip.transform(g).point(at[joint.child])):
                if all((a - b).is_zero for a, b in zip(motion.point(p), p, strict=True)):
                    told = f"an end lies where {joint.name} does not move it, so that its length never changes"
                    torsion = f'for a torsion write joint = "{joint.name}", else '
                    stand.fault(f"{told}; {torsion * bool(joint.coordinate)}give places that it moves")


def check_tree(draft: Draft, faults: Faults) -> None:
    """Report ends that are no bodies, bodies that joints do not connect to the ground, and a scene that is fixed."""
    scene = draft.scene
    bodies = {body.name: None for body in scene.bodies}
    ends = {**bodies, Scene.GROUND: None}
    carrier: dict[str, Joint] = {}
    for where, joint in zip(draft.where["joints"], scene.joints, strict=True):
        _ends(where, joint, bodies, ends, faults)
        if joint.child == Scene.GROUND:
            faults.add(where, f'child = "{Scene.GROUND}" cannot move; swap parent and child')
        elif joint.child in carrier:
            faults.add(where, f'child = "{joint.child}" is already the child of the joint {carrier[joint.child].name}')
        elif joint.child:
            carrier[joint.child] = joint
    joined = {body for joint in (*scene.joints, *scene.loops) for body in (joint.parent, joint.child)}
    for where, body in zip(draft.where["bodies"], scene.bodies, strict=True):
        if body.name in carrier or body.name == Scene.GROUND or any(one.parent == one.child for one in scene.loops):
            continue
        if body.name in joined:
            lost = f"no joint leads from {Scene.GROUND} to the body{_company(scene, body.name)}"
            faults.add(where, f'{lost}; add one with child = "{body.name}"')
        else:
            faults.add(where, f'no joint connects the body to {Scene.GROUND}; add one with child = "{body.name}"')
    for where, point in zip(draft.where["points"], scene.points, strict=True):
        _named(where, "body", point.body, ends, faults)
    _cycles(draft, carrier, faults)
    if not any(joint.moves for joint in scene.joints):
        faults.add("", "nothing moves; declare at least one body and a revolute or prismatic joint that carries it")


def _ends(where: str, joint: Joint, bodies: Mapping[str, None], ends: Mapping[str, None], faults: Faults) -> None:
    _named(where, "parent", joint.parent, ends, faults)
    if joint.child != Scene.GROUND:  # reported by itself
        _named(where, "child", joint.child, bodies, faults)


def _named(where: str, key: str, name: str, bodies: Collection[str], faults: Faults) -> None:
    faults.nameless(where, key, name)
    if name and name not in bodies:
        faults.add(where, f'{key} = "{name}" is not a body; {suggestion(name, bodies)}')


def _company(scene: Scene, name: str) -> str:
    """Return which bodies float together with one, "" if there are none."""
    joints = [joint for joint in (*scene.joints, *scene.loops) if joint.parent != joint.child]
    group, stack = {name: None}, [name]
    while stack:
        here = stack.pop()
        ends = [(joint.parent, joint.child) for joint in joints if here in (joint.parent, joint.child)]
        stack += [x for pair in ends for x in pair if x not in group]
        group.update(dict.fromkeys(stack))
    others = [x for x in group if x != name]
    if not others or Scene.GROUND in group:
        return ""
    return f" or to {listed(others)}, which {'is' if len(others) == 1 else 'are'} connected with it"


def _cycles(draft: Draft, carrier: Mapping[str, Joint], faults: Faults) -> None:
    settled: set[str] = set()
    places = dict(zip((joint.name for joint in draft.scene.joints), draft.where["joints"], strict=True))
    for joint in draft.scene.joints:
        path: dict[str, None] = {}
        name = joint.child
        while name in carrier and name not in settled and name not in path:
            path[name] = None
            name = carrier[name].parent
        if name in path:
            ring = list(path)[list(path).index(name) :]
            shown = " -> ".join([*ring[:10], *(["..."] if len(ring) > 10 else []), name])
            first = next(one for one in draft.scene.joints if one.child in ring)
            lost = f'parent = "{first.parent}" closes a ring, {shown} (child -> parent), that nothing joins to ground'
            faults.add(places[first.name], f'{lost}; write parent = "{Scene.GROUND}" in one of its joints')
        settled.update(path)


def check_loops(draft: Draft, faults: Faults) -> None:
    """Report joints that close loops between bodies that are one, or that say what they forbid in no formula."""
    scene = draft.scene
    bodies = {body.name: None for body in scene.bodies}
    ends, rigid = {**bodies, Scene.GROUND: None}, _rigid(scene.joints)
    for where, joint in zip(draft.where["loops"], scene.loops, strict=True):
        _ends(where, joint, bodies, ends, faults)
        if joint.parent == joint.child:
            faults.add(where, f'joins "{joint.parent}" with itself; write another parent or child')
        elif rigid.get(joint.parent, joint.parent) == rigid.get(joint.child, joint.child):
            both = f'"{joint.parent}" and "{joint.child}"'
            faults.add(where, f"joins {both}, which fixed joints make one body; close the loop between two bodies")
        kind = JOINTS[joint.type]
        if kind.forbids is None:
            advice = "since what it forbids has no formula; cut another joint"
            faults.add(where, f"a {joint.type} joint closes no loop, {advice}")
        elif not kind.class_t(joint):
            faults.add(where, f"a {joint.type} joint forbids nothing and closes no loop; leave it out")


def _rigid(joints: tuple[Joint, ...]) -> dict[str, str]:
    """Return for every body that hangs on fixed joints the one at their beginning; parents come first."""
    root: dict[str, str] = {}
    for joint in joints:
        if not JOINTS[joint.type].velocities(joint):
            root[joint.child] = root.get(joint.parent, joint.parent)
    return root


def check(
    draft: Draft, faults: Faults, allow_invalid_inertia: bool = False, dimensions: bool = True
) -> tuple[str, ...]:
    """Report every fault of a draft, of `dimensions` if asked for; return bodies whose inertia is a note instead."""
    values = _parameter_values(draft, faults)
    check_names(draft, faults)
    check_symbols(draft, faults)
    check_tree(draft, faults)
    check_loops(draft, faults)
    check_joints(draft, values, faults)
    check_elements(draft, values, faults)
    _formulas(draft, values, faults)
    untold = (faults.told(where, "type = ") for where in (*draft.where["joints"], *draft.where["loops"]))
    if not any((*untold, *(faults.told(where, "joint = ") for where in draft.where["elements"]))):
        check_units(draft, faults, dimensions and not draft.scene.dimensionless)  # a joint's type says what is in rad
    return tuple(_masses(draft, values, faults, allow_invalid_inertia))


def _parameter_values(draft: Draft, faults: Faults) -> dict[str, Value]:
    values: dict[str, Value] = {}
    for kind in ("parameters", "derived"):
        for where, one in zip(draft.where[kind], getattr(draft.scene, kind), strict=True):
            if one.value is None:
                continue
            value = _constant(where, one.value, faults) if kind == "parameters" else one.value.known_at(values)
            if value is not None and one.positive and value <= 0:
                faults.add(where, f"value = {shown(one.value)} is not positive; correct it or drop positive = true")
            values |= {} if value is None else {one.name: value}
    for where, letter in zip(draft.where["inputs"], draft.scene.inputs, strict=True):
        _constant(where, letter.value, faults)
    return values


def _constant(where: str, value: Quantity, faults: Faults) -> Value | None:
    """Return what a value without symbols is, None after a fault."""
    if value.symbols:
        way = f"; over time, it is given by {argument('forces')}" if CLOCK in value.symbols else ""
        told = f"uses {', '.join(value.symbols)}; a value may hold numbers and pi only{way}"
        faults.add(where, f"value = {shown(value)} {told}")
        return None
    try:
        value.express(Graph())  # sees that sin(pi) is zero, which a float does not
        found = value.at({})
    except (FormulaError, ZeroDivisionError) as error:
        why = error if isinstance(error, FormulaError) else "divides by zero"
        faults.add(where, f"value = {shown(value)} {why}; give a finite number")
        return None
    assert found is not None, "a formula without symbols has a value"
    return found


def _formulas(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Every formula has a value: no division by what is zero, no root of what is negative."""
    graph = Graph()
    for use in uses(draft):
        if use.quantity.op is Op.CONSTANT:
            continue
        try:
            use.quantity.express(graph)
            use.quantity.at(values)
        except ZeroDivisionError:
            faults.add(use.where, f"{use.key} = {shown(use.quantity)} divides by zero; check the denominator")
        except FormulaError as error:
            faults.add(use.where, f"{use.key} = {shown(use.quantity)} {error}; check the values of its parameters")


def _masses(draft: Draft, values: Mapping[str, Value], faults: Faults, allow: bool) -> Iterator[str]:
    negative = set()
    held = _rigid(draft.scene.joints)
    for where, body in zip(draft.where["bodies"], draft.scene.bodies, strict=True):
        aside = any(x != Quantity.ZERO for x in body.com or ())
        if aside and body.mass == Quantity.ZERO and held.get(body.name) != Scene.GROUND:
            faults.note(where, "has a centre of mass and no mass, so that no weight acts there; write mass too")
        for fault in mass_faults(body, values):
            faults.add(where, fault)
            follows = {*body.mass.symbols} & {name for x in body.inertia for name in x.symbols}
            negative |= {body.name} if body.about == "frame" or follows else set()
    for where, name, why, advice, fine in judge(draft, values):
        if name in negative:
            continue
        if fine:
            faults.note(where, why)
        elif allow:
            faults.note(where, f"{why}; kept as it is")
            yield name
        else:
            faults.add(where, f"{why}; {advice}, or {faults.excuse}")
