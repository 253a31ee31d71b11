"""Steps of equations with multipliers: what ties the coordinates, the principle, the whole system, and what is left.

Conditions are differentiated once and twice, the slopes of all of them make one matrix; in the end the multipliers are
eliminated.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra import Form, Number, Polynomial, Power, Symbol
from symdyn.emit.print import Printable, latex_symbols, text_of
from symdyn.graph import Expr, substitute
from symdyn.scene import Scene, SceneUnits
from symdyn.teach.derivations.constrained import Condition, Constrained
from symdyn.teach.derivations.solved import LONGEST
from symdyn.teach.derivations.solved_ties import integral
from symdyn.teach.derivations.velocities import PAGE, folded, force_row, length
from symdyn.teach.document import Block, Formula, Letter, Matrix, Name, Step, Words
from symdyn.teach.lesson import named, together

ROD = "tie.rod"
"""Key of the sentence about the multiplier of a rod: the condition is that of its length."""

ROPE = "tie.tension"
"""Key of the sentence about the multiplier of a rope."""

MOST_SLOPES = 8
"""Velocities up to which all slopes are shown as one matrix."""


def name_ties(lesson: Constrained) -> None:
    """Name every condition, its derivatives and its slopes, each with its value on the graph."""
    graph, state = lesson.graph, lesson.state
    for tie in lesson.ties:
        letter, k = ("c" if tie.residual is None else "f"), tie.number
        if tie.residual is not None:
            lesson.name(tie.key, letter, k, node=tie.residual)
        along = graph.dot(tie.slopes, state.qd)
        pushed = graph.total([*(a * u for a, u in zip(tie.slopes, state.qdd, strict=True)), tie.bias])
        dots = 0 if tie.residual is None else 1
        lesson.name(tie.rate, letter, k, node=along, dots=dots)
        lesson.name(tie.acceleration, letter, k, node=pushed, dots=dots + 1)
        for i, slope in enumerate(tie.slopes, 1):
            lesson.name(f"A:{k},{i}", "J", f"{k}{i}" if max(i, len(lesson.ties)) < 10 else f"{k} {i}", node=slope)


def multiplier(tie: Condition) -> Symbol:
    """Return the symbol of a condition's multiplier."""
    return Symbol(f"lambda:{tie.number}")


def slope(lesson: Constrained, tie: Condition, i: int) -> Form:
    """Return A_ki in print."""
    return lesson.tie_form(tie.nodes[i])


def condition_steps(lesson: Constrained) -> list[Step]:
    """Return the count, one step an owner, accelerations, and the matrix of slopes."""
    n, m = lesson.state.n, len(lesson.ties)
    owners = dict.fromkeys(tie.owner for tie in lesson.ties)
    held = [tie for tie in lesson.ties if tie.residual is not None]
    places = {"coordinates": str(n), "conditions": str(m), "free": str(n - m)}
    cut = lesson.say("ties.loops" if any(tie.loop for tie in lesson.ties) else "ties.contacts")
    steps = [Step("ties", lesson.say("ties", **places), (), cut, show=("frames",))]
    steps += [_owner(lesson, [tie for tie in lesson.ties if tie.owner == owner]) for owner in owners]
    if len(held) < m:
        slips = together([Symbol(tie.rate) for tie in lesson.ties if tie.residual is None])
        whole = [(tie, integral(lesson, tie)) for tie in lesson.ties if tie.residual is None]
        kind = "integrable" if lesson.integrable else "slip"
        if known := [(tie, form) for tie, form in whole if form is not None]:
            said = [lesson.say("ties.integral", rate=Symbol(tie.rate), form=form) for tie, form in known]
            steps.append(Step("ties.slip", lesson.say("ties.integrated"), tuple(said)))
        if len(known) < len(whole):
            steps.append(
                Step(f"ties.{kind}", lesson.say(f"ties.{kind}", names=slips), (), lesson.say(f"ties.{kind}.reason"))
            )
    steps.append(_accelerations(lesson))
    if n <= MOST_SLOPES:
        steps.append(_matrix(lesson))
    return steps


