"""What is offered stands on the page that lists it."""

from __future__ import annotations

import re
from types import ModuleType

import pages
import pytest

import symdyn
from symdyn import identification, simulation, study

IDENTIFICATION = {
    "Excitation", "Gain", "Identification", "Identified", "OutputFit", "Payload", "Regression",
    "excite", "identified", "identify", "output_error", "with_parameters",
}  # fmt: skip
SIMULATION = {"Feedback", "Uncertainty"}
STUDY = {"Indices", "Runs", "ensemble", "open", "sweep", "uncertainty"}
"""What is for users; a front offers names to other packages, too."""


@pytest.mark.parametrize(
    ("package", "names"),
    [(symdyn, set(symdyn.__all__)), (identification, IDENTIFICATION), (study, STUDY), (simulation, SIMULATION)],
    ids=["symdyn", "identification", "study", "simulation"],
)
def test_every_function_and_noun_for_users_stands_on_the_page(package: ModuleType, names: set[str]) -> None:
    """`excite`, `output_error`, `Indices` and `Uncertainty` were missing."""
    page = (pages.DOCS / "api.md").read_text(encoding="utf-8")
    listed = re.findall(r"auto\w+:: symdyn[.\w]*\.(\w+)$", page, re.MULTILINE)
    asked = [name for name in sorted(names) if callable(getattr(package, name)) and not name.endswith("Error")]

    assert [name for name in asked if name not in listed] == []
