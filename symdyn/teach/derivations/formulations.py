"""A lesson by another formulation: what it is and what it costs here, its steps, the proof, and what one gains by it.

Equations are those of the printed page, which `formulation_steps` explains. What is proved is what is printed: with
momenta put in, and drives as Lagrange's equations ask for them, both are the same functions over finite fields.

References: Goldstein, Classical Mechanics (1980), chapter 8; Kane and Levinson, Dynamics (1985); Udwadia and Kalaba,
Analytical Dynamics (1996); van der Schaft and Jeltsema, Port-Hamiltonian Systems Theory (2014).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import islice

import numpy as np

from symdyn import verify
from symdyn.algebra import Form, Number, Ratios, Symbol
from symdyn.dynamics.mechanism import TIME, solve
from symdyn.emit.print import FormulationPage
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, gradient, reachable, substitute, tangents
from symdyn.scene import Scene, SceneUnits, without_hidden_zeros
from symdyn.scene.values import force_unit
from symdyn.teach.derivations.constrained import Constrained
from symdyn.teach.derivations.formulation_steps import Explained, joined, pushed, structured_steps, tied_steps
from symdyn.teach.derivations.lagrange import energy_sections, scene_picture, scene_section, state_step, with_figures
from symdyn.teach.derivations.multipliers import choose_tied_motion
from symdyn.teach.derivations.precession import NO_FORM, precession_steps
from symdyn.teach.derivations.quaternion_steps import Turning
from symdyn.teach.derivations.quaternions import choose_turned, rotation_sections, turning_scene
from symdyn.teach.derivations.reduced import reduced
from symdyn.teach.derivations.steady import steady_step
from symdyn.teach.derivations.velocities import folded
from symdyn.teach.document import Block, Document, Formula, Letter, Name, Step, Words
from symdyn.teach.lesson import Lesson, Prose, called, named, refuse_quaternions, together
from symdyn.teach.notation import scene_step
from symdyn.teach.shown_state import Chosen, choose_state, picture_letters
from symdyn.verdict import Verdict
from symdyn.verify import Claim, prove

UNTIL = ("equations", "check", "gains")
"""The parts that it may end with."""

FIRST_ORDER = ("hamilton", "port-hamiltonian")


def with_cost(document: Document, declared: Scene) -> Document:
    """Return a lesson by a formulation of `WAYS` with what its page takes, and Lagrange's, of the scene as declared.

    Both are counted as docs/formulations.md has them, and how many equations of which order are integrated.
    """
    lesson, page = Prose(document.scene, document.language), FormulationPage(declared, document.formulation)
    ours, theirs, n = page.operations, FormulationPage(declared, "lagrange").operations, len(declared.velocities)
    kept = sum(len(one.letters) for one in page.groups if one.key == "constant")
    tied = len({row.place[0] for one in page.groups for row in one.rows if row.letter == "A"})
    every = len(declared.coordinates) + n
    first, turning = document.formulation in FIRST_ORDER, every > 2 * n
    orders = ("multipliers" if tied else "first" if turning else "second", "first" if first or turning else "second")
    counts = (every, every) if turning else (n, 2 * n if first else n - kept)
    rows = [
        (lesson.text(f"by.name.{name}"), str(taken), lesson.text(f"by.order.{order}", count=str(count), tied=str(tied)))
        for name, taken, order, count in zip(
            ("lagrange", document.formulation), (theirs, ours), orders, counts, strict=True
        )
    ]
    table = lesson.table(("by.formulation", "by.operations", "by.integrated"), rows)
    claim = lesson.say(f"by.cost.{'shorter' if ours < theirs else 'longer' if ours > theirs else 'same'}")
    letters = {letter: Symbol(f"any:{letter}") for letter in "HMQAbRJ"}
    step = Step("derived:cost", claim, (table,), lesson.say(f"by.when.{document.formulation}", **letters))
    sections = (replace(x, steps=(*x.steps, step)) if x.key == "by.idea" else x for x in document.sections)
    return replace(document, sections=tuple(sections))


# The steps to the equations


def _routhian(told: Explained) -> Iterator[Step]:
    lesson, cyclic = told.lesson, told.momenta.values()
    coordinates = together([named(lesson.state.q[i]) for i in cyclic])
    yield from told.momentum_steps("constant", coordinates=coordinates)
    taken = lesson.graph.total(lesson.momenta[i] * lesson.state.qd[i] for i in cyclic)
    formed = Form.sum((Symbol("L:"), *(one.negative for one in told.work())))
    yield told.function("routhian", lesson.L - taken, formed)
    yield told.step("left", *told.equations("left"))
    yield told.step("cyclic", coordinates=coordinates)


def _by_bodies(told: Explained) -> Iterator[Step]:
    yield from told.body_steps()
    yield told.step("kane", *told.equations("kane"))


def _by_acceleration(told: Explained) -> Iterator[Step]:
    yield from told.acceleration_steps()
    yield told.function("gibbs", told.value(told.row("gibbs").form))
    yield told.step("appell", *told.equations("appell"))


# Proofs


def _same(left: Sequence[Expr], right: Sequence[Expr]) -> Claim:
    return Claim("same", "page", "Lagrange", tuple(left), tuple(right))


def _of_momenta(told: Explained) -> dict[str, Claim]:
    """H is the energy, its slopes are the printed rates, and these are the rates of p by Lagrange's equations."""
    lesson, graph = told.lesson, told.lesson.graph
    H, rows = told.row("hamiltonian").form, {row.name: row.form for row in told.groups["canonical"].rows}
    faster, drives = [f"{p}_dot" for p in told.momenta], lesson.scene.drives
    rates = [told.value(rows[name]) + rest for name, rest in zip(faster, told.needed, strict=True)]
    claims = {"energy": _same([told.value(H)], [lesson.energy.K + lesson.energy.P])}
    if all(name in rows for name in lesson.scene.velocities):
        node, p = H.express(graph), [graph.symbol(name) for name in told.momenta]
        slopes, along = gradient(node, p), lesson.energy.directions.slopes(node)
        pushed = [Q + graph.symbol(tau) if tau else Q for Q, tau in zip(told.acting, drives, strict=True)]
        moving = dict(zip(lesson.state.qd, slopes, strict=True))
        right = [Q - x + y for x, y, Q in zip(along, told.turned(slopes, p), pushed, strict=True)]
        shown = [rows[name].express(graph) for name in (*lesson.scene.velocities, *faster)]
        claims["slopes"] = _same([*slopes, *substitute(right, moving)], substitute(shown, moving))
    return claims | {"lagrange": _same(rates, lesson.momentum_rates)}


