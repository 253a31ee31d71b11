"""Where mechanisms rest, for commands and lessons alike: exactly, by signs of a force, and at singular places."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

import symdyn
from symdyn.algebra.numeric import Floats
from symdyn.cli import main
from symdyn.errors import LinearizeError
from symdyn.graph import Graph, evaluate
from symdyn.linear import linearize_at_rest, rests
from symdyn.linear.modes import SecondOrder
from symdyn.scene import read, read_text

FOUND = Path(__file__).parent / "data/found"

ROD = """
name = "rod"
gravity = [0, -9.81, 0]
[bodies]
rod = { particles = [{ mass = 1, at = [1, 0, 0] }] }
[joints]
pivot = { type = "revolute", parent = "ground", child = "rod", coordinate = "phi", drive = false }
"""

TOP = """
name = "top"
gravity = [0, 0, -10]
[bodies]
top = { mass = 2, com = [0, 0, 1], inertia = [1, 1, 0.5], inertia_about = "com" }
[joints.point]
type = "spherical"
parent = "ground"
child = "top"
orientation = "zxz"
coordinates = ["phi", "theta", "psi"]
start = [0, 0.5, 0]
drive = false
"""


def test_springs_tell_exactly_where_slides_rest() -> None:
    found = rests(read(FOUND / "elastic_pendulum.toml"))
    values = {"m": 1, "k": 40, "l0": 0.5, "g": 9.81}
    graph = Graph()
    known = {graph.symbol(name): value for name, value in values.items()}
    told = []
    for place in found.places:
        assert place.exact is not None
        exact = [place.exact[q].express(graph) for q in ("theta", "r")]
        told.append(evaluate(exact, Floats(), known))
        assert told[-1] == pytest.approx(place.q.tolist())
    stretch = 9.81 / 40
    assert told == [pytest.approx([0, 0.5 + stretch]), pytest.approx([pi, 0.5 - stretch])]
    assert [place.kind for place in found.places] == ["stable", "unstable"]


def test_changes_of_sign_find_what_no_seed_leads_to() -> None:
    """By hand: k phi + 9.81 cos(phi) = 0, alternately stable and unstable."""
    found = rests(read_text(f'{ROD}[springs.coil]\njoint = "pivot"\nstiffness = 0.25\n'))
    fine = np.linspace(-45, 45, 100_002)
    force = 0.25 * fine + 9.81 * np.cos(fine)
    expected = fine[:-1][force[:-1] * force[1:] < 0]
    assert [float(place.q[0]) for place in found.places] == pytest.approx(expected.tolist(), abs=2e-3)
    assert [place.kind for place in found.places[:2]] == ["stable", "unstable"]
    assert any(place.starts == 0 for place in found.places)
    assert found.scanned == pytest.approx(17 * pi)


def test_a_top_rests_upright_though_its_angles_are_singular_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = rests(read_text(TOP))
    assert not found.places
    assert [(abs(float(place.q[1])), place.kind) for place in found.locked] == [(0, "unstable"), (pi, "stable")]
    assert found.singular == 0
    path = tmp_path / "top.toml"
    path.write_text(TOP, encoding="utf-8")
    assert main(["linearize", str(path), "--start", "rest"]) == 1
    told = capsys.readouterr().err
    assert "2 positions of rest found" in told
    assert "where coordinates are singular: it has no one linear motion there" in told


def test_where_angles_are_singular_and_the_weight_pulls_it_does_not_rest() -> None:
    found = rests(read(FOUND / "heavy_top_zyx.toml"))
    assert not found.locked
    assert sorted(abs(float(place.q[1])) for place in found.false) == pytest.approx([pi / 2] * 4)
    assert found.singular > 0
    assert len(found.places) == 4


def test_inertia_and_stiffness_tell_the_modes() -> None:
    found = rests(symdyn.example("double_pendulum"))
    for place, system in zip(found.places, found.systems, strict=True):
        squares, _ = eigh(place.near.K, place.near.M)
        assert [square for square, _ in place.near.modes] == pytest.approx(squares.tolist(), rel=1e-9)
        for square, shape in place.near.modes:
            assert (
                np.abs(place.near.K @ shape - square * place.near.M @ shape).max() < 1e-9 * np.abs(place.near.K).max()
            )
        values = np.sort_complex([mode.value for mode in place.near.spectrum.modes])
        assert values == pytest.approx(np.sort_complex([mode.value for mode in system.modes]))


def test_a_place_at_which_a_motion_moves_no_mass_is_one_of_rest_without_a_linear_motion() -> None:
    crank = """[bodies.crank]
    [joints.free]
    type = "revolute"
    parent = "ground"
    child = "crank"
    drive = false
    [springs.coil]
    joint = "free"
    stiffness = 3
    """
    scene = read_text(f"{ROD.replace('ground', 'crank')}{crank}")
    found = rests(scene)
    assert [place.kind for place in found.places] == ["stable", "unstable"]
    assert [sorted(map(abs, place.q.tolist())) for place in found.places] == [pytest.approx([0, pi / 2])] * 2
    with pytest.raises(LinearizeError, match="moves no mass"):
        linearize_at_rest(scene)


def test_values_of_parameters_may_be_given_where_the_scene_has_none() -> None:
    text = ROD.replace("mass = 1,", 'mass = "m",').replace("[bodies", '[parameters]\nm = { unit = "kg" }\n[bodies', 1)
    found = rests(read_text(text), {"m": 2.0}, np.array([0.3]))
    assert [place.near.K.item() for place in found.places] == pytest.approx([2 * 9.81, -2 * 9.81])


def test_shapes_of_three_equal_carts_are_the_known_ones_without_rounding() -> None:
    K = np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 2]])
    squares, shapes = zip(*SecondOrder(np.eye(3), np.zeros((3, 3)), K).modes, strict=True)

    assert squares == pytest.approx([2 - 2**0.5, 2, 2 + 2**0.5])
    assert shapes[1][1] == 0.0
    assert abs(shapes[1][0] - shapes[1][2]) == pytest.approx(2)


PUCK = """
name = "puck"
gravity = "none"
[bodies]
puck = { mass = 1, com = [0, 0, 0], inertia = [1, 1, 1], inertia_about = "com" }
[joints]
table = { type = "planar", parent = "ground", child = "puck", axis = [0, 0, 1] }
[springs.coil]
from = "puck"
to = "ground"
stiffness = [10, 1]
"""


def test_a_place_at_which_a_spring_has_no_length_is_counted_and_not_listed() -> None:
    """Its force has no slope there, as it pulls along no way."""
    found = rests(read_text(PUCK))
    assert not found.places
    assert found.lost == found.starts > 0


FORK = """
name = "fork"
gravity = [0, 0, -9.81]
[bodies]
crown = { particles = [{ mass = 1, at = [1, 0, 0] }] }
wheel = { mass = 1, com = [0, 0, 0], inertia = [2, 2, 1.5], inertia_about = "com" }
[joints]
turn = { type = "revolute", parent = "ground", child = "crown", axis = [1, 0, 0], motion = "2*t" }
axle = { type = "revolute", parent = "crown", child = "wheel", axis = [0, 1, 0], origin = [0, -2, 0] }
[constraints.contact]
type = "rolling"
body = "wheel"
axis = [0, 1, 0]
radius = 0.5
components = ["along"]
"""


def test_a_motion_in_which_no_velocity_is_free_has_no_other_to_go_to(tmp_path: Path) -> None:
    path = tmp_path / "fork.toml"
    path.write_text(FORK)
    assert main(["walkthrough", str(path), "--detail", "full", "-o", str(tmp_path / "fork.md")]) == 0
