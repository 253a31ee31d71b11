"""The walkthrough of an open mechanism by Lagrange's equations, its first and last steps, and its figures.

First come what is known and wanted, and Lagrange's equations (5.21), (5.22), from which every later step is derived.
The index i in them stands for any coordinate: these names have no value, and tests put each coordinate in their place.

Last comes the scene in numbers at one state: values, each coefficient's share of each torque, the power balance.

What the figure of a page shows at a step depends on what the key of the step begins with. A step that is not listed
shows what the one before it showed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice

from symdyn.algebra import Form, Number, Symbol
from symdyn.draw import Lettered, Wrench, picture
from symdyn.dynamics.mechanism import TIME, generalized_forces, vector
from symdyn.emit.print import Printable, latex_symbols
from symdyn.graph import Expr, gradient, tangents
from symdyn.scene import Scene, SceneUnits, without_hidden_zeros
from symdyn.scene.values import force_unit
from symdyn.teach.derivations.afterwards import after_sections
from symdyn.teach.derivations.coordinates import coordinate_step, length_steps
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.equation_steps import (
    coefficient_key,
    coefficient_steps,
    coefficient_unit,
    equation_steps,
    kane_steps,
    name_coefficients,
    node_of,
)
from symdyn.teach.derivations.forced import uniform_steps
from symdyn.teach.derivations.meaning import axes_of, meaning_steps
from symdyn.teach.derivations.rotations import rotation_steps
from symdyn.teach.derivations.solved import solved_steps
from symdyn.teach.derivations.velocities import energy_steps, position_steps, velocity_steps
from symdyn.teach.document import Bar, Block, Document, Formula, Letter, Name, Picture, Section, Shares, Step, Words
from symdyn.teach.lesson import Lesson, Mass, Prose, called, named, silent_steps, together
from symdyn.teach.notation import (
    acting_steps,
    errata,
    joints_step,
    notation_step,
    numbers_for,
    scene_step,
    with_appendix,
)
from symdyn.teach.shown_state import Chosen, choose_state, idle_velocities, picture_letters, rates_of, timed

NONE = 1e-9
"""A sum of so small a part of its terms' amounts is rounding."""


def number_steps(lesson: Lesson, page: Printable, chosen: Chosen) -> list[Step]:
    """Return the state, the coefficients' values, the torques with their shares, the power balance."""
    steps = [state_step(lesson, chosen), _values(lesson, page, chosen)]
    steps += [_torque(lesson, page, chosen, i) for i in range(len(page.rows))]
    return steps


def state_step(lesson: Lesson | Balance, chosen: Chosen) -> Step:
    """Return the table of the chosen state."""
    scene, symbol = lesson.scene, lesson.graph.symbol
    symbols = [*(symbol(p.name) for p in scene.parameters), *lesson.state.q, *lesson.state.qd, *lesson.state.qdd]
    rates = SceneUnits(scene).velocities
    told = SceneUnits(scene).inferred
    units = [*(told[parameter.name] for parameter in scene.parameters), *SceneUnits(scene).coordinates]
    units += [*(f"{unit}/s" for unit in rates), *(f"{unit}/s^2" for unit in rates)]
    if timed(scene):
        symbols, units = [*symbols, symbol(TIME)], [*units, "s"]
    pairs = zip(symbols, units, strict=True)
    rows = [(named(x), lesson.written(chosen.values[x]), unit.replace("^2", "²")) for x, unit in pairs]
    said = [lesson.say("state.reason.closed")] if scene.is_constrained else []
    said += [lesson.say("state.reason")] if scene.free_parameters else []
    reason = Words(tuple(part for one in said for part in (" ", *one.parts))[1:])
    blocks: tuple[Block, ...] = (lesson.table(("symbol", "value", "unit"), rows),)
    if not scene.is_constrained and idle_velocities(scene):
        blocks = (*blocks, lesson.say("state.undriven"))
    return Step("state", lesson.say("state"), blocks, reason)


