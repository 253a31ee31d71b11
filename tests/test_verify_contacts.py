"""What `verify` claims of contacts: laws that are proved, and laws looked at in numbers; each of them can fail."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.dynamics import Workspace
from symdyn.simulation import natural_contacts as looks
from symdyn.simulation.equations import variational
from symdyn.simulation.equations.complementarity import Laws
from symdyn.simulation.equations.contact_modes import Contacts
from symdyn.simulation.equations.settling import Settling
from symdyn.simulation.equations.system import StateEquations
from symdyn.verdict import Verdict
from symdyn.verify import laws_of_contacts, prove

pytestmark = pytest.mark.runs("cc")

SCENES = Path(__file__).parent / "data" / "impacts" / "scenes"

BRICK = symdyn.read(SCENES / "brick.toml")

PROVED = {
    "gaps": "gap:plane",
    "gaps and slips": "gap_jdot:plane",
    "impact matrices": "impact_matrix:plane",
    "Delassus' matrix": "delassus",
    "contacts without forces": "contact_bias",
    "impacts": "impact:plane",
    "modes of contacts": "contact_dynamics",
    "rows of modes": "contact_dynamics",
}
"""Claims, and the output that is wrong where the claim has to fail."""


@pytest.mark.parametrize("claim", PROVED)
def test_a_fault_in_an_output_of_contacts_is_seen_by_its_law(claim: str, monkeypatch: pytest.MonkeyPatch) -> None:
    w, usual = Workspace(BRICK), laws_of_contacts.derive_one
    law = dict(zip(PROVED, laws_of_contacts.LAWS_OF_CONTACTS, strict=True))[claim]

    def wrong(w: Workspace, name: str) -> Any:
        found = usual(w, name)
        if name != PROVED[claim]:
            return found
        # of a mode accelerations, else forces: what is claimed of the latter holds for any accelerations
        at = len(found.entries) - 1 if claim == "rows of modes" else 0
        changed = tuple(x + w.state.q[0] ** 2 if k == at else x for k, x in enumerate(found.entries))
        return replace(found, entries=changed)

    def verdict() -> Verdict:
        made = law.claim(w)
        assert made is not None
        assert made.name == claim
        return prove([made])[1][0].verdict

    assert verdict() == Verdict.PROVED
    monkeypatch.setattr(laws_of_contacts, "derive_one", wrong)
    monkeypatch.setattr(laws_of_contacts, "entries", lambda w, name: wrong(w, name).entries)
    assert verdict() == Verdict.DIFFERENT


Wrapped = Callable[..., Any]


def by(change: Callable[[Any], Any]) -> Callable[[Wrapped], Wrapped]:
    return lambda function: lambda *given, **named: change(function(*given, **named))


def pulling(function: Wrapped) -> Wrapped:
    return lambda system, name, t, x: function(system, name, t, x) * (-1.0 if name == "contact_forces" else 1.0)


FAULTS: dict[str, tuple[str, Any, str, Callable[[Wrapped], Wrapped]]] = {
    looks.PIVOTS: ("brick", Laws, "by_pivots", by(lambda x: 1.001 * x)),
    looks.GAUSS: ("brick", Laws, "impact", by(lambda x: 1.001 * x)),
    looks.LAWS: ("brick", Laws, "impact", by(lambda x: np.array([x[0], x[0] + x[1]]))),
    looks.ENERGY: ("brick", Laws, "impact", by(lambda x: 3 * x)),
    looks.STUCK: ("brick", Contacts, "with_mode", by(lambda x: np.where(np.arange(len(x)) == 5, 0.0, x))),
    looks.SLOPES: ("brick", variational, "saltation", by(lambda x: 1.001 * x)),
    looks.ROWS: ("brick", StateEquations, "evaluate", pulling),
    looks.BALANCE: ("bouncing_ball", Settling, "behind", by(lambda x: x + 1e-3 * (np.arange(len(x)) == len(x) - 1))),
}
"""Claims, a scene, and what is done to a part of the product so that the claim has to fail."""


@pytest.mark.wide(4)
@pytest.mark.filterwarnings("ignore:brick")  # of runs that end where a fault adds energy
@pytest.mark.parametrize("claim", FAULTS)
def test_a_fault_in_contacts_is_seen_in_numbers(claim: str, monkeypatch: pytest.MonkeyPatch) -> None:
    name, where, what, change = FAULTS[claim]
    scene = symdyn.read(SCENES / f"{name}.toml")

    def failing() -> set[str]:
        return {claim for claim, places in looks.contact_checks(scene, 1)[0].items() if not all(places.values())}

    assert not failing()
    monkeypatch.setattr(where, what, change(getattr(where, what)))
    assert claim in failing()


def test_a_certificate_has_all_laws_of_contacts() -> None:
    """Two corners touch at once, and hold the same."""
    found = symdyn.certify(symdyn.read(SCENES / "rocking_block.toml"), ["delassus", "gap:left", "gap_jacobian:left"])
    verdicts = {one.claim: one.verdict for one in found.findings}

    assert found.passed
    assert verdicts["gaps: dg/dt = n qd"] == Verdict.PROVED
    assert all(verdicts[claim] for claim in FAULTS)
    assert {one.what for one in found.absent} == set()
