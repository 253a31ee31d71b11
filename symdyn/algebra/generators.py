"""The generators of a ring of trigonometric polynomials: which ones given nodes need, and in which order."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm

from symdyn.errors import DerivationError
from symdyn.graph import FUNCTIONS, Expr, LinearForm, Op, linear_form, reachable
from symdyn.graph.identities import SMALL_PRIMES

COSINES = {  # part of a turn -> 4 cos = a + b √2 + c √3 + d √6
    Fraction(0): (4, 0, 0, 0),
    Fraction(1, 24): (0, 1, 0, 1),
    Fraction(1, 12): (0, 0, 2, 0),
    Fraction(1, 8): (0, 2, 0, 0),
    Fraction(1, 6): (2, 0, 0, 0),
    Fraction(5, 24): (0, -1, 0, 1),
    Fraction(1, 4): (0, 0, 0, 0),
}


@dataclass(frozen=True)
class Generator:
    """What a generator of the ring stands for.

    Attributes:
        kind: "sin", "cos", "symbol", "pi", "root", "inverse", "function" or "cyclotomic".
        node: the angle's atom (None: 1 rad), the symbol, the root or the function.
        unit: sine and cosine are those of unit · node.
        number: the prime under a root, the order m of a cyclotomic generator, the slot of an inverse; else 0.
    """

    kind: str
    node: Expr | None = None
    unit: Fraction = Fraction(1)
    number: int = 0


Totals = Mapping[Expr, tuple[int, Expr | None]]  # see `TrigonometricRing`


def atoms_of(form: LinearForm, totals: Totals) -> list[tuple[Expr | None, Fraction]]:
    """Return an angle without its multiple of π as Σ coefficient · atom (None: 1 rad); q = sign (u(q) - u(below))."""
    found: dict[Expr | None, Fraction] = {None: form.constant}
    for atom, coefficient in form.terms:
        sign, below = totals.get(atom, (1, None))
        found[atom] = found.get(atom, Fraction(0)) + sign * coefficient
        if below is not None:
            found[below] = found.get(below, Fraction(0)) - sign * coefficient
    return [(atom, coefficient) for atom, coefficient in found.items() if coefficient]


def angle_units(nodes: Sequence[Expr], totals: Totals) -> tuple[dict[Expr | None, Fraction], Fraction]:
    """Return each angle atom's unit (None: 1 rad), and the unit of the multiples of π."""
    units: dict[Expr | None, Fraction] = {}
    turn = Fraction(1)
    for node in nodes:
        if node.op in (Op.SIN, Op.COS):
            form = linear_form(node.args[0])
            turn = _divisor(turn, form.turns)
            for atom, coefficient in atoms_of(form, totals):
                units[atom] = _divisor(units.get(atom, Fraction(0)), coefficient)
    return units, turn


def _divisor(a: Fraction, b: Fraction) -> Fraction:
    """Return the greatest fraction of which both are integer multiples."""
    scale = lcm(a.denominator, b.denominator)
    return Fraction(gcd(int(a * scale), int(b * scale)), scale)


def choose_generators(nodes: Sequence[Expr], units: dict[Expr | None, Fraction], order: int) -> Iterable[Generator]:
    """Yield the generators, those that relations eliminate first (the ordering is lexicographic)."""
    atoms = sorted(units, key=lambda atom: -1 if atom is None else atom.index)
    for atom in atoms:
        yield Generator("sin", atom, units[atom])
    radicands = [node.args[0] for node in nodes if node.op is Op.SQRT]
    for node in reversed(nodes):
        if node.op is Op.SQRT and node.args[0].op is not Op.CONSTANT:
            yield Generator("root", node)
    wanted = {p for x in radicands if isinstance(x.value, Fraction) for p in prime_factors(x.value)}
    below = reachable([node.args[1] for node in nodes if node.op is Op.DIV])
    slots = sum(node.op is Op.DIV for node in nodes) + 2 * len(below)
    for slot in range(slots, 0, -1):
        yield Generator("inverse", number=slot)
    radical = order in (4, 8, 12, 24)
    if radical:
        wanted |= {p for p, m in ((2, 8), (3, 12)) if order % m == 0}
    for p in sorted(wanted):
        if radical or order % (8 if p == 2 else p):
            yield Generator("root", number=p)
    if not radical:
        yield Generator("cyclotomic", number=order)
    for atom in atoms:
        yield Generator("cos", atom, units[atom])
    for node in nodes:
        if node.op in FUNCTIONS and node.op not in (Op.SIN, Op.COS, Op.SQRT):
            yield Generator("function", node)
    if any(node.op is Op.PI for node in nodes):
        yield Generator("pi")
    for node in nodes:
        if node.op is Op.SYMBOL:
            yield Generator("symbol", node)


def prime_factors(value: Fraction) -> list[int]:
    """Return primes, and perhaps one unfactored rest, whose product is numerator · denominator > 0."""
    n, found = value.numerator * value.denominator, []
    for prime in SMALL_PRIMES:
        while n % prime == 0:
            n //= prime
            found.append(prime)
    return found + ([n] if n > 1 else [])


def refuse_variables(nodes: Sequence[Expr], variables: Sequence[Expr]) -> None:
    """Raise DerivationError if a function, a root or a denominator needs one of `variables`."""
    moving = set(variables)
    for node in nodes:
        if node.op is Op.SIN or node.op is Op.COS:
            guilty = [atom for atom, _ in linear_form(node.args[0]).terms if atom.op is not Op.SYMBOL]
        elif node.op is Op.DIV:
            guilty = [node.args[1]]
        else:
            guilty = list(node.args) if node.op in FUNCTIONS else []
        for found in guilty:
            names = [str(n.value) for n in reachable([found]) if n in moving]
            if names:
                raise DerivationError(
                    f"{node.op.name.lower()} of an expression in {', '.join(names)} is no trigonometric "
                    "polynomial, so it has no closed form; generated code (NumPy, C) has no such limit"
                )
