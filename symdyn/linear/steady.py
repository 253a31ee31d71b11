"""Whether a point is one of rest or of a steady motion, and the coordinates in which A is constant along that.

Along a steady motion the independent velocities stay, and A with them once positions that move and on which nothing
depends are no states any more: the place of a wheel on the ground, the angle of a spindle. Whether it does stay is
looked at a second time, after the mechanism has moved on by about a radian.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.dynamics.loops import Numbers
from symdyn.dynamics.outputs import COLUMNS
from symdyn.errors import DerivationError, LinearizeError
from symdyn.frozen import dataclass, replace
from symdyn.linear.evolution import EQUAL, STILL, SpinAxes, seen, ways
from symdyn.linear.linearization import Linearization
from symdyn.linear.modes import NOTHING, balance, untouched
from symdyn.linear.prepared import Prepared, prepared
from symdyn.linear.search import nearest
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import acceleration_name
from symdyn.simulation import Problem, opened

BALANCED = 1e-6
"""Accelerations, over the largest entry of A or 1, that are none."""

TRIES, CLOSE, FARTHEST = 40, 1e-9, 0.3
"""Newton steps to a steady motion, the step that is none, and the longest, rad or m."""

LATER = (0.37, 1.1, 2.9)
"""Times, s, at which it is looked whether a point lasts where time itself acts."""

AWAY = 0.05
"""How far, rad or m, to look whether equilibria go on."""

MOVES = 1e-9
"""Rates, rad/s or m/s, of a start that are none."""

ON, STEPS = 0.9, 32
"""How far, rad or m, the mechanism is moved on, and in how many steps."""


def settled(requested: Prepared, system: Linearization, anywhere: bool = False) -> Linearization:
    """Return a system at a point of rest, or of a steady motion with its cyclic positions dropped.

    Raises:
        LinearizeError: it is neither, with what is out of balance and where it is not; not if `anywhere` is asked for.
    """
    off = _accelerated(requested, system)
    still = system.still
    if not off and still:
        why = _passing(requested, system)
        if why and not anywhere:
            raise LinearizeError(f"{system.scene.name}: {why}")
        return replace(system, kind="moving") if why else with_families(requested, system)
    if off:
        if anywhere:
            return replace(system, kind="moving")
        raise LinearizeError(_out_of_balance(requested, system, off, still))
    steady, why = _steady(requested, system)
    if steady is not None:
        return steady
    if anywhere:
        return replace(system, kind="moving")
    raise LinearizeError(f"{system.scene.name}: {why}")


def _accelerated(requested: Prepared, system: Linearization) -> list[int]:
    """Return the velocities that change, of those that are independent or prescribed."""
    velocities = system.velocities
    size = max(1.0, float(np.abs(system.A[system.positions :]).max(initial=0.0)))
    watched = (*velocities, *requested.functions.w.prescribed.place)
    return [k for k in watched if abs(system.point.udot[k]) > BALANCED * size]


def _passing(requested: Prepared, system: Linearization) -> str:
    """Return why a point of rest does not last, "" where it does: forces and motions that time changes."""
    for more in LATER if requested.timed else ():
        later = requested.at(system.point.q, system.point.u, system.point.t + more, like=system)
        changed = ", ".join(acceleration_name(system.scene.first_order[k]) for k in _accelerated(requested, later))
        what = f"{changed} would not be zero any more" if changed else "A is another"
        if changed or not np.allclose(later.A, system.A, rtol=EQUAL, atol=EQUAL * np.abs(system.A).max(initial=0.0)):
            return (
                f"no equilibrium at this point: at t = {later.point.t:g} s {what}, as forces or motions depend on "
                f"time; give forces that last, or {argument('anywhere', True)} for A at this instant"
            )
    return ""


def _steady(requested: Prepared, system: Linearization) -> tuple[Linearization | None, str]:
    """Return the system along a steady motion, or why it is none."""
    rates = _rates_of_positions(requested, system)
    labels = COLUMNS["q"](requested.functions.w)
    q, time = _later(requested, system)
    try:
        later = requested.at(q, _velocities(requested, system, q), system.point.t + time, like=system)
    except LinearizeError:
        later = system
    changed = _accelerated(requested, later) if requested.timed else []
    if changed:
        told = ", ".join(acceleration_name(system.scene.first_order[k]) for k in changed)
        return None, (
            f"no steady motion: at t = {later.point.t:.3g} s {told} would not be zero any more, as forces or motions "
            f"depend on time; give forces that last, or {argument('anywhere', True)} for A at this instant"
        )
    M, after = (requested.place(one.point.q, one.point.u, one.point.t).M for one in (system, later))
    lasting: list[Lasting] = []
    for way in ways(system) if later is not system else ():
        here, there = (seen(one, system, labels, way.spin, t) for one, t in ((system, 0.0), (later, time)))
        dropped = _cyclic(here, rates)
        passing = np.abs(there.C[:, dropped]).max(axis=1, initial=0.0) > EQUAL * np.abs(there.C).max(initial=0.0)
        on = np.flatnonzero(passing | here.C[:, dropped].any(axis=1)).tolist()
        one, other = here.without(dropped, on), there.without(dropped, on)
        if _apart(one.A, other.A) <= EQUAL:
            alike = (_apart(one.B, other.B) <= EQUAL) + (_apart(M, way.turned(after, time)) <= EQUAL)
            lasting.append(Lasting(way, dropped, one, other, alike))
            if alike == BOTH:
                break
    if lasting:
        best = max(lasting, key=lambda one: one.alike)
        return _cyclic_at_rest(requested, system, _told(best, time, system), best.dropped), ""
    moving = ", ".join(system.states.names[k] for k in range(system.positions) if abs(rates[k]) > STILL)
    return None, (
        f"no steady motion: A changes as {moving} move on; velocities stay, but forces depend on where it is. Take "
        "coordinates of which those that move are cyclic, such as angles in place of a quaternion, or "
        f"{argument('anywhere', True)} for A at this instant"
    )


@dataclass(frozen=True)
class Lasting:
    """Axes in which A stays: the system at both times, its cyclic positions, and which of B and M stay, how many."""

    way: SpinAxes
    dropped: list[int]
    one: Linearization
    other: Linearization
    alike: int


BOTH = 2
"""B and the mass matrix."""


def _apart(one: Array, other: Array) -> float:
    """Return how far two matrices are apart, over the largest entry or 1."""
    return float(np.abs(one - other).max(initial=0.0)) / max(1.0, float(np.abs(one).max(initial=0.0)))


def at_rest(requested: Prepared, q: Array, u: Array) -> Linearization:
    """Return the system at a position of rest, velocities zero; errors as of `settled`."""
    found = requested.at(q, u)
    if why := _passing(requested, found):
        raise LinearizeError(f"{requested.scene.name}: {why}")
    return with_families(requested, found)


def with_families(requested: Prepared, system: Linearization) -> Linearization:
    """Return a system at rest with the directions named that lead to other equilibria: not to first order alone."""
    p = system.positions
    alone = [k for k in untouched(system.A, range(p)) if _leads_on(requested, system, np.eye(p)[k])]
    others = [k for k in range(p) if k not in alone]
    A = system.A
    scale = balance(A)
    _, values, rows = np.linalg.svd((A * scale[None, :] / scale[:, None])[:, others])
    size = float(np.abs(values).max(initial=0.0))
    rank = int(np.sum(values > NOTHING * size)) if size else 0
    ways = np.zeros((len(others) - rank, p))
    ways[:, others] = rows[rank:] * scale[others]
    family = sum(_leads_on(requested, system, way / np.abs(way).max()) for way in ways)
    return replace(system, cyclic=tuple(system.states.names[k] for k in alone), family=family)


def _leads_on(requested: Prepared, system: Linearization, way: Array) -> bool:
    """Tell whether equilibria go on along a direction of positions: Newton's method does not come back."""
    numbers = opened(system.scene).numbers()
    there = _closed(numbers, numbers.retract(system.point.q, AWAY * (system.directions @ way)))
    place = nearest(requested, there, system.point.u, system.point.t, whole=False)
    far = np.abs(there - system.point.q).max()
    return place is not None and bool(np.abs(place[0] - there).max() < far / 4)


