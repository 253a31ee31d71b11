"""Rates of coordinates q̇ = H(q) u where velocities are no rates of coordinates, by way of placements.

    R, p    placement that a ball or free flight makes, R(e) of the unit quaternion e = (w, x, y, z)
    v, ω    its velocity and angular velocity, both in the moved frame

    Ṙ = R ω̃,  ṗ = R v           4 w² = 1 + tr R,  4 w (x, y, z) = (R_zy - R_yz, R_xz - R_zx, R_yx - R_xy)

The right sides differentiated give ẇ and then ẋ, ẏ, ż; they hold where w is not 0. Generated code takes ½ e ∘ ω, which
every joint says itself and which holds everywhere; this road proves it.

Reference: Shepperd, Quaternion from Rotation Matrix, J. Guidance and Control 1 (1978) 223.
"""

from __future__ import annotations

from symdyn.graph import Expr, Graph
from symdyn.scene import JOINTS, Scene
from symdyn.scene.joints.kind import Block
from symdyn.spatial import apply, multiply, skew


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
