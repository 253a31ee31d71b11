"""Proving that two graphs are the same function: random points over random 127-bit primes (Schwartz-Zippel).

Roots of something variable are formal values there; see `symdyn.verify.points`. What the field cannot decide (which
root of a square is meant, an identity of an uninterpreted function) is compared at random points in 50 digits instead
and reported as agreeing in numbers, never as proved. Points are of either sign, except for symbols that are declared
positive, and lie where every root and logarithm is real.

Linear equations are eliminated over any algebra, every pivot chosen by what the numbers are at the place at hand. Rows
are sparse. The next pivot is the largest entry of the row that has fewest, so that a chain of bodies is eliminated from
its tips without fill; what is too small to be told from zero is none.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from math import lgamma, log
from typing import Any

from symdyn.algebra import FiniteField, Needs, RealBalls, Redraw
from symdyn.errors import VerifyError
from symdyn.frozen import dataclass
from symdyn.graph import Algebra, Expr, Op, reachable
from symdyn.verdict import Verdict
from symdyn.verify.points import (
    MAX_DRAWS,
    Bound,
    Bounds,
    FieldPoints,
    FirstPoints,
    NumberPoints,
    Roots,
    conjugated,
    field_values,
    radicands,
    signed,
)


@dataclass(frozen=True)
class Eliminated:
    """What became of A x = b.

    Attributes:
        x: a solution, shape (unknowns,): zero where the equations leave it open.
        free: the unknowns that they leave open.
        left: b by row, of the rows that became empty on its left: A x = b has a solution if all of it is zero.
    """

    x: list[Any]
    free: tuple[int, ...]
    left: dict[int, Any]


def eliminate(
    rows: Sequence[Mapping[int, Any]], unknowns: int, field: Algebra[Any], zero: Any, weigh: Callable[[Any], Any]
) -> Eliminated:
    """Return what becomes of A x = b in numbers of a field, `zero` its zero.

    Rows are those of A with b beside them, entries by column, b's being `unknowns`; what is missing is zero. What
    weighs 0 cannot be told from zero.
    """
    b = [row.get(unknowns, zero) for row in rows]
    A = [{c: value for c, value in row.items() if c != unknowns and weigh(value)} for row in rows]
    users: list[set[int]] = [set() for _ in range(unknowns)]
    for r, row in enumerate(A):
        for c in row:
            users[c].add(r)

    def reduce(s: int, r: int, c: int) -> None:
        """Take from row s the share of row r that leaves nothing in column c."""
        share = field.div(A[s].pop(c), A[r][c])
        b[s] = field.sub(b[s], field.mul(share, b[r]))
        for k, value in A[r].items():
            if k == c:
                continue
            rest = field.sub(A[s].pop(k, zero), field.mul(share, value))
            if weigh(rest):
                A[s][k] = rest
                users[k].add(s)
            else:
                users[k].discard(s)

    waiting = {r for r, row in enumerate(A) if row}
    order: list[tuple[int, int]] = []
    while waiting:
        r = min(waiting, key=lambda row: (len(A[row]), row))
        waiting.remove(r)
        if not A[r]:
            continue
        c = max(A[r], key=lambda k: (weigh(A[r][k]), -k))
        order.append((r, c))
        for k in A[r]:
            users[k].discard(r)
        for s in sorted(users[c]):
            reduce(s, r, c)
        users[c].clear()
    x = [zero] * unknowns
    for r, c in reversed(order):
        total = b[r]
        for k, value in A[r].items():
            if k != c:
                total = field.sub(total, field.mul(value, x[k]))
        x[c] = field.div(total, A[r][c])
    ends, bound = {r for r, _ in order}, {c for _, c in order}
    free = tuple(k for k in range(unknowns) if k not in bound)
    return Eliminated(x, free, {r: b[r] for r in range(len(A)) if r not in ends})


DIGITS = 50
SURE = -6.0  # log10 of the chance of error from which a claim is not called proved
ROOTS = 1 << 20  # tells points that roots are looked at from points that claims are
TRIALS = 6  # numerical points, half of them the mirror images of the others


Sides = tuple[tuple[Expr, ...], ...]
"""What stands under the variable roots of a claim, that of one graph together."""


@dataclass(frozen=True)
class Claim:
    """A claim that left[i] and right[i] are the same function; the two sides may live on different graphs."""

    name: str
    left_name: str
    right_name: str
    left: tuple[Expr, ...]
    right: tuple[Expr, ...]

    @staticmethod
    def solvable(
        name: str, left_name: str, right_name: str, rows: Sequence[Mapping[int, Expr]], unknowns: int
    ) -> Solvable:
        """Return the claim that A x = b has a solution; rows are of A, with b in the column behind `unknowns`."""
        places = tuple((r, c) for r, row in enumerate(rows) for c in row)
        left = tuple(entry for row in rows for entry in row.values())
        zeros = tuple(entry.graph.zero for entry in left)
        return Solvable(name, left_name, right_name, left, zeros, places, unknowns)

    def compared(
        self, left: list[Any], right: list[Any], field: Algebra[Any], zero: Any, weigh: Callable[[Any], Any]
    ) -> tuple[list[Any], list[Any]]:
        """Return what must be equal at one place, for the values of both sides there, numbers of a field.

        `weigh` tells the size of a number, 0 where it cannot be told from zero.
        """
        return left, right

    def widened(self, bound: Bound) -> Bound:
        """Return the bound of what is compared, for the bound of the two sides."""
        return bound


@dataclass(frozen=True)
class Solvable(Claim):
    """A claim that A x = b has a solution wherever it is looked at, be it unique or not; pivots are chosen there.

    Attributes:
        left: entries of A and b, what is zero left out; right are as many zeros.
        places: row and column of each; b is the column behind the unknowns.
        unknowns: how many.
    """

    places: tuple[tuple[int, int], ...] = ()
    unknowns: int = 0

    def compared(
        self, left: list[Any], right: list[Any], field: Algebra[Any], zero: Any, weigh: Callable[[Any], Any]
    ) -> tuple[list[Any], list[Any]]:
        """Return what is left of b when A is eliminated, and zeros; see `Claim.compared`."""
        rows: list[dict[int, Any]] = [{} for _ in range(1 + max((r for r, _ in self.places), default=-1))]
        for (r, c), value in zip(self.places, left, strict=True):
            rows[r][c] = value
        rest = eliminate(rows, self.unknowns, field, zero, weigh).left
        return [rest.get(r, zero) for r in range(len(rows))], [zero] * len(rows)

    def widened(self, bound: Bound) -> Bound:
        """Return the bound of a determinant of A with b, each row of it multiplied out."""
        size = self.unknowns + 1
        wide = size * (size + 1)
        return Bound(wide * bound.degree, wide * bound.height + lgamma(size + 1) / log(2))


@dataclass(frozen=True)
class Finding:
    """What became of a claim.

    Attributes:
        claim: its name and its two sides, for reading.
        verdict: one of the four of `symdyn.verdict`; NOT_SHOWN where no real point was found to look at.
        entries: how many pairs were compared; of what is looked at in numbers, at how many states.
        degree: bound of the degree of the differences; 0 when numerical.
        error_log10: log10 of the probability that a false claim would pass; 0 when not proved.
        where: index of the first entry that differs, -1 if none.
        why: nothing could be compared, or it fails by more than an entry that differs; "" elsewhere.
    """

    claim: str
    verdict: str
    entries: int
    degree: int
    error_log10: float
    where: int
    why: str = ""


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
    """
    every = _by_graph([node for claim in claims for node in (*claim.left, *claim.right)])
    order = [node for entries in every for node in reachable(entries)]
    rootless = all(node.op is not Op.SQRT for node in order)
    rooted = [()] * len(claims) if rootless else [_radicands(claim) for claim in claims]
    exact = [claim for claim, roots in zip(claims, rooted, strict=True) if roots is not None]
    wanted = Needs.of(order if rootless else reachable([x for claim in exact for x in (*claim.left, *claim.right)]))
    fields = Fields(seed, tuple(wanted.prime(seed + k) for k in range(primes)), points)
    seeds = [[hash_seed(seed, k, point, point) for k in range(primes)] for point in range(points)]
    first, over_fields = FirstPoints(wanted, fields.primes, seeds), FieldPoints(wanted)
    numbers, bounds = RealBalls(DIGITS), Bounds(wanted)
    in_numbers = NumberPoints(numbers, positive)
    if rootless:  # so all claims can be run over a field, which one walk does for most of them
        first.look(order)
        bounds.look(order)
    known: dict[Sides, Roots | None] = {}
    findings = []
    for claim, sides in zip(claims, rooted, strict=True):
        if sides is not None and sides not in known:
            known[sides] = _roots(sides, fields, wanted)
        roots = None if sides is None else known[sides]
        flags = None if roots is None else _agreement(claim, fields, first, over_fields, roots)
        limit = None
        if roots is not None and flags is not None and all(flags):
            limit = conjugated(claim.widened(bounds.of(claim.left, claim.right)), roots.count)
        error = limit.error_log10(wanted, primes, points) if limit else 0.0
        with numbers:
            findings.append(_judge(claim, flags, limit.degree if limit else 0, error, in_numbers))
    return fields, findings


