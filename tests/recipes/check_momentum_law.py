"""What a law from outside is worth: it is proved of every scene, and sees a mistake that both formulations make.

`tests/test_recipes.py` runs this in a fresh process, where the law is one file that is imported here.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import momentum_law
import pytest

import symdyn
from symdyn.cli import main
from symdyn.dynamics import OUTPUTS, Formulation, Workspace
from symdyn.verdict import Verdict
from symdyn.verify import certify, laws

pytestmark = pytest.mark.usefixtures("numpy_alone")

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
CLAIM = f"{momentum_law.__name__}: dK/dqd = p"
ABOUT = ("kinetic_energy", "momentum")


@pytest.mark.parametrize("name", ["two_link", "heavy_top", "four_bar", "rolling_disc"])
def test_it_is_proved_of_trees_and_of_closed_scenes(name: str) -> None:
    certificate = certify(symdyn.read(EXAMPLES / f"{name}.toml"), ABOUT)

    assert {finding.claim: finding.verdict for finding in certificate.findings}[CLAIM] == Verdict.PROVED
    assert certificate.passed


def test_it_is_left_out_where_one_of_its_outputs_is() -> None:
    claims = laws(Workspace(symdyn.read(EXAMPLES / "two_link.toml")), ("momentum", "mass_matrix"))

    assert [claim.name for claim in claims] == []


def test_verify_prints_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(EXAMPLES / "two_link.toml"), "--functions", ",".join(ABOUT)]) == 0
    assert CLAIM in capsys.readouterr().out


def test_it_sees_what_all_formulations_of_an_output_have_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    row = OUTPUTS["momentum"]
    wrong = {way: twice(formulation) for way, formulation in row.formulations.items()}
    monkeypatch.setitem(OUTPUTS, "momentum", replace(row, formulations=wrong))
    certificate = certify(symdyn.read(EXAMPLES / "two_link.toml"), ABOUT)

    assert [finding.claim for finding in certificate.findings if finding.verdict != Verdict.PROVED] == [CLAIM]
    assert not certificate.passed


def twice(formulation: Formulation) -> Formulation:
    """Return a formulation to twice what another one finds."""
    return replace(formulation, derive=lambda w: [2 * x for x in formulation.derive(w)])
