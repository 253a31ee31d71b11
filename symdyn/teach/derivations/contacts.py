"""Steps on contacts: gaps and slips, Delassus' numbers, the impact as percussion.

    g, ġ = n u, s = t u
    M (u⁺ - u⁻) = nᵀ Λn + tᵀ Λt,   D = W M⁻¹ Wᵀ,   W the rows n and t

Everything is in closed form for a contact that strikes alone.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5, 6 and 8.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from symdyn.algebra import Form, Number, Symbol
from symdyn.dynamics.outputs import Touch
from symdyn.emit.print import latex_symbols, percussions
from symdyn.frozen import dataclass
from symdyn.graph import Expr, gradient
from symdyn.teach.derivations.precession import NO_FORM, shortened
from symdyn.teach.derivations.solved import Quotients, quotient
from symdyn.teach.derivations.velocities import folded
from symdyn.teach.document import Block, Formula, Letter, Step, Words
from symdyn.teach.lesson import Lesson
from symdyn.teach.shown_state import Chosen
from symdyn.unlocked import cached_property

ONE, MINUS = Number.ONE, Number.MINUS_ONE


@dataclass(frozen=True)
class Struck:
    """One contact in a lesson, with its number where there are several."""

    lesson: Lesson
    touch: Touch
    number: str
    chosen: Chosen

    @property
    def name(self) -> str:
        """What the scene calls it."""
        return self.touch.law.name

    @property
    def has_friction(self) -> bool:
        """Whether friction acts along one direction, or two."""
        return bool(self.touch.tangents)

    @property
    def is_tied(self) -> bool:
        """Whether gap and slip are too many for the freedoms that there are, so that D has no inverse."""
        return len(self.touch.rows) > self.lesson.state.n

    @property
    def kind(self) -> tuple[bool, int, str]:
        """What has the same steps: of a second one a brief lesson has them folded."""
        return self.touch.normal is None, len(self.touch.tangents), self.touch.law.law

    def node(self, x: Expr) -> Expr:
        """Return a node on the graph of the lesson."""
        return Form.of(x).express(self.lesson.graph)

    @cached_property
    def rows(self) -> list[list[Expr]]:
        """W: n, where there is one, and each t along which friction acts."""
        return [[self.node(x) for x in row.entries] for row in self.touch.rows]

    @cached_property
    def speeds(self) -> list[Expr]:
        """W u: ġ, where there is a gap, and s."""
        u = self.lesson.state.qd
        return [self.lesson.graph.dot(row, u) for row in self.rows]

    def letter(self, key: str, letter: str, index: str = "", node: Expr | None = None, dots: int = 0) -> Symbol:
        """Name a quantity of this contact."""
        below = tuple(part for part in (index, self.number) if part)
        return self.lesson.called(f"{key}:{self.number}", Letter(letter, below, dots), node)

    @cached_property
    def v(self) -> list[Symbol]:
        """The symbols of ġ and s; of slips along two directions s has an index."""
        found, ways = list[Symbol](), "xy" if len(self.touch.tangents) > 1 else ("",)
        if self.touch.normal is not None:
            found.append(self.letter("gap.rate", "g", "", self.speeds[0], 1))
        rest = self.speeds[len(found) :]
        return [*found, *(self.letter(f"slip{way}", "s", way, x) for way, x in zip(ways, rest, strict=False))]

    def rates(self) -> Step:
        """Return its gap and what it changes by."""
        lesson, blocks = self.lesson, list[Block]()
        if self.touch.normal is not None and not self.touch.law.at_rates:
            gap = self.node(self.touch.gap)
            blocks.append(_written(lesson, self.letter("gap", "g", "", gap), gap))
        blocks += [_written(lesson, symbol, x) for symbol, x in zip(self.v, self.speeds, strict=True)]
        key = "dry" if self.touch.normal is None else "slips" if self.has_friction else "gap"
        key = "contacts.one_way" if self.touch.law.at_rates else f"contacts.{key}"
        said = lesson.once("contacts.before.dry" if self.touch.normal is None else "contacts.before")
        return Step(f"contacts:rates:{self.name}", lesson.say(key, contact=self.name), tuple(blocks), said)

    # Impact

    @cached_property
    def columns(self) -> tuple[list[list[Form]], list[list[Form]]] | None:
        """M⁻¹ Wᵀ by row of W, and D, in print; None where they are too long to read."""
        lesson = self.lesson
        M = [gradient(p, lesson.state.qd) for p in lesson.momenta]
        try:
            write = Quotients(lesson, [x for row in (*M, *self.rows) for x in row])
            known = [[write.known[x] for x in row] for row in self.rows]
            sides = write.field.solved([[write.known[x] for x in row] for row in M], list(zip(*known, strict=True)))
            D = write.field.product(known, sides)
            columns = [[quotient(*write.parts(x)) for x in row] for row in zip(*sides, strict=True)]
            return columns, [
                [shortened(lesson, quotient(*write.parts(x)).express(lesson.graph)) for x in row] for row in D
            ]
        except NO_FORM:
            return None

    @cached_property
    def D(self) -> list[list[Form]]:
        """The symbols of Delassus' numbers, zero where one is."""
        assert self.columns is not None, "asked for where there are forms"
        _, forms = self.columns
        found = list[list[Form]]()
        for i, row in enumerate(forms):
            found.append([])
            for j, form in enumerate(row):
                index, node = "".join(sorted("nt"[k] for k in (i, j))), form.express(self.lesson.graph)
                symbol = self.letter(f"D{index}", "D", index if self.has_friction else "", node)
                found[-1].append(symbol if form.terms else Number.ZERO)
        return found

    def impact(self) -> Iterator[Step]:
        """Yield what it feels, and its impact in closed form; nothing of dry friction, which strikes nothing."""
        lesson = self.lesson
        if self.touch.normal is None or (self.columns is not None and not self.columns[1][0][0].terms):
            return
        if len(self.touch.tangents) > 1 or self.columns is None or self.is_tied:
            ways = len(self.touch.tangents)
            key = "contacts.two" if ways > 1 else "contacts.tied" if self.is_tied else "contacts.long"
            yield Step(f"contacts:impact:{self.name}", lesson.say(key, contact=self.name), self._percussion())
            return
        pairs = [(i, j) for i in range(len(self.D)) for j in range(i, len(self.D))]
        shown = [
            folded(lesson, Formula(x.name, self.columns[1][i][j]))
            for i, j in pairs
            if isinstance(x := self.D[i][j], Symbol)
        ]
        key = "contacts.delassus.friction" if self.has_friction else "contacts.delassus"
        W = "W" if self.has_friction else "n"
        row, turned = (lesson.called(f"rows{above}:", Letter(W, above=above)) for above in ("", "T"))
        product = Form.product((row, lesson.called("inverse:", Letter("M", above="-1")), turned))
        claim = lesson.say(key, contact=self.name, D=self.D[0][0], product=product, rows=row, rate=self.v[0])
        turns = ".turns" if self.touch.unit == "rad" else ""
        said = lesson.say(f"contacts.delassus.reason{turns}", feels=self.D[0][0].power(-1))
        yield Step(f"contacts:delassus:{self.name}", claim, tuple(shown), said)
        claim = lesson.say("contacts.impact", contact=self.name)
        yield Step(f"contacts:impact:{self.name}", claim, self._percussion(), lesson.once("contacts.impact.reason"))
        yield self._rough() if self.has_friction else self._smooth()

    @cached_property
    def e(self) -> Form:
        """The coefficient of restitution."""
        return Form.of(self.touch.restitution)

    @cached_property
    def more(self) -> Form:
        """1 + e."""
        return Number(1 + self.e.value) if isinstance(self.e, Number) else Form.sum((self.e, ONE))

    @cached_property
    def mu(self) -> Form:
        """The coefficient of friction while it slips; of dry friction of a joint the force."""
        return Form.of(self.touch.friction)

    @cached_property
    def static(self) -> Form:
        """The same while it sticks."""
        return Form.of(self.touch.static)

    def percussion(self, way: str, mode: str = "", node: Expr | None = None) -> Symbol:
        """Return the symbol of Λn or Λt, in a mode."""
        return self.letter(f"percussion{way}{mode}", "Lambda", way if self.has_friction else "", node)

    def jump(self, i: int, node: Expr | None = None) -> Symbol:
        """Return the symbol of u⁺ - u⁻ of one velocity, with what it is worth where this one strikes alone."""
        lesson = self.lesson
        shown = latex_symbols(lesson.scene)[str(lesson.state.qd[i].value)]
        key = f"jump:{i + 1}:{self.number}" if node is not None else f"jump:{i + 1}"
        return lesson.called(key, Letter(rf"\Delta {shown}"), node)

    def _percussion(self) -> tuple[Block, ...]:
        """Return M (u⁺ - u⁻) = Wᵀ Λ row by row, where a line has each."""
        lesson, ways = self.lesson, ("n", "t") if len(self.touch.tangents) < 2 else ("n", "x", "y")
        forces = [self.percussion(way) for way in ways[: len(self.rows)]]
        blocks = list[Block]()
        for i, p in enumerate(lesson.momenta):
            try:
                left = [(shortened(lesson, x), self.jump(j)) for j, x in enumerate(gradient(p, lesson.state.qd))]
                right = [(shortened(lesson, row[i]), force) for row, force in zip(self.rows, forces, strict=True)]
            except NO_FORM:
                return ()
            sides = [Form.sum(Form.product(pair) for pair in side if pair[0].terms) for side in (left, right)]
            blocks.append(folded(lesson, Formula("", sides[0], right=sides[1])))
        return tuple(blocks)

    def _smooth(self) -> Step:
        """Return the impact without friction: percussion, rates behind it, energy."""
        assert self.columns is not None, "asked for where there are forms"
        lesson, v, D = self.lesson, self.v[0], self.D[0][0]
        graph = lesson.graph
        rate, number = self.speeds[0], self.columns[1][0][0].express(graph)
        e = self.e.express(graph)
        force = self.percussion("n", "+", -(1 + e) * rate / number)
        blocks: list[Block] = [Formula(force.name, Form.product((MINUS, self.more, v, D.power(-1))))]
        for i, column in enumerate(self.columns[0][0]):
            if column.terms:
                change = -(1 + e) * rate / number * column.express(graph)
                try:
                    form = shortened(lesson, change)
                except NO_FORM:
                    form = Form.product((column, force))
                blocks.append(Formula(self.jump(i, change).name, form))
        K = self.letter("loss", rf"\Delta {lesson.letters.latex('K')}", "", -(1 - e**2) * rate**2 / number / 2)
        lost = Form.sum((ONE, Form.product((MINUS, self.e.power(2)))))
        left = Number(1 - self.e.value**2) if isinstance(self.e, Number) else lost
        blocks.append(Formula(K.name, Form.product((Number(Fraction(-1, 2)), left, v.power(2), D.power(-1)))))
        key = "contacts.smooth" if self.e.terms else "contacts.smooth.plastic"
        claim = lesson.say(key, force=force, K=K, e=self.e, rate=v)
        reason = lesson.once(f"{key}.reason", square=self.e.power(2))
        return Step(f"impact:{self.name}", claim, tuple(blocks), reason)

    def _rough(self) -> Step:
        """Return the percussion of a phase by its modes."""
        lesson, (v, s), ((a, b), (_, c)) = self.lesson, self.v, self.D
        newton, mu = self.touch.law.law == "newton", self.mu
        struck = Form.product((self.more, v)) if newton else v
        normal, along = self.percussion("n"), self.percussion("t")
        rows = list[tuple[str, Form, Form, Words]]()
        for found in percussions(self.D, struck, s, mu):
            assert found.along is not None, "asked for where there is friction"
            if found.mode == "sticks":
                where = lesson.say("contacts.inside", mu=mu, normal=normal, along=along)
                rows.append((found.mode, found.normal, found.along, where))
                continue
            mode, z = ("ahead", MINUS) if found.mode == "forwards" else ("back", ONE)
            after = Form.sum((s, Form.product((_sum((b,), (z, mu, c)), normal))))
            key = "contacts.back.if" if mode == "back" else "contacts.ahead.both" if b.terms else "contacts.ahead.if"
            where = lesson.say(key, rate=after, under=_sum((a,), (z, mu, b)))
            rows.append((mode, found.normal, found.along, where))
        shown = [(lesson.say(f"contacts.{mode}"), x, y, where) for mode, x, y, where in rows]
        table = lesson.table(("contacts.mode", normal, along, "contacts.holds"), shown)
        law = lesson.say(f"contacts.{self.touch.law.law if self.e.terms else 'plastic'}", e=self.e, rate=v)
        told = lesson.say("contacts.rough.newton" if newton else "contacts.rough")
        claim = Words((*law.parts, " ", *told.parts))
        key = "expansion" if self.e.terms else "no.expansion"
        reason = Words(()) if newton else lesson.say(f"contacts.{key}", normal=normal, e=self.e, slip=s)
        return Step(f"impact:{self.name}", claim, (table,), reason)


def _sum(*products: tuple[Form, ...]) -> Form:
    return Form.sum(Form.product(one) for one in products)


def _written(lesson: Lesson, symbol: Symbol, node: Expr) -> Block:
    """Return a quantity in short form, as it is where it has none."""
    try:
        return folded(lesson, Formula(symbol.name, shortened(lesson, node)))
    except NO_FORM:
        return folded(lesson, Formula(symbol.name, Form.of(node)))
