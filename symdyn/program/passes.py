"""Passes: exact rewritings of one function's entries that lower what they cost.

A pass takes the entries of a function, an empty graph and the names of the parameters, and returns equal entries on
that graph, or the same entries where it finds nothing. `optimise` applies passes function by function and keeps a
result only where it costs no more than what it had, in all and in what depends on the state, so that no count ever
rises.

`factor` gives the common factor of products that are used once to the sum that they stand in:

    x a + x b = x (a + b)        x a - x b = x (a - b)        c a + c b = c (a + b), c constant

Each term but one saves a multiplication. A sum is read through the sums that are used nowhere else, so that the x of
x a + y + x b is seen. The factor that most terms share goes first, of several the one that was computed last, so that
what is known early stays together: s2 (m l + m' l') rather than m (l s2) + m' (l' s2). What is left in the parentheses
is a sum and is read again. What is known early, parameters and constants, is added and multiplied first:

    p + x + p' = (p + p') + x          p (x p') = (p p') x

A sum or product in which nothing is found keeps its shape, and with it its rounding.

Gain (operations; ns one state a call, a state of a batch); of all functions of the examples, 2 % of the operations:

                          puma560                 arm7                   chain8
    inverse dynamics      -0.3 %; -4 %, -2 %      -0.2 %; +1 %,  0       -0.6 %; 0, -1 %
    forward dynamics      -2.4 %;  0,   -1 %      -0.9 %; +1 %, -4 %     -0.9 %; 0, +2 %

One division by a divisor in place of several is no pass: it rounds twice where a division rounds once, and forward
dynamics of 6 and 7 axes took 1 % longer with it for one state, 1 % less in a batch of 512-bit vectors. Nor are
constants brought together across other factors, c1 ((c2 x) y), which saved 0.4 % of the operations of all examples, nor
are negations led into differences, which saved none that is counted.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics import Function
from symdyn.dynamics.outputs import Counts
from symdyn.errors import DerivationError, choice
from symdyn.graph import Expr, Graph, Op, reachable


def use_counts(entries: Sequence[Expr], needed: Sequence[Expr] | None = None) -> dict[Expr, int]:
    """Return how many operations and entries use each node; a sign is no operation, its operand is used in its place.

    The nodes come arguments first: all of them, or those that are `needed`.
    """
    uses = dict.fromkeys(reachable(entries) if needed is None else needed, 0)
    for entry in entries:
        if entry in uses:
            uses[entry] += 1
    for node in reversed(uses):
        more = uses[node] if node.op is NEG else 1
        for arg in node.args:
            if arg in uses:
                uses[arg] += more
    return uses


class Early:
    """Tells which nodes of a growing graph are known early: constants and what depends on early symbols alone."""

    def __init__(self, graph: Graph, symbols: Collection[str]) -> None:
        """Start with an empty graph or a full one; `symbols` are names."""
        self._nodes = graph.nodes
        self._symbols = frozenset(symbols)
        self._known: list[bool] = []

    def __contains__(self, node: Expr) -> bool:
        """Tell whether a node of the graph is known early."""
        known = self._known
        while len(known) <= node.index:
            new = self._nodes[len(known)]
            known.append(new.value in self._symbols if new.op is SYMBOL else all(known[a.index] for a in new.args))
        return known[node.index]


ADD, MUL, NEG, SUB, SYMBOL = Op.ADD, Op.MUL, Op.NEG, Op.SUB, Op.SYMBOL  # see `Op`

Term = tuple[bool, tuple[Expr, ...]]
"""Whether it is subtracted, and its factors."""


@dataclass(slots=True)
class FactorReading:
    """A sum or product that is not settled yet: its terms, and the nodes that it is made of."""

    terms: list[Term]
    inside: list[Expr]


def factor(entries: Sequence[Expr], graph: Graph, parameters: Collection[str] = ()) -> list[Expr]:
    """Return the entries of one function on `graph`, common factors taken out; `parameters` are known early.

    Where nothing is found the entries stay where they are, and nothing is built.
    """
    settled, found = _read(entries, frozenset(parameters))
    if not found:
        return list(entries)
    early = Early(graph, parameters)
    new: dict[Expr, Expr] = {}
    for node in settled:
        terms = found.get(node)
        if terms is None:
            new[node] = graph.copy(node, [new[arg] for arg in node.args])
        else:
            terms = [(minus, tuple([new[one] for one in factors])) for minus, factors in terms]
            sum_ = _factored(terms, graph, early)
            new[node] = _total(terms, graph, early) if sum_ is None else sum_
    return [new[entry] for entry in entries]


def _read(entries: Sequence[Expr], symbols: Collection[str]) -> tuple[list[Expr], dict[Expr, list[Term]]]:
    """Return the nodes to build, in order, and the terms of those among them that are to be written otherwise."""
    uses = use_counts(entries)
    early: set[Expr] = set()
    settled: list[Expr] = []
    found: dict[Expr, list[Term]] = {}
    readings: dict[Expr, FactorReading] = {}

    def settle(node: Expr) -> None:
        """Decide what is built for `node`, if it is being read."""
        reading = readings.pop(node, None)
        if reading is None:
            return
        if _is_worth_writing_otherwise(reading.terms, early):
            found[node] = reading.terms
            settled.append(node)
        else:
            settled.extend(sorted(reading.inside, key=lambda one: one.index))

    def operand(node: Expr) -> FactorReading:
        """Return an operand as terms, read through if it is used nowhere else."""
        if uses[node] == 1 and node in readings:
            return readings.pop(node)
        settle(node)
        return FactorReading([(False, (node,))], [])

    for node in uses:
        op, args = node.op, node.args
        if op is MUL:
            known, inside = True, list[Expr]()
            product: tuple[Expr, ...] = ()
            for arg in args:
                known = known and arg in early
                if arg.op is MUL and uses[arg] == 1:
                    reading = readings.pop(arg)
                    product += reading.terms[0][1]
                    inside += reading.inside
                else:
                    settle(arg)
                    product += (arg,)
            inside.append(node)
            readings[node] = FactorReading([(False, product)], inside)
        elif op is ADD or op is SUB:
            known = args[0] in early and args[1] in early
            a, b = operand(args[0]), operand(args[1])
            a.terms.extend(_flipped(b.terms) if op is SUB else b.terms)
            a.inside.extend((*b.inside, node))
            readings[node] = a
        elif op is NEG:
            known = args[0] in early
            a = operand(args[0])
            readings[node] = FactorReading(_flipped(a.terms), [*a.inside, node])
        else:
            known = node.value in symbols if op is SYMBOL else all(arg in early for arg in args)
            for arg in args:
                settle(arg)
            settled.append(node)
        if known:
            early.add(node)
    for entry in entries:
        settle(entry)
    return settled, found


def _flipped(terms: list[Term]) -> list[Term]:
    return [(not minus, factors) for minus, factors in terms]


def _is_worth_writing_otherwise(terms: list[Term], early: Collection[Expr]) -> bool:
    """Tell whether terms share a factor, or whether what is known early is scattered among them."""
    if len(terms) == 1 and len(terms[0][1]) < 3:
        return False
    return _most_common(terms) is not None or _scattered(terms, early)


def _scattered(terms: list[Term], early: Collection[Expr]) -> bool:
    """Tell whether several terms, or several factors of one, are known early and others are not."""
    known = [(sum([one in early for one in factors]), len(factors)) for _, factors in terms]
    whole = sum([some == every for some, every in known])
    return 1 < whole < len(terms) or any(1 < some < every for some, every in known)


def _factored(terms: list[Term], graph: Graph, early: Early) -> Expr | None:
    """Return the sum of the terms with common factors taken out, None if there are none."""
    common = _most_common(terms)
    if common is None:
        return None
    while common is not None:
        split = [(minus, factors, factors.index(common)) for minus, factors in terms if _splits(factors, common)]
        shared = [(minus, factors[:k] + factors[k + 1 :]) for minus, factors, k in split]
        rest = [term for term in terms if not _splits(term[1], common)]
        inner = _factored(shared, graph, early)
        terms = [*rest, (False, (common, _total(shared, graph, early) if inner is None else inner))]
        common = _most_common(rest)
    return _total(terms, graph, early)


def _most_common(terms: list[Term]) -> Expr | None:
    """Return the factor of most products, None if each is in one product only."""
    products = [factors for _, factors in terms if len(factors) > 1]
    if len(products) < 2 or len({one for factors in products for one in factors}) == sum(map(len, products)):
        return None
    tally: dict[Expr, int] = {}
    for factors in products:
        for one in dict.fromkeys(factors):
            tally[one] = tally.get(one, 0) + 1
    best = max(tally, key=lambda one: (tally[one], one.index))
    return best if tally[best] > 1 else None


def _splits(factors: tuple[Expr, ...], common: Expr) -> bool:
    return len(factors) > 1 and common in factors


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


Pass = Callable[[Sequence[Expr], Graph, Collection[str]], list[Expr]]

PASSES: Mapping[str, Pass] = {"factor": factor}
"""In the order in which they are applied."""

DEFAULT = tuple(PASSES)

PARAMS = "params"

ROUNDS = 3
"""How often a pass is applied at most; a second time pays where factoring once has made new products."""


def optimise(function: Function, passes: Sequence[str] = DEFAULT) -> Function:
    """Return `function` after the passes, its entries on a graph of their own; the arguments stay where they were.

    Raises:
        DerivationError: there is no such pass in `PASSES`.
    """
    unknown = [name for name in passes if name not in PASSES]
    if unknown:
        raise DerivationError(f"there is no pass {unknown[0]!r}; {choice(unknown[0], PASSES)}")
    parameters = [str(one.value) for a in function.arguments if a.name == PARAMS for one in a.symbols]
    costs = _costs(function)
    for name in passes:
        for _ in range(ROUNDS):
            found = replace(function, entries=tuple(PASSES[name](function.entries, Graph(), parameters)))
            if found.entries == function.entries:
                break
            lower = _costs(found)
            if all(new <= old for new, old in zip(lower, costs, strict=True)):
                function = found
            else:
                break
            if lower == costs:
                break
            costs = lower
    return function


def _costs(function: Function) -> tuple[int, int]:
    """Return what a call costs, and what of it depends on the state."""
    binding = Counts.by_binding(function)
    total = sum(binding.values(), Counts())
    return total.cost, (total - binding[PARAMS]).cost
