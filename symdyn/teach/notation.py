"""Steps: the scene in words, its coordinates and every symbol."""

from __future__ import annotations

import re

from symdyn.algebra import Form, Symbol
from symdyn.emit.print import value_text
from symdyn.graph import Graph
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.forces import FORCES
from symdyn.scene.values import Joint
from symdyn.teach.document import Picture, Step, Words
from symdyn.teach.lesson import Prose, together


def scene_step(lesson: Prose, shown: Picture) -> Step:
    """Return the picture and the joints."""
    scene = lesson.scene
    rows = []
    for joint in (*scene.joints, *scene.loops):
        parent = lesson.text("ground") if joint.parent == Scene.GROUND else joint.parent
        places: list[Form] = [Symbol(q) for q in joint.coordinates]
        if joint.coupling:
            places = [Form.of(joint.position(Graph()))]
        rows.append((joint.name, lesson.joint_kind(joint), parent, joint.child, together(places)))
    key = "scene.closed" if scene.is_closed else "scene"
    claim = lesson.say(key, scene=scene.name, bodies=str(len(scene.bodies)), freedoms=str(len(scene.velocities)))
    joints = lesson.table(("joint", "kind", "parent", "child", "coordinate"), rows)
    return Step("scene", claim, (shown, joints), lesson.say(f"{key}.reason"))


def acting_steps(lesson: Prose) -> list[Step]:
    """Return the step that lists motions that are prescribed and what acts beside drives and weights; none without."""
    scene = lesson.scene
    rows: list[tuple[str | Words, str | Words]] = []
    for joint in scene.joints:
        where = lesson.text("acting.joint", joint=joint.name)
        if joint.motion is not None:
            motion = Form.of(joint.motion.express(Graph()))
            formula: tuple[str | Form, ...] = (f"{where}: ", Symbol(joint.coordinates[0]), " = ", motion)
            rows.append((lesson.say("acting.motion"), Words(formula)))
        if joint.coupling is not None:
            position = Form.of(joint.position(Graph()))
            said = lesson.say("acting.follows", joint=joint.name, leader=leader(scene, joint), position=position)
            rows.append((lesson.say("acting.coupling"), said))
        if joint.damping != Quantity.ZERO:
            rows.append((lesson.say("acting.damping"), where))
        if joint.dry is not None:
            rows.append((lesson.kind(joint.dry.kind, FORCES[joint.dry.kind].words), where))
        if any(x != Quantity.ZERO for x in joint.forces):
            rows.append((lesson.say("acting.force"), where))
    for one in (*scene.struts, *scene.loads):
        ends = " – ".join(lesson.text("ground") if end.body == Scene.GROUND else end.body for end in one.ends)
        where = ends or lesson.text("acting.joint", joint=getattr(one, "joint", ""))
        rows.append((lesson.kind(one.kind, FORCES[one.kind].words), f"{one.name}: {where}"))
    if not rows:
        return []
    reason = lesson.say("acting.reason") if any(joint.motion is not None for joint in scene.joints) else Words(())
    return [Step("acting", lesson.say("acting"), (lesson.table(("kind", "where"), rows),), reason)]


def leader(scene: Scene, joint: Joint) -> str:
    """Return the name of the joint whose coordinate a joint follows at the end of its chain; "" for none."""
    followed = joint.coupling.coordinate if joint.coupling else None
    return next((one.name for one in scene.joints if followed in one.coordinates), "")


def notation_step(lesson: Prose) -> Step:
    """Return the table of symbols."""
    scene = lesson.scene
    rows: list[tuple[Symbol, str | Words, str, str]] = []
    for (joint, q, unit), rate in zip(SceneUnits(scene).each_coordinate(), scene.velocities, strict=True):
        kind = lesson.say("notation.angle" if unit == "rad" else "notation.way", joint=joint.name)
        rows.append((Symbol(q), kind, unit, ""))
        rows.append((Symbol(rate), lesson.say("notation.rate", q=Symbol(q)), f"{unit}/s", ""))
    for joint, drive, unit in SceneUnits(scene).each_drive():
        key = "notation.force" if unit == "N" else "notation.torque"
        rows.append((Symbol(drive), lesson.say(key, joint=joint.name), unit, ""))
    rows += parameter_rows(lesson)
    table = lesson.table(("symbol", "meaning", "unit", "value"), rows)
    return Step("notation", lesson.say("notation"), (table,), level="full")


def parameter_rows(lesson: Prose) -> list[tuple[Symbol, str | Words, str, str]]:
    """Return the rows of the table of symbols about parameters, values with the language's decimal mark."""
    rows: list[tuple[Symbol, str | Words, str, str]] = []
    told = SceneUnits(lesson.scene).inferred
    for parameter in lesson.scene.parameters:
        value = value_text(parameter.value) if parameter.value is not None else ""
        text = parameter.text or lesson.text("notation.parameter")
        shown = re.sub(r"(?<=\d)\.(?=\d)", lesson.tongue.decimal, value).replace("-", "−")
        rows.append((Symbol(parameter.name), text, told[parameter.name].replace("^2", "²"), shown))
    return rows