def _owner(lesson: Constrained, ties: list[Condition]) -> Step:
    """Return what one loop or contact keeps zero, and its rate."""
    blocks = lesson.introduced(ties[0].owner)
    before = lesson.roots_of(lesson.ties[: lesson.ties.index(ties[0])])
    for root in lesson.roots_of(ties):
        if root not in before:
            blocks += _root(lesson, root)
    held = [tie for tie in ties if tie.residual is not None]
    blocks += [folded(lesson, Formula(tie.key, lesson.tie_form(tie.nodes[-1]))) for tie in held]
    if held:
        blocks.append(lesson.say("ties.zero", names=_all([Symbol(tie.key) for tie in held])))
    u = list(map(named, lesson.state.qd))
    for tie in ties:
        terms = (slope(lesson, tie, i).signed_product(rate) for i, rate in enumerate(u))
        blocks.append(folded(lesson, Formula(tie.rate, Form.sum(terms))))
    blocks.append(lesson.say("ties.still", names=_all([Symbol(tie.rate) for tie in ties])))
    first = ties[0]
    key = "ties.loop" if first.loop else "ties.contact" if first.parent else "ties.formula"
    places = {"parent": lesson.body(first.parent), "child": lesson.body(first.child)}
    if first.words == ROPE:
        rope = next(one for one in lesson.scene.lasting_ropes if one.name == first.owner)
        key = "ties.rope.wound" if rope.ends[0].turn or rope.ends[-1].turn else "ties.rope"
        places = {"route": " – ".join(lesson.body(end.body) for end in rope.ends)}
    claim = lesson.say(key.removesuffix(".wound"), owner=first.owner, **places)
    told = first.words == ROPE or (first.loop and first.words == "tie.force")
    reason = lesson.once(f"{key}.reason") if told else Words(())
    reason = lesson.once("ties.rod.reason") if first.words == ROD else reason
    show = (f"joint:{first.owner}", "velocities") if first.loop else ("velocities",)
    return Step(f"tie:{first.owner}", claim, tuple(blocks), reason, show=show)


def _root(lesson: Constrained, root: Expr) -> list[Block]:
    """Return what a root stands for: ±p where it is √p², else its letter."""
    if root not in lesson.squares:
        return [lesson.say("ties.root"), Formula(lesson.roots[root].name, lesson.root_form(root))]
    plain = lesson.tie_form(lesson.squares[root])
    return [lesson.say("ties.square", root=lesson.root_form(root), plain=plain)]


def _accelerations(lesson: Constrained) -> Step:
    """Return f̈_k = A_ki q̈_i + Ȧ_ki q̇_i."""
    u, a = list(map(named, lesson.state.qd)), list(map(named, lesson.state.qdd))
    blocks: list[Block] = []
    for tie in lesson.ties:
        terms = [slope(lesson, tie, i).signed_product(rate) for i, rate in enumerate(a)]
        for j, k, node in lesson.turning[tie.number]:
            rates: list[Form] = [Power(u[j], 2)] if j == k else [u[j], u[k]]
            terms.append(lesson.tie_form(node).signed_product(Form.product(rates)))
        blocks.append(folded(lesson, Formula(tie.acceleration, Form.sum(terms))))
    blocks.append(lesson.say("ties.still", names=_all([Symbol(tie.acceleration) for tie in lesson.ties])))
    return Step("ties.accelerations", lesson.say("ties.accelerations"), tuple(blocks), show=("accelerations",))


def _matrix(lesson: Constrained) -> Step:
    """Return the matrix of all A_ki, those longer than a page by their names."""
    lesson.name("A:", "J", node=None)
    cells = [(slope(lesson, tie, i), f"A:{tie.number},{i + 1}") for tie in lesson.ties for i in range(lesson.state.n)]
    forms, names = zip(*cells, strict=True)
    forms = tuple(form if length(form) <= PAGE else Symbol(name) for form, name in cells)
    matrix = Matrix("A:", forms, tuple(names), width=lesson.state.n)
    columns = together([named(u) for u in lesson.state.qd])
    return Step("ties.matrix", lesson.say("ties.matrix", columns=columns), (matrix,), lesson.say("ties.matrix.reason"))


