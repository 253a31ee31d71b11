"""Scenes with names: the arms of the textbook and of the oracles, and small ones that laws are tried on."""

from __future__ import annotations

import random
from fractions import Fraction
from pathlib import Path

from oracles import oracle

from symdyn.scene import Scene, body, point, prismatic, read, read_text, revolute, scene

EXAMPLES = Path(__file__).parent.parent / "examples"


def two_link() -> Scene:
    """Example 5.28, figure 5.40: q1 from the downward vertical, q2 relative; params m1, m2, h1, h2, g."""
    return read(EXAMPLES / "two_link.toml")


def chain(n: int, length: Fraction = Fraction(1)) -> Scene:
    """n equal links (m) that end in unit point masses, relative angles from the downward vertical."""
    links = range(n)
    return scene(
        f"chain{n}",
        gravity=[0, "-9.81", 0],
        bodies=[body(f"b{i}", particles=[{"mass": 1, "at": [0, -length, 0]}]) for i in links],
        joints=[
            revolute(f"j{i}", f"b{i - 1}" if i else "ground", f"b{i}", origin=[0, -length if i else 0, 0])
            for i in links
        ],
    )


def puma560() -> Scene:
    """Corke's PUMA 560 in a standard Denavit-Hartenberg table, without motors; right angles are exact."""
    return read(EXAMPLES / "puma560.toml")


def three_link() -> Scene:
    """The three-link arm of Modern Robotics, chapter 8 docstrings.

    At q = 0 frame {i} stands in the centre of mass of link i, at M_01 … M_(i-1)i; the screw axes S_i are given in {0}:
    ω = (1, 0, 1) through (-1, 0, 0), which is no unit vector, so the published q1 counts the turn in units of sqrt(2)
    rad; then y through (0, 0, 0.089), and y through (0.425, 0, 0.089). Link frames here keep {0}'s directions.
    """
    first, second, third = oracle("modern_robotics_3link")["data"]["G"]
    return scene(
        "three_link",
        gravity=[0, 0, "-9.8"],
        bodies=[
            body("link1", mass=first[3], com=[1, 0, ".089159"], inertia=first[:3], about="com"),
            # {2} and {3} are turned by Ry(90°) against {0}: their x is -z, their z is x
            body("link2", mass=second[3], com=[".28", ".13585", ".000159"], inertia=second[2::-1], about="com"),
            body("link3", mass=third[3], com=[".25", ".01615", ".000159"], inertia=third[2::-1], about="com"),
        ],
        joints=[
            revolute("j1", "ground", "link1", axis=[1, 0, 1], origin=[-1, 0, 0]),
            revolute("j2", "link1", "link2", axis=[0, 1, 0], origin=[1, 0, ".089"]),
            revolute("j3", "link2", "link3", axis=[0, 1, 0], origin=[".425", 0, 0]),
        ],
        points=[point("tip", "link3", [("Tx", ".39225"), ("Ty", ".01615"), ("Tz", ".000159"), ("Ry", "pi/2")])],
    )


def cart_pole() -> Scene:
    """A cart on a rail with a pole that hangs from it: P, R."""
    return scene(
        "cart_pole",
        parameters=dict.fromkeys(("mc", "mp", "l", "I", "g")),
        gravity=[0, "-g", 0],
        bodies=[
            body("cart", mass="mc"),
            body("pole", mass="mp", com=[0, "-l", 0], inertia={"zz": "I"}, about="com", allow_invalid_inertia=True),
        ],
        joints=[
            prismatic("rail", "ground", "cart", axis=[1, 0, 0], coordinate="x", drive="F"),
            revolute("hinge", "cart", "pole", axis=[0, 0, 1], coordinate="phi", drive=False),
        ],
    )


def spatial_arm() -> Scene:
    """Two crossed revolute joints and a prismatic one: R, R, P in space, with every product of inertia."""
    tensor = {"xx": 2, "yy": 3, "zz": "5/2", "xy": "1/10", "xz": "-1/5", "yz": "1/4"}
    return scene(
        "spatial_arm",
        parameters=dict.fromkeys(("m1", "m2", "m3", "a", "g")),
        gravity=[0, 0, "-g"],
        bodies=[
            body("base", mass="m1", com=["1/10", "-1/5", "3/10"], inertia=tensor, about="com"),
            body("arm", mass="m2", com=["1/2", "1/7", 0], inertia=tensor, about="com"),
            body("slide", mass="m3", com=[0, "1/9", "1/3"], inertia=tensor, about="com"),
        ],
        joints=[
            revolute("turn", "ground", "base", axis=[0, 0, 1]),
            revolute("tilt", "base", "arm", axis=[0, 3, 4], origin=["a", 0, "1/2"]),
            prismatic("reach", "arm", "slide", axis=[1, 0, 0], origin=[0, "1/4", 0]),
        ],
    )


LINK = """
[bodies.b{i}]
mass = {mass}
com = [0.05, -0.08, 0.1]
inertia = {inertia}
inertia_about = "com"
[joints.j{i}]
type = "revolute"
parent = "{parent}"
child = "b{i}"
axis = {axis}
origin = {{ xyz = [0.01, 0.02, 0.2], rpy = {rpy} }}
"""


def turning_chain(n: int, kind: str = "any") -> Scene:
    """Return a chain of joints that turn every way, one in a plane, or a tree of two branches at each body."""
    rng = random.Random(n)
    links = []
    for i in range(n):
        plane = kind == "plane"
        above = (i - 1) // 2 if kind == "tree" else i - 1
        links.append(
            LINK.format(
                i=i,
                parent=f"b{above}" if i else "ground",
                mass=round(rng.uniform(0.5, 2), 3),
                inertia="[0.05, 0.04, 0.03]"
                if plane
                else "{ xx = 0.05, yy = 0.04, zz = 0.03, xy = 0.001, yz = -0.001 }",
                axis=[0, 1, 0] if plane else [int(i % 3 == k) for k in range(3)],
                rpy=[0, 0, 0] if plane else [round(rng.uniform(-1, 1), 3) for _ in range(3)],
            )
        )
    return read_text(f'name = "chain{n}"\n' + "".join(links))
