"""Phases of a motion with contacts: what is closed, sticks and slips in each, and what strikes where it begins.

A schedule is given, times are found. What a phase asks of its contacts are numbers of the functions of a place, and
bounds; an equation that a phase does not have has none.

                 λn        λt            held            at the passage into it
    open         0         0             g ≥ 0           Λ = 0; struck: n u⁺ = -e n u⁻, Λn ≥ 0, g = 0
    sticks       ≥ 0       in its cone   g, n u, t u     n u⁺ = t u⁺ = 0, Λ in its cone; g = 0 where it was open
    slips        ≥ 0       -z μ λn       g, n u; z s ≥ 0 n u⁺ = 0, Λt = -z μ Λn

What bounces with friction slips behind it, Λt = -z μ Λn and z s⁺ ≥ 0, or has come to rest along its plane, s⁺ = 0. By
Poisson's law the first is so where it slips that way at the end of compression too, where u is (e u⁻ + u⁺)/(1 + e):
then both laws agree. The second they need not tell alike, and Newton's is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain, pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import SimulateError, listed, suggestion
from symdyn.frozen import dataclass, field
from symdyn.scene import Scene
from symdyn.scene.values import DryJoint, Faults, Unilateral
from symdyn.simulation.prescribed import number_of, parameter_values
from symdyn.transcription.contact_entries import Contacts
from symdyn.transcription.grid import Grid, Places, read_mesh, read_span
from symdyn.transcription.local import PLACES, Source, appearing

Flags = NDArray[np.bool_]

KEYS = ("closed", "slips", "strikes", "duration", "intervals", "end")

PASSING = ("law", "touch", "struck")
"""Functions of passages that have a row for each of a contact."""

CLOSE = 1e-9
"""By how much durations may miss the time of the end by rounding, s."""

SHORTEST = 1e-3
"""Of a phase whose duration is not given, over the longest time of the end."""


@dataclass(frozen=True)
class Phase:
    """A part of a motion in which the same contacts are closed.

    Attributes:
        mesh: where its intervals end, shares of its duration, 0 … 1.
        span: the smallest and the largest duration, s.
        closed: what is closed; it sticks where there is friction.
        slips: what is closed and slips, and the sign of its slip.
        strikes: what strikes where it begins, what closes there among it.
        bounces: what of that bounces with friction, and the sign of its slip behind, 0 where it has none.
        end: coordinates that are given where it ends.
    """

    mesh: Array = field(repr=False)
    span: tuple[float, float]
    closed: tuple[str, ...] = ()
    slips: Mapping[str, float] = field(default_factory=dict)
    strikes: tuple[str, ...] = ()
    bounces: Mapping[str, float] = field(default_factory=dict)
    end: Mapping[str, Any] = field(default_factory=dict)

    def mode(self, name: str) -> tuple[float, float, float]:
        """Return whether a contact is closed, whether it sticks, and the sign of its slip."""
        slip = self.slips.get(name, 0.0)
        return float(name in self.closed or bool(slip)), float(name in self.closed), slip

    def word(self, name: str, rubs: bool) -> str:
        """Return what a contact does, as runs tell it."""
        closed, sticks, slip = self.mode(name)
        held = f"slips {'+' if slip > 0 else '-'}" if slip else "sticks" if sticks and rubs else "closed"
        return held if closed else "open"

    def numbers(self, contacts: Contacts) -> Array:
        """Return the modes of all contacts, one behind the other."""
        return np.array([x for one in contacts.touches for x in self.mode(one.law.name)])


def read_phases(
    scene: Scene,
    phases: Sequence[Mapping[str, object]],
    mesh: Array,
    until: tuple[float, float],
    laws: Sequence[Unilateral],
    faults: Faults,
) -> tuple[Phase, ...]:
    """Return the phases that are asked for; intervals that are not given are `mesh`, durations free."""
    known, found = {one.name: one for one in laws}, list[Phase]()
    dry = [name for name, one in known.items() if isinstance(one, DryJoint)]
    for k, given in enumerate(phases):
        where = f"phases: {k + 1}"
        for key in (one for one in given if one not in KEYS):
            faults.add(where, f"{key} is no key of a phase; {suggestion(key, KEYS)}")
        closed, strikes = (_names(given.get(word, ())) for word in ("closed", "strikes"))
        slips, end, bounces = given.get("slips", {}), given.get("end", {}), given.get("strikes", {})
        bounces = dict(bounces) if isinstance(bounces, Mapping) else {}
        strikes = tuple(bounces) or strikes
        for name in (name for name, sign in bounces.items() if sign not in (-1, 0, 1)):
            faults.add(
                where, f'strikes = {{"{name}": 1}} where its slip is above zero behind, -1 below, 0 where it rests'
            )
        slips = dict(slips) if isinstance(slips, Mapping) else {str(slips): 0}
        for name in dict.fromkeys((*closed, *slips, *strikes)):
            if name not in known:
                faults.add(where, f"{name} is no contact of {scene.name}; {suggestion(name, known)}")
        for name, sign in slips.items():
            if name in closed:
                faults.add(where, f"{name} cannot both stick and slip; leave it in closed or in slips")
            if sign not in (-1, 1):
                told = f'slips = {{"{name}": 1}} where its slip is above zero, -1 where below'
                faults.add(where, f"slips: say which way {name} slips: {told}")
        for name in strikes:
            if not k:
                faults.add(where, f"{name} strikes at the start, which is given whole; start behind the impact")
            if name in dry:
                faults.add(where, f"{name} is dry friction of a joint, which strikes nothing")
        for name in dry:
            if name not in (*closed, *slips):
                faults.add(where, f"{name} sticks or slips always: name it in closed, where it sticks, or in slips")
        if not isinstance(end, Mapping):
            faults.add(where, f'end = {end!r:.40}: give coordinates, such as {{"z": 1}}')
            end = {}
        own = read_mesh(given["intervals"], faults) if "intervals" in given else mesh
        span = SHORTEST * until[1], until[1]
        if "duration" in given:
            span = read_span(given["duration"], faults, where, "duration")
        signs = {name: float(sign) for name, sign in slips.items() if sign in (-1, 1)}
        closing = [n for n in (*closed, *signs) if found and n not in dry and not found[-1].mode(n)[0]]
        every = tuple(dict.fromkeys((*strikes, *closing)))
        found.append(Phase(own, span, closed, signs, every, bounces, dict(end)))
    least, most = (sum(one.span[i] for one in found) for i in (0, 1))
    if not faults.lines and not (least - CLOSE <= until[1] and until[0] <= most + CLOSE):
        wide, asked = (f"{a:g} s" if a == b else f"{a:g} … {b:g} s" for a, b in ((least, most), until))
        faults.add("phases", f"their durations are {wide} together, and until is {asked}")
    if not faults.lines:
        for k, pair in enumerate(pairwise(found), start=2):
            _check_passage(scene, *pair, known, f"phases: {k}", faults)
    return tuple(found)


def _names(given: object) -> tuple[str, ...]:
    """Return one name or several."""
    if isinstance(given, str):
        return (given,) if given else ()
    return tuple(map(str, given)) if isinstance(given, Sequence) else (str(given),)


def _check_passage(
    scene: Scene, one: Phase, then: Phase, known: Mapping[str, Unilateral], where: str, faults: Faults
) -> None:
    """Report impacts that are not known here: those with restitution that do not part, or have friction."""
    values = parameter_values(scene)
    meet = [n for n, law in known.items() if touches(n, one, then) and not isinstance(law, DryJoint)]
    for name in then.strikes:
        law = known[name]
        if number_of(law.restitution, values, name, faults) == 0:
            if not then.mode(name)[0]:
                faults.add(where, f"{name} has no restitution: where it strikes it is closed; name it in closed too")
        elif then.mode(name)[0]:
            faults.add(where, f"{name} has a restitution: where it strikes it is open behind; take it out of closed")
        elif name not in then.bounces and (law.friction.symbols or number_of(law.friction, values, name, faults)):
            told = f'strikes = {{"{name}": 1}} where its slip is above zero behind, -1 where below, 0 where it rests'
            faults.add(where, f"{name} bounces with friction: say how it leaves: {told}")
        elif law.law == "poisson" and then.bounces.get(name) == 0:
            told = 'write law = "newton"; by Poisson\'s the impulses of both its phases decide'
            faults.add(where, f"{name} rests along its plane behind: {told}")
        elif len(meet) > 1 and law.law == "poisson":
            told = f'law = "newton" says what follows; by Poisson\'s the others, {listed(meet)}, decide too'
            faults.add(where, f"{name} bounces while more than one contact touches: {told}")


def touches(name: str, one: Phase, then: Phase) -> bool:
    """Tell whether a contact touches between two phases."""
    return bool(one.mode(name)[0] or then.mode(name)[0] or name in then.strikes)


class Sides(NamedTuple):
    """What bounds a problem's unknowns and equations; arrays that are changed."""

    place: Mapping[str, Places]
    row: Mapping[str, Places]
    lower: Array
    upper: Array
    rows_lower: Array
    rows_upper: Array

    def hold(self, columns: Places) -> None:
        """Set unknowns to zero."""
        self.lower[columns] = self.upper[columns] = 0.0

    def drop(self, rows: Places) -> None:
        """Ask nothing of equations."""
        self.rows_lower[rows], self.rows_upper[rows] = -np.inf, np.inf

    def above(self, rows: Places) -> None:
        """Ask equations not to be negative."""
        self.rows_upper[rows] = np.inf


