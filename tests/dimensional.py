"""A pendulum whose letters say their units, one of them none, for tests of dimensions."""

from __future__ import annotations

from symdyn.scene import Scene, read_text

PENDULUM = """
gravity = [0, "-g", 0]
[parameters]
g = { value = 9.81, unit = "m/s^2" }
m = { value = 2, unit = "kg" }
l = { value = 0.5, unit = "m" }
k = { value = 3, unit = "N/m" }
b = { value = 0.1, unit = "N m s/rad" }
w = { value = 4, unit = "rad/s" }
p = 7
[inputs.u]
unit = "V"
[bodies.bob]
mass = "m"
com = [0, "-l", 0]
inertia = ["m*l**2/12", 0, "m*l**2/12"]
inertia_about = "com"
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
coordinate = "phi"
force = "-b*phi_dot - m*g*l*sin(phi - w*t)"
[points.tip]
body = "bob"
at = [0, "-l", 0]
"""


def pendulum(old: str = "", new: str = "", more: str = "") -> Scene:
    assert old in PENDULUM
    return read_text(PENDULUM.replace(old, new, 1) + more, "p.toml")


def output(formula: str, more: str = "") -> str:
    return f'[outputs]\ny = {{ formula = "{formula}"{more} }}\n'
