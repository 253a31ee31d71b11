"""Proving that two graphs are the same function: random points over random 61-bit primes (Schwartz-Zippel).

What the field cannot decide (a branch of a square root, an identity of an uninterpreted function) is compared at
random points in 50 digits instead and reported as "checked numerically", never as proved.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from math import log10
from typing import Any

from symdyn.algebra.big import BigFloats
from symdyn.algebra.degree import degree_bound
from symdyn.algebra.finite_field import FiniteField, Needs, Redraw, draw_prime, evaluate_over_field, needs
from symdyn.errors import VerifyError
from symdyn.graph import Expr, Op, evaluate, reachable

PROVED = "proved"
NUMERICAL = "checked numerically"
DIFFERENT = "different"

MAX_DRAWS = 200
DIGITS = 50
TOLERANCE = 1e-35  # relative; 50 digits leave 15 for cancellation


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


def prove(claims: Sequence[Claim], seed: int = 1, primes: int = 2, points: int = 2) -> tuple[Fields, list[Finding]]:
    """Return a finding for every claim.

    Args:
        claims: what to prove; symbols of the same name are the same variable.
        seed: of primes and points; the same seed, the same certificate.
        primes: how many primes.
        points: how many points over each.

    Raises:
        VerifyError: no point could be drawn at which everything is defined.
    """
    graphs = [entries for claim in claims for entries in (claim.left, claim.right) if entries]
    wanted = needs([node for entries in graphs for node in entries])
    chosen = tuple(draw_prime(seed + k, wanted) for k in range(primes))
    agree = [[True] * len(claim.left) for claim in claims]
    for k, prime in enumerate(chosen):
        for point in range(points):
            for flags, (left, right) in zip(agree, _draw(claims, prime, wanted, (seed, k, point)), strict=True):
                for i, (a, b) in enumerate(zip(left, right, strict=True)):
                    flags[i] = flags[i] and a == b
    findings = [
        _judge(claim, flags, wanted, min(chosen), primes * points) for claim, flags in zip(claims, agree, strict=True)
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


def _judge(claim: Claim, flags: Sequence[bool], wanted: Needs, prime: int, points: int) -> Finding:
    """Return the finding for a claim, given which entries agreed over the fields."""
    agreed = all(flags)
    name = f"{claim.name}: {claim.left_name} = {claim.right_name}"
    if agreed and not _has_branches((*claim.left, *claim.right)):
        degree = degree_bound(claim.left, claim.right, wanted)
        error = points * (log10(max(degree, 1)) - log10(prime))
        if error < -6:
            return Finding(name, PROVED, len(flags), degree, error, -1)
    where = _first_difference(claim)
    verdict = NUMERICAL if where < 0 else DIFFERENT
    return Finding(name, verdict, len(flags), 0, 0.0, where)


def _has_branches(outputs: Sequence[Expr]) -> bool:
    """Whether a square root of something variable occurs."""
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


def _first_difference(claim: Claim) -> int:
    """Return the first entry that differs at three random points in 50 digits, -1 if none does."""
    algebra = BigFloats(DIGITS)
    for trial in range(3):
        left, right = (_big_values(side, algebra, trial) for side in (claim.left, claim.right))
        scale = max([abs(value) for value in (*left, *right)], default=1) or 1
        for i, (a, b) in enumerate(zip(left, right, strict=True)):
            if not abs(a - b) <= TOLERANCE * scale:
                return i
    return -1


def _big_values(outputs: Sequence[Expr], algebra: BigFloats, trial: int) -> list[Any]:
    values = {}
    for node in reachable(outputs):
        if node.op is Op.SYMBOL:
            rng = random.Random(f"{trial}:{node.value}")
            values[node] = algebra.number(rng.uniform(0.25, 2.0))
    return evaluate(outputs, algebra, values)
