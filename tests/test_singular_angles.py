"""Angles that are singular: told where they are, and never taken for a property of the mechanism."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from symdyn.dynamics import derive
from symdyn.dynamics.loops.mobility import mobility
from symdyn.dynamics.mechanism.angles import three_angles
from symdyn.emit.targets.fmu import starting_state
from symdyn.errors import DerivationError, EmitError, SimulateError
from symdyn.scene import Scene, read, read_text
from symdyn.simulation import read_motion, simulate
from symdyn.simulation.initial import read_start

FOUND = Path(__file__).parent / "data" / "found"

TOP = """
name = "top"
[bodies.top]
mass = 1
com = [0, 0, 0.2]
inertia = [0.02, 0.02, 0.01]
inertia_about = "com"
[joints.tip]
type = "spherical"
parent = "ground"
child = "top"
orientation = "SEQUENCE"
coordinates = ["a", "b", "c"]
drive = false
start = [0.3, "MIDDLE", 0]
"""


def top(sequence: str, middle: str) -> Scene:
    return read_text(TOP.replace("SEQUENCE", sequence).replace("MIDDLE", middle), "top.toml")


def undriven(name: str) -> Scene:
    text = (FOUND / f"{name}.toml").read_text(encoding="utf-8")
    return read_text(text.replace('orientation = "zxz"', 'orientation = "zxz"\ndrive = false'), name)


@pytest.mark.mends("3.5")
def test_a_loop_whose_angles_start_singular_is_refused_in_simulate() -> None:
    with pytest.raises(SimulateError, match=r"joint j: theta = 0: the axes of psi and phi are parallel.*quaternion"):
        read_start(read(FOUND / "euler_hinge.toml"))


@pytest.mark.parametrize("guess", [{"psi": "1", "theta": "0.3", "phi": "-1"}, {"psi": "0.1", "theta": "0.3"}])
def test_a_start_near_a_position_that_is_not_singular_leads_there(guess: dict[str, str]) -> None:
    """With psi held first the loop would close at theta = 0, where psi alone is as free as any."""
    start = read_start(read(FOUND / "euler_hinge.toml"), guess)

    assert np.abs(start.q[3:]) == pytest.approx([np.pi / 2, 0.3, np.pi / 2])
    assert any("theta kept" in note for note in start.notes)


@pytest.mark.runs
@pytest.mark.mends("3.5")
def test_a_loop_whose_angles_start_singular_is_refused_in_inverse() -> None:
    from symdyn.simulation.inverse_run import inverse

    scene = undriven("euler_hinge")
    with pytest.raises(SimulateError, match=r"joint j: theta = 0: .*singular"):
        inverse(scene, read_motion(scene, ["theta=t"]), np.linspace(0, 1, 3))


@pytest.mark.runs
def test_a_tree_whose_angles_start_singular_is_refused_in_inverse_too() -> None:
    from symdyn.simulation.inverse_run import inverse

    scene = top("zxz", "0.2")
    with pytest.raises(SimulateError, match=r"start: joint tip: b = 0: .*quaternion"):
        inverse(scene, read_motion(scene, ["a=t", "b=0.1*t", "c=2*t"]), np.linspace(0, 1, 3))


def test_a_model_whose_angles_start_singular_is_refused() -> None:
    with pytest.raises(EmitError, match=r"top: start: joint tip: b = 0: .*singular"):
        starting_state(top("zxz", "0"))


@pytest.mark.mends("3.5")
def test_mobility_does_not_depend_on_angles() -> None:
    """Two hinges to the ground with crossed axes hold the body a: what is left is that b turns about it."""
    text = (FOUND / "euler_mobility.toml").read_text(encoding="utf-8")
    quaternion = mobility(read_text(text.replace('orientation="zxz"', ""), "stuck.toml"))
    angles = mobility(read_text(text, "stuck.toml"))

    assert angles.by_rank == quaternion.by_rank == 1
    assert angles.redundant == quaternion.redundant


@pytest.mark.mends("3.5")
def test_a_disc_whose_angles_start_singular_moves_its_mass() -> None:
    scene = read(FOUND / "euler_disc.toml")

    assert mobility(scene).by_rank == 3
    assert derive(scene, ("forward_dynamics",))["forward_dynamics"].entries


@pytest.mark.parametrize("sequence", ["zxz", "xyx", "zyx", "xyz", "zxy"])
def test_a_start_at_singular_angles_names_joint_angle_value_and_remedies(sequence: str) -> None:
    middle = "0" if sequence[0] == sequence[2] else "pi/2"
    value = "0" if sequence[0] == sequence[2] else "1.5708"
    another = "zyx" if sequence[0] == sequence[2] else "zxz"

    with pytest.raises(SimulateError, match=rf'start: joint tip: b = {value}: .* "{another}", or give another start'):
        read_start(top(sequence, middle))
    assert read_start(top(sequence, f"{middle} + 0.01")).q[1] == pytest.approx(float(value) + 0.01, abs=1e-5)


@pytest.mark.runs
@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_motion_that_comes_to_singular_angles_ends_with_its_rows(method: str) -> None:
    if method == "taylor":
        pytest.importorskip("heyoka")
    trajectory = simulate(top("zxz", "2"), until=5.0, method=method)

    assert trajectory.stopped.startswith("t = ")
    assert "the motion came to where the axes of a and c are parallel" in trajectory.stopped
    assert 0.2 < trajectory.t[-1] < 1.0
    assert np.isfinite(trajectory.table()[1]).all()
    assert trajectory["b"][-1] == pytest.approx(np.pi, abs=0.3)


def test_angles_that_loops_hold_where_they_are_singular_are_refused_by_what_divides_by_them() -> None:
    scene = read(FOUND / "euler_mobility.toml")

    with pytest.raises(DerivationError, match="joint ball: q2 = 0, where the loops hold it: the axes of q1 and q3"):
        derive(scene, ("forward_dynamics",))


def test_a_loop_closes_although_its_angles_are_singular_where_it_begins() -> None:
    """The hinge asks for a turn that the angles cannot make from zero; without them it is made, and told in angles."""
    text = (
        (FOUND / "euler_hinge.toml")
        .read_text(encoding="utf-8")
        .replace("axis = [0, 1, 0]", 'axis = [0, 1, 0]\norigin = [["Ry", 0.3], ["Rz", 0.4]]')
    )
    found = mobility(read_text(text, "hinge.toml"))

    assert found.by_rank == 1


@pytest.mark.mends("3.9")
def test_a_motion_is_idle_only_where_it_stays_so() -> None:
    """A rod on a Cardan joint can turn about itself where it stands upright, and nowhere else; the ring always can."""
    scene = read(Path(__file__).parent / "data" / "contacts" / "universal.toml")

    assert mobility(scene).idle == ("ring spins about the line of its joints",)


@pytest.mark.parametrize("axes", [a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if b not in (a, c)])
def test_three_angles_of_a_rotation_are_those_of_scipy(axes: Any) -> None:
    draw = np.random.default_rng(len(axes))
    for singular in (False, True):
        for _ in range(20):
            angles = draw.uniform(-3, 3, 3)
            angles[1] = (0.0 if axes[0] == axes[2] else np.pi / 2) if singular else angles[1]
            turned = Rotation.from_euler(axes.upper(), angles)
            x, y, z, w = turned.as_quat()
            found = three_angles(axes, w, x, y, z)
            assert (turned.inv() * Rotation.from_euler(axes.upper(), found)).magnitude() < 1e-14
            if not singular:
                off = np.array(found) - turned.as_euler(axes.upper())
                assert np.abs(off - 2 * np.pi * np.round(off / (2 * np.pi))).max() < 1e-14
