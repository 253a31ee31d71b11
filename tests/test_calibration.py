"""Calibration against poses with a known truth, made by kinematics of matrices that share nothing with the graph."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import symdyn
from symdyn.errors import IdentifyError, SymdynError, UnknownNameError
from symdyn.identification import Calibration
from symdyn.identification.geometry import GeometricModel
from symdyn.scene import write_text

Poses = dict[str, Any]

ARM = {"m1": 1, "m2": 1, "h1": 0.4, "h2": 0.3, "g": 9.81}
PUMA = np.array([(0, 0, 90), (0, 0.4318, 0), (0.15005, 0.0203, -90), (0.4318, 0, 90), (0, 0, -90), (0, 0, 0)])
"""d, a, m, and alpha, degrees, of the example's file."""


def planar(q: Any, h1: float = 0.4, h2: float = 0.3, off: float = 0.0, noise: Any = 0.0) -> Poses:
    """Return poses of two links that hang down."""
    one, two = q[:, 0], q[:, 0] + q[:, 1] + off
    p = np.stack([h1 * np.sin(one) + h2 * np.sin(two), -h1 * np.cos(one) - h2 * np.cos(two)], axis=-1) + noise
    return {"q1": q[:, 0], "q2": q[:, 1], "x": p[:, 0], "y": p[:, 1]}


def puma(q: Any, offset: Any = 0.0, change: Any = 0.0) -> Any:
    """Return placements of link 6, shape (N, 4, 4), of a table of Denavit and Hartenberg that is off."""
    T = np.tile(np.eye(4), (len(q), 1, 1))
    for k, (d, a, alpha) in enumerate(PUMA * [1, 1, np.pi / 180] + change):
        step = np.tile(np.eye(4), (len(q), 1, 1))
        angle = q[:, k] + np.broadcast_to(offset, 6)[k]
        turn = Rotation.from_rotvec(angle[:, None] * [0, 0, 1]) * Rotation.from_rotvec([alpha, 0, 0])
        step[:, :3, :3] = turn.as_matrix()
        step[:, :3, 3] = np.stack([a * np.cos(angle), a * np.sin(angle), np.full(len(q), d)], axis=-1)
        T = T @ step
    return T


def columns(q: Any, T: Any, turns: str = "rx,ry,rz") -> Poses:
    """Return columns of a log."""
    R = Rotation.from_matrix(T[:, :3, :3])
    numbers = {"rx,ry,rz": R.as_rotvec, "qx,qy,qz,qw": R.as_quat, "roll,pitch,yaw": lambda: R.as_euler("xyz")}[turns]()
    found = {f"q{k + 1}": q[:, k] for k in range(q.shape[1])} | dict(zip("xyz", T[:, :3, 3].T, strict=True))
    return found | dict(zip(turns.split(","), numbers.T, strict=True))


def states(count: int, joints: int, seed: int = 0) -> Any:
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (count, joints))


def arm(poses: Any, *parameters: str, **more: Any) -> Calibration:
    return symdyn.calibrate(symdyn.example("two_link"), poses, parameters=parameters or None, values=ARM, **more)


@pytest.mark.parametrize("turns", ["rx,ry,rz", "qx,qy,qz,qw", "roll,pitch,yaw"])
def test_a_table_of_denavit_and_hartenberg_that_is_off_is_recovered_without_noise(turns: str) -> None:
    q, rng = states(30, 6), np.random.default_rng(3)
    offset, change = 2e-3 * rng.standard_normal(6), 1e-3 * rng.standard_normal((6, 3))

    found = symdyn.calibrate(symdyn.example("puma560"), columns(q, puma(q, offset, change), turns), "link6")

    assert len(found.names) == 4 * 6 + 6 or turns != "rx,ry,rz"  # Everett: 4 a revolute joint, and 6
    assert max(fit[3] for fit in found.fits) < 1e-9  # mm, mrad
    assert min(fit[2] for fit in found.fits) > 1


