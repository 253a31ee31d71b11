"""Every number of a scene has a dimension, and hears the unit that is said of it."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Iterator
from random import Random
from typing import Any

import pytest

from symdyn.errors import SceneError
from symdyn.scene import parse, read_text, write_text
from symdyn.scene.values.unit import Unit


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
    from symdyn.scene.values.shape import NUMBER, NUMBERS, VECTOR

    keys = [(name, key) for name, kind in JOINTS.items() for key in kind.keys]
    keys += [(name, part) for name, kind in FORCES.items() for part in kind.parts if isinstance(part, Key)]
    silent = []
    for name, key in keys:
        shape = SHAPES.get(key.read) if key.shape is None else key.shape
        if key.names is not None and shape in (NUMBER, NUMBERS, VECTOR):
            units = (key.unit,) if isinstance(key.unit, str) else key.unit
            silent += [] if all(units) else [(name, key.name)]
            assert all(Unit.read(one).is_coherent for one in units if one)
    assert silent == [("formula", "formula"), *((kind, "active") for kind in ("point", "ball", "wheel", "gap"))]


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

        found = read_text(said)
        return [one.value.at({}) for one in (*found.parameters, *found.inputs) if one.value is not None]

    other_text = text.replace(old, other)
    assert "is of numbers that are not in SI" in _faults(other_text) or numbers(other_text) != numbers(text)
    with pytest.raises(SceneError, match="is asked for"):
        read_text(text.replace(old, strange))


@pytest.mark.long(0)
@pytest.mark.parametrize("share", [8, pytest.param(10**6, marks=pytest.mark.slow)])
def test_a_unit_is_heard_at_every_number_of_a_scene(share: int) -> None:
    """A hundredth of the unit of each number: the scene of the number over a hundred, and another one than before."""
    whole = _everything()
    whole["contacts"]["tyre"]["static"] = 50  # a hundredth of it still holds as much as what slips
    for way, text in _spoilt(whole, share, lambda old: "3 cd", lambda old: isinstance(old, (int, float)) and old != 0):
        found = re.search(r'"3 cd" is in cd, and (.*?) is asked for', _faults(text))
        if found is None:
            assert {"axis", "second_axis", "normal"}.intersection(way), way
            continue
        old: Any = whole
        for key in way:
            old = old[key]
        said = read_text(text.replace("3 cd", f"{old} % {found[1]}"))
        plain = read_text(text.replace("3 cd", f"{old}"))
        assert said == read_text(text.replace("3 cd", f"{old}/100")) != plain, way
        assert read_text(text.replace('"3 cd"', f'{{ value = {old}, unit = "{found[1]}" }}')) == plain, way


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
