"""Periodic motions: the fixed point of a return map, its period and its Floquet multipliers; the function `gait`.

    P(x)      the state behind the next passage of the section, or one period of the forces later, legs swapped
    P(x) = x  by Newton's method, δ = (1 - ∂P)⁺ (P - x)
    ∂P        steps of the run, differentiated, and saltation matrices of all events on the way; its eigenvalues are
              the multipliers

A section is passed whenever it is: changes of P are those of states on it, so that the multiplier 1 along the motion is
none of them. Coordinates that nothing depends on, as the place of a walker, need not return; angles return by whole
turns where equations are the same then.

References: Leine and Nijmeijer, Dynamics and bifurcations of non-smooth mechanical systems (2004), chapters 7 and 9;
Goswami, Espiau and Keramane, Limit cycles and their stability in a passive bipedal gait (1996).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Unpack

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import with_fields
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import MODE
from symdyn.errors import SimulateError, listed, suggestion
from symdyn.graph import Expr, reachable
from symdyn.rounding import in_digits
from symdyn.scene import Scene, SceneLike
from symdyn.scene.values import Faults, split_commas
from symdyn.shown import Shown
from symdyn.simulation.equations.contact_modes import BREAKS, LIFTS, OF_ROPES, STOPS, STRIKES
from symdyn.simulation.equations.settling import held
from symdyn.simulation.equations.system import Projection, StateEquations
from symdyn.simulation.equations.variational import WIDTH, Flow, smooth_flow
from symdyn.simulation.forward import Control, is_stiff, ready, simulate
from symdyn.simulation.initial import Start
from symdyn.simulation.integrate.integration import IntegrationError
from symdyn.simulation.integrate.tape import Section, taped
from symdyn.simulation.problem import Problem, Run
from symdyn.simulation.trajectory import Trajectory
from symdyn.simulation.variations import state_covectors

EVENTS = {one: one for one in (STRIKES, LIFTS, BREAKS, STOPS)} | {told: one for one, told in OF_ROPES.items()}
"""Events of contacts by the words that runs tell."""

RTOL, COARSER = 1e-11, 30.0
"""Relative tolerance of a step; what it is multiplied by, and widths of differences by 2, for the error bars."""

CLOSE, ENOUGH = 1e-10, 1e-8
"""A state that has returned, over the largest number of it or 1; and that is taken where no step comes closer."""

STEPS, HALVINGS = 25, 6
"""Of Newton's method at most, and of one step."""

UNSURE, ROUNDING = 1e-7, 1e-13
"""How near to 1 a multiplier says nothing; and errors of all."""

SOON = 1e-3
"""What passes the section sooner, over the period before, has just passed it."""

ZERO = 1e-6
"""Singular values and multipliers, over the largest or 1, of directions that an impact or the section takes away."""


