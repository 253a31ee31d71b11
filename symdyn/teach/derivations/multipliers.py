"""The walkthrough of a mechanism with loops or rolling by Lagrange's equations with multipliers, section by section.

Its last steps are multipliers and drives in numbers, and the check by energy: conditions do no work. The state that the
lesson shows, and the multipliers there, solve

    A u = 0, A u̇ + Ȧ u = 0             what the conditions allow; prescribed motions are rows of their own
    E_i(u̇) - A_ki λ_k = 0              where nothing drives velocity i and no motion is prescribed for it

Rates and accelerations of independent velocities are chosen near those of all lessons; the rest follows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np
from scipy.linalg import null_space

from symdyn.algebra import Array, Floats, Form, Symbol
from symdyn.dynamics.mechanism import prescribed
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, gradient, substitute, tangents
from symdyn.scene import Scene, SceneUnits, without_hidden_zeros
from symdyn.scene.values import force_unit
from symdyn.teach.derivations.constrained import Constrained
from symdyn.teach.derivations.eliminated import conserved_sections, eliminated_steps, resting_step
from symdyn.teach.derivations.equation_steps import coefficient_steps, equation_steps, kane_steps, name_coefficients
from symdyn.teach.derivations.equilibria import closed_sections
from symdyn.teach.derivations.lagrange import (
    energy_sections,
    scene_picture,
    scene_section,
    state_step,
    task_step,
    with_figures,
)
from symdyn.teach.derivations.multiplier_steps import (
    ROPE,
    condition_steps,
    multiplier,
    name_forces,
    name_ties,
    principle_steps,
    reduced_steps,
    system_step,
    unit_of,
    valued,
)
from symdyn.teach.derivations.solved_ties import solved_ties_steps
from symdyn.teach.derivations.tied_steady import tied_steady_steps
from symdyn.teach.document import Block, Document, Formula, Section, Step, Words
from symdyn.teach.lesson import called, named, silent_steps, together
from symdyn.teach.notation import scene_step
from symdyn.teach.shown_state import ACCELERATIONS, RATES, Chosen, choose_state, rates_of, starting_rates

TINY = 1e-9
WAYS = (0.3, 0.2, 0.4, 0.25, 0.35, 0.15)
"""rad or m: how far undriven coordinates are shown from where the mechanism is drawn."""


def choose_tied_motion(lesson: Constrained, chosen: Chosen | None = None) -> Chosen:
    """Return a position, that drawn where none is given, with rates and accelerations that fit all equations.

    Raises:
        DerivationError: no accelerations fit that position, as at a change point.
    """
    if chosen is None:
        chosen = _away(lesson, choose_state(lesson.scene, lesson.state, lesson.graph, moving=not lesson.ties))
    state, n, m = lesson.state, lesson.state.n, len(lesson.ties)
    led = prescribed(lesson.scene, lesson.graph)
    pins = np.eye(n)[list(led.place)].reshape(-1, n)
    A = _matrix(chosen, [tie.slopes for tie in lesson.ties], n)
    free = [k for k in lesson.partition.independent if k not in led.place]
    given = starting_rates(lesson.scene, chosen.parameters)
    wanted = [given[k] or RATES[place % len(RATES)] for place, k in enumerate(free)]
    u = _near(np.vstack([A, pins]), [*[0.0] * m, *chosen.of(*led.velocity)], free, wanted)
    chosen = _with(chosen, state.qd, u)
    bias = [-x for x in chosen.of(*(tie.bias for tie in lesson.ties))]
    idle = [k for k in range(n) if lesson.scene.drives[k] is None and k not in led.place]
    forces = [lesson.drives[k] for k in idle]
    rest = chosen.of(*substitute(forces, dict.fromkeys(state.qdd, lesson.graph.zero)))
    M = _matrix(chosen, [gradient(force, state.qdd) for force in forces], n)
    zeros = np.zeros((len(A) + len(pins), m))
    C = np.block([[np.vstack([A, pins]), zeros], [M, -A[:, idle].T.reshape(len(idle), m)]])
    right = [*bias, *chosen.of(*led.acceleration), *(-x for x in rest)]
    driven = [k for k in free if lesson.scene.drives[k]] or free
    found = _near(C, right, driven, [ACCELERATIONS[k % len(ACCELERATIONS)] for k in range(len(driven))])
    if abs(C @ found - right).max(initial=0.0) > 1e-7 * (1 + np.abs(right).max(initial=0.0)):
        raise DerivationError(
            f"{lesson.scene.name}: where the lesson shows numbers no accelerations fit the loops and rows (a change "
            "point); give the joints another start"
        )
    chosen = _with(chosen, state.qdd, found[:n])
    told = [k for k in lesson.partition.dependent if lesson.scene.drives[k]]
    carried = A.T @ found[n:]
    drives = [chosen.of(lesson.drives[k])[0] - carried[k] for k in told]
    return _with(chosen, [lesson.graph.symbol(str(lesson.scene.drives[k])) for k in told], np.array(drives))


def _away(lesson: Constrained, chosen: Chosen) -> Chosen:
    """Return another position that the conditions allow, where undriven coordinates hide nothing."""
    led = lesson.scene.prescribed_velocities
    idle = [k for k in lesson.partition.independent if lesson.scene.drives[k] is None and k not in led]
    if not idle or lesson.scene.free_parameters:
        return chosen
    numbers, n, free = lesson.workspace.loops.numbers, lesson.state.n, lesson.partition.independent
    wanted = [WAYS[place % len(WAYS)] if k in idle else 0.0 for place, k in enumerate(free)]
    A = _matrix(chosen, [tie.slopes for tie in lesson.ties], n)
    step = _near(A, [0.0] * len(A), free, wanted)
    try:
        q = numbers.closed_position(numbers.retract(np.array(chosen.q), step), ()).q
    except DerivationError:  # the loops do not close there
        return chosen
    moved = chosen.with_values(dict(zip(lesson.state.q, map(float, q), strict=True)))
    return replace(moved, q=tuple(map(float, q)))


def _matrix(chosen: Chosen, rows: Sequence[Sequence[Expr]], width: int) -> Array:
    return np.array(chosen.of(*(x for row in rows for x in row))).reshape(-1, width)


def _near(C: Array, right: Sequence[float], free: Sequence[int], requested: Sequence[float]) -> Array:
    """Return x with C x = right whose free entries are as near those wanted as C allows."""
    if not len(C):
        return np.array(requested)
    x: Array = np.linalg.lstsq(C, np.array(right), rcond=1e-10)[0]
    ways = null_space(C, rcond=1e-10)
    moved = np.linalg.lstsq(ways[list(free)], np.array(requested) - x[list(free)], rcond=1e-10)[0]
    return np.asarray(x + ways @ moved)


def _with(chosen: Chosen, symbols: Sequence[Expr], values: Array) -> Chosen:
    rounded = [0.0 if abs(x) < TINY else float(x) for x in values]
    return chosen.with_values(dict(zip(symbols, rounded, strict=True)))


SMALL = 1e-9


def forces_step(lesson: Constrained, chosen: Chosen) -> Step:
    """Return the multipliers and the drives at the chosen state."""
    rows = []
    units = [force_unit(unit) for unit in SceneUnits(lesson.scene).velocities]
    for own, unit in zip(lesson.scene.drives, units, strict=True):
        if own:
            node = lesson.names[own].node
            assert node is not None, "a drive has a value"
            rows.append((Symbol(own), lesson.about(chosen.of(node)[0]), unit))
    for tie in lesson.ties:
        rows.append(
            (multiplier(tie), lesson.about(chosen.of(valued(lesson, multiplier(tie)))[0]), unit_of(tie, lesson.scene))
        )
    if not rows:
        return Step("forces", lesson.say("forces.none"), ())
    table = lesson.table(("symbol", "value", "unit"), rows)
    return Step("forces", lesson.say("forces"), (table,), lesson.say("forces.reason"), show=("reactions", "forces"))


def tied_power_steps(lesson: Constrained, right: Sequence[Form], chosen: Chosen) -> list[Step]:
    """Return d/dt (K + P) = Σ (drive + Q) u + Σ λ_k ḟ_k, whose last sum vanishes; no multiplier is in `right`."""
    state = lesson.state
    total = lesson.energy.K + lesson.energy.P
    (rate,) = tangents([total], state.acceleration)
    lesson.name("E:", "E", node=total)
    symbol = lesson.rate("E:", rate)
    power = [force.signed_product(named(u)) for force, u in zip(right, state.qd, strict=True) if force.terms]
    held = [Form.product((multiplier(tie), Symbol(tie.rate))) for tie in lesson.ties]
    left, *parts = chosen.of(rate, *(valued(lesson, form) for form in (*power, *held)))
    size = SMALL * (1 + sum(map(abs, (*parts, *rates_of(lesson.energy, state, chosen)))))
    assert abs(left - sum(parts)) <= size, "the power of all forces is not d/dt (K + P)"
    assert sum(map(abs, parts[len(power) :])) <= size, "a condition does work"
    value, done = (0.0 if abs(x) <= size else x for x in (left, sum(parts[: len(power)])))
    idle = any(lesson.scene.drives[k] is None for k in lesson.partition.independent)  # then only in its own motion
    whole = Form.sum([*power, *held])
    blocks: tuple[Block, ...] = (
        Formula("E:", Form.sum((Symbol("K:"), Symbol("P:")))),
        Words((symbol, " = ", whole)) if idle else Formula(symbol.name, whole),
    )
    reason = lesson.say("tied.power.reason" if lesson.ties else "power.reason")
    numbers = lesson.say("tied.power.numbers", left=symbol, value=lesson.equals(value), done=lesson.about(done))
    return [
        Step("power", lesson.say("power"), blocks, reason, show=("energies",)),
        Step("power.numbers", numbers, ()),
    ]


def after_sections(lesson: Constrained, chosen: Chosen) -> list[Section]:
    """Return where it rests, what is conserved and steady motions."""
    rests, steady = tied_steady_steps(lesson, chosen)
    found = closed_sections(lesson, resting_step(lesson, chosen), partial(_is_told, lesson))
    if rests:
        found = [lesson.section("after.rests", [*(step for section in found for step in section.steps), *rests])]
    after = [lesson.section("after.steady", steady)] if steady else []
    return [*found, *conserved_sections(lesson), *after]


def _is_told(lesson: Constrained, q: Array) -> bool:
    """Tell whether ropes have at a place the length that the lesson writes: elsewhere they go around otherwise."""
    at = lesson.assembled(0) | dict(zip(lesson.state.q, map(float, q), strict=True))
    ropes = [lesson.plain(tie.residual) for tie in lesson.ties if tie.words == ROPE and tie.residual is not None]
    return all(abs(float(x)) < 1e-6 for x in evaluate(ropes, Floats(), at))


UNTIL = ("conditions", "energies", "lagrangian", "equations", "system", "numbers")
"""The parts that it may end with."""


def multipliers_walkthrough(scene: Scene, language: str = "en", until: str = "numbers") -> Document:
    """Return the walkthrough of a mechanism with loops, rolling or other conditions, up to one of `UNTIL`.

    Raises:
        DerivationError: nothing ties the coordinates, or the open mechanism has no closed form.
    """
    lesson = Constrained(without_hidden_zeros(scene), language)
    assert lesson.forms.n == lesson.state.n, "closed forms and graph have the same velocities"  # raises early
    name_ties(lesson)
    chosen, found, last = choose_tied_motion(lesson), lesson.masses, UNTIL.index(until)
    shown = scene_step(lesson, scene_picture(lesson, chosen))
    parts, drives = lesson.partition, lesson.scene.drives
    tied = parts.dependent if all(drives[k] for k in parts.independent) else ()
    ropes = [multiplier(tie) for tie in lesson.ties if tie.words == ROPE] if last >= 3 else []
    wanted = [lesson.say("task.tension", names=together(ropes))] if ropes else []
    task = task_step(lesson, *wanted, tied=tied)
    sections = [
        scene_section(lesson, chosen, shown, *silent_steps(lesson), task),
        lesson.section("conditions", [*condition_steps(lesson), *solved_ties_steps(lesson)]),
    ]
    if last >= 1:
        sections += islice(energy_sections(lesson, found), 3 + (last >= 2))
    if last >= 3:
        open_page = name_coefficients(lesson)
        page = replace(open_page, right=name_forces(lesson, open_page.right))
        steps = equation_steps(lesson, page)  # names what the principle is made of
        sections.append(lesson.section("principle.multipliers", principle_steps(lesson, open_page)))
        sections.append(lesson.section("equations", [*steps, *kane_steps(lesson, page, chosen)]))
        sections.append(lesson.section("coefficients.open", coefficient_steps(lesson, page)))
    if last >= 4:
        sections.append(
            lesson.section(
                "system",
                [system_step(lesson, right=True), *reduced_steps(lesson, open_page), *eliminated_steps(lesson, chosen)],
            )
        )
    if last >= 5:
        steps = [
            state_step(lesson, chosen),
            forces_step(lesson, chosen),
            *tied_power_steps(lesson, open_page.right, chosen),
        ]
        sections += [*after_sections(lesson, chosen), lesson.section("numbers", steps)]
    sections = [with_figures(section, found) for section in sections]
    title = lesson.text("title.multipliers", scene=called(lesson.scene))
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections), "multipliers")
