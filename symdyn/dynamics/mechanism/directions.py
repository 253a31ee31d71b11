"""Directions of the velocities on the space of coordinates: derivatives along quasi-velocities, and their brackets.

    q̇ = H(q) u                 kinematic map, H = 1 where the velocities are rates of coordinates
    X_i f = Σ_k H_ki ∂f/∂q_k    derivative along velocity i
    [X_j, X_i] = Σ γ^l_ji X_l    zero for rates of coordinates; ε_jil for angular velocities in the body

Reference: Maruskin, Introduction to Dynamical Systems and Geometric Mechanics (2012), chapter 8 (quasi-velocities,
Boltzmann-Hamel equations).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symdyn.dynamics.mechanism.state import joint_motion, state_symbols
from symdyn.graph import Expr, Graph, gradient, tangents
from symdyn.scene import Scene

Brackets = Mapping[tuple[int, int], tuple[tuple[int, int], ...]]


@dataclass(frozen=True)
class Directions:
    """Directions of the velocities.

    Attributes:
        q: coordinates, shape (nq,).
        along: along[i] maps every coordinate that velocity i moves to its rate per unit, H_ki.
        brackets: brackets[j, i] are pairs (l, γ^l_ji).
    """

    q: tuple[Expr, ...]
    along: tuple[dict[Expr, Expr], ...]
    brackets: Brackets

    def slopes(self, f: Expr) -> list[Expr]:
        """Return X_i f, shape (nv,)."""
        partial = dict(zip(self.q, gradient(f, self.q), strict=True))
        return [f.graph.total(h * partial[q] for q, h in seeds.items()) for seeds in self.along]

    def derivative(self, fs: Sequence[Expr], i: int) -> list[Expr]:
        """Return X_i f of several functions."""
        return tangents(fs, self.along[i])


def directions(scene: Scene, graph: Graph) -> Directions:
    """Return the directions of a scene's velocities."""
    state = state_symbols(scene, graph)
    along: list[dict[Expr, Expr]] = [{} for _ in state.qd]
    for q, rate in zip(state.q, state.rates, strict=True):
        for i, h in enumerate(gradient(rate, state.qd)):
            if not h.is_zero:
                along[i][q] = h
    brackets: dict[tuple[int, int], list[tuple[int, int]]] = {}
    first = 0
    for joint in scene.moving:
        for j, i, m, value in joint_motion(joint, graph).brackets:
            brackets.setdefault((first + j, first + i), []).append((first + m, value))
        first += len(joint.rates)
    return Directions(state.q, tuple(along), {pair: tuple(terms) for pair, terms in brackets.items()})
