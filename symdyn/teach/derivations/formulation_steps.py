"""Steps of a lesson by another formulation: each explains a group of equations of the printed page, in a book's order.

    hamilton          p, q̇ solved for, H(q, p), the canonical equations              Goldstein, 8.1
    routh             p kept, cyclic velocities, R, the equations that are left        Goldstein, 8.3
    kane              velocities and partial velocities, F*, F, F + F* = 0             Kane and Levinson, 2 to 4
    gibbs-appell      accelerations, S, ∂S/∂q̈ = Q                                     Gibbs
    udwadia-kalaba    M and Q without constraints, A and b of these, the force added   Udwadia and Kalaba
    port-hamiltonian  p, q̇ and H, (J - R) ∇H with what acts, the same written out     van der Schaft, 4.2

Formulas are those of `FormulationPage`; what they are worth comes from the lesson's own graph, where it has it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from symdyn.algebra import Form, Number, Symbol
from symdyn.dynamics.mechanism import Kane, generalized_forces
from symdyn.emit.print import EquationGroup, EquationRow, FormulationPage
from symdyn.graph import Expr, substitute, tangents
from symdyn.teach.derivations.dalembert.side_by_side import order_of
from symdyn.teach.derivations.velocities import folded
from symdyn.teach.document import Block, Formula, Letter, Matrix, Name, Step, Words
from symdyn.teach.lesson import AXES, Lesson, named, together
from symdyn.unlocked import cached_property

ENDS = ("canonical", "left", "kane", "appell", "added")
"""Groups that are results, by key."""

SHOWN: Mapping[str, tuple[str, ...]] = {
    "momenta": ("momenta",),
    "constant": ("momenta",),
    "hamiltonian": ("energies",),
    "canonical": ("momenta", "accelerations"),
    "velocity": ("velocities",),
    "inertia": ("accelerations", "inertia"),
    "acceleration": ("accelerations",),
    "active": ("weights", "forces"),
    "kane": ("inertia", "weights", "forces"),
    "appell": ("inertia", "weights", "forces"),
    "added": ("reactions", "forces"),
    "power": ("energies",),
}
"""What the figure of a page shows at a step of a group; see `symdyn.teach.derivations.lagrange.SHOWS`."""

Entries = dict[tuple[int, ...], Form]
"""Entries of a matrix or vector by their places, from 0; none that is zero."""

DIGITS = "0123456789_"


@dataclass
class Explained:
    """A lesson and the page whose equations it explains."""

    lesson: Lesson
    page: FormulationPage

    def __post_init__(self) -> None:
        """Name momenta, drives, energies, and what holds for any coordinate, before steps name the rest."""
        lesson, names = self.lesson, self.lesson.names
        for letter, node in (("K", lesson.energy.K), ("P", lesson.energy.P), ("L", lesson.L)):
            lesson.name(f"{letter}:", letter, node=node)
        for drive, i in self.driven.items():
            names[str(drive.value)] = Name(None, lesson.drives[i])
        for name, i in self.momenta.items():
            look = name.rstrip(DIGITS), self.index(i)
            tau = lesson.drives[i] if lesson.scene.drives[i] else lesson.graph.zero
            names[name] = Name(Letter(*look), lesson.momenta[i])
            names[f"{name}_dot"] = Name(Letter(*look, dots=1), self.along[i] + self.acting[i] + tau)
        shown = {row.letter: row.latex.partition("_{")[0] for one in self.page.groups for row in one.rows if row.letter}
        shown |= {letter: rf"\mathbf{{{letter}}}" for letter in "JR"}
        shown |= {letter: self.row(key).latex for key, letter in FUNCTIONS.items() if key in self.groups}
        names |= {f"any:{letter}": Name(Letter(shown.get(letter, letter))) for letter in LETTERS}
        q, F = lesson.letters["q"], shown.get("F", "F")
        names |= {f"any:q{k}": Name(Letter(q, ("i",), dots=k)) for k in range(3)}
        if self.turning:
            names |= {f"any:q{k + 1}": Name(Letter("u", ("i",), dots=k)) for k in range(2)}
            names["any:turned"] = Name(Letter(r"\textstyle\sum_{j,l} \gamma_{ji}^{l} \, u_j p_l"))
            names["any:XH"] = Name(Letter(rf"\partial_i {shown.get('H', 'H')}"))
        names |= {f"any:Q{one}": Name(Letter(lesson.letters["Q"], ("i",), above=one.strip("i"))) for one in ("A", "i")}
        names |= {f"any:F{above}": Name(Letter(F, ("i",), above=above)) for above in ("*", "")}
        p = next(iter(self.momenta), "p").rstrip(DIGITS)
        names |= {f"any:p{k}": Name(Letter(p, ("i",), dots=k)) for k in range(2)}

    @cached_property
    def groups(self) -> dict[str, EquationGroup]:
        """Equations by key of their group."""
        return {one.key: one for one in self.page.groups}

    @cached_property
    def momenta(self) -> dict[str, int]:
        """Velocities of the momenta that stand in formulas, by the names of these."""
        names = [name for one in self.page.groups for name in one.letters]
        return {name: int(name.strip("pPi_") or 1) - 1 for name in names}

    @property
    def turning(self) -> bool:
        """Whether velocities are those along the axes of bodies that turn by quaternions."""
        return bool(self.lesson.state.spheres)

    def turned(self, u: Sequence[Expr], p: Sequence[Expr]) -> list[Expr]:
        """Return Lie and Poisson's terms Σ γ u_j p_l in the rates of momenta; zero for rates of coordinates."""
        found = [self.lesson.graph.zero] * self.lesson.state.n
        for (j, i), terms in self.lesson.energy.directions.brackets.items():
            found[i] = found[i] + self.lesson.graph.total(value * u[j] * p[m] for m, value in terms)
        return found

    @cached_property
    def along(self) -> list[Expr]:
        """What the rates of momenta are without forces: X_i L, and Lie and Poisson's terms."""
        slopes, turned = self.lesson.energy.directions.slopes(self.lesson.L), self.lesson.momenta
        return [a + b for a, b in zip(slopes, self.turned(self.lesson.state.qd, turned), strict=True)]

    @cached_property
    def acting(self) -> list[Expr]:
        """What acts along every velocity beside drives, weights and springs."""
        return generalized_forces(self.lesson.scene, self.lesson.graph)

    @cached_property
    def needed(self) -> list[Expr]:
        """What the motion of every velocity without a drive would need, by Lagrange's equations; zero with a drive."""
        lesson = self.lesson
        return [lesson.graph.zero if tau else x for tau, x in zip(lesson.scene.drives, lesson.drives, strict=True)]

    @property
    def driven(self) -> dict[Expr, int]:
        """Velocities with a drive, by its symbol."""
        return {self.lesson.graph.symbol(tau): i for i, tau in enumerate(self.lesson.scene.drives) if tau}

    @cached_property
    def order(self) -> Callable[[Form], Form]:
        """What puts parameters before sines, and these before rates."""
        return order_of(self.lesson.scene)

    def index(self, i: int) -> tuple[str, ...]:
        """Return what stands below a letter of velocity i: nothing where there is one alone."""
        return (str(i + 1),) if self.lesson.state.n > 1 else ()

    def value(self, form: Form, drives: bool = True) -> Expr:
        """Return what a formula is worth, momenta put in; drives as Lagrange's equations ask, or none at all."""
        lesson, symbol = self.lesson, self.lesson.graph.symbol
        known = {symbol(name): lesson.momenta[i] for name, i in self.momenta.items()}
        known |= {tau: lesson.drives[i] if drives else lesson.graph.zero for tau, i in self.driven.items()}
        return substitute([form.express(lesson.graph)], known)[0]

    def row(self, group: str) -> EquationRow:
        """Return the one row of a group."""
        (row,) = self.groups[group].rows
        return row

    def entries(self, letter: str) -> Entries:
        """Return what the page calls by a letter."""
        return {row.place: row.form for one in self.page.groups for row in one.rows if row.letter == letter}

    def say(self, key: str, **places: str | Form | Words) -> Words:
        """Return prose in which functions and matrices may stand by their letters."""
        letters = {letter: Symbol(f"any:{letter}") for letter in LETTERS} | {x: Symbol(f"{x}:") for x in "KPL"}
        return self.lesson.say(key, **(letters | places))

    # Steps

    def stated(self) -> list[Block]:
        """Return the equations for any coordinate i; none where matrices say them."""

        def slope(of: str, by: str) -> Symbol:
            return self.lesson.slope(f"any:{of}", f"any:{by}", None)

        change = [Symbol("any:XH").negative, Symbol("any:turned")] if self.turning else [slope("H", "q0").negative]
        rate, QA = self.lesson.rate(slope("R", "q1").name, None), Symbol("any:QA")
        known: Mapping[str, list[tuple[Form, Form]]] = {
            "hamilton": [
                (Symbol("any:q1"), slope("H", "p0")),
                (Symbol("any:p1"), Form.sum((*change, QA))),
            ],
            "routh": [(Form.sum((rate, slope("R", "q0").negative)), QA)],
            "kane": [(Form.sum((Symbol("any:F"), Symbol("any:F*"))), Number.ZERO)],
            "gibbs-appell": [(slope("S", "q2"), Symbol("any:Qi"))],
        }
        said = [self.say("by.commute", along=Symbol("any:XH"))] if self.turning and "hamiltonian" in self.groups else []
        shown = known.get(self.page.formulation.replace("port-hamiltonian", "hamilton" if said else ""), [])
        return [*(Formula("", left, right=right) for left, right in shown), *said]

    def step(self, group: str, *blocks: Block, **places: str | Form | Words) -> Step:
        """Return a step about a group: its claim, and the first time its reason, stand under what is before a colon."""
        lesson, kind = self.lesson, group.partition(":")[0]
        claim, reason = (self.variant(f"by.{kind}{end}") for end in ("", ".reason"))
        shown = SHOWN.get(kind, ())
        told = reason in lesson.told or reason not in lesson.tongue.lesson
        lesson.told.add(reason)
        because = Words(()) if told else self.say(reason, **places)
        key = f"{'result' if kind in ENDS else 'derived'}:{group}"
        return Step(key, self.say(claim, **places), blocks, because, show=shown)

    def variant(self, key: str) -> str:
        """Return the key of prose about axes that turn, and velocities that are not solved for, where there is such."""
        own = self.groups["canonical"].rows if "canonical" in self.groups else ()
        unsolved = bool(own) and not {row.name for row in own}.intersection(self.lesson.scene.velocities)
        ends = (".unsolved.turning", ".turning", ".unsolved")
        told = (self.turning and unsolved, self.turning, unsolved)
        others = (f"{key}{end}" for end, holds in zip(ends, told, strict=True) if holds)
        return next((other for other in others if other in self.lesson.tongue.lesson), key)

    def formula(self, key: str, by: Form, form: Form) -> Block:
        """Return key = by = form, or a fold of key = form where that is long."""
        found = folded(self.lesson, Formula(key, form))
        return Formula(key, by, right=form) if isinstance(found, Formula) else found

    def equations(self, group: str) -> list[Block]:
        """Return rows of which each is zero."""
        rows = self.groups[group].rows
        return [folded(self.lesson, Formula("", self.order(row.form), right=Number.ZERO)) for row in rows]

    def momentum_steps(self, group: str, **places: str | Form | Words) -> Iterator[Step]:
        """Yield momenta, and velocities that are solved for."""
        lesson, places = self.lesson, {"names": together([Symbol(name) for name in self.momenta]), **places}
        blocks = list[Block]()
        for row, i in zip(self.groups[group].rows, self.momenta.values(), strict=True):
            slope = lesson.slope("L:", lesson.scene.velocities[i], lesson.momenta[i])
            blocks.append(self.formula(row.name, slope, row.form))
        yield self.step(group, *blocks, **places)
        rows = self.groups["cyclic" if "cyclic" in self.groups else "canonical"].rows
        solved = [Formula("", Symbol(x.name), right=x.form) for x in rows if x.name in lesson.scene.velocities]
        if solved:
            yield self.step("solved", *(folded(lesson, one) for one in solved))

    def function(self, group: str, node: Expr, *formed: Form) -> Step:
        """Return the step of a function: what it is formed of, then as the page has it."""
        row, key = self.row(group), f"{group}:"
        self.lesson.names[key] = Name(Letter(row.latex), node)
        blocks = [Formula(key, form) for form in formed]
        return self.step(group, *blocks, folded(self.lesson, Formula(key, self.order(row.form))))

    def work(self) -> list[Form]:
        """Return the products p q̇ of momenta that stand in formulas."""
        return [Form.product((Symbol(p), named(self.lesson.state.qd[i]))) for p, i in self.momenta.items()]

    def canonical_steps(self) -> Iterator[Step]:
        """Yield the steps to the canonical equations."""
        lesson, H = self.lesson, Symbol("hamiltonian:")
        yield from self.momentum_steps("momenta")
        whole = lesson.page.lengths.written_out(Form.sum((lesson.page.K, lesson.page.P)))
        formed = Form.sum((*self.work(), Symbol("L:").negative))
        blocks, rows = list[Block](), {row.name: row.form for row in self.groups["canonical"].rows}
        shown = [formed, self.order(whole)] if {*rows}.intersection(lesson.scene.velocities) else [formed]
        yield self.function("hamiltonian", lesson.energy.K + lesson.energy.P, *shown)
        for p, i in self.momenta.items():
            if (u := lesson.scene.velocities[i]) in rows:
                blocks.append(self.formula(u, lesson.slope(H.name, p, None), rows[u]))
        for p, i in self.momenta.items():
            if self.turning:
                letter = self.row("hamiltonian").latex
                lesson.names[f"XH:{i}"] = Name(Letter(rf"\partial_{{{i + 1}}} {letter}"))
                slope: Form = Symbol(f"XH:{i}")
            else:
                slope = lesson.slope(H.name, lesson.scene.coordinates[i], None)
            turned = Form.of(self.turned(lesson.state.qd, [lesson.graph.symbol(name) for name in self.momenta])[i])
            pushed = Form.sum((slope.negative, turned, lesson.page.lengths.written_out(lesson.page.right[i])))
            blocks.append(self.formula(f"{p}_dot", pushed, rows[f"{p}_dot"]))
        yield self.step("canonical", *blocks)

    def body_steps(self) -> Iterator[Step]:
        """Yield for every body velocities and partial velocities, then accelerations and shares of F*; then F."""
        lesson, moved = self.lesson, list[Step]()
        bodies = [one for one in self.page.groups if one.key.startswith(("body", "rotors"))]
        for k, group in enumerate(bodies, 1):
            of = {letter: [row for row in group.rows if row.letter == letter] for letter in ("v", "w", "F*")}
            velocities, partial, faster = list[Block](), list[Block](), list[Block]()
            for row in (*of["v"], *of["w"]):
                *r, axis = row.place
                form, key = self.order(row.form), f"{row.letter}:{k}{AXES[axis]}"
                if r:
                    slope = lesson.slope(key, lesson.scene.velocities[r[0]], self.value(form))
                    partial.append(folded(lesson, Formula(slope.name, form)))
                    continue
                letter = "omega" if row.letter == "w" else "v"
                lesson.called(key, Letter(letter, (f"{k}{AXES[axis]}",)), self.value(form))
                velocities.append(folded(lesson, Formula(key, form)))
                (rate,) = tangents([self.value(form)], lesson.state.acceleration)
                faster.append(folded(lesson, Formula(lesson.rate(key, rate).name, self.order(lesson.short(rate)))))
            shares = [self._force(row, str(k)) for row in of["F*"]]
            if group.key == "rotors":
                moved.append(self.step("rotors", *shares))
                continue
            told = [self.say("by.partial"), *partial] if partial else [self.say("by.still")]
            yield self.step(f"velocity:{k}", *velocities, *told, body=group.title)
            if shares:
                moved.append(self.step(f"inertia:{k}", *faster, self.say("by.shares"), *shares, body=group.title))
        yield from moved
        yield self.step("active", *(self._force(row) for row in self.groups["active"].rows))

    def acceleration_steps(self) -> Iterator[Step]:
        """Yield for every body accelerations, and its share of the energy of accelerations."""
        lesson, zero = self.lesson, self.lesson.graph.zero
        parts = Kane.of(lesson.scene, lesson.graph).bodies
        for k, part in enumerate(parts, 1):
            blocks = list[Block]()
            own = (part.R.T @ x if self.turning else x for x in (part.a, part.dw))
            for letter, vector in zip(("a", "alpha"), own, strict=True):
                for axis, x in zip(AXES, vector, strict=True):
                    if not lesson.vanishes(x):
                        key = f"{letter}:{k}{axis}"
                        lesson.called(key, Letter(letter, (f"{k}{axis}",)), x)
                        blocks.append(folded(lesson, Formula(key, self.order(lesson.short(x)))))
            still = substitute([part.acceleration_energy], dict.fromkeys(lesson.state.qdd, zero))[0]
            share = part.acceleration_energy - still
            if lesson.vanishes(share):
                continue
            if len(parts) > 1:
                lesson.names[f"S:{k}"] = Name(Letter(self.row("gibbs").latex, (str(k),)), share)
                told = folded(lesson, Formula(f"S:{k}", self.order(lesson.short(share))))
                blocks += [self.say("by.share"), told]
            yield self.step(f"acceleration:{k}", *blocks, body=part.body)

    def _force(self, row: EquationRow, of: str = "") -> Block:
        """Return a generalized force, of inertia the share of one body."""
        key, above = f"{row.letter}:{of}:{row.place[0] + 1}", row.letter[1:]
        below = (*self.index(row.place[0]), *([of] if of else []))
        self.lesson.names[key] = Name(Letter(row.latex[0], below, above=above), self.value(row.form))
        return folded(self.lesson, Formula(key, self.order(row.form)))

    def matrix(self, key: str, entries: Entries, height: int, width: int = 1) -> Matrix:
        """Return the matrix that is named by a key; what has no entry is zero."""
        vector = width == 1 and all(len(place) == 1 for place in entries)
        places = [(i,) if vector else (i, j) for i in range(height) for j in range(width)]
        look, names = self.lesson.names[key].look, list[str]()
        assert isinstance(look, Letter), "a matrix has a letter"
        for place in places:
            below, form = ",".join(str(k + 1) for k in place), entries.get(place, Number.ZERO)
            self.lesson.names[f"{key}:{below}"] = Name(Letter(look.letter, (below,)), self.value(form))
            names.append(f"{key}:{below}")
        return Matrix(key, tuple(entries.get(place, Number.ZERO) for place in places), tuple(names), width=width)