def _values(lesson: Lesson, page: Printable, chosen: Chosen) -> Step:
    rows, slides = [], [unit == "m" for unit in SceneUnits(lesson.scene).velocities]
    for c in page.written:
        key = coefficient_key(c)
        (value,) = chosen.of(node_of(lesson, key))
        rows.append((Symbol(key), lesson.written(value), coefficient_unit(c.of, c.indices, slides)))
    table = lesson.table(("coefficient", "value", "unit"), rows)
    return Step("values", lesson.say("values"), (table,))


def _torque(lesson: Lesson, page: Printable, chosen: Chosen, i: int) -> Step:
    """Return the bar chart of one equation, solved for the drive: products of coefficient and rates, other forces."""
    terms: list[tuple[Form, Expr]] = []
    for c in page.rows[i]:
        if not c.vanishes:
            key = coefficient_key(c)
            value = node_of(lesson, key) * c.rate.express(lesson.graph)
            terms.append((Form.product((Symbol(key), c.rate)), value))
    for force in _others(lesson, page, i):
        node = page.lengths.written_out(force).express(lesson.graph)
        terms.append((Form.product((Number.MINUS_ONE, force)), -node))
    labels, values = [label for label, _ in terms], chosen.of(*(value for _, value in terms))
    whole, sum_ = sum(map(abs, values)) or 1.0, sum(values)
    sum_ = 0.0 if abs(sum_) <= NONE * whole else sum_
    bars = tuple(Bar(label, value, abs(value) / whole) for label, value in zip(labels, values, strict=True))
    total, unit = _drive(lesson, i), lesson.scene.shown_unit(force_unit(SceneUnits(lesson.scene).velocities[i]))
    caption = lesson.say("shares", total=total)
    block = Shares(caption, total, sum_, unit, bars)
    key = "torque" if lesson.scene.drives[i] else "torque.passive"
    claim = lesson.say(key, total=total, value=f"{lesson.equals(sum_)} {unit}".rstrip(), q=named(lesson.state.q[i]))
    return Step(f"torque:{i + 1}", claim, (block,))


def _drive(lesson: Lesson, i: int) -> Symbol:
    """Return the drive of a velocity; for a passive one the name of what its motion would need."""
    drive, node = lesson.scene.drives[i], lesson.drives[i]
    if drive is None:
        return lesson.name(f"needed:{i + 1}", "tau", str(i + 1), node=node)
    lesson.names[drive] = Name(None, node)
    return Symbol(drive)


def _others(lesson: Lesson, page: Printable, i: int) -> list[Form]:
    """Return what acts beside the drive: friction, damping, loads; terms of Q_i."""
    drive = lesson.scene.drives[i]
    return [term for term in page.right[i].terms if drive is None or term != Symbol(drive)]


def power_steps(lesson: Lesson, page: Printable, chosen: Chosen) -> list[Step]:
    """Return the check by energy: d/dt (K + P) = Σ (τ_i + Q_i) q̇_i, decided on the graph, then in numbers."""
    state, n = lesson.state, range(lesson.state.n)
    total = lesson.energy.K + lesson.energy.P
    rate = tangents([total], state.acceleration)[0]
    lesson.name("E:", "E", node=total)
    symbol = lesson.rate("E:", rate)
    forces = [[_drive(lesson, i), *_others(lesson, page, i)] for i in n]
    power = [Form.sum(forces[i]).signed_product(named(state.qd[i])) for i in n]
    others = [page.lengths.written_out(Form.sum(some[1:])) for some in forces]
    acting = [lesson.drives[i] + others[i].express(lesson.graph) for i in n]
    nodes = [force * u for force, u in zip(acting, state.qd, strict=True)]
    supports = tangents([lesson.energy.P], state.clock)[0] if state.clock else lesson.graph.zero
    told = None if supports.is_zero else lesson.name("told:", "W", "s", node=supports)
    nodes, power = (nodes, power) if told is None else ([*nodes, supports], [*power, told])
    left, *parts = chosen.of(rate, *nodes)
    size = sum(map(abs, (*parts, *rates_of(lesson.energy, state, chosen))))
    left, *parts = (0.0 if abs(x) <= NONE * size else x for x in (left, *parts))
    assert abs(left - sum(parts)) <= 1e-9 * (1 + size), "the power of the drives is not the rate of K + P"
    blocks: list[Block] = [Formula("E:", Form.sum((Symbol("K:"), Symbol("P:")))), Formula(symbol.name, Form.sum(power))]
    blocks += [] if told is None else [lesson.say("power.told", power=told, P=Symbol("P:"))]
    right = " + ".join(map(lesson.written, parts)).replace("+ −", "− ")
    numbers = lesson.say("power.numbers", left=symbol, value=lesson.equals(left), parts=right)
    return [
        Step("power", lesson.say("power"), tuple(blocks), lesson.say("power.reason")),
        Step("power.numbers", numbers, ()),
    ]


