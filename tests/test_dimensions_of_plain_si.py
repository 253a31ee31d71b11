"""Right scenes in plain SI are read: numbers carry dimensions, and what may be meant otherwise is told, not refused."""

from __future__ import annotations

import json
import time
from itertools import pairwise
from pathlib import Path

import pytest
from dimensional import output, pendulum

import symdyn
from symdyn.cli import main
from symdyn.errors import SceneError, SimulateError
from symdyn.scene import Scene, read_text
from symdyn.scene.declaration.dimensions import SceneUnits

CART = """
[parameters]
c = 0.3
k = { value = 200, unit = "N/m" }
f = { value = 3, unit = "Hz" }
A = { value = 3, unit = "N" }
rho = 2700
r = { value = 0.1, unit = "m" }
h = { value = 0.2, unit = "m" }
[bodies.cart]
mass = "k*c"
[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "s"
"""


def cart(more: str = "", mass: object = 2, tail: str = "") -> Scene:
    return read_text(CART.replace('"k*c"', json.dumps(mass)) + more + "\n" + tail, "cart.toml")


NUMBERS = ["pi*t", "2*pi*t", "pi*t**2", "0.3*sin(pi*t)", "2*(90 deg)*t", "sqrt(2)*t", "sqrt(pi)*t", "exp(1)*t", "-pi*t"]


@pytest.mark.parametrize("formula", [*NUMBERS, "log(3)*t", "atan2(1, 2)*t", "0.1*cos(t/pi) + pi*t", "(pi + 1)*t"])
def test_pi_and_roots_and_functions_of_numbers_may_carry_a_dimension(formula: str) -> None:
    assert cart(f'motion = "{formula}"').joints[0].motion is not None


@pytest.mark.runs("cc")
def test_a_stop_at_pi_times_the_time_is_read() -> None:
    run = symdyn.simulate(cart(), until=1.0, start_rates={"s": 1.0}, stops="0.5*pi*t - s - 1")

    assert run.t[-1] <= 1.0


def test_a_letter_beside_pi_is_told_where_nothing_contradicts() -> None:

    found = cart(mass="pi*rho*r**2*h")

    assert SceneUnits(found).letters["rho"] == "kg/m^3"
    assert not SceneUnits(found).dimensions.carried
    assert SceneUnits(cart(mass="rho*r**3", tail=output("pi*rho"))).letters["rho"] == "kg/m^3"


CARRIER = """
[parameters]
c = 1
m = { value = 1, unit = "kg" }
[bodies.b]
mass = 1
inertia = [1, 1, 1]
inertia_about = "com"
[joints.j]
type = "TYPE"
parent = "ground"
child = "b"
"""
MIXED = {"cylindrical": "axis = [0, 0, 1]\n", "planar": "axis = [0, 0, 1]\n", "free": ""}


@pytest.mark.parametrize("kind", MIXED)
@pytest.mark.parametrize(
    "said",
    ['damping = "0.2 N s/m"', 'damping = "0.2 N m s/rad"', 'damping = "c"\nfriction = "c"', 'friction = "3 N"'],
)
def test_a_joint_that_turns_and_slides_takes_both_units(kind: str, said: str) -> None:

    found = read_text(CARRIER.replace("TYPE", kind) + MIXED[kind] + said)

    assert SceneUnits(found).letters["c"] == ""
    assert not SceneUnits(found).doubtful
    for wrong in ('damping = "3 kg"', 'damping = "m"'):
        with pytest.raises(SceneError, match="in kg, and N m s/rad or N s/m is asked for"):
            read_text(CARRIER.replace("TYPE", kind) + MIXED[kind] + wrong)


def test_a_letter_without_a_unit_in_places_of_two_dimensions_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = CARRIER.replace("TYPE", "cylindrical") + 'axis = [0, 0, 1]\nforces = ["-c*q1_dot", "-c*q2_dot"]\n'
    (tmp_path / "c.toml").write_text(text)

    for words in (["info"], ["info", "--units"]):
        assert main([*words, str(tmp_path / "c.toml")]) == 0
        said = " ".join(capsys.readouterr().out.split())
        assert "c has no unit and is used with two dimensions" in said
        assert "N m s by" in said
        assert "N is asked for" in said
    with pytest.raises(SceneError, match="is asked for"):
        read_text(text.replace("c = 1", 'c = { value = 1, unit = "N s/m" }'))


