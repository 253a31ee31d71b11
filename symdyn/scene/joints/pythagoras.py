"""Lengths that are numbers: sin² x + cos² x = 1 and √n √n = n, in small polynomials.

A direction is often given by angles, as (cos a, sin a, 0), and the root that makes it a unit vector would stay in all
that is derived.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product

from symdyn.graph import Expr, Op

MOST, HIGHEST = 60, 12
"""Nodes or terms, and powers, beyond which nobody looks: the square of a direction has fewer."""

SIGNS = {Op.ADD: (1, 1), Op.SUB: (1, -1), Op.NEG: (-1,)}

Atom = tuple[Op, Expr]  # SIN or COS and its angle; SYMBOL and any other node
Powers = tuple[tuple[Atom, int], ...]
Terms = dict[Powers, Fraction]


def as_number(node: Expr) -> Fraction | None:
    """Return what a node is worth if that is one number everywhere, None if it is not, or too long to tell."""
    found: dict[Expr, Terms] = {}
    for here in _polynomial(node):
        terms = _terms(here, found)
        if terms is None or len(terms) > MOST:
            return None
        found[here] = terms
    if not found:
        return None
    (powers, value), *others = found[node].items() or [((), Fraction(0))]
    return None if others or powers else value


def _polynomial(node: Expr) -> list[Expr]:
    """Return the nodes that a polynomial is made of, arguments first; none of a long one."""
    seen, stack = {node}, [node]
    while stack and len(seen) <= MOST:
        here = stack.pop()
        more = {*here.args} - seen if here.op in SIGNS or here.op is Op.MUL else set()
        seen |= more
        stack += more
    return sorted(seen, key=lambda x: x.index) if len(seen) <= MOST else []


def _terms(node: Expr, found: dict[Expr, Terms]) -> Terms | None:
    """Return a node as a polynomial in sines, cosines and other nodes; None if it is long."""
    result: Terms = {}
    if isinstance(node.value, Fraction):
        _add(result, {}, node.value)
    elif node.op in SIGNS:
        for sign, arg in zip(SIGNS[node.op], node.args, strict=True):
            for powers, a in found[arg].items():
                _add(result, dict(powers), sign * a)
    elif node.op is Op.MUL:
        left, right = (found[arg] for arg in node.args)
        if len(left) * len(right) > MOST:
            return None
        for (p, a), (r, b) in product(left.items(), right.items()):
            both = dict(p)
            for atom, power in r:
                both[atom] = both.get(atom, 0) + power
            if sum(both.values()) > HIGHEST:
                return None
            _add(result, both, a * b)
    else:
        circular = node.op in (Op.SIN, Op.COS)
        _add(result, {(node.op, node.args[0]) if circular else (Op.SYMBOL, node): 1}, Fraction(1))
    return result


def _add(result: Terms, powers: dict[Atom, int], a: Fraction) -> None:
    """Add a term in normal form: no square of a sine, and none of the root of a number."""
    for atom, power in powers.items():
        op, node = atom
        if power < 2:
            continue
        rest = powers | {atom: power - 2}
        if op is Op.SIN:  # sin² = 1 - cos²
            cosine = (Op.COS, node)
            _add(result, rest, a)
            _add(result, rest | {cosine: rest.get(cosine, 0) + 2}, -a)
            return
        if node.op is Op.SQRT and isinstance(node.args[0].value, Fraction):
            _add(result, rest, a * node.args[0].value)
            return
    key = tuple(sorted(((x, n) for x, n in powers.items() if n), key=lambda item: (item[0][1].index, item[0][0].value)))
    total = result.pop(key, Fraction(0)) + a
    if total:
        result[key] = total
