"""Elimination with pivots that the numbers choose: over fractions, over GF(p), in doubles."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

from symdyn.algebra.finite_field import FiniteField, Needs
from symdyn.graph import Arithmetic, reachable
from symdyn.verify.equality import eliminate


def sparse(A, b):
    return [{**{c: x for c, x in enumerate(row) if x}, len(row): right} for row, right in zip(A, b, strict=True)]


def drawn(seed, rows, columns, rank):
    """Return a matrix of fractions of a given rank, many entries zero."""
    rng = random.Random(seed)

    def entry():
        return Fraction(rng.randint(-4, 4) * (rng.random() < 0.6))

    left = [[entry() for _ in range(rank)] for _ in range(rows)]
    right = [[entry() for _ in range(columns)] for _ in range(rank)]
    return [
        [sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*right, strict=True)] for row in left
    ]


@pytest.mark.parametrize("seed", range(30))
def test_what_is_consistent_is_solved_whatever_the_rank(seed):
    A = drawn(seed, 7, 5, 1 + seed % 5)
    x = [Fraction(k - 2) for k in range(5)]
    b = [sum((a * y for a, y in zip(row, x, strict=True)), Fraction(0)) for row in A]
    done = eliminate(sparse(A, b), 5, Arithmetic(), Fraction(0), abs)

    assert not any(done.left.values())
    assert [sum((a * y for a, y in zip(row, done.x, strict=True)), Fraction(0)) for row in A] == b
    assert all(done.x[k] == 0 for k in done.free)
    if not done.free:
        assert done.x == x


@pytest.mark.parametrize("seed", range(20))
def test_what_is_inconsistent_leaves_something(seed):
    A = drawn(seed, 6, 4, 3)
    done = eliminate(sparse(A, [Fraction(k * k + 1) for k in range(6)]), 4, Arithmetic(), Fraction(0), abs)

    assert any(done.left.values())


def test_a_pivot_that_vanishes_beforehand_is_not_taken():
    """The first entry is zero here and nowhere else: no order of pivots that was fixed before would know."""
    done = eliminate(sparse([[0.0, 2.0], [3.0, 1.0]], [4.0, 5.0]), 2, Arithmetic(), 0.0, abs)

    assert done.x == [1.0, 2.0]
    assert not done.free


def test_a_field_of_integers_is_as_good_as_numbers():
    wanted = Needs.of(reachable([]))
    field = FiniteField(wanted.prime(1), 1, wanted)
    A = [[3, 1, 2], [1, 5, 1], [4, 6, 3]]  # the last row is the sum of the others
    for b, solvable in (([1, 2, 3], True), ([1, 2, 4], False)):
        done = eliminate(sparse(A, b), 3, field, 0, bool)
        assert (not any(done.left.values())) is solvable
        assert len(done.free) == 1