def bound_schedule(sides: Sides, source: Source, schedule: Sequence[Phase], grid: Grid) -> Array:
    """Put what phases ask of contacts into the bounds of a problem; return α, β and ζ of each row of passages."""
    contacts, rows = source.written.contacts, sides.row["path"]
    moving = [i for i, kind, _ in source.locals["path"].pattern if kind == "u"] if rows.size else []
    again = np.setdiff1d(np.arange(rows.shape[1]), moving)  # what the end of the phase before has told
    law = np.zeros((len(schedule) - 1, len(contacts.law)))
    if not contacts.touches:
        return law
    _refuse(source, schedule)
    places = {"stage": grid.phase[grid.stage], "node": grid.phase[grid.node]}
    for k, phase in enumerate(schedule):
        within = grid.phase[grid.starts] == k
        place = {"contact": sides.place["contact"][places["stage"] == k], "slack": sides.place["slack"][within]}
        row = {name: sides.row[name][places[PLACES[name]] == k] for name in ("balance", "held", "cone", "open")}
        before, after = (schedule[i] if 0 <= i < len(schedule) else None for i in (k - 1, k + 1))
        _bound_phase(sides._replace(place=place, row=row), contacts, phase, before, after)
        if before is not None:
            sides.drop(sides.row["path"][places["node"] == k][0, again])
            place, row = {"impulse": sides.place["impulse"][k - 1]}, {n: sides.row[n][k - 1] for n in PASSING}
            law[k - 1] = _bound_passage(sides._replace(place=place, row=row), contacts, before, phase)
    return law


