"""Scenes whose motion somebody else has computed, in the oracles' own numbers."""

from __future__ import annotations

from symdyn.scene import Scene, read_text


def point(name: str) -> str:
    return f"[bodies.{name}]\nmass = 1\ncom = [0, -1, 0]\n"


def hinge(name: str, parent: str, child: str, more: str = "") -> str:
    head = f'[joints.{name}]\ntype = "revolute"\nparent = "{parent}"\nchild = "{child}"\naxis = [0, 0, 1]\n'
    return head + more + "\n"


def pendulum() -> Scene:
    return read_text(
        'name = "pendulum"\ngravity = [0, -9.81, 0]\n'
        + point("rod")
        + hinge("hinge", "ground", "rod", 'start = "pi/2"')
    )


def double_pendulum() -> Scene:
    return read_text(
        'name = "double_pendulum"\ngravity = [0, -9.81, 0]\n'
        + point("rod1")
        + point("rod2")
        + hinge("upper", "ground", "rod1")
        + hinge("lower", "rod1", "rod2", "origin = [0, -1, 0]")
    )


def heavy_top() -> Scene:
    return read_text(
        """
        name = "heavy_top"
        [bodies.top]
        mass = 15
        com = [0, 1, 0]
        inertia = [0.234375, 0.46875, 0.234375]
        inertia_about = "com"
        [joints.ball]
        type = "spherical"
        parent = "ground"
        child = "top"
        start_rates = [0, 150, -4.61538]
        """
    )


def free_top() -> Scene:
    return read_text(
        """
        name = "free_top"
        gravity = [0, 0, 0]
        [bodies.top]
        mass = 1
        inertia = [1, 2, 3]
        inertia_about = "com"
        [joints.body]
        type = "free"
        parent = "ground"
        child = "top"
        start_rates = [0.1, -0.2, 0.3, 1e-3, 10, 1e-3]
        """
    )


def block(friction: str = "", start: float = 0.5) -> Scene:
    return read_text(
        f"""
        name = "block"
        gravity = "none"
        [bodies.block]
        mass = 2
        [joints.slide]
        type = "prismatic"
        parent = "ground"
        child = "block"
        axis = [1, 0, 0]
        coordinate = "x"
        drive = "F"
        start = {start}
        {friction}
        [springs.coil]
        joint = "slide"
        stiffness = 50
        free = 0
        """
    )
