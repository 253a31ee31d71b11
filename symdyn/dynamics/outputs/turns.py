"""Turns in differentiation: each component of a vector that has turned is the other's derivative by the angle.

    x' = cos θ x - sin θ y        dx' = cos θ dx - sin θ dy - y' dθ
    y' = sin θ x + cos θ y        dy' = sin θ dx + cos θ dy + x' dθ

That takes six multiplications, forward and in reverse, where products by themselves take eight, and two more for the
rates of the sine and the cosine. In derivatives of turns there are turns again.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import NamedTuple

from symdyn.graph import Expr, Op, Slopes, operands, reachable


class _Term(NamedTuple):
    """± sin(angle) factor, or with the cosine."""

    sign: int
    op: Op
    angle: Expr
    factor: Expr

    @property
    def turned(self) -> _Term:
        """The derivative by the angle, the factor held."""
        return self._replace(sign=-self.sign, op=Op.SIN) if self.op is Op.COS else self._replace(op=Op.COS)

    @property
    def negative(self) -> _Term:
        return self._replace(sign=-self.sign)

    @property
    def by_factor(self) -> Expr:
        """The derivative by the factor."""
        circular = self.angle.graph.function(self.op, self.angle)
        return circular if self.sign > 0 else -circular


def turns(outputs: Sequence[Expr]) -> Slopes:
    """Return how to differentiate what `outputs` are made of: what has turned by its angle and by what it was before.

    Only what has its derivative by the angle among them is read so; all else is differentiated by its operands. Inputs
    have to be symbols or angles, for sines, cosines and their products are passed over.
    """
    nodes = reachable(outputs)
    there = {frozenset(terms): node for node in nodes for terms in _read(node)}

    def slopes(node: Expr) -> Iterable[tuple[Expr, Expr]]:
        for terms in _read(node):
            turned = frozenset(term.turned for term in terms)
            by_angle = there.get(turned)
            if by_angle is None and (against := there.get(frozenset(term.negative for term in turned))):
                by_angle = -against
            if by_angle is not None:  # last, so that what is turned anew stands side by side
                return [*((term.factor, term.by_factor) for term in terms), (terms[0].angle, by_angle)]
        return operands(node)

    return slopes


def _read(node: Expr) -> Iterator[tuple[_Term, ...]]:
    """Yield all ways to read a node as one or two products with sines and cosines of one angle."""
    if node.op in (Op.ADD, Op.SUB):
        signed = list(zip((1, -1 if node.op is Op.SUB else 1), node.args, strict=True))
    else:
        signed = [(1, node)]
    if all(one.op is Op.MUL for _, one in signed):
        ways = (
            [_Term(sign, x.op, x.args[0], y) for x, y in (one.args, one.args[::-1]) if x.op in (Op.SIN, Op.COS)]
            for sign, one in signed
        )
        yield from (terms for terms in product(*ways) if len({term.angle for term in terms}) == 1)
