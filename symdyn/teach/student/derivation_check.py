r"""A student's derivation against the scene's: right, or in which term it differs.

Equality is decided by value over finite fields (`symdyn.verify.equality`); the words come from comparing term by term
(`symdyn.teach.student.differences`). Coefficients carry their own sign; `book` takes the minus of k_C and k_D out, as
(5.40).

A student's Lagrangian may have multipliers: L + Σ λ_k f_k, where every f_k vanishes wherever the loops are closed. The
conditions may be written in other ways than the scene's, so they are looked at in numbers, as rows are: each vanishes
on the motions that are allowed, and together they forbid as much as the scene's rows.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

from symdyn.algebra import Form, Function, Number, Symbol
from symdyn.bounds import BOUNDS
from symdyn.dynamics.mechanism import State
from symdyn.emit.print import Printable
from symdyn.errors import DerivationError, TeachError
from symdyn.graph import Graph, Op, gradient, tangents
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.teach.lesson import apart
from symdyn.teach.notation import in_order, ordered_ways
from symdyn.teach.student.answer import (
    EMPTY,
    EQUAL,
    MOTIONS,
    ROUNDED,
    Answer,
    equality,
    judged,
    less,
    settled,
    short,
    untitled,
    without_slope,
)
from symdyn.teach.student.diagnosis import Diagnosis
from symdyn.teach.student.grammar import Names, Target
from symdyn.teach.student.mistakes import FREE, Mistake
from symdyn.teach.student.motions import Decimals
from symdyn.teach.student.rows import LEVELS, holds, in_ground, independent, level_of
from symdyn.teach.student.statements import Statement, find_target, read_statements
from symdyn.verdict import Verdict

ENERGIES = ("K", "P", "L")
ADDED_TO = ("P", "L")
"""Where Lagrange's multipliers may stand: L + λ f, which is K - (P - λ f)."""


def energy_judged(line: int, kind: str, form: Form, right: Form, page: Printable) -> Answer:
    """Return the answer to an energy of the whole mechanism: K, P or L, with multipliers or without."""
    scene = page.scene
    given = set(form.symbols)
    used = [row.multiplier for row in page.constraints.rows if row.multiplier in given]
    if used and kind in ADDED_TO and len(used) == len(page.constraints.rows) and _added(form, used, scene):
        alone = judged(line, kind, form.substitute(dict.fromkeys(used, Number.ZERO)), right, scene, kind)
        return replace(alone, multiplied=tuple(used)) if alone.right else alone
    answer = judged(line, kind, form, right, scene, kind)
    wrong = used and answer.verdict == Verdict.DIFFERENT
    return replace(answer, mistake=Mistake("multiplier", Graph().zero)) if wrong else answer


def _added(form: Form, used: Sequence[str], scene: Scene) -> bool:
    """Whether a formula is λ_k f_k, added up, beside what holds no λ; every f_k a condition, no two the same one."""
    graph = Graph()
    conditions = [Form.of(x) for x in gradient(form.express(graph), [graph.symbol(name) for name in used])]
    if any(set(used) & set(f.symbols) or level_of(f, scene) != LEVELS[0] for f in conditions):
        return False
    return all(holds(f, scene) or _constant(f, scene) for f in conditions) and independent(conditions, scene)


def _constant(condition: Form, scene: Scene) -> bool:
    """Whether a condition of positions keeps its value where rows tie velocities: x - r φ of a wheel that rolls."""
    if not scene.constraints:
        return False
    graph = Graph()
    state = State.of(scene, graph)
    (rate,) = tangents([condition.express(graph)], state.velocity)
    return holds(Form.of(rate), scene)


