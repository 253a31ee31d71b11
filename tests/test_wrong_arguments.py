"""No argument of a door, or of a method of what doors return, ends in a traceback from inside, whatever is given.

A hundred wrong values (`wrong_values.py`) for each of some three hundred arguments: each is taken, or refused in words
that say which argument it is about.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from called_wrongly import DOORS, INNER, NOUNS, Called, T, cart, every_argument, fault, noun
from wrong_values import WRONG

import symdyn
from symdyn.errors import SceneError
from symdyn.scene import Quantity, parse
from symdyn.simulation.trajectory import Trajectory

SHARE = 67
"""Of so many pairs of an argument and a value one is tried; prime to the number of values: each has its turn."""


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let what is written by the way be written to a folder of its own."""
    monkeypatch.chdir(tmp_path)


def faults_of(pairs: list[tuple[Called, str]]) -> list[str]:
    found = [(called, wrong, fault(called, wrong)) for called, wrong in pairs]
    return [f"{called}: {wrong}: {told}" for called, wrong, told in found if told]


def test_every_door_and_every_noun_is_called() -> None:
    assert set(DOORS) == {*symdyn.__all__, *INNER}
    assert len(WRONG) >= 100
    arguments = every_argument()
    assert len(arguments) > 250
    assert {one.name.partition(".")[0] for one in arguments if "." in one.name} <= {kind.__name__ for kind in NOUNS}


@pytest.mark.long(0)
@pytest.mark.runs("cc")
@pytest.mark.mends("30.attacks.8")
def test_wrong_values_of_any_argument_are_taken_or_refused_in_words() -> None:
    every = [(called, wrong) for called in every_argument() for wrong in WRONG]
    assert faults_of(every[::SHARE]) == []


@pytest.mark.mends("30.attacks.8")
def test_the_reader_of_formulas_takes_text_or_says_what_it_was_given() -> None:
    for wrong, make in WRONG.items():
        with contextlib.suppress(SceneError):
            assert isinstance(parse(make()), Quantity), wrong


@pytest.mark.runs("cc")
@pytest.mark.mends("30.attacks.8")
@pytest.mark.parametrize(
    ("file", "way_out"),
    [
        ("\ud800", "characters that UTF-8 has"),
        ("\ud800/run.csv", "characters that UTF-8 has"),
        ("a" * 300 + ".csv", "a shorter name"),
        ("there", "another name"),
    ],
)
def test_a_file_that_cannot_be_is_told_with_a_way_out_that_is_one(file: str, way_out: str, tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    with pytest.raises(symdyn.SymdynError, match=f"give .*{way_out}$"):
        noun(Trajectory).to_csv(file)


@pytest.mark.runs("cc")
@pytest.mark.mends("30.attacks.8")
def test_what_is_walked_but_once_and_flags_of_numpy_are_taken() -> None:
    targets: Any = iter(["numpy"])
    truths: list[Any] = [np.array(False), np.array(True)]

    assert symdyn.certify(cart(), ["mass_matrix"], targets=targets).passed
    once, again = (symdyn.film(cart(), T, [[0, 0], [0, 0.1]], f"{truth}.svg", loop=truth) for truth in truths)
    assert "freeze" in once.read_text()
    assert "freeze" not in again.read_text()


@pytest.mark.mends("30.attacks.8")
def test_records_are_no_labels() -> None:
    records = np.zeros(2, dtype=[("name", "U8"), ("of", float)])
    for wrong in (records, records[0], records.view(np.recarray)):
        with pytest.raises(symdyn.SymdynError, match=r"labels = .*: give a list of texts"):
            symdyn.picture(symdyn.example("pendulum"), labels=wrong)


@pytest.mark.slow
@pytest.mark.runs("cc")
@pytest.mark.parametrize("called", every_argument(), ids=str)
def test_every_wrong_value_of_an_argument_is_taken_or_refused_in_words(called: Called) -> None:
    assert faults_of([(called, wrong) for wrong in WRONG]) == []