def _radicands(claim: Claim) -> Sides | None:
    """Return what stands under the variable roots of a claim, by graph; None where a root has no formal value."""
    found = []
    for entries in _by_graph((*claim.left, *claim.right)):
        under = radicands(entries)
        if under is None:
            return None
        found.append(tuple(under))
    return tuple(found)


def _roots(sides: Sides, fields: Fields, needs: Needs) -> Roots | None:
    """Return what is known of the roots of a claim over every prime; None if they are too many."""
    most = Roots(0, 1)
    for k, prime in enumerate(fields.primes):
        points = (FiniteField(prime, hash_seed(fields.seed, k, ROOTS, draw), needs) for draw in range(MAX_DRAWS))
        roots = signed(sides, points, field_values)
        if roots is None:
            return None
        most = Roots(max(most.count, roots.count), max(most.signs, roots.signs))
    return most


def _agreement(
    claim: Claim, fields: Fields, first: FirstPoints, places: FieldPoints, roots: Roots
) -> list[bool] | None:
    """Return which entries agree at all points of all fields; None if no point was found at which all is defined."""
    if roots.signs == 1:
        try:
            return _at_first(claim, first)
        except Redraw:
            pass  # one of them is unlucky: points are drawn one by one
    agree: list[bool] = []
    for k, prime in enumerate(fields.primes):
        draws = iter(range(MAX_DRAWS << roots.count))
        for point in range(fields.points):
            drawn = _draw(claim, prime, places, (fields.seed, k, point), draws, roots.signs)
            if drawn is None:
                return None
            for left, right in drawn:
                same = [a == b for a, b in zip(left, right, strict=True)]
                agree = [x and y for x, y in zip(agree or same, same, strict=True)]
    return agree


