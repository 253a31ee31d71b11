"""A single-loop spatial mechanism as in figure 5.39 of the textbook, and what its equations are checked with.

R-S-U-P: a crank turns on the ground, a ball carries the coupler, a universal joint the slider, which slides on the
ground and closes the loop. 3 moving bodies, 18 equations, 1 drive: (5.20) is 18 = 1 + (5 + 3 + 4 + 5).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from mechanisms import shape

from symdyn.dynamics import Workspace
from symdyn.dynamics.mechanism.kinematics import centre_of_mass
from symdyn.dynamics.mechanism.state import body_placements
from symdyn.dynamics.reactions.dalembert import Equilibrium
from symdyn.graph import Expr, tangents
from symdyn.scene import Quantity, Scene, parse
from symdyn.scene.values import Body, Joint, Load, Place
from symdyn.scene.values.entry import compose
from symdyn.spatial import Transform
from symdyn.verdict import Verdict
from symdyn.verify.certificate import on_unit_sphere
from symdyn.verify.equality import Claim, prove


def vector(*entries: object) -> tuple:
    return tuple(Quantity.number(Fraction(str(x))) for x in entries)


def heavy(name: str, mass: object, com: tuple, inertia: tuple) -> Body:
    """A body with every product of inertia."""
    return Body(name, Quantity.number(Fraction(str(mass))), vector(*com), None, vector(*inertia), "com", (), True)


def single_loop() -> Scene:
    """R-S-U-P with a technological force on the slider and a couple on the coupler."""
    bodies = (
        heavy("crank", 1, ("1/2", "1/10", "-1/20"), ("1/50", "1/10", "1/9", "1/100", "-1/200", "1/300")),
        heavy("coupler", 2, ("3/2", "1/20", "1/15"), ("1/30", "3/2", "8/5", "1/40", "1/50", "-1/60")),
        heavy("slider", 3, ("1/7", "-1/8", "1/9"), ("1/5", "1/4", "1/3", "1/70", "1/80", "1/90")),
    )
    joints = (
        Joint("R", "revolute", "ground", "crank", coordinates=("q1",), drives=("M",), start=vector("7/10")),
        Joint(
            "S",
            "spherical",
            "crank",
            "coupler",
            origin=compose(("Tx", Quantity.number(1)), ("Rz", Quantity.number(Fraction(1, 5)))),
            tip=compose(("Ty", Quantity.number(Fraction(1, 10)))),
            coordinates=("e0", "e1", "e2", "e3"),
            velocities=("wx", "wy", "wz"),
            start=vector(1, 0, "1/10", "-1/5"),
        ),
        Joint(
            "U",
            "universal",
            "coupler",
            "slider",
            shape=shape("universal", second_axis=vector(0, 1, 0)),
            origin=compose(("Tx", Quantity.number(3))),
            tip=compose(("Tz", Quantity.number(Fraction(-1, 4)))),
            coordinates=("q2", "q3"),
            start=vector("-1/5", "1/10"),
        ),
    )
    loop = Joint(
        "P",
        "prismatic",
        "ground",
        "slider",
        shape=shape("prismatic", axis=vector(1, 0, 0)),
        origin=compose(("Tx", Quantity.number(3)), ("Ty", Quantity.number(Fraction(1, 2)))),
        tip=compose(("Tx", Quantity.number(Fraction(1, 6)))),
    )
    loads = (
        Load(
            "cutting",
            Place("slider", vector("1/5", "1/6", 0)),
            (parse("-10*q2"), Quantity.number(2), Quantity.number(1)),
        ),
        Load("couple", Place("coupler", vector(1, 0, 0)), vector(0, 0, 0), vector(1, -2, 3), "body"),
    )
    gravity = vector(0, "1/3", "-9.81")
    return Scene("rsup", (), gravity, bodies, joints, loops=(loop,), elements=loads)


class Loop:
    """A mechanism with its system (5.18), and its positions by the other formulation, for tests."""

    def __init__(self, scene: Scene) -> None:
        """Derive the system."""
        self.scene, self.w = scene, Workspace(scene)
        self.graph, self.state, self.hanging = self.w.graph, self.w.state, self.w.hanging
        self.system: Equilibrium = Equilibrium.of(self.hanging)
        self.placed = body_placements(scene, self.graph)

    def place(self, j: int) -> Transform:
        """Return the placement of frame j in frame 1, from positions: O_j on the moved joint, axes of the body."""
        T = self.placed[self.scene.bodies[j].name]
        return Transform(T.R, T.point(self.hanging.joints[j].place_on_child))

    def acceleration(self, point: Sequence[Expr]) -> list[Expr]:
        """Return the second derivative of a point of the ground frame."""
        return tangents(tangents(point, self.state.acceleration), self.state.acceleration)

    def centre(self, j: int) -> tuple[Expr, ...]:
        """Return T_j in frame 1; every body here has its centre of mass declared."""
        name = self.scene.bodies[j].name
        return self.placed[name].point(centre_of_mass(self.scene, name, self.graph))

    def verdict(self, left: Sequence[Expr], right: Sequence[Expr]) -> str:
        """Return what the finite fields say of left = right."""
        claims = on_unit_sphere(self.scene, [Claim("equation", "derived", "written out", tuple(left), tuple(right))])
        return prove(claims)[1][0].verdict

    def agrees(self, left: Sequence[Expr], right: Sequence[Expr]) -> bool:
        """Whether left = right is proved."""
        return self.verdict(left, right) == Verdict.PROVED


def matrix_times(M: Sequence[Sequence[Expr]], x: Sequence[Expr]) -> list[Expr]:
    """Return M x for any sizes."""
    return [x[0].graph.total(a * b for a, b in zip(row, x, strict=True)) for row in M]
