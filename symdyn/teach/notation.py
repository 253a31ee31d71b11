"""Steps: the scene in words, its coordinates and every symbol.

From where each coordinate is counted, and which way is positive, is computed where all are zero. Textbook mode has
equation numbers of example 5.28, and boxes where the text, as transcribed, is wrong: `READS` quotes the text; what is
right and every check comes from the graph.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Ratios, Symbol
from symdyn.dynamics.mechanism import Taut, body_placements, ends_apart, strut_way
from symdyn.emit.print import value_text
from symdyn.frozen import dataclass, replace
from symdyn.graph import Graph, Op, evaluate, substitute
from symdyn.scene import Quantity, Scene, SceneUnits, parse
from symdyn.scene.forces import FORCES, elastic
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Element, Joint, Strut
from symdyn.spatial import dot
from symdyn.teach.document import ERRATA, Block, Box, Formula, Letter, Picture, Section, Step, Words
from symdyn.teach.lesson import Lesson, Prose, called, named, together
from symdyn.teach.shown_state import Chosen


def scene_step(lesson: Prose, shown: Picture, numbered: bool = True) -> Step:
    """Return the picture, and the source that equations have their numbers from."""
    scene = lesson.scene
    n, led = len(scene.velocities), len(scene.prescribed_velocities)
    told = {"scene": called(scene), "bodies": str(len(scene.bodies)), "freedoms": str(n)}
    key = "scene.closed" if scene.is_constrained else "scene.led" if led else "scene"
    claim = lesson.say(key, **told, led=str(led), left=str(n - led))
    return Step("scene", claim, (shown, lesson.say("source")) if numbered else (shown,))


def joints_step(lesson: Prose) -> Step:
    """Return the joints and what they carry."""
    scene = lesson.scene
    rows = []
    for joint in (*scene.joints, *scene.loops):
        parent = lesson.text("ground") if joint.parent == Scene.GROUND else joint.parent
        places: list[Form] = [Symbol(q) for q in joint.coordinates]
        if joint.coupling:
            places = [Form.of(joint.position(Graph()))]
        rows.append((joint.name, lesson.joint_kind(joint), parent, joint.child, together(places)))
    joints = lesson.table(("joint", "kind", "parent", "child", "coordinate"), rows)
    key = "joints.closed" if scene.is_constrained else "joints.reason"
    reason = Words(()) if scene.is_constrained and not scene.loops else lesson.say(key)
    return Step("joints", lesson.say("joints"), (joints,), reason)


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
            rows += [(lesson.say("acting.willis", joint=joint.name), said) for said in _willis(scene, joint)]
        if joint.damping != Quantity.ZERO:
            rows.append((lesson.say("acting.damping"), where))
        if joint.dry is not None:
            rows.append((lesson.kind(joint.dry.kind, FORCES[joint.dry.kind].words), where))
        if any(x != Quantity.ZERO for x in joint.forces):
            forces = [Form.of(x.express(Graph())) for x in joint.forces if x != Quantity.ZERO]
            rows.append((lesson.say("acting.force"), Words((f"{where}: ", *together(forces).parts))))
    for one in (*scene.struts, *scene.loads):
        ends = " – ".join(
            lesson.text("ground") if end.body == Scene.GROUND else str(lesson.shown("body", end.body))
            for end in one.ends
        )
        where = ends or lesson.text("acting.joint", joint=getattr(one, "joint", ""))
        rows.append((lesson.kind(one.kind, FORCES[one.kind].words), f"{one.text or one.name}: {where}"))
        for at in (at for strut, at in scene.supports if strut == one):
            x, y, z = (Form.of(entry.express(Graph())) for entry in at)
            rows.append(
                (lesson.say("acting.support"), lesson.say("acting.moves", name=one.text or one.name, x=x, y=y, z=z))
            )
    if not rows:
        return []
    reasons = [lesson.say("acting.reason")] if any(joint.motion is not None for joint in scene.joints) else []
    ordered = ordered_ways(scene)
    lengths = Words(tuple(part for form in ordered for part in (", ", form.plus_first, " > 0"))[1:])
    reasons += [lesson.say("acting.order", lengths=lengths)] if ordered else []
    reason = Words(tuple(part for said in reasons for part in (*said.parts, " "))[:-1])
    return [Step("acting", lesson.say("acting"), (lesson.table(("kind", "where"), rows),), reason)]


def ordered_ways(scene: Scene) -> list[Form]:
    """Return the lengths of springs and dampers whose ends keep their order, each once; see `in_order`."""
    placed = body_placements(scene, graph := Graph())
    return list(dict.fromkeys(Form.of(strut_way(scene, placed, one, graph)) for one in scene.struts if one.is_ordered))


def in_order(scene: Scene) -> Scene:
    """Return the scene of lessons: ends of springs and dampers on one line keep the order of the start.

    Their length √u² is the polynomial u that is positive there, with 1 for parameters without a value, as long as the
    ends do not pass each other; generated code keeps the root, which holds on both sides. So do lessons where inputs
    move ends, whose rates are letters.
    """
    if any(one.of for one in scene.parameters):
        return scene
    taut = Taut(scene, Graph())

    def on_a_line(one: Element) -> bool:
        apart = ends_apart(scene, one.ends, taut.graph)
        return taut.root(dot(apart, apart), guessed=True).op not in (Op.SQRT, Op.CONSTANT)

    elements = (
        replace(one, ends=tuple(replace(end, ordered=True) for end in one.ends))
        if isinstance(one, Strut) and one.ends and not one.is_rope and on_a_line(one)
        else one
        for one in scene.elements
    )
    return replace(scene, elements=tuple(elements))


def _willis(scene: Scene, joint: Joint) -> list[Words]:
    """Return the equation of rates relative to a carrier: of a joint that turns as two others do, ratios of sum 1."""
    assert joint.coupling is not None, "the joint follows others"
    leaders = [one for one in scene.joints if {*joint.coupling.coordinates}.intersection(one.coordinates)]
    if (
        len(leaders) != 2
        or len({one.parent for one in (joint, *leaders)}) > 1
        or any(JOINTS[one.type].axis(one) is None or JOINTS[one.type].slides(one) for one in (joint, *leaders))
    ):
        return []
    graph = Graph()
    a, b = (dict(joint.coupling.ratios)[one.coordinate].express(graph) for one in leaders)
    field = Ratios([a, b])
    x, y, rest = evaluate([a, b, a + b - 1], field, field.values())
    if x.is_zero or not rest.is_zero:
        return []
    first, second, carrier = (graph.symbol(f"omega_{one.name}") for one in (*leaders, joint))
    relative = Form.of((first - carrier) / (second - carrier))
    return [Words((relative, " = ", field.form(field.neg(field.div(y, x)))))]


def leader(scene: Scene, joint: Joint) -> str:
    """Return the names of the joints whose coordinates a joint follows at the end of its chain; "" for none."""
    followed = joint.coupling.coordinates if joint.coupling else ()
    return ", ".join(one.name for one in scene.joints if {*followed}.intersection(one.coordinates))


def notation_step(lesson: Prose) -> Step:
    """Return the table of symbols."""
    scene, kinds = lesson.scene, {"rad": "angle", "m": "way"}
    rows: list[tuple[Symbol, str | Words, str, str]] = []
    unit_of = dict(zip(scene.velocities, SceneUnits(scene).velocities, strict=True))
    for joint, q, measure in SceneUnits(scene).each_coordinate():
        kind = lesson.say(f"notation.{kinds.get(measure, 'quaternion')}", joint=joint.name)
        rows.append((Symbol(q), kind, measure, ""))
        for u in joint.velocities if q == joint.coordinates[-1] else ():
            turns = "turning" if unit_of[u] == "rad" else "sliding"
            rows.append((Symbol(u), lesson.say(f"notation.{turns}", joint=joint.name), f"{unit_of[u]}/s", ""))
    for joint, drive, measure in SceneUnits(scene).each_drive():
        key = "notation.force" if measure == "N" else "notation.torque"
        rows.append((Symbol(drive), lesson.say(key, joint=joint.name), measure, ""))
    rows += parameter_rows(lesson)
    table = lesson.table(("symbol", "meaning", "unit", "value"), rows)
    return Step("notation", lesson.say("notation"), (table,))


def parameter_rows(lesson: Prose) -> list[tuple[Symbol, str | Words, str, str]]:
    """Return the rows of the table of symbols about parameters, values with the language's decimal mark."""
    rows: list[tuple[Symbol, str | Words, str, str]] = []
    told = SceneUnits(lesson.scene).inferred
    for parameter in lesson.scene.parameters:
        value = value_text(parameter.value) if parameter.value is not None else ""
        text = parameter.text or lesson.text("notation.parameter")
        shown = re.sub(r"(?<=\d)\.(?=\d)", lesson.tongue.decimal, value).replace("-", "−").replace("pi", "π")
        rows.append((Symbol(parameter.name), text, told[parameter.name].replace("^2", "²"), shown))
    return rows