FUNCTIONS = {"hamiltonian": "H", "routhian": "R", "gibbs": "S"}
"""Letters of functions that have a page's group each."""

LETTERS = "MQAbJRHS"
"""Functions and matrices that prose names."""


def joined(sign: Sequence[int], *some: Entries) -> Entries:
    """Return a square matrix of which one half is known: sign 1 or -1 is that of the other half; several are added."""
    found: Entries = {}
    for s, half in zip(sign, some, strict=True):
        for (i, j), form in half.items():
            for place, entry in {(j, i): form if s > 0 else form.negative, (i, j): form}.items():
                found[place] = Form.sum((found.get(place, Number.ZERO), entry))
    return found


def tied_steps(told: Explained) -> Iterator[Step]:
    """Yield M and Q without constraints, these, A and b of them, and the force that they add."""
    lesson, n, rows = told.lesson, told.lesson.state.n, told.lesson.page.constraints.rows
    M, Q, A, b = (told.entries(letter) for letter in "MQAb")
    yield told.step("free", told.matrix("any:M", joined([1], M), n, n), told.matrix("any:Q", Q, n))
    held = [folded(lesson, Formula("", row.residual, right=Number.ZERO)) for row in rows if row.residual is not None]
    yield from [told.step("held", *held)] if held else []
    tied = [Form.sum(Form.product((x, named(u))) for x, u in zip(row.G, lesson.state.qd, strict=True))
            for row in rows if row.residual is None]  # fmt: skip
    if tied:
        yield told.step("tied", *(folded(lesson, Formula("", told.order(x), right=Number.ZERO)) for x in tied))
    yield told.step("constraints", told.matrix("any:A", A, len(rows), n), told.matrix("any:b", b, len(rows)))
    looks = {letter: lesson.names[f"any:{letter}"].look for letter in "MQAb"}
    of = {key: look.letter for key, look in looks.items() if isinstance(look, Letter)}
    pulled = f"{of['A']} {of['M']}^{{-1}}"
    answer = f"{pulled} {of['A']}^T"
    lesson.names |= {
        "pulled:": Name(Letter(rf"{of['M']} \ddot q")),
        "added:": Name(Letter("Q", ("c",))),
        "answer:": Name(Letter(answer)),
        "spelled:": Name(Letter(f"{of['A']}^T ({answer})^+ ({of['b']} - {pulled} {of['Q']})")),
    }
    short = [told.matrix("added:", told.entries("Q_c"), n)] if told.groups["added"].rows else []
    whole = Formula("pulled:", Form.sum((Symbol("any:Q"), Symbol("added:"))))
    yield told.step("added", *short, whole, Formula("added:", Symbol("spelled:")), answer=Symbol("answer:"))


