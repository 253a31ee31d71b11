"""Code for many states runs at every length from none to three blocks, and a block that is off is found."""

from __future__ import annotations

from dataclasses import replace

import pytest

import symdyn
from symdyn.program import lower, prepare as prepare_program
from symdyn.verify import building, building as blocks
from symdyn.verify.building import Building

pytestmark = [pytest.mark.runs("cc"), pytest.mark.usefixtures("optimised")]


@pytest.mark.wide(2)
@pytest.mark.parametrize("real", ["double", "float"])
def test_every_length_gives_the_states_one_by_one(real: str) -> None:
    program = lower(
        symdyn.dynamics.derive(symdyn.example("two_link"), ["inverse_dynamics", "mass_matrix", "kinetic_energy"])
    )
    for code in (program, prepare_program(program)):
        found = blocks.run_blocks(Building(code, real), "c")

        assert found.passed, found.wrong
        assert found.longest == 192
        assert found.functions == len(code.routines)


@pytest.mark.wide(2)
@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("k += states;", "k += states + (n == 131);", "of 131 states"),
        ("x[i * stride + states - 1]", "x[i * stride]", ""),
        ("states * sizeof *x);\n    }\n}", "(states - (states == 3)) * sizeof *x);\n    }\n}", "columns of 3 states"),
        ("while (n - k > 8)", "while (n - k > 8 && n != 100)", ""),
        (
            "for (size_t k = 0; k < states; k++) {\n            x[k * length + i]",
            "for (size_t k = 1; k < states; k++) {\n            x[k * length + i]",
            "rows of 9 states",
        ),
    ],
)
def test_a_fault_of_the_fixed_text_is_found(monkeypatch: pytest.MonkeyPatch, old: str, new: str, told: str) -> None:
    program = lower(symdyn.dynamics.derive(symdyn.example("two_link"), ["inverse_dynamics"]))
    emit = building.emit

    def broken(*words: object, **named: object) -> object:
        sources = emit(*words, **named)  # type: ignore[arg-type]
        text = str(sources["two_link.c"])
        assert old in text
        files = tuple((name, text.replace(old, new) if name == "two_link.c" else rest) for name, rest in sources.files)
        return replace(sources, files=files)

    monkeypatch.setattr(building, "emit", broken)

    assert told in blocks.run_blocks(Building(program, "double"), "c").wrong


def test_a_certificate_of_c_says_that_blocks_were_run() -> None:
    found = symdyn.certify(symdyn.example("pendulum"), ["inverse_dynamics"], targets=["c"])

    assert found.passed
    assert [one.longest for one in found.blocks] == [192]
    assert {one.option for one in found.written} == {"", "batch", "header-only", "stack"}
    assert not symdyn.certify(symdyn.example("pendulum"), ["mass_matrix"]).blocks


@pytest.mark.runs("g++")
def test_blocks_of_cpp_are_run_at_every_length() -> None:
    program = lower(symdyn.dynamics.derive(symdyn.example("two_link"), ["inverse_dynamics", "kinetic_energy"]))
    found = blocks.run_blocks(Building(program, "double"), "cpp")

    assert (found.wrong, found.ways, found.functions) == ("", ("columns", "rows"), 2)


@pytest.mark.runs("g++")
@pytest.mark.parametrize("way", ["columns", "rows"])
def test_a_fault_in_the_blocks_of_cpp_is_found(monkeypatch: pytest.MonkeyPatch, way: str) -> None:
    old = {"columns": "own::give(states, n, 1, r, out + k);", "rows": "own::give(states, 1, 2, r, out + k * 2);"}[way]
    new = old.replace("states", "states - (states == 3)")
    program = lower(symdyn.dynamics.derive(symdyn.example("two_link"), ["inverse_dynamics"]))
    emit = building.emit

    def broken(*words: object, **named: object) -> object:
        sources = emit(*words, **named)  # type: ignore[arg-type]
        text = str(sources["two_link.hpp"])
        assert old in text
        return replace(sources, files=(("two_link.hpp", text.replace(old, new)),))

    monkeypatch.setattr(building, "emit", broken)

    assert f"{way} of 3 states" in blocks.run_blocks(Building(program, "double"), "cpp").wrong


@pytest.mark.targets
@pytest.mark.runs("rustc")
@pytest.mark.parametrize("real", ["double", "float"])
def test_rows_of_rust_are_run_at_every_length(real: str) -> None:
    program = lower(symdyn.dynamics.derive(symdyn.example("two_link"), ["inverse_dynamics", "kinetic_energy"]))
    for code in (program, prepare_program(program)):
        found = blocks.run_blocks(Building(code, real), "rust")

        assert (found.wrong, found.ways, found.functions) == ("", ("rows",), len(code.routines))
