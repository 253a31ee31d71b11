"""Scenes with contacts, of which several files of tests speak."""

from __future__ import annotations

import json
from pathlib import Path

DATA = Path(__file__).parent / "data" / "impacts"
CASES = {one["id"]: one for one in json.loads((DATA / "references.json").read_text())["cases"]}
"""Published figures and closed forms."""

AXES = {"x": "[1, 0, 0]", "y": "[0, 1, 0]", "z": "[0, 0, 1]"}

DOWN = "gravity = [0, 0, -9.81]\n"


def sliders(axes: str, body: str = "b", of: str = "mass = 1", **more: str) -> str:
    """Return a body that slides from the ground along axes, which name joints and coordinates, with `more` of each."""
    bodies = [*(f"s_{axis}" for axis in axes[:-1]), body]
    text = "".join(f"[bodies.{name}]\n" for name in bodies) + f"{of}\n"
    for parent, child, axis in zip(("ground", *bodies), bodies, axes, strict=False):
        text += f'[joints.{axis}]\ntype = "prismatic"\nparent = "{parent}"\nchild = "{child}"\naxis = {AXES[axis]}\n'
        text += f'coordinate = "{axis}"\n{more.get(axis, "")}\n'
    return text


ROD = (DATA / "scenes" / "falling_rod_0.36.toml").read_text()

BELT = """
gravity = [0, 0, -9.81]
[bodies]
belt = { mass = 1 }
rail = {}
block = { mass = 1 }
[joints]
belt = { type = "prismatic", parent = "ground", child = "belt", axis = [1, 0, 0], coordinate = "b", motion = "0.5*t" }
slide = { type = "prismatic", parent = "ground", child = "rail", axis = [1, 0, 0], coordinate = "x", start_rates = 0.5 }
lift = { type = "prismatic", parent = "rail", child = "block", axis = [0, 0, 1], coordinate = "z" }
[springs.s]
joint = "slide"
stiffness = 100
[contacts.c]
body = "block"
plane = { body = "belt", normal = [0, 0, 1] }
friction = 0.2
static = 0.4
"""

TWO = """
gravity = [0, 0, 0]
[bodies]
a = { inertia = [2, 2, 2], inertia_about = "com" }
b = { inertia = [3, 3, 3], inertia_about = "com" }
[joints]
a = { type = "revolute", parent = "ground", child = "a", axis = [0, 0, 1], coordinate = "p1", start_rates = 10 }
[joints.b]
type = "revolute"
parent = "a"
child = "b"
axis = [0, 0, 1]
coordinate = "p2"
start_rates = 90
friction = { coulomb = 20 }
"""

FALL = f'{DOWN}[parameters]\ne = 0.7\n{sliders("z", z="start = 0")}[contacts.f]\nbody = "b"\nrestitution = "e"\n'

KNEE = """
gravity = [0, 0, -9.81]
[bodies]
b = { mass = 2, com = [0.5, 0, 0], inertia = [0, 0.2, 0.2], inertia_about = "com" }
[joints.h]
type = "revolute"
parent = "ground"
child = "b"
axis = [0, 1, 0]
coordinate = "q"
limits = { lower = -1, upper = 0.5, restitution = 0 }
"""

LOOPED = """
gravity = [0, 0, -9.81]
[bodies]
left = { mass = 1, com = [0.2, 0, 0], inertia = [0.02, 0.02, 0.02], inertia_about = "com" }
right = { mass = 2, com = [0.3, 0, 0], inertia = [0.03, 0.03, 0.03], inertia_about = "com" }
coupler = { mass = 3 }
[joints]
a = { type = "revolute", parent = "ground", child = "left", axis = [0, 1, 0], coordinate = "a", start = 0.2 }
[joints.b]
type = "revolute"
parent = "ground"
child = "right"
axis = [0, 1, 0]
origin = [1, 0, 0]
coordinate = "b"
start = 0.2
[joints.c]
type = "revolute"
parent = "left"
child = "coupler"
axis = [0, 1, 0]
origin = [0.5, 0, 0]
coordinate = "c"
start = -0.2
[[loop]]
type = "revolute"
parent = "coupler"
child = "right"
axis = [0, 1, 0]
origin = [1, 0, 0]
tip = [-0.5, 0, 0]
[contacts.floor]
body = "coupler"
at = [0.4, 0, -0.1]
restitution = 0.5
friction = 0.2
plane = { at = [0, 0, -0.45], normal = [0, 0, 1] }
"""
"""A parallelogram, which is a pendulum of one angle."""

ALONE = """
gravity = [0, 0, -9.81]
[parameters]
J = "0.02 + 0.03 + 1*0.2**2 + 2*0.3**2 + 3*0.5**2"
Jc = "J - (1*0.2 + 2*0.3 + 3*0.5)**2/6"
[bodies]
arm = { mass = 6, com = ["(1*0.2 + 2*0.3 + 3*0.5)/6", 0, 0], inertia = ["Jc/2", "Jc", "Jc/2"], inertia_about = "com" }
[joints]
a = { type = "revolute", parent = "ground", child = "arm", axis = [0, 1, 0], coordinate = "a", start = 0.2 }
[contacts.floor]
type = "gap"
gap = "0.35 - 0.5*sin(a)"
tangent = "-0.5*a_dot*sin(a)"
restitution = 0.5
friction = 0.2
"""


def row_of_balls(law: str, restitution: float = 1) -> str:
    text = "gravity = [0, 0, 0]\n"
    for k, name in enumerate("abc"):
        text += f'[bodies.{name}]\nmass = 1\n[joints.{name}]\ntype = "prismatic"\nparent = "ground"\nchild = "{name}"\n'
        text += f'axis = [1, 0, 0]\ncoordinate = "x{name}"\nstart = {min(k, 1)}\nstart_rates = {1 - min(k, 1)}\n'
    for one, other in ("ab", "bc"):
        text += f'[contacts.{one}{other}]\ntype = "gap"\ngap = "x{other} - x{one}"\nlaw = "{law}"\n'
        text += f"restitution = {restitution}\n"
    return text


def wheel(slope: float, spokes: int = 8) -> str:
    text = f'gravity = ["9.81*sin({slope})", "-9.81*cos({slope})", 0]\n'
    text += sliders("xy", of="", x='start_rates = "cos(pi/8)"', y='start = "cos(pi/8)"\nstart_rates = "sin(pi/8)"')
    text += """
[bodies.wheel]
mass = 1
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[joints.turn]
type = "revolute"
parent = "b"
child = "wheel"
axis = [0, 0, 1]
coordinate = "theta"
start_rates = -1
"""
    for k in range(spokes):
        angle = f"-pi/2 - pi/{spokes} + {k}*2*pi/{spokes}"
        text += f'[contacts.s{k}]\nbody = "wheel"\nat = ["cos({angle})", "sin({angle})", 0]\nnormal = [0, 1, 0]\n'
        text += "friction = 10\n"
    return text
