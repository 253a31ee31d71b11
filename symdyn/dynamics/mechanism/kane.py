"""Kane's equations F_r + F_r* = 0: forces times partial velocities, body by body, without energies.

Reference: Kane and Levinson, Dynamics: Theory and Applications (1985), sections 2.14, 4.4, 4.11.

    u_r          generalized speeds: the velocities of the scene
    v_r, ω_r     partial velocities ∂v/∂u_r, ∂ω/∂u_r of a body's point P and of the body, ground frame
    a, α         dv/dt and dω/dt
    m, h, I      mass, Σ m r and inertia about P: the centre of mass where the scene gives it, else the frame's origin

    F_r  = Σ v_r·m g + ω_r·(h × g) + what struts, dampers, loads and drives do
    F_r* = -Σ v_r·(m a + α × h + ω × (ω × h)) + ω_r·(h × a + I α + ω × I ω)

Partial velocities come from velocities of points, and accelerations from these: no energy, no recursion, and so a third
derivation, which shares with the two others the scene, the joints' own placements, and the laws of force.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from symdyn.dynamics.mechanism.kinematics import directions
from symdyn.dynamics.mechanism.state import (
    State,
    body_placements,
    elastic_slopes,
    generalized_forces,
    placement_rates,
    vector,
)
from symdyn.graph import Expr, Graph, gradient, substitute, tangents
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.spatial import Inertia, Mat, Transform, Vec, Wrench, add, cross, dot, scale, zero_vector


@dataclass(frozen=True)
class KaneBody:
    """One rigid part of a body, or one particle, about its point P; all vectors in the ground frame.

    Attributes:
        body: its name, or that of the joint whose rotor it is.
        m, h, I: mass, first moment and inertia about P; kg, kg m, kg m^2.
        partial: (v_r, ω_r) for every generalized speed.
        v, w: velocity of P and angular velocity, Σ partial · u.
        a, dw: their rates.
        R: rotation of its body, so that its own axes have Rᵀ v.
    """

    body: str
    m: Expr
    h: Vec
    I: Mat  # noqa: E741  the standard symbol
    partial: tuple[Wrench, ...]
    v: Vec
    w: Vec
    a: Vec
    dw: Vec
    R: Mat

    @property
    def inertia_force(self) -> Wrench:
        """What is taken from the acting forces: -(force, moment about P) of Newton's and Euler's equations."""
        h, w = self.h, self.w
        force = add(scale(self.m, self.a), add(cross(self.dw, h), cross(w, cross(w, h))))
        moment = add(cross(h, self.a), add(self.I @ self.dw, cross(w, self.I @ w)))
        return -Wrench(force, moment)

    @property
    def acceleration_energy(self) -> Expr:
        """½ ∫ a² dm, J/s^2, but for what holds no acceleration: the square of ω × (ω × r)."""
        h, w, dw = self.h, self.w, self.dw
        carried = add(cross(dw, h), cross(w, cross(w, h)))
        turning = dot(dw, self.I @ dw) / 2 + dot(dw, cross(w, self.I @ w))
        return self.m * dot(self.a, self.a) / 2 + dot(self.a, carried) + turning

    def weight(self, g: Vec) -> Wrench:
        """Return the weight as a force at P and a moment about it, N and N m."""
        return Wrench(scale(self.m, g), cross(self.h, g))

    def along(self, wrench: Wrench) -> list[Expr]:
        """Return v_r·force + ω_r·moment for every generalized speed."""
        return [wrench.power(twist) for twist in self.partial]


@dataclass(frozen=True)
class Kane:
    """Kane's equations of a scene on its graph."""

    scene: Scene
    graph: Graph
    state: State
    bodies: tuple[KaneBody, ...]

    @classmethod
    def of(cls, scene: Scene, graph: Graph) -> Kane:
        """Return the parts of all bodies that have a mass or an inertia, then the rotors of joints like balls."""
        state, placed, found = State.of(scene, graph), body_placements(scene, graph), []
        for body in scene.bodies:
            T, still, none = placed[body.name], zero_vector(graph), Inertia.none(graph).I
            for particle in body.particles:
                at = Transform(T.R, T.point(vector(particle.at, graph)))
                found.append(_part(body.name, Inertia(particle.mass.express(graph), still, none), at, scene, state))
            at = T if body.about != "com" or body.com is None else Transform(T.R, T.point(vector(body.com, graph)))
            h = still if at is not T else body.mass_moment(graph)
            inertia = Inertia(body.mass.express(graph), h, Mat.symmetric(*(x.express(graph) for x in body.inertia)))
            if inertia != Inertia.none(graph):
                found.append(_part(body.name, inertia, at, scene, state))
        for joint in scene.joints:
            a = joint.armature.express(graph)
            if not a.is_zero and JOINTS[joint.type].ball(joint):
                inertia = Inertia(graph.zero, zero_vector(graph), Mat.symmetric(a, a, a, *(graph.zero,) * 3))
                turned = Transform(joint_motion(joint, graph).placement.R, zero_vector(graph))
                found.append(_part(joint.name, inertia, turned, scene, state))
        return cls(scene, graph, state, tuple(found))

    def active_forces(self) -> list[Expr]:
        """Return F_r without drives: weights, springs, dampers, friction, loads, declared forces; shape (nv,)."""
        gravity = vector(self.scene.gravity, self.graph)
        springs = elastic_slopes(self.scene, self.graph, directions(self.scene, self.graph).slopes)
        total = generalized_forces(self.scene, self.graph)
        total = [force - spring for force, spring in zip(total, springs, strict=True)]
        return self._summed(total, [(part, part.weight(gravity)) for part in self.bodies])

    def rotor_forces(self) -> list[Expr]:
        """Return the part in F_r* of rotors of turning and sliding joints: -armature · d(rate)/dt ∂rate/∂u_r."""
        total = [self.graph.zero] * self.state.n
        for a, rate, faster in self._rotors():
            slopes = gradient(rate, self.state.qd)
            total = [force - a * faster * slope for force, slope in zip(total, slopes, strict=True)]
        return total

    def inertia_forces(self) -> list[Expr]:
        """Return F_r* of all parts and rotors."""
        return self._summed(self.rotor_forces(), [(part, part.inertia_force) for part in self.bodies])

    def gibbs_function(self) -> Expr:
        """Return S of Gibbs and Appell, without what stays at u̇ = 0, J/s^2; ∂S/∂u̇_r = -F_r*."""
        rotors = (a * faster * faster / 2 for a, _, faster in self._rotors())
        whole = self.graph.total([*(part.acceleration_energy for part in self.bodies), *rotors])
        return whole - substitute([whole], dict.fromkeys(self.state.qdd, self.graph.zero))[0]

    def driving_forces(self) -> list[Expr]:
        """Return τ = -(F_r + F_r*), shape (nv,); N m or N."""
        return [-(a + b) for a, b in zip(self.active_forces(), self.inertia_forces(), strict=True)]

    def _rotors(self) -> Iterator[tuple[Expr, Expr, Expr]]:
        """Yield armature, rate and its rate of joints that turn or slide a rotor."""
        for joint in self.scene.joints:
            a = joint.armature.express(self.graph)
            if joint.moves and not a.is_zero and not JOINTS[joint.type].ball(joint):
                (rate,) = tangents([joint.position(self.graph)], self.state.velocity)
                (faster,) = tangents([rate], self.state.acceleration)
                yield a, rate, faster

    def _summed(self, total: list[Expr], acts: list[tuple[KaneBody, Wrench]]) -> list[Expr]:
        for part, wrench in acts:
            total = [force + share for force, share in zip(total, part.along(wrench), strict=True)]
        return total


def _part(name: str, inertia: Inertia, T: Transform, scene: Scene, state: State) -> KaneBody:
    partial = tuple(placement_rates(T, scene, inertia.m.graph))
    v, w = (_total(inertia.m.graph, [scale(u, twist[k]) for u, twist in zip(state.qd, partial, strict=True)])
            for k in (0, 1))  # fmt: skip
    x = tangents((*v, *w), state.acceleration)
    turned = T.R @ inertia.I @ T.R.T
    a, dw = (x[0], x[1], x[2]), (x[3], x[4], x[5])
    return KaneBody(name, inertia.m, T.R @ inertia.h, turned, partial, v, w, a, dw, T.R)


def _total(graph: Graph, vectors: list[Vec]) -> Vec:
    total = zero_vector(graph)
    for one in vectors:
        total = add(total, one)
    return total
