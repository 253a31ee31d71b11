"""One gain more left free, seen from a fit without it, beside the fit itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from simulated_logs import DRIVEN

from symdyn.identification import Identification, gain_doubts, identify, identify_logs
from symdyn.identification.gain_doubts import bounds, steps
from symdyn.identification.gains import Gains
from symdyn.identification.regression import Rows, solve

TERMS = ("viscous", "coulomb")
EACH = 60


def rows(said: tuple[float, ...], noise: float = 0.05, dependent: bool = False) -> Rows:
    """Return rows of three drives and five columns, and what is known; one gain may be wrong by a factor."""
    draw = np.random.default_rng(3)
    count, joint = EACH * len(said), np.repeat(np.arange(len(said)), EACH)
    Y = draw.normal(size=(count, 6)) * np.array([1, 1, 1, 1, 1, 0.5])
    Y[joint == 0, 1:3] = 0.0  # columns that a drive does not feel
    Y[joint == 2, :1] = 0.0
    if dependent:
        Y[:, 4] = Y[:, 3]
    shown = (Y @ np.array([2.0, -1.0, 0.5, 0.3, 0.2, 1.0]) + noise * draw.normal(size=count)) * np.array(said)[joint]
    group = np.tile(np.arange(EACH), len(said))
    return Rows(Y, shown, joint, group / EACH, group)


@pytest.mark.parametrize("dependent", [False, True])
@pytest.mark.parametrize("said", [(1.0, 1.0, 1.0), (1.0, 2.5, 1.0), (-0.2, 1.0, 1.0)])
@pytest.mark.parametrize("last", [EACH, 3], ids=["many", "fewer rows than columns"])
def test_a_bound_is_what_the_best_of_all_gains_leaves(said: tuple[float, ...], last: int, dependent: bool) -> None:
    seen = rows(said, dependent=dependent)
    of = slice(2 * EACH + last)
    seen = Rows(seen.Y[of], seen.tau[of], seen.joint[of], seen.frequency[of], seen.group[of])
    size = np.array([np.linalg.norm(seen.tau[seen.joint == j]) for j in range(3)])[seen.joint]

    found = bounds(seen, (0, 1, 2), ())

    for j in range(3):

        def left(u: float, j: int = j) -> float:
            turned = np.where(seen.joint == j, u, 1.0)
            A, b = seen.Y[:, :-1] * (turned / size)[:, None], (seen.tau - turned * seen.Y[:, -1]) / size
            off = A @ np.linalg.lstsq(A, b, rcond=None)[0] - b
            return float(off @ off)

        near = np.concatenate([np.linspace(-4, 4, 401), [said[j]]])
        least = min(near, key=left)
        fine = float(minimize_scalar(left, bounds=(least - 0.02, least + 0.02), method="bounded").fun)
        assert found[j] == pytest.approx(fine, rel=1e-6)


def test_no_gain_is_too_large_for_a_bound() -> None:
    """What the second drive shows is known, so that a column that both feel is nothing, and then no gain is enough."""
    column, known = np.random.default_rng(3).normal(size=(2, EACH))
    joint, none = np.repeat([0, 1], EACH), np.zeros(EACH)
    Y = np.column_stack([np.tile(column, 2), np.concatenate([none, known])])
    seen = Rows(Y, np.concatenate([column, known]), joint, np.zeros(2 * EACH), np.tile(np.arange(EACH), 2))

    assert bounds(seen, (0,), ())[0] < 1e-6


def test_a_drive_whose_gain_is_free_anyway_bounds_nothing() -> None:
    seen = rows((1.0, 1.0, 4.0))

    assert bounds(seen, (0,), (2,))[0] < bounds(seen, (0,), ())[0] / 10


@pytest.mark.parametrize("dependent", [False, True])
def test_a_step_is_that_of_the_regression_with_one_column_more(dependent: bool) -> None:
    seen = rows((1.0, 1.1, 1.0), dependent=dependent)
    values = np.ones(3)
    plain = solve([*"abcde"], Gains({}, values, np.zeros(5)).linear(seen), np.zeros(5), 1.0, 3)

    found = steps(seen, plain, (0, 1, 2))

    for j, step in found.items():
        more = Gains({j: "A"}, values, plain.estimate).linear(seen)
        A, b = more.Y * plain.weights[:, None], more.tau * plain.weights
        gain = np.linalg.lstsq(A, b, rcond=1e-10)[0][-1]
        assert 1 + step.size == pytest.approx(gain, abs=1e-9)
        assert step.error == pytest.approx(np.sqrt(np.linalg.pinv(A.T @ A, rcond=1e-10)[-1, -1]), rel=1e-6)


def test_a_gain_that_nothing_tells_has_no_step() -> None:
    seen = rows((1.0, 1.0, 1.0))
    alone = Rows(np.where(seen.joint[:, None] == 0, seen.Y, 0.0), seen.tau, seen.joint, seen.frequency, seen.group)
    alone.Y[seen.joint == 1, 3] = alone.Y[seen.joint == 1, -1] = 0.0
    alone.Y[seen.joint == 1, 1] = 1.0  # one column, which no other drive feels
    plain = solve([*"abcde"], Gains({}, np.ones(3), np.zeros(5)).linear(alone), np.zeros(5), 1.0, 3)

    assert steps(alone, plain, (1,))[1].error == np.inf


@pytest.fixture
def fits(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Return a list that grows by one with each fit."""
    found, once = [], identify_logs.fitted

    def counted(*given: Any) -> Any:
        found.append(given)
        return once(*given)

    monkeypatch.setattr(identify_logs, "fitted", counted)
    return found


