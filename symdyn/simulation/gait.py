"""Periodic motions of a mechanism, with period and Floquet multipliers: the function `gait`.

What repeats itself is the fixed point of a return map, see `return_map`; its multipliers are the eigenvalues of the
derivative of that. Their errors are what a coarser tolerance and wider differences change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Unpack

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import native, with_fields
from symdyn.errors import SimulateError, listed
from symdyn.frozen import dataclass, field, replace
from symdyn.rounding import in_digits
from symdyn.scene import Scene, SceneLike
from symdyn.scene.values import split_commas
from symdyn.shown import Shown
from symdyn.simulation.equations.variational import WIDTH
from symdyn.simulation.forward import simulate
from symdyn.simulation.initial import Start
from symdyn.simulation.prescribed import in_seconds
from symdyn.simulation.problem import Problem
from symdyn.simulation.return_map import CLOSE, ROUNDING, ReturnMap
from symdyn.simulation.trajectory import Trajectory

RTOL, COARSER = 1e-11, 30.0
"""Relative tolerance of a step; what it is multiplied by, and widths of differences by 2, for the error bars."""

LONGEST = 1e6
"""A period at most, s."""

UNSURE = 1e-7
"""How near to 1 a multiplier says nothing."""


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

    >>> import symdyn
    >>> cart = symdyn.scene.read_text('''
    ... [bodies.b]
    ... mass = 1
    ... [joints.x]
    ... type = "prismatic"
    ... parent = "ground"
    ... child = "b"
    ... axis = [1, 0, 0]
    ... coordinate = "x"
    ... damping = 1
    ... [springs.s]
    ... joint = "x"
    ... stiffness = 4
    ... ''')
    >>> found = symdyn.gait(cart, forces="tau1=sin(2*pi*t)", period=1)
    >>> print(found.stable, abs(found.multipliers).round(6))
    True [0.606531 0.606531]
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
    >>> found = symdyn.gait(symdyn.example("pendulum"), forces="tau1=0.1*sin(3*t)", period=2.0943951023931953)
    >>> len(found.multipliers), found.stable
    (2, True)

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
    period, until = in_seconds({"period": period, "until": until}).values()
    pairs = _pairs(swap) if isinstance(swap, str) else dict(swap)
    if odd := [one for one in (*pairs, *pairs.values()) if not isinstance(one, str)]:
        raise SimulateError(f"swap: {odd[0]!r:.40} is no name; write swap={{'a': 'b'}}")
    if bool(section.strip()) == (period is not None):
        raise SimulateError("give section, where a period begins, or period, of forces that depend on time")
    (time,) = native(float, 0.0 if period is None else period)
    if period is not None and not 0.0 < time <= LONGEST:
        raise SimulateError(f"period = {time:g} s: give a time above zero, and no more than {LONGEST:g} s")
    return _gait(problem, section.strip(), pairs, time, until, RTOL if rtol is None else rtol)


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
