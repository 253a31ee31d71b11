"""State equations derived and compiled: the functions that a system of them consists of.

All of it is one program: the formulas of the driving forces and of the events stand on the graph of the equations. Its
parameters are free. What depends on them alone is prepared once for a set of values, so that the same equations, once
compiled, serve all values of theirs. Numbers decide some things (which rows are independent, which velocities, whether
loops hold coordinates in proportion, which momenta are conserved): these are decided at every set of values, and
equations are taken only where they were written for the same decisions.

A pickle holds the scene, what drives it, the events and a hash of what the equations are made of; who reads it compiles
them, or has them.
"""

from __future__ import annotations

import copyreg
import warnings
from collections.abc import Sequence

from symdyn.algebra import Array
from symdyn.dynamics import OUTPUTS, Workspace, derive_one
from symdyn.dynamics.outputs import Moving, WrittenDecisions
from symdyn.errors import SimulateError, SymdynWarning
from symdyn.graph import substitute
from symdyn.program import Candidates
from symdyn.scene import Quantity, Scene
from symdyn.simulation.equations.closed_system import corrections, reach, row_rates, together
from symdyn.simulation.equations.compiled_routines import Kept, acting, compiled, function_of, points
from symdyn.simulation.equations.conserved import candidates
from symdyn.simulation.equations.crossings import limits_of
from symdyn.simulation.equations.decisions import written_decisions
from symdyn.simulation.equations.parametrised import opened
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.prescribed.forces import Forces


def state_equations(
    scene: Scene,
    forces: Forces = Forces(),  # noqa: B008  frozen
    events: Sequence[Quantity] = (),
    start: Array | None = None,
) -> StateEquations:
    """Return the state equations of a scene under forces; those that were compiled for other values are taken again.

    Args:
        scene: the mechanism, its parameters bound.
        forces: driving forces.
        events: formulas in t, coordinates, velocities and parameters.
        start: a position, shape (nq,), where it is known; a closed mechanism is assembled without.

    Raises:
        SimulateError: a parameter has no value, or nothing moves.
        DerivationError: there is no forward dynamics, or the loops cannot be closed.
    """
    if not scene.velocities:
        opened(scene)
        raise SimulateError(f"{scene.name}: nothing moves: no joint has a coordinate")
    asked = (opened(scene).scene, *forces.form, tuple(events))
    others = [one for one in _KEPT if one[:-1] == asked]
    decisions = others[-1][-1] if others and scene.is_closed else None
    if decisions is None or start is None or not decisions.hold(opened(scene).numbers(), start):
        decisions = written_decisions(scene)
    notes = () if not others or (*asked, decisions) in others else (decisions.instead_of(others[-1][-1]),)
    made = _KEPT.get((*asked, decisions), lambda: _written(scene, forces, tuple(events), decisions, ()))
    found = made.at(scene, forces, notes)
    if not set(found.conserved) <= set(found.reported):
        made = _written(scene, forces, tuple(events), decisions, found.reported)
        _KEPT.put((*asked, decisions), made)
        found = made.at(scene, forces, notes)
    return found


_KEPT: Kept[StateEquations] = Kept()
"""By the open scene, formulas of forces, which forces are tables, events and decisions."""


def _written(
    scene: Scene, forces: Forces, events: tuple[Quantity, ...], decisions: WrittenDecisions, reported: Sequence[int]
) -> StateEquations:
    """Return the equations derived and compiled; `reported` are momenta that are told beside those conserved here."""
    found = opened(scene)
    w = Workspace(found.scene, found.closing)
    scene, linear = w.scene, decisions.linear
    place = acting(w, forces)
    tau = [place[one] for one in w.state.tau]
    moving = Moving.driven(w)
    moving.check([one.formula for one in w.scene.outputs])
    solved = linear.forward_dynamics(w) if linear else Candidates(w, "forward_dynamics").cheapest().entries
    accelerations = substitute(solved, place)
    drives = (
        list(substitute(derive_one(w, "drive_forces").entries, place)) if OUTPUTS["drive_forces"].exists(scene) else tau
    )
    acts = (drives, substitute(w.Q, place))
    powers = [w.graph.total(f * u for f, u in zip(some, w.state.qd, strict=True)) for some in acts]
    power = powers[0] + powers[1]
    momenta = candidates(w, accelerations, bool(forces.outside))
    kept = tuple(sorted({*momenta.conserved(found.values), *reported}))
    rates = substitute(w.state.rates, linear.followers(w)) if linear else w.state.rates
    functions = [
        function_of(w, "rates", [*rates, *accelerations, *([] if power.is_zero else [power])]),
        function_of(w, "drives", drives),
        function_of(w, "power", powers),
        function_of(w, "kinetic", Candidates(w, "kinetic_energy").cheapest().entries),
        function_of(w, "potential", Candidates(w, "potential_energy").cheapest().entries),
        points(w),
        function_of(w, "inputs", [place[one] for one in w.inputs]),
    ]
    last, limits = w.loops.ends, limits_of(scene, w.graph, drives)
    if events or last or limits:
        looked_for = list(substitute(moving.expressed(events), place))
        looked_for += [*(formula for formula, _ in last), *(limit.beyond for limit in limits)]
        functions.append(function_of(w, "events", looked_for))
    if kept:
        functions.append(function_of(w, "momenta", [momenta.formulas[k] for k in kept]))
    rows, filled, dependent = 0, (), ()  # type: int, tuple[int, ...], tuple[int, ...]
    if scene.is_closed:
        G = Candidates(w, "constraint_jacobian").cheapest()
        rows = G.shape[0]
        filled = tuple(k for k, entry in enumerate(G.entries) if not entry.is_zero)
        functions += [Candidates(w, "constraint_residual").cheapest(), row_rates(w, G), *corrections(w, decisions)]
        if not linear:
            functions.append(function_of(w, "slopes", [G.entries[k] for k in filled], ("q",)))
            functions.append(function_of(w, "reach", reach(w), ("q",)))
            dependent = tuple(w.loops.decisions.partition.dependent) if functions[-1].entries else ()
    made = compiled(scene, w.graph, functions)
    mass = () if rows else derive_one(w, "mass_matrix").entries
    return StateEquations(
        scene, forces, found, decisions, events, made, {}, not power.is_zero, momenta, kept, mass, dependent,
        rows, filled, tuple(words for _, words in last), tuple(limits), (), lambda: together(w, place, power),
    )  # fmt: skip


def _again(scene: Scene, forces: Forces, events: tuple[Quantity, ...], key: str) -> StateEquations:
    """Return what was pickled: those that this process has, or written and compiled anew."""
    found = state_equations(scene, forces, events)
    if found.key != key:
        message = f"{scene.name}: its equations are written otherwise here than where they were pickled"
        warnings.warn(message, SymdynWarning, stacklevel=2)
    return found


copyreg.pickle(StateEquations, lambda system: (_again, (system.scene, system.forces, system.events, system.key)))
