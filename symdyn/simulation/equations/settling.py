"""What follows where a contact strikes, lifts off, slips or sticks.

Positions return to g = 0, an impact changes velocities where a gap closes, what touches at rest is set to rest, and the
mode is what keeps the laws of all contacts that touch. Where several hold the same, forces are not unique: those of
least size are taken. Flights of a ball that grow shorter without end are passed in their limit.

Reference: Brogliato, Nonsmooth Mechanics (2016), chapters 1 and 5.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.frozen import dataclass, replace
from symdyn.simulation.equations.complementarity import (
    CARRIED,
    CLOSE,
    FREE,
    LIFTED,
    OPENS,
    SLIP,
    STICK,
    Case,
    Laws,
    least,
)
from symdyn.simulation.equations.contact_modes import (
    BREAKS,
    LIFTS,
    NEAR,
    PASSED,
    SLOW,
    STOPS,
    STRIKES,
    TOLD,
    Contacts,
    Impact,
    Numbers,
)

if TYPE_CHECKING:
    from symdyn.simulation.equations.system import StateEquations

TOUCHES, RESTS = 1e-10, 1e-9
"""A gap, in m, and a velocity, in m/s over the fastest one or 1, that are none."""

FLAT, FLAT_OF_LOOPS = 1e-12, 1e-9
"""How high what bounces has to rise, m, for another flight: loops hold positions less closely."""

FAR, ROUNDED, ROUNDINGS = 100.0, 2e-15, 500.0
"""m, from where on rounding of gaps is looked at; what of a coordinate is none; times what it makes of a gap, m, that
what bounces has to rise.
"""


Solution = tuple[tuple[Case, ...], Array]
"""What contacts do, and their forces."""


def part(laws: Laws, some: Sequence[int]) -> tuple[Laws, list[int]]:
    """Return some of the contacts, in order, and their rows."""
    if len(some) == len(laws.normals):
        return laws, list(range(len(laws.D)))
    rows, normals, tangents = list[int](), list[int | None](), list[tuple[int, ...]]()
    for k in some:
        n, along = laws.normals[k], laws.tangents[k]
        normals.append(None if n is None else len(rows))
        rows += [] if n is None else [n]
        tangents.append(tuple(range(len(rows), len(rows) + len(along))))
        rows += along
    chosen = list(some)
    values = (one[chosen] for one in (laws.friction, laws.static, laws.restitution))
    return Laws(laws.D[np.ix_(rows, rows)], tuple(normals), tuple(tangents), *values), rows


@dataclass(frozen=True)
class Settling:
    """One event: what follows from a state at which contacts strike, lift off, slip or stick.

    Attributes:
        contacts: those of the system.
        n: their numbers, where the positions have returned to g = 0.
        numbers: returns those of a state; an impact changes what depends on velocities.
        t: s.
        nq, nv: coordinates and velocities in front of a state.
        flat: how high what bounces has to rise, m.
    """

    contacts: Contacts
    n: Numbers
    numbers: Callable[[Array], Numbers]
    t: float
    nq: int
    nv: int
    flat: float

    def behind(self, x: Array, struck: Collection[int], leaving: dict[int, str], broke: dict[int, Array]) -> Array:
        """Return the state behind it; `struck` are contacts, `leaving` lift off, `broke` slip that way."""
        x, laws, told, was = x.copy(), self.n.laws, self.contacts.told, self.contacts.words(x)
        velocities = slice(self.nq, self.nq + self.nv)
        u = x[velocities]
        rest = RESTS * max(1.0, float(np.abs(u).max(initial=0.0)))
        near = set(np.flatnonzero(self.n.able & (np.abs(self.n.gaps) <= TOUCHES)).tolist())
        touching = sorted({*self.contacts.closed(x), *struck, *near, *self.contacts.always})
        self.contacts.refuse_many(touching)
        v = self.n.W @ u
        impulses, lost, after = np.zeros(len(v)), 0.0, v
        normal = {k: n for k in touching if (n := laws.normals[k]) is not None}
        if any(v[n] < -rest for n in normal.values()):
            some, rows = part(laws, list(normal))
            impulses[rows] = some.impact(v[rows], [self.contacts.laws[k] == "poisson" for k in normal])
            u = u + self.n.C.T @ impulses
            after = self.n.W @ u
            lost = float(-impulses @ (v + after)) / 2
            self._refuse_gain(lost, float(np.abs(impulses * v).sum()), [k for k, n in normal.items() if impulses[n]])
            x[velocities] = u
        then = replace(self, n=self.numbers(x))
        flights = {
            k: then._flights(k, float(after[n]), touching, after, rest)
            for k, n in normal.items()
            if after[n] > rest
            and laws.restitution[k] < 1
            and (v[n] < -rest or lost > 0)  # a bounce, or kicked by one
            and k not in self.contacts.always
        }
        resting = [k for k in touching if self._still(k, after, rest) or flights.get(k) is not None]
        if resting:
            x[velocities] = u = self._at_rest(u, resting, rest)
            after, then = self.n.W @ u, replace(self, n=self.numbers(x))
        lifting = {k for k, what in leaving.items() if what == LIFTS} - set(struck)
        cases = then._mode(resting, after, rest, broke, lifting)
        x[velocities] = u = self._set_off(u, cases)
        x[-1] -= lost
        x = self.contacts.with_mode(x, cases)
        words, size = self.contacts.words(x), CLOSE * float(np.abs(impulses).max(initial=0.0))
        for k in touching:
            n, along = self.contacts.rows[k]
            before, rate = (0.0 if n is None else float(one[n]) for one in (v, after))
            impulse = (0.0 if n is None else float(impulses[n]), *impulses[list(along)].tolist())
            arrives = before < -rest or (before <= rest and words[k] != "open")
            if impulse[0] > size or (k in struck and self.t > 0.0 and arrives):
                what = STRIKES
            elif k in leaving and (
                leaving[k] != LIFTS or words[k] == "open"
            ):  # what stops may slip the other way at once
                what = BREAKS if leaving[k] == STOPS and words[k].startswith("slips") else leaving[k]
            elif was[k] != "open" and words[k] == "open":
                what = LIFTS
            else:
                continue
            name, unit = self.contacts.name(k), self.contacts.units[k]
            what = TOLD.get(self.contacts.kinds[k], {}).get(what, what)
            told.append(Impact(self.t, name, what, before, rate, impulse, max(lost, 0.0), words, flights.get(k), unit))
        return x

    def _refuse_gain(self, lost: float, size: float, some: Sequence[int]) -> None:
        """Raise ArithmeticError where an impact adds energy, which laws of impacts with friction can."""
        if lost < -CLOSE * size:
            names = ", ".join(map(self.contacts.name, some))
            newton = any(self.contacts.laws[k] == "newton" for k in some)
            other = 'write law = "poisson"' if newton else "give them one restitution, or less friction"
            raise ArithmeticError(f"the impact of {names} would add {-lost:.3g} J; {other}")

    def _still(self, k: int, v: Array, rest: float) -> bool:
        """Tell whether what touches does not open."""
        n = self.n.laws.normals[k]
        return n is None or abs(v[n]) <= rest

    def _flights(self, k: int, rate: float, touching: Sequence[int], after: Array, rest: float) -> float | None:
        """Return when the flights of a contact end that are too short to be followed; None where they are not."""
        laws, n = self.n.laws, self.n.laws.normals[k]
        assert n is not None, "it flies"
        others = [j for j in touching if j != k and self._still(j, after, rest)]
        some, rows = part(laws, others)
        falls = float(self.n.drift[n])
        if others:
            modes = self._options(others, after, rest, {})
            found = next(iter(some.solutions(self.n.drift[rows], modes)), None)
            falls += float(laws.D[n, rows] @ found[1]) if found else 0.0
        if falls >= 0 or rate * rate > 2 * self.flat * -falls:
            return None
        return float(self.t + 2 * rate / -falls / (1 - laws.restitution[k]))

    def _at_rest(self, u: Array, resting: Sequence[int], rest: float) -> Array:
        """Return velocities at which gaps that are closed do not change, and what sticks does not slip."""
        rows = []
        for k in resting:
            n, along = self.contacts.rows[k]
            rows += [] if n is None else [n]
            rows += [] if self._moves(self.n.W[list(along)] @ u, rest) else along
        if not rows:
            return u
        missed = least(self.n.laws.D[np.ix_(rows, rows)], self.n.W[rows] @ u)
        return np.asarray(u - self.n.C[rows].T @ missed)

    @staticmethod
    def _moves(slip: Array, rest: float) -> bool:
        """Tell whether a slip is none of rounding, or of what has come to rest."""
        return bool(np.linalg.norm(slip) > (max(rest, 2 * SLOW) if len(slip) > 1 else rest))

    def _set_off(self, u: Array, cases: Sequence[tuple[int, Case]]) -> Array:
        """Return velocities at which what begins to slip along two directions has one."""
        off = {k for k, case in cases if case.slips and len(case.way) == 2 and not case.moving}
        if not off:
            return u
        rows, wanted = list[int](), list[float]()
        for k, case in cases:
            n, along = self.contacts.rows[k]
            held = () if n is None or not case.held else (n,)
            kept = along if k in off or (case.held and case.slip == STICK) else ()
            rows += (*held, *kept)
            wanted += [0.0] * len(held)
            wanted += [4 * SLOW * way for way in (case.way if k in off else (0.0,) * len(kept))]
        missed = np.array(wanted) - self.n.W[rows] @ u
        return np.asarray(u + self.n.C[rows].T @ least(self.n.laws.D[np.ix_(rows, rows)], missed))

    def _options(self, some: Sequence[int], v: Array, rest: float, broke: dict[int, Array]) -> list[tuple[Case, ...]]:
        found = []
        for k in some:
            n, along = self.contacts.rows[k]
            held = self.n.laws.slips(k)
            slip = v[list(along)]
            if k in broke and len(along) == 1:
                held = (Case(True, SLIP, tuple(broke[k].tolist()), True),)
            elif k in broke:
                held = tuple(one for one in held if one.slips)
            elif self._moves(slip, rest) and held[0].slip:
                held = (Case(True, SLIP, tuple((slip / np.linalg.norm(slip)).tolist()), True),)
            if n is not None:  # what nothing moves at first order, as a pendulum that hangs still, presses nothing
                held = (*held, FREE) if self.n.laws.D[n, n] > 0.0 else (FREE,)
            found.append(held)
        return found

    def _mode(
        self, resting: Sequence[int], v: Array, rest: float, broke: dict[int, Array], lifting: Collection[int] = ()
    ) -> list[tuple[int, Case]]:
        """Return what contacts at rest do from now on; `lifting` are those whose force passes zero, which open.

        There the force is zero, and rounding would tell whether it opens: it does, unless others do not let it.

        Raises:
            ArithmeticError: no motion keeps the laws, or several do.
        """
        if not resting:
            return []
        some, rows = part(self.n.laws, resting)
        options = self._options(resting, v, rest, broke)
        opening = [(OPENS,) if k in lifting else held for k, held in zip(resting, options, strict=True)]
        none, d = np.zeros(len(rows)), self.n.drift[rows]
        found = list(some.ways(d, opening, none[: len(resting)], none))
        found = found or list(some.ways(d, options, none[: len(resting)], none) if lifting else ())
        names = ", ".join(map(self.contacts.name, resting))
        if not found:
            raise ArithmeticError(f"contact {names}: no force keeps the laws of contact and friction (Painlevé)")
        found = self._held_by_static(found, some)
        found.sort(key=lambda one: -sum(case.held for case in one[0]))
        motions = [self.n.C[rows].T @ forces for _, forces in found]
        size = 1e-7 * (1.0 + float(np.abs(motions[0]).max(initial=0.0)))
        differ = any(np.abs(one - motions[0]).max(initial=0.0) > size for one in motions[1:])
        if differ and not self._shared(some, found):
            raise ArithmeticError(
                f"contact {names}: {len(found)} motions keep the laws of contact and friction (Painlevé)"
            )
        if differ:  # of several motions that of least forces
            found.sort(key=lambda one: (-sum(case.held for case in one[0]), float(one[1] @ one[1])))
        if broke:  # at the edge of its cone what follows may stick or slip: it slips
            found.sort(key=lambda one: -sum(case.slips for case in one[0]))
        cases, forces = found[0]
        xi, kept = some.D @ forces + self.n.drift[rows], list[tuple[int, Case]]()
        for k, n, case in zip(resting, some.normals, cases, strict=True):
            if case.held:
                kept.append((k, case))
            elif case == OPENS:
                kept.append((k, LIFTED))
            elif n is not None and xi[n] <= CLOSE * (1.0 + float(np.abs(self.n.drift[rows]).max())):
                kept.append((k, CARRIED))
        return kept

    @staticmethod
    def _shared(some: Laws, found: Sequence[Solution]) -> bool:
        """Tell whether contacts hold the same, of all that some motion holds: their forces are not unique then.

        How they share them tells friction, and the least size is taken.
        """
        held = [any(cases[k].held for cases, _ in found) for k in range(len(some.normals))]
        rows = [n for n, one in zip(some.normals, held, strict=True) if n is not None and one]
        values = np.linalg.eigvalsh(some.D[np.ix_(rows, rows)]) if rows else np.ones(1)
        return bool(values[0] < CLOSE * values[-1])

    @staticmethod
    def _held_by_static(found: list[Solution], some: Laws) -> list[Solution]:
        """Return solutions without those in which something slips that static friction holds in another one."""
        higher = np.flatnonzero(some.static > some.friction)
        stuck = {k for k in higher.tolist() for cases, _ in found if cases[k].slip == "stick"}
        return [one for one in found if all(not one[0][k].held or one[0][k].slip == STICK for k in stuck)]


def settled(system: StateEquations, t: float, x: Array, events: Sequence[tuple[int, str]]) -> Array:
    """Return the state behind events of contacts: which, and what each does.

    Raises:
        ArithmeticError: no motion keeps the laws, or several do.
    """
    contacts = system.contacts
    assert contacts is not None, "there are contacts"
    nq, nv = system.nq, system.nv

    def numbers(x: Array) -> Numbers:
        return contacts.numbers(system.evaluate("contacts", t, x), nv)

    found, x, passes = numbers(x), x.copy(), set[int]()
    for k in (k for k, what in events if what == STRIKES or (what == STOPS and k in contacts.always)):
        mode = contacts.mode(x, k)
        if tuple(mode) == PASSED or found.gaps[k] > NEAR / 2:
            mode[:] = FREE.numbers
        elif not found.able[k]:
            mode[:] = PASSED
        else:
            continue
        passes.add(k)
    if len(passes) == len(events):
        return x
    struck = {k for k, what in events if what == STRIKES} - passes
    leaving = {k: what for k, what in events if what != STRIKES and k not in passes}
    forces = system.evaluate("contact_forces", t, x) if leaving else np.zeros(0)
    broke = {
        k: -forces[along] / np.linalg.norm(forces[along])
        for k, what in leaving.items()
        if what == BREAKS and (along := list(contacts.rows[k][1]))
    }
    held = sorted({*contacts.closed(x), *struck})
    normals = {k: n for k in held if (n := contacts.rows[k][0]) is not None}
    rows = list(normals.values())
    D = found.laws.D[np.ix_(rows, rows)]
    step = -found.C[rows].T @ least(D, contacts.heights(found, list(normals)))
    x[:nq] += system.calls["moved"](x[:nq], np.append(step, x[nq + nv : nq + system.nu]))
    flat = max(FLAT_OF_LOOPS if system.closed else FLAT, ROUNDINGS * _rounding(system, t, x, found, list(normals)))
    behind = Settling(contacts, numbers(x), numbers, t, nq, nv, flat).behind(x, struck, leaving, broke)
    if system.scene.prescribed_velocities:  # what moves as it is told takes and gives energy at an impact, too
        before, after = (float(np.sum(system.evaluate("kinetic", t, y))) for y in (x, behind))
        behind[-1] = x[-1] + after - before
    return behind


def _rounding(system: StateEquations, t: float, x: Array, found: Numbers, some: list[int]) -> float:
    """Return how large gaps that are zero may seem since coordinates are rounded, m; zero close to the origin.

    Raises:
        ArithmeticError: more than what touches is told by.
    """
    contacts, q = system.contacts, np.abs(x[: system.nq])
    assert contacts is not None, "there are contacts"
    if not some or np.abs(found.W).max() * q.max(initial=0.0) < FAR:
        return 0.0
    beside = np.tile(x, (system.nq + 1, 1))
    beside[1:, : system.nq] += np.diag(ROUNDED * q)
    gaps = system.evaluate("contacts", np.full(len(beside), t), beside)[:, some]
    off = np.abs(gaps[1:] - gaps[0]).sum(axis=0)
    off[[k in contacts.always for k in some]] = 0.0
    if off.max() > TOUCHES:
        k = int(off.argmax())
        name, unit = contacts.name(some[k]), contacts.units[some[k]]
        told = f"the gap of {name} is rounded to {off[k]:.1g} {unit} there, and {TOUCHES:g} {unit} tells what touches"
        raise ArithmeticError(f"{told}; put the origin of the scene near its contacts")
    return float(off.max())


def impact_beside(
    system: StateEquations, t: float, x: Array, struck: Collection[int]
) -> Callable[[StateEquations, Array], Array]:
    """Return what gives velocities behind an impact, shape (nv,), where contacts do the same beside it.

    It takes the system at values beside its own, and states, shape (nx,).
    """
    contacts, nq, nv = system.contacts, system.nq, system.nv
    assert contacts is not None, "something strikes"
    touching = [k for k in sorted({*contacts.closed(x), *struck, *contacts.always}) if contacts.rows[k][0] is not None]
    by_poisson, cases = [contacts.laws[k] == "poisson" for k in touching], list[tuple[Case, ...]]()

    def behind(there: StateEquations, y: Array, keep: bool = True) -> Array:
        found, u = contacts.numbers(there.evaluate("contacts", t, y), nv), y[nq : nq + nv]
        some, rows = part(found.laws, touching)
        return np.asarray(u + found.C[rows].T @ some.impact(found.W[rows] @ u, by_poisson, cases, keep))

    behind(system, x, keep=False)
    return behind


def held(system: StateEquations, t: float, x: Array, struck: Sequence[int] = ()) -> Array:
    """Return a state next to one, with what is closed closed and at rest, and the gaps of what strikes zero."""
    contacts, nq, nv, nu = system.contacts, system.nq, system.nv, system.nu
    assert contacts is not None, "there are contacts"
    x = x.copy()
    closed = [k for k in range(len(contacts.touches)) if contacts.mode(x, k)[0]]
    touching = {k: n for k in sorted({*closed, *struck}) if (n := contacts.rows[k][0]) is not None}
    resting = [n for k in closed if (n := contacts.rows[k][0]) is not None]
    resting += [row for k in closed if contacts.mode(x, k)[1] for row in contacts.rows[k][1]]
    for _ in range(STEPS):
        found, rows = contacts.numbers(system.evaluate("contacts", t, x), nv), list(touching.values())
        step = -found.C[rows].T @ least(found.laws.D[np.ix_(rows, rows)], contacts.heights(found, list(touching)))
        x[:nq] += system.calls["moved"](x[:nq], np.append(step, np.zeros(nu - nv)))
    found = contacts.numbers(system.evaluate("contacts", t, x), nv)
    u = x[nq : nq + nv]
    u -= found.C[resting].T @ least(found.laws.D[np.ix_(resting, resting)], found.W[resting] @ u)
    return x


STEPS = 3
"""Of Newton's method, from next to a state."""