def check_derivation(
    text: str, scene: SceneLike, name: str = "text", target: Target | str | None = None, book: bool = False
) -> list[Answer]:
    r"""Return an answer to every statement of a student's text.

    Args:
        text: LaTeX or plain text: `k_{z,12} = ...`, `M_1 = ...`, `... = F - b \dot x`, one or more.
        scene: the mechanism.
        name: of the file, for messages.
        target: what a formula without "=" is, or its name, such as "k_z12".
        book: k_C and k_D as the textbook prints them, with the minus in front taken out.

    Raises:
        TeachError: there is no such quantity, or the text has too many lines, or cannot be read; then the message has
            line, column and a caret.
        DerivationError: the scene has no closed form to compare with.
    """
    scene = scene_of(scene)
    target = find_target(target, scene) if isinstance(target, str) else target
    most = BOUNDS["lines of a student's file"]
    if (lines := sum(1 for line in text.splitlines() if line.strip())) > most:
        raise TeachError(f"{name}: has {lines} lines; {most} are the most that is read: give the formulas alone")
    scene = in_order(apart(scene.as_parameters()))
    page = Printable.of(scene, lengths=None)
    beside = page.constraints.units
    others = (*beside, *page.lengths.explicit)
    names = Names(scene, others)
    read = [_in_coordinates(one, page, scene) for one in read_statements(text, scene, name, target, others)]
    diagnosis = Diagnosis(scene, beside)
    asked = {str(goal) for x in read for goal in x.targets} | {s for x in read for f in x.forms for s in f.symbols}
    goals = {str(goal): goal for goal in names.targets.values() if str(goal) in asked}
    places = names.places
    known = {
        name: Form.of(places[goal.kind]) if goal.kind in places else expected(page, goal, book, diagnosis)
        for name, goal in goals.items()
    }
    free = {name: form for name, form in known.items() if name not in names.symbols.values()}
    turned = in_ground(scene)
    answers = _answers(read, known, free, target, page, names, diagnosis)
    if any(not one.right for one in answers) and any(
        set(turned).intersection(f.symbols) for x in read for f in x.forms
    ):
        along = [one.written(lambda form: form.substitute(turned)) for one in read]
        again = _answers(along, known, free, target, page, names, diagnosis)
        if len(again) == len(answers):
            pairs = zip(answers, again, strict=True)
            return [x if x.right or not y.right else replace(y, read=x.read, stars=x.stars) for x, y in pairs]
    return answers


def _answers(
    read: Sequence[Statement],
    known: Mapping[str, Form],
    free: Mapping[str, Form],
    target: Target | None,
    page: Printable,
    names: Names,
    diagnosis: Diagnosis,
) -> list[Answer]:
    """Return what became of statements that are read."""
    scene = diagnosis.scene
    answers: list[Answer] = []
    known_answers: dict[tuple[tuple[Target, ...], tuple[Form, ...]], list[Answer]] = {}
    for statement in read:
        key_of, begun = (statement.targets, statement.forms), len(answers)
        if key_of in known_answers:  # a line that stands there again
            answers += [replace(one, line=statement.line) for one in known_answers[key_of]]
            continue
        filled = statement.written(lambda form: form.substitute(free))
        for goal in statement.targets:
            right = known[str(goal)]
            if not _says(statement, goal, read, free, scene):
                answers.append(Answer(statement.line, str(goal), EMPTY))
                continue
            forms = filled.forms or (known[str(statement.targets[0])],)
            if goal.kind in ENERGIES:
                compared = [energy_judged(statement.line, goal.kind, form, right, page) for form in forms]
            else:
                compared = [judged(statement.line, str(goal), form, right, scene, goal.kind) for form in forms]
            if goal.kind == "tau":
                pairs = zip(compared, forms, strict=True)
                compared = [without_slope(one, form, right, goal.index[0] - 1, page) for one, form in pairs]
            for one, form, loose in zip(compared, forms, filled.loose or forms, strict=True):
                told = _moving(one, goal, form, loose, filled.decimals, right, diagnosis)
                if goal.kind == "tau" and target is not None and target.kind == "tau" and goal != target:
                    answers.append(_of_other_joint(told, statement, form, goal, target, diagnosis))
                else:
                    answers.append(_diagnosed(told, form, right, goal.course_key, diagnosis))
        if not statement.targets and not _names_only(statement, names, len(read)):
            equation = target.index[0] - 1 if target is not None and target.kind == "tau" else None
            told = _of_motion(untitled(filled, page), filled, equation, diagnosis)
            answers.append(_balanced(told, filled, equation, diagnosis))
        answers[begun:] = _told_as(answers[begun:], statement)
        known_answers[key_of] = answers[begun:]
    return answers


def _moving(
    answer: Answer, goal: Target, form: Form, loose: Form, decimals: Decimals, right: Form, diagnosis: Diagnosis
) -> Answer:
    """Return the answer to a quantity: right where it has its value on every motion."""
    letters = diagnosis.seen(goal.course_key, None if goal.kind == "tau" else right)
    motions = None if answer.right and answer.verdict != ROUNDED else diagnosis.moving(letters, [form])
    if motions is None or (goal.kind in ENERGIES and set(form.symbols) & set(diagnosis.others)):
        return answer
    if goal.kind == "tau":
        i = goal.index[0] - 1
        found = motions.holds(less(Form.of(diagnosis.drive(i)), loose), decimals, [i])
    else:
        found = motions.equal(loose, decimals, right, goal.course_key.startswith(FREE))
    if found:
        return answer if answer.right else Answer(answer.line, answer.name, MOTIONS)
    return replace(answer, verdict=Verdict.DIFFERENT) if answer.right else answer  # no decimals account for it


