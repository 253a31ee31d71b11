"""State equations derived and compiled, with the decisions that they rest on.

All is one program: the formulas of the driving forces and of the events stand on the graph of the equations. Its
parameters are free. What depends on them alone is prepared once for a set of values, so that compiled equations serve
all values of theirs.

Some things are decided in numbers, at every set of values: which constraints are independent, which velocities, whether
loops hold coordinates in proportion, which momenta are conserved. Equations are taken only where they were written for
the same decisions. These are made at assembled positions. Where the start is given for other values, nothing is
assembled: it is tested whether the decisions hold there and a step away from there, and only if they may not are they
made anew.

The system of a closed mechanism has more functions than that of a tree:

    residual, row_rates    r and G u: how far a state misses its loops
    correction, fitted     what brings it back: -G_d⁻¹ r, and velocities from independent ones
    reach                  ∂u/∂u_i, which is large where the choice of independent velocities fails
    together               rates by all constraints at once, with multipliers: no choice, regular wherever G has full
                           rank

    M u̇ - Gᵀ λ = τ - h        G u̇ = -γ        u̇_p = p̈ where a motion p is prescribed

A pickle holds the scene, its driving forces, the events and a hash of what the equations are made of; the reader
compiles them, or has them.
"""

from __future__ import annotations

import copyreg
import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

from symdyn.algebra import Array
from symdyn.dynamics import OUTPUTS, Function, Workspace, derive_one
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import Moving, WrittenDecisions, contact_equations, lacks_modes
from symdyn.dynamics.reactions import unknown_forces
from symdyn.errors import DerivationError, SimulateError, SymdynWarning
from symdyn.graph import Expr, Op, reachable, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import LETTERS
from symdyn.simulation.equations.compiled_routines import Kept, acting, compiled, function_of, opened, points, powers
from symdyn.simulation.equations.contact_modes import contact_parts, named_columns
from symdyn.simulation.equations.events import event_kinds
from symdyn.simulation.equations.monitors import candidates, limits_of
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.prescribed.forces import Forces


def row_rates(w: Workspace, G: Function) -> Function:
    """Return G u, what the rows make of the velocities."""
    rows, n = G.shape
    terms = [[G.entries[r * n + k] * w.state.qd[k] for k in range(n)] for r in range(rows)]
    return function_of(w, "row_rates", [w.graph.total(row) for row in terms], ("q", "qd"))


def corrections(w: Workspace, decisions: WrittenDecisions) -> list[Function]:
    """Return what brings a state of a closed mechanism back: Newton's step, its way in q, and fitting velocities."""
    zero, u = w.graph.zero, w.state.qd
    linear = decisions.linear
    if linear:
        values = linear.followers(w)
        step = {k: values[w.state.q[k]] - w.state.q[k] for k in linear.dependent}
        fitted = {k: values[u[k]] for k in linear.dependent}
    else:
        rows, partition = w.loops.recursive, w.loops.decisions.partition
        G = w.loops.G(rows)
        step = partition.solve_dependent(G, [-r for r in w.loops.residual(rows)]) if G else {}
        moved = [-w.graph.total(row[k] * u[k] for k in partition.independent) for row in G]
        fitted = partition.solve_dependent(G, moved) if G else {}
    return [
        function_of(w, "correction", [step.get(k, zero) for k in range(w.state.n + len(w.states))], ("q", "qd")),
        function_of(w, "movement", w.state.rates, ("q", "qd")),
        function_of(w, "fitted", [fitted.get(k, x) for k, x in enumerate((*u, *w.states))], ("q", "qd")),
    ]


def reach(w: Workspace) -> list[Expr]:
    """Return ∂u/∂u_i of the dependent velocities; nothing where there is no other choice."""
    if not w.loops.motion.independent:
        return []
    return [x for row in w.loops.reduction.T for x in row.values() if x is not w.graph.one]


def together(w: Workspace, place: Mapping[Expr, Expr], power: Expr) -> Function | None:
    """Return the rates of a state by all rows at once; None where masses leave some acceleration open without them."""
    try:
        found, _ = w.loops.all_constraints_solution
    except DerivationError:
        return None
    rates = [*w.state.rates, *substitute([*found, *w.state_rates], place)]
    return function_of(w, "together", [*rates, *([] if power.is_zero else [power])])