def _at_first(claim: Claim, first: FirstPoints) -> list[bool]:
    """Return which entries agree at all first points; Redraw where one is unlucky."""
    left, right = first.values(claim.left), first.values(claim.right)
    if type(claim).compared is Claim.compared:
        return [a == b for a, b in zip(left, right, strict=True)]
    agree: list[bool] = []
    for field, j, k in first.places:
        one, other = claim.compared(first.at(left, j, k), first.at(right, j, k), field, 0, bool)
        same = [a == b for a, b in zip(one, other, strict=True)]
        agree = [x and y for x, y in zip(agree or same, same, strict=True)]
    return agree


def _draw(
    claim: Claim, prime: int, places: FieldPoints, key: tuple[int, int, int], draws: Iterator[int], signs: int
) -> list[tuple[list[int], list[int]]] | None:
    """Return what is compared at a random point of a field, for every choice of signs; unlucky ones are drawn again."""
    for attempt in draws:
        found = []
        try:
            for choice in range(signs):
                seed = hash_seed(*key, attempt)
                field, (left, right) = places.values((claim.left, claim.right), prime, seed, choice)
                found.append(claim.compared(left, right, field, 0, bool))
        except Redraw:
            continue
        return found
    return None


def hash_seed(*key: int) -> int:
    """Return one seed for several."""
    result = 0
    for part in key:
        result = result * 1_000_003 + part + 1
    return result


