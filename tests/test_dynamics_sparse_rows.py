"""Large mechanisms with many loops: what is done entry by entry is what dense matrices give."""

from __future__ import annotations

import numpy as np
import pytest
from closed_mechanisms import bricard, crank_rocker, n_four_bar, rssr, slider_crank

from symdyn.algebra.numeric import Floats
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.loops import sparse_rows
from symdyn.dynamics.loops.assembly import Levels
from symdyn.dynamics.loops.loop_numbers import Numbers, jacobian
from symdyn.dynamics.loops.newton import NEGLIGIBLE
from symdyn.dynamics.loops.partition import blocks
from symdyn.dynamics.loops.sparse_rows import is_large, triangular
from symdyn.errors import NoValueError
from symdyn.graph import Graph, evaluate, tangents


def banded(rng: np.random.Generator, rows: int, columns: int, depend: int = 0) -> np.ndarray:
    """Return rows of four entries each along a diagonal, some of which are sums of two others."""
    A = np.zeros((rows, columns))
    for i in range(rows):
        first = i * (columns - 4) // max(rows - 1, 1)
        A[i, first : first + 4] = rng.uniform(-1, 1, 4)
    for i in range(depend):
        A[5 * i + 1] = A[5 * i] - 2 * A[5 * i + 2]
    return A


@pytest.mark.parametrize(("rows", "columns", "depend"), [(40, 50, 0), (40, 50, 6), (50, 40, 0), (60, 40, 5), (7, 9, 1)])
def test_least_squares_rank_and_singular_values_are_those_of_dense_matrices(rows, columns, depend):
    rng = np.random.default_rng(rows + depend)
    A, b = banded(rng, rows, columns, depend), rng.uniform(-1, 1, rows)

    found = triangular(A, NEGLIGIBLE)

    values = np.linalg.svd(A, compute_uv=False)
    rank = int(np.sum(values > NEGLIGIBLE * values[0]))
    assert len(found.independent) == rank
    assert np.allclose(found.shortest(b), np.linalg.lstsq(A, b, rcond=NEGLIGIBLE)[0], rtol=1e-7, atol=1e-7)
    assert np.allclose(found.ends(), (values[0], values[rank - 1]), rtol=1e-4)
    shares = found.relations()
    assert np.allclose(shares @ A[list(found.independent)], A[list(found.dependent)], atol=1e-9)


def test_pivots_are_independent_and_come_from_the_first_stage_that_has_strong_ones():
    A = banded(np.random.default_rng(3), 60, 50, 5)

    chosen, sizes = sparse_rows.pivots(A, [range(0, 60, 2), range(60)], 45, 0.02)

    assert len(set(chosen)) == 45
    assert np.linalg.matrix_rank(A[chosen]) == 45
    assert min(sizes) > 0
    assert all(k % 2 == 0 for k in chosen[:20])


@pytest.mark.parametrize("mechanism", [crank_rocker, slider_crank, rssr, bricard, lambda: n_four_bar(6)])
def test_mechanisms_are_decided_alike_row_by_row(mechanism, monkeypatch):
    dense = Workspace(mechanism()).loops.decisions
    monkeypatch.setattr(sparse_rows, "LARGE", 1)
    numbers = Numbers(mechanism())
    assert is_large(numbers.dimensionless(numbers.start(), 1.0)) or len(numbers.constraints.labels) == 0

    sparse = Workspace(mechanism()).loops.decisions

    assert sparse.assembly.rank == dense.assembly.rank
    assert sparse.assembly.here == dense.assembly.here
    assert sparse.assembly.smallest == pytest.approx(dense.assembly.smallest, rel=1e-3, abs=1e-9)
    assert (len(sparse.independent_rows), sparse.zero_rows) == (len(dense.independent_rows), dense.zero_rows)
    assert np.allclose(sparse.assembly.q, dense.assembly.q, atol=1e-8)
    assert len(sparse.partition.dependent) == len(dense.partition.dependent)


@pytest.mark.long(0)
def test_sixty_four_bars_move_as_the_same_in_dense_numbers(monkeypatch):
    """200 rows and more are large: their accelerations are those of equations that dense numbers decided."""
    scene = n_four_bar(60)
    place = Workspace(scene).loops.decisions.assembly.q
    found = derive_one(Workspace(scene), "forward_dynamics")
    monkeypatch.setattr(sparse_rows, "LARGE", 10**9)
    other = derive_one(Workspace(scene), "forward_dynamics")

    def at_start(function):
        values = {x: 0.0 for one in function.arguments for x in one.symbols}
        values |= dict(zip(function.arguments[0].symbols, place, strict=True))
        return evaluate(function.entries, Floats(), values)

    assert np.allclose(at_start(found), at_start(other), rtol=1e-9)


def test_a_row_of_a_thousand_loops_is_matched_without_recursion():
    count = 5000
    uses = [[k, k + 1] for k in range(count - 1)] + [[0]]

    found = blocks(uses)

    assert sorted(r for one in found for r in one.rows) == list(range(count))


@pytest.mark.parametrize("seed", range(5))
def test_every_row_stands_in_one_block_behind_those_that_it_needs(seed):
    rng = np.random.default_rng(seed)
    order = rng.permutation(8)
    uses = [[int(order[k]), *(int(x) for x in order[k + 1 :] if rng.random() < 0.2)] for k in range(8)]

    found = blocks(uses)

    assert sorted(row for one in found for row in one.rows) == list(range(8))
    for k, one in enumerate(found):
        known = {x for before in found[: k + 1] for x in before.velocities}
        assert {x for row in one.rows for x in uses[row]} <= known


def test_levels_are_floats_node_by_node():
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    entries = [graph.sin(x) * y - x / (y + 2), graph.sqrt(x) + graph.pi, graph.constant(3), x]

    values = {x: 0.7, y: -0.2}

    assert Levels(entries).at(values) == pytest.approx(evaluate(entries, Floats(), values), rel=1e-15)
    with pytest.raises(NoValueError):
        Levels(entries).at({x: -0.7, y: -0.2})
    with pytest.raises(NoValueError):
        Levels([1 / x]).at({x: 0.0})


def test_a_jacobian_is_its_columns():
    graph = Graph()
    x, y, z = graph.symbol("x"), graph.symbol("y"), graph.symbol("z")
    entries = [x * y + graph.cos(z), y * y, z - z, graph.sin(x * z)]
    directions = [{x: graph.one}, {y: graph.one, z: x}, {z: graph.one}]

    rows = jacobian(entries, directions)

    for k, seeds in enumerate(directions):
        assert [row.get(k, graph.zero) for row in rows] == tangents(entries, seeds)
