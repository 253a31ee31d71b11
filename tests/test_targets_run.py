"""Every target runs: what it computes, for every row of the table and one that a stranger adds (`recipes/`)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from formulas import every_op, spoken, states
from hostile import PAYLOADS
from test_targets import KEYWORDS, named

from symdyn import certify, lambdify, read
from symdyn.emit import TARGETS, emit
from symdyn.errors import EmitError, MissingProgram
from symdyn.program import Program, lower
from symdyn.runtime import RUNNERS, run_python
from symdyn.scene.values import Parameter

LIGHT = ("heyoka", "json")
"""Seldom asked for, but run here in a second where they are installed."""

RUNNING = [
    pytest.param(name, marks=[pytest.mark.targets] if RUNNERS[name].by_name_only and name not in LIGHT else [])
    for name, row in TARGETS.items()
    if row.functions is None and name in RUNNERS
]
"""What is run by a heavy runtime is run by `make targets`; Julia is read alone, by its grammar."""

PENDULUM = Path(__file__).parent.parent / "examples" / "pendulum.toml"

pytestmark = [pytest.mark.runs, pytest.mark.parametrize("name", RUNNING)]


def running(name: str, program: Program) -> Any:
    """Return the functions of a program, run as the target is."""
    try:
        return RUNNERS[name].run(emit(program, name))
    except MissingProgram as missing:
        pytest.skip(str(missing))


def test_a_target_computes_what_the_numpy_module_computes(name: str) -> None:
    program = lower(spoken(name))
    module, plain = running(name, program), run_python(emit(program))
    for routine in program.routines:
        given = states(every_op(), routine.function.name, 4)
        call, wanted = getattr(module, routine.function.name, None), getattr(plain, routine.function.name)(*given)
        if call is None:
            assert 0 in routine.function.shape
            continue
        for k in range(4):
            np.testing.assert_allclose(call(*[a[k] for a in given]), wanted[k], rtol=1e-13)
        if RUNNERS[name].batches:
            np.testing.assert_allclose(call(*given), wanted, rtol=1e-13)


@pytest.mark.heavy("ufunc")
def test_verify_measures_what_runs_here(name: str) -> None:
    running(name, lower(spoken(name)))
    found = certify(read(PENDULUM), ("inverse_dynamics", "mass_matrix"), targets=[name]).accuracy

    assert [a.function for a in found if a.passed] == ["inverse_dynamics", "mass_matrix"]


def test_lambdify_takes_what_takes_batches(name: str) -> None:
    if RUNNERS[name].batches:
        running(name, lower(spoken(name)))
        assert lambdify(read(PENDULUM), "mass_matrix", name)(np.zeros((3, 1))).shape == (3, 1, 1)
    else:
        with pytest.raises(EmitError, match=f"target '{name}' is not known; there are numpy, c"):
            lambdify(read(PENDULUM), "mass_matrix", name)


def test_a_function_may_be_called_like_a_word_of_the_language(name: str) -> None:
    own = sorted(TARGETS[name].keywords) or KEYWORDS
    few = lower(named(own[:: len(own) // 10]))
    module = running(name, few)
    for k, legal in enumerate(emit(few, name).functions, 1):
        assert getattr(module, legal)([0.5]) == [k + 0.5]


def test_words_of_a_stranger_in_a_comment_do_nothing(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    equations = spoken(name)
    text = "\n".join(PAYLOADS.values())
    scene = replace(
        equations.scene, parameters=(Parameter("mass", unit="kg", text=text), *equations.scene.parameters[1:])
    )
    program = lower(replace(equations, scene=scene))

    module = running(name, program)
    given = [a[0] for a in states(equations, "scalar", 1)]
    assert module.scalar(*given) == pytest.approx(run_python(emit(lower(equations))).scalar(*given), rel=1e-14)
    assert list(tmp_path.iterdir()) == []
