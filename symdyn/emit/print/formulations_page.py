r"""Other formulations in print: a page each, in LaTeX and as text.

    hamilton        p = ∂L/∂q̇, H(q, p) = p·q̇ - L, q̇ = ∂H/∂p, ṗ = -∂H/∂q + Q
    routh           R = L - Σ p q̇ over coordinates on which nothing depends: their momenta p are constant
    kane            F_r + F_r* = 0, body by body, by partial velocities
    gibbs-appell    S = Σ ½ a·m a + ½ α·I α + α·(ω × I ω), ∂S/∂u̇_r = Q_r
    udwadia-kalaba  M u̇ = Q + Aᵀ (A M⁻¹ Aᵀ)⁺ (b - A M⁻¹ Q) where rows say A u̇ = b
    contact         0 ≤ g ⊥ λ ≥ 0 by mode, W M⁻¹ Wᵀ, impacts: of contacts that open and close
    inverse-kinematics  the angles of an arm at a pose, in the order in which they are found
    port-hamiltonian  ẋ = (J - R) ∇H + B τ + F, y = Bᵀ ∇H, x = (q, p)

References: Goldstein, Classical Mechanics (1980), 8.1 and 8.3; Kane and Levinson, Dynamics (1985), section 4.11; Gibbs,
On the fundamental formulae of dynamics (1879); Udwadia and Kalaba, A new perspective on constrained motion, Proceedings
of the Royal Society A 439 (1992) 407.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from symdyn.algebra import Form, Number, Ratios
from symdyn.dynamics import Function, Workspace
from symdyn.dynamics.mechanism import solve
from symdyn.dynamics.outputs import Counts
from symdyn.emit.print.arm_page import inverse_kinematics
from symdyn.emit.print.breaking import DIGITS, definitions, refuse_too_long
from symdyn.emit.print.canonical_pages import hamilton, port_hamiltonian, routh
from symdyn.emit.print.contact_page import contact
from symdyn.emit.print.formula_text import Forms, Latex, broken_text, rounded
from symdyn.emit.print.formulation_groups import (
    LONGEST,
    TOO_LONG,
    EquationGroup,
    EquationRow,
    drive_symbols,
    entry_row,
    fresh,
    named_row,
    nonzero_rows,
    ordered_workspace,
    refuse_led,
    written_forms,
)
from symdyn.emit.print.printable import Printable, other_rates
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.emit.print.sympy_page import sympy_rows
from symdyn.emit.print.written_page import equation_lines, rate_lines, rate_sections, symbol_table
from symdyn.emit.render import in_latex
from symdyn.errors import DerivationError, EmitError
from symdyn.frozen import dataclass
from symdyn.graph import Graph, evaluate, gradient
from symdyn.rounding import digits_or, requested_digits
from symdyn.scene import Scene
from symdyn.spatial import Vec
from symdyn.unlocked import cached_property

AXES = "xyz"


def kane(scene: Scene) -> Iterator[EquationGroup]:
    """Yield for every rigid part its partial velocities and F_r*, then F_r + F_r* = 0 for every velocity.

    Raises:
        EmitError: more than anyone reads.
    """
    w = ordered_workspace(scene, "Kane's equations")
    system, n = w.kane, range(w.state.n)
    shares = [part.along(part.inertia_force) for part in system.bodies]
    active, inertia, rotors = system.active_forces(), system.inertia_forces(), system.rotor_forces()
    own = bool(w.state.spheres)  # axes of the ground are long in quaternions, and velocities are along the body's
    shown = [
        [part.R.T @ v if own else v for v in (part.v, part.w, *(v for twist in part.partial for v in twist))]
        for part in system.bodies
    ]
    nodes = [x for vectors in shown for v in vectors for x in v]
    write = written_forms(w, [*nodes, *(x for share in shares for x in share), *active, *inertia, *rotors])
    named, forces = drive_symbols(scene), fresh(scene, ("F", "Q", "Fr"), n)
    for part, vectors, share in zip(system.bodies, shown, shares, strict=True):
        rows = list[EquationRow]()
        for i, v in enumerate(vectors):
            rows += _vector("vw"[i % 2], v, write, *([i // 2 - 1] if i > 1 else []))
        rows += _forces(forces, "*", map(write, share))
        axes = "axes of the body" if own else "ground axes"
        text = f"velocities, partial velocities ({axes}), and its share of F*; what is not listed is 0"
        yield EquationGroup(f"body:{part.body}", f"{part.body}", text, nonzero_rows(rows))
    if turned := nonzero_rows(_forces(forces, "*", map(write, rotors))):
        yield EquationGroup("rotors", "Rotors", "the share of the armatures of joints in F*", turned)
    rows = _forces(forces, "", (Form.sum((named[r], write(x))) for r, x in zip(n, active, strict=True)))
    yield EquationGroup("active", "Active forces", "weights, drives, and what else does work", tuple(rows))
    sums = [Form.sum((named[r], write(active[r]), write(inertia[r]))) for r in n]
    rows = [EquationRow("0", "0", x) for x in sums]
    yield EquationGroup("kane", "Kane's equations", "0 = F + F*", tuple(rows), "$F_r + F_r^* = 0$:")


def appell(scene: Scene) -> Iterator[EquationGroup]:
    """Yield S, without what holds no acceleration, and ∂S/∂u̇ = Q for every velocity."""
    w = ordered_workspace(scene, "Appell's equations")
    total, active = w.kane.gibbs_function(), w.kane.active_forces()
    slopes = gradient(total, w.state.qdd)
    write = written_forms(w, [total, *slopes, *active])
    text = "S = sum of m a^2/2 and of what turns, without what holds no acceleration"
    yield EquationGroup("gibbs", "Function of Gibbs and Appell", text, (named_row(scene, "S", write(total)),))
    sides = zip(slopes, drive_symbols(scene), active, strict=True)
    rows = [EquationRow("0", "0", Form.sum((write(x), tau.negative, write(F).negative))) for x, tau, F in sides]
    latex = r"$\partial S/\partial \dot u_r - Q_r = 0$:"
    yield EquationGroup("appell", "Appell's equations", "0 = dS/dudot - Q", tuple(rows), latex)


def _forces(names: Sequence[str], star: str, forms: Iterable[Form]) -> list[EquationRow]:
    """Return rows of generalized forces: active ones, or, with a star, those of inertia."""
    return [
        EquationRow(f"{name}{star}", f"{name[0]}{'^' * bool(star)}{star}_{{{r + 1}}}", form, f"F{star}", (r,))
        for r, (name, form) in enumerate(zip(names, forms, strict=True))
    ]


def _vector(letter: str, v: Vec, write: Forms, *place: int) -> list[EquationRow]:
    """Return rows of a velocity v or w, or, with the number of a generalized speed, of the partial one."""
    shown = r"\omega" if letter == "w" else letter
    index, below = "".join(str(r + 1) for r in place), "".join(f"{r + 1}," for r in place)
    return [
        EquationRow(f"{letter}{index}_{axis}", f"{shown}_{{{below}{axis}}}", write(x), letter, (*place, k))
        for k, (axis, x) in enumerate(zip(AXES, v, strict=True))
    ]


# Udwadia and Kalaba


def udwadia_kalaba(scene: Scene) -> Iterator[EquationGroup]:
    """Yield M and Q of the mechanism without its rows, A and b of these, and what they add.

    Raises:
        DerivationError: there are no rows, or none in closed form; M has no inverse; a motion is prescribed.
    """
    what = "Udwadia and Kalaba's equation"
    if not scene.is_constrained:
        raise DerivationError(
            f"{scene.name}: {what} is about constraints, and no loop and no row ties this mechanism; print Lagrange's "
            "equations"
        )
    refuse_led(scene, what)
    page, n = Printable.of(scene, lengths=None), range(len(scene.velocities))
    if page.constraints.missing:
        raise DerivationError(
            f"{scene.name}: {what} is written with constraints in closed form, and these have none: "
            f"{page.constraints.missing}; generate the output constraint_forces"
        )
    M = [[c.form for c in page.inertia(i)] for i in n]
    Q = [Form.sum((page.right[i], page.coriolis(i).negative, page.gravity(i).negative)) for i in n]
    M_, Q_, A_, b_ = (named_row(scene, letter, Number.ZERO) for letter in "MQAb")
    rows = [entry_row(scene, "M", M[i][j], i, j) for i in n for j in n if i <= j]
    rows += [entry_row(scene, "Q", Q[i], i) for i in n]
    what_is_not = "as if nothing tied the velocities; what is not listed is 0"
    text, latex = f"{M_.name} a = {Q_.name}, {what_is_not}", rf"${M_.latex} a = {Q_.latex}$, {what_is_not}:"
    yield EquationGroup("free", "Without constraints", text, nonzero_rows(rows), latex)
    A, b = (
        [row.G for row in page.constraints.rows],
        [(row.bias or Number.ZERO).negative for row in page.constraints.rows],
    )
    rows = [entry_row(scene, "A", x, k, j) for k, row in enumerate(A) for j, x in enumerate(row)]
    rows += [entry_row(scene, "b", x, k) for k, x in enumerate(b)]
    spare = len(Workspace(scene).loops.recursive.G) - len(A)
    left_out = f"; {spare} more rows follow from these, and leave the forces below as they are" if spare else ""
    text, latex = f"{A_.name} udot = {b_.name}{left_out}", rf"${A_.latex} \dot u = {b_.latex}${left_out}:"
    yield EquationGroup("constraints", "Constraints", text, nonzero_rows(rows), latex)
    graph = Graph()
    solve(range(-1, len(n)), [[x.express(graph) for x in row] for row in M], [x.express(graph) for x in Q])
    inverse = f"{M_.latex}^{{-1}}"
    pseudo = f"({A_.latex} {inverse} {A_.latex}^T)^+"
    added = f"{A_.latex}^T {pseudo} ({b_.latex} - {A_.latex} {inverse} {Q_.latex})"
    spelled = f"{A_.name}^T ({A_.name} {M_.name}^-1 {A_.name}^T)^+ ({b_.name} - {A_.name} {M_.name}^-1 {Q_.name})"
    forces = _constraint_forces(M, Q, A, b)
    if forces is None:
        text, latex = f"{M_.name} udot = {Q_.name} + {spelled}", rf"${M_.latex} \dot u = {Q_.latex} + {added}$."
        yield EquationGroup("added", "Udwadia and Kalaba's equation", text, (), latex)
        return
    rows = [entry_row(scene, "Q_c", x, i) for i, x in enumerate(forces)]
    text = f"{M_.name} udot = {Q_.name} + Q_c, Q_c = {spelled}; what is not listed is 0"
    latex = rf"${M_.latex} \dot u = {Q_.latex} + Q_c$, $Q_c = {added}$; what is not listed is 0:"
    yield EquationGroup("added", "Udwadia and Kalaba's equation", text, nonzero_rows(rows), latex)


def _constraint_forces(
    M: list[list[Form]], Q: list[Form], A: list[tuple[Form, ...]], b: list[Form]
) -> list[Form] | None:
    """Return Aᵀ (A M⁻¹ Aᵀ)⁻¹ (b - A M⁻¹ Q) of independent rows, None where that is too long to read."""
    graph, n, m = Graph(), range(len(M)), range(len(A))
    nodes = [x.express(graph) for x in (*(x for row in M for x in row), *Q, *(x for row in A for x in row), *b)]
    try:
        field = Ratios(nodes)
        found = iter(evaluate(nodes, field, field.values()))
        inertia = [[next(found) for _ in n] for _ in n]
        acting = [[next(found)] for _ in n]
        rows = [[next(found) for _ in n] for _ in m]
        transposed = [list(column) for column in zip(*rows, strict=True)]
        right = [[next(found)] for _ in m]
        sides = field.solved(inertia, [[*x, *y] for x, y in zip(acting, transposed, strict=True)])
        free = field.product(rows, [x[:1] for x in sides])
        rest = [[field.sub(x, y)] for (x,), (y,) in zip(right, free, strict=True)]
        sizes = field.solved(field.product(rows, [x[1:] for x in sides]), rest)
        forces = [field.form(x) for (x,) in field.product(transposed, sizes)]
    except TOO_LONG:
        return None
    longest = max(sum(1 for _ in force.walk()) for force in forces)
    return forces if longest <= 4 * LONGEST else None


PAGES: dict[str, Callable[[Scene], Iterator[EquationGroup]]] = {
    "hamilton": hamilton,
    "routh": routh,
    "kane": kane,
    "gibbs-appell": appell,
    "udwadia-kalaba": udwadia_kalaba,
    "port-hamiltonian": port_hamiltonian,
    "contact": contact,
    "inverse-kinematics": inverse_kinematics,
}
"""Formulations beside Lagrange's and D'Alembert's, and what is printed in place of them, by what writes its page."""


