"""The chosen link frames as they are reported: steps that multiply out to the link, angles in degrees where exact."""

from __future__ import annotations

import json
import random
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from arms import EXAMPLES, spatial_arm
from mechanisms import coupled_tree, random_tree

from symdyn.algebra.numeric import Floats
from symdyn.cli import main
from symdyn.cli.facts import angle_text, frame_texts
from symdyn.dynamics import Workspace
from symdyn.dynamics.closed_forms.frames_and_parameters import angle_of, chosen_frames
from symdyn.dynamics.recursive.reduced_tree import reframe
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.scene import body, point, prismatic, read, revolute, scene

DATA = Path(__file__).parent / "data"


def leaning(*turns, parameters=()):
    """Two revolute joints, the second one placed by a shift and `turns`."""
    return scene(
        "leaning",
        parameters=dict.fromkeys(parameters),
        bodies=[body("a", mass=1), body("b", mass=2, com=[1, 0, 0])],
        joints=[revolute("j1", "ground", "a"), revolute("j2", "a", "b", origin=[("Tx", 1), ("Ty", "1/3"), *turns])],
    )


SCENES = [
    *(random_tree(seed) for seed in range(8)),
    *(coupled_tree(seed) for seed in range(3)),
    spatial_arm(),
    leaning(("Rx", "1/1000000")),
    leaning(("Rx", "37*pi/180"), ("Ry", "21*pi/180")),
    leaning(("Rx", "u"), ("Ry", "v"), parameters=("u", "v")),
    *(read(path) for path in sorted(EXAMPLES.glob("*.toml"))),
]


def matrix(kind, amounts):
    """Return an elementary motion as 4 x 4 matrix."""
    T = np.eye(4)
    if kind == "R":
        T[:3, :3] = np.reshape(amounts, (3, 3))
    elif kind[0] == "T":
        T["xyz".index(kind[1]), 3] = amounts[0]
    else:
        i, j = (("xyz".index(kind[1]) + k) % 3 for k in (1, 2))
        T[i, i] = T[j, j] = np.cos(amounts[0])
        T[j, i], T[i, j] = np.sin(amounts[0]), -np.sin(amounts[0])
    return T


def values(nodes, seed=1):
    """Return nodes at random values of their symbols, by name: the same for nodes of another graph."""
    rng = random.Random(seed)
    symbols = sorted({x for x in reachable(nodes) if x.op is Op.SYMBOL}, key=lambda x: str(x.value))
    drawn = {name: rng.uniform(0.3, 1.2) for name in sorted(f"{kind}{k}" for kind in "qx" for k in range(99))}
    given = {x: drawn.setdefault(str(x.value), random.Random(str(x.value)).uniform(0.3, 1.2)) for x in symbols}
    return evaluate(nodes, Floats(), given)


