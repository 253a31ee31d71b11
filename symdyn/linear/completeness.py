"""Whether all positions of rest are known: counted exactly where the equations are polynomials over the rationals.

    I        ideal of the forces at rest, in sines s and cosines c of angles, s² + c² = 1, and in slides
    D        dimension of ℚ[s, c, x]/I: finite where positions of rest are isolated, complex ones too
    T        trace form, T_ij = tr(multiplication by b_i b_j), b a basis of monomials

The signature of T is the number of different real solutions, each a position, angles to whole turns. If as many were
found, there are no others. Nothing is rounded: numbers are fractions, and signs are those of exact coefficients, by
Descartes' rule, which counts exactly where all roots are real, as those of a symmetric matrix are.

Reference: Cox, Little and O'Shea, Using Algebraic Geometry (2005), chapter 2, section 5 (Hermite, Pedersen, Roy).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

from flint import fmpq, fmpq_mat

from symdyn.algebra import TrigonometricRing
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, substitute
from symdyn.linear.equilibrium import Equilibria
from symdyn.linear.prepared import Prepared
from symdyn.scene import SceneUnits
from symdyn.scene.values import FormulaError

CIRCLE = ("sin", "cos")

MOST_UNKNOWNS, MOST_SOLUTIONS = 4, 32
"""Sines, cosines and slides, and complex solutions, that are few."""


def complete(equilibria: Equilibria) -> bool:
    """Tell whether it is proved that a tree has no positions of rest but those found; False where nothing is proved."""
    prepared = equilibria.prepared
    if prepared.scene.is_closed or prepared.functions.multipliers or prepared.functions.inputs or equilibria.singular:
        return False
    if prepared.forces.tables or any(place.family for place in equilibria.places):
        return False
    equations = _equations(prepared)
    return equations is not None and _real_solutions(*equations) == len(equilibria.places)


def _equations(prepared: Prepared) -> tuple[list[dict[tuple[int, ...], Fraction]], int] | None:
    """Return polynomials that vanish at rest, coefficients by exponents, and how many unknowns; None if not."""
    w = prepared.functions.w
    values: dict[Expr, Expr] = {}
    for parameter in prepared.scene.parameters:
        if parameter.value is not None:
            values[w.graph.symbol(parameter.name)] = parameter.value.express(w.graph)
    values |= dict.fromkeys([*w.state.tau, *w.state.qd], w.graph.zero)
    try:
        forces = substitute(substitute(list(prepared.functions.statics.parts["f"][1]), values), values)
        forces = [one for one in forces if not one.is_zero]
        ring = TrigonometricRing(forces)
        polynomials = evaluate(forces, ring, ring.values(forces))
    except (DerivationError, FormulaError, ZeroDivisionError):
        return None
    named = {k for p in polynomials for powers in p.monoms() for k, power in enumerate(powers) if power}
    turning = {one.node for k, one in enumerate(ring.generators) if k in named and one.kind in CIRCLE}
    kept = [k for k, one in enumerate(ring.generators) if k in named or (one.kind in CIRCLE and one.node in turning)]
    generators = [ring.generators[k] for k in kept]
    units = dict(zip(w.state.q, SceneUnits(prepared.scene).coordinates, strict=True))
    for one in generators:
        wanted = "rad" if one.kind in CIRCLE and one.unit == 1 else "m" if one.kind == "symbol" else None
        if one.node is None or wanted is None or units.get(one.node) != wanted:
            return None
    n = len(generators)
    if not 0 < n <= MOST_UNKNOWNS:
        return None
    equations = [
        {tuple(int(powers[k]) for k in kept): Fraction(int(c.p), int(c.q)) for powers, c in p.terms()}
        for p in polynomials
    ]
    places = {(one.kind, one.node): k for k, one in enumerate(generators)}
    for q in w.state.q:
        if q in turning:
            squares = (tuple(2 * (j == places[kind, q]) for j in range(n)) for kind in CIRCLE)
            equations.append(dict.fromkeys(squares, Fraction(1)) | {(0,) * n: Fraction(-1)})
    return equations, n


def _real_solutions(equations: Sequence[dict[tuple[int, ...], Fraction]], n: int) -> int:
    """Return the number of different real solutions, -1 where there are infinitely many complex ones, or too many."""
    from sympy import QQ, Poly, groebner, symbols

    unknowns = symbols(f"z:{n}")
    polynomials = [Poly({powers: QQ(c.numerator, c.denominator) for powers, c in one.items()}, *unknowns, domain=QQ)
                   for one in equations]  # fmt: skip
    basis = groebner(polynomials, *unknowns, order="grevlex", domain=QQ)
    if basis.exprs == [1]:
        return 0
    if not basis.is_zero_dimensional:
        return -1
    leading = [one.monoms(order="grevlex")[0] for one in basis.polys]
    highest = [min(m[k] for m in leading if sum(m) == m[k] and m[k]) for k in range(n)]
    standard = [m for m in product(*(range(top) for top in highest))
                if not any(all(a >= b for a, b in zip(m, one, strict=True)) for one in leading)]  # fmt: skip
    if len(standard) > MOST_SOLUTIONS:
        return -1
    place = {m: k for k, m in enumerate(standard)}
    reduced: dict[tuple[int, ...], dict[int, Any]] = {}

    def coordinates(monomial: tuple[int, ...]) -> dict[int, Any]:
        if monomial not in reduced:
            rest = basis.reduce(Poly({monomial: QQ(1)}, *unknowns, domain=QQ))[1]
            terms = Poly(rest, *unknowns, domain=QQ).terms() if rest != 0 else []
            reduced[monomial] = {place[m]: c for m, c in terms}
        return reduced[monomial]

    def trace(monomial: tuple[int, ...]) -> Any:
        shifted = (coordinates(tuple(a + b for a, b in zip(monomial, m, strict=True))) for m in standard)
        return sum((row.get(k, 0) for k, row in enumerate(shifted)), start=0)

    entries = []
    for one in standard:
        for other in standard:
            value = trace(tuple(a + b for a, b in zip(one, other, strict=True)))
            entries.append(fmpq(int(value.p), int(value.q)) if value != 0 else fmpq(0))
    polynomial = fmpq_mat(len(standard), len(standard), entries).charpoly()
    signs = [c for c in (polynomial[k] for k in range(len(standard) + 1)) if c != 0]
    turned = [c * (-1) ** k for k, c in enumerate(polynomial[k] for k in range(len(standard) + 1)) if c != 0]
    return _changes(signs) - _changes(turned)


def _changes(signs: Sequence[Any]) -> int:
    return sum((a > 0) != (b > 0) for a, b in pairwise(signs))
