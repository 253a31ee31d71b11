"""What is offered to users has a page of its own in the API reference, with what it takes, returns, and an example."""

from __future__ import annotations

import doctest
import inspect
from types import ModuleType

import pages
import pytest
from reference import GROUPS, catalogue, examples, members, object_of
from test_layers import offered

import symdyn
from symdyn import identification, linear, simulation, study, transcription

LISTED = {name: one for names in catalogue().values() for name in names if (one := object_of(name))}

IDENTIFICATION = {
    "Calibration", "Excitation", "Gain", "Identification", "Identified", "OutputFit", "Payload", "Regression",
    "calibrate", "excite", "identified", "identify", "output_error", "with_parameters",
}  # fmt: skip
NAMES: dict[ModuleType, set[str]] = {
    symdyn: {name for name in offered("symdyn") if not name.endswith("Error")},
    identification: IDENTIFICATION,
    simulation: {"linear_law", "Uncertainty", "Trajectory", "Sensitivity"},
    study: {"Indices", "Runs", "ensemble", "open", "sweep", "uncertainty"},
    linear: {"Linearization"},
    transcription: {"Collocation"},
}
"""What is for users; a front offers names to other packages, too."""


@pytest.mark.parametrize("front", NAMES, ids=lambda front: front.__name__)
def test_every_function_and_noun_for_users_has_a_page(front: ModuleType) -> None:
    """A function that a package of no group adds to `symdyn` is missed here: name its package in `GROUPS`."""
    each = {name: getattr(front, name) for name in NAMES[front]}
    asked = {name: one for name, one in each.items() if callable(one) and not isinstance(one, ModuleType)}

    assert [name for name, one in asked.items() if one not in LISTED.values()] == []


def test_a_name_has_one_page_and_every_group_stands_in_the_reference() -> None:
    page = (pages.DOCS / "api.md").read_text(encoding="utf-8")

    assert len({id(one) for one in LISTED.values()}) == len(LISTED) == sum(map(len, catalogue().values()))
    assert [group.title for group in GROUPS if f".. api-group:: {group.title}\n" not in page] == []
    assert page.count(".. api-group::") == len(GROUPS)
    assert all(catalogue().values())


@pytest.mark.parametrize("name", LISTED)
def test_what_is_listed_says_what_it_is(name: str) -> None:
    """A sentence on top, and an example, in its docstring or in docs/site/api_examples.txt."""
    one = LISTED[name]
    text = inspect.getdoc(one) or ""

    assert text.partition("\n")[0].strip()
    assert ">>>" in text or name in examples()
    if inspect.isfunction(one) and name.count(".") == 1:
        assert "Args:" in text
        assert "Raises:" in text
    if inspect.isclass(one):
        assert {member for member in members(one) if member.startswith("_")} == set()


def test_examples_are_of_what_is_listed() -> None:
    """One whose name is gone, or whose docstring has got an example, is taken away."""
    assert [name for name in examples() if name not in LISTED or ">>>" in (inspect.getdoc(LISTED[name]) or "")] == []


@pytest.mark.wide(4)  # `make doctest` runs them all
@pytest.mark.runs("cc")
@pytest.mark.long(2)
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("text", {text: name for name, text in examples().items()}, ids=lambda text: text[-40:])
def test_an_example_runs_by_itself(text: str) -> None:
    if "problem.solve()" in text:
        pytest.importorskip("casadi")
    found = doctest.DocTestRunner(verbose=False).run(doctest.DocTestParser().get_doctest(text, {}, "example", None, 0))

    assert found.attempted > 1
    assert found.failed == 0
