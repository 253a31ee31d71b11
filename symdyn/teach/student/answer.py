"""What became of one statement of a student's text, and that in words: sentences, filled with formulas.

A statement is left = right, an equation of motion or a row of constraints, or a formula of one quantity: right by
value, or in which terms it differs.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from symdyn.algebra import Form, Number, Symbol
from symdyn.dynamics.mechanism import solve
from symdyn.emit.print import Printable, text_of
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, gradient, reachable
from symdyn.scene import Scene
from symdyn.scene.values import acceleration_name
from symdyn.teach.languages import language_of
from symdyn.teach.student.differences import Difference, differences
from symdyn.teach.student.mistakes import Mistake
from symdyn.teach.student.motions import constants
from symdyn.teach.student.rows import LEVELS, ground_rows, holds, level_of, may_be_row, scene_rows
from symdyn.teach.student.statements import Statement
from symdyn.verdict import Verdict
from symdyn.verify import Claim, Finding, prove

EQUAL = Verdict.HOLD

ROUNDED, HOLDS, EMPTY, MOTIONS = "rounded", "holds", "empty", "motions"

MOST, MANY = 12, 400  # differences told, and listed
LONGEST = 600  # characters of a formula that is told

SAID = {ROUNDED: "digits", HOLDS: "holds", Verdict.NOT_SHOWN: "undefined", EMPTY: "empty", MOTIONS: "motions"}
"""Verdicts that one sentence tells."""


@dataclass(frozen=True)
class Answer:
    """What became of one statement.

    Attributes:
        line: where it stands, from 1.
        name: of the quantity, such as "k_z12", or "equation 2", "velocity row 1".
        verdict: one of `symdyn.verdict`, as of a finding; ROUNDED for equal to the digits written;
            HOLDS for a row that is none of the scene's, but true wherever the loops are closed; MOTIONS for what is
            true on every motion; EMPTY for what names quantities in place of formulas, such as L = K - P.
        error_log10: log10 of the probability that a wrong formula would pass; 0 when not proved.
        differences: term by term; none where it is right or where no term can be named.
        turned: whether all of it has the opposite sign.
        shifted: by how much a potential energy lies elsewhere, which is free; None for not at all.
        scaled: whether an equation is the scene's times a factor.
        valued: parameters in whose place the formula has the scene's numbers.
        multiplied: multipliers that stand in an energy, each times a condition, as they may.
        forgotten: the coordinate q whose -dK/dq is all that is missing; "" for none.
        mistake: the rule that was forgotten, None for none.
        read: the statement as it was read, "" where nothing was.
        stars: runs of names in it that were read as products, as products.
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
    multiplied: tuple[str, ...] = ()
    forgotten: str = ""
    mistake: Mistake | None = None
    read: str = ""
    stars: tuple[str, ...] = ()

    @property
    def right(self) -> bool:
        """Whether the statement is true."""
        return self.verdict in (*EQUAL, ROUNDED, HOLDS, MOTIONS)

    def in_words(self, language: str = "en") -> list[str]:
        """Return it as lines: see `in_words`."""
        return in_words(self, language)

    def as_read(self, language: str = "en") -> list[str]:
        """Return as lines how the statement was read, as a page shows it below its box."""
        say = language_of(language).lesson
        stars = [f"  {say['answer.stars'].format(text=', '.join(self.stars))}"] if self.stars else []
        return [*stars, f"  {say['answer.echo']}: {self.read}"]

    def as_dict(self) -> dict[str, Any]:
        """Return what became of one statement, for JSON; formulas as text."""

        def formula(form: Form | None) -> str | None:
            return None if form is None else text_of(form)

        differences = [
            {"kind": one.kind, "found": formula(one.found), "right": formula(one.right), "symbols": list(one.symbols)}
            for one in self.differences
        ]
        told = {name: getattr(self, name) for name in ("line", "name", "verdict", "right", "error_log10", "turned")}
        return told | {
            "shifted": formula(self.shifted), "scaled": self.scaled, "valued": list(self.valued),
            "multiplied": list(self.multiplied), "forgotten": self.forgotten, "differences": differences,
            "read": self.read, "stars": list(self.stars),
        }  # fmt: skip


def in_words(answer: Answer, language: str = "en") -> list[str]:
    """Return an answer as lines: the verdict, then one indented line a difference."""
    spoken = language_of(language)
    say = spoken.answers
    name = _named(answer.name, say)
    if answer.verdict in SAID:
        return [say[SAID[answer.verdict]].format(name=name)]
    if answer.right:
        if answer.shifted is not None:
            return [say["shifted"].format(name=name, shift=text_of(answer.shifted))]
        if answer.multiplied:
            return [say["multiplied"].format(name=name, symbols=", ".join(answer.multiplied))]
        if answer.valued:
            return [say["valued"].format(name=name, symbols=", ".join(answer.valued))]
        if answer.scaled:
            return [say["scaled"].format(name=name)]
        how = (
            say["proved"].format(log=f"{answer.error_log10:.0f}")
            if answer.verdict == Verdict.PROVED
            else say["numerical"]
        )
        return [say["right"].format(name=name) + how]
    rule = _rule(answer, spoken.mistakes)
    if answer.forgotten:
        more = [f"  {rule}"] if answer.mistake and answer.mistake.more else []
        return [say["forgotten"].format(name=name, q=answer.forgotten), *more]
    if answer.turned:
        hint = say["book"] if answer.name.startswith(("k_C", "k_D")) else ""
        return [say["turned"].format(name=name) + hint, *([f"  {rule}"] if rule else [])]
    told = [f"  {_difference(d, say)}" for d in answer.differences[:MOST]] or [f"  {say['unlisted']}"]
    if len(answer.differences) > MOST:
        told.append(f"  {say['more'].format(count=len(answer.differences) - MOST)}")
    return [say["different"].format(name=name) + (f": {rule}" if rule else ""), *told]