LAGRANGIAN = (
    "(m1 + m2)*h1**2*q1_dot**2/2 + m2*h2**2*(q1_dot**2 + 2*q1_dot*q2_dot + q2_dot**2)/2"
    " + m2*h1*h2*cos(q2)*(q1_dot**2 + q1_dot*q2_dot) + (m1 + m2)*g*h1*cos(q1) + m2*g*h2*cos(q1 + q2)"
)
"""(5.35), by which the example is known."""

NUMBERS = {
    "motion:1": "5.36",
    "K:1": "5.24", "P:1": "5.25", "K.definition:2": "5.26", "v2.definition:2": "5.27", "x:2": "5.28", "y:2": "5.29",
    "dx:2": "5.30", "dy:2": "5.31", "v2:2": "5.32", "P.definition:2": "5.33", "P:2": "5.34", "L.definition": "5.23",
    "L": "5.35", "momentum:1": "5.37", "rate:1": "5.38", "slope:1": "5.39", "equation:1": "5.40", "momentum:2": "5.41",
    "rate:2": "5.42", "slope:2": "5.43", "equation:2": "5.44", "k_z:1,1": "5.45", "J:1": "5.46", "Mz:1,1": "5.47",
    "Mz:2,2": "5.48", "k_z:2,2": "5.49", "Mz:1,2": "5.50", "k_z:1,2": "5.51", "split:1,2": "5.52", "Mz:2,1": "5.53",
    "k_z:2,1": "5.54", "k_D:1,1": "5.55",
}  # fmt: skip