@lru_cache(maxsize=16)
def written_decisions(scene: Scene) -> WrittenDecisions:
    """Return what is decided about the loops and rows of a scene at its values; nothing of a tree.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    if not scene.is_constrained:
        return WrittenDecisions()
    return WrittenDecisions.of(opened(scene).numbers(), opened(scene).closing)


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
    if lacks_modes(scene):
        what = "contacts, stops or dry friction that open, close or stick"
        raise SimulateError(f"{scene.name}: {what} are known by simulate alone; take them out")
    if not (scene.velocities or scene.states):
        opened(scene)
        raise SimulateError(f"{scene.name}: nothing moves: no joint has a coordinate")
    asked = (opened(scene).scene, *forces.form, tuple(events))
    others = [one for one in _KEPT if one[:-1] == asked]
    decisions = others[-1][-1] if others and scene.is_constrained else None
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
    solved = linear.forward_dynamics(w) if linear else derive_one(w, "forward_dynamics").entries
    touching = contact_equations(w, solved, shared=True) if scene.unilaterals else None
    accelerations = substitute(solved if touching is None else touching.accelerations, place)
    drives = (
        list(substitute(derive_one(w, "drive_forces").entries, place)) if OUTPUTS["drive_forces"].exists(scene) else tau
    )
    if touching is not None and w.prescribed.place:
        whole = substitute([*w.forces(touching.accelerations), *touching.generalized], place)
        drives = [whole[k] - whole[w.state.n + k] if k in w.prescribed.place else tau[k] for k in range(w.state.n)]
    work = powers(w, drives, place)
    if touching is not None:
        _refuse_reactions(scene, events)
        moving = replace(moving, accelerations=lambda: touching.accelerations, drives=lambda: drives)
        forces_on = substitute(touching.generalized, place)
        work = [work[0], work[1] + w.graph.total(f * u for f, u in zip(forces_on, w.state.qd, strict=True))]
    power = work[0] + work[1]
    momenta = candidates(w, accelerations, bool(forces.outside) or touching is not None)
    kept = tuple(sorted({*momenta.conserved(found.values), *reported}))
    following = linear.followers(w) if linear else {}
    rates = [*substitute(w.state.rates, following), *accelerations]
    rates += substitute(substitute(w.state_rates, place), following)
    works = touching is not None or not power.is_zero  # impacts take energy at once
    functions = [
        function_of(w, "rates", [*rates, *([power] if works else [])]),
        function_of(w, "drives", drives),
        function_of(w, "power", work),
        function_of(w, "kinetic", derive_one(w, "kinetic_energy").entries),
        function_of(w, "potential", substitute(derive_one(w, "potential_energy").entries, place)),
        points(w),
        function_of(w, "inputs", [place[one] for one in w.inputs]),
    ]
    formulas = (
        substitute(substitute(moving.expressed(events), named_columns(touching, events)), place) if events else []
    )
    bends = _bends(rates, {*w.state.q, *w.state.qd, *w.states, w.graph.symbol(TIME)})
    kinds = event_kinds(w, formulas, bends, limits_of(scene, w.graph, drives), place)
    contacts, own, more = contact_parts(w, touching, place)
    kinds, functions = (*kinds, *own), [*functions, *more]
    functions.append(function_of(w, "events", [kind.guard for kind in kinds]))
    functions += [function_of(w, f"update{k}", kind.update) for k, kind in enumerate(kinds)]
    if kept:
        functions.append(function_of(w, "momenta", [momenta.formulas[k] for k in kept]))
    rows, filled, dependent = 0, (), ()  # type: int, tuple[int, ...], tuple[int, ...]
    if scene.is_constrained:
        G = derive_one(w, "constraint_jacobian")
        rows = G.shape[0]
        filled = tuple(k for k, entry in enumerate(G.entries) if not entry.is_zero)
        functions += [derive_one(w, "constraint_residual"), row_rates(w, G), *corrections(w, decisions)]
        if not linear:
            functions.append(function_of(w, "slopes", [G.entries[k] for k in filled], ("q",)))
            functions.append(function_of(w, "reach", reach(w), ("q",)))
            dependent = tuple(w.loops.decisions.partition.dependent) if functions[-1].entries else ()
    made = compiled(scene, w.graph, functions)
    mass = () if rows else derive_one(w, "mass_matrix").entries
    return StateEquations(
        scene, forces, found, decisions, events, made, {}, works, momenta, kept, mass, dependent,
        rows, filled, kinds, (), lambda: together(w, place, power), contacts=contacts,
    )  # fmt: skip


def _refuse_reactions(scene: Scene, events: Sequence[Quantity]) -> None:
    """Raise SimulateError where reactions are asked for while contacts push, whose forces these do not know."""
    why = unknown_forces(scene)
    asked = [*events, *(one.formula for one in scene.outputs if why)]
    named = [name for one in asked for name in one.symbols if name.startswith(LETTERS.reaction)]
    if named:
        told = why or "events do not know the forces of contacts in them; name normal_NAME, or leave it out"
        raise SimulateError(f"{scene.name}: {named[0]}: {told}")


def _bends(entries: Sequence[Expr], moving: Collection[Expr]) -> list[Expr]:
    """Return what equations choose by that moves, in order: where one passes zero, they bend or jump."""
    order, varies = reachable(entries), set(moving)
    for node in order:
        if not varies.isdisjoint(node.args):
            varies.add(node)
    choices = (node for node in order if node.op in (Op.ABS, Op.SELECT, Op.TABLE) and node.args[0] in varies)
    guards = (guard for node in choices for guard in node.guards)
    return list(dict.fromkeys(one.args[0] if one.op is Op.NEG else one for one in guards))


def _again(scene: Scene, forces: Forces, events: tuple[Quantity, ...], key: str) -> StateEquations:
    """Return what was pickled: those that this process has, or written and compiled anew."""
    found = state_equations(scene, forces, events)
    if found.key != key:
        message = f"{scene.name}: its equations are written otherwise here than where they were pickled"
        warnings.warn(message, SymdynWarning, stacklevel=2)
    return found


copyreg.pickle(StateEquations, lambda system: (_again, (system.scene, system.forces, system.events, system.key)))