def said_of(arm: str, wrong: int | None, loaded: bool) -> Identification:
    """Return what is found where all gains are said, one of them at 0.6 of what it is."""
    driven = DRIVEN[arm]
    said = [k * (0.6 if j == wrong else 1.0) for j, k in enumerate(driven.gains)]
    units = {name: f"{k!r}*A" for name, k in zip(driven.units, said, strict=True)}
    logs, payloads = (driven.logs(3), driven.given) if loaded else (driven.logs(3)[:1], ())
    return identify(driven.arm.scene, logs, friction=TERMS, units=units, payloads=payloads)


@pytest.mark.wide(2)
@pytest.mark.runs("cc")
@pytest.mark.parametrize("wrong", [None, 0])
@pytest.mark.parametrize(
    ("arm", "loaded"),
    [
        ("two_link", True),
        ("two_link", False),
        *(pytest.param("puma560", loaded, marks=pytest.mark.slow) for loaded in (True, False)),
    ],
)
def test_a_verdict_is_that_of_all_gains_fitted_again(
    arm: str, loaded: bool, wrong: int | None, fits: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    few, count = said_of(arm, wrong, loaded), len(fits)
    monkeypatch.setattr(gain_doubts, "_in_doubt", lambda drives, *_: [(j, 0.0) for j in drives])
    every = said_of(arm, wrong, loaded)

    assert few.notes == every.notes
    assert any(" fit" in note for note in few.notes) is (wrong is not None)
    assert count - 1 < len(DRIVEN[arm].gains) + (wrong is not None)
    assert len(fits) - count == 1 + len(DRIVEN[arm].gains)


@pytest.mark.heavy("None-1")
@pytest.mark.runs("cc")
@pytest.mark.long
@pytest.mark.parametrize(("wrong", "count"), [(None, 1), (2, 2)])
def test_of_six_gains_none_that_fits_is_fitted_again(wrong: int | None, count: int, fits: list[Any]) -> None:
    """Each was: six fits more, and up to fifteen times the time."""
    found = said_of("puma560", wrong, True)

    assert len(fits) == count
    doubted = [note for note in found.notes if " fit" in note]
    assert len(doubted) == count - 1
    assert all(note.startswith("gain tau3=0.858*A does not fit: left free, tau3 is 1.43") for note in doubted)


@pytest.mark.runs("cc")
@pytest.mark.long
def test_gains_of_a_wrist_that_the_data_do_not_tell_are_not_blamed() -> None:
    """Without a payload fits went far away: "left free, tau4 is -0.33", and all gains were right."""
    driven = DRIVEN["puma560"]
    units = {name: f"{k!r}*A" for name, k in zip(driven.units, driven.gains, strict=True)}

    found = identify(driven.arm.scene, driven.logs(2)[0], friction=TERMS, units=units)

    assert not [note for note in found.notes if " fit" in note]
