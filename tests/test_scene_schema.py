"""The JSON Schema of scenes judges as the reader does, as far as one table tells."""

from __future__ import annotations

import copy
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest
from fuzz import grammar
from fuzz.mutate import toml

from symdyn.errors import SceneError
from symdyn.scene import read_text
from symdyn.scene.declaration.declare import schema

jsonschema = pytest.importorskip("jsonschema")

ROOT = Path(__file__).parent.parent
SCENES = sorted([*ROOT.glob("examples/*.toml"), *ROOT.glob("tests/data/*.toml"), *ROOT.glob("docs/notebooks/*.toml")])

READER_ALONE = {
    "names that are declared nowhere, or twice": r"is not a (body|joint|point|coordinate|parameter)|undefined symbol"
    r"|already the name|neither a body nor a point|no joint connects|no joint leads|is not known here",
    "formulas that no letter tells from good ones": r"is not a usable formula|has no value|divides by zero",
    "units that are none, or of another kind": r"is not a usable value|unit = |is asked for",
    "what a number must be": r"is not positive|is not physically consistent|is negative|give one above zero|of no rod"
    r"|zero length|parallel",
    "words that take other words' values": r"may hold numbers and pi only|depends? on|uses ",
    "LaTeX": r"latex = ",
    "the tree as a whole": r"nothing moves|closes? |cannot be locked|carries|one body|on one body|by a joint",
    "joints that a joint or element looks at": r"has several coordinates|coordinates; name one|does not move|follow",
}
"""What the schema does not see, and how the reader tells it."""


@pytest.fixture(scope="module")
def judge():
    found = schema()
    jsonschema.Draft202012Validator.check_schema(found)
    return jsonschema.Draft202012Validator(found)


def faults(text: str) -> tuple[str, ...]:
    try:
        read_text(text)
    except SceneError as error:
        return error.faults
    return ()


@pytest.mark.wide(2)
@pytest.mark.long(0)
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_every_scene_of_ours_is_valid(path, judge):
    told = [error.message for error in judge.iter_errors(tomllib.loads(path.read_text(encoding="utf-8")))]

    assert not told


WRONG = (True, "2^3", [], {"strange": 1}, 7, [1, 2], "", -1.5)


