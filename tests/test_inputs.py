"""Inputs and outputs with a person's names: a cart that a motor drives, its voltage u, and what is looked at."""

from __future__ import annotations

import numpy as np
import pytest

import symdyn
from symdyn.errors import DerivationError, SceneError
from symdyn.scene import Scene, body, given, looked_at, point, prismatic, read_text, revolute, scene
from symdyn.scene.formats.toml_writer import write_text

CART = """
name = "motor_cart"
[parameters]
m = 2
mp = 0.3
l = 0.5
k = { value = 3, unit = "N/V" }
b = 0.4
[inputs.u]
unit = "V"
latex = "u_a"
text = "voltage of the motor"
[bodies.cart]
mass = "m"
[bodies.pole]
mass = "mp"
com = [0, 0, "-l"]
[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
drive = false
force = "k*u - b*x_dot"
[joints.hinge]
type = "revolute"
parent = "cart"
child = "pole"
axis = [0, 1, 0]
coordinate = "theta"
drive = false
start = 0.2
[points.tip]
body = "pole"
at = [0, 0, "-l"]
[outputs.way]
formula = "point_tip_x"
unit = "m"
[outputs]
pull = "reaction_hinge_fx_ground"
"""


@pytest.fixture(scope="module")
def cart() -> Scene:
    return read_text(CART, "cart.toml")


def by_hand(q, u, volt):
    """Return accelerations of cart and pole, where the tip is, and what the cart exerts on the pole along x."""
    m, mp, length, k, b = 2, 0.3, 0.5, 3, 0.4
    s, c = np.sin(q[1]), np.cos(q[1])
    M = np.array([[m + mp, -mp * length * c], [-mp * length * c, mp * length**2]])
    a = np.linalg.solve(M, [k * volt - b * u[0] - mp * length * s * u[1] ** 2, -mp * 9.81 * length * s])
    tip = a[0] - length * c * a[1] + length * s * u[1] ** 2
    return a, q[0] - length * s, mp * tip


STATE = np.array([0.1, 0.3]), np.array([0.5, -0.2])


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
        inputs=[given("u", unit="V", latex="u_a", text="voltage of the motor")],
        bodies=[body("cart", mass="m"), body("pole", mass="mp", com=[0, 0, "-l"])],
        joints=[
            prismatic("slide", "ground", "cart", axis=[1, 0, 0], coordinate="x", drive=False, force="k*u - b*x_dot"),
            revolute("hinge", "cart", "pole", axis=[0, 1, 0], coordinate="theta", drive=False, start="0.2"),
        ],
        points=[point("tip", "pole", [0, 0, "-l"])],
        outputs=[looked_at("way", "point_tip_x", unit="m"), looked_at("pull", "reaction_hinge_fx_ground")],
    )
    assert (made.inputs, made.outputs, made.joints) == (cart.inputs, cart.outputs, cart.joints)


@pytest.mark.parametrize(
    ("there", "wrong", "message"),
    [
        (
            'mass = "m"',
            'mass = "m*u"',
            "bodies.cart: mass = m[*]u uses u, an input; only forces, loads and outputs may",
        ),
        ("k*u - b", "k*v - b", "joints.slide: .* uses the undefined symbol v"),
        ("[inputs.u]", "[inputs.x]", '"x" is already the name of inputs.x'),
        ("[inputs.u]", "[inputs.t]", '"t" is used by generated code'),
        ("[outputs.way]", "[outputs.theta]", '"theta" is already the name of outputs.theta'),
        ("[outputs.way]", "[outputs.work]", '"work" is a column that every run may have'),
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
        symdyn.derive(cart, [request_])


def test_a_scene_without_inputs_has_no_derivatives_by_them():
    with pytest.raises(DerivationError, match=r"two_link has no inputs .*\[inputs.u\]"):
        symdyn.derive("examples/two_link.toml", ["forward_dynamics_by_inputs"])


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.long
def test_outputs_are_proved(cart):
    found = symdyn.certify(cart, ["outputs", "forward_dynamics", "outputs_by_inputs"])
    assert found.passed
