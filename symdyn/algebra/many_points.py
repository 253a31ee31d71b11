"""Several points of several prime fields at once: one walk through a graph instead of one a point.

By the Chinese remainder theorem a number mod p₁ p₂ … is one of each field, and +, -, × and ÷ of such numbers are those
of all fields together. So point j of all primes is one number, and a node's value is a tuple of as many numbers as
there are points a prime. What is no field operation (sines, roots, what is uninterpreted) is taken apart, asked of each
field, and put together again: the values are those of the fields one by one, to the last digit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import prod

from symdyn.algebra.finite_field import FiniteField, Redraw
from symdyn.graph import Expr, Op, reachable

Residues = tuple[int, ...]
"""A value at all points: number j is that of point j of every prime."""

Function = Callable[[FiniteField, Expr, Sequence[int], Mapping[Expr, int]], int]
"""Value of a node in a field, for the values of its arguments, and those of the nodes before it."""


class ManyPoints:
    """Values of nodes at points (prime, j); what is computed once is kept."""

    def __init__(
        self,
        fields: Sequence[Sequence[FiniteField]],
        symbol: Callable[[FiniteField, str], int],
        function: Function,
    ) -> None:
        """Start without values.

        Args:
            fields: those of point j of every prime, in the order of the primes, for each j.
            symbol: value of a symbol of this name in a field.
            function: value of a node that is no field operation.
        """
        self.fields = fields
        self.known: dict[Expr, Residues] = {}
        self._symbol, self._function = symbol, function
        primes = [field.p for field in fields[0]]
        self.modulus = prod(primes)
        rests = [self.modulus // p for p in primes]
        self._units = [rest * pow(rest, -1, p) for rest, p in zip(rests, primes, strict=True)]

    def at(self, value: Residues, j: int, k: int) -> int:
        """Return a value at point j of prime k."""
        return value[j] % self.fields[j][k].p

    def values(self, outputs: Sequence[Expr]) -> list[Residues]:
        """Return the values of nodes of one graph.

        Raises:
            Redraw: a point is unlucky.
        """
        known = self.known
        self.evaluate(reachable(outputs, known))
        return [known[node] for node in outputs]

    def evaluate(self, order: Sequence[Expr]) -> None:
        """Add the values of nodes, each behind its arguments.

        Raises:
            Redraw: a point is unlucky.
        """
        known, m = self.known, self.modulus
        for node in order:
            if node in known:
                continue
            op, args = node.op, node.args
            if op is Op.MUL:
                known[node] = tuple([x * y % m for x, y in zip(known[args[0]], known[args[1]], strict=True)])
            elif op is Op.ADD:
                known[node] = tuple([(x + y) % m for x, y in zip(known[args[0]], known[args[1]], strict=True)])
            elif op is Op.SUB:
                known[node] = tuple([(x - y) % m for x, y in zip(known[args[0]], known[args[1]], strict=True)])
            elif op is Op.NEG:
                known[node] = tuple([-x % m for x in known[args[0]]])
            elif op is Op.DIV:
                known[node] = tuple([self._quotient(*both) for both in zip(*map(known.get, args), strict=True)])
            else:
                known[node] = self._each(node)

    def _quotient(self, a: int, b: int) -> int:
        try:
            return a * pow(b, -1, self.modulus) % self.modulus
        except ValueError:  # zero in one of the fields
            raise Redraw from None

    def _each(self, node: Expr) -> Residues:
        """Return the value of a leaf or of a function, asked of every field."""
        return tuple(
            sum(unit * self._one(node, j, k) for k, unit in enumerate(self._units)) % self.modulus
            for j in range(len(self.fields))
        )

    def _one(self, node: Expr, j: int, k: int) -> int:
        field = self.fields[j][k]
        if node.op is Op.CONSTANT:
            return field.constant(node.value)  # type: ignore[arg-type]
        if node.op is Op.PI:
            return field.pi()
        if node.op is Op.SYMBOL:
            return self._symbol(field, str(node.value))
        there = _There(self, j, k)
        return self._function(field, node, [there[arg] for arg in node.args], there)


class _There(Mapping[Expr, int]):
    """The values of all nodes at one point."""

    def __init__(self, points: ManyPoints, j: int, k: int) -> None:
        self._points, self._j, self._k = points, j, k

    def __getitem__(self, node: Expr) -> int:
        return self._points.at(self._points.known[node], self._j, self._k)

    def __iter__(self) -> Iterator[Expr]:
        return iter(self._points.known)

    def __len__(self) -> int:
        return len(self._points.known)
