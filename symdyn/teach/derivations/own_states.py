"""Steps on states that a scene has of its own, a current or a pressure: their rates, where all rests, stored energy.

A lesson takes them as parameters, at one moment. With them it rests where q̇ = 0 and every rate vanishes; a state that
its rate holds linearly is put into the equation of the coordinate.

A force c x along a velocity u and the term -(c/Λ) u in ẋ take and give the same power where ½ Λ x² is the energy of x,
that of a coil or of a spring. Then d/dt (E + ½ Λ x²) is what sources give and losses take.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symdyn.algebra import Form, Ratios, Symbol
from symdyn.dynamics.mechanism import TIME, generalized_forces
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, gradient, reachable, substitute
from symdyn.scene import Scene
from symdyn.table import Table
from symdyn.teach.derivations.equilibria import closed_sections
from symdyn.teach.derivations.lagrange import task_step
from symdyn.teach.derivations.precession import NO_FORM, lowest, shortened
from symdyn.teach.derivations.steady import level_places, plain
from symdyn.teach.derivations.velocities import folded
from symdyn.teach.document import Block, Document, Formula, Letter, Section, Step
from symdyn.teach.lesson import Lesson, Prose, named, together
from symdyn.teach.shown_state import Chosen, choose_state


def with_states(document: Document, declared: Scene) -> Document:
    """Return a lesson with the rates of states, without what holds for states that stay as they are.

    Args:
        document: of the scene with its states as parameters.
        declared: the scene with its states.
    """
    prose, states = Prose(document.scene, document.language, dict(document.names)), declared.states
    names = together([Symbol(one.name) for one in states])
    nodes = [one.rate.express(document.graph) for one in states]
    rates = [prose.rate(one.name, node) for one, node in zip(states, nodes, strict=True)]
    blocks = [folded(prose, Formula(x.name, Form.of(node))) for x, node in zip(rates, nodes, strict=True)]
    step = Step("states", prose.say("states", names=names), tuple(blocks), prose.say("states.reason", names=names))
    first, *others = [one for one in document.sections if not one.key.startswith("after.")]
    if document.formulation == "lagrange":
        lesson = Lesson(document.scene, document.language, prose.names, graph=document.graph)
        chosen = choose_state(lesson.scene, lesson.state, lesson.graph)
        both = Stateful(lesson, declared, tuple(lesson.graph.symbol(one.name) for one in states), tuple(nodes), chosen)
        first = replace(first, steps=tuple(both.task() if one.key == "task" else one for one in first.steps))
        others = [
            new for one in others for new in ([*both.rests(), both.numbers(one)] if one.key == "numbers" else [one])
        ]
    sections = (first, prose.section("states", [step]), *others)
    return replace(document, sections=sections, names=prose.names, declared=declared)


@dataclass(frozen=True)
class Stateful:
    """An open mechanism and its own states."""

    lesson: Lesson
    declared: Scene
    x: tuple[Expr, ...]  # the states, as symbols
    rates: tuple[Expr, ...]  # ẋ
    chosen: Chosen

    @property
    def forces(self) -> Sequence[Expr]:
        """What acts beside drives and potential energy, along every velocity."""
        return generalized_forces(self.lesson.scene, self.lesson.graph)

    def task(self) -> Step:
        """Return what is known and wanted: states are neither; they drive coordinates."""
        lesson = self.lesson
        known = tuple(one for one in lesson.scene.parameters if lesson.graph.symbol(one.name) not in self.x)
        shown = Lesson(replace(lesson.scene, parameters=known), lesson.language, lesson.names, graph=lesson.graph)
        step = task_step(shown)
        used = reachable(self.forces)
        led = [named(q) for q, force in zip(lesson.state.q, self.forces, strict=True) if self._holds_states(force)]
        names = together([named(x) for x in self.x if x in used])
        said = lesson.say("task.states", names=names, coordinates=together(led))
        return replace(step, blocks=(*step.blocks, said)) if led else step

    def _holds_states(self, node: Expr) -> bool:
        return bool(set(self.x).intersection(reachable([node])))

    def rests(self) -> list[Section]:
        """Return where mechanism and states rest together: what follows in letters, and places in numbers."""
        lesson = self.lesson
        found = closed_sections(Prose(self.declared.in_language(lesson.language), lesson.language, lesson.names))
        blocks = list(self._letters()) if found else []
        if not blocks:
            return found
        step = Step("states:rest", lesson.say("states.rest"), tuple(blocks), lesson.say("states.rest.reason"))
        return [lesson.section("after.rests", [step, *(one for section in found for one in section.steps)])]

    def _letters(self) -> Iterator[Block]:
        """Yield states at rest, and the angle at which their force holds the weights."""
        lesson, state = self.lesson, self.lesson.state
        still = dict.fromkeys(state.qd, lesson.graph.zero)
        put, left = dict[Expr, Expr](), substitute(self.rates, still)
        moved = {*self.x, *state.q}
        while one := next((one for node in left if (one := _linear(node, self.x, moved)) is not None), None):
            x, value = one
            put[x] = value
            left = substitute(left, {x: value})
            yield Formula("", named(x), right=Ratios.form_of(value))
        acting = substitute(substitute(self.forces, still), put)
        slopes = [a - b for a, b in zip(gradient(lesson.energy.P, state.q), acting, strict=True)]
        if len(slopes) != 1 or self._holds_states(slopes[0]):
            return
        try:
            level = Ratios.form_of(slopes[0])
            for key, places in level_places(level, named(state.q[0]), frozenset()):
                if key == "steady.wave":
                    (number,) = self.chosen.of(places["value"].express(lesson.graph))
                    shown = {"wave": places["wave"], "value": plain(lesson, places["value"], level)}
                    yield lesson.say("states.wave", **shown, number=lesson.equals(number))
        except NO_FORM:
            return

    def numbers(self, section: Section) -> Section:
        """Return the section with rates of states in the table of the state, and the energy that states store."""
        return replace(section, steps=(*map(self._with_rates, section.steps), *self._matter(), *self._energy()))

    def _with_rates(self, step: Step) -> Step:
        if step.key != "state":
            return step
        lesson, units = self.lesson, [f"{one.unit}/s" for one in self.declared.states]
        values = zip(self.x, map(lesson.written, self.chosen.of(*self.rates)), units, strict=True)
        more = lesson.table(("symbol", "value", "unit"), [(Symbol(f"d/dt {x.value}"), *row) for x, *row in values])
        table, *rest = step.blocks
        assert isinstance(table, Table), "a state is a table"
        reason = lesson.say("states.chosen", names=together(list(map(named, self.x))))
        return replace(step, blocks=(replace(table, rows=(*table.rows, *more.rows)), *rest), reason=reason)

    def _matter(self) -> Iterator[Step]:
        """Yield what the energy changes by because states, such as a mass, stand in it."""
        lesson, total = self.lesson, self.lesson.energy.K + self.lesson.energy.P
        pairs = zip(gradient(total, self.x), self.rates, strict=True)
        held = {x: rate * slope for x, (slope, rate) in zip(self.x, pairs, strict=True) if not slope.is_zero}
        if held:
            power = lesson.graph.total(held.values())
            names, value = together(list(map(named, held))), lesson.written(*self.chosen.of(power))
            claim = lesson.say("states.matter", names=names, total=Symbol("E:"), value=value)
            symbol = lesson.called("E:matter", Letter("W", ("m",)), power)
            yield Step("states:matter", claim, (Formula(symbol.name, Form.of(power)),), show=("energies",))

    def _energy(self) -> Iterator[Step]:
        """Yield the energy of every state whose force and rate exchange power."""
        lesson, state, forces = self.lesson, self.lesson.state, self.forces
        moving = {*self.x, *state.q, *state.qd, lesson.graph.symbol(TIME)}
        stored, told = list[Expr](), list[Expr]()
        for x, rate in zip(self.x, self.rates, strict=True):
            given, taken = [gradient(force, [x])[0] for force in forces], gradient(rate, state.qd)
            pairs = [pair for pair in zip(given, taken, strict=True) if not all(one.is_zero for one in pair)]
            if not pairs or any(one.is_zero for pair in pairs for one in pair):
                continue
            first, *others = (_lowest(-c / e) for c, e in pairs)
            if not moving.intersection(reachable([first])) and all(_lowest(first - one).is_zero for one in others):
                stored.append(first * x**2 / 2)
                told.append(x)
        if not stored:
            return
        energy = lesson.graph.total(stored)
        every = lesson.energy.K + lesson.energy.P + energy
        power = lesson.graph.total(
            [
                *(force * u for force, u in zip(forces, state.qd, strict=True)),
                *(gradient(every, [x])[0] * rate for x, rate in zip(self.x, self.rates, strict=True)),
            ]
        )
        try:
            form = shortened(lesson, lowest(power))
            whole = lesson.called("E:states", Letter("E", above="*"), every)
            shown = shortened(lesson, energy)
        except NO_FORM:
            return
        change = lesson.rate(whole.name, power)
        blocks = (Formula(whole.name, Form.sum((Symbol("E:"), *shown.terms))), Formula(change.name, form))
        names = together(list(map(named, told)))
        claim = lesson.say("states.energy", energy=shown, names=names)
        yield Step("states:energy", claim, blocks, lesson.say("states.energy.reason", names=names), show=("energies",))


def _lowest(node: Expr) -> Expr:
    """Return a quotient in lowest terms, as it is where it has none."""
    try:
        return lowest(node)
    except NO_FORM:
        return node


def _linear(node: Expr, unknown: Sequence[Expr], moving: set[Expr]) -> tuple[Expr, Expr] | None:
    """Return a state and its value where a rate is linear in it, and holds nothing else that moves; None elsewhere."""
    for x in unknown:
        (slope,) = gradient(node, [x])
        if not slope.is_zero and not moving.intersection(reachable([slope])):
            (rest,) = substitute([node], {x: node.graph.zero})
            value = _lowest(-rest / slope)
            if not moving.intersection(reachable([value])):
                return x, value
    return None
