"""One scene that holds every word: all joints, loops, springs, dampers, loads, rows; and the places of its words."""

from __future__ import annotations

from symdyn.scene import (
    Scene,
    body,
    constraint,
    contact,
    custom,
    cylindrical,
    damper,
    elastic_rope,
    flow,
    free,
    gap_contact,
    helical,
    knife_edge,
    load,
    loop,
    parameter,
    planar,
    point,
    point_on_line,
    point_on_plane,
    prismatic,
    revolute,
    rod,
    rolling,
    rope,
    rope_damping,
    scene,
    spherical,
    spring,
    universal,
)


def everything() -> Scene:
    """Return a scene in which every word of the language stands, most with values that are not the usual ones."""
    names = "abcdefghijklmno"
    return scene(
        "everything",
        parameters=[parameter("m", 2), parameter("k"), parameter("r", "1/4", positive=True)],
        bodies=[body(name, mass="m", com=[0, 0, "1/10"], inertia=[1, 1, 1], about="com") for name in names],
        joints=[
            revolute("r1", "ground", "a", axis=[1, 2, 2], rotor={"inertia": "1/1000", "gear": 50}, motion="sin(2*t)"),
            prismatic("p1", "a", "b", friction={"coulomb": 1, "static": 2, "stribeck": "1/5", "smoothing": "1/100"}),
            helical("h1", "b", "c", pitch="r/100", start="pi/3", start_rates=2, force="-3*k*q3_dot + 2*sin(3*t)"),
            cylindrical("c1", "c", "d", axis=[0, 1, 0], force=[0, "3*q4"], drive=["M", False], damping="1/3"),
            universal("u1", "d", "e", axis=[1, 0, 0], second_axis=[0, 1, 1], coordinates=["alpha", "beta"]),
            spherical("s1", "e", "f", start=["1/2", "1/2", "1/2", "1/2"], start_rates=[1, 2, 3], drive=False),
            spherical("s2", "f", "g", orientation="zxz"),
            planar("e1", "g", "h", axis=[0, 0, -1]),
            point_on_line("l1", "h", "i", axis=[1, 0, 0], coordinates=["x", "e0", "e1x", "e2x", "e3x"]),
            point_on_plane("n1", "i", "j", orientation="xyz"),
            rod("rod1", "j", "k", length="r", orientation="yxz", tip=[0, 0, "r/2"]),
            free("f1", "ground", "l", start_rates=[0, 0, 0, 1, "1/100", 0], drive=[True, *[False] * 5]),
            free("f2", "ground", "m", orientation="zyx"),
            custom("cam", "m", "n", steps=[("Rz", "u"), ("Tx", "r*sin(u)")], units=["rad"], coordinate="u"),
            revolute("gear", "n", "o", mimic={"coordinate": "alpha", "ratio": -2, "offset": 1}, friction=3),
        ],
        points=[point("tool", "b", [("Rz", "90 deg"), ("Tx", "r")]), point("end", "c", [1, 2, 3])],
        loops=[
            loop("ring1", "revolute", "c", "ground", axis=[0, 1, 0], origin=[0, 0, "r"], tip={"rpy": [0, "pi/2", 0]}),
            loop("ring2", "universal", "l", "b", second_axis=[0, 1, 0]),
            loop("ring3", "rod", "l", "d", length=2),
            loop("ring4", "helical", "m", "b", pitch="1/50"),
        ],
        springs=[
            spring("s_joint", joint="r1", stiffness=["5*k", 0, "k/10"], free="pi/4", preload=-1),
            spring("s_line", ends=("tool", {"body": "l", "at": [0, "r", 0]}), stiffness=100, free="1/2"),
            spring("constant", ends=("a", "l"), preload=7),
        ],
        dampers=[
            damper("d_joint", joint="gear", damping=["1/10", "1/100"]),
            damper("d_line", ends=({"body": "ground", "at": [1, 0, 0]}, "end"), damping="k"),
        ],
        loads=[
            load("wind", body="l", at=[0, 0, "r"], force=["3*k*t", 0, "-2*f1_vx"], couple=[0, "2*sin(3*t)*alpha", 0]),
            load("thrust", point="tool", force=[0, 0, 9], frame="body"),
        ],
        flows=[
            flow("rain", ["k*t", 0, "-f1_vx"], body="l", rate="3*k", frame="ground"),
            flow("leak", [0, 0, -1], body="l", at=[0, 0, "r"]),
            flow("mouth", [0, 0, 0], point="tool", rate="k/7"),
            flow("drain", [1, 0, 0], body="b"),
        ],
        ropes=[
            rope("hoist", [{"body": "l", "at": ["r", 0, 0]}, "end", "tool"], length="7*r"),
            rope("leash", ["end", "l"], length="3*r", restitution="1/5"),
            elastic_rope(
                "bungee", ["tool", {"body": "a", "at": [0, 1, 0]}, "l"], stiffness=["k", 3], free=1, preload=2
            ),
            rope_damping("loss", ["end", "m", "l"], damping="k/9"),
        ],
        constraints=[
            constraint("slip", "x_dot*cos(u) - r*(u_dot - 2*alpha_dot)", acts_in="joints"),
            knife_edge("blade", body="l", at=["r", 0, 0], axis=[0, 1, 0]),
            rolling("wheel", body="m", axis=[0, 1, 0], radius="r", normal=[0, 1, 1], components=["along", "normal"]),
        ],
        contacts=[
            contact("heel", body="l", at=["r", 0, 0], plane={"body": "a", "at": [0, 0, "r"], "normal": [0, 1, 1]}),
            contact("shot", body="m", radius="r", restitution="1/2", law="newton"),
            contact("tyre", body="l", radius="2*r", axis=[0, 1, 0], friction="1/3", static="1/2"),
            gap_contact("cam", "r - r*sin(alpha)", tangent="r*alpha_dot", friction="1/5", restitution="1/4"),
        ],
    )