def _cyclic_at_rest(
    requested: Prepared, full: Linearization, steady: Linearization, dropped: Sequence[int]
) -> Linearization:
    """Return a steady system with those of its positions named that do not move and on which nothing depends."""
    numbers, names = opened(full.scene).numbers(), []
    for k in untouched(steady.A, range(steady.positions)):
        way = full.directions[:, full.states.names.index(steady.states.names[k])]
        q = _closed(numbers, numbers.retract(full.point.q, AWAY * way))
        try:
            there = requested.at(q, _velocities(requested, full, q), full.point.t, like=full).without(dropped)
        except LinearizeError:
            continue
        if np.allclose(there.A, full.without(dropped).A, rtol=EQUAL, atol=EQUAL * np.abs(full.A).max()):
            names.append(steady.states.names[k])
    return replace(steady, cyclic=tuple(names))


def _cyclic(system: Linearization, rates: Array) -> list[int]:
    """Return the positions that move and on which nothing depends, one after the other."""
    dropped: list[int] = []
    while True:
        rest = [k for k in range(len(system.states)) if k not in dropped]
        moving = [i for i, k in enumerate(rest) if k < system.positions and abs(rates[k]) > STILL]
        more = [rest[i] for i in untouched(system.A[np.ix_(rest, rest)], moving)]
        if not more:
            return sorted(dropped)
        dropped += more