def _of_motion(answer: Answer, statement: Statement, asked: int | None, diagnosis: Diagnosis) -> Answer:
    """Return the answer to an equation: right where it holds on every motion, as one that is asked for if one is."""
    if (answer.right and asked is None) or diagnosis.motions is None or len(statement.forms) != 2:
        return answer
    equations = range(len(diagnosis.scene.drives)) if asked is None else [asked]
    each = ((diagnosis.moving(diagnosis.seen(f"tau:{i + 1}"), statement.forms), i) for i in equations)
    found = any(one and one.holds(less(*statement.loose), statement.decimals, [i]) for one, i in each)
    if found:
        name = answer.name if asked is None else f"equation {asked + 1}"
        return answer if answer.right else Answer(answer.line, name, MOTIONS)
    if answer.right:
        scene = diagnosis.scene
        if len(scene.drives) == 1:
            return replace(answer, verdict=Verdict.DIFFERENT)
        return _of_another(answer, "row" if scene.is_constrained and holds(less(*statement.forms), scene) else "other")
    return answer


def _of_another(answer: Answer, rule: str = "other") -> Answer:
    """Return that a statement holds, and is not the equation that is asked for."""
    return Answer(answer.line, answer.name, Verdict.DIFFERENT, mistake=Mistake(rule, Graph().zero))


def _of_other_joint(
    answer: Answer, statement: Statement, form: Form, goal: Target, target: Target, diagnosis: Diagnosis
) -> Answer:
    """Return the answer to a joint's drive = form where the equation of another joint is asked for."""
    sides = replace(statement, forms=(form, Form.of(diagnosis.drive(goal.index[0] - 1))))
    return _balanced(_of_another(answer) if answer.right else answer, sides, target.index[0] - 1, diagnosis)


def _told_as(answers: Sequence[Answer], statement: Statement) -> list[Answer]:
    """Return answers to a statement with how it was read."""
    read = " = ".join([*map(str, statement.targets), *map(short, statement.forms)])
    return [replace(one, read=read, stars=statement.stars) for one in answers]


def _in_coordinates(statement: Statement, page: Printable, scene: Scene) -> Statement:
    """Return a statement with lengths of struts, which may go by the names that equations have, written out.

    Where ends keep their order, the root and the amount of their distance are the distance.
    """
    ordered = ordered_ways(scene)

    def written(form: Form) -> Form:
        form = page.lengths.written_out(form)
        roots = {x: x.args[0] for x in form.walk() if isinstance(x, Function) and x.op in (Op.SQRT, Op.ABS)}
        squares = {x: of if x.op is Op.SQRT else of.power(2) for x, of in roots.items()}
        known: dict[Form, Form] = {
            x: way for x, of in squares.items() for way in ordered if _equal(of, way.power(2), scene)
        }
        return form.exchanged(known) if known else form

    return statement.written(written) if ordered else statement.written(page.lengths.written_out)


def _equal(a: Form, b: Form, scene: Scene) -> bool:
    with suppress(ZeroDivisionError):  # where what stands below a line is put to zero
        return equality("length", a, b, scene).verdict in EQUAL
    return False


def _names_only(statement: Statement, names: Names, count: int) -> bool:
    """Whether an equation, one of several statements, only says in names what the others carry out."""
    results = {str(target) for target in names.targets.values()} - set(names.symbols.values())
    named = {name for form in statement.forms for name in form.symbols}
    return count > 1 and bool(named) and named <= results


