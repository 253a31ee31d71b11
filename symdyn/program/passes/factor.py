"""Factoring: products that are used once give their common factor to the sum that they stand in.

    x a + x b = x (a + b)        x a - x b = x (a - b)        c a + c b = c (a + b), c constant

Each term but one saves a multiplication. A sum is read through the sums that are used nowhere else, so that the x of
x a + y + x b is seen. The factor that most terms share goes first, of several the one that was computed last, so that
what is known early stays together: s2 (m l + m' l') rather than m (l s2) + m' (l' s2). What is left in the parentheses
is a sum and is read again. What is known early, parameters and constants, is added and multiplied first:

    p + x + p' = (p + p') + x          p (x p') = (p p') x

A sum or product in which nothing is found keeps its shape, and with it its rounding.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from symdyn.graph import Expr, Graph, Op
from symdyn.program.passes.rebuild import Early, copy_node, use_counts

Term = tuple[bool, tuple[Expr, ...]]
"""Whether it is subtracted, and its factors on the new graph."""


@dataclass(frozen=True)
class Reading:
    """A sum or product that is not built yet: its terms on the new graph, and the old nodes that it is made of."""

    terms: list[Term]
    inside: list[Expr]


def factor(entries: Sequence[Expr], graph: Graph, parameters: Collection[str] = ()) -> list[Expr]:
    """Return the entries of one function on `graph`, common factors taken out; `parameters` are known early."""
    uses = use_counts(entries)
    early = Early(graph, parameters)
    new: dict[Expr, Expr] = {}
    readings: dict[Expr, Reading] = {}

    def value(node: Expr) -> Expr:
        """Return the node on the new graph; what was being read is built."""
        if node not in new:
            reading = readings.pop(node)
            found = _factored(reading.terms, graph, early)
            if found is None and _scattered(reading.terms, early):
                found = _total(reading.terms, graph, early)
            if found is not None:
                new[node] = found
            else:
                for inner in sorted(reading.inside, key=lambda one: one.index):
                    new[inner] = copy_node(inner, [new[arg] for arg in inner.args], graph)
        return new[node]

    def operand(node: Expr) -> Reading:
        """Return an operand as terms, read through if it is used nowhere else."""
        if uses[node] == 1 and node in readings:
            return readings.pop(node)
        return Reading([(False, (value(node),))], [])

    def factors(node: Expr) -> Reading:
        """Return an operand as factors, read through if it is a product and used nowhere else."""
        return operand(node) if node.op is Op.MUL else Reading([(False, (value(node),))], [])

    for node in uses:
        if node.op is Op.MUL:
            a, b = map(factors, node.args)
            readings[node] = Reading([(False, a.terms[0][1] + b.terms[0][1])], [*a.inside, *b.inside, node])
        elif node.op in (Op.ADD, Op.SUB):
            a, b = map(operand, node.args)
            a.terms.extend(_flipped(b.terms) if node.op is Op.SUB else b.terms)
            a.inside.extend((*b.inside, node))
            readings[node] = a
        elif node.op is Op.NEG:
            a = operand(node.args[0])
            readings[node] = Reading(_flipped(a.terms), [*a.inside, node])
        else:
            new[node] = copy_node(node, [value(arg) for arg in node.args], graph)
    return [value(entry) for entry in entries]


def _flipped(terms: list[Term]) -> list[Term]:
    return [(not minus, factors) for minus, factors in terms]


def _scattered(terms: list[Term], early: Early) -> bool:
    """Tell whether several terms, or several factors of one, are known early and others are not."""
    parts = [[all(one in early for one in factors) for _, factors in terms]]
    parts += [[one in early for one in factors] for _, factors in terms]
    return any(sum(known) > 1 and not all(known) for known in parts)


def _factored(terms: list[Term], graph: Graph, early: Early) -> Expr | None:
    """Return the sum of the terms with common factors taken out, None if there are none."""
    common = _most_common(terms)
    if common is None:
        return None
    while common is not None:
        shared = [(minus, _without(factors, common)) for minus, factors in terms if _splits(factors, common)]
        rest = [term for term in terms if not _splits(term[1], common)]
        inner = _factored(shared, graph, early)
        terms = [*rest, (False, (common, _total(shared, graph, early) if inner is None else inner))]
        common = _most_common(rest)
    return _total(terms, graph, early)


def _most_common(terms: list[Term]) -> Expr | None:
    """Return the factor of most products, None if each is in one product only."""
    tally: dict[Expr, int] = {}
    for _, factors in terms:
        if len(factors) > 1:
            for one in dict.fromkeys(factors):
                tally[one] = tally.get(one, 0) + 1
    best = max(tally, key=lambda one: (tally[one], one.index), default=None)
    return best if best is not None and tally[best] > 1 else None


def _splits(factors: tuple[Expr, ...], common: Expr) -> bool:
    return len(factors) > 1 and common in factors


def _without(factors: tuple[Expr, ...], one: Expr) -> tuple[Expr, ...]:
    place = factors.index(one)
    return factors[:place] + factors[place + 1 :]


def _total(terms: list[Term], graph: Graph, early: Early) -> Expr:
    """Return the sum of the terms, what is known early first, else from left to right."""
    totals = [graph.zero, graph.zero]
    for minus, factors in terms:
        first, *others = sorted(factors, key=lambda one: one not in early)
        product = first
        for one in others:
            product = graph.mul(product, one)
        late = product not in early
        totals[late] = graph.sub(totals[late], product) if minus else graph.add(totals[late], product)
    return graph.add(*totals)
