"""Neighbours of a state of a closed scene, on its manifold, at sixty digits: what its derivatives are compared with.

Rows are those by differentiation, equations those of Lagrange: nothing of the recursion, and no partition of blocks.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

from symdyn.algebra.big import BigFloats
from symdyn.dynamics import LoopChoices, Workspace
from symdyn.dynamics.loops.constraint_rows import Constraints
from symdyn.dynamics.mechanism.state import TIME, quaternions
from symdyn.dynamics.outputs import constrained_outputs
from symdyn.graph import Expr, evaluate, reachable, tangents
from symdyn.scene import Scene

DIGITS = 60
STEP = "1e-20"


class Neighbours:
    """States of a scene on its manifold."""

    def __init__(self, scene: Scene, closing: LoopChoices = LoopChoices()) -> None:  # noqa: B008  frozen
        """Begin at no state."""
        self.w = Workspace(scene, closing)
        self.algebra = BigFloats(DIGITS)
        self.mp = self.algebra.context
        self.orders: dict[tuple[Expr, ...], list[Expr]] = {}
        self.position_rows, self.position_partition = self.w.loops.position_level
        self.partition = self.w.loops.decisions.partition

    @cached_property
    def rows(self) -> Constraints:
        return self.w.loops.differentiated

    @cached_property
    def parameters(self) -> dict[Expr, Any]:
        graph = self.w.graph
        found = {graph.symbol(name): self.mp.mpf(x) for name, x in self.w.loops.numbers.free.items()}
        for parameter in self.w.scene.parameters:
            if parameter.value is not None:
                found[graph.symbol(parameter.name)] = evaluate([parameter.value.express(graph)], self.algebra, {})[0]
        return found

    def values(self, entries: Sequence[Expr], known: Mapping[Expr, Any]) -> list[Any]:
        key = tuple(entries)
        order = self.orders.setdefault(key, reachable(key))
        return evaluate(key, self.algebra, self.parameters | dict(known), order)

    def solved(self, matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> list[Any]:
        return list(self.mp.lu_solve(self.mp.matrix([list(row) for row in matrix]), self.mp.matrix(list(right))))

    # States

    def moved(self, q: Sequence[Any], step: Mapping[int, Any]) -> list[Any]:
        """Return q after a step along velocities, quaternions of unit length."""
        symbols, along = self.w.state.q, self.w.directions.along
        entries = [(x, h) for k, x in step.items() for h in along[k].items()]
        rates = self.values([h for _, (_, h) in entries], dict(zip(symbols, q, strict=True)))
        result = dict(zip(symbols, q, strict=True))
        for (x, (symbol, _)), rate in zip(entries, rates, strict=True):
            result[symbol] += x * rate
        return self.unit([result[symbol] for symbol in symbols])

    def closed(self, q: Sequence[Any]) -> list[Any]:
        """Return the position near q at which the position-level rows vanish, only dependent positions moved."""
        residual = [self.rows.residual[k] for k in self.position_rows]
        unknown, along = self.position_partition.dependent, self.w.directions.along
        slopes = [tangents(residual, along[k]) for k in unknown]
        for _ in range(60 if unknown else 0):
            here = dict(zip(self.w.state.q, q, strict=True))
            r = self.values(residual, here)
            R = [self.values(column, here) for column in slopes]
            step = self.solved([list(row) for row in zip(*R, strict=True)], [-x for x in r])
            q = self.moved(q, dict(zip(unknown, step, strict=True)))
            if max(map(abs, step)) < self.mp.mpf(10) ** (8 - DIGITS):
                break
        return list(q)

    def following(
        self, symbols: Sequence[Expr], free: Sequence[Any], rest: Sequence[Expr], known: dict[Expr, Any]
    ) -> None:
        """Add dependent symbols with G x + rest = 0 to what is known, independent ones given."""
        kept = self.w.loops.decisions.independent_rows
        G = [self.values(self.rows.G[k], known) for k in kept]
        right = self.values(rest, known) if rest else [self.mp.mpf(0)] * len(kept)
        given = dict(zip(self.partition.independent, free, strict=True))
        x = [-sum((row[k] * v for k, v in given.items()), c) for row, c in zip(G, right, strict=True)]
        found = self.solved([[row[k] for k in self.partition.dependent] for row in G], x) if kept else []
        whole = given | dict(zip(self.partition.dependent, found, strict=True))
        known |= {symbols[k]: whole[k] for k in range(len(symbols))}

    def state(self, q: Sequence[Any], v: Sequence[Any], last: Sequence[Any], argument: str) -> dict[Expr, Any]:
        """Return a state on the manifold: q closed already, v independent velocities, forces or accelerations last."""
        s = self.w.state
        known = dict(zip(s.q, q, strict=True)) | {self.w.graph.symbol(TIME): self.mp.mpf("0.3")}
        self.following(s.qd, v, [], known)
        if argument == "tau":
            known |= dict(zip(s.tau, last, strict=True))
        else:
            self.following(s.qdd, last, [self.rows.bias[k] for k in self.w.loops.decisions.independent_rows], known)
        return known

    def drawn(self, seed: int = 1, still: bool = False) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
        """Return a closed position near the start and random velocities, forces, accelerations; zeros if still."""
        rng = random.Random(seed)
        q = [self.mp.mpf(x) for x in self.w.loops.decisions.assembly.q]
        n, m = self.w.state.n, len(self.partition.independent)

        def some(count: int, size: float = 1.0) -> list[Any]:
            return [self.mp.mpf(0 if still else rng.uniform(-size, size)) for _ in range(count)]

        step = dict(enumerate(some(n, 0.2)))
        return self.closed(self.moved(q, step)), some(m), some(n), some(m)

    def unit(self, q: Sequence[Any]) -> list[Any]:
        """Return q with quaternions of unit length."""
        result, names = list(q), list(self.w.scene.coordinates)
        for group in quaternions(self.w.scene):
            places = [names.index(name) for name in group]
            length = self.mp.sqrt(sum(result[k] ** 2 for k in places))
            for k in places:
                result[k] /= length
        return result

    # Differences

    def differences(
        self, entries: Sequence[Expr], q: Sequence[Any], v: Sequence[Any], last: Sequence[Any], argument: str
    ) -> list[list[Any]]:
        """Return central differences of entries along the manifold, a column for every direction."""
        h = self.mp.mpf(STEP)

        def column(at: Callable[[Any], dict[Expr, Any]]) -> list[Any]:
            there, here = (self.values(entries, at(x)) for x in (h, -h))
            return [(a - b) / (2 * h) for a, b in zip(there, here, strict=True)]

        def stepped(values: Sequence[Any], k: int, x: Any) -> list[Any]:
            return [value + x * (i == k) for i, value in enumerate(values)]

        places = [
            column(lambda x, k=k: self.state(self.closed(self.moved(q, {k: x})), v, last, argument))
            for k in self.position_partition.independent
        ]
        speeds = [column(lambda x, k=k: self.state(q, stepped(v, k, x), last, argument)) for k in range(len(v))]
        ends = [column(lambda x, k=k: self.state(q, v, stepped(last, k, x), argument)) for k in range(len(last))]
        return [*places, *speeds, *ends]

    def entries(self, output: str) -> list[Expr]:
        """Return what is differentiated, by Lagrange's equations."""
        if output == "inverse_dynamics":
            return constrained_outputs.lagrange_inverse(self.w)
        accelerations, multipliers = self.w.loops.lagrange_solution
        kept = len(self.w.loops.decisions.independent_rows)
        return list(accelerations) if output == "forward_dynamics" else list(multipliers[:kept])
