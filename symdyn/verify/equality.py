"""Proving that two graphs are the same function: random points over random 61-bit primes (Schwartz-Zippel).

What the field cannot decide (a branch of a square root, an identity of an uninterpreted function) is compared at
random points in 50 digits instead and reported as "checked numerically", never as proved. Points are of either sign,
except for symbols that are declared positive, and lie where every root and logarithm is real.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from math import log10
from typing import Any

from symdyn.algebra.big import BigFloats
from symdyn.algebra.degree import degree_bound
from symdyn.algebra.finite_field import FiniteField, Needs, Redraw, draw_prime, evaluate_over_field, needs
from symdyn.errors import VerifyError
from symdyn.graph import FUNCTIONS, Expr, Op, evaluate, linear_form, reachable

PROVED = "proved"
NUMERICAL = "checked numerically"
DIFFERENT = "different"

MAX_DRAWS = 200
DIGITS = 50
TOLERANCE = 1e-35  # relative; 50 digits leave 15 for cancellation
TRIALS = 6  # numerical points, half of them the mirror images of the others
CONSISTENT_RADICANDS = frozenset({2, 3, 5, 7})  # their roots are built from the root of unity that gives the sines


@dataclass(frozen=True)
class Claim:
    """A claim that left[i] and right[i] are the same function; the two sides may live on different graphs."""

    name: str
    left_name: str
    right_name: str
    left: tuple[Expr, ...]
    right: tuple[Expr, ...]


@dataclass(frozen=True)
class Finding:
    """What became of a claim.

    Attributes:
        claim: its name and its two sides, for reading.
        verdict: PROVED, NUMERICAL or DIFFERENT.
        entries: how many pairs were compared.
        degree: bound of the degree of the differences; 0 when numerical.
        error_log10: log10 of the probability that a false claim would pass; 0 when not proved.
        where: index of the first entry that differs, -1 if none.
    """

    claim: str
    verdict: str
    entries: int
    degree: int
    error_log10: float
    where: int


@dataclass(frozen=True)
class Fields:
    """The fields and points of a proof, for the record."""

    seed: int
    primes: tuple[int, ...]
    points: int


def prove(
    claims: Sequence[Claim], seed: int = 1, primes: int = 2, points: int = 2, positive: Collection[str] = ()
) -> tuple[Fields, list[Finding]]:
    """Return a finding for every claim.

    Args:
        claims: what to prove; symbols of the same name are the same variable.
        seed: of primes and points; the same seed, the same certificate.
        primes: how many primes.
        points: how many points over each.
        positive: names of symbols that are assumed positive where a claim is checked numerically.

    Raises:
        VerifyError: no point could be drawn at which everything is defined.
    """
    exact = {k: claim for k, claim in enumerate(claims) if not _has_branches((*claim.left, *claim.right))}
    wanted = needs([node for claim in exact.values() for node in (*claim.left, *claim.right)])
    chosen = tuple(draw_prime(seed + k, wanted) for k in range(primes))
    agree = {k: [True] * len(claim.left) for k, claim in exact.items()}
    for k, prime in enumerate(chosen):
        for point in range(points):
            drawn = _draw(tuple(exact.values()), prime, wanted, (seed, k, point))
            for flags, (left, right) in zip(agree.values(), drawn, strict=True):
                for i, (a, b) in enumerate(zip(left, right, strict=True)):
                    flags[i] = flags[i] and a == b
    findings = [
        _judge(claim, agree[k], wanted, min(chosen), primes * points, positive)
        if k in exact
        else _look(claim, positive)
        for k, claim in enumerate(claims)
    ]
    return Fields(seed, chosen, points), findings


def _draw(
    claims: Sequence[Claim], prime: int, wanted: Needs, key: tuple[int, int, int]
) -> list[tuple[list[int], list[int]]]:
    """Return the values of all claims at one random point of the field; unlucky points are drawn again."""
    for attempt in range(MAX_DRAWS):
        field = FiniteField(prime, hash_seed(*key, attempt), wanted)
        try:
            return [(_field_values(c.left, field), _field_values(c.right, field)) for c in claims]
        except Redraw:
            continue
    raise VerifyError(
        f"no point over GF({prime}) was found at which every division and root is defined ({MAX_DRAWS} tries); "
        "a divisor is zero for all values"
    )


def _field_values(outputs: Sequence[Expr], field: FiniteField) -> list[int]:
    symbols = [node for node in reachable(outputs) if node.op is Op.SYMBOL]
    rng = random.Random()
    values = {}
    for node in symbols:
        rng.seed(f"{field.seed}:{node.value}")
        values[node] = rng.randrange(field.p)
    return evaluate_over_field(outputs, field, values)


def hash_seed(*key: int) -> int:
    """Return one seed for several."""
    result = 0
    for part in key:
        result = result * 1_000_003 + part + 1
    return result


def _judge(
    claim: Claim, flags: Sequence[bool], wanted: Needs, prime: int, points: int, positive: Collection[str]
) -> Finding:
    """Return the finding for a claim, given which entries agreed over the fields."""
    if all(flags):
        degree = degree_bound(claim.left, claim.right, wanted)
        error = points * (log10(max(degree, 1)) - log10(prime))
        if error < -6:
            return Finding(_title(claim), PROVED, len(flags), degree, error, -1)
    elif _is_decided((*claim.left, *claim.right)):
        return Finding(_title(claim), DIFFERENT, len(flags), 0, 0.0, list(flags).index(False))
    return _look(claim, positive)


def _look(claim: Claim, positive: Collection[str]) -> Finding:
    """Return the finding for a claim at numerical points alone."""
    where = _first_difference(claim, positive)
    return Finding(_title(claim), NUMERICAL if where < 0 else DIFFERENT, len(claim.left), 0, 0.0, where)


def _title(claim: Claim) -> str:
    return f"{claim.name}: {claim.left_name} = {claim.right_name}"


def _is_decided(outputs: Sequence[Expr]) -> bool:
    """Whether values that differ over a field mean different functions, however small the difference.

    So it is where the field knows every relation: sines of linear angles, and roots of 2, 3, 5, 7.
    """
    for entries in _by_graph(outputs):
        if not set(needs(entries).radicands) <= CONSISTENT_RADICANDS:
            return False
        for node in reachable(entries):
            if node.op in (Op.SIN, Op.COS):
                if any(atom.op is not Op.SYMBOL for atom, _ in linear_form(node.args[0]).terms):
                    return False
            elif node.op in FUNCTIONS and not (node.op is Op.SQRT and node.args[0].op is Op.CONSTANT):
                return False
    return True


def _has_branches(outputs: Sequence[Expr]) -> bool:
    """Whether a root of something variable occurs: a field has two such roots or none, and no sign to choose by."""
    return any(
        node.op is Op.SQRT and node.args[0].op is not Op.CONSTANT
        for entries in _by_graph(outputs)
        for node in reachable(entries)
    )


def _by_graph(outputs: Sequence[Expr]) -> list[list[Expr]]:
    groups: dict[int, list[Expr]] = {}
    for node in outputs:
        groups.setdefault(id(node.graph), []).append(node)
    return list(groups.values())


def _first_difference(claim: Claim, positive: Collection[str]) -> int:
    """Return the first entry that differs at random points in 50 digits, -1 if none does."""
    algebra = BigFloats(DIGITS)
    algebra.context.trap_complex = True  # the root of a negative number is no value
    draws = iter(range(MAX_DRAWS))
    for _ in range(TRIALS):
        left, right = _next_point(claim, algebra, positive, draws)
        scale = max([abs(value) for value in (*left, *right)], default=1) or 1
        for i, (a, b) in enumerate(zip(left, right, strict=True)):
            if not abs(a - b) <= TOLERANCE * scale:
                return i
    return -1


def _next_point(
    claim: Claim, algebra: BigFloats, positive: Collection[str], draws: Iterator[int]
) -> tuple[list[Any], list[Any]]:
    """Return the values of both sides at the next point where they are real."""
    for draw in draws:
        try:
            return _big_values(claim.left, algebra, positive, draw), _big_values(claim.right, algebra, positive, draw)
        except (ValueError, ZeroDivisionError):
            continue
    raise VerifyError(f"{claim.name}: no point was found at which every root and logarithm is real ({MAX_DRAWS} tries)")


def _big_values(outputs: Sequence[Expr], algebra: BigFloats, positive: Collection[str], draw: int) -> list[Any]:
    values = {}
    for node in reachable(outputs):
        if node.op is Op.SYMBOL:
            rng = random.Random(f"{draw // 2}:{node.value}")
            signed = draw < MAX_DRAWS // 2 and node.value not in positive  # if few points are real, try all positive
            sign = rng.choice((-1, 1)) * (-1) ** draw if signed else 1  # points come as x and -x
            values[node] = algebra.number(sign * rng.uniform(0.25, 2.0))
    return evaluate(outputs, algebra, values)