def places(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the way to every table and every value of a scene."""
    if isinstance(value, dict):
        yield at
        for key, one in value.items():
            yield from places(one, (*at, key))
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for k, one in enumerate(value):
            yield from places(one, (*at, k))
    else:
        yield at


def spoilt(scene: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield scenes with one change each: a value of another kind, a key that is gone, misspelled, or too much."""
    for way in places(scene):
        changes = [lambda holder, key, one=one: holder.__setitem__(key, one) for one in WRONG]
        changes.append(lambda holder, key: holder.pop(key))
        changes.append(lambda holder, key: holder.__setitem__(f"{key}x", holder.pop(key)))
        for change in changes if way else ():
            made = copy.deepcopy(scene)
            holder: Any = made
            for key in way[:-1]:
                holder = holder[key]
            if isinstance(holder, dict):
                change(holder, way[-1])
                yield made


FAULTY = ["tests/data/every_kind", "tests/data/struts", "examples/scara", "examples/rolling_disc"]


@pytest.mark.wide("tests/data/every_kind", "examples/rolling_disc")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", FAULTY)
def test_faulty_scenes_are_judged_as_the_reader_judges_them(name, judge):
    """Fifty of each; what the schema alone refuses is none, and what the reader alone refuses is listed above."""
    scene = tomllib.loads((ROOT / f"{name}.toml").read_text(encoding="utf-8"))
    made = list(spoilt(scene))
    alike, unseen, strict = 0, [], []
    for one in Random(name).sample(made, min(len(made), 90)):
        told, good = faults(toml(one)), judge.is_valid(one)
        if told and not good:
            alike += 1
        elif told:
            unseen += [line for line in told if not any(re.search(x, line) for x in READER_ALONE.values())]
        elif not good:
            strict.append([error.message for error in judge.iter_errors(one)])

    assert not strict
    assert not unseen
    assert alike >= 50


@pytest.mark.long
def test_what_the_reader_takes_the_schema_takes(judge):
    """Scenes by grammar, most of them right."""
    taken = 0
    for seed in range(60):
        text = toml(grammar.scene(Random(f"schema {seed}"), 3))
        if not faults(text):
            taken += 1
            assert judge.is_valid(tomllib.loads(text)), text
    assert taken > 40


PENDULUM = """
[bodies.bob]
mass = 1
com = [1, 0, 0]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
"""


@pytest.mark.parametrize(
    ("more", "right"),
    [
        ("axis = [0, 1, 0]", True),
        ("axis = [0, 1]", False),
        ("pitch = 1", False),
        ("orientation = 'zyx'", False),
        ("coordinates = ['a', 'b']", False),
        ("coordinate = ''", False),
        ("coordinate = 'lambda'", False),
        ("coordinate = 'a_dot'", False),
        ("drive = false", True),
        ("drive = 3", False),
        ("drive = ''", False),
        ("drives = ['']", False),
        ("[[loop]]\ntype = 'fixed'\nparent = 'ground'\nchild = 'bob'\ndrive = false", True),
        ("[[loop]]\ntype = 'fixed'\nparent = 'ground'\nchild = 'bob'\ndrive = 'F'", False),
        ("drives = ['a']\ndrive = 'a'", False),
        ("limits = { lower = -1, uper = 1 }", False),
        ("mimic = { ratio = 2 }", False),
        ("position = 1", False),
        ("position = 1\nlocked = false", False),
        ("friction = { coulomb = 1, smoothing = 0.1 }", True),
        ("friction = { colomb = 1 }", False),
        ("origin = [['Rz', 1], ['Tq', 1]]", False),
        ("origin = [['Rz', '90 deg']]", True),
        ("[inputs.u]\nunit = 'V'\nvalue = 2", True),
        ("[inputs.u]\npositive = true", False),
        ("[outputs.speed]\nformula = 'q1_dot'", True),
        ("[outputs.speed]\nunit = 'm'", False),
        ("[points.tip]\nat = [1, 0, 0]", False),
        ("[springs.s]\njoint = 'hinge'\nstiffness = [1, 2]", True),
        ("[springs.s]\njoint = 'hinge'\nfrom = 'bob'\nto = 'ground'\nstiffness = 1", False),
        ("[springs.s]\njoint = 'hinge'", False),
        ("[loads.w]\nbody = 'bob'\nforce = [0, 0, '3*t']\nframe = 'sky'", False),
        ("[constraints.r]\ntype = 'rolling'\nbody = 'bob'", False),
        ("[constraints.r]\nformula = 'q1_dot'\nradius = 1", False),
        ("[bodies.bob.more]", False),
        ("[parameters]\nm = 1\nn = '1/3'", True),
        ("[parameters]\nsin = 1", False),
        ("[parameters.m]\nvalue = [1]", False),
    ],
)
def test_one_word_is_judged_alike(more, right, judge):
    text = PENDULUM + more
    seen = re.search("|".join(READER_ALONE.values()), "\n".join(faults(text)))

    assert judge.is_valid(tomllib.loads(text)) == right
    assert (not faults(text)) == right or seen


FOLLOWER = """
[bodies.pinion]
mass = 1
[joints.mesh]
type = "revolute"
parent = "ground"
child = "pinion"
mimic = { joint = "hinge" }
"""


@pytest.mark.parametrize(("more", "right"), [("drive = false", True), ("drive = 'M'", False), ("start = 1", False)])
def test_what_follows_another_joint_may_say_that_nothing_drives_it(more, right, judge):
    text = PENDULUM + FOLLOWER + more

    assert judge.is_valid(tomllib.loads(text)) == (not faults(text)) == right


def test_a_word_of_two_tables_is_told_as_each_means_it():
    found = schema()["properties"]
    row, output = (found[section]["additionalProperties"] for section in ("constraints", "outputs"))
    formulas = row["properties"]["formula"], output["anyOf"][0]["properties"]["formula"]

    assert "velocities" in formulas[0]["description"]
    assert "reactions" not in formulas[0]["description"]
    assert "reactions" in formulas[1]["description"]


def test_an_editor_tells_what_every_word_means():
    found = schema()["properties"]
    tables = {name: one["additionalProperties"] for name, one in found.items() if one.get("additionalProperties")}
    tables = {name: one.get("anyOf", [one])[0] for name, one in tables.items() if isinstance(one, dict)}
    tables |= {"loop": found["loop"]["items"], "link": found["dh"]["properties"]["links"]["items"], "dh": found["dh"]}
    words = [(name, word, one) for name, table in tables.items() for word, one in table["properties"].items()]

    assert len(words) > 100
    assert not [(name, word) for name, word, one in words if not one.get("description") and word != "type"]


@pytest.mark.runs
def test_a_row_that_is_new_is_in_the_schema():
    """Of a kind of element and of a type of joint that files outside declare."""
    code = "import json; from symdyn.scene.declaration.declare import schema; before = json.dumps(schema())\n"
    code += "import gas_spring, rack_and_pinion; after = json.dumps(schema())\n"
    code += "print([word in text for word in ('charge', 'rack_and_pinion') for text in (before, after)])"
    folder = ROOT / "tests" / "recipes"
    run = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False)

    assert run.stdout == "[False, True, False, True]\n", run.stderr


@pytest.mark.runs
def test_the_command_prints_it(judge):
    words = [sys.executable, "-m", "symdyn", "info", "--schema"]
    plain, told, more = (
        subprocess.run([*words, *one], capture_output=True, text=True, check=False)
        for one in ((), ("--json",), ("a.toml",))
    )

    assert json.loads(plain.stdout) == json.loads(told.stdout)["result"] == judge.schema
    assert more.returncode == 2
    assert more.stderr.splitlines()[-2].endswith("--schema is that of all scenes; leave a.toml out")
