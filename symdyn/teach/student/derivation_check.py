"""A student's derivation against the scene's: right, or in which term it differs.

Equality is decided by value over finite fields (`symdyn.verify.equality`); the words come from comparing term by term
(`symdyn.teach.student.differences`). Coefficients carry their own sign; `book` takes the minus of k_C and k_D out, as
(5.40).
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, replace

from symdyn.algebra.form import (
    MINUS_ONE,
    ZERO,
    Form,
    Symbol,
    express_form,
    form_of,
    in_place,
    power_of,
    product_of,
    sum_of,
    symbols_of,
    terms_of,
)
from symdyn.dynamics.mechanism.ldl import solve
from symdyn.emit.print.printable import Printable, printable
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, Op, gradient, reachable
from symdyn.scene import Scene, SceneLike, acceleration_name, express, scene_of
from symdyn.scene.values.signals import as_parameters
from symdyn.teach.student.diagnosis import Diagnosis
from symdyn.teach.student.differences import Difference, differences
from symdyn.teach.student.mistakes import Mistake
from symdyn.teach.student.rows import LEVELS, ground_rows, holds, level_of, may_be_row, scene_rows
from symdyn.teach.student.statements import Statement, read_statements
from symdyn.teach.student.vocabulary import Names, Target
from symdyn.verify import DIFFERENT, NUMERICAL, PROVED, Claim, Finding, prove

EQUAL = (PROVED, NUMERICAL)
ROUNDED, HOLDS, EMPTY = "rounded", "holds", "empty"
FEW_SOLVED = 4  # accelerations, while equations solved for one are something that a student writes
MANY = 400  # differences, which no answer lists


@dataclass(frozen=True)
class Answer:
    """What became of one statement.

    Attributes:
        line: where it stands, from 1.
        name: of the quantity, such as "k_z12", or "equation 2", "velocity row 1".
        verdict: PROVED, NUMERICAL, DIFFERENT or UNDEFINED, as of a finding; ROUNDED for equal to the digits written;
            HOLDS for a row that is none of the scene's, but true wherever the loops are closed; EMPTY for what names
            quantities in place of formulas, such as L = K - P.
        error_log10: log10 of the probability that a wrong formula would pass; 0 when not proved.
        differences: term by term; none where it is right or where no term can be told.
        turned: whether all of it has the opposite sign.
        shifted: by how much a potential energy lies elsewhere, which is free; None for not at all.
        scaled: whether an equation is the scene's times a factor.
        valued: parameters in whose place the formula has the scene's numbers.
        forgotten: the coordinate q whose -dK/dq is all that is missing; "" for none.
        mistake: the rule that was forgotten, None for none.
    """

    line: int
    name: str
    verdict: str
    error_log10: float = 0.0
    differences: tuple[Difference, ...] = ()
    turned: bool = False
    shifted: Form | None = None
    scaled: bool = False
    valued: tuple[str, ...] = ()
    forgotten: str = ""
    mistake: Mistake | None = None

    @property
    def right(self) -> bool:
        """Whether the statement is true."""
        return self.verdict in (*EQUAL, ROUNDED, HOLDS)


def check_derivation(
    text: str, scene: SceneLike, name: str = "text", target: Target | None = None, book: bool = False
) -> list[Answer]:
    r"""Return an answer to every statement of a student's text.

    Args:
        text: LaTeX or plain text: `k_{z,12} = ...`, `M_1 = ...`, `... = F - b \dot x`, one or more.
        scene: the mechanism.
        name: of the file, for messages.
        target: what a formula without "=" is.
        book: k_C and k_D as the textbook prints them, with the minus in front taken out.

    Raises:
        TeachError: the text cannot be read; the message has line, column and a caret.
        DerivationError: the scene has no closed form to compare with.
    """
    scene = as_parameters(scene_of(scene))
    page = printable(scene)
    others = tuple(row.multiplier for row in page.constraints.rows)
    names = Names(scene, others)
    read = read_statements(text, scene, name, target, others)
    diagnosis = Diagnosis(scene)
    asked = {str(goal) for x in read for goal in x.targets} | {s for x in read for f in x.forms for s in symbols_of(f)}
    goals = {str(goal): goal for goal in names.targets.values() if str(goal) in asked}
    places = names.places
    known = {
        name: form_of(places[goal.kind]) if goal.kind in places else expected(page, goal, book, diagnosis)
        for name, goal in goals.items()
    }
    free = {name: form for name, form in known.items() if name not in names.symbols.values()}
    answers = []
    for statement in read:
        filled = replace(statement, forms=tuple(in_place(form, free) for form in statement.forms))
        for goal in statement.targets:
            right = known[str(goal)]
            if not _says(statement, goal, read, free, scene):
                answers.append(Answer(statement.line, str(goal), EMPTY))
                continue
            forms = filled.forms or (known[str(statement.targets[0])],)
            compared = [_compared(statement.line, str(goal), form, right, scene, goal.kind) for form in forms]
            if goal.kind == "tau":
                pairs = zip(compared, forms, strict=True)
                compared = [_without_slope(one, form, right, goal.index[0] - 1, page) for one, form in pairs]
            key = goal.course_key
            answers += [_diagnosed(one, form, right, key, diagnosis) for one, form in zip(compared, forms, strict=True)]
        if not statement.targets and not _names_only(statement, names, len(read)):
            answers.append(_balanced(_untitled(filled, page), filled, diagnosis))
    return answers


def _names_only(statement: Statement, names: Names, count: int) -> bool:
    """Whether an equation, one of several statements, only says in names what the others carry out."""
    results = {str(target) for target in names.targets.values()} - set(names.symbols.values())
    named = {name for form in statement.forms for name in symbols_of(form)}
    return count > 1 and bool(named) and named <= results


def _diagnosed(answer: Answer, found: Form, right: Form, key: str, diagnosis: Diagnosis) -> Answer:
    """Return the answer with the rule that was forgotten, if a wrong one is a mistake that is known."""
    if answer.verdict != DIFFERENT or not key:
        return answer
    scene = diagnosis.scene

    def equal(a: Form, b: Form) -> bool:
        return _equal("mistake", a, b, scene).verdict in EQUAL

    found_mistake = diagnosis.value(key, found, right, equal)
    if found_mistake is None:
        return answer
    return replace(answer, mistake=found_mistake)


def _balanced(answer: Answer, statement: Statement, diagnosis: Diagnosis) -> Answer:
    """Return the answer to an equation with the rule that was forgotten."""
    scene = diagnosis.scene
    if answer.verdict != DIFFERENT or len(statement.forms) != 2 or scene.is_closed:
        return answer
    found = _less(*statement.forms)
    named = set(symbols_of(found))
    rows = [i for i, drive in enumerate(scene.drives) if drive in named]
    rows = rows or [i for i, drive in enumerate(scene.drives) if not drive] or list(range(len(scene.drives)))
    for i in rows:
        if one := diagnosis.balance(i, found):
            return replace(answer, mistake=one)
    return answer


def _says(
    statement: Statement, goal: Target, read: Sequence[Statement], quantities: Container[str], scene: Scene
) -> bool:
    """Tell whether a statement says what a quantity is: K = K, L = T - V and tau1 = M_1 only say how it is called.

    Coefficients may go by their names in a formula of the scene's symbols; else what is named is written out as well.
    """
    own = {str(goal), scene.drives[goal.index[0] - 1] if goal.kind == "tau" else None}
    written = {
        str(one)
        for x in read
        for one in x.targets
        if x.forms and not any(s in quantities or s in scene.drives for form in x.forms for s in symbols_of(form))
    }
    if not statement.forms:
        return bool(written & {str(one) for one in statement.targets})
    twin = f"k_z{goal.index[1]}{goal.index[0]}" if goal.kind == "k_z" else ""
    for form in statement.forms:
        named = set(symbols_of(form))
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
            raise DerivationError(f"{page.scene.name}: {target} is no step on the way to its equations")
        return form_of(node)
    energies = {"K": page.K, "P": page.P, "L": _less(page.K, page.P)}
    if target.kind in energies:
        return energies[target.kind]
    i = target.index[0] - 1
    if target.kind == "tau":
        drive = page.scene.drives[i]
        loads = sum_of(term for term in terms_of(page.driving(i)) if not (drive and term == Symbol(drive)))
        return _less(page.left(i), loads)
    own = ((c.form, c.of) for c in page.rows[i] if (c.kind, c.indices) == (target.kind, target.index))
    form, of = next(own, (ZERO, ""))
    return _minus(form) if book and of == "qd" else form


def _minus(form: Form) -> Form:
    return sum_of([product_of((MINUS_ONE, form))])


def _less(a: Form, b: Form) -> Form:
    return sum_of((a, product_of((MINUS_ONE, b))))


def _balance(page: Printable, i: int) -> Form:
    """Return what vanishes by equation i."""
    return _less(page.left(i), page.driving(i))


# One quantity


def _compared(line: int, name: str, found: Form, right: Form, scene: Scene, kind: str) -> Answer:
    finding = _equal(name, found, right, scene)
    if finding.verdict != DIFFERENT:
        return Answer(line, name, finding.verdict, finding.error_log10)
    if kind.startswith(("P", "L")) and (constant := _free(_less(found, right), scene)) is not None:
        return Answer(line, name, PROVED, finding.error_log10, shifted=constant)
    values = _values(found, right, scene)
    if values and _equal(name, found, in_place(right, values), scene).verdict in EQUAL:
        return Answer(line, name, PROVED, valued=tuple(values))
    if _equal(name, found, _minus(right), scene).verdict in EQUAL:
        return Answer(line, name, DIFFERENT, turned=True)
    try:
        listed = differences(found, right, scene)
    except DerivationError:
        listed = []
    if listed and all(d.kind == "rounded" for d in listed):
        return Answer(line, name, ROUNDED, differences=tuple(listed))
    return Answer(line, name, DIFFERENT, differences=tuple(listed[:MANY]))


def _values(found: Form, right: Form, scene: Scene) -> dict[str, Form]:
    """Return the numbers of parameters that only the right formula names."""
    absent = set(symbols_of(right)) - set(symbols_of(found))
    values = {p.name: p.value for p in scene.parameters if p.name in absent and p.value is not None}
    return {name: form_of(express(value, Graph())) for name, value in values.items()}


def _equal(name: str, found: Form, right: Form, scene: Scene) -> Finding:
    """Return whether two forms are the same function."""
    graph = Graph()
    return _same(name, express_form(found, graph), express_form(right, graph), scene)


def _same(name: str, found: Expr, right: Expr, scene: Scene) -> Finding:
    return _proved([Claim(name, "found", "scene", (found,), (right,))], scene)[0]


def _proved(claims: Sequence[Claim], scene: Scene) -> list[Finding]:
    return prove(claims, positive=[p.name for p in scene.parameters if p.positive])[1]


def _free(form: Form, scene: Scene) -> Form | None:
    """Return the value of a form if it depends on parameters only: it is looked at term by term."""
    try:
        left = [d.found or product_of((MINUS_ONE, d.right or ZERO)) for d in differences(form, ZERO, scene)]
    except DerivationError:
        return None
    moving = {*scene.coordinates, *scene.velocities}
    return sum_of(left) if not any(moving & set(symbols_of(term)) for term in left) else None


# An equation of motion, or a row of constraints


def _untitled(statement: Statement, page: Printable) -> Answer:
    """Return the answer to left = right: an equation of motion, or a row of constraints, where it could be either."""
    solved = _solved(statement, page)
    if solved is not None and solved.right:
        return solved
    found = _less(*statement.forms)
    if not may_be_row(found, page):
        return _equation(statement.line, found, page)
    row = _row(statement.line, found, page)
    if row.right or level_of(found, page.scene) != LEVELS[-1]:
        return row
    motion = _equation(statement.line, found, page)
    return motion if motion.right or 0 < len(motion.differences) < len(row.differences) else row


def _row(line: int, found: Form, page: Printable) -> Answer:
    """Return the answer to a row: the scene's row that it is, or the row in any axes that it comes nearest to."""
    scene = page.scene
    level = level_of(found, scene)
    own = scene_rows(page, level)
    for row in own:
        finding = _equal(row.name, found, row.form, scene)
        if finding.verdict in EQUAL:
            return Answer(line, row.name, finding.verdict, finding.error_log10)
        rates = [Symbol(name) for u in scene.velocities for name in (acceleration_name(u), u)]
        if level != LEVELS[0] and _proportional(found, row.form, page, rates):
            return Answer(line, row.name, PROVED, scaled=True)
    if holds(found, scene):
        return Answer(line, f"{level} row", HOLDS)
    best = Answer(line, f"{level} row", DIFFERENT)
    for row in (*own, *ground_rows(scene, level)):
        for mine in (found, _minus(found)):
            answer = _compared(line, row.name, mine, row.form, scene, "row")
            if answer.differences and (not best.differences or _length(answer) < _length(best)):
                best = answer
    return best