def _all(names: list[Symbol]) -> Words:
    """Return "f_1 = f_2 = 0" as prose."""
    return Words((*(part for name in names for part in (name, " = ")), "0"))


WIDEST = 10
"""Rows of a system that is shown as one matrix."""

MOST_DEPENDENT = 3
"""Conditions up to which ratios of velocities are written out: a determinant of four rows is none to read."""


def name_forces(lesson: Constrained, right: Sequence[Form]) -> tuple[Form, ...]:
    """Name multipliers and drives, and return the right-hand sides with multipliers.

    Multipliers are worth what the equations of the dependent velocities make them, drives what their own leave them.
    A drive of a dependent velocity is given: a symbol.
    """
    graph, parts, given = lesson.graph, lesson.partition, list(lesson.drives)
    for i in parts.dependent:
        if own := lesson.scene.drives[i]:
            given[i] = given[i] - graph.symbol(own)
    found = parts.solve_transposed([list(tie.slopes) for tie in lesson.ties], given)
    whole = []
    for tie, node in zip(lesson.ties, found, strict=True):
        lesson.name(multiplier(tie).name, "lambda", tie.number, node=node)
    for i, force in enumerate(right):
        carried = [(tie, node) for tie, node in zip(lesson.ties, found, strict=True) if not tie.slopes[i].is_zero]
        terms = (_long(lesson, tie, i).signed_product(multiplier(tie)) for tie, _ in carried)
        whole.append(Form.sum([force, *(term for term in terms if term.terms)]))
        if own := lesson.scene.drives[i]:
            held = graph.total(tie.slopes[i] * node for tie, node in carried)
            node = graph.symbol(own) if i in parts.dependent else lesson.plain(lesson.drives[i] - held)
            lesson.names[own] = Name(None, node)
    return tuple(whole)


def _long(lesson: Constrained, tie: Condition, i: int) -> Form:
    """Return A_ki, by its name where it is long."""
    form = slope(lesson, tie, i)
    return form if length(form) <= MOST_DEPENDENT else Symbol(f"A:{tie.number},{i + 1}")


def principle_steps(lesson: Constrained, page: Printable) -> list[Step]:
    """Return D'Alembert's principle, the conditions added to it, and what the multipliers are."""
    return [_principle(lesson, page), _added(lesson), meaning_step(lesson)]


def _principle(lesson: Constrained, page: Printable) -> Step:
    """Return the virtual work δW of everything, and the virtual displacements that the conditions allow."""
    graph, ways = lesson.graph, _ways(lesson)
    terms = [_rest(lesson, page, i).signed_product(way) for i, way in enumerate(ways)]
    node = graph.total(force * graph.symbol(way.name) for force, way in zip(lesson.drives, ways, strict=True))
    node = node - graph.total(_driven(lesson, i) * graph.symbol(way.name) for i, way in enumerate(ways))
    lesson.called("delta:W", Letter(r"\delta W"), node)
    blocks: list[Block] = [Formula("delta:W", Form.sum(terms)), lesson.say("principle.allowed")]
    for tie in lesson.ties:
        letter = lesson.letters.latex("c" if tie.residual is None else "f")
        moved = graph.total(a * graph.symbol(way.name) for a, way in zip(tie.slopes, ways, strict=True))
        key = lesson.called(f"delta:f{tie.number}", Letter(rf"\delta {letter}", (tie.number,)), moved).name
        form = Form.sum(_long(lesson, tie, i).signed_product(way) for i, way in enumerate(ways))
        blocks.append(folded(lesson, Formula(key, form)))
    names = together([Symbol(f"delta:f{tie.number}") for tie in lesson.ties])
    blocks.append(lesson.say("principle.zero", names=names))
    claim = lesson.say("principle", work=Symbol("delta:W"))
    return Step("principle", claim, tuple(blocks), lesson.say("principle.reason"))