# Pictures


def scene_picture(lesson: Prose, chosen: Chosen, letters: Sequence[Lettered] = ()) -> Picture:
    """Return the mechanism with its frames, coordinates, and letters of masses and lengths."""
    q, given, titles = chosen.q, chosen.parameters, lesson.titles
    svg = picture(lesson.scene, q, given, frames=True, prefix="scene-", titles=titles, letters=letters)
    caption = lesson.say("picture.caption", scene=called(lesson.scene))
    return Picture(svg, caption, lesson.text("picture.caption", scene=called(lesson.scene)), "scene")


def weights_picture(lesson: Lesson, chosen: Chosen, result: list[Mass]) -> Picture | None:
    """Return the mechanism with the weight of every mass; None without gravity."""
    gravity = chosen.of(*vector(lesson.scene.gravity, lesson.graph))
    if not any(gravity):
        return None
    wrenches, G = [], lesson.letters.latex("G")
    for mass in result:
        m, *at = chosen.of(mass.m, *mass.place)
        if m > 0:
            arm = [x / m for x in chosen.of(*mass.h)] if mass.h is not None else [0.0] * 3
            centre = tuple(x + r for x, r in zip(at, arm, strict=True))
            wrenches.append(Wrench(f"{G}_{{{mass.tag}}}", centre, tuple(m * g for g in gravity)))
    shown, labels, titles = chosen.parameters, ("coordinates",), lesson.titles
    svg = picture(lesson.scene, chosen.q, shown, wrenches=wrenches, prefix="weights-", labels=labels, titles=titles)
    return Picture(svg, lesson.say("weights.caption"), lesson.text("weights.caption"), "weights")


def centrifugal_picture(lesson: Lesson, chosen: Chosen, result: list[Mass]) -> Picture | None:
    """Return the mechanism with its axes o_i, drives M_i and the centrifugal forces F_Ok of the first rate alone.

    As figure 5.40 has them; None where the first joint does not turn about one axis.
    """
    axes, (u, *_), F = axes_of(lesson), lesson.state.qd, lesson.letters.latex("F")
    if axes[0] is None or axes[0].slides:
        return None
    wrenches, letters, spelled = [], [], latex_symbols(lesson.scene)
    for mass in result:
        felt = tangents(tangents(mass.place, lesson.state.velocity), lesson.state.velocity)
        force = [-mass.m * u * u / 2 * gradient(gradient(x, [u])[0], [u])[0] for x in felt]
        x, y, z, *force_values = chosen.of(*mass.place, *force)
        if any(force_values):
            wrenches.append(Wrench(f"{F}_{{O{mass.tag}}}", (x, y, z), tuple(force_values)))
    for i, (axis, drive) in enumerate(zip(axes, lesson.scene.drives, strict=True), 1):
        if axis is not None:
            x, y, z, *n = chosen.of(*axis.o, *axis.n)
            S, o = (lesson.letters.latex(letter) for letter in "So")
            letters.append(Lettered(f"{S}_{i}, {o}_{i}", (x, y, z)))
            if drive and not axis.slides:
                wrenches.append(Wrench(spelled[drive], (x, y, z), couple=tuple(n)))
    said = lesson.say("centrifugal.caption", rate=named(u))
    shown, titles = chosen.parameters, lesson.titles
    svg = picture(
        lesson.scene, chosen.q, shown, labels=("coordinates",), wrenches=wrenches, prefix="centrifugal-", titles=titles,
        letters=letters,
    )  # fmt: skip
    return Picture(svg, said, lesson.text("centrifugal.alt"), "centrifugal")


