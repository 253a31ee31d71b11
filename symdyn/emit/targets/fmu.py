"""The FMU target: forward dynamics of a scene as a model of FMI 2.0 and one of FMI 3.0, each a source FMU.

    states        coordinates and velocities, closed loops and unit quaternions kept where rates are evaluated
    inputs        driving forces, and what the scene declares in [inputs]
    outputs       what the scene declares in [outputs]; positions and velocities where it declares none
    parameters    all that have a name, tunable, the scene's value as start
    events        resets of states, each with an indicator

It starts where `simulate` does from what the scene says, loops closed and prescribed motions at t = 0. Both do model
exchange and co-simulation. `build` adds a binary where there is a compiler. The code of the equations is that of the C
target; the files of FMI around it declare the types of the standard themselves. The same members make an archive of the
same bytes; they are stored as they are, since packers differ.

Reference: Modelica Association, Functional Mock-up Interface 2.0.4 and 3.0.1, https://fmi-standard.org.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from typing import Any

from symdyn.dynamics import OUTPUTS
from symdyn.dynamics.mechanism import prescribed, quaternions
from symdyn.emit.code.spelling import Printer, Real
from symdyn.emit.code.target import Contents, Draft, Target
from symdyn.emit.render import render, verbatim
from symdyn.emit.targets.c.c_and_cpp import C
from symdyn.emit.targets.fmu_variables import Variable, described, driven, placing, variables
from symdyn.errors import EmitError
from symdyn.graph import Op, evaluate
from symdyn.scene import Scene
from symdyn.scene.joints import start_of
from symdyn.scene.values import resets_of

BIRTHDAY = (1980, 1, 1, 0, 0, 0)
"""When every member was written: no date reaches a file."""


def packed(files: Mapping[str, str | bytes]) -> bytes:
    """Return files as an archive, in their order."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, contents in files.items():
            member = zipfile.ZipInfo(name, BIRTHDAY)
            member.create_system = 3
            member.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(member, contents)
    return stream.getvalue()


def starting_state(scene: Scene) -> tuple[list[float], list[float]]:
    """Return coordinates and velocities where a bound scene starts, shapes (nq,) and (nv,); rad, m or 1, and per s.

    Raises:
        EmitError: angles are singular there, or a wheel lies flat.
        DerivationError: the loops do not close, or the velocities contradict each other.
    """
    from symdyn.algebra import Floats
    from symdyn.dynamics.loops import Numbers

    numbers = Numbers(scene)
    q, u = numbers.start(), [numbers.value(x) for x in start_of(scene).velocity]
    motion = prescribed(scene, numbers.graph)
    known = numbers.parameters | scene.at_time(numbers.graph)
    count = len(motion.place)
    found = evaluate([*motion.position, *motion.velocity], Floats(), known) if count else []
    for k, place, speed in zip(motion.place, found[:count], found[count:], strict=True):
        q[scene.coordinates.index(scene.velocities[k].removesuffix("_dot"))] = place
        u[k] = speed
    if scene.is_constrained:
        held = list(motion.place)
        q = numbers.normalised(q)
        assembly = numbers.closed_position(q if held or any(q) else None, held or None)
        q[:] = assembly.q
        declared = numbers.declared_rates()
        u = numbers.fitting_rates(q, declared | {k: u[k] for k in held}).tolist()
    why = numbers.singular_angles(q) or numbers.lying_flat(q)
    if why:
        raise EmitError(f"{scene.name}: start: {why}")
    return [float(x) for x in q], [float(x) for x in u]


TOLERANCE = "1e-09"
"""Relative and absolute tolerance of a co-simulation that is not told one."""

FIXED, EVENTS = ("fmu-instance.h", "fmu-steps.h"), "fmu-events.h"
"""Files that are the same for all mechanisms and both versions, the last one where states jump."""

PLACES = {
    "q": "m->q",
    "qd": "m->u",
    "tau": "m->tau",
    "t": "m->n.time",
    "inputs": "m->inputs",
    "internal": "m->n.x + NQ + NU",
    "params": "m->n.p",
    "prepared": "m->prepared",
}
"""Where arguments of functions stand in an instance."""

DIFFERENTIATED = ("forward_dynamics", "outputs", "coordinate_rates")


def needed(scene: Scene, _: str = "") -> tuple[str, ...]:
    """Return the functions that the model of a scene is made of."""
    names = ["state_rates" if scene.states else "forward_dynamics"]
    names += ["coordinate_rates"] if OUTPUTS["coordinate_rates"].exists(scene) else []
    names += ["outputs"] if scene.outputs else []
    names += ["resets"] if resets_of(scene.states) else []
    if scene.is_constrained:
        names += ["constraint_residual", "constraint_jacobian"]
    elif _differentiated(scene):
        names += [f"{name}_derivatives" for name in names]
        by_inputs = [name for name in names if name in DIFFERENTIATED[:2]] if scene.inputs else []
        names += [f"{name}_by_inputs" for name in by_inputs]
    return (*names, *(["prescribed_motion"] if bool(scene.prescribed_velocities) else []))


def _write(draft: Draft) -> dict[str, bytes]:
    """Return the archives of both versions."""
    program, scene = draft.program, draft.program.scene
    if not scene.velocities:
        raise EmitError(f"{scene.name}: nothing moves: no joint has a coordinate")
    there = variables(program, *starting_state(scene))
    code = C.write(C.draft(program, draft.real, draft.page.command))
    values = _values(draft, there)
    facts = described(draft, there, _differentiated(scene), TOLERANCE)
    return {
        f"{draft.stem}_{version}.fmu": packed(_members(version, draft.stem, code, values, facts))
        for version in ("fmi2", "fmi3")
    }


