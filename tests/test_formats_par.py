"""Khalil parameter files: the geometry of the book, SYMORO's signs, and the way back."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from symdyn.dynamics import derive
from symdyn.dynamics.loops.mobility import mobility
from symdyn.errors import SceneError
from symdyn.graph import Graph
from symdyn.runtime import lambdify
from symdyn.scene import Scene, body, fixed, parse, prismatic, read, read_text, revolute, scene, write_text
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats import par, par_writer
from symdyn.scene.formats.par_writer import rows
from symdyn.scene.values import Pose, spell
from symdyn.scene.values.quantity import Quantity
from symdyn.verdict import Verdict
from symdyn.verify import Claim, prove

ROOT = Path(__file__).parents[1]

DATA = Path(__file__).parent / "data"

INVALID = ReadOptions(allow_invalid_inertia=True)

SMALL = "NL = 1\nNJ = 1\nSigma = {0}\nTheta = {t1}\nM = {2}\nZZ = {1}\nYY = {1}\nXX = {1}\nG = {0, -9.81, 0}\n"


def read_par(name: str, **options: bool) -> Scene:
    return par.read(DATA / name, ReadOptions(**options)).scene


def elementary(kind: str, x: float) -> np.ndarray:
    T = np.eye(4)
    k = "xyz".index(kind[1])
    if kind[0] == "T":
        T[k, 3] = x
        return T
    i, j = (k + 1) % 3, (k + 2) % 3
    T[i, i] = T[j, j] = math.cos(x)
    T[i, j], T[j, i] = -math.sin(x), math.sin(x)
    return T


def placed(steps: object, values: dict[str, Fraction] | None = None) -> np.ndarray:
    T = np.eye(4)
    for kind, amount in steps:  # type: ignore[attr-defined]
        T = T @ elementary(kind, float(amount.at(values or {})))  # type: ignore[arg-type]
    return T


def row_steps(row: object) -> list[tuple[str, object]]:
    names = (("Rz", "gamma"), ("Tz", "b"), ("Rx", "alpha"), ("Tx", "d"), ("Rz", "theta"), ("Tz", "r"))
    return [(kind, getattr(row, name)) for kind, name in names]


def same_dynamics(one: Scene, other: Scene) -> None:
    """Prove that inverse dynamics of two scenes are the same function, coordinates and parameters by name."""
    left, right = (derive(each)["inverse_dynamics"].entries for each in (one, other))
    claim = Claim("inverse dynamics", one.source, other.source, tuple(left), tuple(right))
    _, (finding,) = prove([claim])
    assert finding.verdict == Verdict.PROVED


# Reading


def test_rx90_reaches_where_the_book_says() -> None:
    """Khalil & Dombre 2002, direct geometric model of the Staubli RX-90, position of frame 6."""
    robot = read_par("rx90.par")
    D3, RL4 = 0.45, 0.38
    known = {"D3": Fraction("0.45"), "RL4": Fraction("0.38")}
    rng = random.Random(3)
    for _ in range(5):
        q = [rng.uniform(-3, 3) for _ in range(6)]
        T = np.eye(4)
        for joint, x in zip(robot.joints, q, strict=True):
            T = T @ placed(joint.origin.steps, known) @ elementary("Rz", x)
        reach = math.sin(q[1] + q[2]) * RL4 - math.cos(q[1]) * D3
        height = math.cos(q[1] + q[2]) * RL4 + math.sin(q[1]) * D3
        np.testing.assert_allclose(T[:3, 3], [-math.cos(q[0]) * reach, -math.sin(q[0]) * reach, height], atol=1e-15)


def test_rx90_names_are_those_of_the_file() -> None:
    robot = read_par("rx90.par")
    assert robot.name == "RX90"
    assert robot.coordinates == ("t1", "t2", "t3", "t4", "t5", "t6")
    assert [joint.drive for joint in robot.joints] == [f"GAM{j}" for j in range(1, 7)]
    assert [p.name for p in robot.parameters[:3]] == ["IA1", "FV1", "FS1"]
    link = robot.bodies[2]
    assert (link.mass, link.first_moment, link.about) == (
        Quantity.symbol("M3"), (Quantity.symbol("MX3"), Quantity.symbol("MY3"), Quantity.symbol("MZ3")), "frame",
    )  # fmt: skip
    assert [spell(x) for x in link.inertia] == ["XX3", "YY3", "ZZ3", "XY3", "XZ3", "YZ3"]
    third = robot.joints[2]
    assert (third.armature, third.damping, third.friction) == (
        Quantity.symbol("IA3"),
        Quantity.symbol("FV3"),
        Quantity.symbol("FS3"),
    )


def test_a_link_let_go_falls_along_g() -> None:
    text = "NL = 1\nNJ = 1\nSigma = {1}\nTheta = {0}\nR = {r1}\nM = {2}\nG = {0, 0, -9.81}\n"
    falling = par.read_text(text, "fall.par").scene
    assert lambdify(falling, "forward_dynamics")([0.0], [0.0], [0.0]) == pytest.approx([-9.81])


def test_frames_of_every_kind_are_placed_by_six_parameters() -> None:
    robot = read_par("tree.par")
    assert [joint.type for joint in robot.joints] == ["revolute", "prismatic", "fixed", "revolute", "revolute"]
    assert [joint.parent for joint in robot.joints] == ["ground", "link1", "link1", "link3", "link4"]
    assert robot.coordinates == ("th1", "r2", "th4", "th5")
    assert [joint.drive for joint in robot.joints] == ["tau1", "tau2", None, "tau3", None]
    steps = {joint.name: [(kind, spell(x)) for kind, x in joint.origin.steps] for joint in robot.joints}
    assert steps["joint2"] == [
        ("Rz", "pi/2"), ("Rx", "0.3"), ("Tx", "0.15"), ("Rz", "pi/4"), ("Tz", "0.1"),
    ]  # fmt: skip
    assert steps["joint3"] == [("Rz", "-pi/2"), ("Tz", "0.2"), ("Rx", "pi/2"), ("Tx", "L3"), ("Rz", "pi")]
    assert steps["joint4"] == [("Rx", "-pi/2"), ("Rz", "-pi/2"), ("Tz", "RL4")]
    assert steps["joint5"] == [("Rz", "pi/6"), ("Tz", "-0.1"), ("Rx", "pi/3"), ("Tx", "0.0625")]


def test_decimals_of_pi_are_snapped_with_a_note_and_only_if_wanted() -> None:
    reading = par.read(DATA / "tree.par", ReadOptions())
    data = "friction is kept as data and enters no equation (joint1)"
    advice = "; write friction = { coulomb = 0.5, smoothing = 0.01 } in the scene to have it act"
    assert {note.partition(": ")[2] for note in reading.notes} == {
        "frame 3: gamma = -1.5707963 is read as -pi/2",
        "frame 5: alpha = 1.0471976 is read as pi/3",
        data + advice,
    }
    plain = par.read(DATA / "tree.par", ReadOptions(snap=False))
    assert [note.partition(": ")[2] for note in plain.notes] == [data + advice]
    assert plain.scene.joints[2].origin.steps[0] == ("Rz", Quantity.number(Fraction("-1.5707963")))


def test_words_of_both_programs_are_understood() -> None:
    text = SMALL.replace("ZZ = {1}", "ZZ = {2*Cos[Pi/3]*Sqrt[1/4]^2 + (1 + 1)/2*3/4}")
    assert par.read_text(text, "small.par").scene.bodies[0].inertia[2] is not None
    value = par.read_text(text, "small.par").scene.bodies[0].inertia[2].at({})
    assert float(value) == pytest.approx(1)  # type: ignore[arg-type]
    text = SMALL.replace("ZZ = {1}", "ZZ = {atan2(1, 1)*4/pi}")
    assert float(par.read_text(text, "s.par").scene.bodies[0].inertia[2].at({})) == 1  # type: ignore[arg-type]


def test_symbols_that_cannot_be_printed_are_renamed_with_a_note() -> None:
    reading = par.read_text(SMALL.replace("t1", "lambda").replace("M = {2}", "M = {q}"), "small.par")
    assert reading.scene.coordinates == ("lambda_symbol",)
    assert [p.name for p in reading.scene.parameters] == ["q"]
    assert "small.par: the symbol lambda is called lambda_symbol" in reading.notes


def test_placeholders_of_external_wrenches_are_noted_and_others_refused() -> None:
    reading = par.read_text(SMALL + "FX = {FX1}\nCZ = {CZ1}\n", "small.par")
    assert "small.par: frame 1: the external wrench FX1, CZ1 is read as zero" in reading.notes
    with pytest.raises(SceneError, match=r"small.par: frame 1: an external wrench 5 acts on the link"):
        par.read_text(SMALL + "FX = {5}\n", "small.par")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("NJ = 1", "NJ = 0"), "NL = 1, NJ = 0, NF = -1 do not fit together"),
        (("NJ = 1", "NJ = 2\nNF = 2"), "NL = 1, NJ = 2, NF = 2 do not fit together: a file of NL links and NJ joints"),
        (("NJ = 1", "NJ = 2"), "sigma has 1 values; 3 are needed"),
        (("NJ = 1", "NJ = 2"), "Ant is missing; where loops are closed it lists which links a cut joint connects"),
        (("NL = 1", "NL = one"), 'NL = "one" is not a whole number'),
        (("Sigma = {0}", "Sigma = {3}"), 'frame 1: sigma = "3" is not a whole number from 0 to 2'),
        (("Theta = {t1}", "Theta = {0.3}"), "frame 1: theta = 0.3 is no coordinate; name the coordinate, such as th1"),
        (("Theta = {t1}", "Theta = {t1 + t2}"), r"frame 1: theta = t1 \+ t2 is no coordinate"),
        (("Theta = {t1}", "Theta = {2*t1}"), r"frame 1: theta = 2\*t1 is no coordinate"),
        (("Theta = {t1}\n", ""), "theta is missing; give one value a frame"),
        (("M = {2}", "M = {2, 3}"), "m has 2 values; 1 are needed"),
        (("M = {2}", "M = {-2}"), "frame 1: mass = -2 is negative"),
        (("ZZ = {1}", "ZZ = {3}"), "frame 1: inertia .* is not physically consistent"),
        (("M = {2}", "M = {2"), 'line 5: "M = {2" is no statement'),
        (("M = {2}", "(* M = {2}"), "line 5: a comment begins that does not end"),
        (("M = {2}", "M = {2}\nM = {3}"), "line 6: M is given twice"),
        (("M = {2}", "M = {2 +}"), r'frame 1: m = "2 \+" is not a usable formula'),
        (("M = {2}", "M = {2*t1}"), r"frame 1: mass = 2\*t1 uses t1; a mass or an inertia changes by a state"),
        (("G = {0, -9.81, 0}", ""), "G is missing"),
        (("M = {2}", "M = {2}\nV0 = {1, 0, 0}"), "the base of a scene is at rest"),
        (("M = {2}", "M = {2}\nis_floating = True"), "is_floating = True: a free base is not read"),
        (("M = {2}", "M = {2}\neta = {1}"), "frame 1: eta = 1: joints of a scene are rigid"),
        (("M = {2}", "M = {2}\nAnt = {2}"), 'frame 1: ant = "2" is not a whole number from 0 to 1'),
        (("M = {2}", "M = {2}\nAnt = {1}"), 'frame 1: joins "link1" with itself'),
    ],
)
def test_faults_name_the_frame_and_the_key(change: tuple[str, str], message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        par.read_text(SMALL.replace(*change), "small.par")
    assert all(line.startswith("small.par: ") for line in str(caught.value).splitlines())


def test_two_joints_with_one_coordinate_are_refused() -> None:
    text = "NL = 2\nNJ = 2\nSigma = {0, 0}\nTheta = {t1, t1}\nM = {1, 1}\nG = {0, 0, 0}"
    with pytest.raises(SceneError, match="frame 2: theta = t1 is the coordinate of frame 1"):
        par.read_text(text, "two.par")


def test_unknown_keys_and_missing_lists_are_noted() -> None:
    notes = par.read_text(SMALL + "Color = {3}\n", "small.par").notes
    assert "small.par: line 10: Color is not a key of parameter files; it is left out" in notes
    assert any("XY, XZ, YZ, MX, MY, MZ, IA, FV, FS are not given and read as zero" in note for note in notes)


# Writing


@pytest.mark.parametrize("name", ["rx90.par", "tree.par"])
def test_what_was_read_is_written_and_read_again(name: str) -> None:
    once = read_par(name)
    written = par_writer.write_text(once)
    assert written.lost == ()
    again = par.read_text(written.text, name)
    assert again.scene == once
    assert par_writer.write_text(again.scene).text == written.text


def is_plain(scene: Scene) -> bool:
    """Whether a parameter file holds all that acts in a scene."""
    acting = (scene.loops, scene.elements)
    return not any(acting) and all(joint.type in par_writer.SIGMA for joint in scene.joints)


PLAIN = [path for path in sorted((ROOT / "examples").glob("*.toml")) if is_plain(read(path))]


@pytest.mark.wide(2)
@pytest.mark.parametrize("path", PLAIN, ids=lambda path: path.stem)
def test_every_example_keeps_its_dynamics(path: Path) -> None:
    """puma560 is a standard Denavit-Hartenberg table: its link frames move, its equations do not."""
    once = read(path)
    bare = replace(once, joints=tuple(replace(joint, forces=()) for joint in once.joints))
    written = par_writer.write_text(bare)
    again = par.read_text(written.text, path.stem + ".par", INVALID).scene
    same_dynamics(bare.in_numbers([parameter.name for parameter in bare.parameters]), again)
    assert par_writer.write_text(again).text == written.text


def test_puma_becomes_the_table_of_modified_parameters() -> None:
    text = par_writer.write_text(read(ROOT / "examples/puma560.toml")).text
    lines = text.splitlines()
    assert "alpha = {0, pi/2, 0, -pi/2, pi/2, -pi/2}" in lines
    assert "d = {0, 0, 0.4318, 0.0203, 0, 0}" in lines
    assert "r = {0, 0, 0.15005, 0.4318, 0, 0}" in lines


def test_axes_and_tips_of_any_direction_are_written_exactly() -> None:
    inertia = {"xx": 0.2, "yy": 0.3, "zz": 0.25, "xy": 0.01, "xz": -0.02, "yz": 0.03}
    place = [0.1, -0.2, 0.3]
    links = [body(name, mass=2, com=place, inertia=inertia, about="com") for name in ("a", "b", "c", "e")]
    joints = [
        revolute("j1", "ground", "a", axis=[0, -1, 0], origin={"xyz": [0.1, 0.2, 0.3], "rpy": ["pi/2", 0, "-pi/2"]}),
        prismatic("j2", "a", "b", axis=[-2, 0, 0], origin={"xyz": [0.1, 0, 0], "rpy": [0.3, 0.2, "pi/3"]}),
        fixed("j3", "b", "c", origin={"xyz": [0.1, "l", 0.3], "rpy": ["pi/4", 0, 0]}),
        revolute("j4", "c", "e", axis=[0, 0, 1], origin=[["Ry", "0.7"], ["Tx", "l"]], tip=[["Ry", "pi/2"], ["Ty", 2]]),
    ]
    once = scene("odd", parameters={"l": None}, bodies=links, joints=joints)
    written = par_writer.write_text(once)
    again = par.read_text(written.text, "odd.par").scene
    same_dynamics(once, again)
    assert [joint.name for joint in again.joints if joint.coordinate] == ["j1", "j2", "j4"]
    assert [b.name for b in again.bodies if not b.name.count("_frame")] == ["a", "b", "c", "e"]


def test_an_oblique_axis_is_written_with_its_arctangents() -> None:
    links = [body("a", mass=1, com=[0.1, 0.2, 0.3], inertia=[1, 1, 1], about="com")]
    once = scene("odd", bodies=links, joints=[revolute("j", "ground", "a", axis=[1, 2, -2])])
    again = par.read_text(par_writer.write_text(once).text, "odd.par").scene
    for q in (0.3, -1.2):
        ours, theirs = (lambdify(each, "inverse_dynamics")([q], [0.5], [0.7]) for each in (once, again))
        assert ours == pytest.approx(theirs, rel=1e-14)


def test_rows_multiply_to_the_placement() -> None:
    rng = random.Random(5)
    angles = [Quantity.number(0), *(Quantity.number(Fraction(rng.randint(-20, 20), 7)) for _ in range(3))]
    right = [par_writer.towards((Quantity.number(x), Quantity.number(0), Quantity.number(0)))[0][1] for x in (1, -1)]
    for _ in range(300):
        pool = right if rng.random() < 0.5 else [*angles, *right]
        steps = [
            (kind, rng.choice(pool) if kind[0] == "R" else Quantity.number(Fraction(rng.randint(-3, 3), 4)))
            for kind in rng.choices(("Tx", "Ty", "Tz", "Rx", "Ry", "Rz"), k=rng.randint(0, 6))
        ]
        found = rows(steps)
        T = np.eye(4)
        for row in found:
            T = T @ placed(row_steps(row))
        np.testing.assert_allclose(T, placed(steps), atol=1e-13)


def test_right_angled_placements_need_one_row() -> None:
    half = par_writer.towards((Quantity.number(1), Quantity.number(0), Quantity.number(0)))[0][1]
    for steps in (
        [("Tx", Quantity.symbol("a")), ("Ty", Quantity.symbol("b")), ("Tz", Quantity.symbol("c")), ("Rx", half)],
        [("Ty", Quantity.symbol("b")), ("Tz", Quantity.symbol("c")), ("Ry", half)],
        [("Tx", Quantity.symbol("a")), ("Tz", Quantity.symbol("c"))],
        [("Ty", Quantity.symbol("b")), ("Rz", half)],
    ):
        assert len(rows(steps)) == 1


def test_a_symbol_beside_the_coordinate_gets_a_frame_of_its_own() -> None:
    link = body("a", mass=1, com=[0.1, 0, 0], inertia=[1, 1, 1], about="com")
    once = scene(
        "tilted", parameters={"off": None}, bodies=[link], joints=[revolute("j", "ground", "a", origin=[["Rz", "off"]])]
    )
    text = par_writer.write_text(once).text
    assert "theta = {off, q1}" in text
    same_dynamics(once, par.read_text(text, "tilted.par").scene)


def test_what_is_lost_is_listed_and_refused_without_lossy() -> None:
    once = read(ROOT / "examples/cart_pole.toml")
    lost = par_writer.write_text(once).lost
    assert "parameters.mp: its value 0.1 stands in place of the name" in lost
    assert "joints.rail: force = -b*x_dot: there are no forces in formulas" in lost
    assert "points.tip" in lost
    with pytest.raises(SceneError, match=r"points\.tip\n(.*\n)*.*par cannot hold all of this; lossy=True"):
        write_text(once, "par")
    assert write_text(once, "par", lossy=True).text.startswith("(* Robotname = 'cart_pole' *)")


def test_coupled_joints_are_refused() -> None:
    links = [body(name, mass=1, inertia=[1, 1, 1], about="com") for name in "ab"]
    joints = [
        revolute("j1", "ground", "a"),
        revolute("j2", "a", "b", mimic={"joint": "j1", "ratio": 2}, drive=False),
    ]
    with pytest.raises(SceneError, match=r"twins: joints\.j2: a \.par file has no joints that follow others"):
        par_writer.write_text(scene("twins", bodies=links, joints=joints))


def test_inertias_move_to_the_link_frame_by_the_parallel_axis_theorem() -> None:
    graph = Graph()
    link = body("a", mass="m", com=["x", 0, 0], inertia=["I1", "I2", "I3"], about="com")
    once = scene(
        "moved", parameters=dict.fromkeys(("m", "x", "l", "I1", "I2", "I3")), bodies=[link],
        joints=[revolute("j", "ground", "a", tip=[["Tx", "l"]])],
    )  # fmt: skip
    again = par.read_text(par_writer.write_text(once).text, "moved.par").scene.bodies[0]
    assert again.inertia[2].express(graph) is not None
    values = {
        "m": Fraction(3),
        "x": Fraction(2),
        "l": Fraction(5),
        "I1": Fraction(1),
        "I2": Fraction(1),
        "I3": Fraction(4),
    }
    assert again.inertia[2].at(values) == 4 + 3 * 7**2
    assert again.first_moment is not None
    assert again.first_moment[0].at(values) == 3 * 7


def test_pose_without_steps_is_a_row_of_zeros() -> None:
    assert row_steps(rows(Pose().steps)[0]) == [
        (kind, Quantity.number(0)) for kind in ("Rz", "Tz", "Rx", "Tx", "Rz", "Tz")
    ]


def test_a_decimal_angle_near_a_multiple_of_pi_stays_what_it_was():
    text = """
    [bodies.a]
    mass = 1
    com = [1, 2, 3]
    [joints.j]
    type = "revolute"
    parent = "ground"
    child = "a"
    origin = { rpy = [1.57079633, 0, 0.78539816] }
    """
    near = read_text(text, "near.toml")
    written = par_writer.write_text(near).text

    assert "pi" not in written.lower()
    assert "1.570796330" in written


def test_what_a_fixed_frame_or_a_rigid_joint_cannot_use_is_noted():
    text = """
    NL = 2
    NJ = 2
    Ant = {0, 1}
    Sigma = {0, 2}
    Theta = {t1, 0}
    M = {2, 1}
    XX = {1, 0}
    YY = {1, 0}
    ZZ = {1, 0}
    FV = {0, 0.2}
    IA = {0, 0.3}
    K = {50, 0}
    G = {0, -9.81, 0}
    """
    notes = par.read_text(text, "small.par").notes

    assert "small.par: frame 2: IA, FV of a fixed frame: left out, nothing moves there" in notes
    assert "small.par: frame 1: k = 50 is left out: the joint is rigid (eta = 0)" in notes


FOUR_BAR = """
NL = 3
NJ = 4
NF = 5
Type = 2 (* Closed *)
(* Joint names = 'motor, elbow, pivot, hinge' *)
Ant = {0, 1, 0, 2, 3}
Sigma = {0, 0, 0, 0, 2}
d = {0, 1, 4, 3, 3.5}
Theta = {t1, t2, t3, t4 + Pi/2, 0}
M = {1, 3, 3.5}
MX = {0.5, 4.5, 6.125}
ZZ = {1/3, 9, 14.291666666666666}
QP = {QP1, QP2, QP3, QP4}
G = {0, -9.81, 0}
"""


def test_a_cut_joint_closes_a_loop():
    scene = par.read_text(FOUR_BAR, "bar.par", INVALID).scene

    (loop,) = scene.loops
    assert (loop.name, loop.type, loop.parent, loop.child) == ("hinge", "revolute", "link2", "link3")
    assert loop.origin == Pose((("Tx", Quantity.number(3)), ("Rz", parse("pi/2"))))
    assert loop.tip == Pose((("Tx", Quantity.number(Fraction(-7, 2))),))
    assert scene.coordinates == ("t1", "t2", "t3")
    assert not scene.parameters
    assert mobility(scene).by_rank == 1


def test_the_four_bar_of_a_parameter_file_moves_as_the_example_does():
    here = par.read_text(FOUR_BAR, "bar.par", INVALID).scene
    there = read(ROOT / "examples" / "four_bar.toml")
    q, qd, tau = [0.8, 0.1420089234527959928, 2.0260131545490214846], [0.0] * 3, [3.0, 0, 0]

    one, other = (lambdify(scene, "forward_dynamics")(q, qd, tau) for scene in (here, there))

    np.testing.assert_allclose(one, other, rtol=1e-12)
