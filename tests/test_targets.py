"""A target is one row: laws of what is written, for every row and for one that a stranger adds (`recipes/`).

Rows that are made of functions of their own have tests of their own.
"""

from __future__ import annotations

from dataclasses import MISSING, fields, replace
from pathlib import Path

import pytest
from formulas import CURVE, argument, function, one, spoken
from options_table import made

from symdyn.cli import main
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import TARGETS, Target, emit, write
from symdyn.emit.code.spelling import REALS
from symdyn.errors import EmitError
from symdyn.graph import Graph, Op
from symdyn.graph.ops import ARITY
from symdyn.program import lower
from symdyn.runtime import RUNNERS, Runner
from symdyn.scene import Scene

PENDULUM = Path(__file__).parent.parent / "examples" / "pendulum.toml"
KEYWORDS = sorted({word for target in TARGETS.values() for word in target.keywords})
OPTIONS = tuple(dict.fromkeys(option for target in TARGETS.values() for option in target.options))

pytestmark = pytest.mark.parametrize("name", [name for name, row in TARGETS.items() if row.functions is None])


ASKED = [
    (noun, one.name)
    for noun in (Target, Runner)
    for one in fields(noun)
    if one.default is MISSING and one.default_factory is MISSING
]
"""Fields that a row must have; the others say what is unusual."""


@pytest.mark.parametrize(("noun", "field"), ASKED)
def test_a_row_without_a_field_is_refused_by_its_name(name: str, noun: type, field: str) -> None:
    whole = TARGETS[name] if noun is Target else RUNNERS.get(name, RUNNERS["numpy"])
    row = {one.name: getattr(whole, one.name) for one in fields(noun) if one.name != field}

    with pytest.raises(TypeError, match=f"'{field}'"):
        noun(**row)


def test_what_runs_a_target_asks_for_options_that_it_has(name: str) -> None:
    if name in RUNNERS:  # of others the text alone is held
        assert {RUNNERS[name].many, RUNNERS[name].measured} <= {"", *TARGETS[name].options}


def test_a_row_stands_under_its_name_and_is_offered_in_its_words(name: str) -> None:
    options = [*made()["generate"]["options"], *made()["target_options"]["options"]]
    told = "; ".join(words["help"] for flags, words in (one for one in options if not isinstance(one, str)))

    assert TARGETS[name].name == name
    assert f"{name}: {TARGETS[name].text}" in told
    assert all(f"{TARGETS[name].title}: {text}" in told for text in TARGETS[name].options.values())


def test_files_are_called_as_the_row_says_and_a_header_numbers_as_the_language_does(name: str) -> None:
    target, written = TARGETS[name], set()
    for real in target.reals:
        for option in ("", *target.options) if real != "dd" else ("", "batch", "header-only"):  # it keeps its arrays
            sources = emit(lower(spoken(name, real)), name, real, option=option)
            patterns = {
                pattern: kind
                for pattern, kind in target.files.items()
                if {pattern.format(stem="every_op", function=word) for word in sources.functions} & {*sources}
            }
            assert {type(contents) for contents in sources.values()} <= {*patterns.values()}
            assert f"params[{target.first}] = mass, kg: of the load" in "".join(sources.texts.values())
            written |= set(patterns)
    assert written == set(target.files)


@pytest.mark.long
def test_what_a_target_lacks_is_refused_and_never_ignored(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    target, program = TARGETS[name], lower(spoken(name))
    for option in {*OPTIONS, "sails"} - set(target.options):
        with pytest.raises(EmitError, match=f"target {name} .* has no option {option}; "):
            emit(program, name, option=option)
    for real in set(REALS) - set(target.reals):
        with pytest.raises(EmitError, match=f"real type '{real}': target {name} .* takes .* alone; leave real out"):
            emit(program, name, real)
    for option in set(OPTIONS) - set(target.options):
        assert main(["generate", str(PENDULUM), "--target", name, f"--{option}"]) == 1
        assert f"has no option {option}" in capsys.readouterr().err


@pytest.mark.parametrize("op", [op for op, operands in ARITY.items() if operands])
def test_an_operation_is_written_or_refused_with_the_function_that_needs_it(name: str, op: Op) -> None:
    target, g = TARGETS[name], Graph()
    q = [g.symbol(name) for name in ("q1", "q2", "q3")]
    signs = {Op.ADD: q[0] + q[1], Op.SUB: q[0] - q[1], Op.MUL: q[0] * q[1], Op.DIV: q[0] / q[1], Op.NEG: -q[0]}
    signs[Op.TABLE] = g.lookup(CURVE, q[0])
    program = lower(one([signs[op] if op in signs else g.function(op, *q[: ARITY[op]])], q))
    assert op in program.routines[0].operations
    made_of = op if target.looks_up(REALS["double"]) or op is not Op.TABLE else Op.SELECT

    if made_of in target.lacks:
        with pytest.raises(EmitError, match=f"target {name} .* lacks {made_of.name.lower()}, which f needs: .*; .+"):
            emit(program, name)
    else:
        assert emit(program, name)


def test_an_operation_without_a_spelling_is_refused_in_words(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    row, program = TARGETS[name], lower(spoken(name))
    printer = row.printer(REALS["double"])
    mute = replace(printer, spellings={op: one for op, one in printer.spellings.items() if op is not Op.SIN})
    monkeypatch.setitem(TARGETS, name, replace(row, printer=lambda real: mute))

    with pytest.raises(EmitError, match=f"target {name} .* lacks sin, which .* needs: no spelling of it is known; .+"):
        emit(program, name)


def test_an_option_stands_in_the_command_that_makes_the_files_again(name: str, tmp_path: Path) -> None:
    for option in TARGETS[name].options:
        words = ["generate", str(PENDULUM), "--target", name, f"--{option}"]
        assert main([*words, "-o", str(tmp_path)]) == 0
        text = next(iter(emit(lower(spoken(name)), name, option=option).texts.values()))
        assert f"--target {name} --{option} --functions" in text
        assert any(f"--target {name} --{option}" in path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.*"))


def test_files_may_be_bytes_and_are_what_the_row_says(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    row, program = TARGETS[name], lower(spoken(name))
    with_bytes = replace(row, write=lambda draft: {**row.write(draft), "bits/x.bin": bytes(3)})
    monkeypatch.setitem(TARGETS, name, with_bytes)
    with pytest.raises(AssertionError, match=f"target {name} writes other files than it says"):
        emit(program, name)
    monkeypatch.setitem(TARGETS, name, replace(with_bytes, files={**row.files, "bits/x.bin": bytes}))

    assert tmp_path / "bits" / "x.bin" in write(emit(program, name), tmp_path)
    assert (tmp_path / "bits" / "x.bin").read_bytes() == bytes(3)
    assert "bits/x.bin" not in emit(program, name).texts


def named(names: list[str]) -> Equations:
    g = Graph()
    q = g.symbol("q1")
    arguments = [argument("q", [q])]
    functions = [function(word, arguments, (1,), [q + k]) for k, word in enumerate(names, 1)]
    return Equations(Scene("hand"), g, tuple(functions))


@pytest.mark.parametrize("step", [33, pytest.param(1, marks=pytest.mark.slow)])
def test_a_function_that_is_called_like_a_word_of_the_language_has_another_name(name: str, step: int) -> None:
    words = KEYWORDS[::step]  # headers of C have thousands
    sources = emit(lower(named(words)), name)
    assert [legal for word, legal in zip(words, sources.functions, strict=True) if legal != word] == [
        f"{word}_" for word in words if word in TARGETS[name].keywords
    ]
