"""The walkthrough of any mechanism by D'Alembert's method, section by section."""

from __future__ import annotations

from dataclasses import replace

from symdyn.algebra import Form
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.values import Contact
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.dalembert.bodies import body_steps
from symdyn.teach.derivations.dalembert.laws import law_errata, law_steps
from symdyn.teach.derivations.dalembert.loops import loop_steps
from symdyn.teach.derivations.dalembert.reactions import formulations_step, numbers_step, solved_steps
from symdyn.teach.derivations.dalembert.shown_motion import choose_motion
from symdyn.teach.derivations.dalembert.side_by_side import side_by_side
from symdyn.teach.derivations.dalembert.system_picture import system_step
from symdyn.teach.derivations.lagrange.numbers import scene_picture, state_step
from symdyn.teach.derivations.lagrange.strut_lengths import defined_lengths
from symdyn.teach.document import Block, Document, Step, Words
from symdyn.teach.notation import acting_steps, leader, notation_step, scene_step
from symdyn.teach.textbook import with_appendix

UNTIL = ("count", "bodies", "reactions", "formulations")
"""The parts that it may end with."""


def dalembert_walkthrough(scene: Scene, language: str = "en", until: str = "formulations") -> Document:
    """Return the walkthrough by D'Alembert's method (5.1)-(5.20), for open and closed mechanisms, up to one of UNTIL.

    Raises:
        EmitError: there are more unknowns than anyone reads.
    """
    lesson = Balance(scene, language)
    chosen = choose_motion(lesson)
    shown = scene_step(lesson, scene_picture(lesson, chosen))
    first = [shown, *acting_steps(lesson), *defined_lengths(lesson, lesson.lengths), notation_step(lesson)]
    method = [step for law in law_steps(lesson) for step in (law, *law_errata(lesson, law.key))]
    sections = [lesson.section("scene", first), lesson.section("method", method)]
    if tied := loop_steps(lesson, chosen):
        sections.append(lesson.section("loops", tied))
    sections.append(lesson.section("count", [_unknown_table(lesson), _count(lesson)]))
    last = UNTIL.index(until)
    if last >= 1:
        steps = [step for j in range(len(lesson.scene.bodies)) for step in body_steps(lesson, j, chosen)]
        sections.append(lesson.section("bodies", steps))
    if last >= 2:
        steps = [system_step(lesson), *solved_steps(lesson), state_step(lesson, chosen), numbers_step(lesson, chosen)]
        sections.append(lesson.section("reactions", steps))
    if last >= 3:
        if (proof := formulations_step(lesson, chosen)) is not None:
            table = side_by_side(lesson)
            section = lesson.section("formulations", [proof, *([table] if table else [])])
            alone = not proof.reference and not table
            sections.append(replace(section, title=lesson.text("section.laws")) if alone else section)
        sections = with_appendix(lesson, sections)
    title = lesson.text("title.dalembert", scene=lesson.scene.name)
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections), "dalembert")


def _unknown_table(lesson: Balance) -> Step:
    rows = []
    passive, contact = lesson.system.passive, _contacts(lesson)
    for symbol, one in zip(lesson.unknowns, lesson.system.unknowns, strict=True):
        words = lesson.system.direction(one)
        kind = f"unknown.{words.split(' ')[0]}" if words[-2:] in (" x", " y", " z") else "unknown.other"
        if one.is_drive:
            kind = "unknown.drive" if one not in passive else "unknown.idle" if lesson.closed else "unknown.passive"
        places = {"joint": one.joint, "axis": words[-1:]}
        if one.is_reaction and (one.joint, one.number) in contact:
            kind, touching = contact[one.joint, one.number]
            places |= touching
        if one.is_coupling:
            joint = next(joint for joint in lesson.scene.joints if joint.name == one.joint)
            kind, places["leader"] = "unknown.coupling", leader(lesson.scene, joint)
        rows.append((symbol, lesson.say(kind, **places)))
    table, reason = lesson.table(("symbol", "meaning"), rows), lesson.say("unknowns.reason")
    return Step("unknowns", lesson.say("unknowns"), (table,), reason, "(5.6), (5.7)")


def _contacts(lesson: Balance) -> dict[tuple[str, int], tuple[str, dict[str, str]]]:
    """Return the words for each force of a contact, with their places; none where not all of them are asked for."""
    found: dict[tuple[str, int], tuple[str, dict[str, str]]] = {}
    unknown = [(one.joint, one.number) for one in lesson.system.unknowns]
    for row in lesson.scene.rows:
        told = FORCES[row.kind].touch.words(row) if isinstance(row, Contact) else ()
        if isinstance(row, Contact) and all(told) and (row.name, len(told) - 1) in unknown:
            bodies = (
                lesson.text("ground") if name == Scene.GROUND else name for name in (row.plane.body, row.place.body)
            )
            places = dict(zip(("parent", "child"), bodies, strict=True)) | {"owner": row.name}
            found |= {(row.name, k): (f"tie.{one}", dict(places)) for k, one in enumerate(told)}
    return found


def _count(lesson: Balance) -> Step:
    """Return (5.18)-(5.20) in numbers."""
    system, joints = lesson.system, (*lesson.scene.joints, *lesson.scene.loops)
    counts = [one.joint for one in system.unknowns if not one.is_drive]
    rows = [(joint.name, lesson.joint_kind(joint), str(counts.count(joint.name))) for joint in joints]
    classes = [counts.count(name) for name in dict.fromkeys(counts)]
    places: dict[str, str | Form] = {
        "equations": str(system.equations),
        "each": str(len(system.kept)),
        "bodies": str(len(system.bodies)),
        "sum": " + ".join(f"{t} · {classes.count(t)}" for t in sorted(set(classes), reverse=True)) or "0",
        "reactions": str(system.reactions),
        "drives": str(system.drives),
        "m": lesson.name("m:R", "m", "R", node=None),
    }
    correct = system.equations == len(system.unknowns)
    blocks: list[Block] = [lesson.table(("joint", "kind", "class"), rows), lesson.say("count.sum", **places)]
    coupled = ", ".join(one.joint for one in system.unknowns if one.is_coupling)
    if coupled:
        blocks.append(lesson.say("count.coupled", joints=coupled))
    if system.passive:
        names = ", ".join(dict.fromkeys(one.joint for one in system.passive))
        key = "count.idle" if lesson.closed else "count.passive"
        blocks.append(lesson.say(key, number=str(len(system.passive)), joints=names))
    blocks.append(lesson.say("count.correct" if correct else "count.over", **places))
    plane = lesson.say("count.plane") if len(system.kept) == 3 else Words(())
    return Step("count", lesson.say("count", **places), tuple(blocks), plane, "(5.18)-(5.20)")