@pytest.mark.parametrize(("name", "count"), [("puma560", 30), ("arm7", 34)])
def test_parameters_are_recovered_and_the_written_scene_predicts_as_the_table_says(name: str, count: int) -> None:
    scene = symdyn.example(name)
    body = scene.bodies[-1].name
    model = GeometricModel.of(scene, body)
    q = states(25, len(scene.coordinates))

    def posed(values: Any) -> Poses:
        p, R, _ = model.at(values, q)
        T = np.concatenate([np.concatenate([R, p[:, :, None]], axis=2), np.zeros((len(q), 1, 4))], axis=1)
        return columns(q, T)

    told = symdyn.calibrate(scene, posed(model.values), body).names
    truth = model.values.copy()
    places = [model.names.index(one) for one in told]
    truth[places] = 2e-3 * np.random.default_rng(1).standard_normal(len(places))
    found = symdyn.calibrate(scene, posed(truth), body)
    again = symdyn.calibrate(symdyn.scene.read_text(write_text(found.calibrated, "toml").text), posed(truth), body)

    assert len(told) == count
    assert found.names == told
    np.testing.assert_allclose(found.after, truth[places], atol=1e-9)
    assert again.fits[0][2] < 1e-6  # mm, ten digits
    assert again.fits[0][2] == pytest.approx(found.fits[0][3], abs=1e-6)


