"""Passes: exact rewritings of one function's entries that lower what they cost. One file each, its algebra on top.

A pass takes the entries of a function, an empty graph and the names of the parameters, and returns equal entries on
that graph, or the same entries where it finds nothing. `optimise` applies passes function by function and keeps a
result only where it costs no more than what it had, in all and in what depends on the state, so that no count ever
rises.

One division by a divisor in place of several is no pass: it rounds twice where a division rounds once, and forward
dynamics of 6 and 7 axes took 1 % longer with it for one state, 1 % less in a batch of 512-bit vectors. Nor are
constants brought together across other factors, c1 ((c2 x) y), which saved 0.4 % of the operations of all examples, nor
are negations led into differences, which saved none that is counted.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

from symdyn.dynamics import Function
from symdyn.dynamics.outputs import Counts
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph
from symdyn.program.passes.factor import factor

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
        raise DerivationError(f"there is no pass {unknown[0]!r}; there are {', '.join(PASSES)}")
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


__all__ = ["DEFAULT", "PASSES", "Pass", "factor", "optimise"]
