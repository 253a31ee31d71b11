"""A target is one row: laws that hold for every row of the table, and for one that a stranger adds (`recipes/`)."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from formulas import argument, every_op, function, states
from hostile import PAYLOADS

from symdyn import certify, lambdify, read
from symdyn.build import RUNNERS, Runner, run_python
from symdyn.cli import main
from symdyn.dynamics.roads.named_functions import Equations
from symdyn.emit import TARGETS, Target, emit, write
from symdyn.emit.code.real import REALS
from symdyn.errors import EmitError, MissingProgram
from symdyn.graph import Graph
from symdyn.program import Program, lower
from symdyn.scene import Parameter, Scene

PENDULUM = Path(__file__).parent.parent / "examples" / "pendulum.toml"
OPTIONS = tuple(dict.fromkeys(option for target in TARGETS.values() for option in target.options))
KEYWORDS = sorted({word for target in TARGETS.values() for word in target.keywords})

pytestmark = pytest.mark.parametrize("name", TARGETS)


def running(name: str, program: Program) -> Any:
    """Return the functions of a program, run as the target is."""
    if name not in RUNNERS:
        pytest.skip(f"nothing runs {name}")
    try:
        return RUNNERS[name].run(emit(program, name))
    except MissingProgram as missing:
        pytest.skip(str(missing))


@pytest.mark.parametrize(("noun", "field"), [(noun, one.name) for noun in (Target, Runner) for one in fields(noun)])
def test_a_row_without_a_field_is_refused_by_its_name(name: str, noun: type, field: str) -> None:
    whole = TARGETS[name] if noun is Target else RUNNERS[name]
    row = {one.name: getattr(whole, one.name) for one in fields(noun) if one.name != field}

    with pytest.raises(TypeError, match=f"'{field}'"):
        noun(**row)


def test_what_runs_a_target_asks_for_options_that_it_has(name: str) -> None:
    assert {RUNNERS[name].many, RUNNERS[name].measured} <= {"", *TARGETS[name].options}


def test_a_row_stands_under_its_name_and_is_offered_in_its_words(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["generate", "--help"])
    told = "".join(capsys.readouterr().out.split())

    assert TARGETS[name].name == name
    assert f"{name}:{TARGETS[name].text}".replace(" ", "") in told
    assert all(f"{TARGETS[name].title}:{text}".replace(" ", "") in told for text in TARGETS[name].options.values())


def test_files_end_as_the_row_says_and_a_header_numbers_as_the_language_does(name: str) -> None:
    target, written = TARGETS[name], set()
    for real in target.reals:
        for option in ("", *target.options):
            sources = emit(lower(every_op()), name, real, option=option)
            endings = {file.removeprefix("every_op"): type(contents) for file, contents in sources.items()}
            assert endings.items() <= target.endings.items()
            assert f"params[{target.first}] = mass, kg: of the load" in "".join(sources.texts.values())
            written |= set(endings)
    assert written == set(target.endings)


def test_what_a_target_lacks_is_refused_and_never_ignored(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    target, program = TARGETS[name], lower(every_op())
    for option in {*OPTIONS, "sails"} - set(target.options):
        with pytest.raises(EmitError, match=f"target {name} .* has no option {option}; "):
            emit(program, name, option=option)
    for real in set(REALS) - set(target.reals):
        with pytest.raises(EmitError, match=f"real type '{real}': target {name} .* takes .* alone"):
            emit(program, name, real)
    for option in set(OPTIONS) - set(target.options):
        assert main(["generate", str(PENDULUM), "--target", name, f"--{option}"]) == 1
        assert f"has no option {option}" in capsys.readouterr().err


def test_an_option_stands_in_the_command_that_makes_the_files_again(name: str, tmp_path: Path) -> None:
    for option in TARGETS[name].options:
        words = ["generate", str(PENDULUM), "--target", name, f"--{option}"]
        assert main([*words, "-o", str(tmp_path)]) == 0
        text = next(iter(emit(lower(every_op()), name, option=option).texts.values()))
        assert f"--target {name} --{option} --functions" in text
        assert any(f"--target {name} --{option}" in path.read_text(encoding="utf-8") for path in tmp_path.iterdir())


@pytest.mark.runs
def test_a_target_computes_what_the_numpy_module_computes(name: str) -> None:
    program = lower(every_op())
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


@pytest.mark.runs
def test_verify_measures_what_runs_here(name: str) -> None:
    running(name, lower(every_op()))
    found = [a for a in certify(read(PENDULUM), ("inverse_dynamics", "mass_matrix")).accuracy if a.module == name]

    assert [a.function for a in found if a.passed] == ["inverse_dynamics", "mass_matrix"]


@pytest.mark.runs
def test_lambdify_takes_what_takes_batches(name: str) -> None:
    if name in RUNNERS and RUNNERS[name].batches:
        running(name, lower(every_op()))
        assert lambdify(read(PENDULUM), "mass_matrix", name)(np.zeros((3, 1))).shape == (3, 1, 1)
    else:
        with pytest.raises(EmitError, match=f"target '{name}' is not known; give numpy or c"):
            lambdify(read(PENDULUM), "mass_matrix", name)


def named(names: list[str]) -> Equations:
    g = Graph()
    q = g.symbol("q1")
    arguments = [argument("q", [q])]
    functions = [function(word, arguments, (1,), [q + k]) for k, word in enumerate(names, 1)]
    return Equations(Scene("hand"), g, tuple(functions))


@pytest.mark.runs
def test_a_function_may_be_called_like_a_word_of_the_language(name: str) -> None:
    own = sorted(TARGETS[name].keywords) or KEYWORDS
    sources = emit(lower(named(KEYWORDS)), name)
    assert [legal for word, legal in zip(KEYWORDS, sources.functions, strict=True) if legal != word] == [
        f"{word}_" for word in KEYWORDS if word in TARGETS[name].keywords
    ]

    few = lower(named(own[:: len(own) // 10]))
    module = running(name, few)
    for k, legal in enumerate(emit(few, name).functions, 1):
        assert getattr(module, legal)([0.5]) == [k + 0.5]


@pytest.mark.runs
def test_words_of_a_stranger_in_a_comment_do_nothing(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    equations = every_op()
    text = "\n".join(PAYLOADS.values())
    scene = replace(
        equations.scene, parameters=(Parameter("mass", unit="kg", text=text), *equations.scene.parameters[1:])
    )
    program = lower(replace(equations, scene=scene))

    module = running(name, program)
    given = [a[0] for a in states(equations, "scalar", 1)]
    assert module.scalar(*given) == pytest.approx(run_python(emit(lower(equations))).scalar(*given), rel=1e-14)
    assert list(tmp_path.iterdir()) == []


def test_files_may_be_bytes_and_are_what_the_row_says(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    row, program = TARGETS[name], lower(every_op())
    with_bytes = replace(row, write=lambda draft: {**row.write(draft), ".bin": bytes(3)})
    monkeypatch.setitem(TARGETS, name, with_bytes)
    with pytest.raises(AssertionError, match=f"target {name} writes other files than it says"):
        emit(program, name)
    monkeypatch.setitem(TARGETS, name, replace(with_bytes, endings={**row.endings, ".bin": bytes}))

    paths = {path.name: path for path in write(emit(program, name), tmp_path)}
    assert paths["every_op.bin"].read_bytes() == bytes(3)
    assert "every_op.bin" not in emit(program, name).texts