def test_estimates_and_errors_are_those_of_least_squares_by_another_program() -> None:
    q = states(40, 2)
    noise = 1e-4 * np.random.default_rng(5).standard_normal((40, 2))
    poses = planar(q, 0.403, 0.298, 4e-3, noise)

    def off(theta: Any) -> Any:
        model = planar(q, *theta)
        return np.concatenate([model["x"] - poses["x"], model["y"] - poses["y"]])

    other = least_squares(off, [0.4, 0.3, 0.0], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    deviation = np.sqrt(np.diag(np.linalg.inv(other.jac.T @ other.jac)) * 2 * other.cost / (80 - 3))
    found = arm(poses, "h1", "h2", "q2_offset")

    np.testing.assert_allclose([found[name] for name in ("h1", "h2", "q2_offset")], other.x, rtol=1e-7)
    errors = dict(zip(found.names, found.errors, strict=True))
    np.testing.assert_allclose([errors[name] for name in ("h1", "h2", "q2_offset")], deviation, rtol=0.02)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    held = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        q = rng.uniform(-2, 2, (30, 2))
        found = arm(planar(q, 0.403, 0.298, 4e-3, 1e-4 * rng.standard_normal((30, 2))), "h*", "q2_offset")
        truth = {"h1": 0.403, "h2": 0.298, "q2_offset": 4e-3}
        ends = zip(found.names, found.interval(), strict=True)
        held += [low <= truth[name] <= high for name, (low, high) in ends]
    assert np.mean(held) >= 0.8


def test_what_no_motion_separates_is_named_and_keeps_its_value() -> None:
    found = arm(planar(states(40, 2), 0.403, 0.298), "h2", "tool.y", "h1")

    assert found.names == ("h1", "h2")
    assert [one.parameters for one in found.not_identifiable] == [("h2", "tool.y")]
    assert "h2" in found.notes[0]
    assert "tool.y" in found.notes[0]


def test_the_zero_of_a_joint_that_turns_about_minus_z_is_written_with_its_sign() -> None:
    text = write_text(symdyn.example("two_link"), "toml").text.replace("axis = [0, 0, 1]", "axis = [0, 0, -1]")
    scene, q = symdyn.scene.scene_of(symdyn.scene.read_text(text), ARM), states(30, 2)
    poses = planar(-q, off=-0.01) | {"q1": q[:, 0], "q2": q[:, 1]}

    found = symdyn.calibrate(scene, poses, parameters="q2_offset")

    assert found["q2_offset"] == pytest.approx(0.01, abs=1e-9)
    assert symdyn.calibrate(found.calibrated, poses).fits[0][2] < 1e-6


def test_outliers_are_left_out_and_told() -> None:
    poses = planar(states(40, 2), 0.403, 0.298, 0.0, 1e-4 * np.random.default_rng(0).standard_normal((40, 2)))
    poses["x"][7] += 0.03

    found = arm(poses)

    assert found.outliers == (8,)
    assert found["h1"] == pytest.approx(0.403, abs=1e-4)
    assert any(note.startswith("pose 8: not fitted") for note in found.notes)
    assert not arm(poses, outliers=False).outliers


def test_none_of_three_poses_is_an_outlier() -> None:
    rng, few = np.random.default_rng(1), "too few poses to tell one that no noise explains: all were fitted"
    for seed in range(12):
        found = arm(planar(states(3, 2, seed), noise=1e-4 * rng.standard_normal((3, 2))))

        assert not found.outliers
        assert few in found.notes
    assert few not in arm(planar(states(40, 2), noise=1e-4 * rng.standard_normal((40, 2)))).notes


def test_a_cart_called_x_is_no_measured_position() -> None:
    scene = symdyn.scene.read_text(
        '[bodies.x1]\nmass = 1\n[joints.rail]\ntype = "prismatic"\nparent = "ground"\nchild = "x1"\naxis = [1, 0, 0]\n'
        'coordinate = "x"\n[points.p]\nbody = "x1"\n'
    )
    x = np.linspace(-1, 1, 20)

    found = symdyn.calibrate(scene, {"x": x, "p.x": x + 0.01, "p.y": 0 * x, "p.z": 0 * x}, parameters="x_offset")

    assert found["x_offset"] == pytest.approx(0.01)
    with pytest.raises(IdentifyError, match="has no pose of p"):
        symdyn.calibrate(scene, {"x": x, "y_": x})


def q2(**changed: Any) -> Poses:
    return {name: one for name, one in (planar(states(30, 2)) | changed).items() if one is not None}


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "a coordinate is missing": (lambda: arm(q2(q2=None, q22=np.zeros(30))), "has no column q2"),
    "no position": (lambda: arm(q2(x=None, y=None)), "has no pose of tool; name columns x, y, z or tool.x"),
    "half an orientation": (lambda: arm(q2(rx=np.zeros(30))), "takes all of rx, ry, rz"),
    "no quaternion": (
        lambda: arm(q2(**{name: np.ones(30) for name in ("qx", "qy", "qz", "qw")})),
        "no unit quaternion",
    ),
    "too few poses": (lambda: arm(planar(states(2, 2)), "*"), "2 poses give 4 numbers, too few for 10 parameters"),
    "the ground": (
        lambda: symdyn.calibrate(symdyn.example("two_link"), q2(), "ground", values=ARM),
        "there is no point or body ground",
    ),
    "does not move the point": (lambda: arm(q2(), "m1"), "m1 does not move tool"),
    "not known": (lambda: arm(q2(), "h11"), "there is no h11; did you mean h1"),
    "millimetres": (lambda: arm(q2(x=1e3 * np.sin(states(30, 2)[:, 0]))), "no parameters near the scene's fit"),
    "degrees": (lambda: arm(q2(q1=np.degrees(states(30, 2)[:, 0]))), "in SI with radians"),
    "no data": (lambda: arm(3), "int holds no poses"),
    "parameters without a value": (lambda: symdyn.calibrate(symdyn.example("two_link"), q2()), "m1"),
    "which point": (lambda: symdyn.calibrate(symdyn.example("quadruped"), {}), "say which point was measured"),
    "a level": (lambda: arm(q2()).interval(2.0), "level = 2 is no probability"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_calibrated_is_told_in_words(case: str) -> None:
    call, words = REFUSED[case]
    with pytest.raises(SymdynError, match=words):
        call()


def test_a_point_that_nothing_moves_is_told() -> None:
    text = write_text(symdyn.example("two_link"), "toml").text
    scene = symdyn.scene.read_text(text + '[points.floor]\nbody = "ground"\nat = [0, 1, 0]\n')
    with pytest.raises(IdentifyError, match="floor does not move: no joint with a coordinate carries it"):
        symdyn.calibrate(scene, {"x": [0, 1]}, "floor", values=ARM)


def test_one_pose_again_and_again_tells_a_sum_of_lengths() -> None:
    found = arm(planar(np.zeros((30, 2)), 0.41))

    assert found.names == ("h1",)
    assert [(one.parameters, one.why) for one in found.not_identifiable] == [
        (("h2", "h1"), "these poses do not separate them")
    ]


@pytest.mark.slow
def test_a_plot_shows_the_error_of_every_pose(tmp_path: Path) -> None:
    found = arm(planar(states(40, 2), 0.403))
    found.save_plot(tmp_path / "one.svg")
    found.save_plot(tmp_path / "two.svg")

    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
    assert (tmp_path / "one.svg").stat().st_size > 10_000


def test_what_a_person_holds_answers() -> None:
    found = arm(planar(states(40, 2), 0.403))

    assert "2 parameters, position" in repr(found)
    assert [name for name, *_ in found.tables[0].rows] == ["h1", "h2"]
    assert found.as_dict()["fits"][0]["of"] == "position"
    assert found.observability > 0.5
    with pytest.raises(UnknownNameError, match="g was not estimated"):
        found["g"]
