"""Which reactions are unique at a position, and the least ones where they are not.

    A x + b = 0    (5.18) in numbers, six equations a body, every component of every joint
    N              null space of A: self-equilibrated reactions, which no motion tells
    L              characteristic length: a moment of size M counts as a force M / L

A component is unique exactly when its row of N vanishes. Of the others, those with the least sum of squares are given;
newtons and newton metres have no common measure without a length, so L is part of the answer.

Reference: Wojtyra and Frączek, Comparison of selected methods of handling redundant constraints in multibody systems
simulations, J. Computational and Nonlinear Dynamics 8 (2013).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra.numeric import Floats
from symdyn.dynamics.loops.words import in_words
from symdyn.dynamics.reactions.bivectors import frames
from symdyn.dynamics.reactions.dalembert import (
    COUPLING,
    DRIVE,
    ROW,
    Equilibrium,
    Unknown,
    equilibrium,
)
from symdyn.dynamics.reactions.hanging import Hanging
from symdyn.dynamics.reactions.samples import Array
from symdyn.dynamics.reactions.solution import transmitted
from symdyn.dynamics.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate
from symdyn.scene import Scene, express

RANK = 1e-9
"""Singular values this much below the largest are zero, and so are rows of N: position errors are far smaller."""

Flags = np.ndarray[Any, np.dtype[np.bool_]]
Evaluate = Callable[[Sequence[Expr]], Array]

BALANCED = 1e-6
"""How much of the largest load the equilibrium may miss before the motion is called impossible."""


@dataclass(frozen=True)
class Component:
    """One unknown of (5.18).

    Attributes:
        joint: its joint, or the scene's row.
        text: what it is, such as "moment about x" (axes of the joint frame on the parent) or "drive M".
        unique: whether the motion determines it.
        value: its size at the motion asked for, the least one where it is not unique; N or N m.
    """

    joint: str
    text: str
    unique: bool
    value: float


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

    @property
    def redundancy(self) -> int:
        """How many independent self-equilibrated reactions there are."""
        return len(self.components) - self.rank

    @property
    def words(self) -> tuple[str, ...]:
        """What is not unique, one line each, such as "loop1: moment about x is not unique"."""
        lines = [f"{one.joint}: {one.text} is not unique" for one in self.components if not one.unique]
        if not self.possible:
            lines.append(f"the motion is not one that the drives give: {self.missed:.3g} N of the equilibrium remain")
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
        q: joint positions, shape (nq,); quaternions of unit length.
        qd: velocities, shape (nv,); None for zeros.
        qdd: their rates, shape (nv,); None for zeros.
        parameters: values of the free parameters.
        length: characteristic length, m; None takes the largest distance between two joints at this position.
        t: time, s, where something depends on it.

    Raises:
        DerivationError: an argument has the wrong length, a free parameter has no value, or L is not positive.
    """
    workspace = Workspace(scene)
    hanging = Hanging(scene, workspace.tree, workspace.state)
    values = _values(hanging, q, qd, qdd, parameters or {}, t)
    system = equilibrium(hanging, whole=True)

    def at(entries: Sequence[Expr]) -> Array:
        return np.array(evaluate(list(entries), Floats(), values), dtype=np.float64)

    if length is None:
        length = _extent(hanging, at)
    if not length > 0:
        raise DerivationError(f"{scene.name}: length = {length}: a characteristic length is positive; give one in m")
    A = at([entry for row in system.matrix() for entry in row]).reshape(system.equations, len(system.unknowns))
    b = at(system.right())
    acts = [_act(system, unknown, at) for unknown in system.unknowns]
    x, N, rank, missed = _least(A, b, [_size(act, length) for act in acts], length)
    texts = [_text(unknown, act, scene) for unknown, act in zip(system.unknowns, acts, strict=True)]
    free = np.abs(N).max(axis=1, initial=0.0) > RANK
    components = tuple(
        Component(unknown.joint, text, not loose, float(value))
        for unknown, text, loose, value in zip(system.unknowns, texts, free, x, strict=True)
    )
    wrenches, unique = _wrenches(system, x, N, values)
    top = float(np.abs(b).max(initial=0.0))
    return Reactions(
        scene.name,
        float(length),
        system.equations,
        rank,
        components,
        tuple(hinge.joint.name for hinge in (*hanging.joints, *hanging.loops)),
        wrenches,
        unique,
        missed,
        missed <= BALANCED * max(top, 1e-300),
    )


