"""What would be too many lines is refused in words before it is begun, by a size that is about right."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from arms import turning_chain as chain

from symdyn.cli import main
from symdyn.dynamics import Workspace, available, derive, derive_one
from symdyn.dynamics.outputs import Counts
from symdyn.errors import DerivationError

PUMA = Path(__file__).parent.parent / "examples" / "puma560.toml"

SIMPLER = ("inverse_dynamics_hessian", "gravity_forces_by_q", "coriolis_matrix")
"""Of a plane chain these are much shorter than what is counted on."""

REQUESTS = ("inverse_dynamics", "mass_matrix", "inverse_dynamics_derivatives", "forward_dynamics_derivatives")


@pytest.mark.wide("8-requests0-plane", "32-requests2-any")
@pytest.mark.long(0)
@pytest.mark.parametrize("kind", ["any", "plane", "tree"])
@pytest.mark.parametrize(
    ("n", "requests"),
    [
        (
            8,
            (
                *REQUESTS,
                "coriolis_matrix",
                "inverse_dynamics_jvp",
                "gravity_forces_by_q",
                "regressor",
                "inverse_dynamics_hessian",
            ),
        ),
        (16, (*REQUESTS[:3], "forward_dynamics_by_tau", "inverse_dynamics_vjp")),
        (32, REQUESTS[:3]),
        pytest.param(32, REQUESTS[3:], marks=pytest.mark.slow),
    ],
)
def test_a_size_that_is_told_beforehand_is_counted_within_a_factor_of_two(
    n: int, requests: tuple[str, ...], kind: str
) -> None:
    from symdyn.dynamics.outputs.requests import expected_size, simplicity

    scene = chain(n, kind)
    for request in requests:
        workspace = Workspace(scene)
        told = expected_size(workspace, request, simplicity(workspace))
        counted = Counts.of(derive_one(workspace, request)).cost

        assert 0.5 < told / counted < (5 if kind == "plane" and request in SIMPLER else 2), request


@pytest.mark.mends("30.robots.4")
def test_derivatives_of_a_long_chain_are_refused_in_lines_when_they_are_asked_for() -> None:
    with pytest.raises(DerivationError, match=r"some \d,\d00,000 operations.*ask for inverse_dynamics_jvp or"):
        derive(chain(256), ["inverse_dynamics_derivatives"])


@pytest.mark.slow
def test_what_is_asked_for_instead_can_be_had() -> None:
    scene = chain(160)
    with pytest.raises(DerivationError, match="operations") as caught:
        derive(scene, ["inverse_dynamics_derivatives"])
    ways = re.search(r"ask for ([^;]*);", str(caught.value))

    assert ways is not None
    for way in ways[1].split(" or "):
        assert len(derive(scene, [way]).functions) == 1 if way.endswith("_jvp") else "_by_" in way or "_vjp" in way


def test_derivatives_of_64_joints_are_not_too_many() -> None:
    from symdyn.dynamics.outputs.requests import too_large

    workspace = Workspace(chain(64))

    assert [too_large(workspace, request) for request in REQUESTS] == [""] * 4


def test_what_nobody_asked_for_is_left_out_with_the_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symdyn.dynamics.outputs.requests.PLENTY", 10_000)
    outputs, left_out = available(chain(20))

    assert "inverse_dynamics" in outputs
    assert "mass_matrix" not in outputs
    assert any("mass_matrix would take some" in reason for reason in left_out)


@pytest.mark.long(0)
def test_a_chain_in_a_plane_is_simpler_and_may_be_longer() -> None:
    from symdyn.dynamics.outputs.requests import too_large

    request = "inverse_dynamics_derivatives"

    assert too_large(Workspace(chain(200)), request)
    assert not too_large(Workspace(chain(200, "plane")), request)


def test_the_shell_says_it_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("symdyn.dynamics.outputs.requests.PLENTY", 100)

    assert main(["generate", str(PUMA), "--functions", "mass_matrix", "-o", str(tmp_path)]) == 1
    assert "puma560: mass_matrix would take some" in capsys.readouterr().err
