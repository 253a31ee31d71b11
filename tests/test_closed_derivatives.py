"""Derivatives of closed scenes along the manifold: against neighbours at sixty digits, road against road."""

from __future__ import annotations

from pathlib import Path

import pytest
from closed_neighbours import Neighbours

import symdyn
from symdyn.dynamics import derive_one

EXAMPLES = Path(__file__).parent.parent / "examples"
SCENES = [
    "four_bar",
    "slider_crank",
    "spatial_slider_crank",
    "rssr",
    "rsup",
    "governor",
    "rolling_disc",
    "cart_with_wheel",
]


@pytest.mark.parametrize("still", [False, True], ids=["moving", "still"])
@pytest.mark.parametrize("name", SCENES)
def test_derivatives_are_differences_of_neighbours_on_the_manifold(name: str, still: bool) -> None:
    near = Neighbours(symdyn.read(EXAMPLES / f"{name}.toml"))
    q, v, tau, a = near.drawn(still=still)
    for output, last, argument in [
        ("forward_dynamics", tau, "tau"),
        ("multipliers", tau, "tau"),
        ("inverse_dynamics", a, "qdd"),
    ]:
        columns = near.differences(near.entries(output), q, v, last, argument)
        function = derive_one(near.w, f"{output}_derivatives")
        found = near.values(function.entries, near.state(q, v, last, argument))
        rows = [list(row) for row in zip(*columns, strict=True)]
        scale = 1 + max(abs(x) for row in rows for x in row)
        assert function.shape == (len(rows), len(columns))
        expected = [x for row in rows for x in row]
        assert max(abs(x - y) for x, y in zip(found, expected, strict=True)) < 1e-30 * scale, output
