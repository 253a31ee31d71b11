"""A cart that an input drives in time, with a pole: a function of q, qd, tau, t, inputs and params, all at once."""

DRIVEN = """
name = "driven"
gravity = [0, "-g", 0]
[parameters]
m = {}
g = 9.81
[inputs.u]
unit = "N"
[bodies.cart]
mass = "m"
[bodies.bob]
particles = [{ mass = "m", at = [0, -1, 0] }]
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
force = "u*sin(3*t) - 2*x_dot*abs(x_dot)"
[joints.hinge]
type = "revolute"
parent = "cart"
child = "bob"
axis = [0, 0, 1]
coordinate = "a"
"""
