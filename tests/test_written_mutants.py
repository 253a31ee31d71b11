"""Faults planted into written files are caught, each of them, or leave the same program behind."""

from __future__ import annotations

import pytest
from written_mutants import score

import symdyn
from symdyn.emit import TARGETS
from symdyn.verify.written import READERS

SAMPLE = 25
PROGRAMS = {"c": "cc", "cpp": "g++", "gpu": "g++", "matlab": "octave-cli"}

CASES = [
    pytest.param(name, option, marks=pytest.mark.runs(*[PROGRAMS[name]] if name in PROGRAMS else []))
    for name in READERS
    for option in ("", *TARGETS[name].options)
]


@pytest.mark.heavy("gpu")
@pytest.mark.wide(4)
@pytest.mark.parametrize(("name", "option"), CASES)
def test_a_sample_of_faults_is_caught(name: str, option: str) -> None:
    program = symdyn.program.lower(
        symdyn.dynamics.derive(symdyn.example("two_link"), ["inverse_dynamics", "forward_dynamics"])
    )
    found = score(program, name, 1, option, SAMPLE)

    assert not found.missed
    assert found.caught > SAMPLE // 2


@pytest.mark.parametrize(("name", "option"), CASES)
@pytest.mark.parametrize(
    "scene",
    [
        pytest.param("two_link", marks=pytest.mark.targets),
        pytest.param("four_bar", marks=pytest.mark.slow),
        pytest.param("puma560", marks=pytest.mark.slow),
    ],
)
def test_every_fault_is_caught(scene: str, name: str, option: str) -> None:
    found = score(symdyn.program.lower(symdyn.dynamics.derive(symdyn.example(scene))), name, 10, option)

    assert not found.missed
