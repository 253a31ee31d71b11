"""The return map of a motion, its derivative and its fixed point.

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
from typing import NamedTuple

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import MODE
from symdyn.errors import SimulateError, listed, suggestion
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, reachable
from symdyn.scene import Scene
from symdyn.scene.values import Faults
from symdyn.simulation.equations.contact_modes import BREAKS, LIFTS, STOPS, STRIKES, TOLD, column_names
from symdyn.simulation.equations.settling import held
from symdyn.simulation.equations.system import Projection, StateEquations
from symdyn.simulation.equations.variational import Flow, smooth_flow
from symdyn.simulation.forward import Control, is_stiff, ready
from symdyn.simulation.integrate.integration import IntegrationError, Outlook
from symdyn.simulation.integrate.tape import Section, taped
from symdyn.simulation.prescribed.formulas_in_time import read_seen
from symdyn.simulation.problem import Problem, Run
from symdyn.simulation.variations import state_covectors

EVENTS = {one: one for one in (STRIKES, LIFTS, BREAKS, STOPS)} | {
    told: one for words in TOLD.values() for one, told in words.items()
}
"""Events of contacts by the words that runs tell."""

CLOSE, ENOUGH = 1e-10, 1e-8
"""A state that has returned, over the largest number of it or 1; and that is taken where no step comes closer."""

ROUNDING = 1e-13
"""Of multipliers, and of states that keep their constraints."""

STEPS, HALVINGS = 25, 6
"""Of Newton's method at most, and of one step."""

SOON = 1e-3
"""What passes the section sooner, over the period before, has just passed it."""

ZERO = 1e-6
"""Singular values and multipliers, over the largest or 1, of directions that an impact or the section takes away."""


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
    """P and what belongs to it."""

    flow: Flow  # the mechanism under its forces, and its derivative
    begin: Array  # the state that it is looked for from, shape (nx,)
    section: Section  # its kinds of events; none where time ends a period
    told: str  # what it is called
    place: Array  # where the names of x stand after a swap
    cyclic: tuple[int, ...]  # coordinates that nothing depends on
    until: float  # s; the period where there is no section
    rtol: float  # relative tolerance of a step

    @classmethod
    def of(
        cls, problem: Problem, section: str, swap: Mapping[str, str], period: float, until: float, rtol: float
    ) -> ReturnMap:
        """Return it; SimulateError with every fault of a section or a swap."""
        what, _, contact = section.rpartition(" ")
        formula = "" if what in EVENTS or section in EVENTS else section
        run = Run(period or until, rtol=rtol, stops=(formula,) if formula else ())
        faults = Faults("")
        if formula and read_seen(problem.scene, formula, "section", faults, column_names(problem.scene)) is None:
            faults.close(SimulateError)
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
            tape = taped(
                self.flow, x, probe, times, self.rtol, self.rtol, stiff, Outlook(self.until, None).look, self.section
            )
        except IntegrationError as fault:
            raise SimulateError(f"{system.scene.name}: {fault}") from fault
        if self.section.kinds and tape.end is None:
            again = "again " if self.section.sooner else ""
            raise SimulateError(
                f"{system.scene.name}: section {self.told} does not happen {again}until t = {self.until:g} s; give a "
                "later until, a start nearer to a periodic motion, or another section"
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
    """Return what stands in the place of each name after a swap; SimulateError of one without a counterpart."""
    to = {b: a for a, b in swap.items() if b not in swap} | dict(swap)
    found = [to.get(name, "".join(to.get(one, one) for one in re.split(r"([_.])", name))) for name in names]
    lost = [
        f"{name} would be {other}"
        for name, other in zip(names, found, strict=True)
        if other not in names and "." not in name
    ]
    if lost or (swap and found == list(names)):
        told = listed(lost) if lost else "no name has such a part"
        raise SimulateError(
            f"{scene.name}: swap: {told}; parts of names stand between underscores, as in hip_a, foot_a"
        )
    return found