def _judge(
    claim: Claim, flags: Sequence[bool] | None, degree: int, error_log10: float, places: NumberPoints
) -> Finding:
    """Return the finding for a claim; `flags` say which entries agreed over the fields, None where none can tell."""
    wrong = flags is not None and not all(flags)
    if flags is not None and wrong and _is_decided((*claim.left, *claim.right)):
        return _found(claim, len(flags), list(flags).index(False))
    proved = bool(flags) and not wrong and error_log10 < SURE
    try:
        entries, where = _first_difference(claim, places, 1 if proved else TRIALS)  # one look keeps the field honest
    except VerifyError as fault:
        return _found(claim, 0, why=str(fault))
    if where < 0 and proved:
        return _found(claim, entries, where, degree, error_log10)
    return _found(claim, entries, where, why="" if entries else "it has no entries to compare")


def _found(
    claim: Claim, entries: int, where: int = -1, degree: int = 0, error_log10: float = 0.0, why: str = ""
) -> Finding:
    """Return a finding: of so many pairs the first that differs, -1 for none; a chance of error is that of a proof."""
    title = f"{claim.name}: {claim.left_name} = {claim.right_name}"
    said = Verdict.of(entries, where >= 0, error_log10 < 0)
    return Finding(title, said, entries, degree, error_log10, where, why)


def _is_decided(outputs: Sequence[Expr]) -> bool:
    """Whether values that differ over a field mean different functions, however small the difference.

    So it is where the field knows every relation: sines of linear angles, and roots of constants.
    """
    for entries in _by_graph(outputs):
        for node in reachable(entries):
            if node.op in (Op.SIN, Op.COS):
                if any(atom.op is not Op.SYMBOL for atom, _ in node.args[0].linear_form().terms):
                    return False
            elif node.op.is_function and not (node.op is Op.SQRT and node.args[0].op is Op.CONSTANT):
                return False
    return True


def _by_graph(outputs: Sequence[Expr]) -> list[list[Expr]]:
    groups: dict[int, list[Expr]] = {}
    for node in outputs:
        groups.setdefault(id(node.graph), []).append(node)
    return list(groups.values())


def _first_difference(claim: Claim, places: NumberPoints, trials: int) -> tuple[int, int]:
    """Return how many entries are compared, and the first that differs at random points, -1 if none.

    What rounding to 50 digits did is no difference.

    Raises:
        VerifyError: no point was found at which both sides are real.
    """
    algebra, draws, zero, entries = places.algebra, iter(range(MAX_DRAWS)), places.algebra.number(0.0), 0
    for trial in range(trials):
        point = _next_point(claim, places, draws)
        if point is None and not trial:
            raise VerifyError(f"no point was found at which both sides have a real value ({MAX_DRAWS} tries)")
        if point is None:
            break  # fewer points than wanted are some
        left, right = claim.compared(*point, algebra, zero, _certain)
        entries = len(left)
        for i, (a, b) in enumerate(zip(left, right, strict=True)):
            if not a.overlaps(b):
                return entries, i
    return entries, -1


def _certain(number: Any) -> Any:
    """Return the size of a number, 0 where it cannot be told from zero."""
    return 0 if number.contains(0) else abs(number).mid()


def _next_point(claim: Claim, places: NumberPoints, draws: Iterator[int]) -> tuple[list[Any], list[Any]] | None:
    """Return the values of both sides at the next point where they are real; None where there is none left."""
    for draw in draws:
        try:
            return places.values(claim.left, draw), places.values(claim.right, draw)
        except (ValueError, ZeroDivisionError, OverflowError):
            continue
    return None
