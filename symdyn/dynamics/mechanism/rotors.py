"""Rotor inertia at a ball: alike about all axes, so that nobody can tell how the rotor stands.

    ω = Σ S_k u_k                                       angular velocity of the child relative to the parent
    K = ½ a ω·ω                                         a: the joint's armature, kg m^2
    τ_k = a S_k·α                                       α: its rate, seen from the parent or from the child alike
    α = Σ S_k u̇_k + Σ_{m<k} (S_m × S_k) u_m u_k         for turns one behind the other; S_k u̇_k alone for a quaternion

As at other joints the parent's own turning does not enter: that would be a rotor's gyroscopic effect.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from symdyn.dynamics.mechanism.state import joint_motion
from symdyn.graph import Expr, Graph
from symdyn.scene import JOINTS, Joint, express
from symdyn.spatial import Vec, add, apply, cross, dot, scale, unit_transform, zero_vector


@dataclass(frozen=True)
class BallRotor:
    """The rotor of one ball; see the module's legend.

    Attributes:
        inertia: a, kg m^2.
        velocities: numbers from 0 of the three velocities.
        S: one a velocity, in axes behind the first turn, or (a quaternion's) in the moved ones.
        bent: pairs m < k with S_m × S_k.
    """

    inertia: Expr
    velocities: tuple[int, ...]
    S: tuple[Vec, ...]
    bent: tuple[tuple[int, int, Vec], ...]

    def forces(self, qd: Sequence[Expr], qdd: Sequence[Expr]) -> list[Expr]:
        """Return what turns the rotor along each of the ball's velocities, N m, for those of the scene."""
        u, du = ([of[k] for k in self.velocities] for of in (qd, qdd))
        alpha = zero_vector(self.inertia.graph)
        for S, rate in zip(self.S, du, strict=True):
            alpha = add(alpha, scale(rate, S))
        for m, k, across in self.bent:
            alpha = add(alpha, scale(u[m] * u[k], across))
        return [self.inertia * dot(S, alpha) for S in self.S]

    def entries(self) -> Iterator[tuple[int, int, Expr]]:
        """Yield rows and columns of the mass matrix and what the rotor adds there, kg m^2."""
        for i, first in zip(self.velocities, self.S, strict=True):
            for j, second in zip(self.velocities, self.S, strict=True):
                yield i, j, self.inertia * dot(first, second)


def ball_rotor(joint: Joint, velocities: Sequence[int], graph: Graph) -> BallRotor | None:
    """Return the rotor of a ball whose velocities have these numbers; None where there is none, or it is no ball."""
    inertia = express(joint.armature, graph)
    if inertia.is_zero or not JOINTS[joint.type].ball(joint):
        return None
    place, S = unit_transform(graph), []
    for k, move in enumerate(joint_motion(joint, graph).moves):
        if k:  # what stands in front of the first turn, or of the axes of a quaternion, turns all of S alike
            place = place @ move.before
        S.append(apply(place.R, move.axis))
        if k:
            place = place @ move.placement
    pairs = [] if joint.velocities else [(0, 1), (0, 2), (1, 2)]
    return BallRotor(inertia, tuple(velocities), tuple(S), tuple((m, k, cross(S[m], S[k])) for m, k in pairs))
