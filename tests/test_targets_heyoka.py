"""heyoka's expressions: what they are, what its Taylor series makes of them, what it lacks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.errors import EmitError
from symdyn.program import lower, prepare
from symdyn.runtime.runners import run_heyoka
from symdyn.scene import Scene, read, read_text

EXAMPLES = Path(__file__).parent.parent / "examples"
VALUES = {"m1": 1.0, "m2": 0.5, "h1": 0.7, "h2": 0.4, "g": 9.81}

runs = pytest.mark.targets

SLIDING = """
[bodies.block]
mass = 2
[joints.rail]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
coordinate = "x"
friction = { coulomb = 2 }
"""


def module(scene: Scene, *functions: str) -> Any:
    return run_heyoka(emit(lower(derive(scene, functions)), "heyoka")).module


def text(scene: Scene, *functions: str) -> str:
    (contents,) = emit(lower(derive(scene, functions)), "heyoka").texts.values()
    return contents


def test_dry_friction_is_refused_with_what_would_work() -> None:
    scene = read_text(SLIDING)
    with pytest.raises(EmitError, match=r"target heyoka .* lacks sign, which inverse_dynamics needs: .* smoothing"):
        emit(lower(derive(scene, ("inverse_dynamics",))), "heyoka")
    smooth = read_text(SLIDING.replace("coulomb = 2", "coulomb = 2, smoothing = 0.01"))
    assert "heyoka.tanh(" in text(smooth, "inverse_dynamics")


@pytest.mark.mends("30.robots.3")
def test_the_module_says_how_its_integrator_compiles_in_seconds() -> None:
    head, _, body = text(read(EXAMPLES / "arm7.toml"), "forward_dynamics").partition("import heyoka")

    assert "heyoka.taylor_adaptive(dynamics(), state, compact_mode=True)" in head
    assert "compact_mode=True" in body.partition("def dynamics(")[2]


def test_what_the_equations_of_motion_lack_is_said() -> None:
    assert "made of forward_dynamics: generate that too" in text(read(EXAMPLES / "two_link.toml"), "mass_matrix")
    top = read(EXAMPLES / "heavy_top.toml")
    alone = text(top, "forward_dynamics")
    assert "made of coordinate_rates: generate that too" in alone
    assert "def dynamics" not in alone
    assert "def dynamics(" in text(top, "forward_dynamics", "coordinate_rates")


@runs
def test_functions_take_expressions_and_numbers_and_return_arrays_of_expressions() -> None:
    import heyoka

    ours = module(read(EXAMPLES / "two_link.toml"), "mass_matrix", "kinetic_energy")
    p = [heyoka.par[k] for k in range(5)]
    M = ours.mass_matrix(heyoka.make_vars("q1", "q2"), p)
    assert M.shape == (2, 2)
    assert M[0, 1] == M[1, 0]
    energy = ours.kinetic_energy([0.0, 0.0], [1.0, 0.0], [1, 2, 3, 4, 9])
    assert isinstance(energy, heyoka.expression)
    assert str(energy).startswith("94.5") or float(str(energy)) > 0
    with pytest.raises(ValueError, match="q has length 3; give 2"):
        ours.mass_matrix([0.0] * 3, p)


@runs
@pytest.mark.runs
@pytest.mark.parametrize("name", ["two_link", "cart_pole", "puma560", "heavy_top"])
def test_the_taylor_series_follows_what_simulate_follows(name: str) -> None:
    """Two seconds with 1e-15, and `symdyn.simulate`, by Taylor's method of its own and by another integrator."""
    import heyoka

    scene = read(EXAMPLES / f"{name}.toml")
    values = {one.name: 0.5 + 0.25 * k for k, one in enumerate(scene.free_parameters)}
    rng = np.random.default_rng(4)
    q0 = rng.uniform(-0.5, 0.5, len(scene.coordinates))
    q0 = q0 / np.linalg.norm(q0) if name == "heavy_top" else q0
    u0 = rng.uniform(-0.5, 0.5, len(scene.velocities))
    needed = ("forward_dynamics", *(["coordinate_rates"] if len(q0) != len(u0) else []))
    ours = module(scene, *needed)
    pars = [*values.values(), *np.zeros(len(u0))]
    run = heyoka.taylor_adaptive(ours.dynamics(), [*q0, *u0], pars=pars)
    run.propagate_until(2.0)

    start = dict(zip(scene.coordinates, q0, strict=True))
    rates = dict(zip(scene.velocities, u0, strict=True))
    for method, close in (("taylor", 1e-12), ("dop853", 1e-9)):
        motion = symdyn.simulate(
            scene, until=2.0, start=start, start_rates=rates, values=values, method=method, rtol=close / 10
        )
        end = np.concatenate([motion.q[-1], motion.qd[-1]])
        np.testing.assert_allclose(run.state, end, rtol=0, atol=30 * close * max(1.0, np.abs(end).max()))


@runs
def test_forces_are_laws_numbers_or_parameters_of_a_run() -> None:
    """A pendulum held upright by a law of its state; the same force as a parameter; parameters prepared."""
    import heyoka

    scene = read(EXAMPLES / "two_link.toml")
    ours = module(scene, "forward_dynamics", "inverse_dynamics")
    q, qd = heyoka.make_vars("q1", "q2"), heyoka.make_vars("q1_dot", "q2_dot")
    p = [*VALUES.values()]
    wanted = [-4 * a - 4 * b for a, b in zip(q, qd, strict=True)]
    law = ours.inverse_dynamics(q, qd, wanted, p)
    run = heyoka.taylor_adaptive(ours.dynamics(params=p, tau=law), [0.5, -0.3, 0.0, 0.0])
    run.propagate_until(3.0)
    t = 3.0
    decayed = np.exp(-2 * t) * (1 + 2 * t)
    np.testing.assert_allclose(run.state[:2], np.array([0.5, -0.3]) * decayed, atol=1e-12)

    open_ = heyoka.taylor_adaptive(ours.dynamics(), [0.5, -0.3, 0, 0], pars=[*p, 0.0, 0.0])
    still = [float(x) for x in run_heyoka(emit(lower(derive(scene, ["inverse_dynamics"])), "heyoka")).inverse_dynamics(
        [0.5, -0.3], [0, 0], [0, 0], p)]  # fmt: skip
    open_.pars[5:] = still
    open_.propagate_until(1.0)
    np.testing.assert_allclose(open_.state, [0.5, -0.3, 0, 0], atol=1e-9)


@runs
def test_prepared_parameters_are_parameters_of_a_run_too() -> None:
    import heyoka

    scene = read(EXAMPLES / "two_link.toml")
    made = run_heyoka(emit(prepare(lower(derive(scene, ["forward_dynamics"]))), "heyoka"))
    prepared = made.prepare([*VALUES.values()])
    plain = module(scene, "forward_dynamics")
    state = [0.3, 0.2, 0.1, -0.4]
    one = heyoka.taylor_adaptive(made.module.dynamics(), state, pars=[*prepared, 0.0, 0.0])
    other = heyoka.taylor_adaptive(plain.dynamics(tau=[0.0, 0.0]), state, pars=[*VALUES.values()])
    one.propagate_until(2.0)
    other.propagate_until(2.0)
    np.testing.assert_allclose(one.state, other.state, atol=1e-12)