def _of_ports(told: Explained) -> dict[str, Claim]:
    """The parts of what acts are all of it, and the power is the rate of energy where time does not act."""
    lesson, graph, u = told.lesson, told.lesson.graph, told.lesson.state.qd
    F, flow = told.entries("F"), pushed(told)
    forces = [F.get((i,), Number.ZERO).express(graph) for i in range(len(u))]
    for (i, j), form in flow.items():
        forces[i] = forces[i] + told.value(form) * u[j]
    acting = [a + b for a, b in zip(told.acting, told.turned(u, lesson.momenta), strict=True)]
    claims = _of_momenta(told) | {"structure": _same(forces, acting)}
    if not {graph.symbol(TIME), *lesson.state.clock}.intersection(reachable([lesson.L])):
        (rate,) = tangents([lesson.energy.K + lesson.energy.P], lesson.state.acceleration)
        idle = (needed * x for needed, x in zip(told.needed, u, strict=True))
        claims["power"] = _same([graph.total([told.value(told.row("power").form), *idle])], [rate])
    return claims


def _of_routh(told: Explained) -> dict[str, Claim]:
    """What is left is Lagrange's, the accelerations of cyclic coordinates put in from ṗ = 0."""
    lesson, state, cyclic = told.lesson, told.lesson.state, list(told.momenta.values())
    rest = substitute([lesson.momentum_rates[i] for i in cyclic], {state.qdd[i]: lesson.graph.zero for i in cyclic})
    M = [gradient(lesson.momenta[i], [state.qd[j] for j in cyclic]) for i in cyclic]
    put = dict(zip((state.qdd[i] for i in cyclic), solve(range(-1, len(M)), M, [-x for x in rest]), strict=True))
    others = substitute([told.needed[i] for i in range(state.n) if i not in cyclic], put)
    taken = lesson.graph.total(lesson.momenta[i] * state.qd[i] for i in cyclic)
    left = substitute([told.value(row.form) for row in told.groups["left"].rows], put)
    routhian = told.value(told.row("routhian").form)
    return {"routhian": _same([routhian], [lesson.L - taken]), "lagrange": _same(left, others)}


