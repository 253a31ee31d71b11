"""Numbers for what is decided by numbers: which entries vanish, which pivots are large."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra.numeric import Floats
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.graph import Expr, Graph, Op, evaluate, reachable
from symdyn.scene import Quantity, Scene, express

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class Samples:
    """Values of a scene's symbols; the same seed, the same values.

    Attributes:
        places: values by name that stand above all others at seeds 1, 2, …: of closed loops, an assembled position and
            then generic ones, since a position at which loops are open says nothing about a mechanism that closes them.
    """

    scene: Scene
    graph: Graph
    places: tuple[Mapping[str, float], ...] = ()

    def at(self, entries: Sequence[Expr], seed: int = 1) -> Array:
        """Return entries at seed 1, where the scene says that it starts, or at other positions, seeds from 2 on.

        What has no value there is drawn from 0.3 … 1.7; parameters have their values, quaternions the length 1.
        """
        values = {node: self._drawn(node, seed) for node in _symbols(entries)}
        known: dict[str, Quantity] = {p.name: p.value for p in self.scene.parameters if p.value is not None}
        if seed == 1:
            for joint in self.scene.moving:
                known |= dict(zip(joint.coordinates, joint.start, strict=False))
        for name, quantity in known.items():
            node = express(quantity, self.graph)
            inner = {x: values.get(x, self._drawn(x, seed)) for x in _symbols([node])}
            values[self.graph.symbol(name)] = evaluate([node], Floats(), inner)[0]
        if seed <= len(self.places):
            values |= {self.graph.symbol(name): value for name, value in self.places[seed - 1].items()}
        for group in quaternions(self.scene):
            nodes = [self.graph.symbol(name) for name in group]
            values |= {node: values.get(node, self._drawn(node, seed)) for node in nodes}
            length = sum(values[node] ** 2 for node in nodes) ** 0.5
            values |= {node: values[node] / length for node in nodes if length}
        return np.array(evaluate(list(entries), Floats(), values), dtype=np.float64)

    def _drawn(self, node: Expr, seed: int) -> float:
        return random.Random(f"{seed}:{node.value}").uniform(0.3, 1.7)


def _symbols(entries: Sequence[Expr]) -> list[Expr]:
    return [node for node in reachable(entries) if node.op is Op.SYMBOL]
