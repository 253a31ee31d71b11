"""What follows from equations once they stand, section by section: rests, what is conserved, steady motions, limits.

Coordinates that L does not know, the momenta that stay with them, and the energy that stays with time.

One start, several motions: with all terms, without those of Coriolis, without the centrifugal ones. All run at once, an
equation with its terms switched each: M q̈ = Q - s_C k_C q̇ q̇ - s_D k_D q̇² - k_G - k_E.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from symdyn.algebra import Array, Batches, Form, Number, Symbol
from symdyn.draw import Text
from symdyn.dynamics.mechanism import TIME, generalized_forces, prescribed
from symdyn.dynamics.outputs import BRANCHES
from symdyn.emit.print import ArmStep, Printable, PrintName, arm_steps, latex_symbols
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, evaluate, gradient, reachable, repeated, substitute
from symdyn.scene import Quantity, SceneUnits
from symdyn.teach.derivations.charts import DASHED, DOTTED, HIGH, SOLID, Curve, Panel, chart, landscape_step, phase_step
from symdyn.teach.derivations.elsewhere import elsewhere
from symdyn.teach.derivations.equation_steps import coefficient_key, momentum_form, node_of
from symdyn.teach.derivations.equilibria import equilibrium_step, near_rest_steps, places_of_rest
from symdyn.teach.derivations.forced import forced_steps
from symdyn.teach.derivations.limits import limits_step
from symdyn.teach.derivations.meaning import axes_of
from symdyn.teach.derivations.precession import precession_steps
from symdyn.teach.derivations.reduced import cyclic_of, led_by, reduced, swings_step, zero
from symdyn.teach.derivations.steady import steady_step
from symdyn.teach.derivations.velocities import folded
from symdyn.teach.document import Block, Formula, Letter, Picture, Section, Step, Words
from symdyn.teach.lesson import Lesson, Prose, named, together
from symdyn.teach.shown_state import Chosen

SECONDS, MOMENTS = 2.0, 161
"""How long the motions are, at most, and how many moments are drawn."""

MOST_CALLS = (650, 300)
"""Evaluations of the equations, of up to two freedoms and of more; longer motions are shown as far as that goes."""

SHORTEST = 0.1
"""s: motions that run away sooner are not compared."""

LOOKS = (SOLID, DASHED, DOTTED)


@dataclass(frozen=True)
class ComparedRuns:
    """Motions from one start."""

    t: Array  # shape (N,), s
    q: Array  # shape (variants, n, N)
    balance: Array  # change of K + P less the work of all forces, J, at the end; shape (variants,)
    energy: float  # K + P at the start, J


class _TooLongError(Exception):
    """A motion that takes too many evaluations, and the time that it reached, s."""

    def __init__(self, reached: float) -> None:
        super().__init__(f"too many evaluations at t = {reached:g} s")
        self.reached = reached


def comparison_step(lesson: Lesson, page: Printable, chosen: Chosen) -> Step | None:
    """Return the motions side by side and what their energies do; None where no coefficient of rates is left."""
    kinds = [kind for kind in ("k_C", "k_D") if any(not c.vanishes for row in page.rows for c in row if c.kind == kind)]
    if not kinds or led_by(lesson):
        return None
    if told := elsewhere(lesson, "compare"):
        return Step("compare", told, ())
    found = runs(lesson, page, chosen, [(), *((kind,) for kind in kinds)])
    if found is None:
        return None
    names = [lesson.text("compare.all"), *(lesson.text(f"compare.{kind}") for kind in kinds)]
    units, symbols = SceneUnits(lesson.scene).coordinates, latex_symbols(lesson.scene)
    panels, last = [], float(found.t[-1])
    for i, q in enumerate(lesson.state.q):
        low, high = float(found.q[:, i].min()), float(found.q[:, i].max())
        room = 0.06 * (high - low) or 0.5
        label = Text.of_name(symbols[str(q.value)]).with_unit(lesson.scene.shown_unit(units[i]))
        curves = [
            Curve(np.stack([found.t, found.q[k, i]], axis=1), LOOKS[k], Text.as_written(name) if i == 0 else None)
            for k, name in enumerate(names)
        ]
        time = Text.of_name("t").with_unit(lesson.scene.shown_unit("s"))
        corners = (0.0, low - room), (last, high + room)
        panels.append(Panel(time, label, *corners, curves, (), (False, False), HIGH * 0.75))
    title = lesson.text("compare.alt", scene=lesson.scene.name)
    picture = Picture(chart(title, panels, lesson.written, "compare-"), lesson.say("compare.caption"), title, "compare")
    apart = [float(np.abs(found.q[k] - found.q[0]).max()) for k in range(len(names))]
    none = 1e-6 * (1e-3 + abs(found.energy))  # the error of the integration
    changes = [0.0 if abs(x) < none else x for x in found.balance.tolist()]
    left = [lesson.scene.in_shown_unit(lesson.about(x), "J") for x in changes]
    rows = [(name, left[k], "–" if not k else lesson.written(apart[k])) for k, name in enumerate(names)]
    table = lesson.table(("near.mode.kind", "compare.balance", "compare.apart"), rows)
    claim = lesson.say("compare", number=str(len(names)), seconds=lesson.written(last))
    show = ("coriolis", "centrifugal", "ghost")
    blocks = (picture, lesson.say("compare.energy", total=Form.sum((Symbol("K:"), Symbol("P:")))), table)
    return Step("compare", claim, blocks, lesson.say("compare.reason"), show=show)


def runs(lesson: Lesson, page: Printable, chosen: Chosen, left_out: Sequence[tuple[str, ...]]) -> ComparedRuns | None:
    """Return motions without drives from the state of the lesson, one for each set of kinds that is left out.

    None where they run away at once, or where time acts.
    """
    from scipy.integrate import solve_ivp

    state, graph, n = lesson.state, lesson.graph, lesson.state.n
    acting = generalized_forces(lesson.scene, graph)
    if graph.symbol(TIME) in reachable([*acting, lesson.L]) or len(state.q) != n:
        return None
    M = [x for p in lesson.momenta for x in gradient(p, state.qd)]
    parts: list[Expr] = []
    for kinds in (("k_C",), ("k_D",), ("k_G", "k_E")):
        parts += [
            graph.total(
                node_of(lesson, coefficient_key(c)) * (c.rate.express(graph) if c.of else graph.one)
                for c in row
                if c.kind in kinds and not c.vanishes
            )
            for row in page.rows
        ]
    moving = (*state.q, *state.qd)
    fixed = {x: np.float64(value) for x, value in chosen.values.items() if x not in moving}
    with np.errstate(all="ignore"):
        terms_at = repeated([*M, *parts, *acting], Batches(), fixed=fixed)
    switch = np.array([[kind not in out for out in left_out] for kind in ("k_C", "k_D")], dtype=np.float64)
    lanes = len(left_out)

    calls = 0

    def rates(t: float, y: Array) -> Array:
        nonlocal calls
        calls += 1
        if calls > MOST_CALLS[n > 2]:
            raise _TooLongError(t)
        z = y.reshape(2 * n + 1, lanes)
        found = terms_at(dict(zip(moving, z[: 2 * n], strict=True)))
        shaped = np.array([np.broadcast_to(x, lanes) for x in found])
        mass = shaped[: n * n].reshape(n, n, lanes).transpose(2, 0, 1)
        terms = shaped[n * n : n * n + 3 * n].reshape(3, n, lanes)
        force = shaped[n * n + 3 * n :]
        right = force - switch[0] * terms[0] - switch[1] * terms[1] - terms[2]
        faster = np.linalg.solve(mass, right.T[:, :, None])[:, :, 0].T
        return np.concatenate([z[n : 2 * n], faster, [(force * z[n : 2 * n]).sum(axis=0)]]).ravel()

    start = [chosen.values[x] for x in moving]
    first = np.repeat(np.array([*start, 0.0])[:, None], lanes, axis=1).ravel()
    last = SECONDS if n < 3 else SECONDS / 2
    while last >= SHORTEST:
        calls = 0
        with np.errstate(all="ignore"):
            try:
                run = solve_ivp(rates, (0, last), first, "DOP853", np.linspace(0, last, MOMENTS), rtol=1e-8, atol=1e-9)
            except _TooLongError as long:
                last = 0.05 * int(16 * long.reached)  # four fifths, a round number
                continue
            except (np.linalg.LinAlgError, ValueError):
                run = None
        if run is not None and run.success and np.isfinite(run.y).all() and np.abs(run.y[: n * lanes]).max() < 1e3:
            y = run.y.reshape(2 * n + 1, lanes, -1)
            return _balanced(lesson, chosen, run.t, y)
        last /= 2
    return None


def _balanced(lesson: Lesson, chosen: Chosen, t: Array, y: Array) -> ComparedRuns:
    """Return runs with their energies looked at."""
    state, n = lesson.state, lesson.state.n
    energy = lesson.energy.K + lesson.energy.P
    ends = []
    for moment in (0, -1):
        values = {**chosen.values, **dict(zip((*state.q, *state.qd), y[: 2 * n, :, moment], strict=True))}
        ends.append(np.broadcast_to(evaluate([energy], Batches(), values)[0], y.shape[1]))
    balance = ends[1] - ends[0] - y[2 * n, :, -1]
    assert math.isfinite(float(ends[0][0])), "the start has an energy"
    return ComparedRuns(t, y[:n].transpose(1, 0, 2), np.asarray(balance), float(ends[0][0]))


def momentum_steps(lesson: Lesson, page: Printable, chosen: Chosen) -> list[Step]:
    """Return a step a cyclic coordinate, or one that says why there is none; then what is said of the energy."""
    cyclic = cyclic_of(lesson)
    steps = [_cyclic(lesson, page, k, first=k == cyclic[0]) for k in cyclic] or [_none(lesson)]
    return [*steps, _energy(lesson, chosen)]


def _cyclic(lesson: Lesson, page: Printable, k: int, first: bool) -> Step:
    """Return the momentum of a coordinate, and what changes it."""
    state, q = lesson.state, named(lesson.state.q[k])
    p = lesson.name(f"p:{k + 1}", "p", str(k + 1), node=lesson.momenta[k])
    axis = axes_of(lesson)[k]
    blocks: list[Block] = [folded(lesson, Formula(p.name, momentum_form(lesson, k)))]
    if axis is not None and axis.joint.armature == Quantity.ZERO:
        key = "momentum.slide" if axis.slides else "momentum.turn"
        blocks.append(lesson.say(key, p=p, joint=axis.joint.name))
    right = page.right[k]
    key = "momentum.kept" if right == Number.ZERO else "momentum.driven"
    blocks.append(lesson.say(key, p=p, right=right, q=q, rate=lesson.rate(p.name, lesson.momentum_rates[k])))
    reason = lesson.say("momentum.noether") if first else Words(())
    claim = lesson.say("momentum.cyclic", q=q, p=p)
    show = ("momenta", f"joint:{_joint(lesson, k)}")
    assert str(state.q[k].value) == q.name, "a coordinate is called by its name"
    return Step(f"cyclic:{k + 1}", claim, tuple(blocks), reason, show=show)


def _joint(lesson: Lesson, k: int) -> str:
    """Return the joint of a velocity."""
    return [joint.name for joint in lesson.scene.moving for _ in joint.coordinates][k]


def _none(lesson: Lesson) -> Step:
    """Return why no coordinate is cyclic: whether P alone depends on one, or K too."""
    state, led = lesson.state, led_by(lesson)
    slopes = [(k, gradient(lesson.energy.K, [q])[0]) for k, q in enumerate(state.q) if k not in led]
    alone: list[Form] = [named(state.q[k]) for k, slope in slopes if zero(lesson, slope)]
    key = "momentum.potential.one" if len(alone) == 1 else "momentum.potential"
    blocks: tuple[Block, ...] = (lesson.say(key, names=together(alone)),) if alone else ()
    return Step("no momentum", lesson.say("momentum.none"), blocks, show=("momenta",))


def _energy(lesson: Lesson, chosen: Chosen) -> Step:
    """Return whether K + P stays, what takes or gives it, or what stays in its place where a motion is prescribed."""
    graph, show = lesson.graph, ("energies", "plots")
    total = Form.sum((Symbol("K:"), Symbol("P:")))
    if led := led_by(lesson):
        told = Step("energy", lesson.say("energy.led", total=total), (), show=show)
        if (node := _jacobi(lesson)) is None:
            return told
        h = lesson.name("h:", "H", node=node)
        try:
            block = folded(lesson, Formula(h.name, lesson.short(node)))
        except (DerivationError, KeyError):
            return told
        free = [k for k in range(lesson.state.n) if k not in led]
        moving, rates = (together([named(x[k]) for k in free]) for x in (lesson.state.q, lesson.state.qd))
        claim = lesson.say("energy.jacobi", total=total, h=h, q=moving, rates=rates)
        return Step("energy", claim, (block,), lesson.say("energy.jacobi.reason", h=h), show=show)
    acting = generalized_forces(lesson.scene, graph)
    timed = {graph.symbol(TIME), *lesson.state.clock}.intersection(reachable([lesson.L, *acting]))
    some = [named(q) for q, force in zip(lesson.state.q, acting, strict=True) if not force.is_zero]
    key = "timed" if timed else "spent" if some else "kept"
    reason = lesson.say("energy.reason", total=total) if key == "kept" else Words(())
    return Step("energy", lesson.say(f"energy.{key}", total=total, names=together(some)), (), reason, show=show)


def _jacobi(lesson: Lesson) -> Expr | None:
    """Return Σ q̇ ∂L/∂q̇ - L of what is free, at prescribed constant rates; None where L depends on time."""
    state, graph, led = lesson.state, lesson.graph, led_by(lesson)
    free = [k for k in range(state.n) if k not in led]
    if not free or len(state.q) != state.n or not all(zero(lesson, lesson.slopes[k]) for k in led):
        return None
    rates = prescribed(lesson.scene, graph).velocity
    put = dict(zip((state.qd[k] for k in led), rates, strict=True)) | {state.q[k]: graph.zero for k in led}
    (L,) = substitute([lesson.L], put)
    if graph.symbol(TIME) in reachable([L, *rates]):
        return None
    return graph.total([*(gradient(L, [state.qd[k]])[0] * state.qd[k] for k in free), -L])


MOST = 3
"""Degrees of freedom up to which it is all said; of more, where the mechanism rests and what is conserved."""


def after_sections(lesson: Lesson, page: Printable, chosen: Chosen) -> list[Section]:
    """Return the sections after the equations of an open mechanism; their keys begin with "after"."""
    rests, small = places_of_rest(lesson, chosen), lesson.state.n <= MOST
    driven = rests.why == "driven"  # a motion is prescribed, or time acts
    left = reduced(lesson, chosen) if small else None
    steady = None if left is None else steady_step(lesson, left)
    seen = phase_step(lesson, left) if left is not None else None
    if left is None and small and not driven:
        seen = landscape_step(lesson, rests, chosen)
    resting = [] if driven else [equilibrium_step(lesson, rests), *near_rest_steps(lesson, rests, chosen)]
    found: dict[str, list[Step | None]] = {
        "after.rests": list(resting),
        "after.forced": list(forced_steps(lesson, chosen)) if driven else [],
        "after.conserved": list(momentum_steps(lesson, page, chosen)),
        "after.steady": [steady, *(precession_steps(left) if left is not None else [])],
        "after.landscape": [seen],
        "after.terms": [comparison_step(lesson, page, chosen) if small else None],
        "after.limits": [limits_step(lesson), swings_step(lesson, left) if left else None] if small else [],
        "after.arm": list(inverse_kinematics_steps(lesson)),
    }
    kept = {key: [step for step in steps if step is not None] for key, steps in found.items()}
    return [lesson.section(key, steps) for key, steps in kept.items() if steps]


def inverse_kinematics_steps(lesson: Prose) -> Iterator[Step]:
    """Yield how the angles of the first arm with a closed form are found; nothing where there is none."""
    for end in lesson.scene.points or lesson.scene.bodies:
        try:
            told = list(arm_steps(lesson.scene, end.name))
        except DerivationError:
            continue
        yield from (_arm_step(lesson, end.name, one) for one in told)
        return


def _arm_step(lesson: Prose, end: str, told: ArmStep) -> Step:
    own = {name for row in told.rows for name in (row.name, *row.form.symbols)}
    own |= {x for names in told.names.values() for x in names}
    for name in sorted(own - latex_symbols(lesson.scene).keys()):
        look = PrintName.of_code(name)
        below = (look.subscript,) if look.subscript else ()
        lesson.called(name, Letter(look.head, below, accent="bar" if name.endswith("_") else ""))  # d3 is the scene's
    places: dict[str, Words | Form | str] = {x: together([*map(Symbol, y)]) for x, y in told.names.items()}
    blocks = tuple(Formula(row.name, row.form) for row in told.rows)
    if told.title:
        first, *more = told.keys
        reason = lesson.say(f"arm.{more[0]}", **places) if more else Words(())
        return Step(f"arm:{told.title}", lesson.say(f"arm.{first}", q=Symbol(told.title), **places), blocks, reason)
    kind = "wrist" if len(told.names["parallel"]) < len(told.names["meeting"]) else "parallel"
    places |= {"end": end, "branches": str(BRANCHES)}
    return Step(
        "arm", lesson.say("arm.pose", **places), (lesson.say(f"arm.{kind}", **places),), lesson.say("arm.reach")
    )
