"""Left = right of a student's: an equation of motion, or a row of constraints, right or in which terms it differs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from symdyn.algebra import Form, Number, Symbol
from symdyn.dynamics.mechanism import solve
from symdyn.emit.print import Printable
from symdyn.errors import DerivationError
from symdyn.graph import Graph, Op, gradient, reachable
from symdyn.scene.values import acceleration_name
from symdyn.teach.student.answer import EQUAL, HOLDS, Answer
from symdyn.teach.student.quantity import equality, findings, judged, less, minus, same_value
from symdyn.teach.student.rows import LEVELS, ground_rows, holds, level_of, may_be_row, scene_rows
from symdyn.teach.student.statements import Statement
from symdyn.verdict import Verdict
from symdyn.verify import Claim

FEW_SOLVED = 4  # accelerations, while equations solved for one are something that a student writes


def _balance(page: Printable, i: int) -> Form:
    """Return what vanishes by equation i."""
    return less(page.left(i), page.driving(i))


def untitled(statement: Statement, page: Printable) -> Answer:
    """Return the answer to left = right: an equation of motion, or a row of constraints, where it could be either."""
    solved = _solved(statement, page)
    if solved is not None and solved.right:
        return solved
    found = less(*statement.forms)
    if not may_be_row(found, page):
        return _equation(statement.line, found, page)
    row = _row(statement.line, found, page)
    if row.right or level_of(found, page.scene) != LEVELS[-1]:
        return row
    motion = _equation(statement.line, found, page)
    return motion if motion.right or 0 < len(motion.differences) < len(row.differences) else row


def _row(line: int, form: Form, page: Printable) -> Answer:
    """Return the answer to a row: the scene's row that it is, or the row in any axes that it comes nearest to."""
    scene = page.scene
    level = level_of(form, scene)
    own = scene_rows(page, level)
    for row in own:
        finding = equality(row.name, form, row.form, scene)
        if finding.verdict in EQUAL:
            return Answer(line, row.name, finding.verdict, finding.error_log10)
        rates = [Symbol(name) for u in scene.velocities for name in (acceleration_name(u), u)]
        if level != LEVELS[0] and _proportional(form, row.form, page, rates):
            return Answer(line, row.name, Verdict.PROVED, scaled=True)
    if holds(form, scene):
        return Answer(line, f"{level} row", HOLDS)
    best = Answer(line, f"{level} row", Verdict.DIFFERENT)
    for row in (*own, *ground_rows(scene, level)):
        for mine in (form, minus(form)):
            answer = judged(line, row.name, mine, row.form, scene, "row")
            if answer.differences and (not best.differences or _length(answer) < _length(best)):
                best = answer
    return best


def _length(answer: Answer) -> int:
    """Return how much there is to tell: what is missing or should be there, in terms."""
    return sum(len(form.terms) for d in answer.differences for form in (d.found, d.right) if form is not None)


def _equation(line: int, form: Form, page: Printable) -> Answer:
    """Return the answer to left = right: the scene's equation that it comes nearest to, times a factor or not."""
    scene, named = page.scene, set(form.symbols)
    rows = [i for i, drive in enumerate(scene.drives) if drive in named]
    rows = rows or [i for i, drive in enumerate(scene.drives) if not drive] or list(range(len(scene.drives)))
    best: Answer | None = None
    for i in rows:
        right = _balance(page, i)
        for mine in (form, minus(form)):
            answer = judged(line, f"equation {i + 1}", mine, right, scene, "equation")
            if answer.right:
                return answer
            if answer.turned:
                continue
            rates = [c.rate for c in page.rows[i] if c.of == "qdd" and not c.vanishes]
            if _proportional(mine, right, page, rates):
                return Answer(line, f"equation {i + 1}", Verdict.PROVED, scaled=True)
            answer = without_slope(answer, mine, right, i, page)
            if answer.forgotten:
                return answer
            for whole in _multiplied(mine, page, i):
                scaled = judged(line, f"equation {i + 1}", whole, right, scene, "equation")
                if len(scaled.differences) in range(1, len(answer.differences)):
                    answer = scaled
            if best is None or len(answer.differences) < len(best.differences):
                best = answer
    assert best is not None, "a scene with coordinates has an equation"
    return best


def without_slope(answer: Answer, form: Form, right: Form, i: int, page: Printable) -> Answer:
    """Return the answer, or one that says that Lagrange's -∂K/∂q was forgotten, if nothing else is wrong."""
    names = list(page.scene.coordinates)
    if answer.right or len(names) != len(page.rows):
        return answer
    graph = Graph()
    slope = gradient(page.K.express(graph), [graph.symbol(names[i])])[0]
    if slope.is_zero:
        return answer
    finding = same_value("forgotten", form.express(graph), right.express(graph) + slope, page.scene)
    return replace(answer, forgotten=names[i], differences=()) if finding.verdict in EQUAL else answer


def _multiplied(form: Form, page: Printable, i: int) -> Iterator[Form]:
    """Yield a wrong equation times what makes one of its accelerations' coefficients the scene's: it was divided by."""
    graph = Graph()
    node = form.express(graph)
    parameters = {p.name for p in page.scene.parameters}
    for c in page.rows[i]:
        if c.of != "qdd" or c.vanishes:
            continue
        slope = gradient(node, [c.rate.express(graph)])[0]
        names = {str(one.value) for one in reachable([slope]) if one.op is Op.SYMBOL}
        if not slope.is_zero and names <= parameters:
            yield Form.product((form, c.form, Form.of(slope).power(-1)))


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
    if set(accelerations) & set(formula.symbols):
        return None
    graph = Graph()
    symbols = [graph.symbol(name) for name in accelerations]
    balance = [_balance(page, i) for i in range(len(accelerations))]
    M = [gradient(form.express(graph), symbols) for form in balance]
    still = dict.fromkeys(accelerations, Number.ZERO)
    rest = [minus(form.substitute(still)).express(graph) for form in balance]
    try:
        right = solve(range(-1, len(M)), M, rest)[accelerations.index(known[0])]
    except DerivationError:  # what moves no mass has no acceleration of its own
        return None
    finding = same_value(known[0], formula.express(graph), right, scene)
    return Answer(statement.line, known[0], finding.verdict, finding.error_log10)


def _proportional(form: Form, right: Form, page: Printable, rates: Sequence[Form]) -> bool:
    """Whether found / right is free of rates and drives: cross-multiplied by what stands with the first of `rates`."""
    graph = Graph()
    a, b = form.express(graph), right.express(graph)
    moving = {*page.scene.velocities, *(acceleration_name(u) for u in page.scene.velocities), *page.scene.drives}
    symbols = [rate.express(graph) for rate in rates]
    pairs = [(x, y) for x, y in zip(gradient(a, symbols), gradient(b, symbols), strict=True) if not y.is_zero]
    if not pairs:
        return False
    x, y = pairs[0]
    if any(node.op is Op.SYMBOL and str(node.value) in moving for node in reachable([x])):
        return False
    nothing = Claim("no factor", "found", "0", (x,), (graph.zero,))
    same = Claim("proportional", "found", "scene", (a * y,), (b * x,))
    first, second = findings([nothing, same], page.scene)
    return first.verdict == Verdict.DIFFERENT and second.verdict in EQUAL