@pytest.mark.parametrize("start", ['"f"', '"-f"'])
def test_cycles_a_second_where_radians_are_asked_for_are_refused_with_both_readings(start: str) -> None:
    with pytest.raises(SceneError, match=r"in cycles, and rad/s .* 6\*pi rad/s = 18.8496; or did you mean 3 rad/s"):
        read_text(
            CARRIER.replace("TYPE", "revolute").replace("m =", 'f = { value = 3, unit = "Hz" }\nm =')
            + f"axis = [0, 0, 1]\nstart_rates = {start}\n"
        )


def test_a_sine_of_cycles_is_told_where_no_factor_makes_them_radians() -> None:

    (said,) = SceneUnits(cart('force = "A*sin(f*t)"')).doubtful
    assert "joints.slide: force = A*sin(f*t)" in said
    assert "f in cycles a second" in said
    assert not SceneUnits(cart('force = "A*sin(2*pi*f*t)"')).doubtful
    assert not SceneUnits(cart('force = "A*sin(k*s/A)"')).doubtful


def test_powers_have_the_unit_of_their_base_to_the_exponent() -> None:
    with pytest.raises(SceneError, match=r"force = -k\*s\*\*1.5 is in kg m\^\(3/2\)/s\^2, and N is asked for"):
        cart('force = "-k*s**1.5"')
    with pytest.raises(SceneError, match=r"s is in m, and the power \*\*A takes a plain number"):
        cart('force = "-k*s**A"')
    assert cart('force = "-A*(s/r)**1.3 + A*if(s > r, max(s, r)/r, 1)"').joints[0].forces
    assert cart('force = "-A*exp((13/10)*log(s/r)) - c*s*sqrt(s)"').joints[0].forces


def test_without_dimensions_letters_have_no_unit_but_what_they_say(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from symdyn.teach import walkthrough

    text = 'units = "none"\n' + CARRIER.replace("TYPE", "cylindrical") + "axis = [0, 0, 1]\n"
    (tmp_path / "n.toml").write_text(text)

    assert main(["info", "--units", "--json", str(tmp_path / "n.toml")]) == 0
    told = json.loads(capsys.readouterr().out)["result"]["letters"]
    assert {one["name"]: one["unit"] for one in told if one["unit"]} == {"m": "kg"}
    page = str(walkthrough(read_text(text.replace(', unit = "kg"', ""))))
    assert "m/s" not in page
    assert symdyn.equations(read_text(text)).latex(document=True).count(r"\mathrm{m}") == 0


@pytest.mark.long(0)
def test_letters_in_a_long_chain_are_told_in_little_time() -> None:
    """Two thousand letters took 22 s, four times those of half as many."""

    n = 2000
    names = [f"p{k}" for k in range(n)]
    outputs = "".join(f'o{k} = {{ formula = "{a} + {b}" }}\n' for k, (a, b) in enumerate(pairwise(names)))
    text = CART.replace('"k*c"', "2").replace("c = 0.3", "c = 0.3\n" + "".join(f"{name} = 1\n" for name in names))
    found = read_text(f'{text}force = "{names[-1]}"\n[outputs]\n{outputs}')
    start = time.process_time()

    units = SceneUnits(found).letters

    assert {units[name] for name in names} == {"N"}
    assert time.process_time() - start < 2.0


@pytest.mark.runs("cc")
def test_messages_name_what_is_there() -> None:
    with pytest.raises(SimulateError, match=r'units = "none" at the top of the scene'):
        symdyn.simulate(pendulum(), until=0.1, stops="phi - phi_dot")
    with pytest.raises(SimulateError, match=r"max\(phi\) is a plain number, and max\(phi_dot\) is in rad/s"):
        symdyn.ensemble(pendulum(), forces={}, until=0.1, measures=["max(phi) - max(phi_dot)"])


def test_long_exponents_are_rounded() -> None:
    from fractions import Fraction

    from symdyn.scene.values.dimension import LENGTH

    assert (LENGTH ** Fraction(5, 2)).text == "m^(5/2)"
    assert (LENGTH ** Fraction(1234567, 1000000)).text == "m^(1.235)"


@pytest.mark.parametrize(
    ("formula", "unit"),
    [("m*(l*phi_dot)**2/2", "N m"), ("2*m*g", "N"), ("pi*l**2", "m^2"), ("12*u", "")],
)
def test_halves_and_circles_keep_the_unit_of_an_output(formula: str, unit: str) -> None:

    assert SceneUnits(pendulum(more=output(formula))).outputs["y"] == unit
