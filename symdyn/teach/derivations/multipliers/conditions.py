"""Steps: what ties the coordinates, differentiated once and twice; the slopes of all conditions as one matrix."""

from __future__ import annotations

from symdyn.algebra import Form, Power, Symbol
from symdyn.graph import Expr
from symdyn.teach.derivations.lagrange.velocities import folded
from symdyn.teach.derivations.multipliers.condition import Condition
from symdyn.teach.derivations.multipliers.constrained import Constrained
from symdyn.teach.document import Block, Formula, Matrix, Step, Words
from symdyn.teach.lesson import named, together

WIDEST = 8
"""Velocities up to which all slopes are shown as one matrix."""


def name_ties(lesson: Constrained) -> None:
    """Name every condition, its derivatives and its slopes, each with its value on the graph."""
    graph, state = lesson.graph, lesson.state
    for tie in lesson.ties:
        letter, k = ("c" if tie.residual is None else "f"), tie.number
        if tie.residual is not None:
            lesson.name(tie.key, letter, k, node=tie.residual)
        along = graph.total(a * u for a, u in zip(tie.slopes, state.qd, strict=True))
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
        kind = "integrable" if lesson.integrable else "slip"
        reason = lesson.say(f"ties.{kind}.reason")
        steps.append(Step("ties.slip", lesson.say(f"ties.{kind}", names=slips), (), reason))
    steps.append(_accelerations(lesson))
    if n <= WIDEST:
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
    claim = lesson.say(key, owner=first.owner, parent=lesson.body(first.parent), child=lesson.body(first.child))
    reason = lesson.say("ties.loop.reason") if first.loop and first.words == "tie.force" else Words(())
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
    """Return the matrix of all A_ki."""
    lesson.name("A:", "J", node=None)
    cells = [(slope(lesson, tie, i), f"A:{tie.number},{i + 1}") for tie in lesson.ties for i in range(lesson.state.n)]
    forms, names = zip(*cells, strict=True)
    matrix = Matrix("A:", tuple(forms), tuple(names), width=lesson.state.n)
    columns = together([named(u) for u in lesson.state.qd])
    return Step("ties.matrix", lesson.say("ties.matrix", columns=columns), (matrix,), lesson.say("ties.matrix.reason"))


def _all(names: list[Symbol]) -> Words:
    """Return "f_1 = f_2 = 0" as prose."""
    return Words((*(part for name in names for part in (name, " = ")), "0"))