def _values(
    hanging: Hanging,
    q: Sequence[float],
    qd: Sequence[float] | None,
    qdd: Sequence[float] | None,
    parameters: Mapping[str, float],
    t: float,
) -> dict[Expr, float]:
    """Return values of all symbols."""
    scene, state, graph = hanging.scene, hanging.state, hanging.graph
    values = {graph.symbol("t"): float(t)}
    for parameter in scene.parameters:
        if parameter.value is not None:
            values[graph.symbol(parameter.name)] = evaluate([express(parameter.value, graph)], Floats(), {})[0]
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


def _extent(hanging: Hanging, at: Evaluate) -> float:
    """Return the largest distance between two joints, m; 1 where there is none."""
    places = at([x for frame in frames(hanging) for x in frame.p]).reshape(-1, 3)
    largest = max((float(np.linalg.norm(a - b)) for a in places for b in places), default=0.0)
    return largest or 1.0


def _act(system: Equilibrium, unknown: Unknown, at: Evaluate) -> Array:
    """Return what an unknown does in its own joint at unit size: [force; moment], axes of the joint frame."""
    if not unknown.acts:
        return np.zeros(6)
    force, moment = unknown.acts[0][1]
    return at([*force, *moment])


def _size(act: Array, length: float) -> float:
    """Return the size of a wrench, N."""
    return float(np.hypot(np.linalg.norm(act[:3]), np.linalg.norm(act[3:]) / length)) or 1.0


def _least(A: Array, b: Array, sizes: Sequence[float], length: float) -> tuple[Array, Array, int, float]:
    """Return the least x, the null space of A, the rank, and what x leaves unbalanced, N."""
    rows = np.tile([1.0] * 3 + [1.0 / length] * 3, len(b) // 6)
    scales = np.array(sizes)
    scaled = (A * rows[:, None]) / scales
    U, s, Vt = np.linalg.svd(scaled, full_matrices=True)
    rank = int((s > RANK * s.max(initial=0.0)).sum())
    y = -Vt[:rank].T @ ((U[:, :rank].T @ (rows * b)) / s[:rank])
    missed = float(np.abs(scaled @ y + rows * b).max(initial=0.0))
    return y / scales, Vt[rank:].T / scales[:, None], rank, missed


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


def _wrenches(system: Equilibrium, x: Array, N: Array, values: dict[Expr, float]) -> tuple[Array, Flags]:
    """Return the whole wrench in every joint, axes of the child, and which entries are unique."""
    hanging = system.hanging
    symbols = [hanging.graph.symbol(f"x[{k}]") for k in range(len(system.unknowns))]
    whole = zip((*hanging.joints, *hanging.loops), transmitted(system, symbols), strict=False)
    turned = [hinge.on_child(one) for hinge, one in whole]
    entries = [entry for force, moment in turned for entry in (*force, *moment)]

    def with_sizes(sizes: Array) -> Array:
        known = values | dict(zip(symbols, sizes.tolist(), strict=True))
        return np.array(evaluate(entries, Floats(), known), dtype=np.float64)

    still = with_sizes(np.zeros(len(x)))
    loose = np.zeros(len(entries))
    for k in range(N.shape[1]):
        loose = np.maximum(loose, np.abs(with_sizes(N[:, k]) - still))
    return with_sizes(x).reshape(-1, 6), (loose <= RANK).reshape(-1, 6)
