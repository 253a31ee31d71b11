"""The checker passes what the derivations build, and sees a graph that was tampered with."""

from __future__ import annotations

import pytest
from graphs import check_graph
from mechanisms import random_tree

from symdyn.dynamics import derive
from symdyn.graph import Expr, Graph, Op


@pytest.mark.parametrize("seed", range(4))
def test_derived_graphs_keep_every_invariant(seed: int) -> None:
    check_graph(derive(random_tree(seed)).graph)


@pytest.mark.parametrize(
    ("op", "count", "words"),
    [(Op.ADD, 2, "again"), (Op.ADD, 1, "ADD has 1 arguments"), (Op.SIN, 2, "SIN has 2 arguments")],
)
def test_a_node_that_bypasses_the_graph_is_seen(op: Op, count: int, words: str) -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    x + y
    Expr(graph, op, (x, y)[:count], None)

    with pytest.raises(AssertionError, match=words):
        check_graph(graph)


def test_a_node_of_another_graph_is_seen() -> None:
    graph, other = Graph(), Graph()
    Expr(graph, Op.NEG, (other.symbol("x"),), None)

    with pytest.raises(AssertionError, match="uses a node after it"):
        check_graph(graph)
