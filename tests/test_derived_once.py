"""Whatever is asked of a scene, each request is derived once by each road, and its loops are closed once."""

from __future__ import annotations

from collections import Counter
from importlib import import_module
from pathlib import Path

import pytest

from symdyn.build import run_python
from symdyn.dynamics import Workspace
from symdyn.dynamics.loops import loop_decisions
from symdyn.emit import emit
from symdyn.scene import read
from symdyn.verify import certificate

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.mark.long
@pytest.mark.parametrize(("name", "closings"), [("four_bar", 1), ("two_link", 0)])
def test_a_certificate_derives_each_request_once(name: str, closings: int, monkeypatch: pytest.MonkeyPatch) -> None:
    derive = import_module("symdyn.dynamics.roads.derive")  # whose room has a function of this name
    derived, closed, made = derive._derived, loop_decisions.close, Counter[object]()

    def counted(workspace: Workspace, request: str, row: object, place: str, road: str) -> object:
        made[request, road] += 1
        return derived(workspace, request, row, place, road)

    def closing(*asked: object) -> object:
        made["loops"] += 1
        return closed(*asked)

    monkeypatch.setattr(derive, "_derived", counted)
    monkeypatch.setattr(loop_decisions, "close", closing)
    monkeypatch.setattr(certificate, "modules_of", lambda code, *_: ({"numpy": run_python(emit(code))}, ""))

    assert certificate.certify(read(EXAMPLES / f"{name}.toml")).passed
    assert made["loops"] == closings
    assert len(made) > 30  # it is asked for a lot
    assert {request: count for request, count in made.items() if count > 1} == {}
