"""A wrench on its way to the ground passes a run of parallel axes in one turn, by the sum of their angles.

Joint j of a run feels n_z + (P × f)_z (or f_z), without any turn, P being the way from its origin to the wrench's; and
behind the run the wrench is where it would be after all single turns. Sums of angles are taken by the addition
formulas, so that no sine is evaluated for them. What a run needs is computed once for all wrenches that pass it; it
pays from three on.

    k         the joint at the far end of the run, in whose frame n and f stay
    P         from the origin of frame j to that of frame k, axes of frame k
    Q         the same, in the axes in which link j turns
    turn      from frame k to those axes

The run that a wrench starts in is walked step by step: there its turns are those of the composite body.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from symdyn.dynamics.recursive.links import Link, PlanarTurn
from symdyn.dynamics.recursive.reframe import LeanTree
from symdyn.graph import Expr
from symdyn.spatial import Vec, add, zero_vector


@dataclass(frozen=True)
class _Run:
    """A stretch of parallel axes from frame k down to link j; see the module's legend. `rise` is along z in all."""

    P: Vec
    Q: Vec
    turn: PlanarTurn
    rise: Expr


def walk(tree: LeanTree, i: int, n: Vec, f: Vec) -> Iterator[tuple[int, Expr]]:
    """Yield every ancestor of joint i with the part of a wrench in frame i that its joint feels."""
    j = i
    while tree.parent[j] and not tree.link[j].fixed:
        n, f = tree.link[j].wrench_back(n, f)
        j = tree.parent[j]
        yield j, f[2] if tree.slides[j] else n[2]
    run = _start(tree, j)
    while tree.parent[j]:
        link, p = tree.link[j], tree.parent[j]
        if link.fixed:
            n, f = _leave(run, link, n, f)
            run = _start(tree, p)
        else:
            run = _extend(run, link, tree.link[p])
        j = p
        yield j, f[2] if tree.slides[j] else n[2] + run.P[0] * f[1] - run.P[1] * f[0]


def _start(tree: LeanTree, k: int) -> _Run:
    nowhere = zero_vector(tree.graph)
    return _Run(nowhere, nowhere, tree.link[k].turn, tree.link[k].rise)


def _extend(run: _Run, link: Link, below: Link) -> _Run:
    """Return the run with one more link, which turns before the run's."""
    graph = link.rise.graph
    shift = (link.shift[0], link.shift[1], graph.zero)
    c, s, turn = below.turn.cos, below.turn.sin, run.turn
    both = PlanarTurn(2, c * turn.cos - s * turn.sin, s * turn.cos + c * turn.sin)
    rise = run.rise + link.shift[2] + below.rise
    return _Run(add(run.P, turn.out(shift)), below.turn.back(add(run.Q, shift)), both, rise)


def _leave(run: _Run, link: Link, n: Vec, f: Vec) -> tuple[Vec, Vec]:
    """Return the wrench in the frame below the run, whose first link this is."""
    n = run.turn.back((n[0] - run.rise * f[1], n[1] + run.rise * f[0], n[2]))
    f = run.turn.back(f)
    x, y, _ = run.Q
    n = (n[0] + y * f[2], n[1] - x * f[2], n[2] + x * f[1] - y * f[0])
    zero = run.rise.graph.zero
    return Link(link.shift, link.fixed, PlanarTurn(2, run.rise.graph.one, zero), zero).wrench_back(n, f)