@dataclass(frozen=True)
class FormulationPage:
    """A scene's equations by one formulation, "lagrange" or a key of `PAGES`, as they are printed."""

    scene: Scene
    formulation: str

    @cached_property
    def groups(self) -> tuple[EquationGroup, ...]:
        """Equations by title, none by Lagrange; DerivationError where the scene has no such formulation, and why."""
        return () if self.formulation == "lagrange" else tuple(PAGES[self.formulation](self.scene))

    @cached_property
    def forms(self) -> list[Form]:
        """All formulas; of Lagrange's equations both sides."""
        if self.formulation != "lagrange":
            return [row.form for group in self.groups for row in group.rows]
        page = Printable.of(self.scene)
        return [side(i) for i in range(len(page.rows)) for side in (page.left, page.driving)]

    @property
    def operations(self) -> int:
        """Multiplications, additions and divisions that all formulas take together, what is shared once."""
        graph = Graph()
        entries = tuple(form.express(graph) for form in self.forms)
        counts = Counts.of(Function("page", "", (), "", (len(entries),), entries, "", self.formulation))
        return counts.multiplications + counts.additions + counts.divisions

    def refuse_too_long(self) -> None:
        """Raise EmitError where there are more formulas than are written."""
        instead = "symdyn generate writes code, which has no such limit"
        refuse_too_long(self.scene.name, f"{self.formulation}:", self.forms, instead)