def begun(system: StateEquations, x: Array) -> Array:
    """Return the state at the start of a run: what touches strikes there, or rests.

    Raises:
        SimulateError: a contact begins inside its plane.
    """
    if system.contacts is None:
        return x
    contacts = system.contacts
    with np.errstate(all="ignore"):  # words say where there is no value
        found, x = contacts.numbers(system.evaluate("contacts", 0.0, x), system.nv), x.copy()
    gaps = found.gaps
    for k, (n, along) in enumerate(contacts.rows):
        if not np.isfinite(found.W[[*([] if n is None else [n]), *along]]).all():
            told = f"{contacts.name(k)} has no direction there, as of a rope whose ends meet; give another start"
            raise SimulateError(f"{system.scene.name}: start: {told}")
    for k in np.flatnonzero(~found.able & (gaps < 0.0)).tolist():
        contacts.mode(x, k)[:] = PASSED
    inside = np.flatnonzero(found.able & (gaps < -NEAR)).tolist()
    if inside:
        name, unit = contacts.name(inside[0]), contacts.units[inside[0]]
        told = f"contact {name} begins {-gaps[inside[0]]:.3g} {unit} inside its plane; start where it touches, or above"
        if contacts.kinds[inside[0]] == "joint_stop":
            told = f"stop {name} is passed by {-gaps[inside[0]]:.3g} {unit}; start the joint within its limits"
        if inside[0] in contacts.always:
            told = f"{name} moves the other way, {gaps[inside[0]]:.3g} {unit}/s; start it at 0 or above"
        raise SimulateError(f"{system.scene.name}: start: {told}")
    touching = [(k, STRIKES) for k in np.flatnonzero(found.able & (gaps <= NEAR)).tolist()]
    try:
        return settled(system, 0.0, x, touching) if touching else x
    except ArithmeticError as fault:
        raise SimulateError(f"{system.scene.name}: start: {fault}") from fault