@dataclass(frozen=True)
class Erratum:
    """One place where the text is wrong."""

    step: str  # key of the step that the box stands behind
    number: str  # of the equation
    left: str  # what the equation gives, key of `Document.names`; "" where only words are wrong
    reads: str  # the right-hand side as printed, with this product's sign; see `LETTERS`
    words: str  # key of the sentence that says what is wrong


READS = (
    Erratum("potential:2", "5.33", "P:2", "-m2*g*y2", "erratum.5.33"),
    Erratum(
        "momentum:1",
        "5.37",
        "dL:/dq1_dot",
        "(m1 + m2)*h1**2*q1_dot + m2*h2**2*q1_dot + m2*h2**2*q2_dot + 2*m2*h1*h2*cos(q2)*q2_dot"
        " + m2*h1*h2*cos(q2)*q2_dot",
        "erratum.5.37",
    ),
    Erratum("equation:1", "5.40", "k_z:1,2", "m2*h2**2 + m1*h1*h2*cos(q2)", "erratum.5.40z"),
    Erratum("equation:1", "5.40", "k_D:1,2", "-m2*h1*h2*cos(q2)", "erratum.5.40D"),
    Erratum(
        "momentum:2",
        "5.41",
        "dL:/dq2_dot",
        "m2*h2**2*q1_ddot + m2*h2**2*q2_dot**2 + m2*h1*h2*cos(q2)*q1_dot",
        "erratum.5.41",
    ),
    Erratum(
        "rate:2",
        "5.42",
        "d/dt dL:/dq2_dot",
        "m2*h2**2*q1_ddot + m2*h2**2*q2_dot**2 + m2*h1*h2*cos(q2)*q1_ddot - m2*h1*h2*sin(q2)*q1_dot*q2_dot",
        "erratum.5.42",
    ),
    Erratum("slope:2", "5.43", "dL:/dq2", "-m2*h1*h2*sin(q2)*q1_dot*q2_dot - m*g*h2*sin(q1 + q2)", "erratum.5.43"),
    Erratum("equation:2", "5.44", "k_C:2,1,2", "-2*m2*h1*h2*sin(q2)", "erratum.5.44C"),
    Erratum("equation:2", "5.44", "k_D:2,1", "-m2*h1*h2*sin(q2)", "erratum.5.44D"),
    Erratum("meaning:k_z:2,2", "5.48, 5.50, 5.53, 5.55", "", "", "erratum.axes"),
)

LETTERS = {"y2": "y:2"}
"""Letters of the text that are names of the lesson."""

READ_AS = {"m": "m2"}
"""A letter that the text does not define, and what it is read as in the check."""


def numbers_for(lesson: Lesson) -> Mapping[str, str]:
    """Return equation numbers by key, none for any other scene than example 5.28."""
    scene = lesson.scene
    wanted = {"m1", "m2", "h1", "h2", "g"}
    if scene.coordinates != ("q1", "q2") or {p.name for p in scene.parameters} != wanted or elastic(scene):
        return {}
    same = lesson.vanishes(lesson.L - parse(LAGRANGIAN).express(lesson.graph))
    return NUMBERS if same and all(joint.drive for joint in scene.moving) else {}


def errata(lesson: Lesson, section: Section, chosen: Chosen) -> Section:
    """Return a section with a step of boxes behind each step where the source is wrong; `with_appendix` moves them."""
    steps: list[Step] = []
    for one in section.steps:
        step = replace(one, blocks=(*one.blocks, _signs(lesson))) if one.key == "equation:1" else one
        boxes = tuple(_box(lesson, wrong, chosen) for wrong in READS if wrong.step == step.key)
        steps += [step, Step(f"{ERRATA}{step.key}", Words(()), boxes)] if boxes else [step]
    return replace(section, steps=tuple(steps))


