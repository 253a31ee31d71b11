"""Dimensions: every term measures what is asked for, and letters without a unit take that of where they stand."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from dimensional import PENDULUM, output, pendulum
from hypothesis import given, settings, strategies as st

import symdyn
from symdyn.cli import main
from symdyn.errors import SceneError, SimulateError
from symdyn.scene import Scene, bind, body, parameter, prismatic, read, read_text, revolute, scene, write_text
from symdyn.scene.values.unit import Unit

ROOT = Path(__file__).parent.parent

WRONG = [  # changed, and what is said; each of them was read without a word
    ('mass = "m"', 'mass = "m + l"', r"bodies.bob: mass = m \+ l: m is in kg, and l is in m"),
    ('mass = "m"', 'mass = "k"', "bodies.bob: mass = k is in N/m, and kg is asked for"),
    ('com = [0, "-l", 0]', 'com = [0, "-m", 0]', r"com\[1\] = -m is in kg, and m is asked for"),
    ('com = [0, "-l", 0]', 'com = [0, "l**2", 0]', r"com\[1\] = l\*\*2 is in m\^2, and m is asked for"),
    ('"m*l**2/12", 0', '"m*l", 0', r"inertia\[0\] = m\*l is in kg m, and kg m\^2 is asked for"),
    ('"-g", 0', '"-w", 0', r"gravity\[1\] = -w is in rad/s, and m/s\^2 is asked for"),
    ("-b*phi_dot", "-b*phi", r"force = .*: -b\*phi is in N m s, and m\*g\*l\*sin\(phi - w\*t\) is in N m"),
    ("phi - w*t", "phi - t", "phi is a plain number, and t is in s"),
    ("sin(phi - w*t)", "sin(w)", r"w is in rad/s, and sin takes a plain number"),
    ('force = "', 'motion = "w"\nforce = "', r"motion = w is in rad/s, and rad is asked for"),
    ('force = "', 'damping = "k"\nforce = "', r"damping = k is in N/m, and N m s/rad is asked for"),
    ('force = "', 'start = "l"\nforce = "', r"start = l is in m, and rad is asked for"),
    ('at = [0, "-l", 0]', 'at = [0, 0, "sqrt(l)"]', r"at.Tz = sqrt\(l\) is in m\^\(1/2\), and m is asked for"),
    ('at = [0, "-l", 0]', 'at = [["Rz", "l"]]', "at.Rz = l is in m, and rad is asked for"),
    ('at = [0, "-l", 0]', 'at = [0, "atan2(m, l)", 0]', "m is in kg, and l is in m"),
]


@pytest.mark.mends("30.control.1")
@pytest.mark.parametrize(("old", "new", "words"), WRONG)
def test_a_term_of_letters_alone_that_measures_something_else_is_refused(old: str, new: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        pendulum(old, new)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('com = [0, "-l", 0]', 'com = [0, "-m/2", 0]', r"com\[1\] = -m/2 is in kg, and m is asked for"),
        ('com = [0, "-l", 0]', 'com = [0, "2*l + m/3", 0]', r"com\[1\] = .*m/3 is in kg, and m is asked for"),
        ('com = [0, "-l", 0]', 'com = [0, "sqrt(2)*m", 0]', "is in kg, and m is asked for"),
        ('"m*l**2/12", 0', '"pi*k**2*m/12", 0', r"inertia\[0\] = .* and kg m\^2 is asked for"),
    ],
)
def test_a_number_of_shapes_excuses_no_unit_that_is_said(old: str, new: str, words: str) -> None:
    """With l in kilograms, l/2 passed without a word."""
    with pytest.raises(SceneError, match=words):
        pendulum(old, new)


@pytest.mark.parametrize("left_out", ["l**2/4", "m/12", "0.1*k", "12*u", "u/2", "p*m/2", "m*l*phi/2", "phi_dot/2"])
def test_a_number_that_may_stand_for_a_quantity_is_free(left_out: str) -> None:
    """A mass or a length of 1, a gain of an input or of a coordinate, one beside a letter without a unit."""
    own = "-b*phi_dot" if {"phi", "u"}.intersection(re.findall(r"[a-z]+", left_out)) else "m*l**2/12"
    assert read_text(PENDULUM.replace(own, left_out), "p.toml")


@pytest.mark.mends("30.control.1")
@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("m*l*phi + m", r"m\*l\*phi is in kg m, and m is in kg"),
        ("point_tip_x - phi", "point_tip_x is in m, and phi is a plain number"),
        ("reaction_hinge_fx + reaction_hinge_mx", "reaction_hinge_fx is in N, and reaction_hinge_mx is in N m"),
        ("tau1 - m*phi_ddot", r"tau1 is in N m, and m\*phi_ddot is in N/m"),
    ],
)
def test_formulas_of_outputs_are_checked(formula: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        pendulum(more=output(formula))


def test_an_output_is_what_its_unit_says() -> None:
    with pytest.raises(SceneError, match=r"outputs.y: formula = m\*phi is in kg, and N is asked for"):
        pendulum(more=output("m*phi", ', unit = "N"'))
    assert pendulum(more=output("m*phi", ', unit = "kg rad"')).outputs[0].unit == "kg rad"


@pytest.mark.mends("30.control.1")
@pytest.mark.runs("cc")
def test_formulas_of_stops_measures_and_costs_are_checked() -> None:
    one, words = pendulum(), r"phi is a plain number, and phi_dot is in rad/s"
    with pytest.raises(SimulateError, match=words):
        symdyn.simulate(one, until=0.1, stops="phi - phi_dot")
    with pytest.raises(SimulateError, match=words):
        symdyn.linearize(one, start={"phi": 0}, outputs=["phi + phi_dot"])
    with pytest.raises(SimulateError, match=r"kinetic_energy is in N m, and m\*l is in kg m"):
        symdyn.ensemble(one, forces={}, until=0.1, measures=["max(kinetic_energy - m*l)"])
    with pytest.raises(SimulateError, match=r"max\(...\) is a plain number, and integral\(...\) is in s"):
        symdyn.ensemble(one, forces={}, until=0.1, measures=["max(phi) - integral(phi)"])
    with pytest.raises(SimulateError, match=r"tau1\*\*2 is in .*, and phi\*\*2 is a plain number"):
        symdyn.collocation(one, until=1.0, intervals=3, cost="tau1**2 + phi**2")


def test_numbers_that_stand_as_factors_may_carry_a_dimension_and_are_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = PENDULUM.replace("-b*phi_dot", "12*u - b*phi_dot - 0.7*l").replace('"-l", 0]\n[p', '"-u/2", 0]\n[p')
    (tmp_path / "p.toml").write_text(text.replace("phi - w*t", "phi - 3*t"))

    assert main(["info", "--units", str(tmp_path / "p.toml")]) == 0

    said = capsys.readouterr().out
    for line in (
        "12 in joints.hinge: force = 12*u - b*phi_dot - 0.7*l - m*g*l*sin(phi - 3*t) would have to be N m/V",
        "0.7 in joints.hinge: force = 12*u - b*phi_dot - 0.7*l - m*g*l*sin(phi - 3*t) would have to be N",
        "3 in joints.hinge: force = 12*u - b*phi_dot - 0.7*l - m*g*l*sin(phi - 3*t) would have to be 1/s",
        "1/12 in",
    ):
        assert (line in said) == (line != "1/12 in"), said


FREE = PENDULUM.replace('mass = "m"', 'mass = "m + l"').replace("p = 7", "p = 7").replace("w*t", "t")


def test_a_scene_without_dimensions_says_so_and_keeps_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "p.toml").write_text(FREE)
    with pytest.raises(SceneError, match='write units = "none" at the top'):
        read(tmp_path / "p.toml")

    found = read_text(f'units = "none"\n{FREE}', "p.toml")
    assert read_text(write_text(found, "toml").text) == found
    assert 'units = "none"' in write_text(found, "toml").text
    assert read(tmp_path / "p.toml", units="none") == found
    assert main(["info", "--no-units", "--units", "--json", str(tmp_path / "p.toml")]) == 0
    told = json.loads(capsys.readouterr().out)["result"]
    assert (told["checked"], told["numbers"]) == (False, [])
    with pytest.raises(SceneError, match='units = "SI" is not known; write units = "none"'):
        read_text(f'units = "SI"\n{PENDULUM}')


def test_python_says_it_alike() -> None:
    parts: dict[str, Any] = {
        "parameters": [parameter("m", 1, unit="kg")],
        "bodies": [body("b", mass="m", com=["m", 0, 0])],
        "joints": [revolute("j", "ground", "b", axis=[0, 0, 1])],
    }
    with pytest.raises(SceneError, match=r'com\[0\] = m is in kg, .*write units = "none" at the top'):
        scene("s", **parts)
    assert scene("s", **parts, units="none").dimensionless


def test_a_robot_file_is_read_without_dimensions_by_a_flag(tmp_path: Path) -> None:
    text = (ROOT / "tests" / "data").glob("*.par")
    path = next(iter(sorted(text)))
    assert read(path, units="none").dimensionless
    assert not read(path).dimensionless


def test_a_value_that_is_bound_with_a_unit_fits_where_its_letter_stands() -> None:
    one = pendulum(more='[outputs]\ny = { formula = "p*l", unit = "N" }\n')

    assert bind(one, {"p": "3 N/m"}).parameters[-1].unit == "N/m"
    with pytest.raises(SceneError, match=r"p\*l is in kg m, and N is asked for"):
        bind(one, {"p": "3 kg"})


DIMENSIONS = {"m": "kg", "l": "m", "k": "N/m", "w": "rad/s", "g": "m/s^2", "phi": "1"}
ROUND = {"bicycle": {"0.9", "-0.9", "-0.7"}, "rolling_disc": {"6"}}
"""Lengths in metres that stand beside letters, and a rate of spin, 6 rad/s."""


@pytest.mark.long(0)
@settings(max_examples=30)
@given(powers=st.lists(st.integers(-1, 1), min_size=6, max_size=6), extra=st.sampled_from(list(DIMENSIONS)[:5]))
def test_a_product_of_letters_is_of_the_product_of_their_units(powers: list[int], extra: str) -> None:
    """The unit of an output by hand: right where it is so, refused with one letter more."""

    def formula(given: dict[str, int]) -> str:
        return "*".join(f"{name}**{n}" for name, n in given.items() if n) or "phi"

    held = dict(zip(DIMENSIONS, powers, strict=True))
    unit = Unit.read("1")
    for name, n in held.items():
        unit = unit * Unit.read(DIMENSIONS[name]) ** n
    said = f', unit = "{unit.dimension.text}"'
    assert pendulum(more=output(formula(held), said)).outputs[0].unit == unit.dimension.text
    held[extra] += 1
    with pytest.raises(SceneError, match="is asked for"):
        pendulum(more=output(formula(held), said) if any(held.values()) else output("phi", said))


EXAMPLES = sorted([*ROOT.glob("examples/*.toml"), *ROOT.glob("examples/gallery/*.toml")])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_no_number_of_an_example_has_to_carry_a_dimension_unseen(path: Path) -> None:
    """All letters of our scenes have a unit, and numbers beside them are plain, or are those that are known here."""
    from symdyn.cli.info import unit_facts

    facts = unit_facts(read(path))

    assert all(one["unit"] for one in facts["letters"]), facts["letters"]
    assert {one["number"] for one in facts["numbers"]} == ROUND.get(path.stem, set()), facts["numbers"]


@pytest.mark.runs
def test_the_package_imports_nothing_of_dimensions() -> None:
    code = (
        "import sys, symdyn\nloaded = [one for one in sys.modules if 'dimension' in one]\nassert not loaded, loaded\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


def test_a_joint_that_follows_another_is_so_many_units_of_it() -> None:
    parts: dict[str, Any] = {
        "parameters": [parameter("r", "1/10", unit="m"), parameter("n", 3)],
        "bodies": [body("a", mass=1), body("b", mass=1)],
    }
    lead = revolute("lead", "ground", "a", axis=[0, 0, 1])

    def follower(ratio: str) -> Scene:
        rack = prismatic("rack", "ground", "b", axis=[1, 0, 0], mimic={"joint": "lead", "ratio": ratio})
        return scene("s", joints=[lead, rack], **parts)

    assert follower("r").joints[1].coupling is not None
    assert follower("n*r/2").joints[1].coupling is not None
    with pytest.raises(SceneError, match=r"mimic.ratio = r\*\*2 is in m\^2, and m/rad is asked for"):
        follower("r*r")


def test_fractions_of_exponents_are_exact() -> None:
    from symdyn.scene.values.dimension import LENGTH, TIME

    assert (LENGTH**2 / TIME) ** Fraction(1, 2) == LENGTH / TIME ** Fraction(1, 2)
    assert hash((LENGTH**2) ** Fraction(1, 2)) == hash(LENGTH)


def test_a_scene_that_is_locked_where_a_factor_of_one_is_left_is_written_and_read_again() -> None:
    text = """
[parameters]
k = { value = 3, unit = "N/m" }
[bodies.a]
mass = 1
[bodies.b]
mass = 2
[joints.first]
type = "prismatic"
parent = "ground"
child = "a"
axis = [1, 0, 0]
coordinate = "x"
locked = true
position = PLACE
[joints.second]
type = "prismatic"
parent = "a"
child = "b"
axis = [0, 1, 0]
force = "-k*x - 2*q2_dot*atan2(0, x)"
"""
    for place in ("1", "0.5", "0", '"-100 cm"'):
        found = read_text(text.replace("PLACE", place), "l.toml")
        assert read_text(write_text(found, "toml").text) == found
        assert found.dimensionless == (place in ("1", '"-100 cm"'))