def _differentiated(scene: Scene) -> bool:
    """Whether a model tells directional derivatives: of trees without states of their own, and no input places them."""
    return not (scene.is_constrained or scene.states or placing(scene))


def _members(
    version: str, stem: str, code: Mapping[str, Contents], values: dict[str, Any], facts: dict[str, Any]
) -> dict[str, Contents]:
    """Return the files of one version by name; names of ours have a hyphen, which no scene's files have.

    The token that ties code and description together is made of all of them.
    """
    facts = facts | {"compiled": [f"{version}-functions.c", f"{stem}.c"]}
    fixed = (f"{version}-types.h", *FIXED, *([EVENTS] if facts["events"] else []))

    def made(token: str) -> dict[str, Contents]:
        sources = {
            f"{version}-functions.c": render(f"fmu/{version}-functions.c.jinja", values),
            **{name: f"{verbatim(f'fmu/{name}')}\n" for name in fixed},
            "fmu-mechanism.h": render("fmu/fmu-mechanism.h.jinja", values | {"token": token}),
            **code,
        }
        build = {"buildDescription.xml": render("fmu/build.xml.jinja", facts)} if version == "fmi3" else {}
        model = {"modelDescription.xml": render(f"fmu/{version}.xml.jinja", facts | {"token": token})}
        return model | {f"sources/{name}": text for name, text in {**build, **sources}.items()}

    whole = "\0".join(str(text) for text in made("").values())
    return made(hashlib.sha256(whole.encode()).hexdigest()[:32])


def _values(draft: Draft, there: tuple[Variable, ...]) -> dict[str, Any]:
    """Return what the templates of the C files are given."""
    program, scene = draft.program, draft.program.scene
    shapes = {one.function.request or one.function.name: one.function.shape for one in program.routines}
    states = [one for one in there if one.state]
    inputs = [one for one in there if one.causality == "input"]
    free = [one for one in there if one.causality == "parameter"]
    given = [one.name for one in inputs]
    names, velocities = list(scene.coordinates), scene.velocities
    pinned = scene.prescribed_velocities
    rows = shapes["constraint_residual"][0] if scene.is_constrained else 0
    along = PLACES | {"qd": "along"}
    return {
        "about": draft.about,
        "stem": draft.stem,
        "tolerance": TOLERANCE,
        "nq": len(names),
        "nu": len(velocities),
        "ns": len(scene.states),
        "nd": len(inputs) - len(scene.inputs),
        "ni": len(scene.inputs),
        "ny": len(scene.outputs),
        "np": len(free),
        "nr": rows,
        "nprepared": shapes["prepare"][0] if program.is_prepared else 0,
        "names": ", ".join(f'"{one.name}"' for one in there),
        "start_states": _numbers([there[one.state].start for one in states]),
        "start_inputs": _numbers([*(one.start for one in inputs), 0.0]),
        "start_parameters": _numbers([*(one.start for one in free), 0.0]),
        "driven": ", ".join(str(given.index(name)) if name else "-1" for name in driven(scene)),
        "quaternions": ", ".join(str(names.index(group[0])) for group in quaternions(scene)),
        "pinned": {
            "coordinates": ", ".join(str(names.index(velocities[k].removesuffix("_dot"))) for k in pinned),
            "velocities": ", ".join(map(str, pinned)),
        }
        if pinned
        else {},
        "pinned_by_inputs": bool(placing(scene)),
        "ways": [DIRECTIONS[way] for _, way in resets_of(scene.states)],
        "differentiated": _differentiated(scene),
        "calls": {name: _call(draft, name, PLACES) for name in shapes},
        "calls_along": {name: _call(draft, name, along) for name in shapes if name == "coordinate_rates"},
    }


def _call(draft: Draft, request: str, places: dict[str, str]) -> str:
    """Return a call of a function up to where its result goes."""
    (k,) = (k for k, r in enumerate(draft.program.routines) if request in (r.function.request, r.function.name))
    function = draft.page.functions[k]
    return f"{draft.stem}_{function.name}({''.join(f'{places[a.name]}, ' for a in function.arguments)}"


def _numbers(values: list[float | None]) -> str:
    return ", ".join(repr(float(value or 0.0)) for value in values)


DIRECTIONS = {"both": 0, "up": 1, "down": -1}
"""The sign behind zero that makes a reset an event, by its word."""

LACKS = {
    Op.SIGN: "its events are resets, and nothing sticks; smooth it, as friction does with smoothing, or tanh(v/0.01)"
}


def _printer(real: Real) -> Printer:
    printer = C.printer(real)
    return Printer({op: one for op, one in printer.spellings.items() if op not in LACKS}, printer.literal)


FMU = Target(
    name="fmu",
    title="FMU",
    text="models of FMI 2.0 and 3.0, for exchange and co-simulation",
    files={"{stem}_fmi2.fmu": bytes, "{stem}_fmi3.fmu": bytes},
    keywords=frozenset(),  # every function begins with the name of the scene
    lacks=LACKS,
    functions=needed,
    tunes=True,
    printer=_printer,
    comment=C.comment,
    write=_write,
    rows=True,
)
