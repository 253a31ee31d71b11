"""What `symdyn info` knows about a scene, as plain values: the tree, the degrees of freedom, the parameters, the costs.

Chosen link frames as text: `Rx(-90 deg) Tx(a3) Rz(q3) Tz(d3)`, beside the joint as declared.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from fractions import Fraction
from typing import Any, TypedDict

from symdyn.dynamics import Equations, LoopChoices, Requested, Workspace, derive_one
from symdyn.dynamics.outputs import Counts
from symdyn.errors import DerivationError, SymdynError
from symdyn.graph import Expr, Graph, growing
from symdyn.program import choose, count_derived, formulate, lower, prepare, skipped
from symdyn.rounding import digits_or
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Joint, Place, PlaneContact, Pose, spell
from symdyn.spatial import Transform

DIGITS = 6


class FrameText(TypedDict):
    """What is said about one frame.

    Attributes:
        joint, body: names.
        declared: type, axis and origin of the joint, as in the scene.
        parent: the joint that carries the frame before, or "ground".
        link: the placement in that frame.
        moved: where the frame is in the declared frame of the joint; "" where it is that frame.
    """

    joint: str
    body: str
    declared: str
    parent: str
    link: str
    moved: str


def frame_texts(scene: Scene) -> list[FrameText]:
    """Return text about every chosen frame, the ground's side first.

    Angles are in degrees where that is exact. Numbers that come of an angle without an exact sine have six digits.
    """
    from symdyn.dynamics import chosen_frames  # most facts need no closed forms and no printing

    return [
        FrameText(
            joint=frame.joint.name,
            body=frame.joint.child,
            declared=_declared(frame.joint),
            parent=frame.parent,
            link=" ".join(map(step_text, frame.steps)) or "1",
            moved=moved_text(frame.moved),
        )
        for frame in chosen_frames(scene)
    ]


def _declared(joint: Joint) -> str:
    origin = _pose(joint.origin)
    kind = JOINTS[joint.type]
    axis = kind.axis(joint)
    way = "about" if axis and not kind.slides(joint) else "along"
    shown = ", ".join(map(spell, axis or joint.axis))
    return f"{joint.type} {way} ({shown}) at {joint.parent}{f' {origin}' if origin else ''}"


def _pose(pose: Pose) -> str:
    graph = Graph()
    return " ".join(step_text((kind, (amount.express(graph),))) for kind, amount in pose.steps)


def step_text(step: tuple[str, Sequence[Expr]]) -> str:
    """Return one elementary motion, such as "Rx(90 deg)"."""
    kind, amounts = step
    show = angle_text if kind in ("Rx", "Ry", "Rz") else length_text
    return f"{kind}({', '.join(map(show, amounts))})"


def length_text(length: Expr) -> str:
    """Return a formula."""
    from symdyn.dynamics import formulas
    from symdyn.emit.print import text_of

    return text_of(formulas([length], digits_or(DIGITS))[0])


def angle_text(angle: Expr) -> str:
    """Return an angle: multiples of π in degrees, the rest as formula in rad."""
    form, graph = angle.linear_form(), angle.graph
    rest = graph.total(graph.constant(factor) * atom for atom, factor in form.terms) + form.constant
    text = "" if rest.is_zero else length_text(rest)
    if not form.turns:
        return text or "0"
    degrees = f"{spell(abs(form.turns) * 180)} deg"
    if not text:
        return f"-{degrees}" if form.turns < 0 else degrees
    return f"{text} {'-' if form.turns < 0 else '+'} {degrees}"


def moved_text(T: Transform) -> str:
    """Return where a frame is, in what differs from the identity: "origin (0, 0, d), x along (0, 1, 0)"."""
    said = [] if all(x.is_zero for x in T.p) else [f"origin {_vector(T.p)}"]
    for name, axis, unit in zip("xz", list(zip(*T.R, strict=True))[::2], ((1, 0, 0), (0, 0, 1)), strict=True):
        if tuple(x.value for x in axis) != tuple(map(Fraction, unit)):
            said.append(f"{name} along {_vector(axis)}")
    return ", ".join(said)


def _vector(x: Sequence[Expr]) -> str:
    return f"({', '.join(map(length_text, x))})"


MEASURED = 50
"""Velocities up to which it is measured what every step saves: that takes all functions ten times over."""


@growing()
def gather(scene: Scene, formulation: str | None, closing: LoopChoices) -> tuple[dict[str, Any], list[str]]:
    """Return the facts for JSON, and why some functions are missing."""
    workspace = Workspace(scene, closing)
    wanted = Requested.of(workspace)
    outputs, left_out = wanted.available()
    if workspace.state.n > wanted.LARGEST:  # deriving is most of the work, and the order of nodes counts for nothing
        equations = Equations(scene, workspace.graph, choose(workspace, outputs, formulation), closing)
    else:
        equations = formulate(scene, outputs, formulation, closing)
    counted, more = _counted(equations, outputs)
    left_out += [*more, *_no_reactions(scene)]
    freedoms = _mobility(scene, closing)
    told, written = SceneUnits(scene).inferred, _written(scene)
    facts = {
        "name": scene.name,
        "degrees_of_freedom": freedoms["by_rank"] if freedoms else len(scene.velocities),
        "mobility": freedoms,
        "chosen": closing.words,
        "gravity": [spell(component) for component in scene.gravity],
        "gravity_unit": scene.shown_unit("m/s^2"),
        "joints": [
            {
                "name": joint.name,
                "type": joint.type,
                "parent": joint.parent,
                "child": joint.child,
                "coordinate": joint.coordinate,
                "unit": "".join(scene.shown_unit(x) for x in JOINTS[joint.type].coordinates(joint))
                if joint.moves
                else "",
                "drive": joint.drive,
                "coordinates": _with_units(scene, joint.coordinates, JOINTS[joint.type].coordinates(joint)),
                "velocities": _with_units(scene, joint.rates, JOINTS[joint.type].velocities(joint), per="s"),
                "drives": list(joint.drives),
                **_beside(joint),
            }
            for joint in scene.joints
        ],
        "acting": acting(scene),
        "loops": [{"name": j.name, "type": j.type, "parent": j.parent, "child": j.child} for j in scene.loops],
        "constraints": [
            {"name": c.name, "type": c.kind, "law": FORCES[c.kind].law_words(c)} for c in scene.constraints
        ],
        "leaves": list(scene.leaves),
        "points": [{"name": point.name, "body": point.body} for point in scene.points],
        **_arms(scene),
        "on_request": wanted.on_request,
        "parameters": [
            {
                "name": p.name,
                "value": spell(p.value) if p.value else None,
                "unit": told[p.name],
                "text": p.text,
                **written.get(p.name, {}),
            }
            for p in scene.parameters
        ],
        **_put_in(scene),
        **({"values_with_units": list(said)} if (said := SceneUnits(scene).mistakable) else {}),
        **({"doubtful_units": list(said)} if (said := SceneUnits(scene).doubtful) else {}),
        **_signals(workspace),
        **counted,
    }
    return facts, left_out


def _arms(scene: Scene) -> dict[str, list[dict[str, Any]]]:
    """Return what is parallel or meets in arms of three joints at least, of points, else of leaves; nothing if none."""
    if not 3 <= len(scene.velocities) <= MEASURED or scene.is_constrained:
        return {}
    from symdyn.simulation import arm_of  # which takes NumPy

    arms = []
    for name in [one.name for one in scene.points] or scene.leaves:
        with suppress(SymdynError):  # no parameter may be free
            arms.append(arm_of(scene, name))
    told = [{"point": arm.point, "axes": list(arm.words)} for arm in arms if len(arm.names) > 2]
    return {"arms": told} if told else {}


def _put_in(scene: Scene) -> dict[str, list[dict[str, str]]]:
    """Return derived parameters and signals, whose formulas stand in place of their names, nothing where none is."""
    units = SceneUnits(scene)

    def row(name: str, formula: Quantity, unit: str, text: str) -> dict[str, str]:
        return {"name": name, "formula": spell(formula), "unit": unit or units.of_formula(formula, {}), "text": text}

    derived = [row(p.name, p.value, p.unit, p.text) for p in scene.derived if p.value is not None]
    signals = [row(p.name, p.formula, p.unit, p.text) for p in scene.signals]
    return {kind: rows for kind, rows in (("derived", derived), ("signals", signals)) if rows}


def _relative_degree(w: Workspace, name: str) -> int | None:
    """Return which rate of an output its drives are in first, None where there is none, or too much to derive."""
    if w.state.n > Requested.LARGEST:
        return None
    try:
        return int(derive_one(w, f"decoupling_row:{name}").text.rpartition(" ")[2])
    except DerivationError:
        return None


def _signals(w: Workspace) -> dict[str, list[dict[str, Any]]]:
    """Return the inputs, states and outputs that a scene names, nothing where it names none."""
    scene = w.declared
    told, written = SceneUnits(scene).inferred, _written(scene)
    inputs = [
        {"name": p.name, "value": spell(p.value), "unit": told[p.name], "text": p.text, **written.get(p.name, {})}
        for p in scene.inputs
    ]
    looked = SceneUnits(scene).outputs
    outputs: list[dict[str, Any]] = [
        {"name": p.name, "formula": spell(p.formula), "unit": looked[p.name], "text": p.text,
         "relative_degree": _relative_degree(w, p.name)}
        for p in scene.outputs
    ]  # fmt: skip
    states = [
        {"name": p.name, "rate": spell(p.rate), "start": spell(p.value), "unit": told[p.name], "text": p.text}
        for p in scene.states
    ]
    found: dict[str, list[Any]] = {"inputs": inputs, "states": states, "outputs": outputs}
    return {name: some for name, some in found.items() if some}


def _written(scene: Scene) -> dict[str, dict[str, str]]:
    """Return by name the values that were written in another unit than that of SI, as they were."""
    return {name: {"written": said} for name, said in SceneUnits(scene).written.items()}


def _counted(equations: Equations, outputs: Sequence[str]) -> tuple[dict[str, Any], list[str]]:
    """Return what the functions cost, what can be prepared, and what was left out; and what many velocities forbid."""
    n, said, first, program = len(equations.scene.velocities), [], None, None
    if n > Requested.LARGEST:
        said.append(
            "operations are counted as derived, before passes over the code, for more than "
            f"{Requested.LARGEST} velocities"
        )
        bindings = count_derived(equations)
    else:
        program = lower(equations)
        bindings = [dict(routine.binding) for routine in program.routines]
        prepared = prepare(program)
        first = prepared.routines[0] if prepared.is_prepared else None
    if n > MEASURED:
        said.append(f"what was left out is not measured for more than {MEASURED} velocities")
    functions = [
        {
            "name": function.name,
            "shape": function.shape,
            "formulation": function.formulation,
            "operations": asdict(sum(binding.values(), Counts()) - binding["params"]),
            "prepare": asdict(binding["params"]),
            "binding": {time: asdict(part) for time, part in binding.items()},
        }
        for function, binding in zip(equations.functions, bindings, strict=True)
    ]
    report = [
        {
            "step": one.step,
            "why": one.why,
            "saved": None if one.saved is None else {name: asdict(part) for name, part in one.saved.items()},
        }
        for one in (skipped(equations, outputs) if n <= MEASURED else ())
    ]
    prepare_first = first and {"values": len(first.function.entries), "operations": asdict(first.counts)}
    return {"functions": functions, "prepare": prepare_first, "skipped": report}, said


def _no_reactions(scene: Scene) -> list[str]:
    """Return why a scene with rows has no reactions, in words; nothing where it has them."""
    if not scene.constraints:
        return []
    from symdyn.dynamics.reactions import why_no_reactions

    return list(filter(None, [why_no_reactions(scene)]))


def _mobility(scene: Scene, closing: LoopChoices) -> dict[str, Any] | None:
    """Return the mobility of a scene with loops or rows; None for a tree, and where the loops cannot be closed.

    Beside it are entries of reactions, axes of the children, that are statically indeterminate, in words; "" for none.
    """
    if not scene.is_constrained:
        return None
    from symdyn.dynamics import loose_reactions
    from symdyn.dynamics.loops import mobility

    with suppress(DerivationError):  # why, what is available has told
        found = asdict(mobility(scene, closing)) | {"loose_reactions": ""}
        with suppress(DerivationError):
            found["loose_reactions"] = loose_reactions(scene, closing)
        return found
    return None


def parts(scene: Scene, frames: bool, base_parameters: bool) -> dict[str, Any]:
    """Return the chosen frames, the base parameters, or both."""
    found: dict[str, Any] = {"name": scene.name}
    if frames:
        found["frames"] = frame_texts(scene)
    if base_parameters:
        from symdyn.emit.print import base_parameter_texts

        found["base_parameters"] = base_parameter_texts(scene)
    return found


def _with_units(scene: Scene, names: tuple[str, ...], units: Sequence[str], per: str = "") -> list[dict[str, str]]:
    """Return names of coordinates or velocities with their units; none where a joint follows another one."""
    behind = f"/{per}" if per else ""
    return [
        {"name": name, "unit": scene.shown_unit(f"{unit}{behind}")} for name, unit in zip(names, units, strict=False)
    ]


def _beside(joint: Joint) -> dict[str, Any]:
    """Return what a joint says beside its place and its motion."""
    follows = joint.coupling
    limits = {key: getattr(joint.limits, key) for key in asdict(joint.limits)}
    return {
        "mimic": follows and {"ratios": {q: spell(x) for q, x in follows.ratios}, "offset": spell(follows.offset)},
        "armature": spell(joint.armature),
        "damping": spell(joint.damping),
        "friction": spell(joint.friction),
        "limits": {key: limit and spell(limit) for key, limit in limits.items()},
    }


def acting(scene: Scene) -> list[dict[str, str]]:
    """Return what acts beside gravity, drives and damping: what it is, its name, where it acts, its law."""

    def row(kind: str, name: str, where: str, law: str) -> dict[str, str]:
        return {"kind": kind, "name": name, "where": where, "law": law}

    def together(vector: tuple[Quantity, ...]) -> str:
        return f"({', '.join(map(spell, vector))})"

    def at(joint: str, ends: tuple[Place, ...]) -> str:
        return f"joint {joint}" if joint else " and ".join(f"{end.body} {together(end.at)}" for end in ends)

    rows = []
    for strut in scene.struts:
        rows.append(row(strut.kind, strut.name, at(strut.joint, strut.ends), FORCES[strut.kind].law_words(strut)))
    for joint in scene.joints:
        if joint.dry is not None:
            rows.append(
                row(joint.dry.kind, joint.name, at(joint.name, ()), FORCES[joint.dry.kind].law_words(joint.dry))
            )
        if joint.motion is not None:
            rows.append(row("motion", joint.name, at(joint.name, ()), f"{joint.coordinate} = {spell(joint.motion)}"))
    for one in scene.unilaterals:
        where = at("", one.ends) if isinstance(one, PlaneContact) else ""
        rows.append(row("contact", one.name, where, FORCES[one.kind].law_words(one)))
    for load in scene.loads:
        rows.append(row(load.kind, load.name, at("", (scene.seated(load).place,)), FORCES[load.kind].law_words(load)))
    return rows
