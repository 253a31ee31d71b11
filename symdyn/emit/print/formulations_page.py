r"""Other formulations in print: Hamilton's canonical equations, Kane's, Gibbs' and Appell's, Routh's reduction.

    hamilton        p = ∂L/∂q̇, H(q, p) = p·q̇ - L, q̇ = ∂H/∂p, ṗ = -∂H/∂q + Q
    routh           R = L - Σ p q̇ over coordinates on which nothing depends: their momenta p are constant
    kane            F_r + F_r* = 0, body by body, by partial velocities
    gibbs-appell    S = Σ ½ a·m a + ½ α·I α + α·(ω × I ω), ∂S/∂u̇_r = Q_r

References: Goldstein, Classical Mechanics (1980), 8.1 and 8.3; Kane and Levinson, Dynamics (1985), section 4.11; Gibbs,
On the fundamental formulae of dynamics (1879).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from symdyn.algebra import Form, Number, Ratios, Sum, Symbol
from symdyn.arguments import argument
from symdyn.dynamics import ClosedForm, Workspace, angle_groups, closed_form
from symdyn.emit.print.breaking import DIGITS, definitions, refuse_too_long
from symdyn.emit.print.formula_text import Forms, Latex, broken_text, in_sines, rounded
from symdyn.emit.print.printable import Printable
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.emit.print.written_page import equation_lines, rate_lines, rate_sections, symbol_table
from symdyn.emit.render import in_latex
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Expr, evaluate, gradient, substitute, tangents
from symdyn.rounding import digits_or, requested_digits
from symdyn.scene import Scene
from symdyn.spatial import Vec

LONGEST = 30
"""Terms and factors of a solved velocity up to which it is put in; longer ones stay a linear system."""


TOO_LONG = (DerivationError, OverflowError, ValueError, ZeroDivisionError)
"""What says that there is no quotient that is short enough; a list of other length is one that was not solved for."""


@dataclass(frozen=True)
class Row:
    """One equation: its left side as text and in LaTeX, and the formula on the right."""

    name: str
    latex: str
    form: Form


@dataclass(frozen=True)
class Group:
    """Equations under a title.

    Attributes:
        text: what is said of them, in plain words.
        latex: the same with formulas in LaTeX; "" where it is the same.
        letters: names of its own that have rates, as coordinates do.
    """

    title: str
    text: str
    rows: tuple[Row, ...]
    latex: str = ""
    letters: Sequence[str] = ()


def _quotient(closed: ClosedForm, node: Expr) -> Form:
    """Return a node as a quotient in factors, each sum as short as sines can write it."""
    form = Ratios.form_of(node)
    return Form.product(_short(closed, one) if isinstance(one, Sum) else one for one in form.factors)


def _short(closed: ClosedForm, form: Form) -> Form:
    node = form.express(closed.state.q[0].graph)
    return in_sines([node], closed.state, closed.parallel)(node)


def _refuse_rows(scene: Scene, what: str) -> None:
    """Raise DerivationError where rows tie the coordinates, or a motion is prescribed."""
    if scene.is_constrained:
        raise DerivationError(
            f"{scene.name}: {what} are written in independent coordinates, and loops or rows tie these; "
            "print Lagrange's equations with multipliers, or D'Alembert's system"
        )
    if scene.prescribed_velocities:
        raise DerivationError(
            f"{scene.name}: {what} are written without prescribed motions; print Lagrange's equations"
        )


def _open(scene: Scene, what: str) -> ClosedForm:
    """Return the closed form of a scene that no row ties."""
    _refuse_rows(scene, what)
    return closed_form(scene)


def _fresh(scene: Scene, letters: Sequence[str], index: Sequence[int] = ()) -> list[str]:
    """Return a letter, or one for each index where there are several velocities: the first that the scene has not."""
    taken = {one.name for one in (*scene.parameters, *scene.given)} | {*filter(None, scene.drives)}
    taken |= {*scene.coordinates, *scene.velocities}
    names = [[f"{x}{i + 1}" for i in index] if index and len(scene.velocities) > 1 else [x] for x in letters]
    return next((one for one in names if not taken.intersection(one)), [f"{name}_" for name in names[-1]])


# Hamilton and Routh


@dataclass(frozen=True)
class _Momenta:
    """Momenta of some velocities, and these velocities solved for, None where that is too long to read."""

    names: list[str]
    nodes: list[Expr]
    forms: list[Form]
    rates: list[Form] | None


def _momenta(closed: ClosedForm, own: Sequence[int]) -> _Momenta:
    """Return p_i = Σ_j M_ij q̇_j of some velocities; those solve p - M_other q̇_other = M_own q̇_own."""
    scene, graph = closed.scene, closed.state.q[0].graph
    names = _fresh(scene, ("p", "P", "Pi"), own)
    M = [[closed.form("k_z", i, j) for j in range(closed.n)] for i in own]
    forms = [Form.sum(Form.product((m, Symbol(u))) for m, u in zip(row, scene.velocities, strict=True)) for row in M]
    p = [graph.symbol(name) for name in names]
    rest = [
        p[k] - graph.total(row[j].express(graph) * closed.state.qd[j] for j in range(closed.n) if j not in own)
        for k, row in enumerate(M)
    ]
    A = [[row[j].express(graph) for j in own] for row in M]
    try:
        field = Ratios([*rest, *(x for row in A for x in row)])
        values = field.values()
        solved = field.solved([evaluate(row, field, values) for row in A], [[x] for x in evaluate(rest, field, values)])
        rates = [_quotient(closed, field.form(x).express(graph)) for (x,) in solved]
    except TOO_LONG:
        return _Momenta(names, p, forms, None)
    longest = max(sum(1 for _ in rate.walk()) for rate in rates)
    return _Momenta(names, p, forms, rates if longest <= 4 * LONGEST else None)


def hamilton(scene: Scene) -> Iterator[Group]:
    """Yield momenta, H, and the canonical equations.

    Raises:
        DerivationError: rows tie the coordinates, a motion is prescribed, or there is no closed form.
    """
    closed = _open(scene, "Hamilton's equations")
    page, graph, every = Printable.of(closed, lengths=None), closed.state.q[0].graph, range(closed.n)
    found = _momenta(closed, every)
    rows = [Row(name, name, form) for name, form in zip(found.names, found.forms, strict=True)]
    yield Group("Momenta", "p = dL/dqd", tuple(rows), r"$p_i = \partial L/\partial \dot q_i$:", found.names)
    try:
        rates = [form.express(graph) for form in found.rates or ()]
        work = graph.total(p * rate for p, rate in zip(found.nodes, rates, strict=True)) / 2
        kinetic = _quotient(closed, work)
        slopes = [_quotient(closed, x).negative for x in gradient(kinetic.express(graph), closed.state.q)]
        text = r"$\dot q_i = \partial H/\partial p_i$, $\dot p_i = -\partial H/\partial q_i + Q_i$:"
        rows = [Row(u, u, rate) for u, rate in zip(scene.velocities, found.rates or (), strict=True)]
    except TOO_LONG:
        slopes = [closed.compactor(closed.ring.derivative(closed.K, q)) for q in closed.state.q]
        kinetic, rows = closed.form("K"), []
        text = r"$\dot q$ follows from the momenta above, $M \dot q = p$; $\dot p_i = \partial L/\partial q_i + Q_i$:"
    H = Form.sum((kinetic, page.P))
    yield Group("Hamiltonian", "H = p.qd - L", (_named(scene, "H", H),), r"$H = \sum p_i \dot q_i - L$:")
    for i, (name, slope) in enumerate(zip(found.names, slopes, strict=True)):
        form = Form.sum((slope, page.gravity(i).negative, page.right[i]))
        rows.append(Row(f"{name}_dot", f"{name}_dot", form))
    yield Group("Canonical equations", "qd = dH/dp, pd = -dH/dq + Q", tuple(rows), text)


def routh(scene: Scene) -> Iterator[Group]:
    """Yield the constant momenta, Routh's function, and the equations that are left.

    Raises:
        DerivationError: no coordinate is cyclic, all are, or as of `hamilton`.
    """
    closed = _open(scene, "Routh's equations")
    page, graph = Printable.of(closed, lengths=None), closed.state.q[0].graph
    cyclic = Workspace(scene).cyclic
    if not cyclic or len(cyclic) == closed.n:
        which = "every coordinate is" if cyclic else "no coordinate is"
        why = (
            "their momenta are constant, which solves it"
            if cyclic
            else "each has a force, or the energies depend on it"
        )
        raise DerivationError(f"{scene.name}: Routh's equations do not exist: {which} cyclic; {why}")
    found = _momenta(closed, cyclic)
    if found.rates is None:
        raise DerivationError(
            f"{scene.name}: the cyclic velocities are too long to be put in; print Lagrange's equations"
        )
    rows = [Row(name, name, form) for name, form in zip(found.names, found.forms, strict=True)]
    names = ", ".join(scene.coordinates[i] for i in cyclic)
    text = f"nothing depends on {names}"
    yield Group("Constant momenta", text, tuple(rows), f"N{in_latex(text)[1:]}:", found.names)
    rates = [Row(scene.velocities[i], scene.velocities[i], rate) for i, rate in zip(cyclic, found.rates, strict=True)]
    yield Group("Cyclic velocities", "from these", tuple(rates))
    known = {closed.state.qd[i]: rate.express(graph) for i, rate in zip(cyclic, found.rates, strict=True)}
    (kinetic,) = substitute([closed.form("K").express(graph)], known)
    given = graph.total(p * known[closed.state.qd[i]] for p, i in zip(found.nodes, cyclic, strict=True))
    R = _quotient(closed, kinetic - given)
    yield Group("Routh's function", "R = L - sum of p qd", (_named(scene, "R", Form.sum((R, page.P.negative))),),
                r"$R = L - \sum p_i \dot q_i$:")  # fmt: skip
    node, left, order = R.express(graph), [], closed.state
    for i in (i for i in range(closed.n) if i not in cyclic):
        (momentum,) = gradient(node, [order.qd[i]])
        (inertial,) = tangents([momentum], order.acceleration)
        (slope,) = gradient(node, [order.q[i]])
        form = Form.sum((_quotient(closed, inertial), _quotient(closed, slope).negative, page.gravity(i)))
        left.append(Row("0", "0", Form.sum((form, page.right[i].negative))))
    latex = r"$\frac{d}{dt} \partial R/\partial \dot q_i - \partial R/\partial q_i - Q_i = 0$:"
    yield Group("Equations that are left", "0 = d/dt dR/dqd - dR/dq - Q", tuple(left), latex)


def _named(scene: Scene, letter: str, form: Form) -> Row:
    """Return the row of a function by its letter, which is calligraphic where the scene has that letter."""
    (name,) = _fresh(scene, (letter, f"{letter}_cal"))
    return Row(name, letter if name == letter else rf"\mathcal{{{letter}}}", form)


# Kane, Gibbs and Appell


AXES = "xyz"


def _workspace(scene: Scene, what: str) -> Workspace:
    """Return a workspace whose symbols are born in the order in which formulas name them."""
    _refuse_rows(scene, what)
    w = Workspace(scene)
    for name in (*(one.name for one in scene.parameters), *scene.coordinates):
        w.graph.symbol(name)
    return w


def _written(w: Workspace, nodes: Sequence[Expr]) -> Forms:
    return in_sines(nodes, w.state, angle_groups(w.scene, w.graph))


def kane(scene: Scene) -> Iterator[Group]:
    """Yield for every rigid part its partial velocities and F_r*, then F_r + F_r* = 0 for every velocity.

    Raises:
        EmitError: more than anyone reads.
    """
    w = _workspace(scene, "Kane's equations")
    system, n = w.kane, range(w.state.n)
    shares = [part.along(part.inertia_force) for part in system.bodies]
    active, inertia, rotors = system.active_forces(), system.inertia_forces(), system.rotor_forces()
    nodes = [x for part in system.bodies for twist in part.partial for v in twist for x in v]
    nodes += [x for part in system.bodies for x in (*part.v, *part.w)]
    write = _written(w, [*nodes, *(x for share in shares for x in share), *active, *inertia, *rotors])
    named, forces = _drives(scene), _fresh(scene, ("F", "Q", "Fr"), n)
    for part, share in zip(system.bodies, shares, strict=True):
        rows = [*_vector("v", part.v, write), *_vector("w", part.w, write)]
        for r, twist in zip(n, part.partial, strict=True):
            rows += [*_vector(f"v{r + 1}", twist[0], write), *_vector(f"w{r + 1}", twist[1], write)]
        rows += [Row(f"{forces[r]}*", rf"F^*_{{{r + 1}}}", write(x)) for r, x in zip(n, share, strict=True)]
        text = "velocities, partial velocities (ground axes), and its share of F*; what is not listed is 0"
        yield Group(f"{part.body}", text, tuple(row for row in rows if row.form != Number.ZERO))
    turned = [Row(f"{forces[r]}*", rf"F^*_{{{r + 1}}}", write(x)) for r, x in zip(n, rotors, strict=True)]
    if rows := [row for row in turned if row.form != Number.ZERO]:
        yield Group("Rotors", "the share of the armatures of joints in F*", tuple(rows))
    rows = [Row(forces[r], f"F_{{{r + 1}}}", Form.sum((named[r], write(x)))) for r, x in zip(n, active, strict=True)]
    yield Group("Active forces", "weights, drives, and what else does work", tuple(rows))
    sums = [Form.sum((named[r], write(active[r]), write(inertia[r]))) for r in n]
    yield Group("Kane's equations", "0 = F + F*", tuple(Row("0", "0", x) for x in sums), "$F_r + F_r^* = 0$:")


def appell(scene: Scene) -> Iterator[Group]:
    """Yield S, without what holds no acceleration, and ∂S/∂u̇ = Q for every velocity."""
    w = _workspace(scene, "Appell's equations")
    total, active = w.kane.gibbs_function(), w.kane.active_forces()
    slopes = gradient(total, w.state.qdd)
    write = _written(w, [total, *slopes, *active])
    named = _drives(scene)
    text = "S = sum of m a^2/2 and of what turns, without what holds no acceleration"
    yield Group("Function of Gibbs and Appell", text, (_named(scene, "S", write(total)),))
    rows = [Row(f"dS/d{u}_dot", "", write(x)) for u, x in zip(scene.velocities, slopes, strict=True)]
    sums = [Form.sum((row.form, named[r].negative, write(active[r]).negative)) for r, row in enumerate(rows)]
    yield Group("Appell's equations", "0 = dS/dudot - Q", tuple(Row("0", "0", x) for x in sums),
                r"$\partial S/\partial \dot u_r - Q_r = 0$:")  # fmt: skip


def _vector(name: str, v: Vec, write: Forms) -> list[Row]:
    letter, index = name[0], name[1:]
    shown = r"\omega" if letter == "w" else "v"
    return [
        Row(f"{name}_{axis}", f"{shown}_{{{index + ',' if index else ''}{axis}}}", write(x))
        for axis, x in zip(AXES, v, strict=True)
    ]


def _drives(scene: Scene) -> list[Form]:
    return [Symbol(drive) if drive else Number.ZERO for drive in scene.drives]


PAGES: dict[str, Callable[[Scene], Iterator[Group]]] = {
    "hamilton": hamilton,
    "routh": routh,
    "kane": kane,
    "gibbs-appell": appell,
}
"""Formulations beside Lagrange's and D'Alembert's, each by what writes its page."""


