"""Values that say their unit: exact in SI by every door, refused where they do not fit, written back as they were."""

from __future__ import annotations

import math
import re
import tomllib
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from fmus import model_of, sources_of
from hypothesis import example, given, settings, strategies as st

import symdyn
from symdyn.cli import main
from symdyn.cli.scene_options import read_bindings
from symdyn.errors import IdentifyError, SceneError, SimulateError
from symdyn.identification.identified_scene import with_parameters
from symdyn.scene import Scene, bind, body, parameter, parse, read_text, revolute, scene, write_text
from symdyn.scene.values import spell
from symdyn.simulation.initial import read_start
from symdyn.simulation.prescribed.forces import read_forces

PENDULUM = """
gravity = [0, -9.81, 0]
[parameters]
m = {m}
l = {l}
[bodies.bob]
mass = "m"
com = [0, "-l", 0]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
coordinate = "phi"
{more}
"""

UNITS = {  # by hand: unit, the factor and the power of pi to SI, the unit of SI
    "m": ("1", 0, "m"),
    "mm": ("1/1000", 0, "m"),
    "cm": ("1/100", 0, "m"),
    "um": ("1/1000000", 0, "m"),
    "in": ("254/10000", 0, "m"),
    "kg": ("1", 0, "kg"),
    "g": ("1/1000", 0, "kg"),
    "t": ("1000", 0, "kg"),
    "kN/m": ("1000", 0, "N/m"),
    "N/mm": ("1000", 0, "N/m"),
    "mN m": ("1/1000", 0, "N m"),
    "g cm^2": ("1/10000000", 0, "kg m^2"),
    "km/h": ("10/36", 0, "m/s"),
    "deg": ("1/180", 1, "rad"),
    "rpm": ("1/30", 1, "rad/s"),
    "turn": ("2", 1, "rad"),
    "mm/s^2": ("1/1000", 0, "m/s^2"),
    "%": ("1/100", 0, "1"),
}


def pendulum(m: str = "1", l: str = "0.5", more: str = "") -> Scene:  # noqa: E741
    return read_text(PENDULUM.format(m=m, l=l, more=more), "pendulum.toml")


@pytest.mark.mends("30.control.1")
@pytest.mark.parametrize("l", ['{ value = 500, unit = "mm" }', '"500 mm"'])
def test_a_pendulum_of_500_mm_swings_as_one_of_half_a_metre(l: str) -> None:  # noqa: E741
    said, plain = (symdyn.linearize(pendulum(l=one), start={"phi": "0"}).modes[0].frequency for one in (l, "0.5"))

    assert said == plain == pytest.approx(math.sqrt(9.81 / 0.5) / 2 / math.pi, rel=1e-9)


PARTS = {"bodies": [body("b", mass=1)], "joints": [revolute("hinge", "ground", "b", axis=[0, 0, 1])]}

BODY = '[bodies.b]\nmass = 1\n[joints.hinge]\ntype = "revolute"\nparent = "ground"\nchild = "b"\naxis = [0, 0, 1]\n'


def by_file(said: str) -> Scene:
    return read_text(f"[parameters]\np = {said}\n{BODY}")


def by_python(value: object = None, unit: str = "") -> Scene:
    return scene("s", parameters=[parameter("p", value, unit=unit)], **PARTS)  # type: ignore[arg-type]


RUNS = pytest.mark.runs("cc")
SWEEP = ("sweep", "--until", "0.1", "--measure", "max(phi)", "--over")

DOORS = {  # what the value of p is, with its unit
    "value and unit": lambda x, unit, si: by_file(f'{{ value = "{x}", unit = "{unit}" }}'),
    "text": lambda x, unit, si: by_file(f'"{x} {unit}"'),
    "text beside the unit of SI": lambda x, unit, si: by_file(f'{{ value = "{x} {unit}", unit = "{si}" }}'),
    "python": lambda x, unit, si: by_python(x, unit),
    "python text": lambda x, unit, si: by_python(f"{x} {unit}"),
    "bound": lambda x, unit, si: bind(by_python(1, si), read_bindings(f"p={x} {unit}")),
    "bound where it was free": lambda x, unit, si: bind(by_python(None, unit), {"p": f"{x} {unit}"}),
    "in place of one in the unit": lambda x, unit, si: bind(by_python(7, unit), {"p": f"{x}{unit}"}),
    "written and read again": lambda x, unit, si: read_text(write_text(by_file(f'"{x} {unit}"'), "toml").text),
}