def _length(answer: Answer) -> int:
    """Return how much there is to tell: what is missing or should be there, in terms."""
    return sum(len(terms_of(form)) for d in answer.differences for form in (d.found, d.right) if form is not None)


def _equation(line: int, found: Form, page: Printable) -> Answer:
    """Return the answer to left = right: the scene's equation that it comes nearest to, times a factor or not."""
    scene, named = page.scene, set(symbols_of(found))
    rows = [i for i, drive in enumerate(scene.drives) if drive in named]
    rows = rows or [i for i, drive in enumerate(scene.drives) if not drive] or list(range(len(scene.drives)))
    best: Answer | None = None
    for i in rows:
        right = _balance(page, i)
        for mine in (found, _minus(found)):
            answer = _compared(line, f"equation {i + 1}", mine, right, scene, "equation")
            if answer.right:
                return answer
            if answer.turned:
                continue
            rates = [c.rate for c in page.rows[i] if c.of == "qdd" and not c.vanishes]
            if _proportional(mine, right, page, rates):
                return Answer(line, f"equation {i + 1}", PROVED, scaled=True)
            answer = _without_slope(answer, mine, right, i, page)
            if answer.forgotten:
                return answer
            for whole in _multiplied(mine, page, i):
                scaled = _compared(line, f"equation {i + 1}", whole, right, scene, "equation")
                if len(scaled.differences) in range(1, len(answer.differences)):
                    answer = scaled
            if best is None or len(answer.differences) < len(best.differences):
                best = answer
    assert best is not None, "a scene with coordinates has an equation"
    return best


