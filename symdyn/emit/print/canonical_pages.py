r"""Pages of equations in momenta: Hamilton's canonical equations, Routh's reduction, port-Hamiltonian form.

References: Goldstein, Classical Mechanics (1980), 8.1, 8.3 and 9.5; van der Schaft and Jeltsema, Port-Hamiltonian
Systems Theory (2014), 2.1 and 4.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from symdyn.algebra import Form, Number, Ratios, Symbol
from symdyn.dynamics import ClosedForm, Workspace
from symdyn.emit.print.formulation_groups import (
    LONGEST,
    TOO_LONG,
    EquationGroup,
    EquationRow,
    entry_row,
    fresh,
    named_row,
    nonzero_rows,
    open_form,
    ordered_workspace,
    quotient,
    written_forms,
)
from symdyn.emit.print.printable import Printable
from symdyn.emit.render import in_latex
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, gradient, substitute, tangents
from symdyn.scene import Scene


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
    names = fresh(scene, ("p", "P", "Pi"), own)
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
        rates = [quotient(closed, field.form(x).express(graph)) for (x,) in solved]
    except TOO_LONG:
        return _Momenta(names, p, forms, None)
    longest = max(sum(1 for _ in rate.walk()) for rate in rates)
    return _Momenta(names, p, forms, rates if longest <= 4 * LONGEST else None)


def hamilton(scene: Scene) -> Iterator[EquationGroup]:
    """Yield momenta, H, and the canonical equations.

    Raises:
        DerivationError: rows tie the coordinates, a motion is prescribed, or there is no closed form.
    """
    closed = open_form(scene, "Hamilton's equations")
    page, graph, every = Printable.of(closed, lengths=None), closed.state.q[0].graph, range(closed.n)
    found = _momenta(closed, every)
    rows = [EquationRow(name, name, form) for name, form in zip(found.names, found.forms, strict=True)]
    yield EquationGroup(
        "momenta", "Momenta", "p = dL/dqd", tuple(rows), r"$p_i = \partial L/\partial \dot q_i$:", found.names
    )
    try:
        rates = [form.express(graph) for form in found.rates or ()]
        work = graph.total(p * rate for p, rate in zip(found.nodes, rates, strict=True)) / 2
        kinetic = quotient(closed, work)
        slopes = [quotient(closed, x).negative for x in gradient(kinetic.express(graph), closed.state.q)]
        text = r"$\dot q_i = \partial H/\partial p_i$, $\dot p_i = -\partial H/\partial q_i + Q_i$:"
        rows = [EquationRow(u, u, rate) for u, rate in zip(scene.velocities, found.rates or (), strict=True)]
    except TOO_LONG:
        slopes = [closed.compactor(closed.ring.derivative(closed.K, q)) for q in closed.state.q]
        kinetic, rows = closed.form("K"), []
        text = r"$\dot q$ follows from the momenta above, $M \dot q = p$; $\dot p_i = \partial L/\partial q_i + Q_i$:"
    row = named_row(scene, "H", Form.sum((kinetic, page.P)))
    yield EquationGroup("hamiltonian", "Hamiltonian", "H = p.qd - L", (row,), r"$H = \sum p_i \dot q_i - L$:")
    for i, (name, slope) in enumerate(zip(found.names, slopes, strict=True)):
        form = Form.sum((slope, page.gravity(i).negative, page.right[i]))
        rows.append(EquationRow(f"{name}_dot", f"{name}_dot", form))
    yield EquationGroup("canonical", "Canonical equations", "qd = dH/dp, pd = -dH/dq + Q", tuple(rows), text)
    if cyclic := Workspace(scene).cyclic:
        names = ", ".join(scene.coordinates[k] for k in cyclic)
        text = f"{{p, H}} = dp/dt = 0, as nothing depends on {names}"
        kept = tuple(EquationRow(f"{found.names[k]}_dot", f"{found.names[k]}_dot", Number.ZERO) for k in cyclic)
        latex = rf"$\{{p, H\}} = \dot p = 0$, as nothing depends on {in_latex(names)}:"
        yield EquationGroup("brackets", "Poisson brackets", text, kept, latex)


def port_hamiltonian(scene: Scene) -> Iterator[EquationGroup]:
    """Yield momenta, H, the structure with what dissipates and what else acts, equations, outputs, and the power.

    Raises:
        DerivationError: as of `hamilton`.
    """
    momenta, energy, *motion = hamilton(scene)
    yield from (momenta, energy)
    w = ordered_workspace(scene, "port-Hamiltonian equations")
    u, n, graph = w.state.qd, range(w.state.n), w.graph
    slopes = [[-x for x in gradient(Q, u)] for Q in w.Q]
    write = written_forms(w, [x for row in slopes for x in row])
    linear = [i for i in n if not any(name in write(x).symbols for x in slopes[i] for name in scene.velocities)]
    pairs = [(i, j) for i in linear for j in linear]
    rest = [Q + graph.total(slopes[i][j] * u[j] for k, j in pairs if k == i) for i, Q in enumerate(w.Q)]
    lost = {(i, j): (slopes[i][j] + slopes[j][i]) / 2 for i, j in pairs if i <= j}
    turned = {(i, j): (slopes[j][i] - slopes[i][j]) / 2 for i, j in pairs if i < j}
    power = graph.total(Q * x for Q, x in zip(w.Q, u, strict=True))
    write = written_forms(w, [*lost.values(), *turned.values(), *rest, power])
    rows = [entry_row(scene, "R", write(x), *place) for place, x in lost.items()]
    rows += [entry_row(scene, "J", write(x), *place) for place, x in turned.items()]
    rows += [entry_row(scene, "F", write(x), i) for i, x in enumerate(rest)]
    J, R, F = (named_row(scene, letter, Number.ZERO) for letter in "JRF")
    text = (
        f"d/dt (q, p) = ([0, 1; -1, {J.name}] - [0, 0; 0, {R.name}]) grad H + (0, tau + {F.name}); "
        "what is not listed is 0"
    )
    latex = (
        r"$\frac{d}{dt} \begin{bmatrix} q \\ p \end{bmatrix} = \begin{bmatrix} 0 & 1 \\ -1 & "
        rf"{J.latex} - {R.latex} \end{{bmatrix}} \nabla H + \begin{{bmatrix}} 0 \\ \tau + {F.latex} \end{{bmatrix}}$; "
        "what is not listed is 0:"
    )
    yield EquationGroup("structure", "Structure", text, nonzero_rows(rows), latex)
    yield from motion
    driven = [k for k, drive in enumerate(scene.drives) if drive]
    outputs = tuple(entry_row(scene, "y", Symbol(scene.velocities[k]), k) for k in driven)
    if outputs:
        latex = r"$y = \partial H/\partial p$, one a drive:"
        yield EquationGroup("outputs", "Outputs", "y = dH/dp, one a drive", outputs, latex)
    given = (
        Form.product((Symbol(drive), row.form)) for drive, row in zip(filter(None, scene.drives), outputs, strict=True)
    )
    H = energy.rows[0]
    balance = EquationRow(f"{H.name}_dot", rf"\dot{{{H.latex}}}", Form.sum((*given, write(power))))
    text = f"dH/dt = y.tau - qd.{R.name} qd + qd.{F.name}"
    latex = rf"$\dot H = y \cdot \tau - \dot q \cdot {R.latex} \dot q + \dot q \cdot {F.latex}$:"
    yield EquationGroup("power", "Power", text, (balance,), latex)


def routh(scene: Scene) -> Iterator[EquationGroup]:
    """Yield the constant momenta, Routh's function, and the equations that are left.

    Raises:
        DerivationError: no coordinate is cyclic, all are, or as of `hamilton`.
    """
    closed = open_form(scene, "Routh's equations")
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
    rows = [EquationRow(name, name, form) for name, form in zip(found.names, found.forms, strict=True)]
    names = ", ".join(scene.coordinates[i] for i in cyclic)
    text = f"nothing depends on {names}"
    yield EquationGroup("constant", "Constant momenta", text, tuple(rows), f"N{in_latex(text)[1:]}:", found.names)
    rates = [
        EquationRow(scene.velocities[i], scene.velocities[i], rate) for i, rate in zip(cyclic, found.rates, strict=True)
    ]
    yield EquationGroup("cyclic", "Cyclic velocities", "from these", tuple(rates))
    known = {closed.state.qd[i]: rate.express(graph) for i, rate in zip(cyclic, found.rates, strict=True)}
    K, state, others = closed.form("K").express(graph), closed.state, [i for i in range(closed.n) if i not in cyclic]
    given = graph.total(p * known[state.qd[i]] for p, i in zip(found.nodes, cyclic, strict=True))
    held = substitute([*gradient(K, state.q), *gradient(K, state.qd)], known)
    try:
        momenta = [quotient(closed, held[closed.n + i]).express(graph) for i in others]
        twice = graph.total(p * state.qd[i] for p, i in zip(momenta, others, strict=True)) - given
        (rest,) = substitute([twice], {state.qd[i]: graph.zero for i in others})  # by itself: the effective potential
        R = Form.sum((quotient(closed, (twice - rest) / 2), quotient(closed, rest / 2)))
        inertial = [quotient(closed, rate) for rate in tangents(momenta, state.acceleration)]
        slopes = [quotient(closed, held[i]).negative for i in others]  # dR/dq at p held is dL/dq
    except TOO_LONG:
        raise DerivationError(
            f"{scene.name}: Routh's function is too long to be read; generate the output routhian"
        ) from None
    row = named_row(scene, "R", Form.sum((R, page.P.negative)))
    yield EquationGroup("routhian", "Routh's function", "R = L - sum of p qd", (row,), r"$R = L - \sum p_i \dot q_i$:")
    sums = (
        Form.sum((rate, slope, page.gravity(i), page.right[i].negative))
        for i, rate, slope in zip(others, inertial, slopes, strict=True)
    )
    left = [EquationRow("0", "0", form) for form in sums]
    latex = r"$\frac{d}{dt} \partial R/\partial \dot q_i - \partial R/\partial q_i - Q_i = 0$:"
    yield EquationGroup("left", "Equations that are left", "0 = d/dt dR/dqd - dR/dq - Q", tuple(left), latex)