def placed(T):
    R = np.reshape(values([x for row in T.R for x in row]), (3, 3))
    return np.block([[R, np.reshape(values(T.p), (3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.parametrize("one", SCENES, ids=lambda one: one.name)
def test_steps_multiply_out_to_the_link(one):
    framed = reframe(Workspace(one).tree)
    for i, frame in enumerate(chosen_frames(one), start=1):
        product = np.eye(4)
        for kind, amounts in frame.steps:
            product = product @ matrix(kind, values(amounts))

        assert np.allclose(product, placed(framed.X[i].transform), atol=1e-12)


@pytest.mark.parametrize("one", SCENES, ids=lambda one: one.name)
def test_a_frame_is_placed_in_that_of_the_joint_below(one):
    below, met = {joint.child: joint for joint in one.joints}, set()
    for frame in chosen_frames(one):
        joint = frame.joint if frame.joint.name in met else below.get(frame.joint.parent)  # which may move twice
        met.add(frame.joint.name)
        while joint is not None and joint.type == "fixed":  # which has no frame
            joint = below.get(joint.parent)

        assert frame.parent == ("ground" if joint is None else joint.name)


def test_a_chain_needs_four_steps_in_their_order():
    for name in ("puma560", "arm7", "scara"):
        for frame in chosen_frames(read(EXAMPLES / f"{name}.toml")):
            kinds = [kind for kind, _ in frame.steps]

            assert kinds == [kind for kind in ("Rx", "Tx", "Rz", "Tz") if kind in kinds]


def test_the_puma_has_the_frames_of_the_modified_table_though_declared_by_the_standard_one():
    texts = {text["joint"]: text for text in frame_texts(read(EXAMPLES / "puma560.toml"))}

    assert texts["joint2"]["link"] == "Rx(90 deg) Rz(q2)"
    assert texts["joint3"]["link"] == "Tx(0.4318) Rz(q3) Tz(0.15005)"
    assert texts["joint4"]["link"] == "Rx(-90 deg) Tx(0.0203) Rz(q4) Tz(0.4318)"
    assert texts["joint4"]["declared"] == "revolute about (0, 0, 1) at link3 Tz(0.4318)"


def test_another_child_is_placed_with_gamma_and_epsilon():
    one = scene(
        "fork",
        parameters=dict.fromkeys(("a", "e")),
        bodies=[body("trunk", mass=1), body("left", mass=1, com=[1, 0, 0]), body("right", mass=1, com=[1, 0, 0])],
        joints=[
            revolute("j", "ground", "trunk"),
            revolute("l", "trunk", "left", origin=[("Tx", "a"), ("Rx", "pi/2")]),
            revolute("r", "trunk", "right", origin=[("Rz", "2*pi/5"), ("Tz", "e"), ("Tx", "a"), ("Rx", "pi/2")]),
        ],
    )

    assert [text["link"] for text in frame_texts(one)] == [
        "Rz(q1 + 72 deg) Tz(e)",  # the trunk's frame is that of the last child's common normal
        "Rz(-72 deg) Tz(-e) Rx(90 deg) Tx(a) Rz(q2)",
        "Rx(90 deg) Tx(a) Rz(q3)",
    ]


def test_what_was_moved_is_told_in_the_declared_frame():
    one = scene(
        "turret",
        bodies=[body("base", mass=1), body("slide", mass=1, com=[1, 0, 0])],
        joints=[
            revolute("turn", "ground", "base", origin=[0, 0, "1/2"]),
            prismatic("reach", "base", "slide", axis=[1, 0, 0], origin=[0, 0, "1/4"]),
        ],
        points=[point("tip", "slide")],
    )
    turn, reach = frame_texts(one)

    assert turn["moved"] == "origin (0, 0, 0.25), x along (0, 1, 0)"
    assert reach["moved"].endswith("z along (1, 0, 0)")
    assert reach["declared"] == "prismatic along (1, 0, 0) at base Tz(0.25)"


@pytest.mark.parametrize(
    ("turns", "text"),
    [
        ("pi/2", "90 deg"),
        ("-37*pi/180", "-37 deg"),
        ("u", "u"),
        ("pi/2 - u", "-u + 90 deg"),
        ("u - pi/2", "u - 90 deg"),
        ("-u", "-u"),
        ("pi + u", "u + 180 deg"),
        ("1/3", "1/3"),
        ("atan2(3, 4)", "0.643501"),
    ],
)
def test_angles_are_in_degrees_where_that_is_exact(turns, text):
    from symdyn.scene import parse

    graph = Graph()
    angle = parse(turns).express(graph)
    found = angle_of(graph.cos(angle), graph.sin(angle))

    assert angle_text(found) == text


@pytest.mark.parametrize("quadrant", range(8))
def test_the_angle_of_a_pair_lies_in_its_quadrant(quadrant):
    graph = Graph()
    u = graph.symbol("u")
    signs = [(1, -1)[quadrant >> k & 1] for k in (0, 1)]
    pair = (graph.cos(u), graph.sin(u)) if quadrant < 4 else (graph.sin(u), graph.cos(u))
    c, s = (sign * x for sign, x in zip(signs, pair, strict=True))
    angle = angle_of(c, s)
    cosine, sine, cos_angle, sin_angle = values([c, s, graph.cos(angle), graph.sin(angle)])

    assert (cos_angle, sin_angle) == (pytest.approx(cosine), pytest.approx(sine))
    assert Op.ATAN2 not in {node.op for node in reachable([angle])}


def test_a_pair_of_numbers_is_an_exact_part_of_a_turn():
    graph = Graph()
    root = graph.sqrt(3) / 2

    assert angle_of(-root, graph.constant(Fraction(1, 2))) is graph.pi * Fraction(5, 6)


def test_info_prints_the_frames_alone(capsys):
    assert main(["info", str(EXAMPLES / "puma560.toml"), "--frames"]) == 0
    out = capsys.readouterr().out

    assert "Rx(-90 deg) Tx(0.0203) Rz(q4) Tz(0.4318)" in out
    assert "Operations" not in out


def test_info_as_json_holds_frames_and_base_parameters(capsys):
    assert main(["info", str(EXAMPLES / "two_link.toml"), "--frames", "--base-parameters", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["result"]

    assert [frame["link"] for frame in facts["frames"]] == ["Rz(q1 + 90 deg)", "Tx(-h1) Rz(q2)"]
    assert facts["base_parameters"][1] == {
        "name": "ZZR1",
        "formula": "(m1 + m2)*h1**2",
        "latex": r"\mathit{ZZ}_{R1} = (m_1 + m_2) h_1^2",
        "unit": "kg m^2",
    }


def test_angles_without_exact_sines_do_not_fill_the_page(capsys):
    assert main(["info", str(DATA / "gripper_arm.urdf"), "--frames", "--base-parameters"]) == 0
    out = capsys.readouterr().out

    assert "Tz(0.747952)" in out
    assert max(map(len, out.splitlines())) <= 165
    assert "mzR4 = 0.002" in out
