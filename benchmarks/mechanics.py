"""The same robots in SymPy's own mechanics, by Lagrange and by Kane, as its manual shows.

Only what the timed robots need: rotary joints, bodies with a centre of mass and an inertia about it, standard gravity.
"""

from __future__ import annotations

from typing import Any

import sympy
from sympy.physics.mechanics import (
    KanesMethod,
    LagrangesMethod,
    Lagrangian,
    Point,
    ReferenceFrame,
    RigidBody,
    dynamicsymbols,
    inertia,
)

from symdyn.scene import Quantity, Scene

AXES = {"x": 0, "y": 1, "z": 2}


class Robot:
    """Bodies, coordinates, loads and driving forces of a scene."""

    def __init__(self, scene: Scene) -> None:
        n = len(scene.coordinates)
        self.q, self.u = dynamicsymbols(f"q1:{n + 1}"), dynamicsymbols(f"u1:{n + 1}")
        self.drive = sympy.symbols(f"tau1:{n + 1}")
        self.ground, self.origin = ReferenceFrame("N"), Point("O")
        self.origin.set_vel(self.ground, 0)
        self.bodies: list[Any] = []
        self.loads: list[Any] = []
        self.places = {"ground": (self.ground, self.origin)}

    def fill(self, scene: Scene, speeds: bool) -> Robot:
        """Add the bodies; with `speeds` angular velocities are in u, else in the derivatives of q."""
        for k, (joint, body) in enumerate(zip(scene.joints, scene.bodies, strict=True)):
            frame, point = self.places[joint.parent]
            parent = frame
            for i, (step, quantity) in enumerate(joint.origin.steps):
                axis, amount = AXES[step[1].lower()], number(quantity)
                if step[0] == "T":
                    point = point.locatenew(f"P{k}_{i}", amount * list(frame)[axis])
                else:
                    frame = frame.orientnew(f"F{k}_{i}", "Axis", [amount, list(frame)[axis]])
            axis = sum(number(x) * e for x, e in zip(joint.axis, frame, strict=True))
            turned = frame.orientnew(f"B{k}", "Axis", [self.q[k], axis])
            rate = self.u[k] if speeds else self.q[k].diff()
            turned.set_ang_vel(frame, rate * axis)
            point.v2pt_theory(self.places[joint.parent][1], self.ground, parent)
            com = point.locatenew(f"G{k}", sum(number(x) * e for x, e in zip(body.com, turned, strict=True)))
            com.v2pt_theory(point, self.ground, turned)
            xx, yy, zz, xy, xz, yz = (number(x) for x in body.inertia)
            dyadic = inertia(turned, xx, yy, zz, xy, yz, xz)
            mass = number(body.mass)
            self.bodies.append(RigidBody(f"body{k}", com, turned, mass, (dyadic, com)))
            self.bodies[-1].potential_energy = (
                mass * sympy.Rational(981, 100) * com.pos_from(self.origin).dot(self.ground.z)
            )
            self.loads += [(com, -mass * sympy.Rational(981, 100) * self.ground.z), (turned, self.drive[k] * axis)]
            self.loads.append((frame, -self.drive[k] * axis))
            self.places[body.name] = (turned, point)
        return self


def number(quantity: Any) -> Any:
    """Return a quantity of a scene for SymPy, exact where it is rational; ±π/2 stay what they are."""
    if quantity == Quantity.ZERO:
        return sympy.Integer(0)
    value = quantity.at({})
    quarters = float(value) / (float(sympy.pi) / 2)
    if quarters and abs(quarters - round(quarters)) < 1e-12 and not hasattr(value, "numerator"):
        return round(quarters) * sympy.pi / 2
    return sympy.Rational(value.numerator, value.denominator) if hasattr(value, "numerator") else sympy.Float(value)


def kane(scene: Scene) -> Any:
    """Return Kane's equations."""
    robot = Robot(scene).fill(scene, speeds=True)
    kinematic = [q.diff() - u for q, u in zip(robot.q, robot.u, strict=True)]
    method = KanesMethod(robot.ground, robot.q, robot.u, kd_eqs=kinematic)
    method.kanes_equations(robot.bodies, robot.loads)
    return method, robot


def lagrange(scene: Scene) -> Any:
    """Return Lagrange's equations."""
    robot = Robot(scene).fill(scene, speeds=False)
    energy = Lagrangian(robot.ground, *robot.bodies)
    loads = [load for load in robot.loads if load[1].args and not hasattr(load[0], "pos_from")]
    method = LagrangesMethod(energy, robot.q, forcelist=loads, frame=robot.ground)
    method.form_lagranges_equations()
    return method, robot
