"""Dimensions: every term measures what is asked for, and letters without a unit take that of where they stand."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import symdyn
from symdyn.cli import main
from symdyn.errors import SceneError, SimulateError
from symdyn.scene import Scene, bind, body, parameter, parse, prismatic, read, read_text, revolute, scene, write_text

ROOT = Path(__file__).parent.parent

PENDULUM = """
gravity = [0, "-g", 0]
[parameters]
g = { value = 9.81, unit = "m/s^2" }
m = { value = 2, unit = "kg" }
l = { value = 0.5, unit = "m" }
k = { value = 3, unit = "N/m" }
b = { value = 0.1, unit = "N m s/rad" }
w = { value = 4, unit = "rad/s" }
p = 7
[inputs.u]
unit = "V"
[bodies.bob]
mass = "m"
com = [0, "-l", 0]
inertia = ["m*l**2/12", 0, "m*l**2/12"]
inertia_about = "com"
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
coordinate = "phi"
force = "-b*phi_dot - m*g*l*sin(phi - w*t)"
[points.tip]
body = "bob"
at = [0, "-l", 0]
"""


def pendulum(old: str = "", new: str = "", more: str = "") -> Scene:
    assert old in PENDULUM
    return read_text(PENDULUM.replace(old, new, 1) + more, "p.toml")


def output(formula: str, more: str = "") -> str:
    return f'[outputs]\ny = {{ formula = "{formula}"{more} }}\n'


WRONG = [  # changed, and what is said; each of them was read without a word
    ('mass = "m"', 'mass = "m + l"', r"bodies.bob: mass = m \+ l: m is in kg, and l is in m"),
    ('mass = "m"', 'mass = "k"', "bodies.bob: mass = k is in N/m, and kg is asked for"),
    ('com = [0, "-l", 0]', 'com = [0, "-m", 0]', r"com\[1\] = -m is in kg, and m is asked for"),
    ('com = [0, "-l", 0]', 'com = [0, "l**2", 0]', r"com\[1\] = l\*\*2 is in m\^2, and m is asked for"),
    ('"m*l**2/12", 0', '"m*l", 0', r"inertia\[0\] = m\*l is in kg m, and kg m\^2 is asked for"),
    ('"-g", 0', '"-w", 0', r"gravity\[1\] = -w is in 1/s, and m/s\^2 is asked for"),
    ("-b*phi_dot", "-b*phi", r"force = .*: -b\*phi is in N m s, and m\*g\*l\*sin\(phi - w\*t\) is in N m"),
    ("phi - w*t", "phi - t", "phi is a plain number, and t is in s"),
    ("sin(phi - w*t)", "sin(w)", r"w is in 1/s, and sin takes a plain number"),
    ('force = "', 'motion = "w"\nforce = "', r"motion = w is in 1/s, and rad is asked for"),
    ('force = "', 'damping = "k"\nforce = "', r"damping = k is in N/m, and N m s/rad is asked for"),
    ('force = "', 'start = "l"\nforce = "', r"start\[0\] = l is in m, and rad is asked for"),
    ('at = [0, "-l", 0]', 'at = [0, 0, "sqrt(l)"]', r"at.Tz = sqrt\(l\) is in m\^\(1/2\), and m is asked for"),
    ('at = [0, "-l", 0]', 'at = [["Rz", "l"]]', "at.Rz = l is in m, and rad is asked for"),
    ('at = [0, "-l", 0]', 'at = [0, "atan2(m, l)", 0]', "m is in kg, and l is in m"),
]


@pytest.mark.mends("30.control.1")
@pytest.mark.parametrize(("old", "new", "words"), WRONG)
def test_a_term_of_letters_alone_that_measures_something_else_is_refused(old: str, new: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        pendulum(old, new)


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
    one, words = pendulum(), r"phi is a plain number, and phi_dot is in 1/s"
    with pytest.raises(SimulateError, match=words):
        symdyn.simulate(one, until=0.1, stops="phi - phi_dot")
    with pytest.raises(SimulateError, match=words):
        symdyn.linearize(one, at={"phi": 0}, outputs=["phi + phi_dot"])
    with pytest.raises(SimulateError, match=r"kinetic_energy is in N m, and m\*l is in kg m"):
        symdyn.ensemble(one, {}, until=0.1, measures=["max(kinetic_energy - m*l)"])
    with pytest.raises(SimulateError, match=r"max\(...\) is a plain number, and integral\(...\) is in s"):
        symdyn.ensemble(one, {}, until=0.1, measures=["max(phi) - integral(phi)"])
    with pytest.raises(SimulateError, match=r"tau1\*\*2 is in .*, and phi\*\*2 is a plain number"):
        symdyn.collocation(one, until=1.0, intervals=3, cost="tau1**2 + phi**2")


def test_numbers_that_stand_as_factors_may_carry_a_dimension_and_are_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = PENDULUM.replace("-b*phi_dot", "12*u - b*phi_dot - 0.5*l").replace('"-l", 0]\n[p', '"-m/2", 0]\n[p')
    (tmp_path / "p.toml").write_text(text.replace("phi - w*t", "phi - 3*t"))

    assert main(["info", "--units", str(tmp_path / "p.toml")]) == 0

    said = capsys.readouterr().out
    for line in (
        "12 in joints.hinge: force = 12*u - b*phi_dot - l/2 - m*g*l*sin(phi - 3*t) would have to be C",
        "0.5 in joints.hinge: force = 12*u - b*phi_dot - l/2 - m*g*l*sin(phi - 3*t) would have to be N",
        "3 in joints.hinge: force = 12*u - b*phi_dot - l/2 - m*g*l*sin(phi - 3*t) would have to be 1/s",
        "1/12 in",
    ):
        assert (line in said) == (line != "1/12 in"), said


SILENT = [  # a letter without a unit, where it stands, and what it is then
    ('mass = "m"', 'mass = "m"\nshape = { type = "ball", radius = "p" }', "m"),
    ("-b*phi_dot", "-p", "N m"),
    ("-b*phi_dot", "-p*phi_dot", "N m s"),
    ("-b*phi_dot", "p*u", "C"),
    ("-b*phi_dot", "l**2*p*phi", "N/m"),
    ("phi - w*t", "phi - p*t", "1/s"),
    ('force = "', 'damping = "p"\nforce = "', "N m s/rad"),
    ('force = "', 'start = "-p"\nforce = "', "rad"),
    ('force = "', 'armature = "m*p**2"\nforce = "', "m"),
    ("-b*phi_dot", "-2*p", ""),
    ("-b*phi_dot", "-b*phi_dot", ""),
]


@pytest.mark.parametrize(("old", "new", "unit"), SILENT)
def test_a_letter_without_a_unit_takes_that_of_where_it_stands(old: str, new: str, unit: str) -> None:
    from symdyn.scene.units import letter_units

    found = pendulum(old, new)

    assert letter_units(found)["p"] == unit
    assert next(one for one in found.parameters if one.name == "p").unit == ""


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        (
            'damping = "p"',
            'armature = "p"',
            r"p is in N m s by joints.hinge: damping = p|by joints.hinge: armature = p",
        ),
        ('start = "p"', 'damping = "p/m"', "p"),
        ('armature = "p*m"', 'damping = "p*m"', r"is in kg m\^2, and N m s/rad is asked for|N m s"),
    ],
)
def test_where_two_places_disagree_both_are_said(first: str, second: str, words: str) -> None:
    """In SI that is right, and it is told: nothing says that one letter is not two numbers that are equal."""
    from symdyn.scene.units import doubtful, letter_units

    found = pendulum('force = "', f'{first}\n{second}\nforce = "')

    assert letter_units(found)["p"] == ""
    (said,) = doubtful(found)
    assert re.search(words, said)
    assert "p says no unit and stands in places of two dimensions: joints.hinge" in said


def test_what_no_letter_tells_alone_is_told_by_all_equations_together() -> None:
    """Two letters, two products of them: neither place tells one of them, both together do."""
    from symdyn.scene.units import doubtful, letter_units

    text = PENDULUM.replace("p = 7", "p = 7\nr = 2").replace('mass = "m"', 'mass = "p*r"')
    found = read_text(text.replace('com = [0, "-l", 0]', 'com = [0, "p/r", 0]'))
    units = letter_units(found)

    assert (units["p"], units["r"]) == ("kg^(1/2) m^(1/2)", "kg^(1/2)/m^(1/2)")
    (p, r) = doubtful(read_text(text.replace('com = [0, "-l", 0]', 'com = [0, "p*r", 0]')))
    assert all("p*r is in kg, and m is asked for" in one for one in (p, r))


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


@pytest.mark.runs("cc")
def test_units_that_are_told_are_shown_everywhere() -> None:
    """Columns of runs, tables of LaTeX, of lessons, of notebooks and of linear models."""
    from symdyn.notebook.scenes import _tables
    from symdyn.teach import walkthrough

    text = PENDULUM.replace('m = { value = 2, unit = "kg" }', "m = 2").replace('"V"', '""').replace("-b*phi_dot", "u")
    one = read_text(text.replace("phi - w*t", "phi") + output("m*l*phi_dot**2"))

    run = symdyn.simulate(one, "u=0.1", until=0.1)
    assert {c.name: c.unit for c in run.columns if c.name in ("u", "y")} == {"u": "N m", "y": "N"}
    assert symdyn.linearize(one, at={"phi": 0}, outputs=["y"]).outputs.units == ("N",)
    assert any(row[0] == "m" and row[2] == "kg" for table in (_tables(one),) for row in _cells(str(table)))
    page = symdyn.equations(one).latex(document=True)
    assert r"$m$ & parameter & $\mathrm{kg}$" in page
    assert "kg" in str(walkthrough(one))


@pytest.mark.mends("30.lessons.1.5")
@pytest.mark.runs("cc")
def test_the_multiplier_of_a_row_is_a_power_over_the_rate_that_vanishes() -> None:
    from symdyn.simulation.columns import columns

    text = (ROOT / "examples" / "two_link.toml").read_text(encoding="utf-8") + ROWS_OF_RATES
    found = {one.name: one.unit for one in columns(read_text(text), ["multiplier_geared", "multiplier_slides"])}
    page = symdyn.equations(read_text(text)).latex(document=True)

    assert (found["multiplier_geared"], found["multiplier_slides"]) == ("N m", "N")
    assert "of row geared, N m" in page
    assert "of row slides, N." in page


ROWS_OF_RATES = """
[rows.geared]
formula = "q1_dot + q2_dot"
[rows.slides]
formula = "h1*q1_dot"
"""


def _cells(page: str) -> Iterator[list[str]]:
    for row in re.findall(r"<tr>(.*?)</tr>", page, re.S):
        yield re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row, re.S)


DIMENSIONS = {"m": "kg", "l": "m", "k": "N/m", "w": "rad/s", "g": "m/s^2", "phi": "1"}
ROUND = {"bicycle": {"0.9", "-0.9", "-0.7"}, "rolling_disc": {"6"}}
"""Lengths in metres that stand beside letters, and a rate of spin, 6 rad/s."""


@settings(max_examples=60)
@given(powers=st.lists(st.integers(-1, 1), min_size=6, max_size=6), extra=st.sampled_from(list(DIMENSIONS)[:5]))
def test_a_product_of_letters_is_of_the_product_of_their_units(powers: list[int], extra: str) -> None:
    """The unit of an output by hand: right where it is so, refused with one letter more."""
    from symdyn.scene.values.unit import read_unit

    def formula(given: dict[str, int]) -> str:
        return "*".join(f"{name}**{n}" for name, n in given.items() if n) or "phi"

    held = dict(zip(DIMENSIONS, powers, strict=True))
    unit = read_unit("1")
    for name, n in held.items():
        unit = unit * read_unit(DIMENSIONS[name]) ** n
    said = f', unit = "{unit.dimension.text}"'
    assert pendulum(more=output(formula(held), said)).outputs[0].unit == unit.dimension.text
    held[extra] += 1
    with pytest.raises(SceneError, match="is asked for"):
        pendulum(more=output(formula(held), said) if any(held.values()) else output("phi", said))


EXAMPLES = sorted([*ROOT.glob("examples/*.toml"), *ROOT.glob("docs/gallery/*.toml")])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_no_number_of_an_example_has_to_carry_a_dimension_unseen(path: Path) -> None:
    """All letters of our scenes have a unit, and numbers beside them are plain, or are those that are known here."""
    from symdyn.cli.unit_tables import unit_facts

    facts = unit_facts(read(path))

    assert all(one["unit"] for one in facts["letters"]), facts["letters"]
    assert {one["number"] for one in facts["numbers"]} == ROUND.get(path.stem, set()), facts["numbers"]


def leaves(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the way to every number and text of a scene."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    if not isinstance(value, (dict, list)):
        yield at
    for key, one in pairs:
        yield from leaves(one, (*at, key))


NAMES = {"coordinate", "coordinates", "child", "parent", "body"}
"""Keys of names, some of which look like a letter."""


def test_every_key_of_numbers_says_its_dimension() -> None:
    """But the formula of a row, each term of which is alike, in whatever unit."""
    from symdyn.scene.forces import FORCES
    from symdyn.scene.joints import JOINTS
    from symdyn.scene.values.key import SHAPES, Key
    from symdyn.scene.values.shapes import NUMBER, NUMBERS, VECTOR
    from symdyn.scene.values.unit import read_unit

    keys = [(name, key) for name, kind in JOINTS.items() for key in kind.keys]
    keys += [(name, part) for name, kind in FORCES.items() for part in kind.parts if isinstance(part, Key)]
    silent = []
    for name, key in keys:
        shape = SHAPES.get(key.read) if key.shape is None else key.shape
        if key.names is not None and shape in (NUMBER, NUMBERS, VECTOR):
            units = (key.unit,) if isinstance(key.unit, str) else key.unit
            silent += [] if all(units) else [(name, key.name)]
            assert all(read_unit(one).is_coherent for one in units if one)
    assert silent == [("formula", "formula")]


@pytest.mark.parametrize("share", [12, pytest.param(10**6, marks=pytest.mark.slow)])
def test_every_number_of_a_scene_has_a_dimension(share: int) -> None:
    """Each number of the scene that has all words in place of a letter in candelas is refused, or is no number."""
    whole = _everything()
    whole["parameters"] |= {"zz": {"value": 1, "unit": "cd"}}
    unseen = []
    for way, spoilt in _spoilt(whole, share, lambda old: "zz", lambda old: _is_number(old, whole)):
        told = _faults(spoilt)
        if "is in cd" not in told and "depends on zz" not in told:
            unseen.append((way, told[:200] or "is read"))
    assert not [one for one in unseen if not NAMES.intersection(one[0])]


def _everything() -> dict[str, Any]:
    """Return the tables of the scene that has all words."""
    from wide import everything

    return tomllib.loads(write_text(everything(), "toml").text)


def _spoilt(
    whole: dict[str, Any], share: int, new: Callable[[Any], object], right: Callable[[Any], bool]
) -> Iterator[tuple[tuple[Any, ...], str]]:
    """Yield some of the places of values that are right, drawn alike at each time, and the scene with a new one."""
    from fuzz.mutate import toml

    ways = [way for way in leaves(whole) if way[0] != "parameters"]
    for way in Random(2).sample(ways, len(ways)):
        spoilt = json.loads(json.dumps(whole))
        holder: Any = spoilt
        for key in way[:-1]:
            holder = holder[key]
        old = holder[way[-1]]
        if isinstance(old, bool) or not right(old):
            continue
        holder[way[-1]] = new(old)
        yield way, toml(spoilt)
        share -= 1
        if not share:
            return


def _faults(text: str) -> str:
    try:
        read_text(text)
    except SceneError as error:
        return str(error)
    return ""


def _is_number(value: object, whole: dict[str, Any]) -> bool:
    try:
        found = parse(str(value))
    except SceneError:
        return False
    names = {*whole["parameters"], "t", *(f"q{k}" for k in range(99)), "u", "alpha"}
    return all(name.removesuffix("_dot") in names for name in found.symbols)


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


SAID = """
gravity = [0, -9.81, 0]
[parameters]
l = { value = 2, unit = "m" }
[inputs.u]
value = 3
unit = "N m"
[bodies.bob]
mass = 1
com = [0, "-l", 0]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
coordinate = "phi"
force = "u"
[outputs]
y = { formula = "l*sin(phi)", unit = "m" }
"""


@pytest.mark.mends("30.class.ignored")
@pytest.mark.parametrize(
    ("old", "other", "strange"),
    [('"m" }\n[i', '"mm" }\n[i', '"kg" }\n[i'), ('"N m"', '"mN m"', '"V"'), ('"m" }\n\n', '"mm" }\n\n', '"kg" }\n\n')],
    ids=["parameters", "inputs", "outputs"],
)
def test_no_unit_is_read_and_then_ignored(old: str, other: str, strange: str) -> None:
    """Another unit is another scene or a fault, and one of another kind is a fault; each was read without a word."""
    text = f"{SAID}\n"
    assert text.count(old) == 1

    def numbers(said: str) -> object:
        from symdyn.scene.values.value import value_of

        found = read_text(said)
        return [value_of(one.value, {}) for one in (*found.parameters, *found.inputs) if one.value is not None]

    other_text = text.replace(old, other)
    assert "is of numbers that are not in SI" in _faults(other_text) or numbers(other_text) != numbers(text)
    with pytest.raises(SceneError, match="is asked for"):
        read_text(text.replace(old, strange))


@pytest.mark.parametrize("share", [8, pytest.param(10**6, marks=pytest.mark.slow)])
def test_a_unit_is_heard_at_every_number_of_a_scene(share: int) -> None:
    """A hundredth of the unit of each number: the scene of the number over a hundred, and another one than before."""
    whole = _everything()
    for way, text in _spoilt(whole, share, lambda old: "3 cd", lambda old: isinstance(old, (int, float)) and old != 0):
        found = re.search(r'"3 cd" is in cd, and (.*?) is asked for', _faults(text))
        if found is None:
            assert {"axis", "second_axis", "normal"}.intersection(way), way
            continue
        old: Any = whole
        for key in way:
            old = old[key]
        said = read_text(text.replace("3 cd", f"{old} % {found[1]}"))
        assert said == read_text(text.replace("3 cd", f"{old}/100")) != read_text(text.replace("3 cd", f"{old}")), way


BY_ROWS = """
[dh]
convention = "modified"
[[dh.links]]
name = "a"
type = "revolute"
theta = THETA
d = 0
alpha = "90 deg"
mass = 1
rotor = { inertia = INERTIA, gear = GEAR }
[[dh.links]]
name = "b"
type = "prismatic"
a = SHIFT
mass = 2
rotor = { inertia = "2 g m^2", gear = "30 rad/cm" }
[[dh.links]]
name = "c"
type = "prismatic"
mimic = { joint = "joint1", ratio = RATIO, offset = OFFSET }
"""

ROWS = {
    "THETA": ("30 deg", "pi/6", "rad"), "INERTIA": ("3 g m^2", 0.003, "kg m^2"), "GEAR": ("400 %", 4, "1"),
    "SHIFT": ("3 mm", 0.003, "m"), "RATIO": ("3 mm/rad", 0.003, "m/rad"), "OFFSET": ("5 cm", 0.05, "m"),
}  # fmt: skip


@pytest.mark.parametrize("place", ROWS)
def test_what_is_computed_with_when_it_is_read_hears_its_unit_too(place: str) -> None:
    def rows(**said: object) -> str:
        text = BY_ROWS
        for name, (_, plain, _) in ROWS.items():
            text = text.replace(name, json.dumps(said.get(name, plain)))
        return text

    with_unit, _, unit = ROWS[place]
    assert read_text(rows(**{place: with_unit})) == read_text(rows())
    with pytest.raises(SceneError, match=f"3 cd. is in cd, and {re.escape(unit)} is asked for"):
        read_text(rows(**{place: "3 cd"}))