class _Rows(NamedTuple):
    """The contact that each row of W, gap, row of a cone, of an impact, and slip belongs to; whether a row is an n."""

    row: Places
    gap: Places
    cone: Places
    struck: Places
    slip: Places
    normal: Flags

    @classmethod
    def of(cls, contacts: Contacts) -> _Rows:
        """Return those of all contacts."""
        touches = contacts.touches
        gaps, along = (np.array(x) for x in zip(*((bool(x.normal), len(x.tangents)) for x in touches), strict=True))
        each = np.arange(len(touches))
        normal = np.array([x is one.normal for one in touches for x in one.rows])
        cone, struck = (np.repeat(each, np.array(rows)[along]) for rows in ([0, 2, 1], [0, 4, 1]))
        return cls(np.repeat(each, gaps + along), each[gaps], cone, struck, each[along > 0], normal)


def _bound_phase(sides: Sides, contacts: Contacts, phase: Phase, before: Phase | None, after: Phase | None) -> None:
    """Put what a phase asks of its contacts into the bounds of its problem."""
    place, row, of = sides.place, sides.row, _Rows.of(contacts)
    closed, sticks, slips = phase.numbers(contacts).reshape(-1, 3).T != 0
    names = [one.law.name for one in contacts.touches]
    m, count = len(of.row), len(of.gap)
    forces, balance, cone = place["contact"], row["balance"][:, row["balance"].shape[1] - m :], row["cone"]
    sides.hold(forces[:, ~closed[of.row]])
    sides.drop(balance[:, ~closed[of.row]])
    sides.lower[forces[:, closed[of.row] & of.normal]] = 0.0
    kept = np.append(closed[of.gap], np.where(of.normal, closed[of.row], sticks[of.row]))
    sides.hold(place["slack"][:, place["slack"].shape[1] - count - m :][:, ~kept])
    sides.drop(row["held"][:, row["held"].shape[1] - count - m :][:, ~kept])
    sides.above(cone)
    sides.drop(cone[:, ~sticks[of.cone]])
    sides.above(row["open"])
    gaps, slides = row["open"][:, :count], row["open"][:, count:]
    passes = np.array([one.active is not None for one in contacts.touches])
    sides.drop(gaps[:, (closed | passes)[of.gap]])
    sides.drop(slides[:, ~slips[of.slip]])
    for end, one, then in ((0, before, phase), (-1, phase, after)):
        if one is not None and then is not None:  # where both say the same, and it is zero, one of them is enough
            stays = before if end == 0 else after
            sides.drop(gaps[end, [touches(names[k], one, then) for k in of.gap]])
            sides.drop(slides[end, [bool(stays and stays.mode(names[k])[1] and not then.strikes) for k in of.slip]])
    if before is not None:
        sides.drop(row["held"][0])