def _without_slope(answer: Answer, found: Form, right: Form, i: int, page: Printable) -> Answer:
    """Return the answer, or one that says that Lagrange's -∂K/∂q was forgotten, if nothing else is wrong."""
    names = list(page.scene.coordinates)
    if answer.right or len(names) != len(page.rows):
        return answer
    graph = Graph()
    slope = gradient(express_form(page.K, graph), [graph.symbol(names[i])])[0]
    if slope.is_zero:
        return answer
    finding = _same("forgotten", express_form(found, graph), express_form(right, graph) + slope, page.scene)
    return replace(answer, forgotten=names[i], differences=()) if finding.verdict in EQUAL else answer


def _multiplied(found: Form, page: Printable, i: int) -> Iterator[Form]:
    """Yield a wrong equation times what makes one of its accelerations' coefficients the scene's: it was divided by."""
    graph = Graph()
    node = express_form(found, graph)
    parameters = {p.name for p in page.scene.parameters}
    for c in page.rows[i]:
        if c.of != "qdd" or c.vanishes:
            continue
        slope = gradient(node, [express_form(c.rate, graph)])[0]
        names = {str(one.value) for one in reachable([slope]) if one.op is Op.SYMBOL}
        if not slope.is_zero and names <= parameters:
            yield product_of((found, c.form, power_of(form_of(slope), -1)))