def _ways(lesson: Constrained) -> list[Symbol]:
    """Return the virtual displacements δq_i; symbols of the graph."""
    spelled, found = latex_symbols(lesson.scene), []
    for i, u in enumerate(lesson.state.qd, 1):
        q = next((q for q, rate in zip(lesson.state.q, lesson.state.rates, strict=True) if rate is u), u)
        key = f"delta:{i}"
        found.append(lesson.called(key, Letter(rf"\delta {spelled[str(q.value)]}"), lesson.graph.symbol(key)))
    return found


def _driven(lesson: Constrained, i: int) -> Expr:
    """Return the drive of a velocity, zero where there is none."""
    own = lesson.scene.drives[i]
    node = lesson.names[own].node if own else None
    return lesson.graph.zero if node is None else node


def _rest(lesson: Constrained, page: Printable, i: int, without: str | None = None) -> Form:
    """Return d/dt ∂L/∂q̇_i - ∂L/∂q_i - drive - Q_i, in print, without the drive of a name."""
    rate, q = lesson.state.qd[i].value, lesson.state.q[i].value
    acting = (Form.product((Number.MINUS_ONE, term)) for term in page.right[i].terms if term != Symbol(without or ""))
    return Form.sum((Symbol(f"d/dt dL:/d{rate}"), Form.product((Number.MINUS_ONE, Symbol(f"dL:/d{q}"))), *acting))


def _added(lesson: Constrained) -> Step:
    """Return why the multipliers may be chosen so that every bracket vanishes."""
    parts, u = lesson.partition, lesson.state.qd
    work = [Symbol(f"delta:f{tie.number}") for tie in lesson.ties]
    added = Form.sum(
        Form.product((Number.MINUS_ONE, multiplier(tie), way)) for tie, way in zip(lesson.ties, work, strict=True)
    )
    places: dict[str, str | Form | Words] = {
        "sum": Form.sum((Symbol("delta:W"), added)),
        "dependent": together([Symbol(f"delta:{k + 1}") for k in parts.dependent]),
        "independent": together([Symbol(f"delta:{k + 1}") for k in parts.independent]),
        "rates": together([named(u[k]) for k in parts.dependent]),
    }
    said = lesson.say("added.choice" if parts.independent else "added.none", **places)
    return Step("added", lesson.say("added", **places), (said,), lesson.say("added.reason", **places))


def meaning_step(lesson: Constrained) -> Step:
    """Return what each multiplier is."""
    rows = [(multiplier(tie), meaning(lesson, tie), unit_of(tie, lesson.scene)) for tie in lesson.ties]
    table = lesson.table(("symbol", "meaning", "unit"), rows)
    reason = lesson.say("multipliers.reason") if any(tie.parent for tie in lesson.ties) else Words(())
    return Step("multipliers", lesson.say("multipliers"), (table,), reason, show=("reactions",))


def meaning(lesson: Constrained, tie: Condition) -> Words:
    """Return what the multiplier of a condition is."""
    places: dict[str, str] = {"axis": tie.axis, "parent": lesson.body(tie.parent), "child": lesson.body(tie.child)}
    return lesson.say(tie.words, owner=tie.owner, rate=Symbol(tie.rate), **places)


def unit_of(tie: Condition, scene: Scene) -> str:
    """Return the unit of a multiplier, for a formula of the scene what that tells, "" where it is nothing."""
    if tie.words == "tie.formula":
        return SceneUnits(scene).constraints.get(tie.owner, "")
    return "N m" if tie.words.startswith("tie.moment") else "N"


# All equations together


