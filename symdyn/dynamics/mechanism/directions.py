"""Directions of the velocities on the space of coordinates: derivatives along quasi-velocities, and their brackets.

    q̇ = H(q) u                 kinematic map, H = 1 where the velocities are rates of coordinates
    X_i f = Σ_k H_ki ∂f/∂q_k    derivative along velocity i
    [X_j, X_i] = Σ γ^l_ji X_l    zero for rates of coordinates; ε_jil for angular velocities in the body

Reference: Maruskin, Introduction to Dynamical Systems and Geometric Mechanics (2012), chapter 8 (quasi-velocities,
Boltzmann-Hamel equations).

H also follows from placements, where velocities are no rates of coordinates:

    R, p    placement that a ball or free flight makes, R(e) of the unit quaternion e = (w, x, y, z)
    v, ω    its velocity and angular velocity, both in the moved frame

    Ṙ = R ω̃,  ṗ = R v           4 w² = 1 + tr R,  4 w (x, y, z) = (R_zy - R_yz, R_xz - R_zx, R_yx - R_xy)

The right sides differentiated give ẇ and then ẋ, ẏ, ż; they hold where w is not 0. Generated code takes ½ e ∘ ω, which
every joint says itself and which holds everywhere; this road proves it.

Reference: Shepperd, Quaternion from Rotation Matrix, J. Guidance and Control 1 (1978) 223.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symdyn.dynamics.mechanism.state import joint_motion, state_symbols
from symdyn.graph import Expr, Graph, gradient, tangents
from symdyn.scene import JOINTS, Scene
from symdyn.scene.joints.joint_kind import Block
from symdyn.spatial import apply, multiply, skew

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


def has_quaternions(scene: Scene) -> bool:
    """Tell whether a velocity of the scene is no rate of a coordinate."""
    return len(scene.coordinates) != len(scene.velocities)


def rates_of_placements(scene: Scene, graph: Graph) -> list[Expr]:
    """Return q̇, shape (nq,), from the rates of placements."""
    result: list[Expr] = []
    for joint in scene.moving:
        q = tuple(graph.symbol(name) for name in joint.coordinates)
        u = tuple(graph.symbol(name) for name in joint.rates)
        for block in JOINTS[joint.type].blocks(joint):
            here, q = q[: len(block.coordinates)], q[len(block.coordinates) :]
            moving, u = u[: len(block.velocities)], u[len(block.velocities) :]
            result += _rates(block, here, moving) if block.letters else moving
    return result


def _rates(block: Block, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> list[Expr]:
    """Return the rates of a quaternion, behind those of a position if the block has one."""
    X = block.motion(u[0].graph, q, u).placement
    S = multiply(X.R, skew((u[-3], u[-2], u[-1])))
    w, *vector = q[-4:]
    turning = (S[0][0] + S[1][1] + S[2][2]) / (8 * w)
    twisting = (S[2][1] - S[1][2], S[0][2] - S[2][0], S[1][0] - S[0][1])
    bending = [(twist / 4 - turning * x) / w for twist, x in zip(twisting, vector, strict=True)]
    sliding = apply(X.R, (u[0], u[1], u[2])) if len(u) == 6 else ()
    return [*sliding, turning, *bending]
