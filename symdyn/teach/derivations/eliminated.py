"""Steps: the equations of motion of a tied mechanism without multipliers and without dependent rates; what stays.

With u_d = Y u, the equation of an independent velocity k is E_k + Σ Y_jk E_j = 0, in which u_d and its derivative are
put in; and the dependent coordinates, where their closed forms hold no root. Where it is the derivative of
p_k + Σ Y_jk p_j, that momentum is conserved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.algebra import Form, Number, Ratios, Symbol
from symdyn.dynamics.mechanism import TIME, generalized_forces
from symdyn.frozen import dataclass
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute, tangents
from symdyn.teach.derivations.constrained import Constrained
from symdyn.teach.derivations.multiplier_steps import meaning, multiplier, valued
from symdyn.teach.derivations.precession import NO_FORM, shortened
from symdyn.teach.derivations.solved import (
    LONGEST,
    NO_SHORT_FORM,
    accelerations,
    motions_put_in,
    signs_told,
    with_entries,
)
from symdyn.teach.derivations.solved_ties import closed_positions
from symdyn.teach.derivations.velocities import length
from symdyn.teach.document import Block, Formula, Section, Step, Words
from symdyn.teach.lesson import named, together
from symdyn.teach.shown_state import Chosen

SMALL = 1e-9
"""N or N m: forces that are none."""


def eliminated_steps(lesson: Constrained, chosen: Chosen) -> list[Step]:
    """Return the equations with dependent rates put in, and solved where that is short; none without their ratios."""
    if not _ratios(lesson):
        return []
    put, blocks, long = PutIn.of(lesson), list[Block](), list[Form]()
    for k in lesson.partition.independent:
        own = lesson.scene.drives[k]
        right: Form = Symbol(own) if own else Number.ZERO
        form = _sorted(lesson, put.equation(k))
        if form is None or length(form) > LONGEST:
            long.append(right if own else named(lesson.state.qdd[k]))
        else:
            blocks.append(Formula("", form, right=right))
    if not blocks:
        return [Step("eliminated", lesson.say("eliminated.long", names=together(long)), ())]
    if long:
        blocks.append(lesson.say("eliminated.long", names=together(long)))
    symbols = lesson.state.q if put.positions else lesson.state.qd
    dependent, free = (
        together([named(symbols[k]) for k in some])
        for some in (lesson.partition.dependent, lesson.partition.independent)
    )
    key = "eliminated.closed" if put.positions else "eliminated"
    claim = lesson.say(key, dependent=dependent, independent=free)
    step = Step("eliminated", claim, tuple(blocks), lesson.say("eliminated.reason"))
    return [step, *([] if long else _solved(lesson, put, chosen))]


def conserved_sections(lesson: Constrained) -> list[Section]:
    """Return what is conserved: momenta along independent velocities, and the energy."""
    steps = list[Step]()
    if _ratios(lesson):
        put = PutIn.of(lesson)
        for k in lesson.partition.independent:
            p = put.together(k, gradient(lesson.energy.K, lesson.state.qd))
            (rate,) = put.into(tangents([p], lesson.state.acceleration))
            form = _sorted(lesson, p)
            if form is None or not form.terms or length(form) > LONGEST:
                continue
            if _same(rate, put.equation(k)):
                own, q = lesson.scene.drives[k], named(lesson.state.qd[k])
                key = "eliminated.momentum.driven" if own else "eliminated.momentum"
                claim = lesson.say(key, q=q, momentum=form, **({"drive": Symbol(own)} if own else {}))
                steps.append(Step(f"conserved:{k + 1}", claim, (), lesson.say("eliminated.momentum.reason")))
    acting = generalized_forces(lesson.scene, lesson.graph)
    moved = reachable([lesson.L, *(x for tie in lesson.ties for x in tie.nodes)])
    timed = lesson.scene.prescribed_velocities or lesson.graph.symbol(TIME) in moved
    if not timed and all(x.is_zero for x in acting):
        total = Form.sum((Symbol("K:"), Symbol("P:")))
        steps.append(Step("energy", lesson.say("energy.kept", total=total), (), lesson.say("eliminated.energy.reason")))
    return [lesson.section("after.conserved", steps)] if steps else []


def _ratios(lesson: Constrained) -> bool:
    """Tell whether ratios of dependent to independent velocities were written out."""
    return any(key.startswith("Y:") for key in lesson.names)


def _ratio(lesson: Constrained, j: int, k: int) -> Expr:
    name = lesson.names.get(f"Y:{j + 1},{k + 1}")
    return lesson.graph.zero if name is None or name.node is None else name.node


@dataclass(frozen=True)
class PutIn:
    """What is put into equations.

    Attributes:
        ratios: Y_jk of dependent velocities j and independent ones k.
        positions: dependent coordinates, and waves of them, by the others; none where they have no such form.
        rates: dependent rates and their derivatives by those of the independent ones.
    """

    lesson: Constrained
    ratios: Mapping[tuple[int, int], Expr]
    positions: Mapping[Expr, Expr]
    rates: Mapping[Expr, Expr]

    @classmethod
    def of(cls, lesson: Constrained) -> PutIn:
        """Return what is put into the equations of a lesson."""
        state, graph, parts = lesson.state, lesson.graph, lesson.partition
        places = [(j, k) for j in parts.dependent for k in parts.independent]
        positions = closed_positions(lesson, parts.dependent) if len(state.q) == state.n else {}
        ratios = {
            (j, k): gradient(positions[state.q[j]], [state.q[k]])[0] if positions else _ratio(lesson, j, k)
            for j, k in places
        }
        rates = [graph.total(ratios[j, k] * state.qd[k] for k in parts.independent) for j in parts.dependent]
        put = dict(zip((state.qd[j] for j in parts.dependent), rates, strict=True))
        faster = substitute(tangents(rates, state.acceleration), put)
        put |= dict(zip((state.qdd[j] for j in parts.dependent), faster, strict=True))
        return cls(lesson, ratios, positions, put)

    def into(self, nodes: Sequence[Expr]) -> list[Expr]:
        """Return nodes with rates put in, and coordinates."""
        return list(substitute(substitute(nodes, self.rates), self.positions))

    def together(self, k: int, nodes: Sequence[Expr]) -> Expr:
        """Return what belongs to velocity k, and to the dependent ones times their ratios, with those put in."""
        others = (self.ratios[j, k] * nodes[j] for j in self.lesson.partition.dependent)
        return self.into([nodes[k] + self.lesson.graph.total(others)])[0]

    def equation(self, k: int) -> Expr:
        """Return what is equal to the drive of velocity k, or zero without one."""
        given = list(self.lesson.drives)
        for j in self.lesson.partition.dependent:
            if own := self.lesson.scene.drives[j]:
                given[j] = given[j] - self.lesson.graph.symbol(own)
        return self.together(k, given)


def _sorted(lesson: Constrained, node: Expr) -> Form | None:
    """Return a node sorted by accelerations, then rates; None where it has no short form."""
    state, graph = lesson.state, lesson.graph
    linear = state.qd if all(x.is_zero for x in gradient(node, state.qdd)) else state.qdd
    terms: list[Form] = []
    try:
        for x in linear:
            (slope,) = gradient(node, [x])
            if (shown := shortened(lesson, slope)).terms:
                terms.append(shown.signed_product(named(x)))
        (rest,) = substitute([node], dict.fromkeys(linear, graph.zero))
        return Form.sum((*terms, *shortened(lesson, rest).terms))
    except NO_SHORT_FORM:
        return None


def _same(a: Expr, b: Expr) -> bool:
    """Tell whether two nodes are the same function; False where that cannot be decided."""
    try:
        field = Ratios([difference := a - b])
        return evaluate([difference], field, field.values())[0].is_zero
    except NO_FORM:
        return False


# Solved


def _solved(lesson: Constrained, put: PutIn, chosen: Chosen) -> list[Step]:
    """Return accelerations, and with them put in the multipliers, as far as they have a short form."""
    state, every, motions = lesson.state, lesson.partition.independent, motions_put_in(lesson)
    led = lesson.scene.prescribed_velocities
    told = {k: node for k, node in zip(every, _told(lesson, put), strict=True) if k not in led}
    free = list(told)
    if not free or not set(led) <= set(every):
        return []
    found = accelerations(lesson, substitute(list(told.values()), motions), free, chosen)
    if found is None:
        return []
    blocks, forms = found
    solved = with_entries(lesson, [form.express(lesson.graph) for form in forms])
    known = dict(zip((state.qdd[k] for k in free), solved, strict=True))

    def written(node: Expr) -> Form | None:
        return _written(lesson, substitute(substitute([node], known), motions)[0])

    for j in lesson.partition.dependent:
        if (form := written(put.rates[state.qdd[j]])) is not None:
            same = next((x for x, one in zip(free, forms, strict=True) if one == form), None)
            blocks.append(Formula("", named(state.qdd[j]), right=form if same is None else named(state.qdd[same])))
    claim = lesson.say("eliminated.led" if led else "eliminated.solved", led=together([named(state.q[k]) for k in led]))
    held = {named(x).name for k in lesson.partition.dependent for x in (state.q[k], state.qd[k])}
    alone = held.isdisjoint(forms[0].symbols)
    reason = Words(signs_told(lesson, free, forms, chosen)) if alone else lesson.say("explicit.signs")
    steps = [Step("eliminated:solved", claim, tuple(blocks), reason)]
    exerted = list[Block]()
    for k in led:
        if (own := lesson.scene.drives[k]) and (form := written(put.equation(k))) is not None:
            exerted.append(Formula("", Symbol(own), right=form))
    for tie in lesson.ties:
        if (form := written(put.into([valued(lesson, multiplier(tie))])[0])) is not None:
            said = lesson.say("eliminated.meaning", name=multiplier(tie), meaning=meaning(lesson, tie))
            exerted += [Formula("", multiplier(tie), right=form), said]
    if exerted:
        claim = lesson.say("eliminated.forces.led" if led else "eliminated.forces")
        steps.append(Step("eliminated:forces", claim, tuple(exerted), show=("reactions",)))
    return steps


def _written(lesson: Constrained, node: Expr) -> Form | None:
    """Return a quotient in print; None where it is not short."""
    try:
        return shortened(lesson, node)
    except NO_FORM:
        return None


def _told(lesson: Constrained, put: PutIn) -> list[Expr]:
    """Return what vanishes in a motion, a node each independent velocity."""
    graph, drives = lesson.graph, lesson.scene.drives
    own = {k: graph.zero if (drive := drives[k]) is None else graph.symbol(drive) for k in lesson.partition.independent}
    return [put.equation(k) - force for k, force in own.items()]


def resting_step(lesson: Constrained, chosen: Chosen) -> Step | None:
    """Return that it rests nowhere or everywhere, where no position changes what acts at rest; None elsewhere."""
    state, graph = lesson.state, lesson.graph
    if not _ratios(lesson) or lesson.scene.prescribed_velocities:
        return None
    drives = [graph.symbol(own) for own in lesson.scene.drives if own]
    still = dict.fromkeys((*state.qd, *state.qdd, *drives), graph.zero)
    forces = substitute(_told(lesson, PutIn.of(lesson)), still)
    forms = [form for x in forces if (form := _written(lesson, x)) is not None]
    moving = {str(x.value) for x in (*state.q, graph.symbol(TIME))}
    if len(forms) < len(forces) or any(moving.intersection(form.symbols) for form in forms):
        return None
    shown = [Formula("", form, right=Number.ZERO) for form in forms if form.terms]
    key = "tied.everywhere" if all(abs(x) < SMALL for x in chosen.of(*forces)) else "tied.nowhere"
    blocks: list[Block] = (
        [lesson.say("tied.level"), *shown, lesson.say(key)] if shown else [lesson.say("equilibria.all")]
    )
    return Step("equilibria", lesson.say("equilibria"), tuple(blocks), show=("weights", "forces"))
