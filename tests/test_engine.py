"""symdyn against a reference in maximal coordinates that shares none of its mechanics: see tests/engine."""

from __future__ import annotations

import ast
from itertools import combinations
from pathlib import Path

import pytest
from engine.trials.compare import COMPARED, report
from engine.trials.options import OPTIONS, PAIRED, covering, pairs

from symdyn.dynamics import OUTPUTS
from symdyn.dynamics.outputs.arm_outputs import ARMS
from symdyn.dynamics.outputs.configuration_outputs import CONFIGURATIONS
from symdyn.dynamics.outputs.contact_outputs import CONTACTS
from symdyn.dynamics.outputs.held_outputs import HELD
from symdyn.dynamics.outputs.linearizing_outputs import LINEARIZING
from symdyn.dynamics.outputs.operator_outputs import OPERATORS
from symdyn.dynamics.outputs.regressor_outputs import PASSIVITY, REGRESSORS

ENGINE = Path(__file__).parent / "engine"

ALL, PART = 3000, 50


@pytest.mark.wide(9)
@pytest.mark.long
@pytest.mark.parametrize("seed", range(PAIRED))
def test_bodies_one_by_one_move_and_bear_as_symdyn_says(seed: int) -> None:
    text = report(seed)
    assert not text, text


@pytest.mark.slow
@pytest.mark.parametrize("begin", range(PAIRED, ALL, PART))
def test_thousands_of_mechanisms_move_and_bear_as_symdyn_says(begin: int) -> None:
    found = [text for text in map(report, range(begin, begin + PART)) if text]
    assert not found, "\n\n".join(found)


def test_every_pair_of_options_meets_in_the_first_trials() -> None:
    every = {((a, x), (b, y)) for a, b in combinations(OPTIONS, 2) for x in OPTIONS[a] for y in OPTIONS[b]}

    assert every == set().union(*(pairs(one) for one in covering()))


FORMULAS = {"output", "outputs", "tension"}
"""What scenes of trials do not have: formulas of reactions and accelerations, which are compared themselves."""
LED = {name.partition(":")[0] for name in LINEARIZING}
SHAPED = {"shaping_forces", "damping_forces"}
ELSEWHERE = {
    *REGRESSORS, *PASSIVITY, *LED, *CONTACTS, *HELD, *SHAPED, *OPERATORS, *CONFIGURATIONS,
    *ARMS, "state_rates", "resets", "canonical_rates", "routhian",
}  # fmt: skip
"""What is proved to be forces times parameters, and compared in numbers by `test_regressors.py`; rates and resets of
states, which scenes of trials do not have, by `test_states.py`, `test_state_examples.py` and `test_state_events.py`; by
`test_canonical.py` rates of momenta, and Routh's function; by `test_linearizing.py` what linearises; by
`test_contacts.py` contacts that open and close, by `test_held_contacts.py` those that a mask holds, by
`test_shaping.py` forces that shape energy; by `test_operators.py` and `test_robots_frames.py` what solves with the mass
matrix, the centre of pressure, and what adds displacements to positions; by `test_arm_outputs.py` the
angles of arms."""


def test_every_output_is_compared() -> None:
    names = {name.partition(":")[0] for name in OUTPUTS} - FORMULAS - ELSEWHERE
    assert names == set(COMPARED), "add a comparison to COMPARED in tests/engine/trials/compare.py"


def test_the_reference_knows_no_derivation() -> None:
    for path in ENGINE.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.partition(".")[0] == "symdyn"], path
    for path in (ENGINE / "trials").glob("*.py"):
        if path.stem not in ("code", "compare"):
            text = path.read_text(encoding="utf-8")
            assert "symdyn." not in text.replace("symdyn.scene", "").replace("symdyn.errors", ""), path
