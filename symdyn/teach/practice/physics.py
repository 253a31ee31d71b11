"""Questions of physics about a mechanism: where it rests, how it swings, what stays, what a limit leaves.

Each is made from what the lesson computes of its scene, and asked only where there is one answer. They stand between
the equations and what follows from these, which shows the answers.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product

from symdyn import linear
from symdyn.algebra import Form, Function, Number, Pi, Ratios, Symbol
from symdyn.dynamics.mechanism import TIME, generalized_forces
from symdyn.emit.print import latex_symbols
from symdyn.errors import NoValueError
from symdyn.graph import Expr, Op, gradient, reachable, substitute
from symdyn.scene import SceneUnits
from symdyn.scene.values import force_unit
from symdyn.teach.derivations.equation_steps import coefficient_unit
from symdyn.teach.derivations.equilibria import FAULTS, QUARTERS, Rests, kind_near, places_of_rest
from symdyn.teach.derivations.forced import forced
from symdyn.teach.derivations.limits import forgotten, lightened, vanishing
from symdyn.teach.derivations.precession import shortened
from symdyn.teach.derivations.reduced import Reduced, cyclic_of, led_by, reduced, zero
from symdyn.teach.derivations.solved import short_form
from symdyn.teach.derivations.steady import force_aside, force_on, level_places
from symdyn.teach.derivations.velocities import length
from symdyn.teach.document import Blank, Block, Choice, Document, Formula, Letter, Name, Option, Words
from symdyn.teach.lesson import Lesson, Prose, named, together
from symdyn.teach.shown_state import Chosen, choose_state
from symdyn.unlocked import cached_property

PHYSICS = "physics"
"""What keys of these questions begin with."""

MOST = 8
"""Questions."""

LONGEST = 24
"""Terms and factors of a formula in a reason."""

TRIED = 12
"""Values of the parameters at which a sign must be the same."""

SLIGHT = 1e-9
"""Of the largest: no more than rounding."""

UNITS = ("kg", "kg m", "kg m²")
"""Of coefficients of inertia."""

Asked = Iterator[Choice | Blank]


class PhysicsQuestions:
    """The questions about one document; every kind yields one, or none where its answer is not one."""

    def __init__(self, document: Document) -> None:
        self.document, self.scene = document, document.scene
        self.names: dict[str, Name] = dict(document.names)
        self.prose = Prose(document.scene, document.language, self.names)
        self.steps = {step.key for section in document.sections for step in section.steps}
        self.units = SceneUnits(document.scene).coordinates

    def kinds(self) -> Iterable[Callable[[], Asked]]:
        """Return what yields questions, in their order."""
        raise NotImplementedError

    def every(self) -> Asked:
        """Yield all questions; what has no value in this scene is left out."""
        for kind in self.kinds():
            try:
                yield from list(kind())
            except (*FAULTS, KeyError, NoValueError):
                continue

    def say(self, key: str, **places: str | Form | Words) -> Words:
        """Return prose about questions."""
        return self.prose.say(f"{PHYSICS}.{key}", **places)

    def choice(self, key: str, ask: Words, options: Sequence[Option]) -> Asked:
        """Yield a question whose options hold a right one and a wrong one."""
        if len({option.right for option in options}) == 2:
            found = Choice(f"{PHYSICS}:{key}", ask, tuple(options), ())
            reasons: dict[Words, str] = {}
            for letter, option in found.lettered.items():
                reasons[option.reason] = f"{reasons.get(option.reason, '')}{letter}) "
            told = [Words((letters, *why.parts)) for why, letters in reasons.items() if why.parts]
            right = self.say("right", letters=", ".join(found.right))
            yield replace(found, solution=(right, *told))

    def blank(
        self, key: str, letter: str | Form, answer: Form, ask: str, *solution: Block, **places: str | Words | Form
    ) -> Asked:
        """Yield a question for a formula or a number; a letter is that of a quantity, which gets a name."""
        if letter == "R":  # of a reaction, where the scene has none
            letter = next((x for x in "RNFS" if x not in latex_symbols(self.scene).values()), letter)
        name, look = f"{PHYSICS}:{key}", Letter(letter if isinstance(letter, str) else "c")
        symbol = self.prose.called(name, look, answer.express(self.document.graph))
        shown = symbol if isinstance(letter, str) else letter
        told = self.say("found", left=shown, right=answer)
        hint = self.say(f"{key}.hint")
        yield Blank(name, self.say(ask, letter=shown, **places), name, shown, answer, hint, (told, *solution))

    def unit_of(self, i: int, j: int, rate: Symbol) -> Asked:
        """Yield which unit coefficient ij of inertia has, by what its product with an acceleration is."""
        key, rates = f"k_z:{i + 1},{j + 1}", SceneUnits(self.scene).velocities
        if key not in self.names or self.scene.shown_unit("kg") != "kg":
            return
        right, force = coefficient_unit("qdd", (i + 1, j + 1), [x == "m" for x in rates]), force_unit(rates[i])
        why = {one: self.say("unit.no", unit=one, rate=f"{rates[j]}/s²", force=force) for one in (*UNITS, force)}
        yield from self.units_of(right, why, self.say("unit", name=Symbol(key), i=str(i + 1), rate=rate))

    def units_of(self, right: str, why: Mapping[str, Words], ask: Words) -> Asked:
        """Yield which of some units is right, by why it is none."""
        options = [Option(Words((one,)), one == right, Words(()) if one == right else no) for one, no in why.items()]
        yield from self.choice("unit", ask, options)

    def placed(self, at: Iterable[tuple[Symbol, str | Form]]) -> Words:
        """Return a position: "q1 = 0, q2 = 0.5 rad"."""
        return Words(tuple(part for q, x in at for part in (", ", q, " = ", x))[1:])

    def value(self, k: int, x: float) -> tuple[Symbol, str]:
        """Return a coordinate and its value with its unit, as `placed` takes them."""
        return Symbol(self.scene.coordinates[k]), self.scene.in_shown_unit(self.prose.written(x), self.units[k])

    def stays(self, options: Sequence[Option], why: Words, *more: Option) -> Asked:
        """Yield what is conserved: some momenta, the energy unless `why` says why not, what stands in its place."""
        total = Form.sum((Symbol("K:"), Symbol("P:")))
        told = [*options, Option(self.say("conserved.energy", total=total), not why.parts, why), *more]
        nothing = not any(option.right for option in told)
        told.append(Option(self.say("conserved.none"), nothing, Words(()) if nothing else self.say("conserved.some")))
        yield from self.choice("conserved", self.say("conserved", several=self.say("several")), told)

    def stably(self, places: Iterable[Words], systems: Iterable[linear.Linearization]) -> Asked:
        """Yield which of some places of rest are stable."""
        options = list[Option]()
        for place, system in zip(places, systems, strict=False):
            grows = max((mode.value.real for mode in system.modes), default=0.0)
            calm = kind_near(system) not in ("unstable", "undecided")
            why = Words(()) if calm else self.say("stable.grows", rate=self.prose.written(grows))
            options.append(Option(place, calm, why))
        yield from self.choice("stable", self.say("stable.of", several=self.say("several")), options[:MOST])

    def of_sign(
        self, key: str, sign: int, why: Words, drive: Symbol, q: Symbol, at: Iterable[tuple[int, float]]
    ) -> Asked:
        """Yield which sign a drive or a force has at a position, by coordinates and their values."""
        options = [
            Option(self.say(f"sense.{one}"), way == sign, Words(()) if way == sign else why)
            for one, way in (("+", 1), ("-", -1), ("0", 0))
        ]
        ask = self.say(key, drive=drive, q=q, place=self.placed(self.value(*x) for x in at))
        yield from self.choice("sense", ask, options)

    def frequency(self, squares: Sequence[float], formulas: Sequence[Form], damped: bool, place: str) -> Asked:
        """Yield what the frequency is: a formula if it is the only one and has one, else the lowest, if in numbers."""
        found = sorted({float(f"{x:.6g}") for x in squares if x > SLIGHT * max(map(abs, squares))})
        bound = not self.scene.free_parameters
        if not found or not (bound or (len(found) == 1 and formulas)):
            return
        exact = formulas[0] if formulas and len(found) == 1 else None
        answer = Function(Op.SQRT, (exact,)) if exact is not None else _number(math.sqrt(found[0]))
        which = "one" if len(found) == 1 else "lowest"
        without = self.say("frequency.damped") if damped else Words(())
        value = self.say("frequency.value", value=self.prose.about(math.sqrt(found[0])))
        told, places = [value] if exact is not None and bound else [], {"place": self.say(place), "without": without}
        yield from self.blank("frequency", "omega", answer, f"frequency.{which}", *told, **places)

    def critical(self) -> Asked:
        """From which spin on a top stands upright."""
        steps = [step for section in self.document.sections for step in section.steps if step.key == "upright:0"]
        for block in steps[0].blocks[1:] if steps else ():
            forms = [x for x in block.parts if isinstance(x, Form)] if isinstance(block, Words) else []
            if len(forms) == 2:
                yield from self.blank("critical", forms[0], forms[1], "critical")


class OpenQuestions(PhysicsQuestions):
    """Of an open mechanism."""

    def kinds(self) -> Iterable[Callable[[], Asked]]:
        """Return what yields questions, in their order."""
        if not {"equilibria", "energy", "steady"} & self.steps:
            return [self.sense, self.reaction] if any(key.startswith("solved") for key in self.steps) else []
        first = [self.rest, self.swing, self.steady, self.critical]
        return [*first, self.conserved, self.limit, self.sense, self.unit, self.reaction]

    @cached_property
    def lesson(self) -> Lesson:
        """The mechanism on a graph of its own."""
        return Lesson(self.scene, self.document.language)

    @cached_property
    def chosen(self) -> Chosen:
        """The state of the lesson."""
        return choose_state(self.scene, self.lesson.state, self.lesson.graph)

    @cached_property
    def rests(self) -> Rests:
        """Where it rests."""
        return places_of_rest(self.lesson, self.chosen)

    @cached_property
    def left(self) -> Reduced | None:
        """The one freedom that is left, if one is."""
        return reduced(self.lesson, self.chosen)

    def written(self, node: Expr) -> Form | None:
        """Return a node as a form; None where it is long or has none."""
        form = short_form(self.lesson, node)
        return form if length(form) <= LONGEST else None

    # Rests

    def rest(self) -> Asked:
        """Where it rests, of quarter turns; and where stably, of the same. A single way has a formula."""
        q = self.rests.q
        if self.rests.why or not q:
            return
        if len(q) == 1 and self.units[self.lesson.state.q.index(q[0])] != "rad":
            yield from self._extended(q[0])
        if len(q) > 2 or any(self.units[self.lesson.state.q.index(x)] != "rad" for x in q):
            return
        places = {self._quarters(place): place for place in self.rests.places if place.exact is not None}
        every = list(product(QUARTERS, repeat=len(q)))
        wrong = [x for x in every if x not in places and self._force(x) is not None]
        picked = {*list(places)[:3], *wrong[: 5 - min(3, len(places))]} if len(q) > 1 else {*places, *wrong}
        shown = [x for x in every if x in picked]
        rest, stable = [], []
        for x in shown:
            text = self.placed(zip(map(named, q), map(_quarter, x), strict=True))
            place = places.get(x)
            against = self._force(x) if place is None else None
            why = self.say("rest.no", **against) if against else Words(())
            rest.append(Option(text, place is not None, why))
            if place is None or place.kind != "undecided":
                falls = self._falls(x) if place is not None and place.kind == "unstable" else why
                stable.append(Option(text, place is not None and place.kind == "stable", falls))
        several = self.say("several")
        yield from self.choice("rest", self.say("rest", several=several), rest)
        yield from self.choice("stable", self.say("stable", several=several), stable)

    def _extended(self, q: Expr) -> Asked:
        """Where a force that is linear in one way is zero; nothing is asked where a second one has to be zero too."""
        forces = [x for x in self.rests.forces if not zero(self.lesson, x)]
        if len(forces) != 1:
            return
        (force,) = forces
        (slope,) = gradient(force, [q])
        if q not in reachable([slope]) and not slope.is_zero:
            (least,) = substitute([force], {q: self.lesson.graph.zero})
            answer = Ratios.form_of(-least / slope)
            if answer != Number.ZERO:
                yield from self.blank("place", named(q), answer, "place")

    def _quarters(self, place: linear.Equilibrium) -> tuple[int, ...]:
        at = [float(place.q[self.lesson.state.q.index(x)]) for x in self.rests.q]
        return tuple((round(2 * x / math.pi) + 1) % 4 - 1 for x in at)

    def _at(self, quarters: Sequence[int]) -> dict[Expr, Expr]:
        forms = (_quarter(k) for k in quarters)
        return {q: form.express(self.lesson.graph) for q, form in zip(self.rests.q, forms, strict=True)}

    def _force(self, quarters: Sequence[int]) -> dict[str, Form] | None:
        """Return what is left of the forces there and of which coordinate; None where nothing surely is."""
        for q, node in zip(self.lesson.state.q, substitute(self.rests.forces, self._at(quarters)), strict=True):
            if abs(self.chosen.of(node)[0]) > SLIGHT:
                return {"q": named(q), "force": short_form(self.lesson, node)}
        return None

    def _falls(self, quarters: Sequence[int]) -> Words:
        """Return why a place is unstable: along one coordinate the force drives away, or along several together."""
        for q, force in zip(self.lesson.state.q, self.rests.forces, strict=True):
            (slope,) = substitute(gradient(force, [q]), self._at(quarters))
            form = self.written(slope)
            if form is not None and self.chosen.of(slope)[0] < 0:
                return self.say("stable.falls", q=named(q), slope=form)
        return self.say("stable.no")

    def swing(self) -> Asked:
        """Which frequency small oscillations have about the stable place, at rest or while another motion goes on."""
        stable, left = [place for place in self.rests.places if place.kind == "stable"], self.left
        if self.rests.why == "driven" and left is not None and left.couples:
            squares = [curvature / m for _, curvature, m in left.places if curvature > 0 and m > 0]
            if squares and max(squares) - min(squares) < 1e-6 * max(squares):
                yield from self.frequency(squares[:1], (), False, "frequency.steady")
        waved = forced(self.lesson) if self.rests.why == "driven" else None
        if waved is not None and len(waved.free) == 1:
            own = shortened(self.lesson, waved.K[0][0] / waved.M[0][0])
            yield from self.frequency(self.chosen.of(own.express(self.lesson.graph)), [own], True, "frequency.rest")
        if len(stable) != 1:
            return
        near = stable[0].near.of(stable[0].near.moved)
        damped = bool(abs(near.D).max() > 0)
        blocks = [block for _, block in self.document.blocks() if isinstance(block, Formula)]
        formulas = [block.form for block in blocks if block.left.startswith("near:s:omega")]
        known = [x for x in formulas if not any(":" in name for name in x.symbols)]
        if near.symmetric:
            yield from self.frequency([square for square, _ in near.modes], known, damped, "frequency.rest")

    def steady(self) -> Asked:
        """Where a coordinate stays while others go on, beside where its sine is zero, and the force on a point."""
        left = self.left
        if left is None or not left.couples:
            return
        lesson, r = self.lesson, named(left.q)
        (slope,) = gradient(left.static, [left.q])
        rates = {str(lesson.state.qd[k].value) for k in left.cyclic}
        found = [x for _, x in level_places(Ratios.form_of(slope), r, rates) if "value" in x]
        if len(found) == 1:
            others = together([named(lesson.state.q[k]) for k in (*left.cyclic, *left.led)])
            yield from self.blank("steady", found[0]["wave"], found[0]["value"], "steady", q=r, others=others)
            why = self.say("reaction.reason")
            for joint, force in force_aside(lesson, left, **found[0]):
                yield from self.blank("reaction", "R", force, "reaction.aside", why, joint=joint, q=r)

    # What stays, limits, signs, units

    def conserved(self) -> Asked:
        """What stays while no drive acts: momenta, energy, or what stays in its place."""
        lesson, acting, led = self.lesson, generalized_forces(self.scene, self.lesson.graph), led_by(self.lesson)
        cyclic, options = cyclic_of(lesson), list[Option]()
        for k, q in enumerate(lesson.state.q[:4] if len(lesson.state.q) == lesson.state.n else ()):
            why = Words(())
            if k in led:
                why = self.say("conserved.led", q=named(q))
            elif k not in cyclic:
                slope = self.written(lesson.slopes[k])
                key = "conserved.slope" if slope is None else "conserved.slope.is"
                why = self.say(key, q=named(q), slope=slope or "")
            elif not acting[k].is_zero:
                why = self.say("conserved.force", q=named(q))
            options.append(Option(self.say("conserved.momentum", q=named(q)), not why.parts, why))
        some = [named(q) for q, force in zip(lesson.state.q, acting, strict=False) if not force.is_zero]
        timed = lesson.graph.symbol(TIME) in reachable([lesson.L, *acting])
        why = self.say("conserved.work") if led else self.say("conserved.timed") if timed else Words(())
        why = self.say("conserved.spent", names=together(some)) if some and not why.parts else why
        stays = [b.form for _, b in self.document.blocks() if led and isinstance(b, Formula) and b.left == "h:"]
        more = (Option(Words((one,)), True, self.say("conserved.jacobi")) for one in stays[:1])
        yield from self.stays(options, why, *more)

    def limit(self) -> Asked:
        """What is left as one parameter vanishes: the first that takes a body, or a coordinate, away; then a spring."""
        lesson = self.lesson
        found = [({how: x for x, how in lightened(lesson, one)}, one) for one in vanishing(lesson) if one.of_energies]
        coordinates, keys = [named(q) for q in lesson.state.q[:3]], {"limit", "limit.spring"}
        for gone, one in sorted(found, key=lambda x: ("unsprung" in x[0], "smaller" not in x[0])):
            key, (idle, cyclic) = "limit.spring" if "unsprung" in gone else "limit", forgotten(lesson, one)
            left = [how for how in ("smaller", "unsprung") if how in gone]
            options = [Option(self.say(f"limit.{how}", body=gone[how]), True, Words(())) for how in left]
            for q in coordinates:
                why = Words(()) if q in idle else self.say("limit.idle.no", q=q)
                options.append(Option(self.say("limit.idle", q=q), q in idle, why))
            for q in coordinates:
                before = zero(lesson, lesson.slopes[coordinates.index(q)])
                if q not in idle and not before:
                    why = Words(()) if q in cyclic else self.say("limit.cyclic.no", q=q)
                    options.append(Option(self.say("limit.cyclic", q=q), q in cyclic, why))
            ask = self.say("limit", m=one.letters, several=self.say("several"))
            if key in keys and (asked := list(self.choice(key, ask, options))):
                yield from asked
                keys.remove(key)

    def sense(self) -> Asked:
        """Which sign a drive has that holds the mechanism at rest, or what gravity and springs do to a coordinate."""
        lesson, scene = self.lesson, self.scene
        if self.rests.why == "driven":
            return
        matter = reachable(list(self.rests.forces))
        every = list(enumerate(self.chosen.q))
        at = [(k, x) for k, x in every if lesson.state.q[k] in matter] or every
        for k, q in enumerate(lesson.state.q if len(lesson.state.q) == lesson.state.n else ()):
            force = self.rests.forces[k]
            signs = {self._sign(force, seed) for seed in range(TRIED if scene.free_parameters else 1)}
            if len(signs) != 1 or 0 in signs:
                continue
            (sign,), drive = signs, scene.drives[k]
            form = self.written(force)
            told = self.say("sense.long") if form is None else Words((form if drive else form.negative,))
            key = "sense.drive" if drive else "sense.passive"
            sign = sign if drive else -sign
            why = self.say("sense.reason", force=told, sign=self.say(f"sense.{'+' if sign > 0 else '-'}"))
            yield from self.of_sign(key, sign, why, Symbol(drive or str(q.value)), named(q), at)
            return

    def _sign(self, node: Expr, seed: int) -> int:
        """Return the sign of a force at the position of the lesson; after the first seed with other parameters."""
        rest = dict.fromkeys(self.lesson.state.qd, 0.0)
        draw = random.Random(seed)
        free = {self.lesson.graph.symbol(p.name): draw.uniform(0.3, 3.0) for p in self.scene.free_parameters}
        (value,) = self.chosen.with_values(rest | (free if seed else {})).of(node)
        return 0 if abs(value) < SLIGHT else 1 if value > 0 else -1

    def unit(self) -> Asked:
        """Which unit a coefficient of inertia has, by what its product with an acceleration is."""
        lesson = self.lesson
        pairs = [(i, j) for i in range(lesson.state.n) for j in range(i + 1, lesson.state.n)] or [(0, 0)]
        M = [gradient(p, lesson.state.qd) for p in lesson.momenta]
        pair = next(((i, j) for i, j in pairs if not zero(lesson, M[i][j])), (0, 0))
        yield from self.unit_of(*pair, named(lesson.state.qdd[pair[1]]))

    def reaction(self) -> Asked:
        """How large the force in the hinge is as the mechanism of one freedom passes its stable place."""
        lesson = self.lesson
        stable = [x for x in self.rests.places if x.kind == "stable" and x.exact is not None]
        if lesson.state.n != 1 or self.units != ("rad",) or len(stable) != 1 or self.scene.elements:
            return
        at = self._at(self._quarters(stable[0])) | dict.fromkeys(lesson.state.qdd, lesson.graph.zero)
        if not zero(lesson, substitute(lesson.drives, at)[0]):  # it is accelerated there
            return
        parts = [x for x in substitute(force_on(lesson, lesson.masses), at) if not zero(lesson, x)]
        if len(parts) == 1:
            form = short_form(lesson, parts[0])
            form = form.negative if self.chosen.of(parts[0])[0] < 0 else form
            joint, turn = self.scene.moving[0].name, Symbol(self.scene.velocities[0])
            why = self.say("reaction.reason")
            yield from self.blank("reaction", "R", form, "reaction", why, joint=joint, rate=turn)


def _quarter(k: int) -> Form:
    return Form.product((Number(Fraction(k, 2)), Pi())) if k else Number.ZERO


def _number(value: float) -> Form:
    """Return a number of six digits, which is more than anyone is asked for."""
    return Number(Fraction(f"{value:.6g}"))