def _told(lasting: Lasting, time: float, full: Linearization) -> Linearization:
    """Return a steady system with the notes that say how it is known to be one, and what of it does not stay."""
    steady, later = lasting.one, lasting.other
    apart = float(np.abs(steady.A - later.A).max(initial=0.0))
    same = "the same" if apart == 0 else f"the same to {apart:.1g}"
    notes = [f"steady motion: A is {same} at t = {full.point.t:g} s and {full.point.t + time:.3g} s"]
    notes += lasting.way.words
    if steady.dropped:
        notes.append(f"cyclic, and no states: {', '.join(steady.dropped)}")
    lost = [name for name in full.outputs.names if name not in steady.outputs.names]
    if lost:
        notes.append(f"no outputs, as they move on for ever: {', '.join(lost)}")
    for letter, axis, before, after in (
        ("B", steady.inputs, steady.B.T, later.B.T),
        ("C and D", steady.outputs, np.hstack([steady.C, steady.D]), np.hstack([later.C, later.D])),
    ):
        passing = [name for name, x, y in zip(axis.names, before, after, strict=True) if _apart(x, y) > EQUAL]
        if passing:
            notes.append(f"{letter} of {', '.join(passing)}: of this instant alone, as what moves on changes it")
    return replace(steady, kind="steady", notes=(*full.notes, *notes))


def _rates_of_positions(requested: Prepared, system: Linearization) -> Array:
    labels = COLUMNS["q"](requested.functions.w)
    return np.array([system.point.u[labels.index(name)] for name in system.states.names[: system.positions]])


def _velocities(requested: Prepared, system: Linearization, q: Array) -> Array:
    """Return velocities at a position whose independent ones are those of the point."""
    G, _ = requested.kinematics(q, system.point.t)
    independent = system.velocities
    led = list(requested.functions.w.prescribed.place)
    kept = [*independent, *led]
    dependent = [k for k in range(len(system.point.u)) if k not in kept]
    u = system.point.u.copy()
    if dependent:
        u[dependent] = -np.linalg.lstsq(G[:, dependent], G[:, kept] @ u[kept], rcond=None)[0]
    return u


def _later(requested: Prepared, system: Linearization) -> tuple[Array, float]:
    """Return where the mechanism is after about a radian or a metre, and when, s; what has no rate has stayed."""
    numbers, labels = opened(system.scene).numbers(), COLUMNS["q"](requested.functions.w)
    time = ON / float(np.abs(system.point.u[: len(system.scene.velocities)]).max())
    q, step = system.point.q.copy(), time / STEPS

    def rate(place: Array) -> Array:
        return requested.kinematics(place)[1] @ _velocities(requested, system, place)

    for _ in range(STEPS):  # Runge and Kutta's
        first = rate(q)
        second = rate(q + step / 2 * first)
        third = rate(q + step / 2 * second)
        q = q + step / 6 * (first + 2 * second + 2 * third + rate(q + step * third))
    q = _closed(numbers, q)
    for k, name in enumerate(system.scene.coordinates):
        if name in labels and abs(system.point.u[labels.index(name)]) <= STILL:
            q[k] = system.point.q[k]
    return q, time


def _closed(numbers: Numbers, q: Array) -> Array:
    q = numbers.normalised(q)
    return numbers.newton(q, ()) if numbers.scene.is_constrained else q


def _out_of_balance(requested: Prepared, system: Linearization, off: Sequence[int], still: bool) -> str:
    """Return what is said of a point that is no equilibrium: what accelerates, and where nothing would."""
    scene = system.scene
    units = [*(f"{unit}/s^2" for unit in SceneUnits(scene).velocities), *(one.rate_unit for one in scene.states)]
    sizes = {k: scene.in_shown_unit(f"{system.point.udot[k]:.6g}", units[k]) for k in off}
    told = ", ".join(f"{acceleration_name(scene.first_order[k])} = {size}" for k, size in sizes.items())
    what = "equilibrium" if still else "steady motion"
    of_start = "".join(f" ({note})" for note in system.notes if note.startswith("start: "))
    words = f"{scene.name}: no {what} at this point: {told}{of_start}{_precession(system, off)}"
    point = system.point
    rest = nearest(requested, point.q, point.u, point.t) if still else None
    place = rest[0] if rest else None if still else _balanced(requested, system)
    held = _holding(requested, system) if still else ""
    hold = f"it is held there by {held}" if held else "give forces that hold it"
    if place is None:
        other = hold if held else "give forces or rates that balance it"
        return f"{words}; none is near; {other}, or {argument('anywhere', True)} for A at this instant"
    there = dict(zip(scene.coordinates, place, strict=True))
    if rest:
        there |= dict(zip(scene.first_order, rest[1], strict=True))
    near = argument("start", {name: _rounded(x) for name, x in there.items() if name not in scene.velocities})
    kept = "" if still else " and the same rates"
    return f"{words}; the nearest {what} is at {near}{kept}; or {hold}, or {argument('anywhere', True)}"