def system_step(lesson: Constrained, right: bool = False) -> Step:
    """Return the equations of motion and the accelerations of the conditions as one linear system.

    `right`: with its right-hand side, by coefficients in closed form.
    """
    n, m = lesson.state.n, len(lesson.ties)
    unknowns = [
        *map(named, lesson.state.qdd),
        *(Form.product((Number.MINUS_ONE, multiplier(tie))) for tie in lesson.ties),
    ]
    places: dict[str, str | Form | Words] = {
        "equations": str(n + m),
        "moving": str(n),
        "conditions": str(m),
        "unknowns": together(unknowns),
    }
    blocks: list[Block] = [lesson.say("system.counted", **places)]
    if n + m <= WIDEST:
        blocks.append(lesson.say("system.sorted", **places))
        lesson.names["0:"] = Name(None, lesson.graph.zero)
        lesson.name("B:", r"\mathcal{B}", node=None)
        cells: list[tuple[Form, str]] = []
        for i in range(n):
            cells += [_inertia(lesson, i, j) for j in range(n)]
            cells += [(_cell(lesson, tie, i), f"A:{tie.number},{i + 1}") for tie in lesson.ties]
        for tie in lesson.ties:
            cells += [(_cell(lesson, tie, i), f"A:{tie.number},{i + 1}") for i in range(n)]
            cells += [(Number.ZERO, "0:")] * m
        forms, names = zip(*cells, strict=True)
        blocks.append(Matrix("B:", tuple(forms), tuple(names), width=n + m))
        blocks += _right_side(lesson) if right else []
    return Step("system", lesson.say("tied.system"), tuple(blocks), lesson.say("system.reason"))


def _right_side(lesson: Constrained) -> list[Block]:
    """Return what the matrix times the unknowns is: forces, and minus what f̈_k has without accelerations."""
    b, u, long = lesson.name("b:", "b", node=None), list(map(named, lesson.state.qd)), list[Symbol]()
    still = substitute(lesson.drives, dict.fromkeys(lesson.state.qdd, lesson.graph.zero))
    nodes = [_driven(lesson, i) - node for i, node in enumerate(still)]
    cells = [force_row(lesson, i) for i in range(lesson.state.n)]
    for tie in lesson.ties:
        nodes.append(-tie.bias)
        form = Form.sum(
            lesson.tie_form(-node).signed_product(Form.product((u[j], u[k])) if j != k else u[j].power(2))
            for j, k, node in lesson.turning[tie.number]
        )
        key = f"b:{len(nodes)}"
        if length(form) > MOST_DEPENDENT:
            long.append(Symbol(tie.acceleration))
        cells.append(form if length(form) <= MOST_DEPENDENT else Symbol(key))
    keys = [lesson.name(f"b:{k}", "b", str(k), node=node).name for k, node in enumerate(nodes, 1)]
    blocks: list[Block] = [lesson.say("system.right"), Matrix(b.name, tuple(cells), tuple(keys))]
    return [*blocks, lesson.say("system.rest", names=together(long))] if long else blocks


def _inertia(lesson: Constrained, i: int, j: int) -> tuple[Form, str]:
    """Return k_z,ij by its name, and the key of its value."""
    if lesson.without_inertia(i, j):
        return Number.ZERO, "0:"
    return Symbol(key := f"k_z:{i + 1},{j + 1}"), key


def _cell(lesson: Constrained, tie: Condition, i: int) -> Form:
    form = slope(lesson, tie, i)
    return form if length(form) <= 1 else Symbol(f"A:{tie.number},{i + 1}")


# Without multipliers


