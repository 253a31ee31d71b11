"""Lagrange's equations of the second kind: K and P from positions, L = K - P differentiated automatically.

Reference: the textbook, section 5.1.2, eq. (5.21)-(5.23).

    T[B]     placement of body B in the ground frame          v   velocity of a centre of mass, by differentiation
    u        velocities, q̇ as a rule                          X   derivative along them; γ their brackets: kinematics.py
    R, p     its rotation and translation                     ω   from ω̃ = Ṙ Rᵀ, ground frame
    K, P     kinetic and potential energy, J                  L   K - P
    G, E     energy of gravity and of springs, P = G + E

This formulation shares nothing with the recursive one but the scene and the joint's own placement.
"""

from __future__ import annotations

from symdyn.dynamics.mechanism.kinematics import Directions, directions
from symdyn.dynamics.mechanism.state import (
    State,
    body_placements,
    elastic_energy,
    elastic_slopes,
    generalized_forces,
    vector,
)
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, gradient, substitute, tangents
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.scene.values import Body, Joint
from symdyn.spatial import Mat, Transform, Vec, cross, dot


@dataclass(frozen=True)
class Energies:
    """Energies of a scene on its graph, functions of `state`: K, and potential G of gravity and E of springs; J."""

    scene: Scene
    graph: Graph
    state: State
    directions: Directions
    K: Expr
    G: Expr
    E: Expr

    @classmethod
    def of(cls, scene: Scene, graph: Graph) -> Energies:
        """Return K(q, q̇), G(q) = -Σ m g·r, zero where the mass centre passes the ground's origin level, and E(q)."""
        state = State.of(scene, graph)
        rates = state.velocity
        gravity = vector(scene.gravity, graph)
        placed = body_placements(scene, graph)
        kinetic = [_kinetic(body, placed[body.name], rates, graph) for body in scene.bodies]
        kinetic += [rotor_energy(joint, rates, graph) for joint in scene.joints if joint.moves]
        potential = [-dot(gravity, _weighted_place(body, placed[body.name], graph)) for body in scene.bodies]
        K, G = graph.total(kinetic), graph.total(potential)
        return cls(scene, graph, state, directions(scene, graph), K, G, elastic_energy(scene, graph))

    @property
    def P(self) -> Expr:
        return self.G + self.E

    def momenta(self) -> list[Expr]:
        """Return p = ∂L/∂u = M(q) u, shape (nv,); kg m^2/s or kg m/s."""
        return gradient(self.K, self.state.qd)

    def driving_forces(self) -> list[Expr]:
        """Return τ = d/dt p - X L - Σ γ u p - Q^A, shape (nv,); N m or N.

        Eq. (5.21)-(5.23), in the form of Boltzmann and Hamel.
        """
        state, p = self.state, self.momenta()
        inertial = tangents(p, state.acceleration)
        slope = self.directions.slopes(self.K - self.G)
        declared = generalized_forces(self.scene, self.graph)
        forces = [a - b + e - f for a, b, e, f in zip(inertial, slope, self.elastic_forces(), declared, strict=True)]
        for (j, i), terms in self.directions.brackets.items():
            for m, value in terms:
                forces[i] = forces[i] - value * state.qd[j] * p[m]
        return forces

    def mass_matrix(self) -> list[list[Expr]]:
        """Return M = ∂²K/∂q̇², shape (n, n); column j is the momentum at q̇ = e_j, since K is quadratic in q̇."""
        state, graph = self.state, self.graph
        p = self.momenta()
        columns = []
        for j in range(state.n):
            still = {qd: graph.one if k == j else graph.zero for k, qd in enumerate(state.qd)}
            columns.append(substitute(p, still))
        return [[columns[max(i, j)][min(i, j)] for j in range(state.n)] for i in range(state.n)]

    def gravity_forces(self) -> list[Expr]:
        """Return k_G = X G, shape (nv,), ∂G/∂q for rates of coordinates; N m or N."""
        return self.directions.slopes(self.G)

    def elastic_forces(self) -> list[Expr]:
        """Return k_E = X E, shape (nv,), ∂E/∂q for rates of coordinates; N m or N."""
        return elastic_slopes(self.scene, self.graph, self.directions.slopes)


def _kinetic(body: Body, T: Transform, rates: dict[Expr, Expr], graph: Graph) -> Expr:
    """Return ½ m v² + ½ ω·I ω of the extended mass, plus ½ m v² of each particle."""
    total = graph.total(
        _half(graph) * particle.mass.express(graph) * _square(_rate(T.point(vector(particle.at, graph)), rates))
        for particle in body.particles
    )
    m, omega = body.mass.express(graph), _angular_velocity(T.R, rates)
    inertia = Mat.symmetric(*(entry.express(graph) for entry in body.inertia))
    w = T.R.T @ omega  # ω in body coordinates, where the inertia is constant
    spin = _half(graph) * dot(w, inertia @ w)
    if body.about == "com":
        assert body.com is not None
        v = _rate(T.point(vector(body.com, graph)), rates)
        return total + _half(graph) * m * _square(v) + spin
    v = _rate(T.p, rates)  # of the body frame's origin: K = ½ m v² + v·(ω × R h) + ½ ω·I ω, h = m r
    h = body.mass_moment(graph)
    return total + _half(graph) * m * _square(v) + dot(v, cross(omega, T.R @ h)) + spin


def rotor_energy(joint: Joint, rates: dict[Expr, Expr], graph: Graph) -> Expr:
    """Return ½ armature (rate of the joint)², at a ball ½ armature ω² of its relative angular velocity."""
    inertia = joint.armature.express(graph)
    if inertia.is_zero:
        return graph.zero
    if JOINTS[joint.type].ball(joint):
        return _half(graph) * inertia * _square(_angular_velocity(joint_motion(joint, graph).placement.R, rates))
    (rate,) = tangents([joint.position(graph)], rates)
    return _half(graph) * inertia * rate * rate


def _weighted_place(body: Body, T: Transform, graph: Graph) -> Vec:
    """Return Σ m r of the body in the ground frame, kg m."""
    m, h = body.mass.express(graph), T.R @ body.mass_moment(graph)
    total = [m * T.p[k] + h[k] for k in range(3)]
    for particle in body.particles:
        place, mass = T.point(vector(particle.at, graph)), particle.mass.express(graph)
        total = [total[k] + mass * place[k] for k in range(3)]
    return (total[0], total[1], total[2])


def _angular_velocity(R: Mat, rates: dict[Expr, Expr]) -> Vec:
    """Return ω in the ground frame."""
    return R.spin([tangents(row, rates) for row in R])


def _rate(place: Vec, rates: dict[Expr, Expr]) -> Vec:
    x, y, z = tangents(place, rates)
    return (x, y, z)


def _square(v: Vec) -> Expr:
    return dot(v, v)


def _half(graph: Graph) -> Expr:
    return graph.one / 2