@dataclass(frozen=True, eq=False)
class Gait(Shown):
    """A periodic motion.

    Attributes:
        problem: the mechanism, from the fixed point on.
        section: what passes where it begins; "" of forces with its period, whose motion begins at t = 0.
        swap: names that change places after a period.
        period: s.
        start: the fixed point behind the section by name: positions, velocities and states.
        advances: by how much coordinates that nothing depends on go on in a period, by name.
        multipliers: Floquet's, those not zero, the largest first; complex, shape (k,).
        errors: of each, from a coarser tolerance and wider differences, shape (k,).
        zeros: how many more are zero, as impacts and the section take directions away.
        missed: by how much the state after a period is not the fixed point, the largest entry.
        rtol: relative tolerance of a step.
        until: s, within which it has to return.
    """

    problem: Problem
    section: str
    swap: Mapping[str, str]
    period: float
    start: Mapping[str, float]
    advances: Mapping[str, float]
    multipliers: Array
    errors: Array
    zeros: int
    missed: float
    rtol: float = field(repr=False)
    until: float = field(repr=False)

    @property
    def scene(self) -> Scene:
        """The mechanism."""
        return self.problem.scene

    @property
    def stable(self) -> bool:
        """Whether what is next to it comes back to it: all multipliers are inside of the unit circle, errors too."""
        return bool(np.all(np.abs(self.multipliers) + self.errors < 1.0))

    @property
    def run(self) -> Trajectory:
        """The motion over one period."""
        return simulate(self.problem, until=self.period, rtol=self.rtol)

    @property
    def words(self) -> tuple[str, ...]:
        """It in a few lines."""
        beyond = np.abs(self.multipliers) - 1.0
        unsure = np.maximum(self.errors, UNSURE)
        says = "unstable" if np.any(beyond > unsure) else "neither stable nor unstable to first order"
        says = "stable" if self.stable else says
        behind = f" behind {self.section}" if self.section else " of the forces"
        lines = [f"{self.scene.name}: {says}, period {in_digits(self.period, 12)} s{behind}"]
        lines += [f"{name} = {in_digits(value, 12)}" for name, value in self.start.items()]
        lines += [f"{name} advances by {in_digits(value, 12)}" for name, value in self.advances.items()]
        for value, error in zip(self.multipliers.tolist(), self.errors.tolist(), strict=True):
            imaginary = f" {'+-'[value.imag < 0]} {in_digits(abs(value.imag), 9)}i" if value.imag else ""
            lines.append(f"multiplier {in_digits(value.real, 9)}{imaginary}, error {in_digits(error, 2)}")
        return (*lines, *([f"{self.zeros} more are zero"] if self.zeros else []))

    def __repr__(self) -> str:
        largest = float(np.abs(self.multipliers).max(initial=0.0))
        return f"<Gait of {self.scene.name}: period {self.period:.6g} s, largest multiplier {largest:.6g}>"

    def as_json(self) -> dict[str, Any]:
        """Return it as numbers and text."""
        pairs = [[one.real, one.imag] for one in self.multipliers.tolist()]
        told = {"section": self.section, "swap": dict(self.swap), "period": self.period, "start": dict(self.start)}
        told |= {"advances": dict(self.advances), "multipliers": pairs, "errors": self.errors.tolist()}
        return {**told, "zeros": self.zeros, "stable": self.stable, "missed": self.missed}

    def continued(self, name: str, values: Sequence[float]) -> tuple[Gait, ...]:
        """Return the periodic motions at values of a parameter, each looked for from the one before.

        Raises:
            SimulateError: none is found at a value; it says at which.
        """
        found, last, forced = list[Gait](), self, 0.0 if self.section else self.period
        for value in values:
            problem = replace(last.problem, values={name: float(value)})
            try:
                found.append(last := _gait(problem, last.section, last.swap, forced, last.until, last.rtol))
            except SimulateError as fault:
                raise SimulateError(f"{name} = {float(value):g}: {fault}") from fault
        return tuple(found)