def _of_sums(group: str, told: Explained) -> dict[str, Claim]:
    """What is zero vanishes with the drives that Lagrange's equations ask for, or is what no drive supplies."""
    found = [told.value(row.form) for row in told.groups[group].rows]
    return {"lagrange": _same([-x for x in found] if group == "kane" else found, told.needed)}


def _added(told: Explained) -> tuple[list[Expr], list[Expr]]:
    """Return accelerations and forces of constraints by M, Q, A and b of the page, drives as symbols."""
    graph, n = told.lesson.graph, range(told.lesson.state.n)
    M, Q, A, b = (
        {place: form.express(graph) for place, form in one.items()}
        for one in (joined([1], told.entries("M")), *(told.entries(letter) for letter in "QAb"))
    )
    rows = [[A.get((k, i), graph.zero) for i in n] for k in range(len(told.lesson.page.constraints.rows))]
    inertia = [[M.get((i, j), graph.zero) for j in n] for i in n]
    free, *turned = (
        solve(range(-1, len(n)), inertia, right) for right in ([Q.get((i,), graph.zero) for i in n], *rows)
    )

    missing = [b.get((k,), graph.zero) - graph.dot(row, free) for k, row in enumerate(rows)]
    sizes = solve(range(-1, len(rows)), [[graph.dot(row, one) for one in turned] for row in rows], missing)
    forces = [graph.dot(sizes, [row[i] for row in rows]) for i in n]
    return [x + graph.dot(sizes, [one[i] for one in turned]) for i, x in enumerate(free)], forces


def _of_constraints(told: Explained) -> dict[str, Claim]:
    """With the accelerations Lagrange's open equations lack the force that is added, and the conditions are kept."""
    lesson, graph = told.lesson, told.lesson.graph
    moved, added = _added(told)
    put = dict(zip(lesson.state.qdd, moved, strict=True))
    drives = [graph.symbol(drive) if drive else graph.zero for drive in lesson.scene.drives]
    lacking = [x - tau for x, tau in zip(substitute(lesson.drives, put), drives, strict=True)]
    held = [row.residual.express(graph) for row in lesson.page.constraints.rows if row.residual is not None]
    twice = substitute(tangents(tangents(held, lesson.state.velocity), lesson.state.acceleration), put)
    return {"open": _same(lacking, added)} | ({"kept": _same(twice, [graph.zero] * len(held))} if held else {})


