"""Steps: the scene in numbers at one state: values, each coefficient's share of each torque, the power balance."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra import Form, Number, Symbol
from symdyn.draw import Lettered, Wrench, picture
from symdyn.dynamics.mechanism import TIME, vector
from symdyn.emit.print import Printable
from symdyn.graph import Expr, tangents
from symdyn.scene import SceneUnits
from symdyn.scene.values import force_unit
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.lagrange.equation_steps import coefficient_key, coefficient_unit, node_of
from symdyn.teach.document import Bar, Block, Formula, Name, Picture, Shares, Step
from symdyn.teach.lesson import Lesson, Prose, named
from symdyn.teach.masses import Mass
from symdyn.teach.shown_state import Chosen, idle_velocities, rates_of, timed

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
    reason = lesson.say("state.reason.closed" if scene.is_closed else "state.reason")
    blocks: tuple[Block, ...] = (lesson.table(("symbol", "value", "unit"), rows),)
    if not scene.is_closed and idle_velocities(scene):
        blocks = (*blocks, lesson.say("state.undriven"))
    return Step("state", lesson.say("state"), blocks, reason)


def _values(lesson: Lesson, page: Printable, chosen: Chosen) -> Step:
    rows, slides = [], [unit == "m" for unit in SceneUnits(lesson.scene).velocities]
    for c in page.written:
        key = coefficient_key(c)
        (value,) = chosen.of(node_of(lesson, key))
        rows.append((Symbol(key), lesson.written(value), coefficient_unit(c.of, c.indices, slides)))
    table = lesson.table(("coefficient", "value", "unit"), rows)
    return Step("values", lesson.say("values"), (table,), level="full")


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


def power_step(lesson: Lesson, page: Printable, chosen: Chosen) -> Step:
    """Return the check by energy: d/dt (K + P) = Σ (τ_i + Q_i) q̇_i, decided on the graph, and in numbers."""
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
    left, *parts = chosen.of(rate, *nodes)
    parts = [0.0 if abs(x) <= NONE * max(map(abs, parts)) else x for x in parts]
    size = sum(map(abs, (*parts, *rates_of(lesson.energy, state, chosen))))
    assert abs(left - sum(parts)) <= 1e-9 * (1 + size), "the power of the drives is not the rate of K + P"
    blocks: list[Block] = [
        Formula("E:", Form.sum((Symbol("K:"), Symbol("P:")))),
        Formula(symbol.name, Form.sum(power)),
        lesson.say(
            "power.numbers",
            left=symbol,
            value=lesson.equals(left),
            parts=" + ".join(map(lesson.written, parts)).replace("+ −", "− "),
        ),
    ]
    return Step("power", lesson.say("power"), tuple(blocks), lesson.say("power.reason"))


# Pictures


def scene_picture(lesson: Prose, chosen: Chosen, letters: Sequence[Lettered] = ()) -> Picture:
    """Return the mechanism with its frames, coordinates, and letters of masses and lengths."""
    q, given, titles = chosen.q, chosen.parameters, lesson.titles
    svg = picture(lesson.scene, q, given, frames=True, prefix="scene-", titles=titles, letters=letters)
    caption = lesson.say("picture.caption", scene=lesson.scene.name)
    return Picture(svg, caption, lesson.text("picture.caption", scene=lesson.scene.name), "scene")


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
