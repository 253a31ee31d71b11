"""Strength: constants of one product meet, and dividing by one is multiplying.

c1 (c2 x) = (c1 c2) x        c1, c2 constant; their product is worked out when it is printed, to 50 digits
(c1 x) (c2 y) = (c1 c2) (x y)                                     where c1 x and c2 y are used nowhere else
c1 ((c2 x) y) = (c1 c2) (x y)                                     where (c2 x) y is used nowhere else
x / c = (1/c) x              c constant
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from symdyn.graph import Expr, Graph, Op
from symdyn.program.passes.rebuild import fixed, use_counts

DIV, MUL = Op.DIV, Op.MUL  # see `Op`


def strength(entries: Sequence[Expr], graph: Graph, parameters: Collection[str] = ()) -> list[Expr]:
    """Return the entries of one function on `graph`, constants together.

    Where no constants can meet, the entries stay where they are.
    """
    uses = use_counts(entries)
    constant = fixed(list(uses))
    if not _meet(uses, constant):
        return list(entries)
    new: dict[Expr, Expr] = {}
    split: dict[Expr, tuple[Expr, Expr]] = {}  # a product as (constant, rest), both on the new graph

    def parts(node: Expr, alone: bool) -> tuple[Expr, Expr]:
        """Return an operand as (constant, rest); `alone`: only if it is used nowhere else."""
        if node in constant:
            return new[node], graph.one
        if node in split and (not alone or uses[node] == 1):
            return split[node]
        return graph.one, new[node]

    for node in uses:
        args = [new[arg] for arg in node.args]
        if node in constant:
            new[node] = graph.copy(node, args)
        elif node.op is MUL:
            factors = [one for one in node.args if one not in constant]
            held = [new[one] for one in node.args if one in constant]
            if held and factors[0] in split and uses[factors[0]] == 1:
                factors = list(factors[0].args)
            split[node] = _joined([(c, graph.one) for c in held] + [parts(one, not held) for one in factors], graph)
            new[node] = graph.mul(*split[node])
        elif node.op is DIV and node.args[1] in constant:
            new[node] = graph.mul(graph.div(graph.one, args[1]), args[0])
        else:
            new[node] = graph.copy(node, args)
    return [new[entry] for entry in entries]


def _meet(uses: Mapping[Expr, int], constant: Collection[Expr]) -> bool:
    """Tell whether any constants can be brought together, or a constant divides; `uses` has arguments first."""
    multiples: set[Expr] = set()  # of constants
    for node in uses:
        if node.op is DIV and node.args[1] in constant:
            return True
        if node.op is not MUL or node in constant:
            continue
        rest = [one for one in node.args if one not in constant]
        if len(rest) == 2:
            if any(one in multiples and uses[one] == 1 for one in rest):
                return True
        else:
            inner = rest[0].args if rest[0].op is MUL and uses[rest[0]] == 1 else ()
            if not multiples.isdisjoint((*rest, *inner)):
                return True
            multiples.add(node)
    return False


def _joined(parts: Sequence[tuple[Expr, Expr]], graph: Graph) -> tuple[Expr, Expr]:
    """Return the product of several (constant, rest) as one."""
    constant = rest = graph.one
    for c, x in parts:
        constant, rest = graph.mul(constant, c), graph.mul(rest, x)
    return constant, rest
