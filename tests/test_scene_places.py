"""Faults of TOML scenes say their line: of misspelt keys and values of all examples, and of texts that are no TOML."""

import random
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from symdyn.errors import Place, SceneError
from symdyn.scene import read, read_text, tables_of
from symdyn.scene.places import placing

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.toml"))
KEY = re.compile(r"(?m)^[a-z_]+(?= *=)")
VALUE = re.compile(r"(?m)(?<=^mass = )[^\n#{]+|(?<=^axis = )\[[^]\n]*\]")


def faults(text: str) -> list[tuple[str, Place]]:
    """Return the faults of a text and their places; of a text without one, none."""
    try:
        read_text(text, "arm.toml")
    except SceneError as error:
        found = list(zip(error.faults, error.places, strict=True))
    else:
        found = []
    assert all(fault.startswith(f"arm.toml:{place.line}: ") for fault, place in found), found
    return found


def under(text: str, place: Place) -> str:
    return text.splitlines()[place.line - 1][place.column - 1 :][: place.length]


def test_every_fault_of_mutated_examples_has_its_place() -> None:
    """A key that is misspelt is underlined where it stands; what a value is refused for, in its line."""
    keys = values = 0
    for path in EXAMPLES:
        text, draw = path.read_text(encoding="utf-8"), random.Random(path.stem)
        for one in draw.sample(every := [*KEY.finditer(text)], min(4, len(every))):
            wrong = f"{text[: one.start()]}zz{text[one.start() :]}"
            for fault, place in faults(wrong):
                if f'unknown key "zz{one[0]}"' in fault:
                    assert under(wrong, place) == f"zz{one[0]}", fault
                    keys += 1
        for one in draw.sample(every := [*VALUE.finditer(text)], min(2, len(every))):
            wrong = f'{text[: one.start()]}"?"{text[one.end() :]}'
            (fault, place), *_ = faults(wrong)
            assert place.line == wrong.count("\n", 0, one.start()) + 1, fault
            values += 1
    assert keys > 40
    assert values > 30


def test_every_path_of_every_example_is_found() -> None:
    def walk(value: Any, told: str) -> None:
        inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        for name, one in inner:
            path = f"{told}[{name}]" if isinstance(name, int) else f"{told}.{name}".lstrip(".")
            with pytest.raises(SceneError) as caught, placing(text, "a.toml"):
                raise SceneError(f"a.toml: {path}: is wrong")
            place = caught.value.places[0]
            if isinstance(name, str):
                assert under(text, place).strip("\"'") == name, path
            walk(one, path)

    for path in EXAMPLES[::4]:
        text = path.read_text(encoding="utf-8")
        walk(tomllib.loads(text), "")


@pytest.mark.parametrize(
    ("text", "line", "column", "told"),
    [
        ("name = 'a'\nx = = 3", 2, 5, "column 5: is not valid TOML: Invalid value"),
        ("name = 'a'\n\nx = [1,\n\n", 3, 8, "end of document: is not valid TOML: Invalid value"),
        ("a = 1\n" + ".".join("a" * 500) + " = 1", 2, 1, "is a key of 500 parts"),
        ("a = " + "[" * 5000, 1, 1, "it nests too deep"),
        ("name = 'a'", 1, 1, "nothing moves"),
    ],
)
def test_what_is_no_scene_has_a_place_too(text: str, line: int, column: int, told: str) -> None:
    fault, place = faults(text)[0]
    assert (place.line, place.column) == (line, column)
    assert told in fault


def test_a_place_in_a_list_of_tables_and_in_a_line_of_several() -> None:
    text = """[bodies.bar]
particles = [{ mass = 1, at = [0, 0, 1] }, { mas = 1, at = [0, 0, 2] }]
[joints.pin]
type = "revolute"
parent = "ground"
child = "bar"
axis = [0, 0, 0]
[[loop]]
type = "revolute"
parent = "ground"
child = "barr"
"""
    found = {fault.split(": ", 1)[1]: (place.line, under(text, place)) for fault, place in faults(text)}
    where = {told.split(" = ")[0]: place for told, place in found.items()}
    assert where["joints.pin: axis"] == (7, "axis")
    assert where["loop.loop1: child"] == (11, "child")
    assert next(place for told, place in found.items() if "particles[1]: unknown" in told) == (2, "mas")


def test_a_negative_mass_is_told_at_its_own_key() -> None:
    text = """[bodies.bar]
mass = -3
particles = [
    { mass = 1, at = [0, 0, 1] },
    { at = [0, 0, 2], mass = -2 },
]
[joints.pin]
type = "revolute"
parent = "ground"
child = "bar"
"""
    (whole, at), (part, there) = faults(text)
    assert "bodies.bar: mass = -3 is negative" in whole
    assert "bodies.bar: particles[1]: mass = -2 is negative" in part
    assert [(one.line, under(text, one)) for one in (at, there)] == [(2, "mass"), (5, "mass")]


def test_bytes_that_are_no_text_have_their_line(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_bytes(b"name = 'a'\ntext = '\xff'\n")
    with pytest.raises(SceneError, match=r"arm\.toml:2: byte 19 is not UTF-8") as caught:
        read(path)
    assert caught.value.places == (Place(2, 9),)


def test_other_files_of_toml_have_places_of_what_is_no_toml() -> None:
    with pytest.raises(SceneError, match=r"^forces\.toml:2: column 5: "):
        tables_of("a = 1\nb = = 2", "forces.toml")


def test_an_error_keeps_its_places_on_its_way_to_another_process() -> None:
    import pickle

    with pytest.raises(SceneError) as caught:
        read_text("x = 1")
    assert pickle.loads(pickle.dumps(caught.value)).places == caught.value.places
