"""Rates of coordinates from velocities: where scenes have them, and that the joint moves as they say."""

from __future__ import annotations

import pytest
from mechanisms import jointed
from running import call

from symdyn.algebra.numeric import Floats
from symdyn.dynamics import available, derive
from symdyn.program.lower import formulate
from symdyn.scene import Scene

H = 2.0**-20


def pose_after(scene: Scene, q: list[float]) -> list[float]:
    return call(derive(scene, [f"pose:{scene.bodies[-1].name}"]), f"pose_{scene.bodies[-1].name}", Floats(), q=q)


@pytest.mark.parametrize("kind", ["spherical", "free"])
@pytest.mark.parametrize("formulation", ["joints", "placements"])
def test_the_body_moves_as_its_velocities_say(kind: str, formulation: str) -> None:
    """The change of the pose along q̇ is the Jacobian times u, by central differences."""
    scene = jointed(kind)
    q = [*([0.3, -0.2, 0.5] if kind == "free" else []), 0.5, -0.1, 0.7, 0.5]
    u = [*([1.5, -0.4, 0.9] if kind == "free" else []), 0.6, -1.1, 0.8]
    rates = call(derive(scene, ["coordinate_rates"], formulation), "coordinate_rates", Floats(), q=q, qd=u)
    body = scene.bodies[-1].name
    J = call(derive(scene, [f"jacobian:{body}"]), f"jacobian_{body}", Floats(), q=q)
    twist = [sum(J[i * len(u) + k] * u[k] for k in range(len(u))) for i in range(6)]

    ahead, behind = (pose_after(scene, [x + s * H * r for x, r in zip(q, rates, strict=True)]) for s in (1, -1))
    change = [(a - b) / (2 * H) for a, b in zip(ahead, behind, strict=True)]
    T = pose_after(scene, q)
    a, b, c = twist[3:]
    spin = [[0, -c, b], [c, 0, -a], [-b, a, 0]]

    for i in range(3):
        assert change[4 * i + 3] == pytest.approx(twist[i], abs=1e-8)
        for j in range(3):
            assert change[4 * i + j] == pytest.approx(sum(spin[i][k] * T[4 * k + j] for k in range(3)), abs=1e-8)


def test_scenes_without_quaternions_have_none_unasked() -> None:
    assert "coordinate_rates" in available(jointed("revolute", "spherical"))[0]
    assert "coordinate_rates" not in available(jointed("revolute", "universal"))[0]


def test_code_never_divides_by_a_quaternion() -> None:
    (rates,) = formulate(jointed("free"), ["coordinate_rates"]).functions
    assert (rates.formulation, rates.shape) == ("joints", (7,))
