"""Kane's equations F_r + F_r* = 0: forces times partial velocities, body by body, without energies.

Reference: Kane and Levinson, Dynamics: Theory and Applications (1985), sections 2.14, 4.4, 4.11.

    u_r          generalized speeds: the velocities of the scene
    v_r, ω_r     partial velocities ∂v/∂u_r, ∂ω/∂u_r of a body's point P and of the body, ground frame
    a, α         dv/dt and dω/dt
    m, h, I      mass, Σ m r and inertia about P: the centre of mass where the scene gives it, else the frame's origin

    F_r  = Σ v_r·m g + ω_r·(h × g) + what struts, dampers, loads and drives do
    F_r* = -Σ v_r·(m a + α × h + ω × (ω × h)) + ω_r·(h × a + I α + ω × I ω)

Partial velocities come from velocities of points, and accelerations from these: no energy, no recursion. Struts and
loads are forces at points, too, no slopes of a length or an energy. So this is a third derivation, which shares with
the two others the scene, the joints' own placements and rates, and the laws of force.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symdyn.dynamics.mechanism.ropes import Taut
from symdyn.dynamics.mechanism.state import (
    State,
    body_placements,
    carried,
    declared_forces,
    joint_of,
    joint_resistance,
    load_vectors,
    pull,
    vector,
)
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, gradient, substitute, tangents
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.scene.values import Place
from symdyn.spatial import Inertia, Mat, Transform, Vec, Wrench, add, cross, dot, scale, sub, zero_vector

Partial = tuple[Wrench, ...]
"""Partial velocities (v_r, ω_r) of a place on a body for every generalized speed, ground frame."""


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
    partial: Partial
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
                found.append(_part(body.name, Inertia(particle.mass.express(graph), still, none), at, state))
            at = T if body.about != "com" or body.com is None else Transform(T.R, T.point(vector(body.com, graph)))
            h = still if at is not T else body.mass_moment(graph)
            inertia = Inertia(body.mass.express(graph), h, Mat.symmetric(*(x.express(graph) for x in body.inertia)))
            if inertia != Inertia.none(graph):
                found.append(_part(body.name, inertia, at, state))
        for joint in scene.joints:
            a = joint.armature.express(graph)
            if not a.is_zero and JOINTS[joint.type].ball(joint):
                inertia = Inertia(graph.zero, zero_vector(graph), Mat.symmetric(a, a, a, *(graph.zero,) * 3))
                turned = Transform(joint_motion(joint, graph).placement.R, zero_vector(graph))
                found.append(_part(joint.name, inertia, turned, state))
        return cls(scene, graph, state, tuple(found))

    def active_forces(self) -> list[Expr]:
        """Return F_r without drives: weights, springs, dampers, friction, loads, declared forces; shape (nv,)."""
        gravity = vector(self.scene.gravity, self.graph)
        acts = [(part.partial, part.weight(gravity)) for part in self.bodies]
        total = self._summed(self._resisted(), [*acts, *self._pushed()])
        for forces in self._pulled():
            total = [one + force for one, force in zip(total, forces, strict=True)]
        return total

    def rotor_forces(self) -> list[Expr]:
        """Return the part in F_r* of rotors of turning and sliding joints: -armature · d(rate)/dt ∂rate/∂u_r."""
        total = [self.graph.zero] * self.state.n
        for a, rate, faster in self._rotors():
            slopes = gradient(rate, self.state.qd)
            total = [force - a * faster * slope for force, slope in zip(total, slopes, strict=True)]
        return total

    def inertia_forces(self) -> list[Expr]:
        """Return F_r* of all parts and rotors."""
        return self._summed(self.rotor_forces(), [(part.partial, part.inertia_force) for part in self.bodies])

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

    def _summed(self, total: list[Expr], acts: Sequence[tuple[Partial, Wrench]]) -> list[Expr]:
        for partial, wrench in acts:
            total = [force + share for force, share in zip(total, map(wrench.power, partial), strict=True)]
        return total

    def _resisted(self) -> list[Expr]:
        """Return what joints declare, less damping, friction and struts at them along the slopes of their rates."""
        total, graph = declared_forces(self.scene, self.graph), self.graph
        against = [(rate, joint_resistance(one, rate)) for one in self.scene.joints for rate in one.speeds(graph)]
        for strut in self.scene.struts:
            if strut.joint:
                joint = joint_of(self.scene, strut)
                (rate,) = joint.speeds(graph)
                against.append((rate, FORCES[strut.kind].pull.force(strut, joint.position(graph), rate)))
        for rate, force in against:
            slopes = gradient(rate, self.state.qd)
            total = [one - force * slope for one, slope in zip(total, slopes, strict=True)]
        return total

    def _pulled(self) -> Iterator[list[Expr]]:
        """Yield the forces of struts between points and of ropes along every velocity.

        What a unit pulls with at the places takes the power that the length grows by, s ṡ where that is of size s.
        """
        graph, placed, taut = self.graph, body_placements(self.scene, self.graph), Taut(self.scene, self.graph)
        for strut in (one for one in self.scene.struts if one.ends):
            law = FORCES[strut.kind].pull
            if strut.is_rope:
                acts = taut.pulls(strut.ends, placed)
            else:
                a, b = (placed[end.body].point(vector(end.at, graph)) for end in strut.ends)
                apart = Wrench(sub(b, a), zero_vector(graph))
                acts = list(zip(strut.ends, (apart, -apart), strict=True))
            moved = [self._moved(place, placed[place.body]) for place, _ in acts]
            wrenches = [wrench for _, wrench in acts]
            slopes = [
                graph.total(map(Wrench.power, wrenches, columns))
                for columns in zip(*(partial for _, partial in moved), strict=True)
            ]
            rate = -graph.total(map(Wrench.power, wrenches, (twist for twist, _ in moved)))
            if strut.is_rope:
                size = law.force(strut, taut.placed(strut.ends, placed), rate)
            else:
                square = dot(apart.force, apart.force)
                resists = law.energy is None and not square.is_zero
                size = pull(strut, square, rate / graph.sqrt(square) if resists else graph.zero)
            yield [size * slope for slope in slopes]

    def _pushed(self) -> Iterator[tuple[Partial, Wrench]]:
        """Yield what loads exert, and the partial velocities of their places."""
        placed = body_placements(self.scene, self.graph) if self.scene.loads else {}
        for load in self.scene.loads:
            T = placed[load.place.body]
            wrench = load_vectors(load, self.scene, self.graph)
            wrench = wrench.rotated(T.R) if load.frame == "body" else wrench
            yield self._moved(self.scene.seated(load).place, T)[1], wrench + carried(load, self.scene, T)

    def _moved(self, place: Place, T: Transform) -> tuple[Wrench, Partial]:
        """Return velocity and angular velocity of a place on a body, and its partial velocities."""
        return _motion(Transform(T.R, T.point(vector(place.at, self.graph))), self.state)


def _part(name: str, inertia: Inertia, T: Transform, state: State) -> KaneBody:
    (v, w), partial = _motion(T, state)
    x = tangents((*v, *w), state.acceleration)
    turned = T.R @ inertia.I @ T.R.T
    a, dw = (x[0], x[1], x[2]), (x[3], x[4], x[5])
    return KaneBody(name, inertia.m, T.R @ inertia.h, turned, partial, v, w, a, dw, T.R)


def _motion(T: Transform, state: State) -> tuple[Wrench, Partial]:
    """Return (v, ω) of a placement, ω̃ = Ṙ Rᵀ, ground frame, and its slope by every generalized speed."""
    moved, one = (*T.p, *T.R[0], *T.R[1], *T.R[2]), T.p[0].graph.one

    def twist(x: Sequence[Expr]) -> Wrench:
        return Wrench((x[0], x[1], x[2]), T.R.spin((x[3:6], x[6:9], x[9:12])))

    rates = tangents(moved, state.velocity)
    partial = tuple(twist(tangents(rates, {u: one})) for u in state.qd)
    total = twist(tangents(moved, state.clock)) if state.clock else Wrench.none(one.graph)
    for u, column in zip(state.qd, partial, strict=True):
        total = total + column.scaled(u)
    return total, partial