@with_fields(Problem)
def gait(
    scene: SceneLike | Problem,
    *,
    section: str = "",
    swap: str | Mapping[str, str] = "",
    period: float | None = None,
    until: float = 10.0,
    rtol: float | None = None,
    **fields: Unpack[Problem.Fields],
) -> Gait:
    """Return a periodic motion next to a start, with its Floquet multipliers.

    >>> import symdyn
    >>> found = symdyn.gait(symdyn.example("pendulum"), section="q1", start="q1=0.5")
    >>> len(found.multipliers), found.stable
    (1, False)

    Args:
        scene: the mechanism, its parameters bound; or a `Problem`. Its start has to be near the motion.
        section: where a period begins and ends: an event of a contact, such as "strikes foot_a", "lifts off foot_a",
            "slips" or "sticks"; or a formula, where it passes zero upwards.
        swap: what changes places after a period, such as "a=b": a part of names between underscores, so that `hip_a`
            and `foot_a` become `hip_b` and `foot_b`. A step of two equal legs is a period then.
        period: of forces and motions that depend on time, s, in place of a section; several of them are one too.
        until: time within which it has to return, s.
        rtol: relative tolerance of a step; None takes 1e-11.
        **fields: of `Problem`.

    Raises:
        SimulateError: with every fault of the arguments; the section does not happen, or not again, in that time; an
            event is only touched; or Newton's method finds nothing.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    problem, run = Problem.requested(gait, locals(), "until", "rtol")
    pairs = _pairs(swap) if isinstance(swap, str) else dict(swap)
    if bool(section.strip()) == (period is not None):
        raise SimulateError("give section, where a period begins, or period, of forces that depend on time")
    if period is not None and not period > 0:
        raise SimulateError(f"period = {period:g} s: give one above zero")
    return _gait(problem, section.strip(), pairs, period or 0.0, until, RTOL if rtol is None else rtol)


def _pairs(swap: str) -> dict[str, str]:
    found = [pair.partition("=") for pair in split_commas(swap)]
    if wrong := [a for a, _, b in found if not (a.strip() and b.strip())]:
        raise SimulateError(f"swap: {listed(wrong)} changes places with nothing; write a=b")
    return {a.strip(): b.strip() for a, _, b in found}


def _gait(problem: Problem, section: str, swap: Mapping[str, str], period: float, until: float, rtol: float) -> Gait:
    returns = ReturnMap.of(problem, section, swap, period, until, rtol)
    x, there = returns.fixed_point()
    values = there.multipliers
    others = replace(returns, flow=replace(returns.flow, width=2 * WIDTH), rtol=COARSER * rtol).at(x).multipliers
    errors = ROUNDING + np.array([np.abs(others - one).min(initial=1.0) for one in values])
    scene, system = problem.scene, returns.flow.system
    q, u, s = np.split(x[: len(x) - system.hidden], [system.nq, system.nq + system.nv])
    names = (*scene.coordinates, *scene.velocities, *(one.name for one in scene.states))
    advances = {names[k]: float(there.x[k] - x[k]) for k in returns.cyclic}
    return Gait(
        replace(problem, start=Start(q, u, s=s), start_rates=None),
        section,
        swap,
        there.time,
        dict(zip(names, x.tolist(), strict=False)),
        {name: value for name, value in advances.items() if abs(value) > CLOSE},
        values,
        errors,
        len(there.slope) - len(values),
        float(np.abs(returns.missed(x, there)).max(initial=0.0)),
        rtol,
        until,
    )


class Returned(NamedTuple):
    """A state after a period, legs swapped: when, x, shape (nx,), and ∂P along independent names, shape (k, k)."""

    time: float
    x: Array
    slope: Array

    @property
    def multipliers(self) -> Array:
        """Eigenvalues of ∂P that are not zero, the largest first, complex, shape (at most k,)."""
        A, rank = self.slope, -1
        while rank != len(A):  # on what it leaves: zeros of a block that takes several turns are rounded to large ones
            U, sizes, _ = np.linalg.svd(A)
            rank = int(np.sum(sizes > ZERO * max(1.0, sizes.max(initial=0.0))))
            A = A if rank == len(A) else U[:, :rank].T @ A @ U[:, :rank]
        found = np.linalg.eigvals(A).astype(complex)
        found = found[np.abs(found) > ZERO]
        order = np.lexsort((-found.imag, -np.round(np.abs(found), 9)))
        return np.asarray(found[order])


@dataclass(frozen=True)
class ReturnMap:
    """P and what belongs to it.

    Attributes:
        flow: the mechanism under its forces, and its derivative.
        begin: the state that it is looked for from, shape (nx,).
        section: its kinds of events; none where time ends a period.
        told: what it is called.
        place: where the names of x stand after a swap.
        cyclic: coordinates that nothing depends on.
        until: s; the period where there is no section.
        rtol: relative tolerance of a step.
    """

    flow: Flow
    begin: Array
    section: Section
    told: str
    place: Array
    cyclic: tuple[int, ...]
    until: float
    rtol: float

    @classmethod
    def of(
        cls, problem: Problem, section: str, swap: Mapping[str, str], period: float, until: float, rtol: float
    ) -> ReturnMap:
        """Return it; SimulateError with every fault of a section or a swap."""
        what, _, contact = section.rpartition(" ")
        formula = "" if what in EVENTS or section in EVENTS else section
        run = Run(period or until, rtol=rtol, stops=(formula,) if formula else ())
        faults = Faults("")
        forces, initial, zeros, _ = problem.posed(run, faults)
        faults.close(SimulateError)
        system, x = ready(problem, forces, zeros, initial, run.until, Control())
        scene = problem.scene
        kinds: tuple[int, ...] = ()
        if formula:
            kinds = (0,)
            system = replace(system, kinds=(replace(system.kinds[0], direction=1), *system.kinds[1:]))
        elif section:
            kinds = (_kind(scene, system, EVENTS.get(what, what), contact),)
        nodes = _depends(system)
        q = next(one for one in system.program["rates"].function.arguments if one.name == "q").symbols
        in_time = forces.outside or q[0].graph.symbol(TIME) in nodes
        if section and in_time:
            raise SimulateError(f"{scene.name}: forces or motions depend on time; give period in place of section")
        names = [*scene.coordinates, *scene.velocities, *(one.name for one in system.scene.states)]
        cyclic = tuple(k for k, one in enumerate(q) if one not in nodes)
        place = np.array([names.index(one) for one in _swapped(scene, names, swap)], dtype=int)
        flow = smooth_flow(system, ())
        return cls(flow, x[: flow.size], Section(kinds), section, place, cyclic, run.until, rtol)

    def at(self, x: Array) -> Returned:
        """Return P and ∂P at a state.

        Raises:
            SimulateError: the motion does not return, or cannot go on; an event is only touched.
        """
        system = self.flow.system
        ways, changes, rows = self._ways(x)
        probe = np.cos(1.0 + np.arange(len(ways))) @ ways, np.zeros(changes.shape[1])
        times = np.array([0.0, self.until])
        stiff = is_stiff(system, np.append(x, np.zeros(int(system.works))), self.until)
        try:
            tape = taped(self.flow, x, probe, times, self.rtol, self.rtol, stiff, section=self.section)
        except IntegrationError as fault:
            raise SimulateError(f"{system.scene.name}: {fault}") from fault
        if self.section.kinds and tape.end is None:
            again = "again " if self.section.sooner else ""
            raise SimulateError(
                f"{system.scene.name}: {self.told} does not happen {again}until t = {self.until:g} s; give a later "
                "until, a start nearer to a periodic motion, or another section"
            )
        end, moved = tape.x[-1][self.place], tape.forward(self.flow, ways, changes)[-1][:, self.place]
        slope = state_covectors(self.flow, end)[rows] @ moved.T
        return Returned(self.until if tape.end is None else tape.end, end, slope)

    def missed(self, x: Array, there: Returned) -> Array:
        """Return P - x along independent names, shape (k,), angles but for whole turns that equations do not see."""
        d = there.x - x
        d[list(self.cyclic)] = 0.0
        for k in np.flatnonzero(np.abs(d[: self.flow.system.nq]) > math.pi).tolist():
            turned = x.copy()
            turned[k] += 2 * math.pi * round(float(d[k]) / (2 * math.pi))
            f, g = (
                np.append(self.flow.rates(0.0, one), self.flow.system.evaluate("events", 0.0, one))
                for one in (x, turned)
            )
            if np.allclose(f, g, 1e-9, 1e-9):
                d[k] += x[k] - turned[k]
        return np.asarray(state_covectors(self.flow, x)[self._ways(x)[2]] @ d)

    def fixed_point(self) -> tuple[Array, Returned]:
        """Return the state that returns, and where it does.

        Raises:
            SimulateError: the motion does not return, or no state near it returns to itself.
        """
        first = self.at(self.begin)
        x = first.x
        here = replace(self, section=replace(self.section, sooner=SOON * first.time))
        there = here.at(x)
        missed = here.missed(x, there)
        for _ in range(STEPS):
            size = float(np.abs(missed).max(initial=0.0))
            if size <= CLOSE * max(1.0, float(np.abs(x).max())):
                return x, there
            step = np.asarray(
                np.linalg.lstsq(np.eye(len(missed)) - there.slope, missed, rcond=1e-9)[0], dtype=np.float64
            )
            better = here._better(x, there, step, size)
            if better is None:
                break
            x, there, missed = better
        size = float(np.abs(missed).max(initial=0.0))
        if size <= ENOUGH * max(1.0, float(np.abs(x).max())):
            return x, there
        raise SimulateError(
            f"{self.flow.system.scene.name}: no state next to the start returns to itself: one that was found misses "
            f"itself by {size:.3g}, and others by more; give a start nearer to a periodic motion"
        )

    def _better(self, x: Array, there: Returned, step: Array, size: float) -> tuple[Array, Returned, Array] | None:
        """Return the state behind a step that brings P closer to it, shortened where need be; None for none."""
        for shorter in range(HALVINGS):
            try:
                y = self._moved(x, there, step / 2**shorter)
                found = self.at(y)
            except SimulateError:
                continue
            missed = self.missed(y, found)
            if float(np.abs(missed).max(initial=0.0)) < size:
                return y, found, missed
        return None

    def _moved(self, x: Array, there: Returned, step: Array) -> Array:
        """Return a state a step away, back on its constraints, in the mode that it returns in."""
        system, hidden = self.flow.system, self.flow.system.hidden
        y = x + step @ self._ways(x)[0]
        y[len(y) - hidden :] = there.x[len(y) - hidden :]
        y = Projection(system, ROUNDING).projected(y)
        kinds = [system.kinds[k].contact for k in self.section.kinds]
        struck = [one[0] for one in kinds if one is not None and one[1] == STRIKES]
        swapped = [] if system.contacts is None else [self._swapped_contact(k) for k in struck]
        return y if system.contacts is None else held(system, 0.0, y, swapped)

    def _swapped_contact(self, k: int) -> int:
        contacts = self.flow.system.contacts
        assert contacts is not None, "it strikes"
        first = contacts.place + len(MODE) * k
        return (int(np.flatnonzero(self.place == first)[0]) - contacts.place) // len(MODE)

    def _ways(self, x: Array) -> tuple[Array, Array, list[int]]:
        """Return δx of independent names, shape (k, nx), δp, which is zero, and their rows among all names."""
        flow, nv = self.flow, self.flow.system.nv
        ways, changes, _ = flow.starting(x)
        positions, velocities = flow.independent()
        rows = [*positions, *(nv + k for k in velocities)]
        still = flow.turned(x[: flow.system.nq])
        others = [k for k in range(flow.system.nq) if k not in self.cyclic]
        gone = {k for k in range(nv) if not np.any(still[others, k])}
        kept = [i for i, k in enumerate(rows) if k not in gone]
        return ways[kept], changes[kept], [rows[i] for i in kept]


def _depends(system: StateEquations) -> set[Expr]:
    """Return all that rates, events and constraints are made of."""
    names = [one for one in ("events", "contacts", "constraint_residual") if one in system.calls]
    entries = [x for one in names for x in system.program[one].function.entries]
    return set(reachable([*system.program["rates"].function.entries[: system.nq + system.nu], *entries]))


def _kind(scene: Scene, system: StateEquations, what: str, contact: str) -> int:
    """Return the kind of event by its words; SimulateError where there is no such contact."""
    contacts = system.contacts
    known = [] if contacts is None else [contacts.name(k) for k in range(len(contacts.touches))]
    if contact not in known:
        told = suggestion(contact, known) if known else "the scene has no contacts"
        raise SimulateError(f"{scene.name}: section: contact {contact} is not known; {told}")
    here = (known.index(contact), what)
    found = [k for k, kind in enumerate(system.kinds) if kind.contact == here]
    if not found:
        raise SimulateError(f"{scene.name}: section: {contact} never {what}: it has no such law; take strikes")
    return found[0]


def _swapped(scene: Scene, names: Sequence[str], swap: Mapping[str, str]) -> list[str]:
    """Return what stands in the place of each name after a swap.

    Raises:
        SimulateError: a name has no counterpart, or nothing is swapped.
    """
    to = {b: a for a, b in swap.items() if b not in swap} | dict(swap)
    found = [to.get(name, "".join(to.get(one, one) for one in re.split(r"([_.])", name))) for name in names]
    lost = [f"{name} would be {other}" for name, other in zip(names, found, strict=True) if other not in names]
    if lost or (swap and found == list(names)):
        told = listed(lost) if lost else "no name has such a part"
        raise SimulateError(
            f"{scene.name}: swap: {told}; parts of names stand between underscores, as in hip_a, foot_a"
        )
    return found