def _diagnosed(answer: Answer, form: Form, right: Form, key: str, diagnosis: Diagnosis) -> Answer:
    """Return the answer with the rule that was forgotten, if a wrong one is a mistake that is known."""
    if answer.verdict != Verdict.DIFFERENT or answer.mistake or not key or diagnosis.course is None:
        return answer
    scene, motions = diagnosis.scene, diagnosis.motions
    others = (j for j in range(len(scene.drives)) if key.startswith("tau:") and j != int(key[4:]) - 1)
    if motions and any(motions.holds(less(Form.of(diagnosis.drive(j)), form), {}, [j]) for j in others):
        return _of_another(answer)  # what drives another joint, if anything
    found_mistake = diagnosis.value(key, form, right, partial(_equal, scene=scene))
    moved = less(form, Form.of(diagnosis.drive(int(key[4:]) - 1))) if key.startswith("tau:") else form
    told = found_mistake if answer.turned else diagnosis.told_apart(key, moved, found_mistake)
    if key.startswith("tau:") and not (told or answer.turned):
        told = diagnosis.mixed(int(key[4:]) - 1, moved)
    if not (told or answer.turned or key.startswith("tau:")):  # zero, or right without what the result does not have
        foreign = {p.name for p in scene.parameters} & set(form.symbols) - set(right.symbols)
        rest = form.substitute(dict.fromkeys(foreign, Number.ZERO))
        told = Mistake("extra", Graph().zero) if any(_equal(x, right, scene) for x in (Number.ZERO, rest)) else None
    if not told and _equal(form, Number.ZERO, scene) and (moved.symbols or not key.startswith("tau:")):
        told = Mistake("nothing", Graph().zero)
    return replace(answer, mistake=told)


def _balanced(answer: Answer, statement: Statement, asked: int | None, diagnosis: Diagnosis) -> Answer:
    """Return the answer to an equation with the rule that was forgotten."""
    scene = diagnosis.scene
    if answer.verdict != Verdict.DIFFERENT or len(statement.forms) != 2 or answer.mistake:
        return answer
    found = less(*statement.forms)
    named = set(found.symbols)
    rows = [i for i, drive in enumerate(scene.drives) if drive in named]
    rows = rows or [i for i, drive in enumerate(scene.drives) if not drive] or list(range(len(scene.drives)))
    for i in rows if asked is None else [asked]:
        one = None if scene.is_constrained else diagnosis.balance(i, found)
        if one := diagnosis.told_apart(f"tau:{i + 1}", found, one) or diagnosis.mixed(i, found):
            return replace(answer, mistake=one)
    return answer


def _says(
    statement: Statement, goal: Target, read: Sequence[Statement], quantities: Collection[str], scene: Scene
) -> bool:
    """Tell whether a statement says what a quantity is: K = K, L = T - V and tau1 = M_1 only say how it is called.

    Coefficients may go by their names in a formula of the scene's symbols; else what is named is written out as well.
    """
    own = {str(goal)} & set(quantities)  # a length may be called L
    own |= {scene.drives[goal.index[0] - 1] or ""} if goal.kind == "tau" else set()
    written = {
        str(one)
        for x in read
        for one in x.targets
        if x.forms and not any(s in quantities or s in scene.drives for form in x.forms for s in form.symbols)
    }
    if not statement.forms:
        return bool(written & {str(one) for one in statement.targets})
    twin = f"k_z{goal.index[1]}{goal.index[0]}" if goal.kind == "k_z" else ""
    for form in statement.forms:
        named = set(form.symbols)
        called = {name for name in named if name in quantities}
        if called < named:  # with symbols of the scene: coefficients may go by their names
            called = {name for name in called if not name.startswith("k_") or name == twin}
        if named & own or not called <= written:
            return False
    return True


def expected(page: Printable, target: Target, book: bool = False, diagnosis: Diagnosis | None = None) -> Form:
    """Return what a quantity should be; τ_i is what drives joint i, with friction and loads on its side.

    Raises:
        DerivationError: it stands on a way to the equations that this scene does not take.
    """
    if target.key:
        course = (diagnosis or Diagnosis(page.scene)).course
        node = course.value(target.key, course.right) if course is not None else None
        if node is None:
            raise DerivationError(f"{page.scene.name}: {target} is no step of the derivation of its equations")
        return settled(Form.of(node), page.scene)
    energies = {"K": page.K, "P": page.P, "L": less(page.K, page.P)}
    if target.kind in energies:
        return energies[target.kind]
    i = target.index[0] - 1
    if target.kind == "tau":
        drive = page.scene.drives[i]
        loads = Form.sum(term for term in page.driving(i).terms if not (drive and term == Symbol(drive)))
        return less(page.left(i), loads)
    own = ((c.form, c.of) for c in page.rows[i] if (c.kind, c.indices) == (target.kind, target.index))
    form, of = next(own, (Number.ZERO, ""))
    return form.negative if book and of == "qd" else form
