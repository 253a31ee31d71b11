"""Checks of a scene as a whole: names, tree, symbols, values, physics. Every fault is reported, none is repaired."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields

from symdyn.graph import Graph
from symdyn.scene.folding import FormulaError
from symdyn.scene.model import GROUND, Joint, Limits, Pose, Scene, acceleration_name
from symdyn.scene.names import check_latex, check_name, listed, suggestion
from symdyn.scene.physical import inertia_fault, mass_faults
from symdyn.scene.quantity import ZERO, Quantity, express
from symdyn.scene.spelling import spell
from symdyn.scene.table import Faults, shorten
from symdyn.scene.value import Value, value_of


@dataclass(frozen=True)
class Draft:
    """A scene in declared order, not yet checked; bodies and joints need not belong together.

    Attributes:
        scene: what was declared.
        where: for each of "parameters", "bodies", "joints" and "points" the places of its entries, for messages.
    """

    scene: Scene
    where: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class Use:
    """A quantity of the scene, where it stands, and what it may name beside parameters."""

    where: str
    key: str
    quantity: Quantity
    allowed: frozenset[str] = frozenset()


def check(draft: Draft, faults: Faults, allow_invalid_inertia: bool = False) -> tuple[str, ...]:
    """Report every fault of a draft; return the bodies whose inertia is a note instead, if that is allowed."""
    values = _parameter_values(draft, faults)
    _names(draft, faults)
    _symbols(draft, faults)
    _tree(draft, faults)
    _axes(draft, faults)
    _formulas(draft, values, faults)
    _signs(draft, values, faults)
    return tuple(_masses(draft, values, faults, allow_invalid_inertia))


def _parameter_values(draft: Draft, faults: Faults) -> dict[str, Value]:
    values: dict[str, Value] = {}
    for where, parameter in zip(draft.where["parameters"], draft.scene.parameters, strict=True):
        if parameter.value is None:
            continue
        if parameter.value.symbols:
            names = ", ".join(parameter.value.symbols)
            faults.add(where, f"value = {_shown(parameter.value)} uses {names}; a value may hold numbers and pi only")
            continue
        try:
            express(parameter.value, Graph())  # sees that sin(pi) is zero, which a float does not
            value = value_of(parameter.value, {})
        except (FormulaError, ZeroDivisionError) as error:
            why = error if isinstance(error, FormulaError) else "divides by zero"
            faults.add(where, f"value = {_shown(parameter.value)} {why}; give a finite number")
            continue
        assert value is not None, "a formula without symbols has a value"
        if parameter.positive and value <= 0:
            faults.add(where, f"value = {_shown(parameter.value)} is not positive; correct it or drop positive = true")
        values[parameter.name] = value
    return values


def _names(draft: Draft, faults: Faults) -> None:
    """Names are printable, and each stands for one thing."""
    scene = draft.scene
    fault = check_name(scene.name)
    if fault:
        faults.add("", f'name = "{scene.name}" {fault}')
    taken: dict[str, dict[str, str]] = {}
    for kind, family, names in (
        ("parameters", "symbol", [parameter.name for parameter in scene.parameters]),
        ("bodies", "frame", [body.name for body in scene.bodies]),
        ("joints", "joint", [joint.name for joint in scene.joints]),
        ("points", "frame", [point.name for point in scene.points]),
    ):
        for where, name in zip(draft.where[kind], names, strict=True):
            _claim(faults, taken.setdefault(family, {}), where, "", name)
            if family == "frame" and name == GROUND:
                faults.add(where, "ground is the name of what does not move; choose another")
    for where, parameter in zip(draft.where["parameters"], scene.parameters, strict=True):
        fault = check_latex(parameter.latex) if parameter.latex else None
        if fault:
            faults.add(where, f"latex = {shorten(repr(parameter.latex))} {fault}")
    for where, joint in zip(draft.where["joints"], scene.joints, strict=True):
        for key, symbol in (("coordinate", joint.coordinate), ("drive", joint.drive)):
            if symbol:
                _claim(faults, taken.setdefault("symbol", {}), where, f"{key} = ", symbol)


def _claim(faults: Faults, taken: dict[str, str], where: str, key: str, name: str) -> None:
    fault = check_name(name)
    if fault:
        faults.add(where, f'{key}"{name}" {fault}')
    elif name in taken:
        faults.add(where, f'{key}"{name}" is already the name of {taken[name]}; choose another name')
    taken.setdefault(name, f"{where} ({key.removesuffix(' = ')})" if key else where)


def _symbols(draft: Draft, faults: Faults) -> None:
    """Every symbol is a parameter, or a coordinate where coordinates may stand."""
    parameters = {parameter.name: None for parameter in draft.scene.parameters}
    motion = dict.fromkeys(_motion_names(draft.scene))
    for use in _uses(draft):
        for name in use.quantity.symbols:
            if name in parameters or name in use.allowed:
                continue
            known = [*parameters, *(other for other in motion if other in use.allowed)]
            if name in motion:
                why = f"uses {name}, which moves; only the force of a joint may depend on coordinates and velocities"
            else:
                why = f"uses the undefined symbol {name}; declare it in parameters ({suggestion(name, known)})"
            faults.add(use.where, f"{use.key} = {_shown(use.quantity)} {why}")


def _tree(draft: Draft, faults: Faults) -> None:
    """Joints hang every body on ground, each on one joint."""
    scene = draft.scene
    bodies = {body.name: None for body in scene.bodies}
    carrier: dict[str, Joint] = {}
    for where, joint in zip(draft.where["joints"], scene.joints, strict=True):
        for key, name in (("parent", joint.parent), ("child", joint.child)):
            if name and name not in bodies and name != GROUND:
                near = suggestion(name, [*bodies, GROUND] if key == "parent" else bodies)
                faults.add(where, f'{key} = "{name}" is not a body; {near}')
        if joint.child == GROUND:
            faults.add(where, f'child = "{GROUND}" cannot move; swap parent and child')
        elif joint.child in carrier:
            other = carrier[joint.child].name
            advice = "a body hangs on one joint (closed loops are not part of a tree)"
            faults.add(where, f'child = "{joint.child}" already hangs on the joint {other}; {advice}')
        elif joint.child:
            carrier[joint.child] = joint
    for where, body in zip(draft.where["bodies"], scene.bodies, strict=True):
        if body.name not in carrier and body.name != GROUND:
            faults.add(where, f'the body hangs on no joint; add one with child = "{body.name}"')
    _cycles(draft, carrier, faults)
    if not any(joint.moves for joint in scene.joints):
        faults.add("", "nothing moves; declare at least one body and a revolute or prismatic joint that carries it")


def _cycles(draft: Draft, carrier: Mapping[str, Joint], faults: Faults) -> None:
    settled: set[str] = set()
    for where, joint in zip(draft.where["joints"], draft.scene.joints, strict=True):
        path: dict[str, None] = {}
        name = joint.child
        while name in carrier and name not in settled and name not in path:
            path[name] = None
            name = carrier[name].parent
        if name in path:
            ring = list(path)[list(path).index(name) :]
            shown = " -> ".join([*ring[:10], *(["..."] if len(ring) > 10 else []), name])
            faults.add(where, f"its body hangs on itself: {shown} (child -> parent); let one of them hang on {GROUND}")
        settled.update(path)


def _axes(draft: Draft, faults: Faults) -> None:
    for where, joint in zip(draft.where["joints"], draft.scene.joints, strict=True):
        shown = f"axis = [{', '.join(_shown(x) for x in joint.axis)}]"
        names = listed(name for x in joint.axis for name in x.symbols)
        if names != "none":
            faults.add(where, f"{shown} depends on {names}; give numbers, and tilt by origin.rpy instead")
        elif all(_vanishes(x) for x in joint.axis):
            faults.add(where, f"{shown} has zero length; give a direction such as [0, 0, 1]")


def _vanishes(quantity: Quantity) -> bool:
    try:
        return express(quantity, graph := Graph()) is graph.zero or value_of(quantity, {}) == 0
    except (FormulaError, ZeroDivisionError):
        return False  # reported as a formula without a value


def _formulas(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Every formula has a value: no division by what is zero, no root of what is negative."""
    graph = Graph()
    for use in _uses(draft):
        try:
            express(use.quantity, graph)
            value_of(use.quantity, values)
        except ZeroDivisionError:
            faults.add(use.where, f"{use.key} = {_shown(use.quantity)} divides by zero; check the denominator")
        except FormulaError as error:
            faults.add(use.where, f"{use.key} = {_shown(use.quantity)} {error}; check the values of its parameters")


