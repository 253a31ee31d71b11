"""Contacts in runs: their modes, and where one strikes, lifts off, slips or sticks.

    guard       open    g                    it strikes
                closed  λn                   it lifts off
                sticks  μs² λn² - |λt|²      it breaks away
                slips   z s                  it comes to rest; of two directions |s|² - SLOW²

What touches while nothing presses there, since others carry all or it has just lifted off, is open within NEAR of zero,
where rounding tells the sign of g. It leaves that where NEAR² - g² passes zero. What is not active passes its plane,
and comes back where -g passes zero.

The mode of every contact is part of the state, and all formulas depend on it: one compiled system serves all modes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.dynamics import Function, Workspace
from symdyn.dynamics.outputs import CLOSED_AT_ONCE, MODE, ContactEquations, Touch, unilaterals_of
from symdyn.errors import SimulateError, suggestion
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Expr, Op, substitute
from symdyn.scene import Quantity, Scene
from symdyn.simulation.equations.compiled_routines import function_of
from symdyn.simulation.equations.complementarity import Case, Laws
from symdyn.simulation.equations.events import EventKind

if TYPE_CHECKING:
    from symdyn.simulation.equations.system import StateEquations

STRIKES, LIFTS, BREAKS, STOPS = "strikes", "lifts off", "slips", "sticks"

OF_ROPES = {STRIKES: "becomes taut", LIFTS: "goes slack"}
OF_FREEWHEELS = {STRIKES: "locks", STOPS: "locks", LIFTS: "runs free"}
"""What ropes, and what joints that move one way, are told to do."""

TOLD = {"slack": OF_ROPES, "one_way": OF_FREEWHEELS}
"""What kinds are told to do in words of their own."""

SLOW = 1e-9
"""A slip along two directions, m/s, that has come to rest."""

ONE_WAY = "one_way"
"""The kind of what is always at its plane: its law is one of rates."""

PASSED = (0.0, 0.0, 0.0, 1.0)
"""The mode of what has passed its plane, where it was not active."""

NEAR = 1e-9
"""A gap at the start, or where nothing presses, m, that is none."""


def contact_parts(
    w: Workspace, c: ContactEquations | None, place: Mapping[Expr, Expr]
) -> tuple[Contacts | None, list[EventKind], list[Function]]:
    """Return contacts, their events, and what these are settled with; `place` tells what forces and inputs are."""
    if c is None:
        return None, [], []
    still = [x.law.name for x in c.touches if x.normal and all(entry.is_zero for entry in x.normal.entries)]
    if still:
        told = "nothing moves what touches towards its plane or away from it; name another body or plane"
        raise SimulateError(f"{w.scene.name}: contacts.{still[0]}: its gap never changes: {told}")
    kinds = contact_kinds(c)
    guards = substitute([kind.guard for kind in kinds], place)
    numbers = [replace(one, entries=tuple(substitute(one.entries, place))) for one in contact_numbers(w, c)]
    first = len(w.state.q) + w.state.n + len(w.states) - len(MODE) * len(c.touches)
    placed = [replace(kind, guard=guard) for kind, guard in zip(kinds, guards, strict=True)]
    return Contacts.of(c, first), placed, numbers


def contact_kinds(c: ContactEquations) -> list[EventKind]:
    """Return the events of contacts; what has no meaning in a mode is 1."""
    found = []
    for k, (touch, (normal, along)) in enumerate(zip(c.touches, c.parts(c.forces), strict=True)):
        closed, sticks, slip, yields = touch.mode
        graph = closed.graph
        one = graph.one
        guards, largest = [], touch.static
        if normal is not None:
            gap, what = c.distance(touch), STOPS if touch.law.at_rates else STRIKES
            within = (one - closed) * sticks
            leaves = graph.constant(Fraction(NEAR)) - gap * gap / Fraction(NEAR)
            above = gap if touch.active is None else gap * (one - 2 * yields)
            strikes = (one - within) * above + within * leaves + closed
            guards = [(what, strikes), (LIFTS, closed * normal + (one - closed))]
            largest = largest * normal
        if along:
            cone = largest * largest - graph.total(part * part for part in along)
            held = closed * sticks
            guards.append((BREAKS, held * cone + (one - held)))
            moves, slips = slip * slip, c.slips(touch)
            fast = slip * slips[0] if len(slips) == 1 else graph.total(s * s for s in slips) - Fraction(SLOW) ** 2
            guards.append((STOPS, moves * fast + (one - moves)))
        found += [EventKind(guard, -1, contact=(k, what)) for what, guard in guards]
    return found


def contact_numbers(w: Workspace, c: ContactEquations) -> list[Function]:
    """Return what an event is settled with, as functions."""
    flat = [*map(c.distance, c.touches), *(x for row in c.rows for x in row.entries)]
    flat += [*(x for column in c.columns for x in column), *c.drift]
    flat += [x for touch in c.touches for x in (touch.friction, touch.static, touch.restitution, _able(touch))]
    forces = function_of(w, "contact_forces", c.forces)
    return [function_of(w, "contacts", flat), forces, function_of(w, "moved", w.state.rates, ("q", "qd"))]


def _able(touch: Touch) -> Expr:
    """Return 1 where one is closed or may strike, else 0."""
    graph = touch.gap.graph
    return graph.one if touch.active is None else graph.function(Op.SELECT, touch.active, graph.one, touch.mode[0])


@dataclass(frozen=True)
class Impact:
    """What an event told about a contact.

    Attributes:
        t: s.
        contact: its name.
        what: "strikes", "lifts off", "slips" or "sticks"; of a rope "becomes taut", "goes slack".
        before, after: rates of its gap, m/s or rad/s.
        impulse: normal, and tangential of each direction, N s or N m s.
        lost: kinetic energy, J, of all that struck at this time.
        mode: of all contacts then, in words.
        rest: when flights that become shorter and shorter have ended, s; None of other events.
        unit: of its gap, "m" or "rad".
    """

    t: float
    contact: str
    what: str
    before: float = 0.0
    after: float = 0.0
    impulse: tuple[float, ...] = (0.0, 0.0)
    lost: float = 0.0
    mode: tuple[str, ...] = ()
    rest: float | None = None
    unit: str = "m"

    @property
    def words(self) -> str:
        """It in one line, such as "floor strikes at t = 0.45 s, -4.43 to 3.54 m/s, 3.53 J lost"."""
        found = f"{self.contact} {self.what} at t = {self.t!r} s"
        if self.what in (STRIKES, OF_ROPES[STRIKES], OF_FREEWHEELS[STRIKES]) and self.impulse[0]:
            before, after = (0.0 if abs(rate) < 1e-9 * abs(self.before) else rate for rate in (self.before, self.after))
            found += f", {before:.6g} to {after:.6g} {self.unit}/s, {self.lost:.3g} J lost"
        return found if self.rest is None else f"{found}; it rests from t = {self.rest:.9g} s on"


@dataclass(frozen=True)
class Numbers:
    """Contacts of a system at a state, of laws of rates these for gaps; `able` tells which are closed, or active."""

    gaps: Array
    able: npt.NDArray[np.bool_]
    W: Array
    C: Array
    drift: Array
    laws: Laws


@dataclass(frozen=True)
class Contacts:
    """The contacts of a system.

    Attributes:
        touches: names, whether there is an n, and how many t there are.
        kinds: "point", "gap", "joint_stop", "joint_friction" and so on.
        units: of gaps, "m" or "rad".
        laws: "poisson" or "newton" of each.
        place: where their modes begin in a state.
        told: every event of a run, in order.
        pushed: forces of all contacts by time, shape (m,), of a run by steps; else the mode tells them.
        declared: the scene as its writer has it, without modes; None before a run begins.
    """

    touches: tuple[tuple[str, bool, int], ...]
    kinds: tuple[str, ...]
    units: tuple[str, ...]
    laws: tuple[str, ...]
    place: int
    told: list[Impact] = field(default_factory=list)
    pushed: dict[float, Array] = field(default_factory=dict)
    declared: Scene | None = None

    @classmethod
    def of(cls, c: ContactEquations, place: int) -> Contacts:
        """Return those of some equations."""
        kinds, units = tuple(one.law.kind for one in c.touches), tuple(one.unit for one in c.touches)
        touches = tuple((one.law.name, bool(one.normal), len(one.tangents)) for one in c.touches)
        return cls(touches, kinds, units, tuple(one.law.law for one in c.touches), place)

    @property
    def rows(self) -> tuple[tuple[int | None, tuple[int, ...]], ...]:
        """The row of n of each, None where there is none, and those of its t."""
        found, at = list[tuple[int | None, tuple[int, ...]]](), 0
        for _, touches, rough in self.touches:
            found.append((at if touches else None, tuple(range(at + touches, at + touches + rough))))
            at += touches + rough
        return tuple(found)

    def numbers(self, flat: Array, nv: int) -> Numbers:
        """Return what the compiled function tells at a state."""
        k, m = len(self.touches), sum(touches + rough for _, touches, rough in self.touches)
        gaps, rest = flat[:k], flat[k + 2 * m * nv :]
        W, C = flat[k : k + 2 * m * nv].reshape(2, m, nv)
        drift, (friction, static, e, able) = rest[:m], rest[m:].reshape(k, 4).T
        normals, tangents = zip(*self.rows, strict=True)
        return Numbers(gaps, able > 0.0, W, C, drift, Laws(W @ C.T, normals, tangents, friction, static, e))

    @property
    def always(self) -> set[int]:
        """Which are at their planes wherever they are: laws of rates."""
        return {k for k, kind in enumerate(self.kinds) if kind == ONE_WAY}

    def forces(self, system: StateEquations, t: Array, x: Array) -> Array:
        """Return the forces of all contacts over a run, shape (N, m)."""
        found = system.evaluate("contact_forces", t, x).reshape(len(t), -1)
        return np.array([self.pushed.get(one, row) for one, row in zip(t.tolist(), found, strict=True)])

    def heights(self, n: Numbers, some: Sequence[int]) -> Array:
        """Return gaps of some contacts, zero of laws of rates."""
        return np.array([0.0 if k in self.always else n.gaps[k] for k in some])

    def name(self, k: int) -> str:
        return self.touches[k][0]

    def refuse_many(self, touching: Sequence[int]) -> None:
        """Raise ArithmeticError where more contacts touch at once than runs and generated code close."""
        some = [self.name(k) for k in touching if self.touches[k][1] and k not in self.always]
        if len(some) > CLOSED_AT_ONCE:
            told = f"{len(some)} contacts are closed at once, {', '.join(some)}; {CLOSED_AT_ONCE} can be"
            raise ArithmeticError(f"{told}: leave out what others carry, such as all but the corners of a foot")

    def closed(self, x: Array) -> list[int]:
        """Return which contacts are closed, or touch while nothing presses there."""
        return [k for k in range(len(self.touches)) if self.mode(x, k)[:2].any()]

    def mode(self, x: Array, k: int) -> Array:
        """Return the numbers of the mode of one, shape (4,) or (N, 4) of a run."""
        return x[..., self.place + len(MODE) * k : self.place + len(MODE) * (k + 1)]

    def words(self, x: Array) -> tuple[str, ...]:
        """Return the mode of every contact in words."""
        found = []
        for k, (_, _, directions) in enumerate(self.touches):
            closed, sticks, slip, yields = self.mode(x, k)
            slips = "closed" if not slip else "slips" if directions > 1 else f"slips {'+' if slip > 0 else '-'}"
            rests = "sticks" if closed and directions else "closed"
            found.append(rests if sticks and yields else slips if closed else "open")
        return tuple(found)

    def with_mode(self, x: Array, cases: Sequence[tuple[int, Case]]) -> Array:
        """Return a state in a mode; contacts that are not named are open."""
        x = x.copy()
        x[self.place : self.place + len(MODE) * len(self.touches)] = 0.0
        for k, case in cases:
            self.mode(x, k)[:] = case.numbers
        return x


FRICTIONS = ("friction_along", "friction_across")
"""What the columns of friction along two directions begin with."""

COLUMNS = ("gap", "normal", "friction", *FRICTIONS, "mode")
"""What the columns of a contact begin with."""


def column_names(scene: Scene) -> tuple[str, ...]:
    """Return the columns of contacts that events may name: all but modes, whose changes are events of their own."""
    return tuple(f"{word}_{one.name}" for one in unilaterals_of(scene) for word in COLUMNS[:-1])


def named_columns(c: ContactEquations | None, events: Sequence[Quantity]) -> dict[Expr, Expr]:
    """Return what stands for the columns of contacts in formulas of events.

    Raises:
        SimulateError: one is named that there is not, as the friction of what is smooth.
    """
    if c is None:
        return {}
    graph, found = c.free[0].graph, dict[str, Expr]()
    for touch, (normal, along) in zip(c.touches, c.parts(c.forces), strict=True):
        name, pushed = touch.law.name, (*(() if normal is None else (normal,)), *along)
        found |= {} if normal is None or touch.law.at_rates else {f"gap_{name}": touch.gap}
        found |= zip(column_words(name, normal is not None, len(along)), pushed, strict=True)
    asked = {f"{word}_{one.law.name}" for one in c.touches for word in COLUMNS} - {*found}
    for name in (name for one in events for name in one.symbols if name in asked):
        raise SimulateError(f"event: {name} is no column of this scene; {suggestion(name, found)}")
    return {graph.symbol(name): one for name, one in found.items()}


def check_names(scene: Scene) -> None:
    """Report contacts of one name, and columns of contacts that are called as something else.

    Raises:
        SimulateError: a name stands for two.
    """
    signals = {*scene.coordinates, *scene.velocities, *(one.name for one in (*scene.given, *scene.outputs))}
    known = set[str]()
    for one in scene.unilaterals:
        if one.name in known:
            raise SimulateError(
                f"{scene.name}: contacts: {one.name} is the name of a stop or a friction, too; rename it"
            )
        known.add(one.name)
        if both := signals.intersection(f"{word}_{one.name}" for word in COLUMNS):
            told = f"{min(both)} is the name of a column of contact {one.name}, too; rename it or the contact"
            raise SimulateError(f"{scene.name}: {told}")


def column_words(name: str, touches: bool, along: int) -> tuple[str, ...]:
    """Return what the columns of the forces of a contact are called, in the order of its rows."""
    words = FRICTIONS[:along] if along > 1 else ("friction",) * along
    return tuple(f"{word}_{name}" for word in (*(("normal",) if touches else ()), *words))


def change_of(before: Sequence[float], then: Sequence[float], strikes: bool, kind: str) -> str:
    """Return what a contact is told to do between two modes, "" of nothing; of each closed, sticks and slip."""
    what = STRIKES if strikes else LIFTS if before[0] > then[0] else ""
    what = what or (BREAKS if before[1] and then[2] else STOPS if then[1] > before[1] else "")
    return TOLD.get(kind, {}).get(what, what)


def columns_of(contacts: Contacts, system: StateEquations, t: Array, x: Array) -> dict[str, Array]:
    """Return gap, forces and mode of every contact over a run, each of shape (N,).

    A mode is 0 where it is open, 1 where it sticks or nothing rubs, 2 where it slips, -2 where it slips backwards.
    """
    flat = system.evaluate("contacts", t, x)
    forces = contacts.forces(system, t, x)
    found = dict[str, Array]()
    for k, (row, tangents) in enumerate(contacts.rows):
        name = contacts.name(k)
        closed, sticks, slip, yields = contacts.mode(x, k).T
        found |= {} if row is None or contacts.kinds[k] == ONE_WAY else {f"gap_{name}": flat[:, k]}
        rows = (*(() if row is None else (row,)), *tangents)
        words = column_words(name, row is not None, len(tangents))
        found |= {word: forces[:, one] for word, one in zip(words, rows, strict=True)}
        found[f"mode_{name}"] = np.where(slip == 0.0, np.maximum(closed, sticks * (yields > 0)), 2.0 * slip)
    return found


def laws_missed(contacts: Contacts, system: StateEquations, t: Array, x: Array) -> dict[str, float]:
    """Return by how much a run misses the laws of contact and friction, for every contact with a gap.

    A force misses them that pulls, that pushes while the contact is open, or that is beyond its cone.
    """
    flat = system.evaluate("contacts", t, x)
    forces = contacts.forces(system, t, x)
    laws = flat[:, -4 * len(contacts.touches) :].reshape(len(t), -1, 4)
    largest, found = float(np.abs(forces).max(initial=1e-300)), dict[str, float]()
    for k, (row, tangents) in enumerate(contacts.rows):
        if row is None:
            continue
        gap, normal = flat[:, k], forces[:, row]
        beyond = np.linalg.norm(forces[:, list(tangents)], axis=1) - laws[:, k, :2].max(axis=1) * normal
        apart = (gap > NEAR) & (not contacts.pushed)  # behind a step in which it pushed it may be open
        wrong = np.maximum(np.maximum(-normal, beyond), np.where(apart, np.abs(normal), 0.0))
        passed = np.all(contacts.mode(x, k) == PASSED, axis=1)
        found[f"penetration {contacts.name(k)}"] = max(0.0, float(-gap[~passed].min(initial=0.0)))
        found[f"contact_laws {contacts.name(k)}"] = max(0.0, float(wrong.max(initial=0.0))) / largest
    return found
