"""Robots by their modified Denavit-Hartenberg tables, as the literature counts their operations.

Lengths are free parameters, so that only their zeros are known; right angles are exact. All ten inertial parameters of
every link are free about its frame, unless products of inertia are left out. Gravity is a free parameter along z of
the base. Numbers of the manufacturers play no part.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from symdyn.scene import Quantity, Scene, dh_table, scene, with_symbolic_inertia

RIGHT, LEFT = "pi/2", "-pi/2"


@dataclass(frozen=True)
class Row:
    """One row A = Rx(alpha) Tx(a) Rz(theta) Tz(d); the joint adds its coordinate to theta, or to d if it slides."""

    alpha: str = "0"
    a: str = "0"
    d: str = "0"
    type: str = "revolute"


@dataclass(frozen=True)
class Robot:
    """A robot with the source of its table."""

    name: str
    text: str
    rows: tuple[Row, ...]
    source: str


ROBOTS: tuple[Robot, ...] = (
    Robot(
        "general_6r",
        "general 6R arm, joint 1 on the base's z axis",
        (Row(), *(Row(f"alpha{k}", f"a{k}", f"d{k}") for k in range(2, 7))),
        "Khalil and Kleinfinger 1987",
    ),
    Robot(
        "puma560",
        "PUMA 560",
        (Row(), Row(LEFT), Row("0", "a3", "d3"), Row(LEFT, "a4", "d4"), Row(RIGHT), Row(LEFT)),
        "Craig, Introduction to Robotics, figure 3.21",
    ),
    Robot(
        "stanford",
        "Stanford arm",
        (Row(), Row(LEFT, d="d2"), Row(RIGHT, type="prismatic"), Row(), Row(LEFT), Row(RIGHT)),
        "Khalil and Dombre 2002, section 3; Paul 1981",
    ),
    Robot(
        "rx90",
        "Stäubli RX-90",
        (Row(), Row(RIGHT), Row("0", "a3"), Row(LEFT, d="d4"), Row(RIGHT), Row(LEFT)),
        "Khalil and Dombre 2002, table 3.1",
    ),
    Robot(
        "iiwa",
        "7R arm with the axes of a KUKA LBR iiwa",
        (Row(), Row(LEFT), Row(RIGHT, d="d3"), Row(RIGHT), Row(LEFT, d="d5"), Row(LEFT), Row(RIGHT)),
        "axes S-R-S, as examples/arm7.toml",
    ),
    Robot(
        "panda",
        "7R arm with the axes of a Franka Panda",
        (
            Row(),
            Row(LEFT),
            Row(RIGHT, d="d3"),
            Row(RIGHT, a="a4"),
            Row(LEFT, a="a5", d="d5"),
            Row(RIGHT),
            Row(RIGHT, a="a7"),
        ),
        "Franka control interface, Denavit-Hartenberg parameters",
    ),
)

PRODUCTS = ("Ixy", "Ixz", "Iyz")


def robot(name: str) -> Robot:
    """Return the robot called `name`; KeyError if there is none."""
    return {one.name: one for one in ROBOTS}[name]


def robot_scene(one: Robot, diagonal: bool = False) -> Scene:
    """Return the scene of a robot.

    Args:
        one: the robot.
        diagonal: leave out the products of inertia, about the link frames.
    """
    lengths = [value for row in one.rows for value in (row.alpha, row.a, row.d) if value.isidentifier()]
    links = [
        {"name": f"link{k}", "type": row.type, "alpha": row.alpha, "a": row.a, "theta": 0, "d": row.d}
        for k, row in enumerate(one.rows, start=1)
    ]
    bare = scene(
        one.name,
        parameters=dict.fromkeys((*lengths, "g")),
        gravity=[0, 0, "-g"],
        dh=dh_table("modified", links),
    )
    full = with_symbolic_inertia(bare)
    if not diagonal:
        return full
    return replace(
        full,
        bodies=tuple(
            replace(body, inertia=(*body.inertia[:3], Quantity.ZERO, Quantity.ZERO, Quantity.ZERO))
            for body in full.bodies
        ),
        parameters=tuple(p for p in full.parameters if not p.name.startswith(PRODUCTS)),
    )