def proof_step(told: Explained, claims: Mapping[str, Claim]) -> Step:
    """Return Lagrange's equations, and the proof over finite fields that those of the page are the same.

    What is defined at no point that was tried is not said.
    """
    lesson, page = told.lesson, told.lesson.page
    positive = [one.name for one in lesson.scene.parameters if one.positive]
    fields, findings = prove(verify.on_unit_sphere(lesson.scene, list(claims.values())), positive=positive)
    verdicts = {key: one.verdict for key, one in zip(claims, findings, strict=True)}
    wrong = [key for key, verdict in verdicts.items() if verdict == Verdict.DIFFERENT]
    assert not wrong, f"{told.page.formulation} differs from Lagrange's equations: {wrong}"
    kept = [key for key, verdict in verdicts.items() if verdict in Verdict.HOLD]
    blocks: list[Block] = [told.say(f"by.proof.{key}") for key in kept if key != "lagrange"]
    if "lagrange" in kept:
        alike = {"port-hamiltonian": "hamilton", "gibbs-appell": "kane"}
        blocks.append(told.say(f"by.proof.lagrange.{alike.get(name := told.page.formulation, name)}"))
        blocks += [folded(lesson, Formula("", page.left(i), right=page.right[i])) for i in range(lesson.state.n)]
    how = lesson.say("by.agrees")
    if all(one.verdict == Verdict.PROVED for one in findings):
        chance = Number(Fraction(10)).power(int(max(one.error_log10 for one in findings)))
        counts = {"points": str(fields.points), "primes": str(len(fields.primes))}
        how = lesson.say("formulations.proved", **counts, chance=chance)
    return Step("derived:proof", lesson.say("by.proof"), tuple(blocks), how)


# What one gains


def _kept(told: Explained, chosen: Chosen) -> Iterator[Step]:
    """Yield which momenta are conserved, and the balance of energy."""
    kept, lesson = [row.name for row in told.groups["canonical"].rows if row.form == Number.ZERO], told.lesson
    if told.turning and kept:
        yield told.step("brackets", *(Formula(name, Number.ZERO) for name in kept))
    elif "brackets" in told.groups:
        names = [row.name for row in told.groups["brackets"].rows]
        of = together([named(lesson.state.q[told.momenta[name.removesuffix("_dot")]]) for name in names])
        yield told.step("brackets", *(Formula(name, Number.ZERO) for name in names), coordinates=of)
    else:
        yield told.step("brackets.none")
    yield from _volume(told)
    if not {lesson.graph.symbol(TIME), *lesson.state.clock}.intersection(reachable([lesson.L, *told.acting])):
        pushed = zip(lesson.page.right, lesson.state.qd, strict=True)
        work = Form.sum(lesson.page.lengths.written_out(x).signed_product(named(u)) for x, u in pushed if x.terms)
        rate = lesson.rate("hamiltonian:", told.value(work))
        yield told.step("work", folded(lesson, Formula(rate.name, told.order(work))))


def _volume(told: Explained) -> Iterator[Step]:
    """Yield what volumes of phase space do: div (q̇, ṗ) = Σ ∂Q_i/∂q̇_j ∂q̇_j/∂p_i, as slopes of H cancel."""
    graph, p = told.lesson.graph, [told.lesson.graph.symbol(name) for name in told.momenta]
    rows = {row.name: row.form.express(graph) for row in told.groups["canonical"].rows}
    rates = [gradient(rows[u], p) for u in told.lesson.scene.velocities if u in rows]
    slopes = [gradient(Q, told.lesson.state.qd) for Q in told.acting]
    if all(x.is_zero for row in slopes for x in row):
        yield told.step("volume")
    elif rates:
        n = range(len(p))
        node = graph.total(slopes[i][j] * rates[j][i] for j in n for i in n if not slopes[i][j].is_zero)
        told.lesson.names["volume:"] = Name(Letter(r"\frac{\dot V}{V}"), node)
        try:
            yield told.step("volume.lost", folded(told.lesson, Formula("volume:", told.order(Ratios.form_of(node)))))
        except NO_FORM:
            return


def _reduced(told: Explained, chosen: Chosen) -> Iterator[Step]:
    """Yield the effective potential, and steady motions where one coordinate is left."""
    lesson = told.lesson
    others = [i for i in range(lesson.state.n) if i not in told.momenta.values()]
    rates = {lesson.scene.velocities[i] for i in others}
    form = Form.sum(x for x in told.row("routhian").form.terms if not rates.intersection(x.symbols)).negative
    lesson.names["effective:"] = Name(Letter("V", ("eff",)), told.value(form))
    names = together([named(lesson.state.q[i]) for i in others])
    yield told.step(
        "effective", folded(lesson, Formula("effective:", told.order(form))), names=names, V=Symbol("effective:")
    )
    left = reduced(lesson, chosen)
    if left is not None and (steady := steady_step(lesson, left)) is not None:
        yield from (replace(state_step(lesson, chosen), key="derived:state"), steady)
        yield from precession_steps(left)


