"""The variables of an FMU, by value reference: time, states, their rates, inputs, outputs, parameters.

Templates of model descriptions are given every attribute as finished text.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symdyn.arguments import argument
from symdyn.dynamics.mechanism import quaternions
from symdyn.emit.code.target import Draft
from symdyn.emit.render import in_xml
from symdyn.errors import EmitError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op, reachable
from symdyn.program import Program
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import Unit, UnitError, resets_of, spell, velocity_name

TIME = "t"


@dataclass(frozen=True)
class Variable:
    """One variable.

    Attributes:
        reference: its value reference, which is its place in the list, from 0.
        name: as scenes call it; der(x) is the rate of a state x.
        causality: "independent", "local", "output", "input" or "parameter".
        start: its value at the start, None where it is computed.
        unit: as the scene has it.
        text: what it is, one line.
        state: reference of the state whose rate it is, 0 for none.
        depends: references of the states and inputs that a rate or an output depends on.
        least, most: limits of a joint, which nothing in the equations keeps.
    """

    reference: int
    name: str
    causality: str
    start: float | None = None
    unit: str = ""
    text: str = ""
    state: int = 0
    depends: tuple[int, ...] = ()
    least: float | None = None
    most: float | None = None


def parameters_of(program: Program) -> list[str]:
    """Return the names of the parameters that the code takes."""
    found = [one for routine in program.routines for one in routine.function.arguments if one.name == Program.PARAMS]
    return [str(symbol.value) for symbol in found[0].symbols] if found else []


def driven(scene: Scene) -> list[str]:
    """Return the name of the driving force of every velocity, "" where nobody gives one, shape (nv,)."""
    held = scene.prescribed_velocities
    return [drive if drive and k not in held else "" for k, drive in enumerate(scene.drives)]


def placing(scene: Scene) -> tuple[str, ...]:
    """Return the inputs that prescribe positions, and those that prescribe velocities with them."""
    led = {name for joint in scene.joints if joint.motion is not None for name in joint.motion.symbols}
    return tuple(x for name, rate in scene.rates.items() if name in led for x in (name, rate))


def variables(program: Program, q: Sequence[float], u: Sequence[float]) -> tuple[Variable, ...]:
    """Return the variables of a program that starts at q and u; EmitError where a parameter has no value."""
    scene = program.scene
    words = _words(scene)
    outputs = {one.name: one for one in scene.outputs}
    shown = "local" if outputs else "output"
    start = scene.at_time(Graph())
    own = [x for node, x in start.items() if node.value in {one.name for one in scene.states}]
    named = [TIME, *scene.coordinates, *scene.first_order]
    named += [f"der({name})" for name in named[1:]]
    forces, units = driven(scene), {drive: unit for _, drive, unit in SceneUnits(scene).each_drive()}
    inputs = [*filter(None, forces), *(one.name for one in scene.inputs)]
    free = parameters_of(program)
    named += [*inputs, *outputs, *free]
    place = {name: k for k, name in enumerate(named)}
    values = {one.name: one.value for one in scene.parameters if one.value is not None}
    limits = {
        joint.coordinate: (_bound(joint.limits.lower, values), _bound(joint.limits.upper, values))
        for joint in scene.moving
        if joint.coordinate
    }
    depends = _depends(program, place)
    found = [Variable(0, TIME, "independent", None, scene.shown_unit("s"), "time")]
    for name, value in zip([*scene.coordinates, *scene.first_order], [*q, *u, *own], strict=True):
        least, most = limits.get(name, (None, None))
        unit, text = words[name]
        unit = scene.shown_unit(unit)
        found.append(Variable(place[name], name, shown, value, unit, text, 0, (place[name],), least, most))
    for name in [*scene.coordinates, *scene.first_order]:
        rate = f"der({name})"
        unit = f"{words[name][0]}/s" if words[name][0] not in ("rad/s", "m/s") else f"{words[name][0]}^2"
        unit = scene.shown_unit(unit)
        found.append(Variable(place[rate], rate, "local", None, unit, f"rate of {name}", place[name], depends[rate]))
    for name in filter(None, forces):
        found.append(Variable(place[name], name, "input", 0.0, scene.shown_unit(units[name]), "driving force"))
    told, looked = SceneUnits(scene).inferred, SceneUnits(scene).outputs
    for one in scene.inputs:
        found.append(Variable(place[one.name], one.name, "input", _number(one.value), told[one.name], one.text))
    for signal in scene.outputs:
        name = signal.name
        found.append(Variable(place[name], name, "output", None, looked[name], signal.text, 0, depends[name]))
    _check_values(scene, free)
    there = {one.name: one for one in scene.parameters}
    for name in free:
        p = there[name]
        found.append(Variable(place[name], name, "parameter", _number(p.value), told[name], p.text))
    assert [one.reference for one in found] == [*range(len(found))], "references are places"
    return tuple(found)


def _words(scene: Scene) -> dict[str, tuple[str, str]]:
    """Return unit and description of every state."""
    words = {q: (unit, f"position, joint {joint.name}") for joint, q, unit in SceneUnits(scene).each_coordinate()}
    speeds = iter(SceneUnits(scene).velocities)
    for joint in scene.moving:
        words |= {u: (f"{next(speeds)}/s", f"velocity, joint {joint.name}") for u in joint.rates}
    told = SceneUnits(scene).inferred
    return words | {one.name: (told[one.name] or "1", one.text or "state") for one in scene.states}


def _bound(limit: Quantity | None, values: Mapping[str, Quantity]) -> float | None:
    known = {name: value.known_at({}) for name, value in values.items()}
    value = None if limit is None else limit.known_at({k: x for k, x in known.items() if x is not None})
    return None if value is None else float(value)


def _number(value: Quantity | None) -> float:
    found = None if value is None else value.known_at({})
    return 0.0 if found is None else float(found)


def _check_values(scene: Scene, free: Sequence[str]) -> None:
    missing = [one.name for one in scene.parameters if one.name in free and one.value is None]
    if missing:
        raise EmitError(
            f"{scene.name}: {', '.join(missing)} {'has' if len(missing) == 1 else 'have'} no value, and a variable of "
            f"an FMU starts with one; give {argument('values', dict.fromkeys(missing, 1))}, or what they are: they "
            "can be set later"
        )


def _depends(program: Program, place: Mapping[str, int]) -> dict[str, tuple[int, ...]]:
    """Return the references that rates and outputs depend on, by name."""
    scene, functions = program.scene, {one.function.request: one.function for one in program.routines}
    groups = {name: group for group in quaternions(scene) for name in group}
    states = [*scene.coordinates, *scene.first_order]
    forces = {f"tau[{k}]": name for k, name in enumerate(driven(scene)) if name}

    def found(entry: Expr) -> tuple[int, ...]:
        names = [str(node.value) for node in reachable([entry]) if node.op is Op.SYMBOL]
        names = [forces.get(name, name) for name in names]
        if scene.is_constrained and any(
            name in states for name in names
        ):  # states are brought to where loops are closed
            names += states
        names += [other for name in names for other in groups.get(name, ())]
        names += placing(scene) if moved.intersection(names) else ()
        wanted = {place[name] for name in names if name in place and name not in moved}
        return tuple(sorted(wanted - {0} - {place[name] for name in parameters_of(program)}))

    pinned = [scene.velocities[k] for k in scene.prescribed_velocities]
    moved = {name for rate in pinned for name in (rate, rate.removesuffix("_dot"))}
    depends: dict[str, tuple[int, ...]] = {}
    rates = functions.get("coordinate_rates")
    for k, name in enumerate(scene.coordinates):
        if rates is not None:
            depends[f"der({name})"] = found(rates.entries[k])
        elif scene.is_constrained:
            depends[f"der({name})"] = tuple(place[one] for one in states if one not in moved)
        else:
            rate = velocity_name(name)
            depends[f"der({name})"] = tuple(place[x] for x in placing(scene)) if rate in moved else (place[rate],)
    moving = functions["state_rates" if scene.states else "forward_dynamics"].entries
    for name, entry in zip(scene.first_order[::-1], moving[::-1], strict=False):
        depends[f"der({name})"] = found(entry)
    if scene.outputs:
        for one, entry in zip(scene.outputs, functions["outputs"].entries, strict=True):
            depends[one.name] = found(entry)
    return depends


VARIABILITY = {"independent": "continuous", "parameter": "tunable"}
"""Of each causality; "continuous" of all others."""


def described(draft: Draft, variables: Sequence[Variable], differentiated: bool, tolerance: str) -> dict[str, Any]:
    """Return the facts of a model description."""
    outputs = [one for one in variables if one.causality == "output"]
    jumps = [
        f"reset of {', '.join(to)}: {spell(when)}" for (when, _), to in resets_of(draft.program.scene.states).items()
    ]
    rates = [one for one in variables if one.state]
    computed = sorted([*(one for one in outputs if one.start is None), *rates], key=lambda one: one.reference)
    names = dict.fromkeys(one.unit for one in variables if one.unit and one.unit != "1")
    return {
        "model": in_xml(draft.program.scene.name),
        "identifier": in_xml(draft.stem),
        "description": in_xml(f"{draft.page.command}"),
        "differentiated": "true" if differentiated else "false",
        "tolerance": tolerance,
        "units": [{"name": in_xml(name), "base": _base(name)} for name in names],
        "variables": [_variable(one) for one in variables],
        "outputs": [_unknown(one) for one in outputs],
        "rates": [_unknown(one) for one in rates],
        "initial": [_unknown(one) for one in computed],
        "events": [  # in FMI 3 alone
            _variable(Variable(len(variables) + k, f"event({k + 1})", "local", text=text))
            for k, text in enumerate(jumps)
        ],
    }


def _base(unit: str) -> str:
    """Return a unit in those of SI, as attributes; "" where it cannot be read."""
    try:
        found = Unit.read(unit)
    except UnitError:  # such as one of a row, "m/s or 1/s"
        return ""
    exponents = [*found.dimension.powers, ("rad", found.radians)]
    if any(count.denominator != 1 for _, count in exponents):
        return ""
    told = "" if found.is_coherent else f' factor="{found.size!r}"'
    return "".join(f' {name}="{count}"' for name, count in exponents if count) + told or ' factor="1"'


def _variable(one: Variable) -> dict[str, Any]:
    initial = "" if one.causality in ("independent", "input") else "calculated" if one.start is None else "exact"
    manner = f' causality="{one.causality}" variability="{VARIABILITY.get(one.causality, "continuous")}"'
    unit = f' unit="{in_xml(one.unit)}"' if one.unit and one.unit != "1" else ""
    start = "" if one.start is None else f' start="{one.start!r}"'
    limits = "".join(f' {k}="{x!r}"' for k, x in (("min", one.least), ("max", one.most)) if x is not None)
    return {
        "name": in_xml(one.name),
        "reference": one.reference,
        "manner": manner + (f' initial="{initial}"' if initial else ""),
        "description": f' description="{in_xml(one.text)}"' if one.text else "",
        "real2": unit + limits + start + (f' derivative="{one.state + 1}"' if one.state else ""),
        "real3": unit + limits + start + (f' derivative="{one.state}"' if one.state else ""),
    }


def _unknown(one: Variable) -> dict[str, Any]:
    return {
        "reference": one.reference,
        "index": one.reference + 1,
        "references": " ".join(map(str, one.depends)),
        "indices": " ".join(str(k + 1) for k in one.depends),
    }
