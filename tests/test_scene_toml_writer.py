"""A scene written as TOML and read back is the same scene, and its text the same text."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from arms import cart_pole, chain, spatial_arm, three_link
from hypothesis import given, strategies as st
from mechanisms import coupled_tree, random_tree

from symdyn.errors import SceneError
from symdyn.scene import (
    Quantity,
    body,
    parameter,
    parse,
    read,
    read_text,
    revolute,
    scene,
    with_symbolic_inertia,
    write_text,
)
from symdyn.scene.toml import decimal
from symdyn.scene.values import Parameter, Pose
from symdyn.scene.values.body import Particle
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.joint import Limits

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.toml"))
SCENES = [
    *map(read, EXAMPLES),
    *(with_symbolic_inertia(read(path)) for path in EXAMPLES),
    *(cart_pole(), chain(3), spatial_arm(), three_link()),
    *(random_tree(seed, n) for seed in range(20) for n in (1, 5, 9)),
    *(coupled_tree(seed, n) for seed in range(20) for n in (3, 9)),
]


def there_and_back(one):
    written = write_text(one, "toml")
    assert written.lost == ()
    back = read_text(written.text)
    assert write_text(back, "toml").text == written.text
    return back


@pytest.mark.wide(4)
@pytest.mark.long
@pytest.mark.parametrize("k", range(len(SCENES)), ids=lambda k: f"{k}-{SCENES[k].name}")
def test_every_scene_reads_back_equal(k):
    assert there_and_back(SCENES[k]) == SCENES[k]


def test_all_that_a_scene_can_say_reads_back():
    one = scene(
        "everything",
        parameters=[
            parameter("m", "1/3", positive=True, unit="kg", latex=r"m_{\%,\text{o}}", text='a "name" with \\ and °'),
            parameter("bare"),
            parameter("plain", "pi/7"),
        ],
        gravity=False,
        bodies=[
            body("a", mass="m", first_moment=[0, 0, "bare"], inertia={"xx": "plain", "yz": "1e-30"}, about="frame"),
            body("b", mass=1, com=[1, 2, 3], inertia=[1, 1, 1], about="frame", allow_invalid_inertia=True),
            body(
                "c",
                particles=[Particle(Quantity.number(2), (Quantity.number(1), Quantity.number(0), parse("-plain/2")))],
                about="frame",
            ),
        ],
        joints=[
            revolute("j", "ground", "a", coordinate="phi", drive="M", force="-3*m*phi_dot", axis=[1, 2, 3]),
            revolute(
                "k", "a", "b", drive=False, origin={"rpy": [0, "90 deg", 0]}, tip=[("Rx", 1), ("Tx", 2), ("Rx", 3)]
            ),
            revolute("l", "b", "c", limits={"upper": "pi/2"}, armature="m/2", origin=Pose()),
        ],
    )

    assert there_and_back(one) == one


def test_the_text_is_short_and_says_only_what_is_not_usual():
    pendulum = scene(
        "pendulum",
        parameters={"l": "0.5"},
        bodies=[body("bob", mass=2, com=[0, "-l", 0])],
        joints=[revolute("hinge", "ground", "bob", limits={"lower": -1, "upper": "pi/2"})],
    )

    assert write_text(pendulum, "toml").text == (
        'name = "pendulum"\n'
        "\n[parameters]\nl = 0.5\n"
        '\n[bodies.bob]\nmass = 2\ncom = [0, "-l", 0]\n'
        '\n[joints.hinge]\ntype = "revolute"\nparent = "ground"\nchild = "bob"\naxis = [0, 0, 1]\n'
        'limits = { lower = -1, upper = "pi/2" }\n'
    )


def test_a_scene_out_of_normal_form_is_written_in_it():
    """A step that does nothing and a weld's axis say nothing, so they do not come back."""
    one = random_tree(3)
    idle = replace(one.joints[0], origin=Pose((("Tx", Quantity.number(0)), *one.joints[0].origin.steps)))

    assert there_and_back(replace(one, joints=(idle, *one.joints[1:]))) == one


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("0", "0"),
        ("-3", "-3"),
        ("9.81", "9.81"),
        ("-0.00015", "-0.00015"),
        ("0.000001", "1e-6"),
        ("-2.5e-7", "-2.5e-7"),
        ("1e22", "1e22"),
        ("6.02e23", "6.02e23"),
        ("120000", "120000"),
        ("1/3", None),
        ("0.1234567890123456789012345678901234567891", "0.1234567890123456789012345678901234567891"),
        ("0.12345678901234567890123456789012345678912", None),
    ],
)
def test_decimals(value, text):
    assert decimal(Fraction(value)) == text


@pytest.mark.long
@given(
    st.fractions(max_denominator=10**12) | st.decimals(allow_nan=False, allow_infinity=False, places=30).map(Fraction)
)
def test_every_number_comes_back_exactly(value):
    one = replace(SCENES[0], parameters=(*SCENES[0].parameters, Parameter("extra", Quantity.number(value))))

    assert there_and_back(one).parameters[-1].value == Quantity.number(value)


@pytest.mark.parametrize("written", ["", "g"])
def test_the_unit_that_was_chosen_comes_back_beside_a_value_in_another_one(written):
    extra = Parameter("extra", quantity("2 lb"), unit="kg", written=written)
    one = replace(SCENES[0], parameters=(*SCENES[0].parameters, extra))

    assert there_and_back(one).parameters[-1].written == written


@pytest.mark.long
@given(st.text(st.characters(exclude_categories=("C", "Z"), include_characters=" "), max_size=30))
def test_every_printable_text_comes_back(text):
    one = replace(SCENES[0], parameters=(*SCENES[0].parameters, Parameter("extra", text=text, unit="kg m^2")))

    assert there_and_back(one).parameters[-1] == Parameter("extra", text=text, unit="kg m^2")


def test_integers_fit_into_what_toml_promises():
    one = replace(
        SCENES[0], parameters=(*SCENES[0].parameters, Parameter("extra", Quantity.number(12345678901234567890123)))
    )

    value = tomllib.loads(write_text(one, "toml").text)["parameters"]["extra"]
    assert value == "12345678901234567890123"
    assert there_and_back(one) == one


def test_a_symbol_that_is_said_to_be_none_reads_back():
    text = '[parameters]\nm = { value = 1, latex = "" }\n[bodies.bob]\nmass = "m"\ncom = [1, 0, 0]\n'
    text += '[joints.hinge]\ntype = "revolute"\nparent = "ground"\nchild = "bob"\nforce = "u"\n[inputs.u]\nlatex = ""\n'
    one = read_text(text)

    assert (one.parameters[0].latex, one.inputs[0].latex) == ("", "")
    assert there_and_back(one) == one


def test_limits_without_bounds_are_not_written():
    assert all(joint.limits == Limits() for joint in SCENES[0].joints)
    assert "limits" not in write_text(SCENES[0], "toml").text


def test_an_unknown_format_is_named():
    with pytest.raises(SceneError, match='"tmol" is not a format that is written; did you mean toml'):
        write_text(SCENES[0], "tmol")