def _balanced(told: Explained, chosen: Chosen) -> Iterator[Step]:
    """Yield F and F* in numbers, and what drives have to add."""
    both, active = (
        chosen.of(*(told.value(row.form, drives=False) for row in told.groups[key].rows)) for key in ("kane", "active")
    )
    inertia = [x - F for x, F in zip(both, active, strict=True)]
    yield from _in_numbers(told, chosen, "balance", {"active": active, "inertia": inertia}, [-x for x in both])


def _forces(told: Explained, chosen: Chosen) -> Iterator[Step]:
    """Yield the forces of constraints in numbers, as Lagrange's equations ask for them, and what drives add."""
    lesson = told.lesson
    assert isinstance(lesson, Constrained), "there are conditions"
    A = np.array(chosen.of(*(x for tie in lesson.ties for x in tie.slopes))).reshape(len(lesson.ties), -1)
    needed, idle = np.array(chosen.of(*lesson.drives)), [i for i, tau in enumerate(lesson.scene.drives) if tau is None]
    held = A.T @ np.linalg.lstsq(A[:, idle].T, needed[idle], rcond=None)[0]
    drives = {tau: float(needed[i] - held[i]) for tau, i in told.driven.items()}
    _, added = _added(told)
    assert np.allclose(chosen.with_values(drives).of(*added), held, 1e-6, 1e-6), "the force added is another one"
    yield from _in_numbers(told, chosen, "forces", {"constraint": held.tolist()}, (needed - held).tolist())


def _in_numbers(
    told: Explained, chosen: Chosen, key: str, columns: Mapping[str, Sequence[float]], drives: Sequence[float]
) -> Iterator[Step]:
    """Yield the state, and a table of forces along every velocity."""
    lesson = told.lesson
    units = [lesson.scene.shown_unit(force_unit(unit)) for unit in SceneUnits(lesson.scene).velocities]
    rows: list[list[str | Form | Words]] = []
    noise = 1e-10 * max(map(abs, (*drives, *(x for column in columns.values() for x in column))), default=0.0)
    for i, u in enumerate(lesson.state.qd):
        sizes = (one[i] if abs(one[i]) > noise else 0.0 for one in (*columns.values(), drives))
        known = [f"{lesson.written(x)} {units[i]}" for x in sizes]
        rows.append([named(u), *known[:-1], known[-1] if lesson.scene.drives[i] else "–"])
    heads = ["by.velocity.head", *(f"by.{name}.head" for name in columns), "by.drive.head"]
    yield replace(state_step(lesson, chosen), key="derived:state")
    yield told.step(key, lesson.table(heads, rows))


def _least(told: Explained, chosen: Chosen) -> Iterator[Step]:
    n = told.lesson.state.n
    M: dict[tuple[int, ...], Form] = {(i, j): told.lesson.forms.form("k_z", i, j) for i in range(n) for j in range(n)}
    yield told.step("least", told.matrix("any:M", M, n, n))


def _powers(told: Explained, chosen: Chosen) -> Iterator[Step]:
    """Yield the outputs, the power, and what passes through the ports."""
    lesson, blocks = told.lesson, list[Block]()
    for (i,), form in told.entries("y").items():
        row = next(one for one in told.groups["outputs"].rows if one.place == (i,))
        lesson.names[f"y:{i}"] = Name(Letter(row.latex.partition("_{")[0], told.index(i)), lesson.state.qd[i])
        blocks.append(Formula(f"y:{i}", form))
    yield from [told.step("outputs", *blocks)] if blocks else []
    row = told.row("power")
    symbol = lesson.rate("hamiltonian:", told.value(row.form))
    verdict = "pushed" if told.entries("F") else "lost" if told.entries("R") else "kept"
    power = folded(lesson, Formula(symbol.name, told.order(row.form)))
    yield told.step("power", power, told.say(f"by.passive.{verdict}"))


