"""Ends of runs and their gradients beside mpmath's Taylor method on equations typed by hand, `data/gradients.py`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from oracles import oracle

from symdyn.scene import read
from symdyn.simulation import sensitivity

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"
ORACLE = oracle("gradients")
NAMES = [name for name in ORACLE if name != "source"]


@pytest.mark.heavy("rolling_disc-forward")
@pytest.mark.parametrize("by", ["forward", "adjoint"])
@pytest.mark.parametrize("name", NAMES)
def test_gradients_are_those_of_taylor_series_at_30_digits(name: str, by: str) -> None:
    scene, said = read(EXAMPLES / f"{name}.toml"), ORACLE[name]
    own = {key: text for key, text in said["start"].items() if not key.startswith("along ")}
    start = {key: text for key, text in own.items() if key in scene.coordinates}
    rates = {key: text for key, text in own.items() if key not in start}

    found = sensitivity(scene, until=1.0, start=start, start_rates=rates, by=by)

    expected = np.array([[float(x) for x in said["columns"][key]] for key in found.columns]).T

    assert set(found.columns) == set(said["columns"])
    assert found.by == by
    assert np.abs(np.concatenate([found.q, found.u]) - [float(x) for x in said["end"]]).max() < 5e-12
    assert np.abs(found.matrix - expected).max() < 2e-12 * max(1.0, np.abs(expected).max())
