"""Values at the ends of what a double holds: told in words, or linearised."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import block_diag

import symdyn
import symdyn.scene as declared
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


FREE, FREE_SAMPLED = [[0.0, 1.0], [0.0, 0.0]], [[1.0, 0.1], [0.0, 1.0]]


def swinging(pole: complex) -> list[list[float]]:
    return [[0.0, 1.0], [-(abs(pole) ** 2), 2 * pole.real]]


def turning(pole: complex) -> list[list[float]]:
    return [[pole.real, pole.imag], [-pole.imag, pole.real]]


KNOWN = {
    "swings": ([swinging(-0.2 + 2j)], None, "asymptotically stable"),
    "without damping": ([swinging(3j), swinging(3j), swinging(5j)], None, "marginally stable"),
    "a free cart": ([FREE, swinging(-0.2 + 2j)], None, "marginally stable"),
    "a free cart beside what is fast": ([FREE, swinging(-10 + 1e6j)], None, "marginally stable"),
    "fast and slow": ([[[-1e6]], [[-1e-4]]], None, "asymptotically stable"),
    "fast and slow swings": ([swinging(-10 + 1e6j), swinging(-0.01 + 0.1j)], None, "asymptotically stable"),
    "slow without damping": ([swinging(-10 + 1e6j), swinging(0.1j)], None, "marginally stable"),
    "slow and growing": ([swinging(1e6j), swinging(1e-3 + 0.1j)], None, "unstable"),
    "sampled": ([turning(0.9 + 0.3j), [[0.5]]], 0.1, "asymptotically stable"),
    "sampled and slow": ([[[1 - 1e-10]], [[0.5]]], 0.1, "asymptotically stable"),
    "sampled, on the edge": ([turning(0.6 + 0.8j), [[0.3]]], 0.1, "marginally stable"),
    "sampled and free": ([FREE_SAMPLED, [[0.5]]], 0.1, "marginally stable"),
    "sampled, slow and growing": ([[[1 + 1e-10]], [[0.5]]], 0.1, "unstable"),
}


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("seed", [None, 0, 1, 2])
def test_units_of_states_over_twelve_decades_change_no_pole_and_no_verdict(name: str, seed: int | None) -> None:
    """Of 1e-6 and 1e6 a swinging mass drifted, and what decays in hours beside a fast spring stayed for ever."""
    blocks, period, verdict = KNOWN[name]
    A, poles = block_diag(*blocks), np.concatenate([np.linalg.eigvals(one) for one in blocks])
    n = len(A)
    decades = [0.0] * n if seed is None else np.random.default_rng(seed).uniform(-6, 6, n)
    d = 2.0 ** np.round(np.log2(10) * np.asarray(decades))
    B, C = np.ones((n, 1)), np.ones((1, n))
    plain, found = StateSpace(A, B, C, period=period), StateSpace(A * d / d[:, None], B / d[:, None], C * d, None)
    found = StateSpace(found.A, found.B, found.C, period=period)

    for pole in poles:
        assert np.abs(found.poles - pole).min() <= 1e-6 * abs(pole)
    assert_allclose(found.poles, plain.poles, rtol=1e-9)
    assert found.verdict.partition(":")[0] == verdict
    assert found.stable == (verdict == "asymptotically stable")
    assert_allclose(found.bode().omega[[0, -1]], plain.bode().omega[[0, -1]], rtol=1e-6)
    assert_allclose(found.step().t[-1], plain.step().t[-1], rtol=1e-6)
    ends = sum(float(np.sum(np.linalg.solve(float(bool(period)) * np.eye(len(one)) - one, np.ones(len(one)))))
               for one in blocks) if found.stable else np.nan  # fmt: skip
    assert_allclose(found.step().final[0, 0], ends, rtol=1e-5)


def test_a_milligram_on_a_stiff_spring_leaves_a_slow_mass_as_it_is() -> None:
    masses = [declared.body("light", mass=1e-6), declared.body("heavy", mass=1e3)]
    rails = [
        declared.prismatic(name, "ground", name, axis=[1, 0, 0], coordinate=q, drive=f"F_{q}", force=force)
        for name, q, force in (("light", "x", "-1e6*x - 1e-3*x_dot"), ("heavy", "y", "-1e-3*y - 1e-2*y_dot"))
    ]
    found = symdyn.linearize(declared.scene("two", gravity="none", bodies=masses, joints=rails))

    assert found.stable
    assert found.poles[0] == pytest.approx(-5e-6 + 1j * math.sqrt(1e-6 - 25e-12), rel=1e-9)
    assert found.step("y", "F_y").final[0, 0] == pytest.approx(1e3)


def test_a_call_of_several_transfer_functions_tells_which_to_call() -> None:
    one = StateSpace([[0, 1], [-4, -1]], [[0], [1]], [[1, 0]], outputs=["y"], inputs=["F"])

    with pytest.raises(LinearizeError, match=r'one of them is a function: \.transfer\("y", "F"\)\(1j\)'):
        one.transfer()(1j)