@dataclass(frozen=True)
class Way:
    """What a lesson by one formulation is made of."""

    steps: Callable[[Explained], Iterator[Step]]  # those to its equations
    claims: Callable[[Explained], dict[str, Claim]]  # what proves them
    gains: Callable[[Explained, Chosen], Iterator[Step]]  # steps behind them
    sections: int = 4  # how many of positions, velocities, energies and the Lagrangian come before


WAYS: Mapping[str, Way] = {
    "hamilton": Way(Explained.canonical_steps, _of_momenta, _kept),
    "routh": Way(_routhian, _of_routh, _reduced),
    "kane": Way(_by_bodies, partial(_of_sums, "kane"), _balanced, 1),
    "gibbs-appell": Way(_by_acceleration, partial(_of_sums, "appell"), _least, 1),
    "udwadia-kalaba": Way(tied_steps, _of_constraints, _forces, 0),
    "port-hamiltonian": Way(structured_steps, _of_ports, _powers),
}
"""Formulations of `FormulationPage`, each by its lesson."""


def formulation_walkthrough(formulation: str, scene: Scene, language: str = "en", until: str = "gains") -> Document:
    """Return the lesson of a scene by a formulation of `WAYS`, up to one of `UNTIL`.

    Raises:
        DerivationError: the scene has no such equations, and why.
        EmitError: they are more than anyone reads.
    """
    way, scene, last = WAYS[formulation], without_hidden_zeros(scene), UNTIL.index(until)
    page = FormulationPage(scene, formulation)
    page.refuse_too_long()  # derives it, and says first what the page says
    turning = len(scene.coordinates) > len(scene.velocities)
    if scene.is_constrained:
        refuse_quaternions(scene)
    lesson = (Constrained if scene.is_constrained else Turning if turning else Lesson)(scene, language)
    assert lesson.forms.n == lesson.state.n, "closed forms and graph have the same velocities"  # raises early
    if isinstance(lesson, Constrained):
        chosen = choose_tied_motion(lesson, choose_turned(lesson) if isinstance(lesson, Turning) else None)
    else:
        chosen = choose_state(scene, lesson.state, lesson.graph)
    told, found = Explained(lesson, page), lesson.masses
    letters = () if isinstance(lesson, Constrained) else picture_letters(scene, lesson.graph, chosen)
    shown = scene_step(lesson, scene_picture(lesson, chosen, letters), numbered=False)
    claim, reason = (told.say(f"by.idea.{formulation}{end}") for end in ("", ".reason"))
    idea = Step("derived:idea", claim, tuple(told.stated()), reason)
    if isinstance(lesson, Turning):
        opened, parts = turning_scene(lesson, shown), rotation_sections(lesson)
    else:
        opened, parts = scene_section(lesson, chosen, shown), energy_sections(lesson, found)
    sections = [opened, lesson.section("by.idea", [idea])]
    for part in islice(parts, way.sections):
        steps = (replace(one, reference="") for one in part.steps)  # numbers are those of another lesson's source
        sections.append(replace(part, steps=tuple(steps)))
    sections.append(lesson.section("by.equations", list(way.steps(told))))
    if last >= 1:
        sections.append(lesson.section("by.check", [proof_step(told, way.claims(told))]))
    if last >= 2:
        sections.append(lesson.section("by.gains", list(way.gains(told, chosen))))
    sections = [with_figures(section, found) for section in sections]
    title = lesson.text("title.by", scene=called(scene), name=lesson.text(f"by.name.{formulation}"))
    return Document(title, language, scene, lesson.graph, lesson.names, tuple(sections), formulation)