@pytest.mark.mends("30.control.1")
@pytest.mark.parametrize("door", DOORS)
@settings(max_examples=20)
@given(number=st.fractions(-(10**4), 10**4, max_denominator=10**3), unit=st.sampled_from(list(UNITS)))
@example(number=Fraction(500), unit="mm")
@example(number=Fraction(-90), unit="deg")
@example(number=Fraction(0), unit="rpm")
def test_a_value_with_its_unit_is_one_quantity_by_every_door(door: str, number: Fraction, unit: str) -> None:
    factor, turns, si = UNITS[unit]

    (p,) = DOORS[door](number, unit, si).parameters

    assert (p.value, p.unit) == (parse(f"({number})*({factor})*{'pi' if turns else 1}"), si)


@pytest.mark.mends("30.control.1")
@pytest.mark.parametrize(
    ("said", "words"),
    [
        ('{ value = 3, unit = "furlongz" }', "furlongz is no unit"),
        ('{ value = 3, unit = "mmm" }', r"did you mean mm\?"),
        ('{ value = 3, unit = "deg C" }', "zero of its own"),
        ('{ unit = "N/m s" }', "two ways"),
    ],
)
def test_a_unit_that_is_none_is_refused(said: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        by_file(said)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ('{ value = "3 kg", unit = "mm" }', "3 kg.* is in kg, and mm is asked for"),
        ('{ value = "3 Hz", unit = "rad/s" }', r"6\*pi rad/s = 18.8496; or did you mean 3 rad/s\?"),
        ('{ value = "3 furlongz", unit = "m" }', "furlongz is no unit"),
        ('{ value = 3, unit = "mm", tolerance = "1 kg" }', "is in kg, and its parameter is in mm"),
        ('"12 kg + 3 kg"', "a unit stands behind a number alone"),
    ],
)
def test_a_value_of_another_kind_is_refused(said: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        by_file(said)


@pytest.mark.mends("30.control.1")
def test_what_is_computed_is_in_si_and_its_unit_too() -> None:
    with pytest.raises(SceneError, match='what is computed is; write "m"'):
        pendulum(more='[outputs]\nx = { formula = "1000*l*sin(phi)", unit = "mm" }')


@pytest.mark.mends("30.control.1")
def test_a_tolerance_without_a_unit_is_in_that_of_its_parameter() -> None:
    from symdyn.scene.values.entry import Faults
    from symdyn.study.distributions import read_over

    one = pendulum(l='{ value = 500, unit = "mm", tolerance = 5 }')
    (found,) = read_over(one, (), (), Faults(""))

    assert dict(found.arguments) == pytest.approx({"low": 0.495, "high": 0.505})


@pytest.mark.mends("30.control.1")
@pytest.mark.parametrize(
    ("words", "asked"),
    [
        (["linearize", "--start", "phi=0", "--bind", "l=400"], "l is given in mm: write l=400mm or l=400m"),
        (
            ["linearize", "--start", "phi=0", "--over", "l=linspace(400,500,3)"],
            "l is given in mm: write l=400mm or l=400m",
        ),
        pytest.param([*SWEEP, "l=[400]"], "write l=400mm or l=400m", marks=RUNS),
        pytest.param([*SWEEP, "l=tolerance(2)"], "write l=2mm or l=2m", marks=RUNS),
        pytest.param(["simulate", "--until", "0.1", "--forces", "V=3"], "write V=3mV or V=3V", marks=RUNS),
    ],
)
def test_a_shell_asks_what_a_bare_number_is_where_a_letter_is_not_in_si(
    words: list[str], asked: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more = 'force = "0*V"\n[inputs]\nV = { value = 20, unit = "mV" }'
    (tmp_path / "p.toml").write_text(PENDULUM.format(m=1, l='{ value = 500, unit = "mm" }', more=more))

    assert main([words[0], str(tmp_path / "p.toml"), *words[1:]]) == 1
    assert asked in capsys.readouterr().err


def test_python_takes_numbers_of_si_and_text_with_units() -> None:
    one = pendulum(l='{ value = 500, unit = "mm" }')

    known = [bind(one, {"l": said}).parameters[1].value for said in (0.4, Fraction(2, 5), "400 mm", "40cm")]

    assert known == [parse("2/5")] * 4
    at = {"phi": "0"}
    assert symdyn.linearize(one, start=at, values={"l": "400 mm"}).modes[0].frequency == pytest.approx(
        symdyn.linearize(one, start=at, values={"l": 0.4}).modes[0].frequency
    )


WHOLE = """name = "whole"
gravity = [0, "-9810 mm/s^2", 0]

[parameters]
m = { value = 1200, unit = "g", positive = true, tolerance = "5 g" }
l = { value = 500, unit = "mm" }
w = "3 rpm"
f = { unit = "kHz" }

[bodies.bob]
mass = "m"
com = [0, "-20 cm", 0]
inertia = ["20 kg cm^2", "5 kg cm^2", "17 kg cm^2"]
inertia_about = "com"

[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
origin = ["100 mm", 0, 0]
coordinate = "phi"
damping = "3 mN m s/rad"
limits = { lower = "-0.5 turn", upper = "3 rad" }
start = "90 deg"
start_rates = "3 rpm"

[springs.s]
from = { body = "ground", at = [0, "30 cm", 0] }
to = { body = "bob", at = [0, "-1 ft", 0] }
stiffness = "18 kN/m"
free = "3 m"

[inputs.V]
value = 20
unit = "mV"
"""


def test_a_scene_keeps_the_units_that_its_writer_chose() -> None:
    one = read_text(WHOLE)

    assert write_text(one, "toml").text == WHOLE
    assert read_text(write_text(one, "toml").text) == one


def test_every_number_of_a_scene_may_say_its_unit() -> None:
    one = read_text(WHOLE)
    (spring,), (bob,), (hinge,) = one.elements, one.bodies, one.joints

    assert [spell(x) for x in (spring.stiffness[0], spring.free)] == ["18000", "3"]  # type: ignore[attr-defined]
    assert [spell(x) for x in (*one.gravity, *bob.com, *bob.inertia[:3])] == [  # type: ignore[misc]
        *("0", "-9.81", "0", "0", "-0.2", "0"),
        *("0.002", "0.0005", "0.0017"),
    ]
    assert [spell(x) for x in (*hinge.start, *hinge.start_rates, hinge.damping)] == ["pi/2", "0.1*pi", "0.003"]
    assert [spell(x) for x in (hinge.limits.lower, hinge.limits.upper) if x] == ["-pi", "3"]


@pytest.mark.mends("30.control.1")
def test_a_model_for_exchange_starts_in_si() -> None:
    model = model_of(sources_of(pendulum(l='{ value = 500, unit = "mm" }')), "fmi3")
    (found,) = (one for one in model.iter() if one.get("name") == "l")

    assert (found.get("start"), found.get("unit")) == ("0.5", "m")


def test_values_that_stand_alone_in_a_run_may_say_their_units() -> None:
    one = pendulum()

    said = read_start(one, {"phi": "1/12 turn"}, {"phi": "60 rpm"})

    assert (*said.q, *said.u) == pytest.approx((math.pi / 6, 2 * math.pi), rel=1e-15)
    for start, rates, words in (
        ({"phi": "30 mm"}, {}, "30 mm is in mm, and rad is asked for"),
        ({}, {"phi": "3 Hz"}, r"6\*pi rad/s = 18.8496; or did you mean 3 rad/s\?"),
    ):
        with pytest.raises(SimulateError, match=words):
            read_start(one, start, rates)
    with pytest.raises(SimulateError, match="3 N is in N, and N m is asked for"):
        read_forces(one, {"tau1": "3 N"})


@RUNS
@pytest.mark.mends("30.control.1")
def test_a_log_in_a_unit_of_another_kind_is_refused() -> None:
    t = np.linspace(0, 1, 50)

    with pytest.raises(IdentifyError, match="phi is in mm, and rad is asked for"):
        symdyn.identify(pendulum(), {"t": t, "phi": np.sin(9 * t), "tau1": np.cos(9 * t)}, units={"phi": "mm"})


def test_info_says_of_which_values_letters_are_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "p.toml").write_text(PENDULUM.format(m=1, l='"3 m"', more=""))

    assert main(["info", str(tmp_path / "p.toml")]) == 0

    assert "3 m is a number and a unit: m is not the scene's symbol there" in capsys.readouterr().out
    assert pendulum(l='"3 m"').parameters[1].value == parse("3")
    assert pendulum(l='{ value = "3", unit = "m" }') == pendulum(l='"3 m"')


def test_what_was_identified_is_written_in_the_units_of_the_scene() -> None:
    rubbing = '[joints.hinge.friction]\ncoulomb = "20 mN m"\nsmoothing = "1 deg/s"\n\n'
    text = WHOLE.replace('mass = "m"', 'mass = "1200 g"').replace("[inputs.V]", f"{rubbing}[inputs.V]")
    one = read_text(text.replace('{ unit = "kHz" }', "1"))
    names = dict(zip(("fv1", "fc1", "k1"), (0.0045, 0.03, 19000.0), strict=True))

    found = with_parameters(one, names)
    text = write_text(found, "toml").text

    for line in ('damping = "4.5 mN m s/rad"', 'coulomb = "30 mN m"', 'smoothing = "1 deg/s"', 'stiffness = "19 kN/m"'):
        assert line in text, line
    assert read_text(text) == found
    ten = with_parameters(one, {"m1": 1.25})
    assert 'mass = "1250 g"' in write_text(ten, "toml").text
    assert read_text(write_text(ten, "toml").text) == ten
    named = with_parameters(read_text(WHOLE), {"m": 1.3})
    assert 'm = { value = 1300, unit = "g"' in write_text(named, "toml").text


def test_editors_take_every_value_that_a_scene_may_say() -> None:
    import jsonschema

    from symdyn.scene.declaration.declare import schema

    judge = jsonschema.Draft202012Validator(schema())
    for said in (
        "500 mm",
        "3 m²",
        "1/3 kN/m",
        "-90°",
        "5 %",
        "3 µm",
        "8 Ω",
        "3 N·m",
        "+.5 kg*m^2/(s^2 rad)",
        "3 1/s",
        "3 (m/s)^2",
    ):
        assert judge.is_valid(tomllib.loads(f'[parameters]\np = "{said}"\n{BODY}')), said
        assert by_file(f'"{said}"').parameters[0].value is not None


def said_in(text: str) -> list[str]:
    """Return a text with each of its values with units in turn, but those of parameters, in candelas."""
    found = [one for one in re.finditer(r'"-?[0-9./]+ [^"]+"', text) if not text[: one.start()].endswith(" = \n")]
    return [f'{text[: one.start()]}"3 cd"{text[one.end() :]}' for one in found]


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ('mass = "m"', 'mass = { value = 3, unit = "g" }', '"3 g"'),
        ('damping = "3 mN m s/rad"', 'damping = { value = "1/3", unit = "N m s" }', '"1/3 N m s"'),
        ('com = [0, "-20 cm", 0]', 'com = [0, { value = -20, unit = "cm" }, 0]', '"-20 cm"'),
        ('stiffness = "18 kN/m"', "stiffness = { value = 18 }", '"18"'),
        ('damping = "3 mN m s/rad"', 'damping = { value = "2 N m s", unit = "mN m s" }', '"2 N m s"'),
    ],
)
def test_a_value_is_a_table_with_its_unit_wherever_it_may_be_text(old: str, new: str, text: str) -> None:
    assert old in WHOLE
    found = read_text(WHOLE.replace(old, new))
    assert found == read_text(WHOLE.replace(old, new.replace(new[new.index("{") : new.index("}") + 1], text)))
    assert read_text(write_text(found, "toml").text) == found


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ('{ value = 3, unit = "kg" }', "is in kg, and N m s/rad is asked for"),
        ('{ value = 3, unit = "mNms", text = "a" }', 'unknown key .text.; write a number and a unit such as'),
        ('{ value = "2*t1", unit = "mN m s" }', "is a formula of symbols, which is in SI; leave the unit out"),
        ('{ value = "2 kg", unit = "mN m s" }', "is in kg, and mN m s is asked for"),
        ('{ value = { value = 3 } }', 'is no number with its unit; write a number and a unit'),
        ('{ value = 3, unit = 4 }', 'is no number with its unit; write a number and a unit'),
        ('{ value = 3, unit = "mNmz" }', "mNmz"),
        ('{ unit = "N m s" }', "is a table; give a number"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_table_of_a_value_is_said(said: str, told: str) -> None:
    with pytest.raises(SceneError, match=told):
        read_text(WHOLE.replace('damping = "3 mN m s/rad"', f"damping = {said}"))


@pytest.mark.parametrize("said", ['{ value = 300, unit = "mN m" }', '{ value = "3/10" }'])
def test_friction_of_a_joint_is_a_number_as_a_table_too(said: str) -> None:
    def joint(friction: str) -> Scene:
        return read_text(WHOLE.replace('damping = "3 mN m s/rad"', f"friction = {friction}"))

    assert joint(said) == joint("0.3")
    with pytest.raises(SceneError, match=r"unknown key .coulomb."):
        joint("{ value = 3, coulomb = 2 }")
    with pytest.raises(SceneError, match=r'unknown key "valu"; did you mean|unknown key "valu"; known are'):
        joint("{ valu = 3 }")


@pytest.mark.parametrize("k", range(len(said_in(WHOLE))))
def test_no_value_of_a_scene_may_be_of_another_kind(k: int) -> None:
    spoilt = said_in(WHOLE)[k]
    if 'w = "3 cd"' in spoilt:  # which is a parameter of its own
        return

    with pytest.raises(SceneError, match=r"3 cd.* is in cd, and "):
        read_text(spoilt)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('start_rates = "3 rpm"', 'start_rates = "3 Hz"', r"6\*pi rad/s = 18.8496; or did you mean 3 rad/s\?"),
        (
            'stiffness = "18 kN/m"',
            'stiffness = ["18 kN/m", "3 N/m^2", "2 N/m"]',
            r"\[2\] = .2 N/m. is in N/m, ",
        ),
        ('stiffness = "18 kN/m"', 'stiffness = "18 kN m/rad"', "is in kN m/rad, and N/m is asked for"),
        ('start = "90 deg"', 'locked = true\nposition = "3 mm"', "3 mm.* is in mm, and rad is asked for"),
    ],
)
def test_a_value_that_does_not_fit_its_place_is_refused(old: str, new: str, words: str) -> None:
    assert old in WHOLE
    with pytest.raises(SceneError, match=words):
        read_text(WHOLE.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('mass = "m"', 'mass = "3 m"', 'mass = "3 m" is in m, and kg is asked for; for 3 times the symbol write 3*m'),
        ('start = "90 deg"', 'start = "1/3 m^2"', "; for 1/3 times the symbol write 1/3*m**2"),
        ('free = "3 m"', 'free = "3 t"', 'free = "3 t" is in t, and m is asked for'),
        ('mass = "m"', 'mass = "-3 m l"', "l is no unit"),
        *(("[inputs.V]", f"{old}\n[inputs.V]", f"times the symbol write {told}") for old, told in (
            ('[outputs]\ns = "2t^2"', '2*t**2, for the unit formula = "2 t^2", unit = "kg^2"'),
            ('[outputs]\ns = "2 m"', '2*m, for the unit formula = "2 m", unit = "m"'),
            ('[states]\ns = { rate = "2 m" }', '2*m, for the unit rate = "2 m", unit = "m s"'),
            ('[outputs]\ns = { formula = "2t", unit = "N" }', "2*t"),
        )),
    ],
)  # fmt: skip
def test_a_value_in_a_unit_that_is_called_like_a_letter_is_told_the_formula(old: str, new: str, words: str) -> None:
    assert old in WHOLE
    with pytest.raises(SceneError) as raised:
        read_text(WHOLE.replace(old, new))
    assert words in str(raised.value)
    assert ("times" in words) == ("times the symbol" in str(raised.value))