def _signs(lesson: Lesson) -> Box:
    """Return the box about signs: (5.40) as the book writes it, minus signs outside of k_C1 and k_D12."""
    u, a = (list(map(named, rates)) for rates in (lesson.state.qd, lesson.state.qdd))
    outside: list[Form] = []
    values: list[Block] = []
    for ours, letters, rate in (
        ("k_C:1,1,2", ("C", "1"), u[0].signed_product(u[1])),
        ("k_D:1,2", ("D", "12"), u[1].power(2)),
    ):
        node = lesson.names[ours].node
        assert node is not None, f"{ours} has no value"
        theirs = lesson.called(f"book {ours}", Letter("k", letters, above="(5.40)"), -node)
        outside.append(Form.product((Number.MINUS_ONE, theirs, rate)))
        values.append(Formula(theirs.name, lesson.short(-node)))
    inertia = [Form.product((Symbol(f"k_z:1,{k + 1}"), one)) for k, one in enumerate(a)]
    whole = Form.sum((*inertia, *outside, Symbol("k_G:1")))
    said = lesson.say("textbook.signs"), Formula("", Symbol(str(lesson.scene.drives[0])), "", whole), *values
    return Box("remark", lesson.say("textbook.signs.title"), said)


def with_appendix(prose: Prose, sections: Sequence[Section]) -> list[Section]:
    """Return the sections with what the textbook has wrong in one at their end, and a mark at each step before it."""
    kept, appendix, count = [], list[Step](), 0
    for section in sections:
        steps: list[Step] = []
        for step in section.steps:
            if not step.key.startswith(ERRATA):
                steps.append(step)
                continue
            numbers, boxes = [], []
            for box in step.blocks:
                assert isinstance(box, Box), "an erratum stands in a box"
                numbers.append(str(count := count + 1))
                boxes.append(replace(box, title=Words((f"{count}. ", *box.title.parts))))
            mark = prose.text("erratum.mark", numbers=", ".join(numbers))
            steps[-1] = replace(steps[-1], reference=", ".join(filter(None, (steps[-1].reference, mark))))
            appendix.append(replace(step, blocks=tuple(boxes)))
        kept.append(replace(section, steps=tuple(steps)))
    return [*kept, prose.section("errata", appendix)] if appendix else kept


def _box(lesson: Lesson, one: Erratum, chosen: Chosen) -> Box:
    """Return what the text reads, what is right, and the check: both in numbers at the lesson's state."""
    title = lesson.say("erratum.several" if "," in one.number else "erratum", number=one.number.replace(", ", "), ("))
    blocks: list[Block] = [lesson.say(one.words)]
    if one.left:
        printed = quoted(one.reads)
        node = lesson.names[one.left].node
        assert node is not None, f"{one.left} has no value"
        typed = parse(one.reads).express(lesson.graph)
        meanings = {lesson.graph.symbol(a): lesson.names[b].node for a, b in LETTERS.items()}
        meanings |= {lesson.graph.symbol(a): lesson.graph.symbol(b) for a, b in READ_AS.items()}
        (read,) = substitute([typed], {x: y for x, y in meanings.items() if y is not None})
        assert not lesson.vanishes(read - node), f"({one.number}) is right as quoted; {one.left}"
        wrong, right = chosen.of(read, node)
        rows = [("erratum.reads", printed, wrong), ("erratum.right", lesson.short(node), right)]
        told = [(lesson.say(key), form, lesson.written(value)) for key, form, value in rows]
        blocks.append(lesson.table(("erratum.source", Symbol(one.left), "value"), told))
    return Box("erratum", title, tuple(blocks))


def quoted(text: str) -> Form:
    """Return a formula as a form, term by term as it is written; letters become the lesson's names."""
    return _quoted(ast.parse(text, mode="eval").body)


def _quoted(node: ast.expr) -> Form:
    if isinstance(node, ast.BinOp):
        left = _quoted(node.left)
        if isinstance(node.op, ast.Pow):
            assert isinstance(node.right, ast.Constant), "an exponent is a number"
            return left.power(int(str(node.right.value)))
        right = _quoted(node.right)
        if isinstance(node.op, ast.Mult):
            return Form.product((left, right))
        return Form.sum((left, right if isinstance(node.op, ast.Add) else Form.product((Number.MINUS_ONE, right))))
    if isinstance(node, ast.UnaryOp):
        return Form.product((Number.MINUS_ONE, _quoted(node.operand)))
    if isinstance(node, ast.Call):
        assert isinstance(node.func, ast.Name), "a function has a name"
        return Function(Op[node.func.id.upper()], tuple(map(_quoted, node.args)))
    if isinstance(node, ast.Constant):
        return Number(Fraction(str(node.value)))
    assert isinstance(node, ast.Name), "quotations hold sums, products, powers, sines"
    return Symbol(LETTERS.get(node.id, node.id))
