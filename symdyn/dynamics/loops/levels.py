"""A large graph evaluated at one state, level by level: all operations of one kind that need nothing else at once.

A node's level is one more than the highest of its operands'. A graph of many like parts, as of a mechanism with many
loops, has few levels, however many nodes: NumPy takes each in one call. Values are those of doubles; sines and the like
may differ from Python's in the last bit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array, Batches
from symdyn.errors import NoValueError
from symdyn.graph import Expr, Op, arithmetic, reachable

Places = npt.NDArray[np.intp]


class Levels:
    """Outputs of a graph, ready to be evaluated often."""

    def __init__(self, outputs: Sequence[Expr]) -> None:
        """Sort what the outputs need."""
        order = reachable(outputs)
        place = {node: k for k, node in enumerate(order)}
        level = [0] * len(order)
        steps: dict[tuple[int, Op], list[int]] = {}
        known: list[tuple[int, float]] = []
        self.symbols: dict[Expr, int] = {}
        numbers = Batches()
        for k, node in enumerate(order):
            if node.op is Op.SYMBOL:
                self.symbols[node] = k
            elif node.op is Op.CONSTANT:
                assert isinstance(node.value, Fraction), "a constant has a fraction"
                known.append((k, float(numbers.constant(node.value))))
            elif node.op is Op.PI:
                known.append((k, float(numbers.pi())))
            else:
                level[k] = 1 + max(level[place[arg]] for arg in node.args)
                steps.setdefault((level[k], node.op), []).append(k)
        self.size = len(order)
        self._start = np.zeros(self.size)
        for k, x in known:
            self._start[k] = x
        self._steps = [
            (
                op,
                np.array(ks, dtype=np.intp),
                np.array([[place[a] for a in order[k].args] for k in ks], dtype=np.intp).T,
            )
            for (_, op), ks in sorted(steps.items(), key=lambda item: (item[0][0], item[0][1].value))
        ]
        self._outputs = np.array([place[node] for node in outputs], dtype=np.intp)

    def at(self, values: Mapping[Expr, float]) -> Array:
        """Return the outputs at values of the symbols, shape (outputs,).

        Raises:
            KeyError: a symbol has no value.
            NoValueError: something is divided by zero, or has no real value.
        """
        x, numbers = self._start.copy(), Batches()
        apply = arithmetic(numbers)
        for node, k in self.symbols.items():
            x[k] = values[node]
        with np.errstate(divide="raise", invalid="raise", over="ignore", under="ignore"):
            try:
                for op, at, args in self._steps:
                    operands = [x[one] for one in args]
                    x[at] = apply[op](*operands) if op in apply else numbers.functions[op](*operands)
            except FloatingPointError as fault:
                raise NoValueError(f"{fault} in a formula of the scene") from None
        found: Array = x[self._outputs]
        return found