def structured_steps(told: Explained) -> Iterator[Step]:
    """Yield the steps to H, its structure, and the same written out."""
    *steps, canonical = told.canonical_steps()
    yield from steps
    lesson, n, F = told.lesson, told.lesson.state.n, told.entries("F")
    flows, H = r"\mathbf{J} - \mathbf{R}", told.row("hamiltonian").latex
    latex = {"rate:": r"\dot{\mathbf{x}}", "moved:": rf"({flows}) \nabla {H}", "input:": r"\mathbf{f}", "flow:": flows}
    if told.turning:
        latex |= {"rate:": r"\dot{\mathbf{p}}", "moved:": rf"({flows}) \mathbf{{u}} - \partial {H}"}
    lesson.names |= {key: Name(Letter(shown)) for key, shown in latex.items()}
    flow: Entries = {(i, n + i): Number.ONE for i in range(n)}
    for (i, j), form in ({(i, i - n): Number.MINUS_ONE for i in range(n)} | pushed(told)).items():
        flow[n + i, n + j] = form
    drives = [Symbol(tau) if tau else Number.ZERO for tau in lesson.scene.drives]
    given: Entries = {(n + i,): Form.sum((tau, F.get((i,), Number.ZERO))) for i, tau in enumerate(drives)}
    whole = Formula("rate:", Form.sum((Symbol("moved:"), Symbol("input:"))))
    matrices = told.matrix("flow:", flow, 2 * n, 2 * n), told.matrix("input:", given, 2 * n)
    if told.turning:
        moved: Entries = {(i,): form for i in range(n) if (form := given[n + i,]) != Number.ZERO}
        matrices = told.matrix("flow:", pushed(told), n, n), told.matrix("input:", moved, n)
    names = together([Symbol(name) for name in (*lesson.scene.coordinates, *told.momenta)])
    yield told.step("structure", whole, *matrices, names=names)
    yield canonical


def pushed(told: Explained) -> Entries:
    """Return J - R of momenta, no entry that is zero."""
    lost = {place: form.negative for place, form in told.entries("R").items()}
    return joined([-1, 1], told.entries("J"), lost)
