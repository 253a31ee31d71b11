"""Moreau's time stepping for contacts: steps of one length, of first order, in which no event is located.

    q_m = q⁻ + h/2 H(q⁻) u⁻                       the midpoint
    u_f = u⁻ + h a(t_m, q_m, u⁻)                  without contacts
    u⁺  = u_f + M⁻¹(q_m) Wᵀ P                     P percussions of a step, of what is closed at the midpoint, g(q_m) ≤ 0
    0 ≤ Pn ⊥ n u⁺ + e n u⁻ ≥ 0,  -Pt ∈ μ Pn Sgn(t u⁺)
    q⁺  = q_m + h/2 H(q_m) u⁺

Forces in a step and impacts are one problem of all closed contacts, by Newton's law of restitution. The force of a
contact is told as P/h. Gaps are held by their rates: what struck stays below its plane by up to h times its velocity.
Work is that of (u⁻ + u⁺)/2, so that `energy_error` is what the steps themselves change: rounding where M is constant,
else in proportion to h. What leaves while it is still below its plane may gain up to M (h a)² in a step.

References: Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988); Jean, The non-smooth contact
dynamics method (1999).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import listed
from symdyn.frozen import replace
from symdyn.simulation.equations.complementarity import CLOSE, FREE, STICK, Case, Laws
from symdyn.simulation.equations.contact_modes import SLOW, Contacts
from symdyn.simulation.equations.settling import RESTS, part
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate.integration import InitialValueProblem, IntegrationError, Method, Piece

STEP = 1e-3
"""Length of a step, s, where none stands behind the name, moreau:1e-3."""


def refuses(system: StateEquations) -> str:
    """Return why the method does not apply, "" if it does."""
    named = [one.name for one in system.scene.unilaterals if one.active is not None]
    events = (kind for kind in system.kinds if kind.contact is None and kind.limit is None and not kind.bends)
    why = {
        "there are no contacts, stops or dry friction, and it is of first order": system.contacts is None,
        "loops are closed, and it has no projection": system.closed,
        "the scene has states of its own": system.nu > system.nv + system.hidden,
        "a controller or a function is at work": system.loop is not None,
        "it looks for no events": any(events),
        f"{listed(named)} may strike only where active, which is told by an event": bool(named),
    }
    return next((words for words, holds in why.items() if holds), "")


def run(problem: InitialValueProblem, step: float) -> Iterator[Piece]:
    """Yield a piece a sample; steps are of one length between two samples, as long as `step`, s, or shorter.

    Raises:
        IntegrationError: the motion leaves what doubles hold.
    """
    contacts, x, t = problem.system.contacts, problem.x, problem.begin
    assert contacts is not None, "it was refused"
    yield Piece(problem.times[:1], x[None], (), (t, x), 0, 0)
    for until in problem.times[1:].tolist():
        count = max(1, math.ceil((until - t) / step - RESTS))
        h = (until - t) / count
        for k in range(count):
            x, forces = _stepped(problem, contacts, t + k * h, x, h)
        if not np.isfinite(x).all():
            raise IntegrationError(f"the motion leaves what doubles hold after t = {t:g} s")
        t = until
        contacts.pushed[t] = forces
        yield Piece(np.array([t]), x[None], (), (t, x), count, 2 * count)


def _stepped(problem: InitialValueProblem, contacts: Contacts, t: float, x: Array, h: float) -> tuple[Array, Array]:
    """Return the state behind a step, in the mode that it was in, and the forces, shape (m,)."""
    system, middle = problem.system, t + h / 2
    nq, nv, velocities = system.nq, system.nv, slice(system.nq, system.nq + system.nv)
    before = x[velocities]
    x = contacts.with_mode(x, ())
    x[:nq] += h / 2 * system.calls["moved"](x[:nq], x[nq : nq + system.nu])
    found = contacts.numbers(system.evaluate("contacts", middle, x), nv)
    laws, v, P = found.laws, found.W @ before, np.zeros(len(found.W))
    free = before + h * system.rates(middle, x)[velocities]
    height = contacts.heights(found, range(len(contacts.touches)))
    closed = [k for k, (n, _) in enumerate(contacts.rows) if n is None or (found.able[k] and height[k] <= 0.0)]
    contacts.refuse_many(closed)
    some, rows = part(laws, closed)
    cases = list[tuple[int, Case]]()
    if rows:
        dry = np.array([h if n is None else 1.0 for n in some.normals])  # the friction of a joint is a force
        some = replace(some, friction=dry * some.friction, static=dry * some.static)
        target = np.zeros(len(rows))
        for k, n in enumerate(some.normals):
            if n is not None:
                target[n] = -some.restitution[k] * v[rows][n]
        P[rows] = some.percussions(found.W[rows] @ free, target)
    after = free + found.C.T @ P
    u, rates, falls = (before + after) / 2, found.W @ after, np.abs(found.W @ (free - before))
    for k, here in enumerate(closed):
        case = _case(some, k, P[rows], rates[rows], falls[rows])
        cases += [(here, case)] if case.held else []
    x[velocities] = u
    power = system.rates(middle, x)[-1]
    x[velocities] = after
    x[:nq] += h / 2 * system.calls["moved"](x[:nq], x[nq : nq + system.nu])
    if problem.project.active:  # quaternions have length 1
        x = problem.project.projected(x)
    gained = float(P @ (found.W @ u))
    u[list(system.scene.prescribed_velocities)] = 0.0
    size = CLOSE * float(np.abs(P * v).sum()) + float(np.abs(P) @ falls)
    if gained > size:
        names = listed(contacts.name(k) for k in closed)
        raise ArithmeticError(f"Newton's law of {names} would add {gained:.3g} J; give less friction or restitution")
    x[-1] += h * power + float(P @ (found.W @ u))
    return contacts.with_mode(x, cases), P / h


def _case(laws: Laws, k: int, P: Array, rates: Array, falls: Array) -> Case:
    """Return what a contact does at the end of a step: what leaves by more than a step brings back is open."""
    n, along = laws.normals[k], list(laws.tangents[k])
    if n is not None and rates[n] > falls[n] + RESTS * max(1.0, float(np.abs(rates).max())):
        return FREE
    case = laws.case(k, P, np.zeros(len(laws.normals)))
    slips = case.slips and float(np.linalg.norm(rates[along])) > 2 * SLOW
    return case if slips or not case.slips else Case(case.held, STICK)


METHODS = {
    "moreau": Method(
        "time stepping", "of first order: no events are located, impacts by Newton's law", "numpy", "", 0.0,
        partial(run, step=STEP), refuses, False, absolute=False, step=STEP,
    ),
}  # fmt: skip
