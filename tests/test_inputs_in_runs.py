"""Inputs and outputs of a scene in runs, in linear systems, in loops, and by commands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from motor_cart import CART, by_hand

import symdyn
from symdyn.cli import main
from symdyn.errors import DerivationError
from symdyn.linear import linearize_along
from symdyn.scene import Scene, bind, read_text
from symdyn.simulation import Feedback
from symdyn.transcription import collocation

pytestmark = [pytest.mark.runs("cc"), pytest.mark.long]


@pytest.fixture(scope="module")
def cart() -> Scene:
    return read_text(CART, "cart.toml")


# Runs


def test_a_run_has_columns_of_inputs_and_outputs(cart):
    run = symdyn.simulate(cart, forces="u=12*sin(t)", until=1.0, reports=["point_tip_x - 0.1", "way + pull/100"])
    found = symdyn.load(cart)
    told = found.outputs(run.q, run.qd, np.zeros_like(run.qd), run["u"][:, None])

    np.testing.assert_allclose(run["u"], 12 * np.sin(run.t), rtol=1e-14)
    np.testing.assert_allclose(np.stack([run["way"], run["pull"]], axis=-1), told, atol=1e-13)
    assert [one.unit for one in run.columns if one.name in ("u", "way")] == ["V", "m"]
    assert {event.formula for event in run.events} == {"point_tip_x - 0.1", "way + pull/100"}
    for event in run.events:
        _, way, pull = by_hand(event.q, event.u, 12 * np.sin(event.t))
        assert (way - 0.1 if "point" in event.formula else way + pull / 100) == pytest.approx(0, abs=1e-9)


def test_energy_balances_where_the_motor_works(cart):
    assert symdyn.simulate(cart, forces="u=12*sin(t)", until=1.0).monitors["energy"] < 1e-10


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "bdf"])
def test_formulas_tables_functions_and_controllers_give_the_same_motion(cart, method):
    t = np.linspace(0, 0.5, 2001)
    ways = [{"u": "3 + 2*t"}, {"u": (t, 3 + 2 * t)}, {"u": lambda t: 3 + 2 * t}]
    runs = [
        symdyn.simulate(cart, forces=one, until=0.5, method=method) for one in ways[: 1 if method == "taylor" else None]
    ]
    if method != "taylor":
        runs.append(symdyn.simulate(cart, until=0.5, method=method, feedback=lambda t, q, u: 3 + 2 * t))
    right = symdyn.simulate(cart, forces="u = 3 + 2*t", until=0.5, rtol=1e-13, method="dop853")
    for run in runs:
        np.testing.assert_allclose(run.q[-1], right.q[-1], rtol=1e-6)
        np.testing.assert_allclose(run["u"], 3 + 2 * run.t, rtol=1e-9)


def test_an_input_that_nobody_gives_is_what_the_scene_says():
    scene = read_text(CART.replace('unit = "V"', 'unit = "V"\nvalue = "3/2"'), "cart.toml")
    given = symdyn.simulate(scene, forces="u=1.5", until=0.2)
    usual = symdyn.simulate(scene, until=0.2)
    np.testing.assert_allclose(usual.q, given.q, rtol=1e-13)
    assert set(usual["u"]) == {1.5}


def test_what_simulate_writes_inverse_reads(cart, tmp_path):
    run = symdyn.simulate(cart, forces="u=5*cos(3*t)", until=0.5, every=0.05)
    run.to_csv(tmp_path / "run.csv")
    back = symdyn.inverse(cart, str(tmp_path / "run.csv"), run.t)
    other = symdyn.inverse(cart, str(tmp_path / "run.csv"), run.t, forces="u = 0")

    assert abs(back.tau).max() < 1e-9
    np.testing.assert_allclose(back["pull"], run["pull"], atol=1e-9)
    np.testing.assert_allclose(other.tau[:, 0], 3 * run["u"], atol=1e-9)


@pytest.mark.parametrize(
    ("forces", "message"),
    [
        ("v=1", "v is neither a drive, an input nor a coordinate; known are u"),
        ("u=w", r"uses w, which is not known here; .*, or declare it, \[inputs.w\]"),
        ("u=-way", "uses way, which is not known here; .*, but no outputs: forces make them"),
        ("u=u+1", "uses u, which is not known here"),
        ("u=1/0", "divides by zero"),
    ],
)
def test_what_is_wrong_with_what_is_given_is_told(cart, forces, message):
    with pytest.raises(symdyn.SymdynError, match=message):
        symdyn.simulate(cart, forces=forces, until=0.1)


def test_an_array_over_a_coordinate_t_is_a_course(cart):
    xarray = pytest.importorskip("xarray")
    course = xarray.DataArray([0.0, 1.0], coords={"t": [0.0, 0.5]}, dims="t")
    run = symdyn.simulate(cart, forces={"u": course}, until=0.5)
    np.testing.assert_allclose(run["u"], 2 * run.t, atol=1e-12)
    with pytest.raises(symdyn.SymdynError, match=r"forces: u: .* is no course over time"):
        symdyn.simulate(cart, forces={"u": xarray.DataArray([0.0, 1.0], dims="s")}, until=0.5)


def test_units_of_outputs_are_those_of_what_they_name(cart):
    run = symdyn.simulate(cart, forces="u=1", until=0.1)
    told = {one.name: one.unit for one in run.columns}
    assert (told["way"], told["pull"]) == ("m", "N")


@pytest.mark.parametrize("method", ["dop853", "cvode"])
def test_what_a_sampled_force_jumps_over_is_an_event(cart, method):
    law = {"law": lambda t, q, u: 1 - 4 * (t > 0.25), "inputs": ("u",), "period": 0.1}
    run = symdyn.simulate(cart, until=1.0, method=method, feedback=Feedback(**law), reports="u")
    assert [event.t for event in run.events] == pytest.approx([0.3])
    run = symdyn.simulate(cart, until=1.0, method=method, feedback=Feedback(**law), stops="u")
    assert (run.stopped, run.t[-1], run["u"][-1]) == ("u", pytest.approx(0.3), -3)


def test_inverse_takes_inputs_alone():
    with pytest.raises(symdyn.SymdynError, match="forces: F: found from the motion; cart_pole has no input"):
        symdyn.inverse("examples/cart_pole.toml", {"x": "t"}, [0.0, 1.0], forces="F=1")


# Linear systems


def test_linear_systems_have_them_as_inputs_and_outputs(cart):
    feedback = "-2*theta + 1/2"
    one = symdyn.linearize(cart, start={"theta": "0.2"}, forces={"u": feedback}, anywhere=True)

    def rates(z, w):
        return np.concatenate([z[2:], by_hand(z[:2], z[2:], -2 * z[1] + 0.5 + w)[0]])

    def seen(z, w):
        return np.array(by_hand(z[:2], z[2:], -2 * z[1] + 0.5 + w)[1:])

    z, h = np.array([0, 0.2, 0, 0]), 1e-6
    for f, by_state, by_input in ((rates, one.A, one.B), (seen, one.C, one.D)):
        slopes = [(f(z + h * way, 0) - f(z - h * way, 0)) / (2 * h) for way in np.eye(4)]
        np.testing.assert_allclose(by_state, np.array(slopes).T, atol=1e-8)
        np.testing.assert_allclose(by_input[:, 0], (f(z, h) - f(z, -h)) / (2 * h), atol=1e-8)
    assert (one.inputs.names, one.inputs.units) == (("u",), ("V",))
    assert (one.outputs.names, one.outputs.units) == (("way", "pull"), ("m", "N"))
    assert one.point.inputs == pytest.approx([0.1])


def test_gains_drive_an_input(cart):
    gains = symdyn.linearize(cart, start={"theta": "0"}).lqr({"x": 1, "theta": 10}).gains()
    run = symdyn.simulate(cart, until=12.0, start={"x": "0.1", "theta": "0.2"}, feedback=gains)
    assert gains["inputs"] == ["u"]
    assert abs(run.q[-1]).max() < 0.01


def test_systems_along_a_run_keep_its_inputs(cart):
    run = symdyn.simulate(cart, forces="u=3*sin(t)", until=0.4, every=0.2)
    found = linearize_along(cart, run)
    for one, volt in zip(found, run["u"], strict=True):
        assert one.point.inputs == pytest.approx([volt])
        np.testing.assert_allclose(one.point.udot, by_hand(one.point.q, one.point.u, volt)[0], rtol=1e-9, atol=1e-12)


def test_outputs_of_a_linear_system_may_stand_in_one_text(cart):
    one = symdyn.linearize(cart, start={"theta": "0"}, outputs="way, atan2(x, 1)")
    assert one.outputs.names == ("way", "atan2(x, 1)")
    with pytest.raises(symdyn.SymdynError, match=r"outputs = .*: give text or a list of texts"):
        symdyn.linearize(cart, start={"theta": "0"}, outputs={"a": "2*way"})


# Loops


def test_outputs_of_a_motion_that_is_given_need_no_mass():
    """There is no forward dynamics of bars without mass, and what a load takes of the pins is there."""
    text = Path("examples/four_bar.toml").read_text(encoding="utf-8").replace(", positive = true", "")
    text += '[loads.push]\nbody = "rocker"\nat = ["c", 0, 0]\nforce = [10, 0, 0]\n'
    text += '[outputs]\npull = "reaction_elbow_fx_joint"\n'
    scene = bind(read_text(text, "four_bar.toml"), {"m1": 0, "m2": 0, "m3": 0})

    run = symdyn.inverse(scene, "phi=0.8+0.3*t", times=[0.0, 0.1], reactions="joint")

    assert np.abs(run["pull"]).min() > 1.0
    np.testing.assert_array_equal(run["pull"], run["reaction_elbow_fx_joint"])


FOUR_BAR = """
[inputs.V]
value = 2
[loads.push]
body = "crank"
at = [1, 0, 0]
force = ["V*sin(2*t)", 0, 0]
[outputs]
turn = "phi + chi"
closing = "multiplier_hinge_fx_joint"
pull = "reaction_elbow_fx_joint + V"
faster = "phi_ddot + 2*M*V"
"""


@pytest.mark.usefixtures("numpy_alone")
def test_outputs_of_a_closed_scene_are_the_same_in_runs_and_functions():
    text = Path("examples/four_bar.toml").read_text(encoding="utf-8") + FOUR_BAR
    scene = read_text(text, "four_bar.toml")
    run = symdyn.simulate(scene, forces={"V": "3*cos(2*t)", "M": "0.1*V"}, until=0.5, every=0.1)
    (outputs,) = symdyn.lambdify(scene, ["outputs"], target="numpy")
    told = outputs(run.q, run.qd, run.tau, run.t, run["V"][:, None])

    for k, one in enumerate(scene.outputs):
        np.testing.assert_allclose(run[one.name], told[:, k], rtol=1e-9, atol=1e-9)
    assert symdyn.certify(scene, ["outputs", "forward_dynamics_by_V"]).passed
    with pytest.raises(DerivationError, match="outputs: multiplier_hinge_fz is not known; did you mean"):
        symdyn.dynamics.derive(read_text(text.replace("hinge_fx_joint", "hinge_fz"), "four_bar.toml"), ["outputs"])


def test_collocation_holds_an_input_and_says_so(cart):
    assert "input u is held at 0 V" in collocation(cart, until=1.0, intervals=3).notes


def test_from_a_file_to_a_run_by_commands(tmp_path, capsys, monkeypatch):
    """As a user goes: look, generate C, simulate with a voltage, linearise, close the loop."""
    page = (Path(__file__).parent.parent / "docs" / "scenes.md").read_text(encoding="utf-8")
    block = page[page.index("    [parameters]\n    k = ") : page.index("What an output names, `simulate")]
    monkeypatch.chdir(tmp_path)
    Path("cart.toml").write_text(block.replace("    ", ""), encoding="utf-8")

    def run(*words):
        assert main(list(words)) == 0, words
        return capsys.readouterr()

    shown = run("info", "cart.toml").out
    assert "voltage of the motor" in shown
    assert "point_tip_x" in shown
    run("generate", "cart.toml", "--target", "c", "-o", "c")
    assert "const double *inputs" in Path("c/cart.h").read_text(encoding="utf-8")
    for target in ("numpy", "ufunc", "js"):
        run("generate", "cart.toml", "--target", target, "-o", target)
    run("simulate", "cart.toml", "--forces", "u=12*sin(t)", "--until", "1", "-o", "run.csv", "--report", "grip - 0.5")
    assert Path("run.csv").read_text(encoding="utf-8").partition("\n")[0].endswith(",grip,pull")
    run("inverse", "cart.toml", "--motion", "run.csv", "-o", "back.csv")
    assert "w = (u [V])" in run("linearize", "cart.toml").out
    run("linearize", "cart.toml", "--lqr", "Q=x:1;theta:10", "--gains", "gains.json")
    run("simulate", "cart.toml", "--feedback", "gains.json", "--until", "1", "--start", "theta=0.1", "-o", "held.csv")
    assert main(["linearize", "cart.toml", "--forces", "u = r"]) == 1
    assert "declare it, [inputs.r]" in capsys.readouterr().err