def _rule(answer: Answer, say: Mapping[str, str]) -> str:
    """Return which rule was forgotten, "" for none that is known."""
    if answer.mistake is None:
        return ""
    rule, of, other = answer.mistake.rule, answer.mistake.of, answer.mistake.other
    where, both = say["where"].format(of=of) if of else "", say.get(f"{rule}.{other}")  # what two are together
    beside = say["or"] + say[other] if other and not both else ""
    return (both or say[rule]) + where + beside + "".join(say["and"] + say[one] for one in answer.mistake.more)


def _named(name: str, say: Mapping[str, str]) -> str:
    """Return the name of an equation or a row in the language; that of a quantity as it is."""
    if found := re.fullmatch(r"(\w+ of) (.+) along ([xyz])", name):
        return say[found[1]].format(loop=found[2], axis=found[3])
    head, _, number = name.rpartition(" ")
    if name in say:
        return say[name]
    return f"{say[head]} {number}" if head in say else name


def short(form: Form | None) -> str:
    """Return a form as text, the beginning of one that is very long."""
    text = text_of(form) if form is not None else ""
    return text if len(text) <= LONGEST else f"{text[:LONGEST]} ..."


def _difference(difference: Difference, say: Mapping[str, str]) -> str:
    found, right = short(difference.found), short(difference.right)
    symbols: Sequence[str] = [*difference.symbols, "", ""]
    return say[difference.kind].format(
        found=found,
        right=right,
        found_symbol=symbols[0],
        right_symbol=symbols[1],
        factor=text_of(Number(difference.factor)),
    )


def less(a: Form, b: Form) -> Form:
    """Return a - b."""
    return Form.sum((a, b.negative))


def judged(line: int, name: str, form: Form, right: Form, scene: Scene, kind: str) -> Answer:
    """Return the answer to a formula of a quantity, or of a row."""
    finding = equality(name, form, right, scene)
    if finding.verdict != Verdict.DIFFERENT:
        return Answer(line, name, finding.verdict, finding.error_log10)
    if kind.startswith(("P", "L")) and (constant := _free(less(form, right), scene)) is not None:
        return Answer(line, name, Verdict.PROVED, finding.error_log10, shifted=constant)
    values = _values(form, right, scene)
    if values and equality(name, form, right.substitute(values), scene).verdict in EQUAL:
        return Answer(line, name, Verdict.PROVED, valued=tuple(values))
    if equality(name, form, right.negative, scene).verdict in EQUAL:
        return Answer(line, name, Verdict.DIFFERENT, turned=True)
    try:
        listed = differences(form, right, scene)
    except DerivationError:
        listed = []
    if listed and all(d.kind == "rounded" for d in listed):
        return Answer(line, name, ROUNDED, differences=tuple(listed))
    return Answer(line, name, Verdict.DIFFERENT, differences=tuple(listed[:MANY]))


def _values(form: Form, right: Form, scene: Scene) -> dict[str, Form]:
    """Return the numbers of parameters that only the right formula names."""
    absent = set(right.symbols) - set(form.symbols)
    values = {p.name: p.value for p in scene.parameters if p.name in absent and p.value is not None}
    return {name: Form.of(value.express(Graph())) for name, value in values.items()}


def equality(name: str, form: Form, right: Form, scene: Scene) -> Finding:
    """Return whether two forms are the same function."""
    graph = Graph()
    return same_value(name, form.express(graph), right.express(graph), scene)


def settled(form: Form, scene: Scene) -> Form:
    """Return a result as it is; zero where it is that at every state, so that no doubles are left of it."""
    return Number.ZERO if equality("zero", form, Number.ZERO, scene).verdict in EQUAL else form


def same_value(name: str, node: Expr, right: Expr, scene: Scene) -> Finding:
    """Return whether two nodes of one graph are the same function."""
    return findings([Claim(name, "found", "scene", (node,), (right,))], scene)[0]


def findings(claims: Sequence[Claim], scene: Scene) -> list[Finding]:
    """Return what becomes of claims about a scene."""
    return prove(claims, positive=[p.name for p in scene.parameters if p.positive])[1]


def _free(form: Form, scene: Scene) -> Form | None:
    """Return the value of a form if it depends on constants only: it is looked at term by term."""
    try:
        left = [d.found or (d.right or Number.ZERO).negative for d in differences(form, Number.ZERO, scene)]
    except DerivationError:
        return None
    fixed = constants(scene)
    return Form.sum(left) if all(fixed.issuperset(term.symbols) for term in left) else None


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
        for mine in (form, form.negative):
            answer = judged(line, row.name, mine, row.form, scene, "row")
            if answer.differences and (not best.differences or _length(answer) < _length(best)):
                best = answer
    return best


def _length(answer: Answer) -> int:
    """Return the number of differences: what is missing or should be there, in terms."""
    return sum(len(form.terms) for d in answer.differences for form in (d.found, d.right) if form is not None)


def _equation(line: int, form: Form, page: Printable) -> Answer:
    """Return the answer to left = right: the scene's equation that it comes nearest to, times a factor or not."""
    scene, named = page.scene, set(form.symbols)
    rows = [i for i, drive in enumerate(scene.drives) if drive in named]
    rows = rows or [i for i, drive in enumerate(scene.drives) if not drive] or list(range(len(scene.drives)))
    best: Answer | None = None
    for i in rows:
        right = _balance(page, i)
        for mine in (form, form.negative):
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
    rest = [form.substitute(still).negative.express(graph) for form in balance]
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
