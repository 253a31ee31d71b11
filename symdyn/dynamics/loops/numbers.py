"""A scene's loops as numbers, for what is decided numerically: assembly, rank, conditioning, the choice of pivots.

    r(q), R      residuals of all loops and their rates R u
    G(q)         rows of all loops and of the scene
    H(q)         q̇ = H u

A step δ along the velocities moves q by H δ, quaternions stay of unit length.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from symdyn.algebra.numeric import Floats
from symdyn.dynamics.directions import Directions, directions
from symdyn.dynamics.loops.rows import Constraints, recursive
from symdyn.dynamics.state import State, quaternions, state_symbols
from symdyn.dynamics.tree import Tree, build_tree
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, Op, evaluate, reachable, tangents
from symdyn.scene import Quantity, Scene, express
from symdyn.scene.start import starting_position

Array = np.ndarray[Any, np.dtype[np.float64]]


class Numbers:
    """Functions of q as numbers, at values of the parameters."""

    def __init__(
        self,
        scene: Scene,
        graph: Graph,
        state: State,
        tree: Tree,
        directions: Directions,
        constraints: Constraints,
        free: Mapping[str, float],
    ) -> None:
        """Prepare a scene; `free` are values of its free parameters."""
        self.scene, self.graph, self.state, self.tree = scene, graph, state, tree
        self.constraints, self.directions = constraints, directions
        self.free = dict(free)
        self._orders: dict[tuple[Expr, ...], list[Expr]] = {}  # Newton's method asks for the same entries many times

    @cached_property
    def parameters(self) -> dict[Expr, float]:
        """Values of all parameters."""
        values = {self.graph.symbol(name): value for name, value in self.free.items()}
        for parameter in self.scene.parameters:
            if parameter.value is not None:
                (value,) = evaluate([express(parameter.value, self.graph)], Floats(), {})
                values[self.graph.symbol(parameter.name)] = value
        return values

    def value(self, quantity: Quantity) -> float:
        """Return the value of a quantity in parameters.

        Raises:
            DerivationError: it has no real value with these parameters.
        """
        try:
            return float(evaluate([express(quantity, self.graph)], Floats(), self.parameters)[0])
        except (ArithmeticError, ValueError) as fault:
            raise DerivationError(f"{self.scene.name}: {quantity} has no real value with these parameters") from fault

    def at(self, entries: Sequence[Expr], q: Array, others: Mapping[Expr, float] | None = None) -> Array:
        """Return the values of entries at q, and at values of other symbols.

        Raises:
            DerivationError: a formula has no real value there.
        """
        values = self.parameters | dict(zip(self.state.q, q.tolist(), strict=True)) | dict(others or {})
        wanted = tuple(entries)
        order = self._orders.get(wanted) or self._orders.setdefault(wanted, reachable(wanted))
        try:
            return np.array(evaluate(wanted, Floats(), values, order), dtype=np.float64)
        except (ArithmeticError, ValueError) as fault:
            raise DerivationError(f"{self.scene.name}: a formula has no real value at q = {q.tolist()}") from fault

    def residual(self, q: Array) -> Array:
        """Return r(q), every loop's, m or 1."""
        return self.at(self.constraints.residual, q)

    @cached_property
    def _rates(self) -> list[Expr]:
        columns = [tangents(self.constraints.residual, along) for along in self.directions.along]
        return [column[k] for k in range(len(self.constraints.residual)) for column in columns]

    def residual_rates(self, q: Array) -> Array:
        """Return R, shape (m, nv)."""
        return self.at(self._rates, q).reshape(-1, self.state.n)

    def jacobian(self, q: Array) -> Array:
        """Return G, shape (m, nv)."""
        return self.at([entry for row in self.constraints.G for entry in row], q).reshape(-1, self.state.n)

    @cached_property
    def _kinematic_map(self) -> list[Expr]:
        return [along.get(q, self.graph.zero) for q in self.state.q for along in self.directions.along]

    def moved(self, q: Array, step: Array) -> Array:
        """Return q after a step along the velocities, shape (nv,)."""
        result = q + self.at(self._kinematic_map, q).reshape(-1, self.state.n) @ step
        names = list(self.scene.coordinates)
        for group in quaternions(self.scene):
            first = names.index(group[0])
            result[first : first + 4] /= np.linalg.norm(result[first : first + 4])
        return result

    def start(self) -> Array:
        """Return where the scene says that it starts; zeros, and unit quaternions, where it says nothing."""
        return self.normalised(np.array([self.value(one) for one in starting_position(self.scene)]))

    def normalised(self, q: Array) -> Array:
        """Return q with quaternions of unit length; (1, 0, 0, 0) for one that is zero."""
        q, names = q.astype(np.float64), list(self.scene.coordinates)
        for group in quaternions(self.scene):
            first = names.index(group[0])
            length = np.linalg.norm(q[first : first + 4])
            q[first : first + 4] = q[first : first + 4] / length if length else (1.0, 0.0, 0.0, 0.0)
        return q

    def drawn(self, seed: int) -> Array:
        """Return random coordinates, about one turn or one metre wide; the same seed, the same ones."""
        rng = random.Random(f"{self.scene.name}:{seed}")
        return self.normalised(np.array([rng.uniform(-2.0, 2.0) for _ in self.state.q]))


def numbers_of(scene: Scene) -> Numbers:
    """Return a scene on a graph of its own, without values of its free parameters."""
    graph = Graph()
    state = state_symbols(scene, graph)
    tree = build_tree(scene, graph)
    return Numbers(scene, graph, state, tree, directions(scene, graph), recursive(scene, tree, state), {})


def unbound(scene: Scene, entries: Sequence[Expr]) -> list[str]:
    """Return the names of the free parameters that entries depend on."""
    names = {node.value for node in reachable(entries) if node.op is Op.SYMBOL}
    return [parameter.name for parameter in scene.free_parameters if parameter.name in names]
