"""Inputs and outputs with a person's names: a cart that a motor drives, its voltage u, and what is looked at."""

from __future__ import annotations

import numpy as np
import pytest
from motor_cart import CART, STATE, by_hand

import symdyn
from symdyn.cli import main
from symdyn.errors import DerivationError, SceneError
from symdyn.scene import Scene, body, input_signal, output, point, prismatic, read_text, revolute, scene
from symdyn.scene.toml import write_text
from symdyn.teach import check_derivation, rendered, walkthrough


@pytest.fixture(scope="module")
def cart() -> Scene:
    return read_text(CART, "cart.toml")


# Scenes


def test_what_is_written_is_read_again(cart):
    text = write_text(cart).text
    assert read_text(text, "cart.toml") == cart
    assert "[inputs.u]" in text
    assert 'formula = "reaction_hinge_fx_ground"' in text


def test_python_declares_the_same(cart):
    made = scene(
        "motor_cart",
        parameters={"m": 2, "mp": "0.3", "l": "0.5", "k": 3, "b": "0.4"},
        inputs=[input_signal("u", unit="V", latex="u_a", text="voltage of the motor")],
        bodies=[body("cart", mass="m"), body("pole", mass="mp", com=[0, 0, "-l"])],
        joints=[
            prismatic("slide", "ground", "cart", axis=[1, 0, 0], coordinate="x", drive=False, force="k*u - b*x_dot"),
            revolute("hinge", "cart", "pole", axis=[0, 1, 0], coordinate="theta", drive=False, start="0.2"),
        ],
        points=[point("tip", "pole", [0, 0, "-l"])],
        outputs=[output("way", "point_tip_x", unit="m"), output("pull", "reaction_hinge_fx_ground")],
    )
    assert (made.inputs, made.outputs, made.joints) == (cart.inputs, cart.outputs, cart.joints)


@pytest.mark.parametrize(
    ("there", "wrong", "message"),
    [
        (
            'mass = "m"',
            'mass = "m*u"',
            "bodies.cart: mass = m[*]u uses u; a mass or an inertia changes by a state: write",
        ),
        ("k*u - b", "k*v - b", "joints.slide: .* uses the undefined symbol v"),
        ("[inputs.u]", "[inputs.x]", '"x" is already the name of inputs.x'),
        ("[inputs.u]", "[inputs.t]", '"t" is the time in formulas'),
        ("[outputs.way]", "[outputs.theta]", '"theta" is already the name of outputs.theta'),
        ("[outputs.way]", "[outputs.work]", '"work" is called like a column of runs'),
        ('"point_tip_x"', '"point_tio_x"', "undefined symbol point_tio_x; .*did you mean point_tip_x"),
        ('"reaction_hinge_fx_ground"', '"multiplier_cut"', "undefined symbol multiplier_cut"),
        ('unit = "V"', 'value = "k"', "inputs.u: value = k uses k; a value may hold numbers and pi only"),
        ('unit = "V"', "positive = true", "inputs.u: unknown key .positive."),
        ('formula = "point_tip_x"', "", "outputs.way: formula is missing"),
        ('latex = "u_a"', 'latex = "\\\\input{x}"', "inputs.u: latex = .* "),
        ('child = "pole"', 'child = "pole"\nmotion = "u"', "motion = u uses u, an input"),
    ],
)
def test_a_fault_is_told_where_it_is(there, wrong, message):
    with pytest.raises(SceneError, match=message):
        read_text(CART.replace(there, wrong, 1), "cart.toml")


# Equations


@pytest.mark.runs
def test_functions_take_inputs_and_outputs_are_functions(cart):
    found = symdyn.load(cart)
    nothing = np.zeros(2)
    a, way, pull = by_hand(*STATE, 5.0)
    np.testing.assert_allclose(found.forward_dynamics(*STATE, nothing, np.array([5.0])), a, rtol=1e-12)
    np.testing.assert_allclose(found.outputs(*STATE, nothing, np.array([5.0])), [way, pull], rtol=1e-12)
    np.testing.assert_allclose(found.inverse_dynamics(*STATE, a, np.array([5.0])), 0, atol=1e-12)


def test_outputs_have_derivatives(cart):
    names = ["output:way", "output_by_q:way", "outputs_by_inputs", "outputs_by_u"]
    _, by_q, *by_u = symdyn.lambdify(cart, names, target="numpy")
    nothing, h = np.zeros(2), 1e-6
    ahead, behind = (by_hand(*STATE, volt) for volt in (1 + h, 1 - h))
    slope = (ahead[2] - behind[2]) / (2 * h)
    np.testing.assert_allclose(by_q(*STATE, nothing), [[1, -0.5 * np.cos(0.3)]], rtol=1e-12)
    for one in by_u:
        np.testing.assert_allclose(one(*STATE, nothing), [[0], [slope]], rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        ("output:wy", "there is no output 'wy' in .outputs.; did you mean way"),
        ("output", "output needs an output; write output:NAME"),
        ("outputs_by_v", "v is neither an argument"),
    ],
)
def test_what_there_is_not_is_told(cart, request_, message):
    with pytest.raises(DerivationError, match=message):
        symdyn.dynamics.derive(cart, [request_])


def test_a_scene_without_inputs_has_no_derivatives_by_them():
    with pytest.raises(DerivationError, match=r"two_link has no inputs .*\[inputs.u\]"):
        symdyn.dynamics.derive("examples/two_link.toml", ["forward_dynamics_by_inputs"])


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.long
def test_outputs_are_proved(cart):
    found = symdyn.certify(cart, ["outputs", "forward_dynamics", "outputs_by_inputs"])
    assert found.passed


# What else reads scenes


def test_a_locked_joint_has_no_drive_to_look_at():
    text = CART.replace('coordinate = "theta"\ndrive = false', 'coordinate = "theta"\nlocked = true\ndrive = "M"', 1)
    gone = read_text(text.replace('"point_tip_x"', '"point_tip_x + 3*theta_ddot"'), "cart.toml")
    assert str(gone.outputs[0].formula.symbols) == "('point_tip_x',)"
    with pytest.raises(SceneError, match=r"outputs.way: uses M, which a locked joint has no more"):
        read_text(text.replace('"point_tip_x"', '"3*M"'), "cart.toml")


@pytest.mark.long(0)
def test_equations_and_lessons_show_the_letter(cart):
    assert "k*u - b*x_dot" in symdyn.equations(cart).text()
    assert "k u_a - b" in symdyn.equations(cart).latex()
    (answer,) = check_derivation(r"-m_p l \cos\theta \ddot x + m_p l^2 \ddot\theta = -9.81 m_p l \sin\theta", cart)
    assert answer.verdict == "proved"
    text = rendered(walkthrough(cart), "md")
    assert "u_a" in text[next(iter(text))]


def test_what_a_robot_file_cannot_hold_is_told(cart, tmp_path, capsys):
    (tmp_path / "cart.toml").write_text(CART, encoding="utf-8")
    assert main(["convert", str(tmp_path / "cart.toml"), str(tmp_path / "cart.urdf")]) == 1
    said = capsys.readouterr().err
    assert "inputs.u: the file has no inputs" in said
    assert "outputs.way = point_tip_x: the file has no outputs" in said
