"""Laws of every reader: what a target writes is proved, and a constant that is a unit off is found."""

from __future__ import annotations

import re
from dataclasses import replace
from math import nextafter
from pathlib import Path

import pytest
from formulas import every_op, one_in_another, spoken

import symdyn
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import TARGETS, emit
from symdyn.emit.code.spelling import SINGLE
from symdyn.program import Program, lower, prepare as prepare_program
from symdyn.scene import read_text
from symdyn.verify.building import files_of
from symdyn.verify.written import READERS, Printed, Written, languages, printed, prove_texts

CASES = [(name, option) for name in READERS for option in ("", *TARGETS[name].options)]
SCENES = ("two_link", "four_bar", "puma560")
EXAMPLES = Path(__file__).parent.parent / "examples"

pytestmark = pytest.mark.parametrize(("name", "option"), CASES)


@pytest.fixture(scope="module")
def programs() -> dict[str, Program]:
    """Return programs to write: three scenes as they are, one prepared, one at rest, one that is led over time."""
    found = {}
    for scene in SCENES:
        found[scene] = lower(symdyn.dynamics.derive(symdyn.example(scene)))
    found["prepared"] = prepare_program(found["two_link"])
    found["static"] = lower(symdyn.dynamics.derive(symdyn.example("two_link")).at_rest())
    led = (EXAMPLES / "cart_pole.toml").read_text(encoding="utf-8").replace('drive = "F"', 'motion = "l*sin(5*t)"')
    found["led"] = lower(symdyn.dynamics.derive(read_text(led), ["forward_dynamics", "drive_forces"]))
    return found


def proved(numbers: Printed, name: str, option: str) -> tuple[Written, ...]:
    files = files_of(emit(numbers.program, name, numbers.real, option=option))
    return prove_texts(numbers, files, languages(name, option))


@pytest.mark.long
@pytest.mark.wide(7)
@pytest.mark.parametrize("which", [*SCENES, "prepared", "static", "led"])
def test_what_is_written_is_proved(programs: dict[str, Program], name: str, option: str, which: str) -> None:
    for real in {*TARGETS[name].reals} & {*SINGLE}:  # of double-doubles the text is not read
        found = proved(printed(programs[which], real), name, option)

        assert {one.verdict for one in found} <= {"proved", ""}, found
        assert any(one.functions for one in found)


@pytest.mark.parametrize("equations", [every_op(), one_in_another()], ids=["alone", "inside"])
def test_every_operation_is_read(name: str, option: str, equations: Equations) -> None:
    program = lower(spoken(name, equations=equations))
    for real in {*TARGETS[name].reals} & {*SINGLE}:  # of double-doubles the text is not read
        found = proved(printed(program, real), name, option)

        assert {one.verdict for one in found} <= {"proved", ""}, found
        assert any(one.functions for one in found)


@pytest.mark.long
@pytest.mark.wide(5)
def test_a_constant_that_is_one_unit_off_is_found(programs: dict[str, Program], name: str, option: str) -> None:
    numbers = printed(programs["puma560"], "double" if "double" in TARGETS[name].reals else TARGETS[name].reals[0])
    files = files_of(emit(numbers.program, name, numbers.real, option=option))
    fresh = dict(files.contents)
    arithmetic = {one.file for one in prove_texts(numbers, files, languages(name, option)) if one.functions}
    for file in arithmetic:
        text = str(fresh[file])
        digits = re.findall(r"(?<![\w.])\d\.\d{4,}(?![\w.])", text)[-1]
        there = text.rindex(digits)
        changed = text[:there] + repr(nextafter(float(digits), 99.0)) + text[there + len(digits) :]
        found = prove_texts(numbers, replace(files, contents={**fresh, file: changed}), languages(name, option), fresh)

        assert [one.file for one in found if not one.passed] == [file]


def test_a_function_that_is_not_there_is_missed(programs: dict[str, Program], name: str, option: str) -> None:
    numbers = printed(programs["two_link"], TARGETS[name].reals[0])
    files = files_of(emit(numbers.program, name, numbers.real, option=option))
    empty = dict.fromkeys(files.contents, "")

    assert not all(one.passed for one in prove_texts(numbers, replace(files, contents=empty), languages(name, option)))


@pytest.mark.wide(3)
@pytest.mark.parametrize(
    ("right", "told"),
    [
        ("p_m9 {} p_h2", "has no value yet"),
        ("p_m2 {} other(p_h2)", "is no function that is read here"),
        ('p_m2 {} "p_h2"', "is no expression that is read here"),
    ],
)
def test_what_has_no_meaning_is_told_alike(
    programs: dict[str, Program], name: str, option: str, right: str, told: str
) -> None:
    numbers = printed(programs["two_link"], TARGETS[name].reals[0])
    files = files_of(emit(numbers.program, name, numbers.real, option=option))
    texts = {file: str(contents) for file, contents in files.contents.items()}
    products = {file: re.search(r"(?<== )p_m2 (\.?\*) p_h2(?=[;\n])", text) for file, text in texts.items()}
    where = []
    for file, product in products.items():
        if product is not None:
            text = texts[file][: product.start()] + right.format(product[1]) + texts[file][product.end() :]
            changed = replace(files, contents={**files.contents, file: text})
            found = prove_texts(numbers, changed, languages(name, option), files.contents)
            where += [one.where for one in found if not one.passed]

    assert where
    assert all(told in one for one in where)
