"""What docs say of derivatives runs: the page's examples and counts."""

from __future__ import annotations

import doctest
from pathlib import Path

import pytest
from counts_of_literature import state_dependent_counts

from symdyn.dynamics import Workspace, derive_one
from symdyn.scene import read

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "derivatives.md"
COUNTS = ROOT / "docs" / "performance-of-runs.md"


def test_the_examples_of_the_page_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testfile(str(PAGE), module_relative=False)
    assert found.failed == 0
    assert found.attempted > 20


@pytest.mark.parametrize("name", ["two_link", "puma560", "arm7"])
def test_the_counts_of_the_page_are_those_of_today(name: str) -> None:
    w = Workspace(read(ROOT / "examples" / f"{name}.toml"))
    _, section = COUNTS.read_text(encoding="utf-8").split("## Products with derivatives\n")
    (row,) = (line for line in section.partition("\n## ")[0].splitlines() if line.startswith(f"| {name} |"))
    asked = [of + word for of in ("inverse_dynamics", "forward_dynamics") for word in ("", "_jvp", "_vjp")]
    counted = [state_dependent_counts(derive_one(w, one)).multiplications for one in asked]
    assert [int(cell) for cell in row.split("|")[2:-1]] == counted


@pytest.mark.long(0)
def test_contracted_hessians_cost_what_the_page_says() -> None:
    w = Workspace(read(ROOT / "examples" / "arm7.toml"))
    for name in ("inverse_dynamics", "forward_dynamics"):
        count = state_dependent_counts(derive_one(w, f"{name}_hessian")).multiplications
        assert f"{count:,}" in PAGE.read_text(encoding="utf-8")