ANY = ("q:i", "q_dot:i", "Q:i", "QA:i")
"""Keys of any coordinate, its rate, its generalized force, and the part of that which is not of P."""


def task_step(lesson: Lesson, *more: Block, tied: Collection[int] = ()) -> Step:
    """Return what is known and what is wanted, `more` at the end; `tied` velocities follow from others."""
    scene = lesson.scene
    given = together([Symbol(p.name) for p in scene.parameters])
    ways = lesson.state.q if len(lesson.state.q) == lesson.state.n else lesson.state.qd  # a quaternion has no drives
    passive = [k for k, drive in enumerate(scene.drives) if drive is None and k not in tied]
    known = lesson.say("task.known", parameters=given) if scene.parameters else lesson.say("task.known.numbers")
    if not all(x.is_zero for x in vector(scene.gravity, lesson.graph)):
        known = Words((*known.parts, " ", *lesson.say("task.gravity").parts))
    blocks: list[Block] = [known]
    driven = [k for k, drive in enumerate(scene.drives) if drive]
    led = [k for k in driven if k in scene.prescribed_velocities]
    for key, some in (("task.wanted", [k for k in driven if k not in led]), ("task.led", led)):
        if some:
            drives = together([Symbol(str(scene.drives[k])) for k in some])
            blocks.append(lesson.say(key, drives=drives, coordinates=together([named(ways[k]) for k in some])))
    if passive:
        free, faster = (together([named(some[k]) for k in passive]) for some in (ways, lesson.state.qdd))
        key = "task.passive" if len(passive) > 1 else "task.passive.one"
        blocks.append(lesson.say(key, coordinates=free, accelerations=faster))
    if tied:
        blocks.append(lesson.say("task.tied", coordinates=together([named(ways[k]) for k in tied])))
    return Step("task", lesson.say("task"), (*blocks, *more), lesson.say("task.reason") if driven else Words(()))


def principle_steps(lesson: Lesson, page: Printable) -> list[Step]:
    """Return (5.21) and (5.22), both with L, and the generalized force of every coordinate."""
    q, qd, Q, QA = _general(lesson)
    for letter, node in (("K", lesson.energy.K), ("P", lesson.energy.P), ("L", lesson.L)):
        lesson.name(f"{letter}:", letter, node=node)
    kinetic, potential = lesson.slope("K:", q.name, None), lesson.slope("P:", q.name, None)
    momentum, slope = lesson.slope("L:", qd.name, None), lesson.slope("L:", q.name, None)
    rate = lesson.rate(lesson.slope("K:", qd.name, None).name, None)
    stated = [
        Formula("", _less(rate, kinetic), "5.21", Q),
        Formula("", Q, "5.22", _less(QA, potential)),
    ]
    both: list[Block] = [
        Formula("L:", _less(Symbol("K:"), Symbol("P:")), lesson.number("L.definition")),
        Formula("", _less(lesson.rate(momentum.name, None), slope), "", QA),
        lesson.say("stated.way"),
    ]
    every = together([named(x) for x in lesson.state.q])
    claim = lesson.say("stated" if lesson.state.n > 1 else "stated.one", q=q, coordinates=every)
    return [
        Step("principle", claim, tuple(stated), lesson.say("stated.reason", q=q), "(5.21), (5.22)"),
        Step("principle:L", lesson.say("stated.L"), tuple(both), lesson.say("stated.L.reason"), "(5.23)"),
        _forces(lesson, page),
    ]


def _general(lesson: Lesson) -> tuple[Symbol, Symbol, Symbol, Symbol]:
    """Name any coordinate q_i, its rate, Q_i and Q_i^A."""
    keys = iter(ANY)
    letter = lesson.letters["q"]
    lesson.names[q := next(keys)] = Name(Letter(letter, ("i",)))
    lesson.names[qd := next(keys)] = Name(Letter(letter, ("i",), dots=1))
    force = lesson.called(next(keys), Letter("Q", ("i",)))
    return Symbol(q), Symbol(qd), force, lesson.called(next(keys), Letter("Q", ("i",), above="A"))