def _bound_passage(sides: Sides, contacts: Contacts, one: Phase, then: Phase) -> Array:
    """Put what is asked between two phases into bounds; return α, β and ζ of each row."""
    of, impulse, law = _Rows.of(contacts), sides.place["impulse"], sides.row["law"]
    first, struck = len(impulse) - len(contacts.forces), bool(then.strikes)
    (closed, stuck, _), (closes, sticks, _) = (x.numbers(contacts).reshape(-1, 3).T != 0 for x in (one, then))
    names = [x.law.name for x in contacts.touches]
    bounced = np.array([name in then.bounces for name in names])
    leaves = np.array([then.bounces.get(name, 0.0) for name in names])
    slip, sticks = then.numbers(contacts)[2::3] + leaves, sticks | (bounced & (leaves == 0))
    meets = closes | np.array([x.law.name in then.strikes for x in contacts.touches])
    kicked = np.array([struck and x.normal is not None for x in contacts.touches])
    pushed = np.where(of.normal, (kicked & meets)[of.row], (kicked & (closes | bounced))[of.row])
    asked = np.where(
        of.normal,
        (meets & ~(closed & closes & ~kicked))[of.row],
        ((closes | bounced) & np.where(sticks, ~stuck | struck, kicked))[of.row],
    )
    sides.above(sides.row["struck"])
    slides = (np.arange(len(of.struck)) - np.searchsorted(of.struck, of.struck)) > 1
    kept = np.where(slides, (leaves != 0)[of.struck], (sticks & kicked)[of.struck])
    sides.drop(sides.row["struck"][~kept])
    sides.drop(sides.row["touch"][(closed | ~meets)[of.gap]])
    sides.drop(law[first:][~asked])
    sides.hold(impulse[first:][~pushed])
    sides.lower[impulse[first:][pushed & of.normal]] = 0.0
    if not struck:
        sides.hold(impulse)
        sides.drop(law[:first])
    numbers = np.zeros((len(impulse), 3))
    numbers[:first, 0] = 1.0
    numbers[first:, 0] = np.where(of.normal, meets[of.row], sticks[of.row])
    numbers[first:, 1] = of.normal & ~closes[of.row]
    numbers[first:, 2] = np.where(of.normal, 0.0, slip[of.row])
    return numbers.ravel()


def _refuse(source: Source, phases: Sequence[Phase]) -> None:
    """Report what phases know nothing of.

    Raises:
        SimulateError: something depends on the time, or slips along two directions, or is to slip without friction.
    """
    name, found = source.scene.name, source.written
    if {*found.kinds[TIME]} & appearing(chain(*found.entries.values())):
        raise SimulateError(f"{name}: phases know no motions, forces and formulas over time t; leave t out")
    for touch in found.contacts.touches:
        one, along = touch.law.name, len(touch.tangents)
        if along != 1 and any(one in phase.slips for phase in phases):
            rubs = "may slip along two directions, and a phase knows slips along one: let it stick"
            told = rubs if along else "has no friction, so that nothing slips or sticks: name it in closed"
            raise SimulateError(f"{name}: phases: {one} {told}")