def test_a_unit_without_a_space_is_one_where_no_product_of_that_letter_fits() -> None:
    told = WHOLE.replace('"3 m"', '"3m"').replace('"-20 cm"', '"-2m"').replace("[bodies.bob]", 'r = "2m"\n[bodies.bob]')
    told = told.replace('value = 20\nunit = "mV"', 'value = "2t"').replace('"-9810 mm/s^2"', '"-9.81m/s^2"')
    one = symdyn.scene.with_values(read_text(told), {"l": "2m"})
    assert spell(one.bodies[0].com[1]) == "-2"
    values = {x.name: spell(x.value) for x in (*one.parameters, *one.inputs) if x.value}
    assert [values[name] for name in ("l", "r", "V")] == ["2", "2", "2000"]
    for formula, unit in ("2 m", "m"), ("2 t^2", "kg^2"), ("2m", "m"), ("2 % m", "m"), ("2 m (m/m)", "m"):
        assert read_text(f'{WHOLE}[outputs.s]\nformula = "{formula}"\nunit = "{unit}"\n').outputs
    assert read_text(f'{WHOLE}\n[states.s]\nrate = "2 m"\nunit = "m s"\n').states
    with pytest.raises(SceneError, match=r'joints.hinge: start = "3 m" is in m'):
        read_text(WHOLE.replace('start = "90 deg"', 'start = "3 m"'))