def _signs(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """What dissipates or stores energy is not negative, and limits leave room."""
    for where, joint in zip(draft.where["joints"], draft.scene.joints, strict=True):
        numbers = dict(_joint_numbers(joint))
        known: dict[str, Value | None] = {}
        for key, quantity in numbers.items():
            try:
                known[key] = value_of(quantity, values)
            except FormulaError:
                known[key] = None  # reported as a formula without a value
        for key in ("armature", "damping", "friction", "limits.velocity", "limits.effort"):
            value = known.get(key)
            if value is not None and value < 0:
                faults.add(where, f"{key} = {float(value):.6g} is negative; give zero or more")
        lower, upper = known.get("limits.lower"), known.get("limits.upper")
        if lower is not None and upper is not None and lower > upper:
            shown = [f"{key} = {_shown(numbers[key])}" for key in ("limits.lower", "limits.upper")]
            faults.add(where, f"{shown[0]} is above {shown[1]}; swap them")


def _masses(draft: Draft, values: Mapping[str, Value], faults: Faults, allow: bool) -> Iterator[str]:
    for where, body in zip(draft.where["bodies"], draft.scene.bodies, strict=True):
        negative = mass_faults(body, values)
        for fault in negative:
            faults.add(where, fault)
        if body.allow_invalid_inertia or (negative and body.about == "frame"):
            continue
        wrong = inertia_fault(body, values)
        if wrong and allow:
            faults.note(where, f"{wrong[0]}; kept as it is")
            yield body.name
        elif wrong:
            faults.add(where, f"{wrong[0]}; {wrong[1]}, or {faults.excuse}")


def _motion_names(scene: Scene) -> list[str]:
    names: list[str] = []
    names += scene.coordinates
    for velocity in scene.velocities:
        names += [velocity, acceleration_name(velocity)]
    return names


def _uses(draft: Draft) -> Iterator[Use]:
    """Return every quantity but parameter values and axes, in declared order."""
    scene = draft.scene
    for i, x in enumerate(scene.gravity):
        yield Use("", f"gravity[{i}]", x)
    for where, body in zip(draft.where["bodies"], scene.bodies, strict=True):
        yield Use(where, "mass", body.mass)
        for key, vector in (("com", body.com), ("first_moment", body.first_moment), ("inertia", body.inertia)):
            yield from (Use(where, f"{key}[{i}]", x) for i, x in enumerate(vector or ()))
        for k, particle in enumerate(body.particles):
            yield Use(where, f"particles[{k}].mass", particle.mass)
            yield from (Use(where, f"particles[{k}].at[{i}]", x) for i, x in enumerate(particle.at))
    moving = frozenset((*scene.coordinates, *scene.velocities))
    for where, joint in zip(draft.where["joints"], scene.joints, strict=True):
        yield from _steps(where, "origin", joint.origin)
        yield from _steps(where, "tip", joint.tip)
        if joint.force != ZERO:
            yield Use(where, "force", joint.force, moving)
        yield from (Use(where, key, quantity) for key, quantity in _joint_numbers(joint))
    for where, point in zip(draft.where["points"], scene.points, strict=True):
        yield from _steps(where, "at", point.at)


def _joint_numbers(joint: Joint) -> Iterator[tuple[str, Quantity]]:
    """Return what a joint says beside its placement and force, by key."""
    if joint.coupling is not None:
        yield from (("mimic.ratio", joint.coupling.ratio), ("mimic.offset", joint.coupling.offset))
    yield from (("armature", joint.armature), ("damping", joint.damping), ("friction", joint.friction))
    for field in fields(Limits):
        quantity = getattr(joint.limits, field.name)
        if quantity is not None:
            yield f"limits.{field.name}", quantity


def _steps(where: str, key: str, pose: Pose) -> Iterator[Use]:
    yield from (Use(where, f"{key}.{kind}", amount) for kind, amount in pose.steps)


def _shown(quantity: Quantity) -> str:
    return shorten(spell(quantity))
