"""Values at the ends of what a double holds: told in words, or linearised."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import LinearizeError, SimulateError, SymdynError
from symdyn.linear import StateSpace
from symdyn.scene import Scene

LARGEST = 1.797e308

CART = str(Path(__file__).parent.parent / "examples" / "cart_pole.toml")


@pytest.mark.mends("30.attacks.6")
def test_a_place_as_far_as_doubles_go_is_linearised(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["linearize", CART, "--start", "x=1e308"]) == 0
    assert "5.61664" in capsys.readouterr().out


@pytest.mark.mends("30.attacks.6")
def test_a_weight_beyond_all_numbers_is_told_in_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["linearize", CART, "--bind", f"g={LARGEST}"]) == 1
    told = capsys.readouterr().err
    assert told == "symdyn: cart_pole: a derivative has no finite value there; give another place, or other values\n"


SLIDE = """
[joints.{0}]
type = "prismatic"
parent = "{1}"
child = "{2}"
axis = [1, 0, 0]
coordinate = "{0}"
force = "{3}"
"""


def test_rounding_beside_what_swings_fast_is_printed_as_zero(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bodies = "[bodies.a]\nmass = 1\n[bodies.b]\nmass = 2\n"
    slides = SLIDE.format("x", "ground", "a", "1e8*(y - 2.3*x)") + SLIDE.format("y", "a", "b", "1e8*(x - 1.7*y)")
    (tmp_path / "two.toml").write_text(bodies + slides)

    assert main(["linearize", str(tmp_path / "two.toml")]) == 0
    told = capsys.readouterr().out
    assert "\n0 ± 4684.43 i " in told
    assert "\n0 ± 25749.9 i " in told


@pytest.mark.mends("30.attacks.8.t")
@pytest.mark.parametrize("t", [math.nan, math.inf, -math.inf])
def test_a_time_that_is_none_is_refused(t: float) -> None:
    with pytest.raises(SimulateError, match=f"t = {t}: give a finite time, s"):
        symdyn.linearize(symdyn.example("cart_pole"), t=t)


def asked(scene: Scene) -> list[dict[str, object]]:
    found: list[dict[str, object]] = []
    for x in (-LARGEST, 1e-320):
        found += [{"values": {one.name: x}} for one in scene.parameters]
        found += [{"start": {name: repr(x)}} for name in scene.coordinates]
        found += [{"start_rates": {name: repr(x)}} for name in scene.velocities]
    return found


@pytest.mark.long
@pytest.mark.parametrize("name", ["cart_pole", "slider_crank"])
def test_what_is_too_large_or_too_small_never_ends_in_a_traceback(name: str) -> None:
    scene = symdyn.example(name)
    for one in asked(scene):
        try:
            with np.errstate(all="ignore"):
                found = symdyn.linearize(scene, anywhere=True, **one)  # type: ignore[arg-type]
                assert np.isfinite(found.A).all()
                assert len(found.poles) == len(found.states)
        except SymdynError:
            continue  # in words


def test_a_call_of_several_transfer_functions_tells_which_to_call() -> None:
    one = StateSpace([[0, 1], [-4, -1]], [[0], [1]], [[1, 0]], outputs=["y"], inputs=["F"])

    with pytest.raises(LinearizeError, match=r'one of them is a function: \.transfer\("y", "F"\)\(s\)'):
        one.transfer()(1j)


def test_two_free_masses_with_a_spring_and_a_damper_drift() -> None:
    """Two zeros, told by rounding of a turned matrix, are no slow growth."""
    m, n, k, c = 1.88, 0.35, 1.8, 0.0134
    rows = [[0, 0, 1, 0], [0, 0, 0, 1], [-k / m, k / m, -c / m, c / m], [k / n, -k / n, c / n, -c / n]]

    one = StateSpace(rows, [[0], [0], [1 / m], [0]], [[1, 0, 0, 0]])

    assert one.verdict.startswith("marginally stable")
    assert sorted(np.abs(one.poles))[:2] == [0, 0]