def _precession(system: Linearization, off: Sequence[int]) -> str:
    """Return what is said of accelerations of what spins by a quaternion: in angles a precession may be steady."""
    first, words = 0, ""
    for joint in system.scene.moving:
        here = range(first, first + len(joint.rates))
        if joint.velocities and any(k in off for k in here) and np.abs(system.point.u[here.start : here.stop]).any():
            words += (
                f" (velocities of joint {joint.name} are along axes of its body, in which those of a precession turn; "
                'by angles, orientation = "zxz" and rates of them at the start, they stay)'
            )
        first = here.stop
    return words


def _rounded(x: float) -> str:
    return f"{0.0 if abs(x) < CLOSE else x:.9g}"


def _holding(requested: Prepared, system: Linearization) -> str:
    """Return the option by which drives hold a mechanism at rest at a point, "" where they do not, or in many ways."""
    drives, point = requested.drives, system.point
    if any(k in requested.forces.formulas or k in requested.forces.tables for k in drives):
        return ""
    here = requested.place(point.q, point.u, point.t)
    missing = here.P @ point.multipliers - here.M @ point.udot
    acting = np.hstack([np.eye(len(missing))[:, drives], here.P]) * here.sizes[:, None]
    forces, _, rank, _ = np.linalg.lstsq(acting, missing * here.sizes, rcond=1e-9)
    left = np.abs(acting @ forces - missing * here.sizes).max(initial=0.0)
    if rank < acting.shape[1] or left > CLOSE * np.abs(missing * here.sizes).max(initial=0.0):
        return ""
    given = [(requested.scene.drives[k], _rounded(x)) for k, x in zip(drives, forces, strict=False)]
    return argument("forces", {str(name): x for name, x in given if x != "0"})


def steady_next_to(requested: Prepared, system: Linearization, q: Array | None = None) -> Linearization | None:
    """Return the system at the steady motion next to a point, or to q, with its independent velocities, or None."""
    here = system if q is None else requested.at(q, _velocities(requested, system, q), system.point.t, like=system)
    place = _balanced(requested, here)
    return (
        None
        if place is None
        else requested.at(place, _velocities(requested, system, place), system.point.t, like=system)
    )


def _balanced(requested: Prepared, system: Linearization) -> Array | None:
    """Return the position next to a point at which its independent velocities stay, None where Newton finds none."""
    numbers, here, p = opened(system.scene).numbers(), system, system.positions
    places = system.velocities
    for _ in range(TRIES):
        step = -np.linalg.lstsq(here.A[p:, :p], here.point.udot[places], rcond=1e-9)[0]
        longest = float(np.abs(step).max(initial=0.0))
        if longest < CLOSE:
            size = max(1.0, float(np.abs(here.A[p:]).max(initial=0.0)))
            return here.point.q if np.abs(here.point.udot[places]).max(initial=0.0) <= BALANCED * size else None
        q = here.point.q + here.moves @ (step * min(1.0, FARTHEST / longest))
        q = _closed(numbers, q)
        try:
            here = requested.at(q, _velocities(requested, system, q), system.point.t, like=system)
        except (LinearizeError, DerivationError):
            return None
    return None


def steady_at_start(scene: Scene) -> tuple[Linearization, Array] | None:
    """Return the steady motion next to the start, and the rates of coordinates there, shape (nq,).

    None where it starts at rest, or there is none; errors as of `linearize`.
    """
    problem = Problem(scene)
    asked, start = prepared(problem), problem.initial
    if np.abs(start.u).max(initial=0.0) <= MOVES:
        return None
    near = steady_next_to(asked, asked.at(start.q, start.moving))
    one = None if near is None else settled(asked, near)
    if one is None or one.kind != "steady":
        return None
    return one, asked.kinematics(one.point.q)[1] @ one.point.u
