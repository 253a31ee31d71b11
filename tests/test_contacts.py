"""Contacts, stops and dry friction in runs, against closed forms and published figures; see tests/data/contacts."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.errors import SceneError, SimulateError
from symdyn.scene import read_text, write_text

DATA = Path(__file__).parent / "data" / "contacts"
CASES = {one["id"]: one for one in json.loads((DATA / "references.json").read_text())["cases"]}

pytestmark = pytest.mark.runs("cc")

METHODS = ("taylor", "dop853")


def told(run: symdyn.Trajectory, what: list) -> float:
    kind, *rest = what
    if kind == "end":
        return float(run[rest[0]][-1])
    names = {"impact": "strikes", "stick": "sticks", "slip": "slips"}
    hits = [one for one in run.impacts if one.what == names[rest[0]] and _is(one.contact, rest[1]) and one.t > 1e-9]
    if kind == "time":
        return hits[rest[2]].t
    row = np.flatnonzero(run.t > hits[rest[2]].t)[0]
    return float(run(np.array([hits[rest[2]].t + 1e-12]))[rest[3]][0]) if row else 0.0


def _is(contact: str, name: str) -> bool:
    return name in (contact, contact.rpartition("_")[0])


@pytest.mark.parametrize("name", [one for one, case in CASES.items() if "scene" in case])
@pytest.mark.parametrize("method", METHODS)
def test_runs_agree_with_closed_forms(name: str, method: str) -> None:
    case = CASES[name]
    run = symdyn.simulate(symdyn.read(DATA / case["scene"]), until=case["until"], method=method, rtol=1e-13)
    for one in case["expect"]:
        assert told(run, one["what"]) == pytest.approx(one["value"], rel=0, abs=one["tol"]), one["what"]
    assert np.abs(run["energy_error"]).max() < 1e-10
    assert min((one.lost for one in run.impacts), default=0.0) >= 0.0
