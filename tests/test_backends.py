"""Whose arrays functions take: what is said where there is no such backend, or its package is missing."""

from __future__ import annotations

import importlib.util
from typing import Any

import pytest

import symdyn
from symdyn.dynamics import LoopChoices
from symdyn.errors import BuildError, MissingProgram
from symdyn.program import formulate, lower, prepare as prepared
from symdyn.runtime.backends import load_functions
from symdyn.runtime.backends.words import ALL, ALONG, BACK, BENT, VALUE, Code, Word
from symdyn.scene import Scene


def word(scene: Scene, request: str, prepare: bool = False) -> Word:
    program = lower(formulate(scene, (request,)))
    program = prepared(program) if prepare else program
    return Word(VALUE, None, Code(program, lambda *_: None), int(prepare), (scene, request, LoopChoices()))


def test_an_unknown_backend_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(BuildError, match="'tensorflow' is not known; there are numpy, jax, torch"):
        symdyn.load(symdyn.example("pendulum"), backend="tensorflow")


@pytest.mark.parametrize("name", [name for name, row in load_functions.BACKENDS.items() if row.package])
def test_a_missing_package_is_told_with_what_installs_it(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = importlib.util.find_spec

    def without(module: str, *rest: Any) -> Any:
        return None if module == load_functions.BACKENDS[name].package else found(module, *rest)

    monkeypatch.setattr(load_functions, "find_spec", without)
    with pytest.raises(MissingProgram, match=rf'is not installed; `pip install "symdyn\[{name}\]"`'):
        symdyn.load(symdyn.example("pendulum"), backend=name)


@pytest.mark.parametrize(
    ("name", "request_", "stated"),
    [
        ("two_link", "inverse_dynamics", ("q", "qd", "qdd")),
        ("two_link", "pose:tip", ("q",)),
        ("heavy_top", "inverse_dynamics", None),
        ("four_bar", "forward_dynamics", None),
    ],
)
def test_the_words_of_a_scene_are_taken_where_velocities_are_rates(
    name: str, request_: str, stated: tuple[str, ...] | None
) -> None:
    one = word(symdyn.example(name), request_.replace("tip", "link2"))
    way = one.stated

    assert (way.varied_names if way else None) == stated
    assert one.plain.varied_names == one.names
    if way:
        assert one.way_for(way.varied_names[:1]) is way
        assert one.way_for([*way.varied_names, "params"]) is one.plain


def test_what_is_prepared_is_differentiated_as_it_is_computed() -> None:
    one = word(symdyn.example("two_link"), "inverse_dynamics", prepare=True)

    assert one.stated is None
    assert one.plain.word(BACK).names == ("q", "qd", "qdd", "weights", "prepared")


@pytest.mark.parametrize("kind", [ALONG, BACK, ALL, BENT])
def test_derivatives_of_derivatives_have_arguments_of_their_own(kind: str) -> None:
    one = word(symdyn.example("pendulum"), "inverse_dynamics")
    for _ in range(3):
        one = one.plain.word(kind)
        assert len(set(one.names)) == len(one.names)