def formulation_text(scene: Scene, formulation: str, format: str = "latex", document: bool = False) -> str:
    """Return a formulation in LaTeX, a whole document of it where that is asked for, as plain text, or as Python.

    Raises:
        EmitError: another format, a document of text, or more than anybody reads.
        DerivationError: the scene has no such formulation, and why.
    """
    if document and format != "latex":
        raise EmitError(f"{formulation}: a document is written in LaTeX, not as {format}")
    page = FormulationPage(scene, formulation)
    page.refuse_too_long()
    groups, forms = page.groups, page.forms
    if format == "sympy":
        rows = [(group.key.replace(":", "_"), row.name, row.form) for group in groups for row in group.rows]
        return sympy_rows(scene, [*rows, *(("rate", name, form) for name, form in other_rates(scene))])
    if format == "text":
        return "\n".join(["\n\n".join(map(_text, groups)), *rate_lines(scene)])
    symbols = latex_symbols(scene, (), [name for group in groups for name in group.letters])
    entries = {row.name: row.latex for group in groups for row in group.rows if row.place}
    write = Latex(entries | symbols, digits_or(DIGITS))
    sections = [*(_section(group, write) for group in groups), *rate_sections(scene, write)]
    if not document:
        return "\n\n".join(f"\\paragraph{{{s['title']}.}} {s['text']}\n{s['body']}" for s in sections)
    from symdyn.emit.render import render

    table = symbol_table(scene, write, any("t" in form.symbols for form in forms))
    values = any(row["value"] for row in table)
    title = in_latex(scene.name)
    inside = {"title": title, "comment": scene.name, "sections": sections, "symbols": table, "values": values}
    return render("latex/equations.tex.jinja", inside)


def _text(group: EquationGroup) -> str:
    rows = (equation_lines(row.name, broken_text(rounded(row.form, requested_digits() or 15))) for row in group.rows)
    return "\n".join((f"# {group.title}: {group.text}", *rows))


def _section(group: EquationGroup, write: Latex) -> dict[str, str]:
    pairs = [(write.symbols.get(row.latex, row.latex), write(row.form)) for row in group.rows]
    text = group.latex or f"{group.text[0].upper()}{in_latex(group.text[1:])}:"
    return {"title": in_latex(group.title), "text": text, "body": "\n".join(definitions(pairs))}