def _solved(statement: Statement, page: Printable) -> Answer | None:
    """Return the answer to an acceleration that is solved for, all others eliminated; None for what is none.

    u̇ = M⁻¹ (Q - h)
    """
    scene, (left, other) = page.scene, statement.forms
    accelerations = [acceleration_name(u) for u in scene.velocities]
    known = [str(form.name) for form in (left, other) if isinstance(form, Symbol) and form.name in accelerations]
    if len(known) != 1 or page.constraints.rows or len(accelerations) > FEW_SOLVED:
        return None
    formula = other if left == Symbol(known[0]) else left
    if set(accelerations) & set(symbols_of(formula)):
        return None
    graph = Graph()
    symbols = [graph.symbol(name) for name in accelerations]
    balance = [_balance(page, i) for i in range(len(accelerations))]
    M = [gradient(express_form(form, graph), symbols) for form in balance]
    still = dict.fromkeys(accelerations, ZERO)
    rest = [express_form(_minus(in_place(form, still)), graph) for form in balance]
    try:
        right = solve(range(-1, len(M)), M, rest)[accelerations.index(known[0])]
    except DerivationError:  # what moves no mass has no acceleration of its own
        return None
    finding = _same(known[0], express_form(formula, graph), right, scene)
    return Answer(statement.line, known[0], finding.verdict, finding.error_log10)


def _proportional(found: Form, right: Form, page: Printable, rates: Sequence[Form]) -> bool:
    """Whether found / right is free of rates and drives: cross-multiplied by what stands with the first of `rates`."""
    graph = Graph()
    a, b = express_form(found, graph), express_form(right, graph)
    moving = {*page.scene.velocities, *(acceleration_name(u) for u in page.scene.velocities), *page.scene.drives}
    symbols = [express_form(rate, graph) for rate in rates]
    pairs = [(x, y) for x, y in zip(gradient(a, symbols), gradient(b, symbols), strict=True) if not y.is_zero]
    if not pairs:
        return False
    x, y = pairs[0]
    if any(node.op is Op.SYMBOL and str(node.value) in moving for node in reachable([x])):
        return False
    nothing = Claim("no factor", "found", "0", (x,), (graph.zero,))
    same = Claim("proportional", "found", "scene", (a * y,), (b * x,))
    first, second = _proved([nothing, same], page.scene)
    return first.verdict == DIFFERENT and second.verdict in EQUAL