def formulation_text(scene: Scene, formulation: str, format: str = "latex", document: bool = False) -> str:
    """Return a formulation in LaTeX, a whole document of it where that is asked for, or as plain text.

    Raises:
        EmitError: another format, a document of text, or more than anybody reads.
        DerivationError: the scene has no such formulation, and why.
    """
    if format not in ("latex", "text") or (format == "text" and document):
        told = f"without {argument('document')}"
        raise EmitError(f"{formulation}: it is written in LaTeX and, {told}, as text, not as {format}")
    groups = list(PAGES[formulation](scene))
    forms = [row.form for group in groups for row in group.rows]
    refuse_too_long(scene.name, f"{formulation}:", forms, "symdyn generate writes code, which has no such limit")
    if format == "text":
        return "\n".join(["\n\n".join(map(_text, groups)), *rate_lines(scene)])
    write = Latex(latex_symbols(scene, (), [name for group in groups for name in group.letters]), digits_or(DIGITS))
    sections = [*(_section(group, write) for group in groups), *rate_sections(scene, write)]
    if not document:
        return "\n\n".join(f"\\paragraph{{{s['title']}.}} {s['text']}\n{s['body']}" for s in sections)
    from symdyn.emit.render import render

    symbols = symbol_table(scene, write, any("t" in form.symbols for form in forms))
    values = any(row["value"] for row in symbols)
    title = in_latex(scene.name)
    inside = {"title": title, "comment": scene.name, "sections": sections, "symbols": symbols, "values": values}
    return render("latex/equations.tex.jinja", inside)


def _text(group: Group) -> str:
    rows = (equation_lines(row.name, broken_text(rounded(row.form, requested_digits() or 15))) for row in group.rows)
    return "\n".join((f"# {group.title}: {group.text}", *rows))


def _section(group: Group, write: Latex) -> dict[str, str]:
    pairs = [(write.symbols.get(row.latex, row.latex), write(row.form)) for row in group.rows]
    text = group.latex or f"{group.text[0].upper()}{in_latex(group.text[1:])}:"
    return {"title": in_latex(group.title), "text": text, "body": "\n".join(definitions(pairs))}
