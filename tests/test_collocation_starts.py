"""Starts of a search: drawn by seed, inside of what is asked, and told with all that they led to."""

from __future__ import annotations

import sys
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest
from numpy.testing import assert_allclose

import symdyn
from symdyn.errors import SimulateError
from symdyn.transcription import Collocation, Solution, ipopt

ROOT = Path(__file__).parent.parent
SWING = symdyn.read(ROOT / "benchmarks" / "data" / "swing_up.toml")


@pytest.fixture(scope="module")
def problem() -> Collocation:
    end = {"end": {"q1": 1, "q2": "pi"}, "end_rates": {"q1": 0, "q2": 0}}
    return symdyn.collocation(SWING, (1, 3), 20, cost="u**2", **end)


def drawn(problem: Collocation, starts: int = 6, seed: int = 3) -> list[np.ndarray]:
    from symdyn.transcription.ipopt import drawn

    return drawn(problem, problem.guess, starts, seed)


@pytest.mark.runs("cc")
def test_a_seed_gives_the_same_starts_and_another_one_others(problem: Collocation) -> None:
    one, same, other = drawn(problem), drawn(problem), drawn(problem, seed=4)
    for x, y in zip(one, same, strict=True):
        assert_allclose(x, y, rtol=0, atol=0)
    assert_allclose(one[0], problem.guess, rtol=0, atol=0)
    assert all(np.abs(x - y).max() > 0.1 for x, y in zip(one[1:], other[1:], strict=True))
    assert_allclose(drawn(problem, 3)[2], one[2], rtol=0, atol=0)  # more starts go on where fewer ended


@pytest.mark.runs("cc")
def test_starts_keep_the_ends_and_the_bounds_and_are_motions(problem: Collocation) -> None:
    for z in drawn(problem)[1:]:
        assert np.all((problem.lower <= z) & (z <= problem.upper))
        q, u, t = z[problem.place["q"]], z[problem.place["u"]], problem.time(z) * problem.grid.share
        assert_allclose(q[[0, -1]], [[0, 0], [1, np.pi]], atol=1e-12)
        assert 1 <= problem.time(z) <= 3
        inside = slice(2, -2)  # what is given of the ends stays
        slope = np.gradient(q[:, 1], t)
        assert_allclose(u[inside, 1], slope[inside] + problem.guess[problem.place["u"]][inside, 1] - np.pi / t[-1],
                        atol=0.06 * np.abs(slope).max())  # fmt: skip


def solution(problem: Collocation, z: np.ndarray, cost: float, success: bool = True) -> Solution:
    return Solution(problem, z, np.zeros(problem.rows), cost, 0.0, success, "ended" if success else "gave up", 1, 0.0)


@pytest.mark.runs("cc")
def test_all_optima_are_told_best_first_and_how_many_starts_led_there(
    problem: Collocation, monkeypatch: pytest.MonkeyPatch
) -> None:
    others = problem.guess.copy()
    others[problem.place["q"]] *= -1.0  # of the same cost, but another motion
    ends = iter([(problem.guess, 3.0), (others, 3.0), (problem.guess, 3.0 + 1e-8), (problem.guess, 2.0), None])

    def one(problem: Collocation, start: np.ndarray, *_: object) -> Solution:
        there = next(ends)
        return solution(problem, start, 1.0, success=False) if there is None else solution(problem, *there)

    monkeypatch.setattr(ipopt, "_solved", one)
    found = problem.solve(starts=5, seed=7)
    assert [one.objective for one in found.optima] == [2.0, 3.0, 3.0]
    assert found.objective == 2.0
    assert repr(found) == "<Solution of swing_up: 2, ended after 1 iterations; 3 optima from 5 starts>"
    assert found.searched.led == ((2.0, 1), (3.0, 2), (3.0, 1))
    assert found.searched.failed == (("gave up", 1),)
    assert found.notes[-1] == (
        "searched from 5 starts (the guess, and 4 drawn by seed 7): 3 optima by the conditions of first order: 2 "
        "(1 start), 3 (2 starts), 3 (1 start); 1 ended with gave up; there may be better ones"
    )


@pytest.mark.runs("cc")
def test_one_start_is_said_to_be_one(problem: Collocation, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ipopt, "_solved", lambda problem, start, *_: solution(problem, start, 1.5))
    found = problem.solve()
    assert found.optima == (found,)
    assert repr(found) == "<Solution of swing_up: 1.5, ended after 1 iterations>"
    assert found.notes[-1].endswith("1.5 (1 start); another start may find a better one: starts=8")
    assert found.notes[-1] in found._repr_mimebundle_()["text/html"]


@pytest.mark.runs("cc")
@pytest.mark.mends("30.control.3")
@pytest.mark.mends("30.class.optimum")
def test_a_page_of_an_optimum_says_how_it_was_searched(problem: Collocation, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever solver ends at the guess."""
    solver = MagicMock(return_value={"x": problem.guess, "lam_g": np.zeros(int(problem.binding.sum()))})
    solver.stats.return_value = {"return_status": "Solve_Succeeded", "iter_count": 1, "success": True}
    monkeypatch.setitem(sys.modules, "casadi", MagicMock(nlpsol=lambda *_: solver))
    for name in ("_callback", "_hessian"):
        monkeypatch.setattr(ipopt, name, MagicMock())
    page = problem.solve()._repr_mimebundle_()["text/html"]

    assert "searched from 1 start: 1 optimum by the conditions of first order" in page
    assert "another start may find a better one" in page


@pytest.mark.runs("cc")
def test_where_no_start_ends_the_first_is_returned_with_what_was_said(
    problem: Collocation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ipopt, "_solved", lambda problem, start, *_: solution(problem, start, 1.5, success=False))
    found = problem.solve(starts=3)
    assert not found.success
    assert_allclose(found.z, problem.guess)
    assert "3 starts (the guess, and 2 drawn by seed 0): no optimum; 3 ended with gave up" in found.notes[-1]


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"starts": 0}, "starts = 0: give a whole number, 1 or more"),
        ({"starts": "many"}, "starts = 'many': give a whole number, 1 or more"),
        ({"starts": 2.5}, "starts = 2.5: give a whole number, 1 or more"),
        ({"seed": -1}, "seed = -1: give a whole number, 0 or more"),
    ],
)
def test_what_is_no_number_of_starts_is_told(problem: Collocation, given: dict[str, object], said: str) -> None:
    with pytest.raises(SimulateError, match=said):
        problem.solve(**given)
