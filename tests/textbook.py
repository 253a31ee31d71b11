"""Example 5.28 of the textbook as a reader works through it: hand-typed formulas beside what symdyn derives.

Formulas are typed as text in the book's letters and parsed onto the graph of the derivation:

    c1 s1 c2 s2 c12 s12     cosines and sines of q1, q2, q1 + q2
    v1 v2, a1 a2            q̇1 q̇2, q̈1 q̈2
    x2 y2                   place of m2, derived: the end point of link 2
    m1 m2 h1 h2 g           as in figure 5.40
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

from arms import two_link

from symdyn.dynamics import Workspace, derive_one
from symdyn.graph import Expr, gradient, substitute, tangents
from symdyn.scene import Quantity, Scene, parse
from symdyn.scene.values import Parameter, Point, Pose, velocity_name
from symdyn.verify.equality import Claim, prove

ENDS = (
    Point("end1", "link1", Pose((("Ty", -Quantity.symbol("h1")),))),
    Point("end2", "link2", Pose((("Ty", -Quantity.symbol("h2")),))),
)


def with_ends(scene: Scene) -> Scene:
    """Return the arm with its two end points named."""
    return replace(scene, points=ENDS)


def only_mass(k: int) -> Scene:
    """Return the arm with mass k alone: 1 or 2."""
    scene = two_link()
    return replace(scene, bodies=tuple(b if b.name == f"link{k}" else replace(b, particles=()) for b in scene.bodies))


def with_friction() -> Scene:
    """Return the arm with viscous friction -b q̇ in both joints, a non-conservative action of (5.22)."""
    scene = two_link()
    b = Parameter("b")
    joints = tuple(replace(joint, forces=(parse(f"-b*{velocity_name(joint.coordinate)}"),)) for joint in scene.joints)
    return replace(scene, parameters=(*scene.parameters, b), joints=joints)


class Arm:
    """What symdyn derives for example 5.28 by one formulation, under the book's names."""

    def __init__(self, formulation: str, scene: Scene | None = None) -> None:
        """Choose "lagrange" (positions differentiated) or "recursive" (Newton-Euler along the tree)."""
        self.formulation = formulation
        self.w = Workspace(with_ends(scene or two_link()))
        self.graph, self.state = self.w.graph, self.w.state

    def entries(self, request: str, workspace: Workspace | None = None) -> tuple[Expr, ...]:
        """Return the entries of an output by this formulation."""
        name = request.partition(":")[0]
        recursive = {"mass_matrix": "crba", "k_z": "crba", "potential_energy": "recursive", "pose": "recursive"}
        recursive["jacobian"] = "recursive"
        by_positions = {"pose": "positions", "jacobian": "differentiation"}
        formulation = (
            recursive.get(name, "rnea") if self.formulation == "recursive" else by_positions.get(name, "lagrange")
        )
        return derive_one(workspace or self.w, request, formulation).entries

    # Energies

    def energy(self, which: str, mass: int) -> Expr:
        """Return the "kinetic_energy" or "potential_energy" of mass 1 or 2 alone."""
        return self.entries(which, Workspace(only_mass(mass)))[0]

    @cached_property
    def L(self) -> Expr:
        """The Lagrangian K - P."""
        return self.entries("kinetic_energy")[0] - self.entries("potential_energy")[0]

    # Kinematics

    def place(self, end: str) -> tuple[Expr, Expr]:
        """Return x and y of an end point or of a link's origin."""
        T = self.entries(f"pose:{end}")
        return T[3], T[7]

    def twist(self, end: str) -> list[Expr]:
        """Return [v; ω] of an end point, from its Jacobian."""
        J = self.entries(f"jacobian:{end}")
        v1, v2 = self.state.qd
        return [J[2 * row] * v1 + J[2 * row + 1] * v2 for row in range(6)]

    # Lagrange's terms

    def slope(self, i: int) -> Expr:
        """Return ∂L/∂q_i, i = 1 or 2."""
        return gradient(self.L, self.state.q)[i - 1]

    def momentum(self, i: int) -> Expr:
        """Return ∂L/∂q̇_i."""
        return gradient(self.L, self.state.qd)[i - 1]

    def rate(self, node: Expr) -> Expr:
        """Return d/dt of a function of q and q̇."""
        s = self.state
        return tangents([node], dict(zip(s.q + s.qd, s.qd + s.qdd, strict=True)))[0]

    # Torques

    def torque(self, i: int) -> Expr:
        """Return M_i, the driving torque of joint i."""
        return self.entries("inverse_dynamics")[i - 1]

    def induced(self, i: int, alone: str) -> Expr:
        """Return the torque in axis i without gravity when `alone` ("v1", "a2", ...) is all the motion there is."""
        rates = {"v1": self.state.qd[0], "v2": self.state.qd[1], "a1": self.state.qdd[0], "a2": self.state.qdd[1]}
        off = {node: self.graph.zero for letter, node in rates.items() if letter != alone}
        return substitute([self.torque(i)], {**off, self.graph.symbol("g"): self.graph.zero})[0]

    def k(self, name: str, i: int, j: int = 1) -> Expr:
        """Return a coefficient with this product's sign: k("z", 1, 2), k("D", 2, 1), k("C", 1), k("G", 2)."""
        columns = {"z": 2, "D": 2, "C": 1, "G": 1}[name]
        return self.entries(f"k_{name}")[columns * (i - 1) + j - 1]

    # Formulas typed by hand

    def typed(self, text: str) -> Expr:
        """Return a formula in the book's letters as a node."""
        graph, (q1, q2) = self.graph, self.state.q
        x2, y2 = self.place("end2")
        letters = {
            **{"c1": graph.cos(q1), "s1": graph.sin(q1), "c2": graph.cos(q2), "s2": graph.sin(q2)},
            **{"c12": graph.cos(q1 + q2), "s12": graph.sin(q1 + q2), "x2": x2, "y2": y2},
            **dict(zip(("v1", "v2", "a1", "a2"), self.state.qd + self.state.qdd, strict=True)),
        }
        meanings = {graph.symbol(letter): node for letter, node in letters.items()}
        return substitute([parse(text).express(graph)], meanings)[0]


def verdict(left: Expr, right: Expr) -> str:
    """Return what the finite fields say of left = right."""
    return prove([Claim("equation", "derived", "typed", (left,), (right,))])[1][0].verdict
