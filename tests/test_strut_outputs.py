"""Forces and lengths of springs and dampers by name: in outputs, runs, inverse runs and linear systems."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import signal

import symdyn
from symdyn.errors import SceneError, UnknownNameError
from symdyn.scene import Scene, read_text
from symdyn.scene.values import LETTERS

pytestmark = pytest.mark.runs("cc")

PLANE = (Path(__file__).parent / "data" / "findings" / "sp.toml").read_text(encoding="utf-8")
TURN = """
gravity = [0, "-9.81", 0]
[bodies.b]
mass = 2
com = [0.3, 0, 0]
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[joints.j]
type = "revolute"
parent = "ground"
child = "b"
axis = [0, 0, 1]
coordinate = "a"
drive = "M"
[springs.t]
joint = "j"
stiffness = 20
free = 0.2
[dampers.d]
joint = "j"
damping = 0.5
"""
CAR = (Path(__file__).parent / "data" / "findings" / "car.toml").read_text(encoding="utf-8")


def looked_at(text: str, *formulas: str) -> Scene:
    return read_text(
        text + "".join(f'\n[outputs.y{k}]\nformula = "{one}"\n' for k, one in enumerate(formulas)), "scene"
    )


def by_hand(run: symdyn.Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Return length and rate between (x + cos φ, y + sin φ) and (0, -1)."""
    x, y, phi, vx, vy, w = (run[name] for name in ("x", "y", "phi", "x_dot", "y_dot", "phi_dot"))
    way = np.array([x + np.cos(phi), y + 1 + np.sin(phi)])
    length = np.hypot(*way)
    return length, (way[0] * (vx - w * np.sin(phi)) + way[1] * (vy + w * np.cos(phi))) / length


def test_a_spring_between_points_has_a_force_and_a_length_in_outputs_and_in_runs() -> None:
    scene = looked_at(
        PLANE, "spring_s_force", "spring_s_length", "spring_s_rate", "damper_d_force", "spring_s_force*spring_s_rate"
    )
    run = symdyn.simulate(scene, until=2)
    length, rate = by_hand(run)
    expected = [10 * (length - 0.5), length, rate, 2 * rate, 10 * (length - 0.5) * rate]

    for k, values in enumerate(expected):
        np.testing.assert_allclose(run[f"y{k}"], values, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(run[["spring_s_force", "spring_s_rate"]].T, [expected[0], rate], rtol=1e-9, atol=1e-12)
    units = {one.name: one.unit for one in run.columns}
    assert [units[f"y{k}"] for k in range(5)] == ["N", "m", "m/s", "N", "W"]
    with pytest.raises(UnknownNameError, match="did you mean spring_s_force"):
        run["spring_s_forc"]


def test_both_formulations_say_the_same() -> None:
    car = looked_at(CAR, *LETTERS.of_struts(read_text(CAR, "car").struts))
    for scene in (
        looked_at(PLANE, "spring_s_force", "spring_s_rate"),
        looked_at(TURN, "spring_t_force", "damper_d_force"),
        car,
    ):
        assert symdyn.certify(scene, outputs=["outputs"]).passed


def test_a_spring_at_a_joint_has_a_force_against_its_coordinate() -> None:
    scene = looked_at(TURN, "spring_t_force", "damper_d_force")
    run = symdyn.simulate(scene, until=1)

    np.testing.assert_allclose(run["y0"], 20 * (run["a"] - 0.2), atol=1e-12)
    np.testing.assert_allclose(run["y1"], 0.5 * run["a_dot"], atol=1e-12)
    assert {one.unit for one in run.columns if one.name in ("y0", "y1")} == {"N m"}
    with pytest.raises(SceneError, match="spring_t_length"):
        looked_at(TURN, "spring_t_length")


def test_inverse_runs_have_them_and_the_energies() -> None:
    scene = looked_at(TURN, "kinetic_energy", "spring_t_force")
    run = symdyn.inverse(scene, motion={"a": "0.3*sin(2*t)"}, until=1)

    np.testing.assert_allclose(run["y0"], 0.14 * run["a_dot"] ** 2, atol=1e-12)
    np.testing.assert_allclose(run["kinetic_energy"], run["y0"], atol=1e-12)
    heights = 2 * 9.81 * 0.3 * np.sin(run["a"])
    np.testing.assert_allclose(run["potential_energy"], heights + 10 * (run["a"] - 0.2) ** 2, atol=1e-12)
    np.testing.assert_allclose(run["spring_t_force"], 20 * (run["a"] - 0.2), atol=1e-12)


def test_linear_systems_measure_them() -> None:
    here = {"x": 0.0, "y": 1.0, "phi": 0.4}
    names = ["spring_s_force", "spring_s_length", "spring_s_rate", "damper_d_force"]
    one = symdyn.linearize(read_text(PLANE, "sp"), start=here, anywhere=True, outputs=names)

    def length(x: float, y: float, phi: float) -> float:
        return float(np.hypot(x + np.cos(phi), y + 1 + np.sin(phi)))

    moved = [{**here, name: here[name] + 1e-6} for name in here]
    slopes = [(length(**place) - length(**here)) / 1e-6 for place in moved]
    C = np.zeros((4, 6))
    C[0, :3], C[1, :3], C[2, 3:], C[3, 3:] = (factor * np.array(slopes) for factor in (10, 1, 1, 2))
    np.testing.assert_allclose(one.C, C, atol=1e-4)
    assert one.outputs.units == ("N", "m", "m/s", "N")


def test_a_letter_of_the_scene_keeps_its_meaning() -> None:
    scene = looked_at(TURN.replace('drive = "M"', 'drive = "spring_t_force"'), "spring_t_force")
    run = symdyn.simulate(scene, until=0.5, forces={"spring_t_force": 1.5})
    np.testing.assert_array_equal(run["y0"], 1.5)


def test_events_and_measured_signals_know_them() -> None:
    run = symdyn.simulate(read_text(PLANE, "sp"), until=2, stops=["spring_s_length - 1"])
    assert by_hand(run)[0][-1] == pytest.approx(1)
    law = symdyn.Feedback(signal.TransferFunction([0.5], [0.1, 1.0]), measures="spring_t_force")
    run = symdyn.simulate(read_text(TURN, "turn"), start={"a": 0.3}, until=1, feedback=law)
    filtered = run["M"] + 0.1 * np.gradient(run["M"], run.t)
    np.testing.assert_allclose(filtered[2:-2], -0.5 * run["spring_t_force"][2:-2], rtol=2e-2, atol=0.02)


@pytest.mark.targets
def test_the_path_of_a_collocation_knows_them() -> None:
    bounds = {"spring_t_force": (-4, 6)}
    problem = symdyn.collocation(
        read_text(TURN, "turn"), 1, 10, cost="M**2", start={"a": 0}, end={"a": 0.4}, path=bounds
    )
    found = problem.solve()
    assert 20 * (found.run["a"].max() - 0.2) < 6 + 1e-6