def test_a_force_in_a_unit_that_is_called_like_a_letter_is_told_the_formula() -> None:
    with pytest.raises(SimulateError, match=r"3 m is in m, and N m is asked for; for 3 times the symbol write 3\*m"):
        read_forces(pendulum(), {"tau1": "3 m"})
    with pytest.raises(SimulateError, match=r"3 m is in m, and N m is asked for$"):
        read_forces(by_python(1, "kg"), {"tau1": "3 m"})


@pytest.mark.parametrize("units", ["None", "si", "", "NONE", 0, False, ("none",)])
def test_the_units_of_a_scene_are_none_or_left_alone(units: object, tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text(PENDULUM.format(m=1, l='"3 m"', more=""))

    with pytest.raises(SceneError, match=r"^units = .*: give 'none' or None$"):
        symdyn.read(tmp_path / "p.toml", units=units)  # type: ignore[arg-type]
    assert symdyn.read(tmp_path / "p.toml", units="none").dimensionless
    assert not symdyn.read(tmp_path / "p.toml", units=None).dimensionless


def test_a_command_that_stands_in_a_file_keeps_the_spaces_of_units(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text(PENDULUM.format(m=1, l='{ value = 500, unit = "mm" }', more=""))

    words = ["generate", str(tmp_path / "p.toml"), "-o", str(tmp_path), "--bind", "l = 400 mm, m = 3 N s^2/m"]
    assert main(words) == 0

    assert "--bind 'l=400 mm,m=3 N s^2/m'" in (tmp_path / "p.py").read_text()


def test_values_of_python_are_asked_about_as_those_of_a_shell_are() -> None:
    """After "150 g", 100 was 100 kg without a word, and so was "100"."""
    heavy = pendulum(m='"150 g"', l='"500 mm"')
    asked = r"values: m is given in g: write m=100g or m=100kg, whichever is meant"
    for raw in (100, 100.0, np.float64(100), Fraction(100), "100"):
        with pytest.raises(SceneError, match=asked):
            symdyn.linearize(heavy, start={"phi": 0}, values={"m": raw})
    with pytest.raises(SceneError, match=r"m=0\.1g or m=0\.1kg"):
        symdyn.linearize(heavy, start={"phi": 0}, values={"m": "0.1"})
    for raw in (0.1, 2, "100 g", "0.1 kg", "1e5 mg", 1e-9, 1e9):
        symdyn.linearize(heavy, start={"phi": 0}, values={"m": raw})
    symdyn.linearize(pendulum(), start={"phi": 0}, values={"m": "100", "l": 50})
