"""Contacts in runs: where one strikes, lifts off, slips or sticks, and what follows.

    guard       open    g                    it strikes
                closed  λn                   it lifts off
                sticks  μs² λn² - λt²        it breaks away
                slips   z s                  it comes to rest

The mode of every contact is part of the state. What else is a formula of it: one compiled system serves all modes. At
an event positions return to g = 0, an impact changes velocities where a gap closes, what touches at rest is set to
rest, and the mode is what keeps the laws of all contacts that touch. Flights of a ball that grow shorter without end
are passed in their limit: it touches from where the rest of them takes no time.

Reference: Brogliato, Nonsmooth Mechanics (2016), chapters 1 and 5.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import Function, Workspace
from symdyn.dynamics.outputs import MODE, ContactEquations, Touch
from symdyn.errors import SimulateError
from symdyn.graph import Expr, substitute
from symdyn.scene import Scene
from symdyn.simulation.equations.compiled_routines import function_of
from symdyn.simulation.equations.complementarity import CLOSE, FREE, Case, Laws
from symdyn.simulation.equations.events import EventKind

if TYPE_CHECKING:
    from symdyn.simulation.equations.system import StateEquations

TOUCHES, RESTS = 1e-10, 1e-9
"""A gap, in m, and a velocity, in m/s over the fastest one or 1, that are none."""

STARTS = 1e-9
"""A gap at the start, m, that is none."""

FLAT = 1e-12
"""How high what bounces has to rise, m, for another flight."""

STRIKES, LIFTS, BREAKS, STOPS = "strikes", "lifts off", "slips", "sticks"


def contact_parts(
    w: Workspace, c: ContactEquations | None, place: Mapping[Expr, Expr]
) -> tuple[Contacts | None, list[EventKind], list[Function]]:
    """Return contacts, their events, and what these are settled with; `place` tells what forces and inputs are."""
    if c is None:
        return None, [], []
    kinds = contact_kinds(c)
    guards = substitute([kind.guard for kind in kinds], place)
    numbers = [replace(one, entries=tuple(substitute(one.entries, place))) for one in contact_numbers(w, c)]
    first = len(w.state.q) + w.state.n + len(w.states) - len(MODE) * len(c.touches)
    placed = [replace(kind, guard=guard) for kind, guard in zip(kinds, guards, strict=True)]
    return Contacts.of(c, first), placed, numbers


def contact_kinds(c: ContactEquations) -> list[EventKind]:
    """Return the events of contacts; what has no meaning in a mode is 1."""
    found = []
    for k, (touch, (normal, tangent)) in enumerate(zip(c.touches, c.parts(c.forces), strict=True)):
        closed, sticks, slip = touch.mode
        one = closed.graph.one
        guards, largest = [], touch.static
        if normal is not None:
            guards = [(STRIKES, touch.gap + closed), (LIFTS, closed * normal + (one - closed))]
            largest = largest * normal
        if tangent is not None:
            cone = largest * largest - tangent * tangent
            held = closed * sticks
            guards.append((BREAKS, held * cone + (one - held)))
            moves = slip * slip
            guards.append((STOPS, moves * slip * _slip(touch, c) + (one - moves)))
        found += [EventKind(guard, -1, contact=(k, what)) for what, guard in guards]
    return found


def _slip(touch: Touch, c: ContactEquations) -> Expr:
    assert touch.tangent is not None, "friction acts along it"
    graph = touch.gap.graph
    return graph.total(t * u for t, u in zip(touch.tangent.entries, c.velocities, strict=True))


def contact_numbers(w: Workspace, c: ContactEquations) -> list[Function]:
    """Return what an event is settled with, as functions."""
    flat = [*(touch.gap for touch in c.touches), *(x for row in c.rows for x in row.entries)]
    flat += [*(x for column in c.columns for x in column), *c.drift]
    flat += [x for touch in c.touches for x in (touch.friction, touch.static, touch.restitution)]
    forces = function_of(w, "contact_forces", c.forces)
    return [function_of(w, "contacts", flat), forces, function_of(w, "moved", w.state.rates, ("q", "qd"))]


@dataclass(frozen=True)
class Impact:
    """What an event told about a contact.

    Attributes:
        t: s.
        contact: its name.
        what: "strikes", "lifts off", "slips" or "sticks".
        before, after: rates of its gap, m/s.
        impulse: normal and tangential, N s.
        lost: kinetic energy, J, of all that struck at this time.
        mode: of all contacts then, in words.
        rest: when flights that become shorter and shorter have ended, s; None of other events.
    """

    t: float
    contact: str
    what: str
    before: float = 0.0
    after: float = 0.0
    impulse: tuple[float, float] = (0.0, 0.0)
    lost: float = 0.0
    mode: tuple[str, ...] = ()
    rest: float | None = None

    @property
    def words(self) -> str:
        """It in one line, such as "floor strikes at t = 0.45 s, -4.43 to 3.54 m/s, 3.53 J lost"."""
        found = f"{self.contact} {self.what} at t = {self.t!r} s"
        if self.impulse[0]:
            found += f", {self.before:.6g} to {self.after:.6g} m/s, {self.lost:.3g} J lost"
        return found if self.rest is None else f"{found}; it rests from t = {self.rest:.9g} s on"


@dataclass(frozen=True)
class Numbers:
    """Contacts of a system at a state."""

    gaps: Array
    W: Array
    C: Array
    drift: Array
    laws: Laws


@dataclass(frozen=True)
class Contacts:
    """The contacts of a system.

    Attributes:
        touches: names, and whether there are an n and a t.
        laws: "poisson" or "newton" of each.
        place: where their modes begin in a state.
        told: every event of a run, in order.
        declared: the scene as its writer has it, without modes; None before a run begins.
    """

    touches: tuple[tuple[str, bool, bool], ...]
    laws: tuple[str, ...]
    place: int
    told: list[Impact] = field(default_factory=list)
    declared: Scene | None = None

    @classmethod
    def of(cls, c: ContactEquations, place: int) -> Contacts:
        """Return those of some equations."""
        touches = tuple((one.law.name, bool(one.normal), bool(one.tangent)) for one in c.touches)
        return cls(touches, tuple(one.law.law for one in c.touches), place)

    @property
    def rows(self) -> tuple[tuple[int | None, int | None], ...]:
        """The rows of n and t of each, None where there is none."""
        found, at = list[tuple[int | None, int | None]](), 0
        for _, touches, rough in self.touches:
            found.append((at if touches else None, at + touches if rough else None))
            at += touches + rough
        return tuple(found)

    def numbers(self, flat: Array, nv: int) -> Numbers:
        """Return what the compiled function tells at a state."""
        k, m = len(self.touches), sum(touches + rough for _, touches, rough in self.touches)
        gaps, W, C, drift, rest = np.split(flat, np.cumsum([k, m * nv, m * nv, m]))
        W, C = W.reshape(m, nv), C.reshape(m, nv)
        friction, static, e = rest.reshape(k, 3).T
        normals, tangents = zip(*self.rows, strict=True)
        return Numbers(gaps, W, C, drift, Laws(W @ C.T, normals, tangents, friction, static, e))

    def name(self, k: int) -> str:
        """Return the name of one."""
        return self.touches[k][0]

    def closed(self, x: Array) -> list[int]:
        """Return which contacts are closed."""
        return [k for k in range(len(self.touches)) if x[self.place + 3 * k]]

    def words(self, x: Array) -> tuple[str, ...]:
        """Return the mode of every contact in words."""
        found = []
        for k in range(len(self.touches)):
            closed, sticks, slip = x[self.place + 3 * k : self.place + 3 * k + 3]
            slips = f"slips {'+' if slip > 0 else '-'}" if slip else "closed"
            found.append("open" if not closed else "sticks" if sticks else slips)
        return tuple(found)

    def with_mode(self, x: Array, cases: Sequence[tuple[int, Case]]) -> Array:
        """Return a state in a mode; contacts that are not named are open."""
        x = x.copy()
        x[self.place : self.place + 3 * len(self.touches)] = 0.0
        for k, case in cases:
            sticks = case.slip == "stick"
            x[self.place + 3 * k : self.place + 3 * k + 3] = case.held, sticks, 0.0 if sticks else float(case.slip)
        return x


def part(laws: Laws, some: Sequence[int]) -> tuple[Laws, list[int]]:
    """Return some of the contacts, and their rows."""
    rows, normals, tangents = list[int](), list[int | None](), list[int | None]()
    for k in some:
        for places, row in ((normals, laws.normals[k]), (tangents, laws.tangents[k])):
            places.append(None if row is None else len(rows))
            rows += [] if row is None else [row]
    chosen = list(some)
    values = (one[chosen] for one in (laws.friction, laws.static, laws.restitution))
    return Laws(laws.D[np.ix_(rows, rows)], tuple(normals), tuple(tangents), *values), rows


@dataclass(frozen=True)
class Settling:
    """One event: what follows from a state at which contacts strike, lift off, slip or stick.

    Attributes:
        contacts: those of the system.
        n: their numbers, where the positions have returned to g = 0.
        t: s.
        nq, nv: coordinates and velocities in front of a state.
    """

    contacts: Contacts
    n: Numbers
    t: float
    nq: int
    nv: int

    def behind(self, x: Array, struck: Collection[int], leaving: dict[int, str], broke: dict[int, float]) -> Array:
        """Return the state behind it; `struck` are contacts, `leaving` lift off, `broke` slip that way."""
        x, laws, told, was = x.copy(), self.n.laws, self.contacts.told, self.contacts.words(x)
        velocities = slice(self.nq, self.nq + self.nv)
        u = x[velocities]
        rest = RESTS * max(1.0, float(np.abs(u).max(initial=0.0)))
        near = {k for k in range(len(self.n.gaps)) if abs(self.n.gaps[k]) <= TOUCHES}
        touching = sorted({*self.contacts.closed(x), *struck, *near})
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
        flights = {
            k: self._flights(k, float(after[n]), touching, after, rest)
            for k, n in normal.items()
            if k in struck and v[n] < -rest and after[n] > rest and 0 < laws.restitution[k] < 1
        }
        resting = [k for k in touching if self._still(k, after, rest) or flights.get(k) is not None]
        u = self._at_rest(u, resting, rest)
        after = self.n.W @ u
        cases = self._mode(resting, after, rest, broke)
        x[velocities] = u
        x[-1] -= lost
        x = self.contacts.with_mode(x, cases)
        words, size = self.contacts.words(x), CLOSE * float(np.abs(impulses).max(initial=0.0))
        for k in touching:
            n, t = self.contacts.rows[k]
            before, rate = (0.0 if n is None else float(one[n]) for one in (v, after))
            impulse = (0.0 if n is None else float(impulses[n]), 0.0 if t is None else float(impulses[t]))
            if impulse[0] > size or (k in struck and n is not None and before <= rest and self.t > 0.0):
                what = STRIKES
            elif k in leaving:
                what = leaving[k]
            elif was[k] != "open" and words[k] == "open":
                what = LIFTS
            else:
                continue
            name = self.contacts.name(k)
            told.append(Impact(self.t, name, what, before, rate, impulse, lost, words, flights.get(k)))
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
        if falls >= 0 or rate * rate > 2 * FLAT * -falls:
            return None
        return float(self.t + 2 * rate / -falls / (1 - laws.restitution[k]))

    def _at_rest(self, u: Array, resting: Sequence[int], rest: float) -> Array:
        """Return velocities at which gaps that are closed do not change, and what sticks does not slip."""
        rows = []
        for k in resting:
            n, t = self.contacts.rows[k]
            rows += [] if n is None else [n]
            rows += [] if t is None or abs(self.n.W[t] @ u) > rest else [t]
        if not rows:
            return u
        missed = np.linalg.lstsq(self.n.laws.D[np.ix_(rows, rows)], self.n.W[rows] @ u, rcond=1e-12)[0]
        return np.asarray(u - self.n.C[rows].T @ missed)

    def _options(self, some: Sequence[int], v: Array, rest: float, broke: dict[int, float]) -> list[tuple[Case, ...]]:
        found = []
        for k in some:
            n, t = self.contacts.rows[k]
            held = self.n.laws.slips(k)
            if k in broke:
                held = (Case(True, broke[k], True),)
            elif t is not None and abs(v[t]) > rest:
                held = (Case(True, float(np.sign(v[t])), True),)
            found.append(held if n is None else (*held, FREE))
        return found

    def _mode(self, resting: Sequence[int], v: Array, rest: float, broke: dict[int, float]) -> list[tuple[int, Case]]:
        """Return what contacts at rest do from now on.

        Raises:
            ArithmeticError: no motion keeps the laws, or several do.
        """
        if not resting:
            return []
        some, rows = part(self.n.laws, resting)
        options = self._options(resting, v, rest, broke)
        found = list(some.solutions(self.n.drift[rows], options))
        names = ", ".join(map(self.contacts.name, resting))
        if not found:
            raise ArithmeticError(f"contact {names}: no force keeps the laws of contact and friction (Painlevé)")
        motions = [self.n.C[rows].T @ forces for _, forces in found]
        size = 1e-7 * (1.0 + float(np.abs(motions[0]).max(initial=0.0)))
        if any(np.abs(one - motions[0]).max(initial=0.0) > size for one in motions[1:]):
            raise ArithmeticError(
                f"contact {names}: {len(found)} motions keep the laws of contact and friction (Painlevé)"
            )
        return self._independent(resting, some, found[0][0])

    def _independent(self, resting: Sequence[int], some: Laws, cases: Sequence[Case]) -> list[tuple[int, Case]]:
        """Return cases without what others hold already: its friction is not determined, and none is as good as any."""
        kept, found = list[int](), []
        order = [(k, n) for k in range(len(cases)) if (n := some.normals[k]) is not None and cases[k].held]
        order += [(k, t) for k in range(len(cases)) if (t := some.tangents[k]) is not None and cases[k].slip == "stick"]
        dropped = set()
        for k, row in order:
            D = some.D[np.ix_([*kept, row], [*kept, row])]
            values = np.linalg.eigvalsh(D)
            if values[0] > 1e-9 * values[-1]:
                kept.append(row)
            elif row == some.normals[k]:
                name = self.contacts.name(resting[k])
                raise ArithmeticError(f"contact {name} is held by others already; leave one of them out")
            else:
                dropped.add(k)
        for k, case in enumerate(cases):
            if case.held:
                found.append((resting[k], Case(True, 0.0) if k in dropped else case))
        return found


def settled(system: StateEquations, t: float, x: Array, events: Sequence[tuple[int, str]]) -> Array:
    """Return the state behind events of contacts: which, and what each does.

    Raises:
        ArithmeticError: no motion keeps the laws, or several do.
    """
    contacts = system.contacts
    assert contacts is not None, "there are contacts"
    nq, nv = system.nq, system.nv
    struck = {k for k, what in events if what == STRIKES}
    leaving = {k: what for k, what in events if what != STRIKES}
    found = contacts.numbers(system.evaluate("contacts", t, x), nv)
    forces = system.evaluate("contact_forces", t, x)
    broke = {
        k: -float(np.sign(forces[row]))
        for k, what in leaving.items()
        if what == BREAKS and (row := contacts.rows[k][1]) is not None
    }
    held = sorted({*contacts.closed(x), *struck})
    normals = {k: n for k in held if (n := contacts.rows[k][0]) is not None}
    rows = list(normals.values())
    D = found.laws.D[np.ix_(rows, rows)]
    step = -found.C[rows].T @ np.linalg.lstsq(D, found.gaps[list(normals)], rcond=1e-12)[0]
    x = x.copy()
    x[:nq] += system.calls["moved"](x[:nq], np.append(step, x[nq + nv : nq + system.nu]))
    found = contacts.numbers(system.evaluate("contacts", t, x), nv)
    return Settling(contacts, found, t, nq, nv).behind(x, struck, leaving, broke)


def columns_of(contacts: Contacts, system: StateEquations, t: Array, x: Array) -> dict[str, Array]:
    """Return gap, forces and mode of every contact over a run, each of shape (N,).

    A mode is 0 where it is open, 1 where it sticks or nothing rubs, 2 and -2 where it slips.
    """
    flat = system.evaluate("contacts", t, x)
    forces = system.evaluate("contact_forces", t, x).reshape(len(t), -1)
    found = dict[str, Array]()
    for k, (row, tangent) in enumerate(contacts.rows):
        name = contacts.name(k)
        closed, _, slip = x[:, contacts.place + 3 * k : contacts.place + 3 * k + 3].T
        if row is not None:
            found |= {f"gap_{name}": flat[:, k], f"normal_{name}": forces[:, row]}
        if tangent is not None:
            found[f"friction_{name}"] = forces[:, tangent]
        found[f"mode_{name}"] = np.where(slip == 0.0, closed, 2.0 * slip)
    return found


def begun(system: StateEquations, x: Array) -> Array:
    """Return the state at the start of a run: what touches strikes there, or rests.

    Raises:
        SimulateError: a contact begins inside its plane.
    """
    if system.contacts is None:
        return x
    contacts = system.contacts
    gaps = contacts.numbers(system.evaluate("contacts", 0.0, x), system.nv).gaps
    inside = [k for k in range(len(gaps)) if gaps[k] < -STARTS]
    if inside:
        name = contacts.name(inside[0])
        told = f"contact {name} begins {-gaps[inside[0]]:.3g} m inside its plane"
        raise SimulateError(f"{system.scene.name}: start: {told}; start where it touches, or above")
    touching = [(k, STRIKES) for k in range(len(gaps)) if gaps[k] <= STARTS]
    return settled(system, 0.0, x, touching) if touching else x