def reduced_steps(lesson: Constrained, page: Printable) -> list[Step]:
    """Return the ratios of dependent to independent velocities, and the equations that hold no multiplier.

    None where no velocity is independent, or the ratios would be too long to read; `page` has no multipliers.
    """
    parts, m = lesson.partition, len(lesson.ties)
    if lesson.writer.ring is None or m > MOST_DEPENDENT or not parts.independent:
        return []
    u, blocks = lesson.state.qd, list[Block]()
    ratios: dict[tuple[int, int], Symbol] = {}
    for j in parts.dependent:
        for k in parts.independent:
            node, form = _ratio(lesson, parts.dependent, j, k)
            if length(form) > LONGEST:
                return []
            if form.terms:
                index = (f"{j + 1}{k + 1}",) if len(u) < 10 else (str(j + 1), str(k + 1))
                ratios[j, k] = lesson.name(f"Y:{j + 1},{k + 1}", "Y", *index, node=node)
                blocks.append(Formula(ratios[j, k].name, form))
    for j in parts.dependent:
        terms = [Form.product((ratios[j, k], named(u[k]))) for k in parts.independent if (j, k) in ratios]
        blocks.append(Words((named(u[j]), " = ", Form.sum(terms))))
    places: dict[str, str | Form | Words] = {
        "dependent": together([named(u[k]) for k in parts.dependent]),
        "independent": together([named(u[k]) for k in parts.independent]),
    }
    dead = any(isinstance(block, Formula) and _divides(block.form) for block in blocks)
    reason = lesson.say("ratios.dead" if dead else "ratios.reason")
    steps = [Step("ratios", lesson.say("ratios", **places), tuple(blocks), reason)]
    left: list[Block] = []
    for k in parts.independent:
        others = [Form.product((ratios[j, k], _rest(lesson, page, j))) for j in parts.dependent if (j, k) in ratios]
        own = lesson.scene.drives[k]
        mine = Symbol(own) if own else lesson.called(f"tau*:{k + 1}", Letter("tau", (str(k + 1),), above="*"))
        form = Form.sum((_rest(lesson, page, k, own), *others))
        if not own:
            lesson.called(mine.name, Letter("tau", (str(k + 1),), above="*"), valued(lesson, form))
        left.append(folded(lesson, Formula(mine.name, form)))
        if not own:
            left.append(lesson.say("reduced.passive", force=mine, q=named(u[k])))
    steps.append(Step("reduced", lesson.say("reduced", **places), tuple(left), lesson.say("reduced.reason")))
    return steps


def valued(lesson: Constrained, form: Form) -> Expr:
    """Return what a form in names of the lesson is worth."""
    known = {lesson.graph.symbol(key): name.node for key, name in lesson.names.items() if name.node is not None}
    return substitute([form.express(lesson.graph)], known)[0]


def _divides(form: Form) -> bool:
    """Tell whether a quotient stands in a form."""
    return any(isinstance(part, Power) and part.exponent < 0 for part in form.walk())


def _ratio(lesson: Constrained, dependent: Sequence[int], j: int, k: int) -> tuple[Expr, Form]:
    """Return ∂u_j/∂u_k by Cramer's rule from A_d u_d = -A_k u_k, on the graph and in print."""
    replaced = [k if column == j else column for column in dependent]
    nodes = [[tie.slopes[column] for column in dependent] for tie in lesson.ties]
    other = [[tie.slopes[column] for column in replaced] for tie in lesson.ties]
    node = -_determinant(other, lesson.graph.zero) / _determinant(nodes, lesson.graph.zero)
    ring, write = lesson.writer.ring, lesson.writer
    assert ring is not None, "ratios are asked for where there is a ring"
    above, below = (
        write.reduced(_determinant([[write.polynomial(x) for x in row] for row in rows], ring.zero))
        for rows in (other, nodes)
    )
    if not above:
        return node, Number.ZERO
    shared = above.gcd(below)
    above, below = ring.normal(-above / shared), ring.normal(below / shared)  # of quotients, squares of sines are left
    shapes = [(write.short(sign * above), write.short(sign * below)) for sign in (1, -1)]
    over, under = min(shapes, key=lambda x: (sum(map(len, map(text_of, x))), text_of(x[1]).startswith("-")))
    if isinstance(under, Number):
        return node, Form.product((Number(1 / under.value), over))
    return node, Form.product((over, under.power(-1)))


def _determinant(rows: Sequence[Sequence[Polynomial]], zero: Polynomial) -> Polynomial:
    """Return the determinant of a small matrix, by its first row."""
    if len(rows) == 1:
        return rows[0][0]
    total = zero
    for k, entry in enumerate(rows[0]):
        rest = [[*row[:k], *row[k + 1 :]] for row in rows[1:]]
        total = total + (entry if k % 2 == 0 else -entry) * _determinant(rest, zero)
    return total
