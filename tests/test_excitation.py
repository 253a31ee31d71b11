"""Exciting motions: well conditioned, within every limit between samples too, at rest at both ends, the same again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import IdentifyError
from symdyn.identification import Excitation, excite
from symdyn.identification.excitation import CRITERIA, FAMILIES
from symdyn.notebook import bundle

pytestmark = pytest.mark.runs("cc")

EXAMPLES = Path(__file__).parent.parent / "examples"

TWO_LINK: dict[str, Any] = {"values": {"m1": 1, "m2": 1, "h1": 1, "h2": 1, "g": 9.81}, "period": 5, "terms": 4}

BOX = {"M1": (-24, 24), "tool.y": (None, 0.5), "q1": (-1, 1), "q2_ddot": (-3, 3)}


def two_link(**more: Any) -> Excitation:
    return excite(symdyn.example("two_link"), **(TWO_LINK | {"starts": 1, "every": 0.02} | more))


def inside(found: Excitation, low: float, high: float, values: np.ndarray[Any, Any]) -> bool:
    return bool(values.min() >= low and values.max() <= high)


@pytest.mark.parametrize("family", FAMILIES)
def test_derivatives_of_a_family_are_those_of_its_positions(family: str) -> None:
    t, h = np.linspace(0.0, 3.0, 61), 1e-5
    one, ahead, behind = (FAMILIES[family].basis(at, 3.0, 4) for at in (t, t + h, t - h))

    assert np.allclose((ahead.position - behind.position) / (2 * h), one.rate, atol=1e-7)
    assert np.allclose((ahead.rate - behind.rate) / (2 * h), one.second, atol=1e-6)
    assert np.allclose(one.position[0], one.position[-1], atol=1e-12)
    assert np.abs(np.vstack([one.rate[[0, -1]], one.second[[0, -1]]])).max() < 1e-9
    assert np.linalg.matrix_rank(one.position) == one.count


@pytest.mark.parametrize("name", CRITERIA)
def test_the_slope_of_a_criterion_is_that_of_its_value(name: str) -> None:
    random, h = np.random.default_rng(3), 1e-6
    A, D = random.standard_normal((2, 7, 3, 5))
    value, slope = CRITERIA[name].slope(A)
    by_steps = (CRITERIA[name].slope(A + h * D)[0] - CRITERIA[name].slope(A - h * D)[0]) / (2 * h)

    assert by_steps == pytest.approx(float((slope * D).sum()), rel=1e-6)
    if name == "condition":
        sizes = np.linalg.svd(A.reshape(-1, 5), compute_uv=False)
        assert np.log(sizes[0] / sizes[-1]) <= value <= np.log(sizes[0] / sizes[-1]) + np.log(5) / 8


@pytest.mark.parametrize("family", FAMILIES)
def test_a_motion_keeps_its_limits_between_samples_and_goes_to_some(family: str) -> None:
    found = two_link(family=family, box=BOX, every=0.001)
    place = symdyn.lambdify(found.scene, "pose:tool")(found.q)[:, 1, 3]

    assert inside(found, -24, 24, found.tau[:, 0])
    assert inside(found, -np.inf, 0.5, place)
    assert inside(found, -1, 1, found.q[:, 0])
    assert inside(found, -3, 3, found.qdd[:, 1])
    assert found.margin > 0
    assert found.active


def test_it_is_better_than_what_was_drawn_and_tells_the_condition_number_of_its_rows() -> None:
    found = two_link()
    Y = symdyn.lambdify(found.scene, "base_regressor")(found.q[:-1], found.qd[:-1], found.qdd[:-1])
    condition = np.linalg.cond(Y.reshape(-1, Y.shape[-1]))

    assert all(one.after < one.before for one in found.starts)
    assert found.condition == pytest.approx(condition, rel=1e-6)
    assert found.condition == pytest.approx(found.starts[0].after, rel=0.05)


def test_the_same_seed_is_the_same_motion_and_another_is_another() -> None:
    assert two_link().to_csv() == two_link().to_csv()
    assert two_link().to_csv() != two_link(seed=1).to_csv()


def test_it_is_at_rest_at_both_ends_and_rates_are_those_of_its_positions() -> None:
    found = two_link(every=0.001)
    ends = np.vstack([found.qd[[0, -1]], found.qdd[[0, -1]]])

    assert np.abs(ends).max() < 1e-9
    assert np.allclose(np.gradient(found.q, found.t, axis=0, edge_order=2), found.qd, atol=1e-4)


def test_inverse_reads_what_it_writes_and_finds_the_same_forces(tmp_path: Path) -> None:
    found = two_link()
    found.to_csv(tmp_path / "motion.csv")
    run = symdyn.inverse(found.scene, [str(tmp_path / "motion.csv")], found.t)

    assert np.allclose(run.tau, found.tau, atol=1e-9)


def test_noise_of_drives_weighs_their_rows() -> None:
    found = two_link(noise={"M1": 100.0, "M2": 0.01})
    Y = symdyn.lambdify(found.scene, "base_regressor")(found.q[:-1], found.qd[:-1], found.qdd[:-1])
    A = (Y / np.array([100.0, 0.01])[:, None]).reshape(-1, Y.shape[-1])

    assert found.condition == pytest.approx(np.linalg.cond(A), rel=1e-6)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"box": ["tool.x=0.."], "family": "cosines"}, ["'cosines'", "fourier"]),
        ({"box": ["q3=-1..1", "q1=1", "q2=2..1"]}, ["q3 is nothing", "name=low..high", "leave no range"]),
        ({"box": {"q1_dot": (1, 2), "q2": 3}}, ["do not let it rest", "is no pair"]),
        ({"box": {"q1": (float("nan"), 2)}}, ["nan is no limit"]),
        ({"noise": {"M3": 1}, "starts": 0, "every": 9}, ["M3 is no drive", "starts", "every"]),
        ({"values": {"m1": 1}}, ["m2, h1, h2, g have no value"]),
        ({"box": {"M1": (-3, 3), "q1": (1, 1.2), "q2": (-0.1, 0.1)}}, ["no motion was found", "M1 goes from"]),
    ],
)
def test_what_cannot_be_is_told_in_words_all_of_it(arguments: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(IdentifyError) as fault:
        two_link(**arguments)
    for one in words:
        assert one in str(fault.value)


@pytest.mark.parametrize(
    ("name", "words"), [("four_bar", "loops"), ("cart_pole", "without a drive"), ("free_body", "locked = true")]
)
def test_scenes_that_cannot_be_moved_freely_are_refused_with_the_way_out(name: str, words: str) -> None:
    with pytest.raises(IdentifyError, match=words):
        excite(symdyn.example(name))


@pytest.mark.slow
@pytest.mark.wide("puma560")
@pytest.mark.long
@pytest.mark.parametrize("name", ["puma560", "arm7"])
def test_arms_of_six_and_seven_axes_get_condition_numbers_below_fifteen_within_limits(name: str) -> None:
    found = excite(symdyn.example(name), starts=1)

    assert found.condition < 15
    assert found.margin > 0


def command(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    status = main(["identify", str(EXAMPLES / "two_link.toml"), *words, "--bind", "m1=1,m2=1,h1=1,h2=1,g=9.81"])
    return status, *capsys.readouterr()


def test_the_verb_writes_a_motion_that_inverse_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tmp_path / "motion.csv")
    words = ["--period", "4", "--starts", "1", "--every", "0.1", "--box", "M1=-30..30", "-o", path]
    status, out, err = command(capsys, "--excite", *words)
    run = symdyn.inverse(two_link().scene, [path], np.linspace(0, 4, 41))

    assert status == 0
    assert "condition number" in out
    assert "no limits are known" in err
    assert np.abs(run.tau[:, 0]).max() < 30


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--box", "q1=2..3"], "--box: of --excite"),
        (["log.csv", "--excite"], "log.csv would be the log of one"),
        (["--excite", "--plot", "motion.txt"], "motion.txt"),
        (["--excite", "-o", "motion.toml"], "motion.toml"),
        (["--excite", "--noise", "M1"], '"M1" is not name=formula'),
        (["--excite", "--noise", "M1=much"], "M1=much is no number"),
        (["--excite", "--box", "q1=2", "--noise", "M3=1"], "is no box"),
    ],
)
def test_the_verb_tells_what_cannot_be(words: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = command(capsys, *words)

    assert (status, out) == (1, "")
    assert told in err


def test_a_notebook_shows_how_well_it_tells_and_what_it_reaches() -> None:
    html = bundle(two_link(box={"M1": (-24, 24)}))["text/html"]

    assert "condition number" in html
    assert "M1" in html
    assert "reached" in html
