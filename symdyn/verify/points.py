"""Values of nodes at random points, kept from claim to claim: the claims of one scene share most of their nodes."""

from __future__ import annotations

import random
from collections.abc import Collection, Sequence
from contextlib import suppress
from typing import Any

from symdyn.algebra import FiniteField, ManyPoints, Needs, RealBalls, Redraw
from symdyn.graph import Expr, Op, evaluate, reachable

MAX_DRAWS = 200
SPREAD = (2.0, 8.0, 64.0, 1024.0)  # widths of the ranges that numerical points are drawn from, one after the other
KEPT = 40  # points that are kept, of fields and of numbers; claims with few roots are looked at fewer
HELD = 300_000  # values that are kept at all points together; with more all are forgotten, for the sake of memory


class FirstPoints:
    """The first points that are drawn over all fields, which hardly ever are unlucky: looked at together."""

    def __init__(self, needs: Needs, primes: Sequence[int], seeds: Sequence[Sequence[int]]) -> None:
        """Start without values; `seeds` are those of point j of every prime, for each j."""
        fields = [[FiniteField(p, seed, needs) for p, seed in zip(primes, row, strict=True)] for row in seeds]
        self._points = ManyPoints(fields, _drawn_from, FiniteField.function_at)
        self._most = HELD // (len(primes) * len(seeds))

    @property
    def places(self) -> list[tuple[FiniteField, int, int]]:
        """Every field with the numbers of its point and of its prime, prime by prime."""
        fields = self._points.fields
        return [(fields[j][k], j, k) for k in range(len(fields[0])) for j in range(len(fields))]

    def values(self, outputs: Sequence[Expr]) -> list[tuple[int, ...]]:
        """Return the values of nodes of one graph.

        Raises:
            Redraw: a point is unlucky.
        """
        if len(self._points.known) > self._most:
            self._points.known.clear()
        return self._points.values(outputs)

    def look(self, order: Sequence[Expr]) -> None:
        """Find the values of nodes, each behind its arguments, up to where a point is unlucky."""
        if len(order) <= self._most:
            with suppress(Redraw):
                self._points.evaluate(order)

    def at(self, values: Sequence[tuple[int, ...]], j: int, k: int) -> list[int]:
        """Return values at one of `places`."""
        return [self._points.at(value, j, k) for value in values]


def _drawn_from(field: FiniteField, name: str) -> int:
    return random.Random(f"{field.seed}:{name}").randrange(field.p)


class FieldPoints:
    """Points over finite fields."""

    def __init__(self, needs: Needs) -> None:
        """Start without points; `needs` is what all claims need."""
        self._wanted = needs
        self._known: dict[tuple[int, int], tuple[FiniteField, dict[Expr, int]]] = {}

    def values(
        self, sides: Sequence[Sequence[Expr]], prime: int, seed: int, signs: int = 0
    ) -> tuple[FiniteField, list[list[int]]]:
        """Return the field of a prime with the point of a seed, and the values there of each of `sides`.

        Bit j of `signs` turns the sign of the j-th variable root; what is not usual is not kept.

        Raises:
            Redraw: the point is unlucky.
        """
        if signs:
            other, fresh = FiniteField(prime, seed, self._wanted, signs), dict[Expr, int]()
            return other, [field_values(side, other, fresh) for side in sides]
        field, known = self._known.get((prime, seed)) or (FiniteField(prime, seed, self._wanted), {})
        if len(self._known) < KEPT:
            self._known[prime, seed] = field, known
        _forget([values for _, values in self._known.values()])
        return field, [field_values(side, field, known) for side in sides]


def _forget(known: Collection[dict[Expr, Any]]) -> None:
    if sum(map(len, known)) > HELD:
        for values in known:
            values.clear()


def field_values(outputs: Sequence[Expr], field: FiniteField, known: dict[Expr, int] | None = None) -> list[int]:
    """Return the values of nodes of one graph at the point of a field; `known` ones are added to.

    Raises:
        Redraw: the point is unlucky.
    """
    known = {} if known is None else known
    rng, order = random.Random(), reachable(outputs, known)
    for node in order:
        if node.op is Op.SYMBOL and node not in known:
            rng.seed(f"{field.seed}:{node.value}")
            known[node] = rng.randrange(field.p)
    return field.evaluate(outputs, known, order)


class NumberPoints:
    """Points in numbers: they come as pairs x and -x, in ever wider ranges, at last all positive."""

    def __init__(self, algebra: RealBalls, positive: Collection[str]) -> None:
        """Start without points; symbols named in `positive` are never drawn negative."""
        self.algebra = algebra
        self._positive = positive
        self._known: dict[int, dict[Expr, Any]] = {}

    def values(self, outputs: Sequence[Expr], draw: int) -> list[Any]:
        """Return the values of nodes of one graph at a point.

        Raises:
            ValueError, ZeroDivisionError, OverflowError: they are not real there.
        """
        known = self._known.setdefault(draw, {}) if draw < KEPT else {}
        _forget(self._known.values())
        order = reachable(outputs, known)
        known |= {node: self._drawn(node, draw) for node in order if node.op is Op.SYMBOL and node not in known}
        return evaluate(outputs, self.algebra, known, order, known)

    def _drawn(self, symbol: Expr, draw: int) -> Any:
        rng = random.Random(f"{draw // 2}:{symbol.value}")
        signed = draw < MAX_DRAWS // 2 and symbol.value not in self._positive
        sign = rng.choice((-1, 1)) * (-1) ** draw if signed else 1
        width = SPREAD[draw // 8 % len(SPREAD)]
        return self.algebra.number(sign * rng.uniform(0.25, width))
