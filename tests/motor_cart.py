"""A cart that a motor drives, its voltage u, with a pole; and its equations by hand."""

from __future__ import annotations

import numpy as np

CART = """
name = "motor_cart"
[parameters]
m = 2
mp = 0.3
l = 0.5
k = { value = 3, unit = "N/V" }
b = 0.4
[inputs.u]
unit = "V"
latex = "u_a"
text = "voltage of the motor"
[bodies.cart]
mass = "m"
[bodies.pole]
mass = "mp"
com = [0, 0, "-l"]
[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
drive = false
force = "k*u - b*x_dot"
[joints.hinge]
type = "revolute"
parent = "cart"
child = "pole"
axis = [0, 1, 0]
coordinate = "theta"
drive = false
start = 0.2
[points.tip]
body = "pole"
at = [0, 0, "-l"]
[outputs.way]
formula = "point_tip_x"
unit = "m"
[outputs]
pull = "reaction_hinge_fx_ground"
"""


def by_hand(q, u, volt):
    """Return accelerations of cart and pole, where the tip is, and what the cart exerts on the pole along x."""
    m, mp, length, k, b = 2, 0.3, 0.5, 3, 0.4
    s, c = np.sin(q[1]), np.cos(q[1])
    M = np.array([[m + mp, -mp * length * c], [-mp * length * c, mp * length**2]])
    a = np.linalg.solve(M, [k * volt - b * u[0] - mp * length * s * u[1] ** 2, -mp * 9.81 * length * s])
    tip = a[0] - length * c * a[1] + length * s * u[1] ** 2
    return a, q[0] - length * s, mp * tip


STATE = np.array([0.1, 0.3]), np.array([0.5, -0.2])
