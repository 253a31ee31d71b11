r"""Contacts in print: gaps and slips, their laws, what they add in every mode, Delassus' matrix, and impacts.

    0 ≤ g ⊥ λn ≥ 0        -λt ∈ μ λn Sgn(s)        M u̇ = Q + Wᵀ λ,  W the rows of ġ and s

References: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5, 6 and 8.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symdyn.algebra import Form, Number, Ratios, Symbol
from symdyn.dynamics import ClosedForm
from symdyn.dynamics.outputs import Row, Touch, touching
from symdyn.emit.print.formula_text import Forms
from symdyn.emit.print.formulation_groups import (
    LONGEST,
    TOO_LONG,
    EquationGroup,
    EquationRow,
    entry_row,
    fresh,
    nonzero_rows,
    open_form,
    ordered_workspace,
    quotient,
    written_forms,
)
from symdyn.emit.print.printable import Printable
from symdyn.emit.print.printed_names import PrintName
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import Scene
from symdyn.scene.values import acceleration_name

WHAT = "equations of contacts"
SIGNS = {"strikes": "", "sticks": "", "forwards": "+", "backwards": "-"}


@dataclass(frozen=True)
class Percussion:
    """The impulses of a contact that strikes alone, in a mode: along its normal, and its tangent with friction."""

    mode: str
    normal: Form
    along: Form | None = None


def percussions(D: Sequence[Sequence[Form]], struck: Form, slip: Form, mu: Form) -> Iterator[Percussion]:
    """Yield the impulses in every mode: with friction it sticks, or slips forwards or backwards.

    Args:
        D: Delassus' matrix of the normal and, with friction, of the tangent: 1 × 1 or 2 × 2, in 1/kg or 1/(kg m²).
        struck: the rate that the impulse takes away: ġ of a phase of compression, (1 + e) ġ by Newton's law.
        slip: s before the impact.
        mu: the coefficient of friction.
    """
    if len(D) == 1:
        yield Percussion("strikes", Form.product((struck.negative, D[0][0].power(-1))))
        return
    (nn, nt), (_, tt) = D
    if nt.terms:
        over = Form.sum((Form.product((nn, tt)), nt.power(2).negative)).power(-1)
        normal = Form.sum((Form.product((nt, slip)), Form.product((tt, struck)).negative))
        along = Form.sum((Form.product((nt, struck)), Form.product((nn, slip)).negative))
        yield Percussion("sticks", Form.product((normal, over)), Form.product((along, over)))
    else:
        normal, along = (Form.product((x.negative, d.power(-1))) for x, d in ((struck, nn), (slip, tt)))
        yield Percussion("sticks", normal, along)
    for mode, z in (("forwards", Number.ONE), ("backwards", Number.MINUS_ONE)):
        under = Form.sum((nn, Form.product((z.negative, mu, nt))))
        pushed = Form.product((struck.negative, under.power(-1)))
        yield Percussion(mode, pushed, Form.product((z.negative, mu, pushed)))


@dataclass(frozen=True)
class _Letters:
    """The letters of one contact, with its number where there are several: of its gap, and of its slip."""

    number: str
    gap: str
    slip: str

    @classmethod
    def of(cls, scene: Scene, k: int, count: int) -> _Letters:
        number = str(k + 1) if count > 1 else ""
        ((gap,), (slip,)) = (fresh(scene, [f"{x}{number}" for x in some]) for some in (("g", "gap"), ("s", "slip")))
        return cls(number, gap, slip)

    def impulse(self, word: str, sign: str, form: Form) -> EquationRow:
        above = f"^{sign}" if sign else ""
        below = ",".join(filter(None, (word, self.number)))
        return EquationRow(f"Lambda_{word}{self.number}{sign}", rf"\Lambda{above}_{{{below}}}", form)

    def force(self, word: str) -> str:
        return f"lambda_{word}{self.number}"


def contact(scene: Scene) -> Iterator[EquationGroup]:
    """Yield gap and slip of every contact, its laws by mode, forces in the equations of motion, D, and its impact.

    Raises:
        DerivationError: there are no contacts, rows tie the coordinates, or a motion is prescribed.
    """
    w = ordered_workspace(scene, WHAT)
    touches: tuple[Touch, ...] = w.once(touching, True)
    if not touches:
        raise DerivationError(f"{scene.name} has no contacts that open and close; print Lagrange's equations")
    if wide := next((one for one in touches if len(one.tangents) > 1), None):
        raise DerivationError(
            f"{scene.name}: contacts.{wide.law.name} can slip along two directions, and modes are printed of one; "
            "generate contact_dynamics"
        )
    entries = [x for one in touches for row in one.rows for x in (*row.entries, row.bias)]
    write = written_forms(w, [*entries, *(x for one in touches for x in (one.gap, one.friction, one.restitution))])
    letters = [_Letters.of(scene, k, len(touches)) for k in range(len(touches))]
    for one, own in zip(touches, letters, strict=True):
        yield _one(scene, one, own, write)
    every = [row for one in touches for row in one.rows]
    forces = [
        own.force(word)
        for one, own in zip(touches, letters, strict=True)
        for word in [*(["n"] if one.normal else []), *("t" for _ in one.tangents)]
    ]
    added = [
        Form.sum(Form.product((write(row.entries[i]), Symbol(name))) for row, name in zip(every, forces, strict=True))
        for i in range(w.state.n)
    ]
    text = "M udot = Q + Q_c: Lagrange's equations with this beside the drives; what is not listed is 0"
    latex = r"$M \dot u = Q + Q_c$, Lagrange's equations with this beside the drives; what is not listed is 0:"
    pushes = nonzero_rows(entry_row(scene, "Q_c", x, i) for i, x in enumerate(added))
    yield EquationGroup("forces", "Forces of contacts", text, pushes, latex)
    D = _delassus(open_form(scene, WHAT), [[write(x) for x in row.entries] for row in every])
    names = ", ".join(forces)
    told = f"accelerations of gaps and slips by a unit of force, rows and columns in the order {names}"
    shown = "$, $".join(str(PrintName.of_code(name)) for name in forces)
    if D is None:
        text = f"{told}: D = W M^-1 W^T, too long to be read here; generate the output delassus"
        yield EquationGroup("delassus", "Delassus' matrix", text, (), "")
    else:
        above = nonzero_rows(
            entry_row(scene, "D", x, i, j) for i, row in enumerate(D) for j, x in enumerate(row) if i <= j
        )
        latex = rf"$D = W M^{{-1}} W^T$, {told.replace(names, f'${shown}$')}:"
        yield EquationGroup("delassus", "Delassus' matrix", f"D = W M^-1 W^T, {told}", above, latex)
    at = 0
    for one, own in zip(touches, letters, strict=True):
        if one.normal is not None:
            yield _impact(scene, one, own, at, D, write)
        at += len(one.rows)


def _one(scene: Scene, one: Touch, letters: _Letters, write: Forms) -> EquationGroup:
    """Return gap and slip of one, and the equations that a mode adds."""
    n, t, g, s = letters.force("n"), letters.force("t"), letters.gap, letters.slip
    n_, t_, g_, s_ = (str(PrintName.of_code(name)) for name in (n, t, g, s))
    rows, laws, modes, shown = list[EquationRow](), list[str](), list[str](), list[str]()
    if one.normal is not None:
        g0, g0_ = (f"{g}_dot", rf"\dot{{{g_}}}") if one.law.at_rates else (g, g_)
        rows += [] if one.law.at_rates else [EquationRow(g, g, write(one.gap))]
        rows += _rates(one.normal, f"{g}_dot", f"{g}_ddot", scene, write)
        laws.append(f"0 <= {g0}, 0 <= {n}, one of them 0")
        modes.append(f"open {n} = 0, closed {g}_ddot = 0")
        shown.append(rf"$0 \le {g0_} \perp {n_} \ge 0$: open ${n_} = 0$, closed $\ddot{{{g_}}} = 0$")
    for row in one.tangents:
        largest, cone = (f"mu {n}", rf"\mu {n_}") if one.normal else ("F", "F")
        rows += _rates(row, s, f"{s}_dot", scene, write)
        laws.append(f"|{t}| <= {largest}")
        modes.append(f"sticks {s}_dot = 0, slips forwards {t} = -{largest}, backwards {t} = {largest}")
        slips = rf"slips forwards ${t_} = -{cone}$, backwards ${t_} = {cone}$"
        shown.append(rf"$|{t_}| \le {cone}$: sticks $\dot{{{s_}}} = 0$, {slips}")
    text, latex = f"{'; '.join(laws)}; by mode {'; '.join(modes)}", f"{'; '.join(shown)}:"
    own = (*([g] if one.normal else []), *(s for _ in one.tangents))
    return EquationGroup(f"contact:{one.law.name}", one.law.name, text, tuple(rows), latex, own)


def _rates(row: Row, rate: str, change: str, scene: Scene, write: Forms) -> list[EquationRow]:
    """Return the rows of a rate that is linear in velocities, and of what it changes by."""
    accelerations = [acceleration_name(name) for name in scene.velocities]
    form = Form.sum((_along(row.entries, accelerations, write), write(row.bias)))
    return [EquationRow(rate, rate, _along(row.entries, scene.velocities, write)), EquationRow(change, change, form)]


def _along(entries: Sequence[Expr], names: Sequence[str], write: Forms) -> Form:
    return Form.sum(Form.product((write(x), Symbol(name))) for x, name in zip(entries, names, strict=True))


def _delassus(closed: ClosedForm, W: list[list[Form]]) -> list[list[Form]] | None:
    """Return W M⁻¹ Wᵀ, None where that is too long to read."""
    page, graph = Printable.of(closed, lengths=None), Graph()
    M = [[cell.form.express(graph) for cell in page.inertia(i)] for i in range(closed.n)]
    rows = [[x.express(graph) for x in row] for row in W]
    try:
        field = Ratios([*(x for row in M for x in row), *(x for row in rows for x in row)])
        values = field.values()
        inertia = [evaluate(row, field, values) for row in M]
        known = [evaluate(row, field, values) for row in rows]
        sides = field.solved(inertia, [list(column) for column in zip(*known, strict=True)])
        own = closed.state.q[0].graph
        found = [[quotient(closed, field.form(x).express(own)) for x in row] for row in field.product(known, sides)]
    except TOO_LONG:
        return None
    longest = max(sum(1 for _ in form.walk()) for row in found for form in row)
    return found if longest <= 4 * LONGEST else None


def _impact(
    scene: Scene, one: Touch, letters: _Letters, at: int, own: list[list[Form]] | None, write: Forms
) -> EquationGroup:
    """Return the impulses of one that strikes alone, by its modes; `own` is D, where that is short."""
    size = range(at, at + len(one.rows))
    D = [
        [
            Symbol(entry_row(scene, "D", Number.ZERO, *sorted((i, j))).name)
            if own is None or i == j or own[i][j].terms
            else Number.ZERO
            for j in size
        ]
        for i in size
    ]
    e, mu, v = write(one.restitution), write(one.friction), Symbol(f"{letters.gap}_dot")
    newton = one.law.law == "newton" or one.restitution.is_zero
    struck = Form.product((Form.sum((Number.ONE, e)), v)) if newton else v
    said = "where it strikes alone, its impulse" if newton else "where it strikes alone, its impulse of compression"
    behind, shown = "", r"; $u^+ = u + M^{-1} W^T \Lambda$:"
    if not newton:
        least = "at least the part that restitution gives back"
        behind = f"; expansion is the same from the rates behind it, Lambda_n {least}"
        shown = rf"; expansion is the same from the rates behind it, $\Lambda_n$ {least}{shown}"
    if one.tangents:
        said += ": where it sticks, if it is within its cone; where it slips forwards (+) or backwards (-)"
    rows = list[EquationRow]()
    for found in percussions(D, struck, Symbol(letters.slip), mu):
        rows.append(letters.impulse("n", SIGNS[found.mode], found.normal))
        if found.along is not None:
            rows.append(letters.impulse("t", SIGNS[found.mode], found.along))
    text, latex = f"{said}{behind}; u+ = u + M^-1 W^T Lambda", f"{said[0].upper()}{said[1:]}{shown}"
    return EquationGroup(f"impact:{one.law.name}", f"Impact of {one.law.name}", text, tuple(rows), latex)
