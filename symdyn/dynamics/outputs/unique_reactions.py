"""Which reactions are unique, at a position and in general, and the least ones where they are not.

    A x + b = 0    (5.18) in numbers, six equations a body, every component of every joint
    N              null space of A: self-equilibrated reactions, which no motion tells
    L              characteristic length: a moment of size M counts as a force M / L

A component is unique exactly when its row of N vanishes. Of the others, those with the least sum of squares are given;
newtons and newton metres have no common measure without a length, so L is part of the answer. A position that closes
the loops but for the digits that were written is closed first: what an error of position leaves of a singular value
would be taken for a constraint. Where the rank is less than at generic positions, the mechanism stands at a change
point, which is said.

Reference: Wojtyra and Frączek, Comparison of selected methods of handling redundant constraints in multibody systems
simulations, J. Computational and Nonlinear Dynamics 8 (2013).

In general: rigid bodies do not determine what a self-equilibrated λ in the loops changes, with all wrenches that close
them, and with Gᵀ λ = 0. One drawn at random from N changes, but for a set of measure zero,
every entry that any of them does; it is drawn at generic positions, where the loops are closed and nothing is special.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.arguments import suggesting
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.loops.newton import generic_configurations, in_words, lever_of
from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.dynamics.outputs.result_labels import COMPONENTS, flagged_entries, joints_of
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.reactions.closure_equations import all_ties, refuse_without_place
from symdyn.dynamics.reactions.dalembert import COUPLING, DRIVE, ROW, Equilibrium, Flags, Unknown
from symdyn.dynamics.reactions.free_bodies import FreeBodies, with_loops
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, evaluate
from symdyn.scene import Scene
from symdyn.spatial import Wrench

NEAR = 1e-3
"""Largest residual, over the largest lever, of a position that was written with few digits."""

LOOSE = 1e-7
"""Entries above it, over the largest, are changed: positions are closed to the last digits."""

BALANCED = 1e-6
"""How much of the largest load the equilibrium may miss before the motion is called impossible."""


@dataclass(frozen=True)
class Component:
    """One unknown of (5.18)."""

    joint: str  # its joint, or the scene's row
    text: str  # what it is, such as "moment about x" (axes of the joint frame on the parent) or "drive M"
    unique: bool  # whether the motion determines it
    value: float  # its size at the motion asked for, the least one where it is not unique; N or N m


@dataclass(frozen=True)
class Reactions:
    """Reactions at one position and motion, and how far they are determined.

    Attributes:
        scene: its name.
        length: L, m.
        equations, rank: number of equations (5.18) and the rank of A at this position.
        components: the unknowns.
        joints: names of the joints of the tree and of the loops: the rows of `wrenches`.
        wrenches: [force; moment] that parents exert on children, as the output `reactions`, shape (joints, 6).
        unique: which of its entries are, shape (joints, 6).
        missed: largest part of the equilibrium that no reaction balances, N: the motion is impossible if it is not 0.
        possible: whether it is small against the loads.
        general: rank of A at generic positions of closed loops; more than `rank` at a change point.
        open: largest residual of loops that the position does not close, m or 1; 0 where it does.
    """

    scene: str
    length: float
    equations: int
    rank: int
    components: tuple[Component, ...]
    joints: tuple[str, ...]
    wrenches: Array
    unique: Flags
    missed: float
    possible: bool
    general: int
    open: float

    @property
    def redundancy(self) -> int:
        """How many independent self-equilibrated reactions there are."""
        return len(self.components) - self.rank

    @property
    def words(self) -> tuple[str, ...]:
        """What is not unique, one line each, such as "loop1: moment about x is not unique", and what else to know."""
        lines = [f"{one.joint}: {one.text} is not unique" for one in self.components if not one.unique]
        if not self.possible:
            lines.append(f"the motion is not one that the drives give: {self.missed:.3g} N of the equilibrium remain")
        if self.general > self.rank:
            lines.append(f"change point: the equations have rank {self.rank} here, in general {self.general}")
        if self.open:
            lines.append(f"the loops are not closed here: a residual of {self.open:.3g} is left")
        return tuple(lines)


def reactions_at(
    scene: Scene,
    q: Sequence[float],
    qd: Sequence[float] | None = None,
    qdd: Sequence[float] | None = None,
    parameters: Mapping[str, float] | None = None,
    length: float | None = None,
    t: float = 0.0,
) -> Reactions:
    """Return the reactions of any mechanism, overconstrained ones too, at one position of closed loops.

    Args:
        scene: the mechanism.
        q: joint positions, shape (nq,); quaternions of unit length. Loops that miss by the digits that were written are
            closed from there.
        qd: velocities, shape (nv,); None for zeros.
        qdd: their rates, shape (nv,); None for zeros.
        parameters: values of the free parameters.
        length: characteristic length, m; None takes the largest distance between two joints at this position.
        t: time, s, where something depends on it.

    Raises:
        DerivationError: an argument has the wrong length, a free parameter has no value, L is not positive, a wheel
            lies flat, or a row does not say where its force acts.
    """
    workspace = Workspace(scene)
    hanging = FreeBodies(scene, workspace.tree, workspace.state)
    values = _values(hanging, q, qd, qdd, parameters or {}, t)
    system = Equilibrium.of(hanging, whole=True).in_numbers
    here, places, off = _closed(workspace.scene, np.array([values[node] for node in hanging.state.q]), parameters or {})
    values |= dict(zip(hanging.state.q, here.tolist(), strict=True))
    if length is None:
        length = _extent(hanging, values)
    if not length > 0:
        raise DerivationError(f"{scene.name}: length = {length}: a characteristic length is positive; give one in m")
    found = system.least(values, length)
    acts, _ = system.sizes(values, length)
    unknowns = system.system.unknowns
    components = tuple(
        Component(unknown.joint, _text(unknown, act, scene), not free, float(value))
        for unknown, act, free, value in zip(unknowns, acts, found.free, found.x, strict=True)
    )
    elsewhere = [values | dict(zip(hanging.state.q, place.tolist(), strict=True)) for place in places]
    ranks = [system.least(others, length).rank for others in elsewhere]
    return Reactions(
        scene.name,
        float(length),
        system.system.equations,
        found.rank,
        components,
        tuple(hinge.joint.name for hinge in (*hanging.joints, *hanging.loops)),
        found.R,
        found.unique,
        found.missed,
        found.missed <= BALANCED * max(found.load, 1e-300),
        max([found.rank, *ranks]),
        off,
    )


def _closed(scene: Scene, q: Array, parameters: Mapping[str, float]) -> tuple[Array, tuple[Array, ...], float]:
    """Return q with its loops closed to the last digits, generic positions, and the residual where they are open."""
    if not scene.is_constrained:
        return q, (), 0.0
    numbers = Numbers(scene).bound_to(parameters)
    fault = numbers.lying_flat(q)
    if fault:
        raise DerivationError(f"{scene.name}: {fault}")
    lever = lever_of(numbers, q)
    off = float(np.abs(numbers.residual(q)).max(initial=0.0))
    near = numbers.newton(q, ())
    if off > NEAR * lever or not numbers.is_closed(near):
        return q, (), off
    places = generic_configurations(numbers.in_quaternions, numbers.to_quaternions(near), lever)
    return near, tuple(numbers.from_quaternions(one, near) for one in places), 0.0


def _values(
    hanging: FreeBodies,
    q: Sequence[float],
    qd: Sequence[float] | None,
    qdd: Sequence[float] | None,
    parameters: Mapping[str, float],
    t: float,
) -> dict[Expr, float]:
    scene, state, graph = hanging.scene, hanging.state, hanging.graph
    values = scene.at_time(graph, float(t))
    for parameter in scene.parameters:
        if parameter.value is not None:
            values[graph.symbol(parameter.name)] = evaluate([parameter.value.express(graph)], Floats(), {})[0]
        elif parameter.name in parameters:
            values[graph.symbol(parameter.name)] = float(parameters[parameter.name])
        else:
            raise DerivationError(f"{scene.name}: parameter {parameter.name} has no value; give it in parameters")
    for name, symbols, given in (("q", state.q, q), ("qd", state.qd, qd), ("qdd", state.qdd, qdd)):
        numbers = [0.0] * len(symbols) if given is None else [float(x) for x in given]
        if len(numbers) != len(symbols):
            raise DerivationError(f"{scene.name}: {name} has {len(numbers)} entries, the scene has {len(symbols)}")
        values |= dict(zip(symbols, numbers, strict=True))
    return values


def _extent(hanging: FreeBodies, values: Mapping[Expr, float]) -> float:
    """Return the largest distance between two joints, m; 1 where there is none."""
    entries = [x for frame in hanging.frames for x in frame.p]
    places = np.array(evaluate(entries, Floats(), values)).reshape(-1, 3)
    largest = max((float(np.linalg.norm(places - a, axis=1).max()) for a in places), default=0.0)
    return largest or 1.0


def _text(unknown: Unknown, act: Array, scene: Scene) -> str:
    if unknown.kind == COUPLING:
        return "force of the coupling"
    if unknown.kind == ROW:
        return "force of the row"
    words = in_words(act[:3], act[3:])
    if unknown.kind != DRIVE:
        return words
    joint = next(joint for joint in scene.joints if joint.name == unknown.joint)
    name = joint.drives[unknown.number] if unknown.number < len(joint.drives) else None
    return f"drive {name}" if name else f"drive along {joint.rates[unknown.number]}"


@suggesting
def unique_reactions(
    scene: Scene,
    axes: str = "body",
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> Flags:
    """Return which entries of `reactions` rigid bodies determine, shape (joints + loops, 6), [force; moment] by joint.

    In other `axes` ("body", "joint", "ground") other entries are; DerivationError where loops cannot be assembled, or a
    row does not say where its force acts.
    """
    count = len(scene.joints) + len(scene.loops)
    found = unique_entries(Workspace(scene, closing), axes) or (True,) * (6 * count)
    return np.array(found).reshape(count, 6)


def unique_entries(w: Workspace, axes: str = "body") -> tuple[bool, ...]:
    """Return which entries of the reactions in some axes are unique, row by row; () where all are.

    Raises:
        DerivationError: a row does not say where its force acts.
    """
    refuse_without_place(w.scene)
    if not w.hanging.cuts:
        return ()
    decisions, numbers = w.loops.decisions, w.loops.numbers
    rank, count = len(decisions.independent_rows), len(decisions.names)
    if rank == count:
        return ()
    hanging = FreeBodies(w.scene, numbers.tree, numbers.state, decisions)  # on a graph of its own
    sizes = [numbers.graph.symbol(f"size[{k}]") for k in range(count)]
    still = [Wrench.none(numbers.graph)] * len(hanging.joints)
    R = with_loops(hanging, still, all_ties(hanging, whole=True), sizes, axes)
    loose = np.zeros(len(R), dtype=bool)
    rng = np.random.default_rng(1)
    for place in map(np.array, decisions.assembly.configurations):
        U, _, _ = np.linalg.svd(numbers.jacobian(place))
        drawn = U[:, rank:] @ rng.uniform(0.5, 1.5, count - rank)
        changed = np.abs(numbers.at(R, place, dict(zip(sizes, drawn.tolist(), strict=True))))
        loose |= changed > LOOSE * changed.max(initial=0.0)
    return () if not loose.any() else tuple((~loose).tolist())


def loose_reactions(scene: Scene, closing: LoopChoices) -> str:
    """Return which entries of reactions, axes of the children, are statically indeterminate, in words; "" for none."""
    loose = ~unique_reactions(scene, closing=closing)
    return flagged_entries(joints_of(scene), COMPONENTS, loose.ravel().tolist())