def _forces(lesson: Lesson, page: Printable) -> Step:
    """Return Q_i^A of every coordinate: its drive, and what else acts."""
    blocks: list[Block] = []
    slides = [unit == "m" for unit in SceneUnits(lesson.scene).velocities]
    acting = generalized_forces(lesson.scene, lesson.graph)
    for i, form in enumerate(page.right):
        key = f"QA:{i + 1}"
        node = acting[i] + (lesson.drives[i] if lesson.scene.drives[i] else lesson.graph.zero)
        lesson.called(key, Letter("Q", (str(i + 1),), above="A"), node)
        blocks += [_said(lesson, i, slides[i]), Formula(key, form)]
    return Step(
        "principle:forces", lesson.say("generalized"), tuple(blocks), lesson.say("generalized.reason"), show=("forces",)
    )


def _said(lesson: Lesson, i: int, slides: bool) -> Words:
    joint = next(one for one in lesson.scene.joints if lesson.scene.coordinates[i] in one.coordinates)
    drive = lesson.scene.drives[i]
    key = f"generalized.driven{'.slide' if slides else ''}" if drive else "generalized.passive"
    places = {"drive": Symbol(drive)} if drive else {}
    return lesson.say(key, q=named(lesson.state.q[i]), joint=joint.name, **places)


def _less(a: Form, b: Form) -> Form:
    return Form.sum((a, Form.product((Number.MINUS_ONE, b))))


SHOWS: Mapping[str, tuple[str, ...]] = {
    "scene": ("frames", "angles", "names"),
    "coordinates": ("angles",),
    "acting": ("forces",),
    "lengths": ("forces",),
    "principle:forces": ("forces",),
    "rotation": ("frames", "angles"),
    "position": ("places",),
    "velocity": ("velocities",),
    "turning": ("frames", "velocities"),
    "square": ("velocities",),
    "spin": ("velocities",),
    "offset": ("velocities",),
    "kinetic": ("velocities", "energies"),
    "potential": ("places", "weights"),
    "springs": ("forces", "energies"),
    "energies": ("energies",),
    "lagrangian": ("energies",),
    "momentum": ("momenta",),
    "rate": ("momenta", "accelerations"),
    "slope": ("weights", "forces"),
    "equation": ("inertia", "weights", "forces"),
    "coefficients:k_z": ("accelerations", "inertia"),
    "coefficients:k_C": ("coriolis",),
    "coefficients:k_D": ("centrifugal",),
    "coefficients:k_G": ("weights",),
    "coefficients:k_E": ("forces",),
    "meaning:k_z": ("accelerations", "inertia"),
    "meaning:k_C": ("coriolis",),
    "meaning:k_D": ("centrifugal",),
    "meaning:k_G": ("weights",),
    "state": ("angles", "velocities", "accelerations"),
    "torque": ("inertia", "weights", "forces"),
    "power": ("energies", "plots"),
    "power.numbers": ("energies", "plots"),
    "joints": ("frames", "names"),
}
"""Words of `symdyn.teach.render.html`; of two beginnings the longer one counts."""

OF_A_MASS = ("position", "velocity", "turning", "square", "spin", "offset", "kinetic", "potential")
"""Steps whose key ends with the index of a mass: the figure points at its body."""


def with_figures(section: Section, result: list[Mass]) -> Section:
    """Return a section whose steps say what the figure shows, those that say it themselves as they are."""
    bodies = {mass.tag: mass.body.name for mass in result}
    return replace(section, steps=tuple(step if step.show else _shown(step, bodies) for step in section.steps))


