"""What runs in lockstep are made of, as one program: rates, what measures fold, and what ends runs, of one lane each.

rates(q, qd, t, values)      q̇, u̇
seen(...)                    formulas that are folded
watched(...)                 what ends a run where it crosses zero
prepare(params) -> values    what depends on parameters alone, once a run
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.dynamics import OUTPUTS, Equations, Workspace, derive_one
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import Moving
from symdyn.graph import Expr, evaluate, substitute
from symdyn.program import Candidates, Program, assemble, lower, prepare
from symdyn.scene import Quantity
from symdyn.simulation.equations.compiled_routines import acting, function_of
from symdyn.simulation.equations.crossings import SLACK, STOPS, limits_of
from symdyn.simulation.equations.parametrised import Opened
from symdyn.simulation.prescribed.forces import Forces

TAKEN = ("q", "qd", TIME)

VALUES = "values"
"""The argument of what was prepared: a number for every lane, where `prepared` is one for all."""

ENERGIES = {"kinetic_energy": "kinetic_energy", "potential_energy": "potential_energy"}
"""Columns of a run that measures may name, and the outputs that they are."""


@dataclass(frozen=True)
class Lockstep:
    """The program of runs in lockstep.

    Attributes:
        program: its functions.
        parameters: names of what `prepare` takes, () where nothing is prepared.
        values: how many numbers it returns.
        seen: how many formulas are folded.
        watched: how many ways a run may end before its time.
        outward: the first of them that counts only where it turns positive.
    """

    program: Program
    parameters: tuple[str, ...]
    values: int
    seen: int
    watched: int
    outward: int


def lockstep(
    opened: Opened, forces: Forces, insides: Sequence[Quantity], stops: Sequence[Quantity], ignore_limits: bool
) -> Lockstep:
    """Return the program of a tree under forces without tables and functions.

    Raises:
        DerivationError: there is no forward dynamics, or a reaction that there is not.
    """
    w = Workspace(opened.scene, opened.closing)
    place = acting(w, forces)
    accelerations = substitute(Candidates(w, "forward_dynamics").cheapest().entries, place)
    moving = Moving.driven(w)
    named = {name for one in insides for name in one.symbols}
    energies = {
        w.graph.symbol(name): Candidates(w, output).cheapest().entries[0]
        for name, output in ENERGIES.items()
        if name in named
    }
    seen = substitute(substitute(moving.expressed(insides), energies), place) if insides else []
    tau = [place[one] for one in w.state.tau]
    driving = OUTPUTS["drive_forces"].exists(w.scene)
    drives = list(substitute(derive_one(w, "drive_forces").entries, place)) if driving else tau
    limits = [] if ignore_limits else [one for one in limits_of(w.scene, w.graph, drives) if one.kind in STOPS]
    both = [*(substitute(moving.expressed(stops), place) if stops else ()), *(f for f, _ in w.loops.ends)]
    watched: list[Expr] = [*both, *(limit.beyond - Fraction(str(SLACK)) for limit in limits)]
    functions = [
        function_of(w, name, entries, TAKEN)
        for name, entries in (
            ("rates", [*substitute(w.state.rates, place), *accelerations]), ("seen", seen), ("watched", watched),
        )
        if entries
    ]  # fmt: skip
    made = prepare(_with_parameters(w, functions))
    if not made.is_prepared:
        return Lockstep(made, (), 0, len(seen), len(watched), len(both))
    first = made[Program.PREPARE].function
    apart = [
        replace(
            one.function,
            arguments=tuple(
                replace(a, name=VALUES) if a.name == Program.PREPARED else a
                for a in one.function.arguments
                if a.symbols or a.name != Program.PREPARED  # where no function needs a parameter there are no values
            ),
        )
        for one in made.routines
        if one.function.entries
    ]
    graph = apart[0].entries[0].graph
    program = assemble(opened.scene, graph, tuple(apart)).checked()
    names = tuple(str(one.value) for a in first.arguments for one in a.symbols)
    return Lockstep(program, names, len(first.entries), len(seen), len(watched), len(both))


def jacobian_at(made: Lockstep, parameters: Mapping[str, float], x: Array) -> Callable[[float], Array]:
    """Return what gives ∂f/∂x at t = 0 by central differences of a relative size, zero where it is not finite."""
    rates = made.program["rates"].function
    known: dict[Expr, Any] = {}
    if made.values:
        first = made.program[Program.PREPARE].function
        names = {one: np.float64(parameters[str(one.value)]) for a in first.arguments for one in a.symbols}
        symbols = next(a.symbols for a in rates.arguments if a.name == VALUES)
        known |= zip(symbols, evaluate(first.entries, Batches(), names), strict=True)
    letters = [one for a in rates.arguments if a.name in TAKEN[:2] for one in a.symbols]

    def jacobian(relative: float) -> Array:
        steps = relative * np.maximum(1.0, np.abs(x))
        states = np.vstack([x + np.diag(steps), x - np.diag(steps)])
        at = known | dict(zip(letters, states.T, strict=True)) | {rates.entries[0].graph.symbol(TIME): np.float64(0.0)}
        with np.errstate(all="ignore"):
            found = np.array([np.broadcast_to(y, len(states)) for y in evaluate(rates.entries, Batches(), at)])
            J = (found[:, : len(x)] - found[:, len(x) :]) / (2 * steps)
        return np.where(np.isfinite(J), J, 0.0)

    return jacobian


def _with_parameters(w: Workspace, functions: Sequence[object]) -> Program:
    return lower(Equations(w.scene, w.graph, tuple(functions)))  # type: ignore[arg-type]
