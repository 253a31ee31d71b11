"""The fuzzer itself: its cases can be made again, most of its scenes are right, and what it found once is mended."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from random import Random

import pytest
from fuzz import grammar
from fuzz.cases import case, read_case
from fuzz.mutate import toml
from fuzz.planted import PLANTS

import symdyn
from symdyn.scene.toml import read_text

ROOT = Path(__file__).parent.parent
CORPUS = sorted((ROOT / "tests" / "fuzz" / "corpus").glob("*.json"))


def test_a_case_is_made_of_seed_and_number_alone():
    for number in range(200):
        first = case("s", number)
        assert case("s", number) == first
        again = read_case(first.text())
        assert (again.argv, dict(again.files)) == (first.argv, dict(first.files))


def test_most_scenes_by_grammar_are_right():
    right = 0
    for seed in range(60):
        try:
            read_text(toml(grammar.scene(Random(seed), 3)))
        except symdyn.SymdynError:
            continue
        right += 1
    assert right > 40


@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant.file)
def test_every_planted_fault_has_its_place(plant):
    text = (ROOT / "symdyn" / plant.file).read_text(encoding="utf-8")
    assert text.count(plant.old) == 1


@pytest.mark.runs
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="workers are limited as Linux does it")
@pytest.mark.parametrize("every", [16, pytest.param(1, marks=pytest.mark.slow)])
def test_what_was_found_once_is_mended(every: int):
    some = CORPUS[::every]
    assert some
    command = [sys.executable, "-m", "tests.fuzz", "--replay", *map(str, some)]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)

    assert ran.returncode == 0, ran.stdout[-4000:] + ran.stderr[-2000:]
    assert ran.stdout.count("nothing wrong") == len(some)