def _shown(step: Step, bodies: Mapping[str, str]) -> Step:
    kind, _, of = step.key.partition(":")
    known = [key for key in SHOWS if step.key == key or step.key.startswith((f"{key}:", f"{key},"))]
    words = SHOWS[max(known, key=len)] if known else ()
    pointed = (f"body:{bodies[of]}",) if kind in OF_A_MASS and of in bodies else ()
    return replace(step, show=(*words, *pointed))


def scene_section(lesson: Lesson, chosen: Chosen, *first: Step) -> Section:
    """Return the section of the mechanism: its first steps, coordinates, what acts, all symbols, joints."""
    steps = [*first, coordinate_step(lesson, lesson.graph, chosen), *acting_steps(lesson), *length_steps(lesson)]
    return lesson.section("scene", [*steps, notation_step(lesson), joints_step(lesson)])


def energy_sections(lesson: Lesson, result: list[Mass]) -> Iterator[Section]:
    """Yield the sections of positions, velocities, energies, and the Lagrangian, each derived when it is asked for."""
    yield lesson.section("positions", position_steps(lesson, result))
    yield lesson.section("velocities", velocity_steps(lesson, result))
    *energies, lagrangian = energy_steps(lesson, result)
    yield lesson.section("energies", energies)
    yield lesson.section("lagrangian", [lagrangian])


UNTIL = ("energies", "lagrangian", "equations", "coefficients", "numbers")
"""The parts that it may end with."""


def lagrange_walkthrough(scene: Scene, language: str = "en", until: str = "numbers") -> Document:
    """Return the walkthrough of an open mechanism by Lagrange's equations (5.21)-(5.23), up to one of `UNTIL`.

    Raises:
        DerivationError: the mechanism has constraints or no closed form.
    """
    lesson = Lesson(without_hidden_zeros(scene), language)
    assert lesson.forms.n == lesson.state.n, "closed forms and graph have the same velocities"  # raises early
    lesson.numbers = numbers_for(lesson)
    found = lesson.masses
    chosen = choose_state(lesson.scene, lesson.state, lesson.graph)
    page = name_coefficients(lesson)
    letters = picture_letters(lesson.scene, lesson.graph, chosen)
    shown, last = scene_step(lesson, scene_picture(lesson, chosen, letters)), UNTIL.index(until)
    sections = [
        scene_section(lesson, chosen, shown, *silent_steps(lesson), task_step(lesson)),
        lesson.section("principle", principle_steps(lesson, page)),
        *([lesson.section("rotations", turned)] if (turned := rotation_steps(lesson, found)) else []),
        *islice(energy_sections(lesson, found), 3 + (last >= 1)),
    ]
    if last >= 2:
        sections.append(lesson.section("equations", [*equation_steps(lesson, page), *kane_steps(lesson, page, chosen)]))
    if last >= 3:
        if solved := [*solved_steps(lesson, chosen), *uniform_steps(lesson, chosen)]:
            sections.append(lesson.section("explicit", solved))
        steps = coefficient_steps(lesson, page)
        meanings = meaning_steps(lesson, page, found)
        weights = weights_picture(lesson, chosen, found)
        if weights is not None:
            meanings = _with_picture(meanings, weights, "k_G")
        if lesson.numbers and (forces := centrifugal_picture(lesson, chosen, found)) is not None:
            meanings = _with_picture(meanings, forces, "k_D")
        sections.append(lesson.section("coefficients", [*steps, *meanings]))
    if last >= 4:
        sections += after_sections(lesson, page, chosen)
        steps = [*number_steps(lesson, page, chosen), *power_steps(lesson, page, chosen)]
        sections.append(lesson.section("numbers", steps))
    if lesson.numbers:
        sections = with_appendix(lesson, [errata(lesson, section, chosen) for section in sections])
    sections = [with_figures(section, found) for section in sections]
    title = lesson.text("title", scene=called(scene))
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections))


def _with_picture(steps: list[Step], shown: Block, kind: str) -> list[Step]:
    """Return the steps with a picture in the first one about a kind of coefficients."""
    for k, step in enumerate(steps):
        if step.key.startswith(f"meaning:{kind}"):
            return [*steps[:k], replace(step, blocks=(shown, *step.blocks)), *steps[k + 1 :]]
    return steps
