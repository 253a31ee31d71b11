"""The generators of a ring of trigonometric polynomials: which ones given nodes need, and in which order.

An angle is a multiple of π/12, which has an exact sine, plus multiples of atoms. An atom is a coordinate, a parameter,
1 rad (None) or π itself, and has one unit or more, each with a sine and a cosine of its own:

    coordinates, parameters,   the greatest common divisor of coefficients that are small multiples of it: q/2 and q
    coordinates times them     share the unit ½; q and 100 q do not, and 101 q is their sum
    constants                  one unit for each angle that occurs, 0.3 rad, π/180; π up to quarter turns and sign
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from math import gcd, inf, isqrt, lcm

from flint import fmpz

from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import SMALL_PRIMES, Expr, Op, reachable, tangents

COSINES = {  # part of a turn -> 4 cos = a + b √2 + c √3 + d √6
    Fraction(0): (4, 0, 0, 0),
    Fraction(1, 24): (0, 1, 0, 1),
    Fraction(1, 12): (0, 0, 2, 0),
    Fraction(1, 8): (0, 2, 0, 0),
    Fraction(1, 6): (2, 0, 0, 0),
    Fraction(5, 24): (0, -1, 0, 1),
    Fraction(1, 4): (0, 0, 0, 0),
}
MOST = 6  # angles share a unit while they are at most so many times as large


@dataclass(frozen=True)
class Generator:
    """What a generator of the ring stands for."""

    kind: str  # "sin", "cos", "symbol", "pi", "root", "inverse" or "function"
    node: Expr | None = None  # the angle's atom (None: 1 rad), the symbol, the root or the function
    unit: Fraction = Fraction(1)  # sine and cosine are those of unit · node
    number: int = 0  # the prime under a root, the slot of an inverse; else 0


Totals = Mapping[Expr, tuple[int, Expr | None]]  # see `TrigonometricRing`
Atom = Expr | None
Units = Mapping[Atom, tuple[Fraction, ...]]


def read_angle(angle: Expr, totals: Totals) -> tuple[int, list[tuple[Atom, Fraction]]]:
    """Return (k, [(atom, coefficient), …]) with angle = k π/12 + Σ coefficient · atom; q = sign (u(q) - u(below))."""
    form = angle.linear_form()
    exact = form.turns if (12 * form.turns).denominator == 1 else Fraction(round(2 * form.turns), 2)
    found: dict[Atom, Fraction] = {None: form.constant}
    if form.turns != exact:
        found[angle.graph.pi] = form.turns - exact
    for atom, coefficient in form.terms:
        sign, below = totals.get(atom, (1, None))
        found[atom] = found.get(atom, Fraction(0)) + sign * coefficient
        if below is not None:
            found[below] = found.get(below, Fraction(0)) - sign * coefficient
    return int(12 * exact), [(atom, coefficient) for atom, coefficient in found.items() if coefficient]


def angle_units(nodes: Sequence[Expr], totals: Totals) -> tuple[Units, int]:
    """Return the units of each angle atom, and the order (4, 8, 12, 24) of the root of unity for the rest."""
    sizes: dict[Atom, list[Fraction]] = {}
    order = 4
    for node in nodes:
        if node.op in (Op.SIN, Op.COS):
            exact, parts = read_angle(node.args[0], totals)
            order = lcm(order, Fraction(exact, 24).denominator)
            for atom, coefficient in parts:
                sizes.setdefault(atom, []).append(abs(coefficient))
    ordered = sorted(sizes, key=lambda atom: -1 if atom is None else atom.index)
    return {atom: _units(sizes[atom], atom is None or atom.op is Op.PI) for atom in ordered}, order


def _units(sizes: Sequence[Fraction], constant: bool) -> tuple[Fraction, ...]:
    """Return the units of one atom: those of its sizes that are near multiples of each other share one."""
    if constant:
        return tuple(dict.fromkeys(sizes))
    groups: list[list[Fraction]] = []
    for size in sorted(dict.fromkeys(sizes)):
        home = next((g for g in groups if max(*g, size) <= MOST * _divisor([*g, size])), None)
        if home is not None:
            home.append(size)
        elif _length(split_by_units(size, [_divisor(g) for g in groups])) > MOST:
            groups.append([size])
    return tuple(map(_divisor, groups))


def _divisor(sizes: Sequence[Fraction]) -> Fraction:
    scale = lcm(*(size.denominator for size in sizes))
    return Fraction(gcd(*(int(size * scale) for size in sizes)), scale)


Split = list[tuple[Fraction, int]] | None  # Σ unit · count, None for an angle that is none


def split_by_units(coefficient: Fraction, units: Sequence[Fraction]) -> Split:
    """Return coefficient = count · unit or, from the greatest unit on, Σ count · unit: the shortest that is found."""
    found: list[Split] = [[(unit, int(coefficient / unit))] for unit in units if (coefficient / unit).denominator == 1]
    greedy, rest = [], coefficient
    for unit in sorted(units, reverse=True):
        if count := round(rest / unit):
            greedy.append((unit, count))
            rest -= count * unit
    return min([*found, *([] if rest else [greedy])], key=_length, default=None)


def _length(split: Split) -> float:
    return inf if split is None else sum(abs(count) for _, count in split)


def choose_generators(nodes: Sequence[Expr], units: Units, order: int) -> Iterable[Generator]:
    """Yield the generators, those that relations eliminate first (the ordering is lexicographic)."""
    angles = [(atom, unit) for atom, sizes in units.items() for unit in sizes]
    for atom, unit in angles:
        yield Generator("sin", atom, unit)
    radicands = [node.args[0] for node in nodes if node.op is Op.SQRT]
    for node in reversed(nodes):
        if node.op is Op.SQRT and node.args[0].op is not Op.CONSTANT:
            yield Generator("root", node)
    wanted = {p for x in radicands if isinstance(x.value, Fraction) for p in prime_factors(x.value)}
    below = reachable([node.args[1] for node in nodes if node.op is Op.DIV])
    slots = sum(node.op is Op.DIV for node in nodes) + 2 * len(below)
    for slot in range(slots, 0, -1):
        yield Generator("inverse", number=slot)
    wanted |= {p for p, m in ((2, 8), (3, 12)) if order % m == 0}
    for p in sorted(wanted):
        yield Generator("root", number=p)
    for atom, unit in angles:
        yield Generator("cos", atom, unit)
    for node in nodes:
        if node.op.is_function and node.op not in (Op.SIN, Op.COS, Op.SQRT):
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


def turning(nodes: Iterable[Expr], variables: Iterable[Expr]) -> dict[Expr, tuple[Expr, Expr]]:
    """Return the atoms of angles that are a variable times parameters, such as r q: the variable, and r."""
    moving, found = set(variables), dict[Expr, tuple[Expr, Expr]]()
    for node in nodes:
        terms = node.args[0].linear_form().terms if node.op in (Op.SIN, Op.COS) else ()
        for atom in (atom for atom, _ in terms if atom.op is not Op.SYMBOL and atom not in found):
            inside = [one for one in reachable([atom]) if one in moving]
            if len(inside) == 1:
                slope = tangents([atom], {inside[0]: atom.graph.one})[0]
                if not moving.intersection(reachable([slope])):
                    found[atom] = inside[0], slope
    return found


def refuse_variables(nodes: Sequence[Expr], variables: Sequence[Expr], turned: Container[Expr] = ()) -> None:
    """Raise DerivationError if a function, a root or a denominator needs one of `variables`; `turned` are angles."""
    for node, names in refused(nodes, variables, turned):
        raise DerivationError(
            f"{node.op.name.lower()} of an expression in {', '.join(names)} is no trigonometric "
            "polynomial, so it has no closed form; generated code (NumPy, C) has no such limit"
        )


def refused(
    nodes: Sequence[Expr], variables: Sequence[Expr], turned: Container[Expr] | None = None
) -> Iterator[tuple[Expr, list[str]]]:
    """Yield the functions, roots and quotients that need some of `variables`, with their names; `turned` are angles."""
    moving, turned = set(variables), turning(nodes, variables) if turned is None else turned
    for node in nodes:
        if node.op is Op.SIN or node.op is Op.COS:
            guilty = [atom for atom, _ in node.args[0].linear_form().terms if atom.op is not Op.SYMBOL]
            guilty = [atom for atom in guilty if atom not in turned]
        elif node.op is Op.DIV:
            guilty = [node.args[1]]
        else:
            guilty = list(node.args) if node.op.is_function else []
        for found in guilty:
            names = [str(n.value) for n in reachable([found]) if n in moving]
            if names:
                yield node, names


def coprime_base(radicands: Iterable[int], order: int) -> tuple[int, ...]:
    """Return pairwise coprime non-squares of which every radicand is a product, times a square.

    Primes up to 1000 and those of `order` are split off; what is left is refined by common divisors, so that no large
    number has to be factored. The roots of such a base are independent over the field of the root of unity.
    """
    primes = {*SMALL_PRIMES, *(int(prime) for prime, _ in fmpz(order).factor())}
    base: set[int] = set()
    rests: list[int] = []
    for radicand in radicands:
        rest = radicand
        for prime in primes:
            while rest and rest % prime == 0:
                rest //= prime
                base.add(prime)
        rests.append(rest)
    coprime: list[int] = []
    while rests:
        rest = rests.pop()
        root = isqrt(rest)
        if root * root == rest:
            if root > 1:
                rests.append(root)
            continue
        for k, other in enumerate(coprime):
            common = gcd(rest, other)
            if common > 1:
                del coprime[k]
                rests += [part for part in (rest // common, other // common, common) if part > 1]
                break
        else:
            coprime.append(rest)
    return tuple(sorted(base | set(coprime)))
