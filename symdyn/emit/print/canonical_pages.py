r"""Pages of equations in momenta: Hamilton's canonical equations, Routh's reduction, port-Hamiltonian form.

References: Goldstein, Classical Mechanics (1980), 8.1, 8.3 and 9.5; van der Schaft and Jeltsema, Port-Hamiltonian
Systems Theory (2014), 2.1 and 4.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symdyn.algebra import Form, Function, Number, Ratios, Symbol
from symdyn.dynamics import ClosedForm, Workspace
from symdyn.dynamics.mechanism import TIME, State
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
from symdyn.emit.print.printed_names import PrintName
from symdyn.emit.render import in_latex
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, evaluate, gradient, substitute, tangents
from symdyn.scene import Scene
from symdyn.scene.values import velocity_name


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


def _coordinates(scene: Scene, cyclic: Sequence[int]) -> str:
    """Return the names of the coordinates that cyclic velocities are rates of."""
    rates = [velocity_name(q) for q in scene.coordinates]
    return ", ".join(scene.coordinates[rates.index(scene.velocities[k])] for k in cyclic)


@dataclass(frozen=True)
class _Said:
    """How a page says its laws, in rates of coordinates, or in velocities that are none.

    Attributes:
        u, u_i, velocity: what the velocities are called as text, one in LaTeX, all in LaTeX.
        slope: the derivative along velocity i in LaTeX, of what is put in.
        turned: Lie and Poisson's terms of rates of momenta in LaTeX; and what is meant by their letters.
        text: the canonical equations as text.
        blocks: what the structure matrix of port-Hamiltonian form begins with.
    """

    u: str = "qd"
    u_i: str = r"\dot q_i"
    velocity: str = r"\dot q"
    slope: str = r"\partial {}/\partial q_i"
    turned: str = ""
    meant: str = ""
    text: str = "qd = dH/dp, pd = -dH/dq + Q"
    blocks: tuple[str, str] = ("1", "-1")

    @classmethod
    def of(cls, state: State) -> _Said:
        if not state.spheres:
            return cls()
        text = "u = dH/dp, pd = -X H + Q with the terms of Lie and Poisson, p x w; X: derivatives along u"
        turned = r" + \sum \gamma^l_{ji} u_j p_l"
        meant = r", with derivatives $X_i$ along $u_i$ and $[X_j, X_i] = \sum \gamma^l_{ji} X_l$ of Lie and Poisson"
        return cls("u", "u_i", "u", "X_i {}", turned, meant, text, ("X", "-X^T"))


def hamilton(scene: Scene) -> Iterator[EquationGroup]:
    """Yield momenta, H, and the canonical equations.

    Raises:
        DerivationError: rows tie the coordinates, a motion is prescribed, or there is no closed form.
    """
    closed = open_form(scene, "Hamilton's equations")
    page, graph, every = Printable.of(closed, lengths=None), closed.state.q[0].graph, range(closed.n)
    found, along = _momenta(closed, every), closed.slopes.of
    says = _Said.of(closed.state)
    rows = [EquationRow(name, name, form) for name, form in zip(found.names, found.forms, strict=True)]
    yield EquationGroup(
        "momenta", "Momenta", f"p = dL/d{says.u}", tuple(rows), rf"$p_i = \partial L/\partial {says.u_i}$:", found.names
    )
    try:
        rates = [form.express(graph) for form in found.rates or ()]
        work = graph.dot(found.nodes, rates) / 2
        kinetic = quotient(closed, work)
        slopes = [quotient(closed, x).negative for x in along.slopes(kinetic.express(graph))]
        text = rf"${says.u_i} = \partial H/\partial p_i$, $\dot p_i = -{says.slope.format('H')}{says.turned} + Q_i$"
        rows = [EquationRow(u, u, rate) for u, rate in zip(scene.velocities, found.rates or (), strict=True)]
    except TOO_LONG:
        slopes = [closed.compactor(closed.slopes(closed.K, i)) for i in every]
        kinetic, rows, rates = closed.form("K"), [], list(closed.state.qd)
        follows = rf"${says.velocity}$ follows from the momenta above, $M {says.velocity} = p$"
        text = rf"{follows}; $\dot p_i = {says.slope.format('L')}{says.turned} + Q_i$"
    H = Form.sum((kinetic, page.P))
    latex = rf"$H = \sum p_i {says.u_i} - L$:"
    yield EquationGroup("hamiltonian", "Hamiltonian", f"H = p.{says.u} - L", (named_row(scene, "H", H),), latex)
    turned = [
        graph.total(rates[j] * found.nodes[m] * value for j in every for m, value in along.brackets.get((j, i), ()))
        for i in every
    ]
    w = ordered_workspace(scene, "Hamilton's equations")
    lost = w.by_states(w.energy.momenta())
    write = written_forms(w, lost)
    for i, (name, slope) in enumerate(zip(found.names, slopes, strict=True)):
        form = Form.sum((slope, quotient(closed, turned[i]), page.gravity(i).negative, page.right[i], write(lost[i])))
        rows.append(EquationRow(f"{name}_dot", f"{name}_dot", form))
    yield EquationGroup("canonical", "Canonical equations", says.text, tuple(rows), f"{text}{says.meant}:")
    if cyclic := w.cyclic:
        names = _coordinates(scene, cyclic)
        text = f"{{p, H}} = dp/dt = 0, as nothing depends on {names}"
        kept = tuple(EquationRow(f"{found.names[k]}_dot", f"{found.names[k]}_dot", Number.ZERO) for k in cyclic)
        latex = rf"$\{{p, H\}} = \dot p = 0$, as nothing depends on {in_latex(names)}:"
        yield EquationGroup("brackets", "Poisson brackets", text, kept, latex)
    left = [k for k in every if k not in w.cyclic]
    constant = not (scene.states or w.state.clock or w.state.spheres or any(scene.drives))
    if found.rates is not None and len(left) == 1 and constant and not any(form.terms for form in page.right):
        try:
            yield _transformation(closed, found, left[0], H)
        except TOO_LONG:
            return


def _transformation(closed: ClosedForm, found: _Momenta, k: int, H: Form) -> EquationGroup:
    """Return the momentum in Hamilton's characteristic function W, of whose new momenta no coordinate is in H.

    Reference: Goldstein, Classical Mechanics (1980), 10.3.
    """
    scene, graph, p = closed.scene, closed.state.q[0].graph, found.nodes[k]
    (E,) = fresh(scene, ("E", "E_cal"))
    node = H.express(graph)
    (slope,) = gradient(node, [p])
    rest, half = substitute([node, slope / 2], {p: graph.zero})
    square = gradient(slope, [p])[0] / 2
    shift, under = quotient(closed, half / square), (graph.symbol(E) - rest) / square
    name = found.names[k]
    if shift.terms:
        root = Function(Op.SQRT, (quotient(closed, under + (half / square) * (half / square)),))
        row = EquationRow(name, name, Form.sum((root, shift.negative)))
    else:
        row = EquationRow(f"{name}**2", f"{PrintName.of_code(name)}^2", quotient(closed, under))
    others = [(x, q) for i, (x, q) in enumerate(zip(found.names, scene.coordinates, strict=True)) if i != k]
    sums = "".join(f" + {x} {q}" for x, q in others)
    momenta = ", ".join([E, *(x for x, _ in others)])
    text = (
        f"to cyclic coordinates, by W = integral of {name} d{scene.coordinates[k]}{sums} with H = {E}; new "
        f"momenta {momenta} stay, and so do their coordinates, but for dW/d{E} = t"
    )
    return EquationGroup("transformation", "Canonical transformation", text, (row,))


def port_hamiltonian(scene: Scene) -> Iterator[EquationGroup]:
    """Yield momenta, H, the structure with what dissipates and what else acts, equations, outputs, and the power.

    Raises:
        DerivationError: as of `hamilton`.
    """
    momenta, energy, *motion = hamilton(scene)
    yield from (momenta, energy)
    w = ordered_workspace(scene, "port-Hamiltonian equations")
    u, n, graph = w.state.qd, range(w.state.n), w.graph
    acting = [Q + lost for Q, lost in zip(w.Q, w.by_states(w.energy.momenta()), strict=True)]
    slopes = [[-x for x in gradient(Q, u)] for Q in acting]
    write = written_forms(w, [x for row in slopes for x in row])
    linear = [i for i in n if not any(name in write(x).symbols for x in slopes[i] for name in scene.velocities)]
    pairs = [(i, j) for i in linear for j in linear]
    rest = [Q + graph.total(slopes[i][j] * u[j] for k, j in pairs if k == i) for i, Q in enumerate(acting)]
    lost = {(i, j): (slopes[i][j] + slopes[j][i]) / 2 for i, j in pairs if i <= j}
    turned = {(i, j): (slopes[j][i] - slopes[i][j]) / 2 for i, j in pairs if i < j}
    for (j, i), terms in w.directions.brackets.items():
        if i < j:
            by_momenta = graph.total(graph.symbol(momenta.letters[m]) * value for m, value in terms)
            turned[i, j] = turned.get((i, j), graph.zero) + by_momenta
    H = energy.rows[0]
    at_rest = {graph.symbol(TIME): graph.one, **w.state.clock, **dict(zip(w.states, w.state_rates, strict=True))}
    (explicit,) = tangents([H.form.express(graph)], at_rest)  # supports that move, masses that change
    power = graph.total([*(Q * x for Q, x in zip(acting, u, strict=True)), explicit])
    write = written_forms(w, [*lost.values(), *turned.values(), *rest, power])
    rows = [entry_row(scene, "R", write(x), *place) for place, x in lost.items()]
    rows += [entry_row(scene, "J", write(x), *place) for place, x in turned.items()]
    rows += [entry_row(scene, "F", write(x), i) for i, x in enumerate(rest)]
    J, R, F = (named_row(scene, letter, Number.ZERO) for letter in "JRF")
    (upper, lower), listed = _Said.of(w.state).blocks, "what is not listed is 0"
    text = f"d/dt (q, p) = ([0, {upper}; {lower}, {J.name}] - [0, 0; 0, {R.name}]) grad H + (0, tau + {F.name}); "
    text += f"X as in the rates of q; {listed}" if w.state.spheres else listed
    latex = (
        rf"$\frac{{d}}{{dt}} \begin{{bmatrix}} q \\ p \end{{bmatrix}} = \begin{{bmatrix}} 0 & {upper} \\ {lower} & "
        rf"{J.latex} - {R.latex} \end{{bmatrix}} \nabla H + \begin{{bmatrix}} 0 \\ \tau + {F.latex} \end{{bmatrix}}$; "
        f"{listed}:"
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
    balance = EquationRow(f"{H.name}_dot", rf"\dot{{{H.latex}}}", Form.sum((*given, write(power))))
    says, timed = _Said.of(w.state), not explicit.is_zero
    text = f"dH/dt = y.tau - {says.u}.{R.name} {says.u} + {says.u}.{F.name}{' + what H itself changes by' * timed}"
    latex = (
        rf"$\dot H = y \cdot \tau - {says.velocity} \cdot {R.latex} {says.velocity} + {says.velocity} \cdot {F.latex}"
    )
    latex += r" + \partial H/\partial t$:" if timed else "$:"
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
    text = f"nothing depends on {_coordinates(scene, cyclic)}"
    yield EquationGroup("constant", "Constant momenta", text, tuple(rows), f"N{in_latex(text)[1:]}:", found.names)
    says, along = _Said.of(closed.state), closed.slopes.of
    rates = [
        EquationRow(scene.velocities[i], scene.velocities[i], rate) for i, rate in zip(cyclic, found.rates, strict=True)
    ]
    yield EquationGroup("cyclic", "Cyclic velocities", "from these", tuple(rates))
    known = {closed.state.qd[i]: rate.express(graph) for i, rate in zip(cyclic, found.rates, strict=True)}
    K, state, others = closed.form("K").express(graph), closed.state, [i for i in range(closed.n) if i not in cyclic]
    given = graph.total(p * known[state.qd[i]] for p, i in zip(found.nodes, cyclic, strict=True))
    held = substitute([*along.slopes(K), *gradient(K, state.qd)], known)
    try:
        momenta = [quotient(closed, held[closed.n + i]).express(graph) for i in others]
        twice = graph.total(p * state.qd[i] for p, i in zip(momenta, others, strict=True)) - given
        (rest,) = substitute([twice], {state.qd[i]: graph.zero for i in others})  # by itself: the effective potential
        R = Form.sum((quotient(closed, (twice - rest) / 2), quotient(closed, rest / 2)))
        inertial = [quotient(closed, rate) for rate in tangents(momenta, state.acceleration)]
        p = dict(zip([*others, *cyclic], [*momenta, *found.nodes], strict=True))
        turned = [
            graph.total(
                known.get(state.qd[j], state.qd[j]) * p[m] * value
                for j in range(closed.n)
                for m, value in along.brackets.get((j, i), ())
            )
            for i in others
        ]
        # dR/dq at p held is dL/dq
        slopes = [quotient(closed, held[i] + x).negative for i, x in zip(others, turned, strict=True)]
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
    taken = says.turned.replace("+", "-")
    slope = rf"\frac{{d}}{{dt}} \partial R/\partial {says.u_i} - {says.slope.format('R')}"
    text = "d/dt dR/du - X R - Q, with the terms of Lie and Poisson" if taken else "d/dt dR/dqd - dR/dq - Q"
    yield EquationGroup(
        "left", "Equations that are left", f"0 = {text}", tuple(left), rf"${slope}{taken} - Q_i = 0${says.meant}:"
    )
