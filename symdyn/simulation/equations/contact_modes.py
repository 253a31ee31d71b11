"""Contacts in runs: their modes, and where one strikes, lifts off, slips or sticks.

    guard       open    g                    it strikes
                closed  λn                   it lifts off
                sticks  μs² λn² - λt²        it breaks away
                slips   z s                  it comes to rest

The mode of every contact is part of the state, and all formulas depend on it: one compiled system serves all modes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
from symdyn.simulation.equations.complementarity import Case, Laws
from symdyn.simulation.equations.events import EventKind

if TYPE_CHECKING:
    from symdyn.simulation.equations.system import StateEquations

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
        before, after: rates of its gap, m/s or rad/s.
        impulse: normal and tangential, N s or N m s.
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
    impulse: tuple[float, float] = (0.0, 0.0)
    lost: float = 0.0
    mode: tuple[str, ...] = ()
    rest: float | None = None
    unit: str = "m"

    @property
    def words(self) -> str:
        """It in one line, such as "floor strikes at t = 0.45 s, -4.43 to 3.54 m/s, 3.53 J lost"."""
        found = f"{self.contact} {self.what} at t = {self.t!r} s"
        if self.what == STRIKES and self.impulse[0]:
            before, after = (0.0 if abs(rate) < 1e-9 * abs(self.before) else rate for rate in (self.before, self.after))
            found += f", {before:.6g} to {after:.6g} {self.unit}/s, {self.lost:.3g} J lost"
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
        kinds: "point", "gap", "joint_stop", "joint_friction" and so on.
        units: of gaps, "m" or "rad".
        laws: "poisson" or "newton" of each.
        place: where their modes begin in a state.
        told: every event of a run, in order.
        declared: the scene as its writer has it, without modes; None before a run begins.
    """

    touches: tuple[tuple[str, bool, bool], ...]
    kinds: tuple[str, ...]
    units: tuple[str, ...]
    laws: tuple[str, ...]
    place: int
    told: list[Impact] = field(default_factory=list)
    declared: Scene | None = None

    @classmethod
    def of(cls, c: ContactEquations, place: int) -> Contacts:
        """Return those of some equations."""
        kinds, units = tuple(one.law.kind for one in c.touches), tuple(one.unit for one in c.touches)
        touches = tuple((one.law.name, bool(one.normal), bool(one.tangent)) for one in c.touches)
        return cls(touches, kinds, units, tuple(one.law.law for one in c.touches), place)

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


COLUMNS = ("gap", "normal", "friction", "mode")
"""What the columns of a contact begin with."""


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
