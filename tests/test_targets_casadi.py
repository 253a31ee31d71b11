"""Functions of CasADi: what they compute, by what they are differentiated, what is saved; an optimum found by them."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from formulas import argument, every_op, function, states

import symdyn
from symdyn.dynamics import derive
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import emit, write
from symdyn.emit.targets.casadi_modules import EXTERNAL, JacobianBlock, jacobians
from symdyn.graph import Graph
from symdyn.program import lower
from symdyn.runtime.runners import run_casadi
from symdyn.scene import Scene, read

EXAMPLES = Path(__file__).parent.parent / "examples"
DYNAMICS = ("inverse_dynamics", "forward_dynamics")
SCENES = ("pendulum", "two_link", "cart_pole", "puma560", "four_bar", "slider_crank", "heavy_top", "rolling_disc")

runs = pytest.mark.targets


def made(scene: str, *functions: str) -> Any:
    """Return the sources of functions of an example, those that it lacks left out."""
    return emit(lower(derive(read(EXAMPLES / f"{scene}.toml"), functions)), "casadi")


def module(scene: str, *functions: str) -> Any:
    return run_casadi(made(scene, *functions)).module


def with_derivatives(scene: str) -> list[str]:
    """Return the dynamics that a scene has, and their derivatives."""
    found = []
    for name in DYNAMICS:
        try:
            derive(read(EXAMPLES / f"{scene}.toml"), (name, f"{name}_derivatives"))
        except symdyn.DerivationError:
            continue
        found += [name, f"{name}_derivatives"]
    return found


def drawn(function: Any, seed: int = 3) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.uniform(0.3, 1.2, function.numel_in(i)) for i in range(function.n_in())]


def test_whole_derivatives_are_blocks_of_the_jacobian_and_single_ones_fill_what_is_missing() -> None:
    asked = ("inverse_dynamics", "inverse_dynamics_derivatives", "inverse_dynamics_by_parameters",
             "kinetic_energy", "kinetic_energy_by_qd", "pose:tool")  # fmt: skip
    program = lower(derive(read(EXAMPLES / "two_link.toml"), asked))
    whole = "inverse_dynamics_derivatives"

    assert jacobians(program, frozenset()) == {
        "inverse_dynamics": {
            "q": JacobianBlock(whole, 0, 2),
            "qd": JacobianBlock(whole, 2, 4),
            "qdd": JacobianBlock(whole, 4, 6),
            "params": JacobianBlock("inverse_dynamics_by_parameters", 0, 5),
        },
        "kinetic_energy": {"qd": JacobianBlock("kinetic_energy_by_qd", 0, 2)},
    }


@pytest.mark.long
@pytest.mark.parametrize("scene", ["heavy_top", "rolling_disc", "four_bar"])
def test_derivatives_that_are_none_by_the_coordinates_are_no_jacobian(scene: str) -> None:
    asked = ("forward_dynamics", "forward_dynamics_derivatives", "forward_dynamics_by_q", "forward_dynamics_by_qd")
    found = jacobians(lower(derive(read(EXAMPLES / f"{scene}.toml"), asked)), frozenset())

    blocks = found.get("forward_dynamics", {})
    assert "q" not in blocks
    assert all(block.function != "forward_dynamics_derivatives" for block in blocks.values())


@runs
@pytest.mark.parametrize("scene", SCENES)
def test_our_jacobian_is_what_casadi_differentiates_and_what_differences_say(scene: str) -> None:
    import casadi

    names = with_derivatives(scene)
    ours = module(scene, *names)
    for name in names[::2]:
        f = ours.functions[name]
        given = drawn(f)
        symbols = [casadi.SX.sym(f"x{i}", f.numel_in(i)) for i in range(f.n_in())]
        exact = casadi.Function("exact", symbols, [casadi.jacobian(f(*symbols), x) for x in symbols])(*given)
        found = f.jacobian()(*given, 0)
        found = found if isinstance(found, tuple) else (found,)
        step = 1e-6
        for i, (own, casadis) in enumerate(zip(found, exact, strict=True)):
            size = max(1.0, float(np.abs(casadis.full()).max(initial=0)))
            assert np.abs(own.full() - casadis.full()).max(initial=0) <= 1e-9 * size, (name, i)
            assert own.sparsity().nnz() <= casadis.sparsity().nnz() or own.shape == casadis.shape
            for k in range(f.numel_in(i)):
                moved = [[x.copy() for x in given] for _ in range(2)]
                moved[0][i][k] += step
                moved[1][i][k] -= step
                slope = (f(*moved[0]) - f(*moved[1])).full()[:, 0] / (2 * step)
                assert np.abs(own.full()[:, k] - slope).max() <= 1e-5 * size, (name, i, k)


@runs
def test_what_calls_with_mx_takes_our_jacobian_and_what_calls_with_sx_is_differentiated() -> None:
    import casadi

    f = module("puma560", *with_derivatives("puma560")).functions["inverse_dynamics"]
    x = [casadi.MX.sym(f"x{i}", f.numel_in(i)) for i in range(f.n_in())]
    J = casadi.jacobian(f(*x), x[0])
    assert "jac_inverse_dynamics" in str(J)

    stage = casadi.Function("stage", x, [f(*x)]).map(3)
    many = [casadi.MX.sym(f"y{i}", f.numel_in(i), 3) for i in range(f.n_in())]
    whole = casadi.Function("whole", many, [casadi.jacobian(casadi.vec(stage(*many)), casadi.vec(many[0]))])
    given = [np.tile(one[:, None], 3) for one in drawn(f)]
    one = casadi.Function("J", x, [J])(*drawn(f)).full()
    np.testing.assert_allclose(whole(*given).full(), np.kron(np.eye(3), one), rtol=1e-12, atol=1e-12)


@runs
def test_columns_are_states_and_one_column_is_for_all_of_them() -> None:
    import casadi

    ours = module("two_link", "mass_matrix")
    q = np.random.default_rng(1).normal(size=(2, 5))
    p = np.arange(1.0, 6.0)
    side_by_side = ours.mass_matrix(q, p)
    assert side_by_side.shape == (2, 10)
    for k in range(5):
        assert np.array_equal(side_by_side[:, 2 * k : 2 * k + 2].full(), ours.mass_matrix(q[:, k], p).full())
    mapped = ours.functions["mass_matrix"].map(5)(q, casadi.repmat(p, 1, 5))
    assert np.array_equal(mapped.full(), side_by_side.full())
    assert ours.functions["mass_matrix"].name_in() == ["q", "params"]
    assert ours.functions["mass_matrix"].name_out() == ["M"]


@runs
@pytest.mark.runs
def test_the_module_alone_writes_files_that_casadi_loads_with_their_jacobians(tmp_path: Path) -> None:
    import casadi

    names = with_derivatives("two_link")
    (path,) = write(made("two_link", *names), tmp_path)
    away = [sys.executable, "-P", "-W", "error", path.name, "saved"]
    done = subprocess.run(away, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [f"saved/{name}.casadi" for name in names]

    for name in names[::2]:
        loaded = casadi.Function.load(str(tmp_path / "saved" / f"{name}.casadi"))
        fresh = module("two_link", *names).functions[name]
        given = drawn(fresh)
        assert np.array_equal(loaded(*given).full(), fresh(*given).full())
        assert loaded.jacobian().name() == f"jac_{name}"
        for one, other in zip(loaded.jacobian()(*given, 0), fresh.jacobian()(*given, 0), strict=True):
            assert np.array_equal(one.full(), other.full())


@runs
def test_three_dimensions_are_blocks_side_by_side_and_names_are_legal_for_casadi() -> None:
    g = Graph()
    q = [g.symbol("q1"), g.symbol("q2")]
    arguments = [argument("q", q)]
    deep = [q[0] * k + q[1] for k in range(12)]
    names = ("a__b", "jac", "null", "_c", "q")
    functions = [function("deep", arguments, (2, 3, 2), deep)]
    functions += [function(name, arguments, (1,), [q[0] + k]) for k, name in enumerate(names)]
    sources = emit(lower(Equations(Scene("hand"), g, tuple(functions))), "casadi")
    calls = run_casadi(sources)

    found = calls.module.deep([3, 5])
    assert found.shape == (2, 6)
    assert all(found[i, 2 * j + k] == 3 * (6 * i + 2 * j + k) + 5 for i in range(2) for j in range(3) for k in range(2))
    assert calls.deep([3, 5])[1, 2, 0] == 3 * 10 + 5
    for k, name in enumerate(sources.functions[1:]):
        assert getattr(calls, name)([0.5, 1]) == [0.5 + k]


@runs
@pytest.mark.runs("cc")
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_our_c_is_what_casadi_calls_with_its_jacobians(tmp_path: Path, compiler: str) -> None:
    import casadi

    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    asked = [*with_derivatives("two_link"), "mass_matrix", "kinetic_energy"]
    asked += [f"{name}_by_parameters" for name in DYNAMICS]
    program = lower(derive(read(EXAMPLES / "two_link.toml"), asked))
    path = write(emit(program, "casadi", option=EXTERNAL), tmp_path)[1]
    library = tmp_path / "two_link_external.so"
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-pedantic", "-Werror", "-shared", "-fPIC", path.name, "-o"]
    subprocess.run([compiler, *flags, library.name, "-lm"], cwd=tmp_path, check=True)

    for name, ours in run_casadi(emit(program, "casadi", option=EXTERNAL)).module.functions.items():
        called = casadi.external(name, str(library))
        assert (called.name_in(), called.name_out()) == (ours.name_in(), ours.name_out())
        given = drawn(ours)
        np.testing.assert_allclose(called(*given).full(), ours(*given).full(), rtol=1e-13, atol=1e-13)
        columns = [np.random.default_rng(2).normal(size=(ours.numel_in(i), 3)) + 2 for i in range(ours.n_in())]
        np.testing.assert_allclose(called(*columns).full(), ours(*columns).full(), rtol=1e-12, atol=1e-12)
        if name in DYNAMICS:
            for one, other in zip(called.jacobian()(*given, 0), ours.jacobian()(*given, 0), strict=True):
                np.testing.assert_allclose(one.full(), other.full(), rtol=1e-12, atol=1e-12)
    with pytest.raises(RuntimeError, match="Derivatives cannot be calculated for mass_matrix"):
        casadi.external("mass_matrix", str(library)).jacobian()


TWICE = ("", "_derivatives", "_vjp", "_hessian")
"""What a function needs beside it so that CasADi takes its Hessians from our C."""


def external_of(scene: Scene, *functions: str) -> str:
    """Return our C for CasADi of functions of a scene."""
    sources = emit(lower(derive(scene, functions)), "casadi", option=EXTERNAL)
    return sources.texts[f"{scene.name}_external.c"]


def test_c_sweeps_backwards_where_all_second_derivatives_are_plain_ones() -> None:
    cart, open_values, top = (read(EXAMPLES / f"{name}.toml") for name in ("cart_pole", "two_link", "heavy_top"))
    every = [f"inverse_dynamics{one}" for one in TWICE]

    assert "of first and second order, which Hessians are made of: inverse_dynamics.\n" in external_of(cart, *every)
    for scene, names in ((cart, every[:3]), (cart, [every[0], every[3]]), (open_values, every), (top, every)):
        assert "adj1" not in external_of(scene, *names)


@runs
@pytest.mark.runs("cc")
@pytest.mark.parametrize("scene", ["cart_pole", "arm7"])
def test_hessians_of_sums_that_casadi_takes_from_our_c_are_those_of_its_own_sweeps(scene: str, tmp_path: Path) -> None:
    import casadi

    mechanism = read(EXAMPLES / f"{scene}.toml")
    n = len(mechanism.velocities)
    for name in DYNAMICS:
        text = external_of(mechanism, *(f"{name}{one}" for one in TWICE))
        (tmp_path / f"{name}.c").write_text(text)
        flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-pedantic", "-Werror", "-shared", "-fPIC"]
        subprocess.run(["gcc", *flags, f"{name}.c", "-o", f"{name}.so", "-lm"], cwd=tmp_path, check=True)
        ours = casadi.external(name, str(tmp_path / f"{name}.so"))
        own = run_casadi(emit(lower(derive(mechanism, [name])), "casadi")).module.functions[name]
        x, weights = casadi.MX.sym("x", 3 * n), casadi.MX.sym("weights", n)
        found = []
        for f in (ours, own):
            y = f(x[:n], x[n : 2 * n], x[2 * n :])
            whole = casadi.hessian(casadi.dot(weights, y * y), x)[0]  # what y is multiplied by moves with x
            assert ("jac_adj1" in str(whole)) == (f is ours)
            found.append(casadi.Function("H", [x, weights], [whole]))
        for seed in (0, 1):
            given = np.random.default_rng(seed).normal(size=3 * n) * seed, np.random.default_rng(2).normal(size=n)
            expected = found[1](*given).full()
            assert np.abs(found[0](*given).full() - expected).max() <= 1e-11 * np.abs(expected).max()

        problem = {"x": x, "f": casadi.sumsqr(x - 1), "g": ours(x[:n], x[n : 2 * n], x[2 * n :])}
        solver = casadi.nlpsol("s", "ipopt", problem, {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes"})
        solver(x0=np.full(3 * n, 0.3), lbg=0.1, ubg=0.1)
        assert solver.stats()["success"]
        assert solver.stats()["n_call_nlp_hess_l"] > 0


@runs
def test_help_says_what_the_numpy_module_says() -> None:
    ours = run_casadi(emit(lower(every_op()), "casadi")).module
    assert "entries of q, shape (2,); rad." in ours.matrix.__doc__
    assert ours.matrix(*[one[0] for one in states(every_op(), "matrix", 1)]).shape == (2, 3)


@runs
def test_ipopt_swings_a_pole_up_by_our_functions_and_our_derivatives() -> None:
    """Trapezoids, 40 of them, cart-pole, 2 seconds: the pole ends upright and the path is one of the equations."""
    import casadi

    f = module("cart_pole", "forward_dynamics", "forward_dynamics_derivatives").functions["forward_dynamics"]
    scene = read(EXAMPLES / "cart_pole.toml")
    values = {"mc": 1.0, "mp": 0.3, "l": 0.5, "b": 0.0, "g": 9.81}
    free = [values[one.name] for one in scene.free_parameters]
    n, h = 40, 2.0 / 40
    problem = casadi.Opti()
    q, qd, u = problem.variable(2, n + 1), problem.variable(2, n + 1), problem.variable(1, n + 1)
    qdd = [f(q[:, k], qd[:, k], casadi.vertcat(u[k], 0), *([free] if free else [])) for k in range(n + 1)]
    for k in range(n):
        problem.subject_to(q[:, k + 1] == q[:, k] + h / 2 * (qd[:, k] + qd[:, k + 1]))
        problem.subject_to(qd[:, k + 1] == qd[:, k] + h / 2 * (qdd[k] + qdd[k + 1]))
    problem.subject_to(q[:, 0] == 0)
    problem.subject_to(casadi.vertcat(qd[:, 0], qd[:, -1]) == 0)
    problem.subject_to(q[:, -1] == casadi.vertcat(1.0, np.pi))
    problem.subject_to(problem.bounded(-20, u, 20))
    problem.minimize(h * casadi.sumsqr(u))
    problem.set_initial(q, np.linspace([0, 0], [1.0, np.pi], n + 1).T)
    problem.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes"})
    found = problem.solve()

    assert found.stats()["return_status"] == "Solve_Succeeded"
    steps = [found.value(one) for one in (q, qd, u)]
    exact = symdyn.lambdify(scene, "forward_dynamics")
    given = [steps[0].T, steps[1].T, np.c_[steps[2], 0 * steps[2]], *([np.array(free)] if free else [])]
    rates = np.hstack([steps[1].T, exact(*given)])
    states_ = np.hstack([steps[0].T, steps[1].T])
    defects = states_[1:] - states_[:-1] - h / 2 * (rates[1:] + rates[:-1])
    assert np.abs(defects).max() < 1e-7
    assert np.abs(states_[-1] - [1.0, np.pi, 0, 0]).max() < 1e-7
