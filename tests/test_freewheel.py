"""Joints that move one way: freewheels and ratchets, their locking and running free, impulses, slopes, words."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import symdyn
from symdyn.errors import SceneError, SimulateError, SymdynError
from symdyn.scene import read_text
from symdyn.simulation import contact_checks
from symdyn.teach import rendered, walkthrough

pytestmark = pytest.mark.runs("cc")

DRUM = """
name = "drum"
[bodies.drum]
mass = 1
inertia = [2, 2, 2]
[bodies.rim]
mass = 1
inertia = [1, 1, 1]
[joints.a]
type = "revolute"
parent = "ground"
child = "drum"
coordinate = "a"
drive = "T"
[joints.b]
type = "revolute"
parent = "drum"
child = "rim"
coordinate = "b"
drive = false
limits = { one_way = true }
"""

FORCES = "T=0.5+cos(2*t)"


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_a_rim_is_carried_and_runs_ahead_as_its_closed_form_says(method: str) -> None:
    """It runs ahead where the drum is braked, and is carried again where the drum has its rate again."""
    run = symdyn.simulate(read_text(DRUM), forces=FORCES, until=4, rtol=1e-12, method=method)
    free = np.pi / 3
    locks = brentq(lambda t: np.sin(2 * t) / 2 + t / 2 - (np.sin(2 * free) / 2 + free / 2), 2.0, 3.1)

    assert [one.what for one in run.impacts] == ["runs free", "locks"]
    np.testing.assert_allclose([one.t for one in run.impacts], [free, locks], rtol=0, atol=1e-9)
    assert run["b_dot"].min() > -1e-12
    carried = run.t < free
    np.testing.assert_allclose(run["normal_b_one_way"][carried], (0.5 + np.cos(2 * run.t[carried])) / 3, atol=1e-12)
    assert np.abs(run["b_dot"][carried]).max() < 1e-15


def test_what_would_be_driven_back_by_an_impact_takes_an_impulse() -> None:
    """A stop holds the drum at once: the rim goes on. A stop of the rim's own angle holds both."""
    stop = "limits = { one_way = true, upper = 0.3, restitution = 0.5 }"
    struck = DRUM.replace(
        'coordinate = "a"', 'coordinate = "a"\nstart_rates = 1\nlimits = { upper = 0.5, restitution = 0.2 }'
    )
    both = struck.replace("limits = { one_way = true }", stop)
    ahead, back = (symdyn.simulate(read_text(text), until=0.9, rtol=1e-12) for text in (struck, both))

    assert ahead["b_dot"][-1] == pytest.approx(1.2)  # the rim keeps its rate, the drum has -0.2
    # at b = 0.3 the rim strikes, and goes back by -e: it cannot, the freewheel holds it
    hit = [one for one in back.impacts if one.contact == "b_upper"]
    assert (hit[0].before, hit[0].after) == pytest.approx((-1.2, 0), abs=1e-12)
    assert back["b_dot"].min() > -1e-12


def test_slopes_go_through_locking_and_running_free() -> None:
    """From where it runs ahead; it is carried soon, and runs ahead again from π/3 s on."""
    scene, w = read_text(DRUM), 1e-3
    asked = {"forces": FORCES, "until": 1.3}
    found = symdyn.sensitivity(scene, start_rates={"b_dot": 0.3}, parameters=(), rtol=1e-12, **asked)

    def end(step: float) -> float:
        run = symdyn.simulate(scene, start_rates={"b_dot": 0.3 + step}, rtol=1e-13, **asked)
        assert [one.what for one in run.impacts] == ["locks", "runs free"]
        return float(run["a"][-1])

    by_runs = (8 * (end(w) - end(-w)) - (end(2 * w) - end(-2 * w))) / (12 * w)
    assert abs(by_runs) > 0.1
    assert found["a", "b_dot"] == pytest.approx(by_runs, abs=1e-8)


def test_its_laws_hold_at_natural_states_and_are_proved() -> None:
    checks, _ = contact_checks(read_text(DRUM), 1)
    found = symdyn.certify(read_text(DRUM), ["delassus", "contact_dynamics", "gap_jacobian:b_one_way"])

    assert all(all(places.values()) for places in checks.values())
    assert len(checks) > 5
    assert found.passed


def test_it_is_read_printed_and_written() -> None:
    scene = read_text(DRUM)
    page = symdyn.equations(scene, formulation="contact").text()

    assert "0 <= g_dot, 0 <= lambda_n, one of them 0" in page
    assert read_text(str(symdyn.scene.write_text(scene, "toml").text)) == scene


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (
            lambda: symdyn.simulate(read_text(DRUM), start_rates={"b_dot": -1}),
            "b_one_way moves the other way, -1 rad/s",
        ),
        (lambda: read_text(DRUM.replace('"revolute"', '"spherical"')), "one_way is of a joint with one velocity"),
        (lambda: symdyn.linearize(read_text(DRUM)), "no joint that moves one way, as b; take limits.one_way out"),
        (lambda: symdyn.collocation(read_text(DRUM), until=1), "no joint that moves one way"),
        (lambda: read_text(DRUM.replace("= true", "= 3")), "one_way = 3 is neither true nor false"),
    ],
)
def test_what_is_wrong_is_told(ask, words: str) -> None:
    with pytest.raises((SceneError, SimulateError, SymdynError), match=words):
        ask()


def test_its_lesson_speaks_of_a_rate_and_of_no_gap() -> None:
    text = str(rendered(walkthrough(read_text(DRUM)), "md")["drum.md"])

    assert r"b\_one\_way: the rate that is never negative." in text
    assert r"| locked | $\dot{\delta}$ = 0 | $\lambda_n$ ≥ 0 |" in text
    assert r"\delta = 0" not in text
    assert " gap" not in text
