"""Functions for JAX: the values of those for NumPy, and derivatives that differences and JAX's own agree with."""

from __future__ import annotations

import pickle
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from driven_cart import DRIVEN

import symdyn
from symdyn.errors import ArgumentError, BuildError
from symdyn.graph import Arithmetic, Op, evaluate
from symdyn.scene import read_text

pytestmark = [pytest.mark.targets, pytest.mark.runs]

jax = pytest.importorskip("jax")
jnp = jax.numpy
check_grads = pytest.importorskip("jax.test_util").check_grads

TWO_LINK = [1.0, 2.0, 1.1, 0.9, 9.81]
"""m1, m2, h1, h2, g."""


@pytest.fixture(autouse=True)
def _wide() -> Iterator[None]:
    with jax.enable_x64(True):
        yield


def states(name: str, count: int = 5, seed: int = 1) -> tuple[Any, ...]:
    """Return q, and twice as many velocities."""
    scene, rng = symdyn.example(name), np.random.default_rng(seed)
    n = len(scene.velocities)
    return (rng.normal(size=(count, len(scene.coordinates))), *rng.normal(size=(2, count, n)))


def both(name: str, *requests: str, **options: Any) -> tuple[Any, Any]:
    """Return the functions for JAX and for NumPy."""
    scene = symdyn.example(name)
    return symdyn.load(scene, requests, backend="jax", **options), symdyn.load(scene, requests, **options)


@pytest.mark.parametrize("name", ["pendulum", "two_link", "arm7", "four_bar", "heavy_top", "quadruped"])
def test_all_functions_are_those_of_numpy(name: str) -> None:
    scene = symdyn.example(name)
    found, wanted = symdyn.load(scene, backend="jax"), symdyn.load(scene)
    rng = np.random.default_rng(0)

    assert list(found) == list(wanted)
    assert found.signatures == wanted.signatures
    for one in found:
        given = [rng.uniform(0.5, 1, (3,) if x.scalar else (3, len(x.entries))) for x in found[one].operands]
        for call in (found[one], jax.jit(found[one])):
            np.testing.assert_allclose(call(*given), wanted[one](*given), rtol=1e-10, atol=1e-10)


def test_leading_dimensions_broadcast_and_vmap_takes_any_axis() -> None:
    found, wanted = both("two_link", "inverse_dynamics")
    f, g, (q, u, a) = found.inverse_dynamics, wanted.inverse_dynamics, states("two_link")
    many = np.abs(np.random.default_rng(3).normal(size=(5, 5))) + 0.5
    p = np.array(TWO_LINK)

    cases = [
        (f(q[:, None], u, a[:2, None, None], TWO_LINK), g(q[:, None], u, a[:2, None, None], p)),
        (jax.vmap(f, (1, None, 0, None))(q.T, u[0], a, p), g(q, u[0], a, p)),
        (jax.vmap(f, (0, 0, 0, 0), 1)(q, u, a, many), g(q, u, a, many).T),
        (jax.vmap(jax.vmap(f, (None, 0, 0, 0)), (0, None, None, None))(q, u, a, many), g(q[:, None], u, a, many)),
    ]
    for result, exact in cases:
        np.testing.assert_allclose(result, exact, rtol=1e-14)


def test_arguments_are_named_as_for_numpy() -> None:
    found, wanted = both("cart_pole", "mass_matrix", free="mp")
    q = np.array([0.1, 0.7])

    np.testing.assert_array_equal(found.mass_matrix(q), wanted.mass_matrix(q))
    np.testing.assert_array_equal(found.mass_matrix(q=q, mp=1.5), wanted.mass_matrix(q, mp=1.5))
    assert "Return the" in found.mass_matrix.__doc__
    slope = jax.jit(jax.grad(lambda mp: found.mass_matrix(q, mp=mp)[0, 0]))(0.3)
    np.testing.assert_allclose(slope, 1.0)
    with pytest.raises(ArgumentError, match="there is no mq"):
        found.mass_matrix(q, mq=1.0)
    with pytest.raises(ArgumentError, match="q has 3 in its last dimension; give 2 numbers, x, theta"):
        found.mass_matrix(np.zeros(3))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_of_any_order_agree_with_differences(order: int) -> None:
    f = both("two_link", "inverse_dynamics")[0].inverse_dynamics
    check_grads(jax.jit(f), (*states("two_link", 2), np.array(TWO_LINK)), order=order)


@pytest.mark.parametrize(
    ("name", "request_"),
    [
        ("cart_pole", "forward_dynamics"),
        ("cart_pole", "kinetic_energy"),
        ("free_body", "inverse_dynamics"),
        ("heavy_top", "forward_dynamics"),
        ("four_bar", "forward_dynamics"),
        ("two_link", "inverse_dynamics_jvp"),
        ("two_link", "mass_matrix"),
    ],
)
def test_derivatives_agree_with_differences_whatever_moves(name: str, request_: str) -> None:
    f = both(name, request_)[0][request_]
    rng = np.random.default_rng(5)
    given = [rng.uniform(0.5, 1.0, (2, len(x.entries))) for x in f.operands]

    check_grads(jax.jit(f), given, order=2, rtol=1e-3)
    if f(*given).ndim == 2:
        columns = jax.vmap(jax.jacfwd(f, tuple(range(len(given)))))(*given)
        rows = jax.vmap(jax.jacrev(f, tuple(range(len(given)))))(*given)
        for one, other in zip(columns, rows, strict=True):
            np.testing.assert_allclose(one, other, atol=1e-10 * float(jnp.abs(other).max() + 1))


def test_all_of_j_is_what_the_scene_says_and_has_derivatives() -> None:
    found, wanted = both("cart_pole", "inverse_dynamics", "inverse_dynamics_derivatives")
    x = states("cart_pole", 3)
    whole = jax.vmap(jax.jacfwd(found.inverse_dynamics, (0, 1, 2)))
    back = jax.vmap(jax.jacrev(found.inverse_dynamics, (0, 1, 2)))

    for slopes in (whole, back, jax.jit(whole), jax.jit(back)):
        np.testing.assert_allclose(jnp.concatenate(slopes(*x), -1), wanted.inverse_dynamics_derivatives(*x), atol=1e-12)
    check_grads(jax.jit(whole), x, order=2, rtol=1e-3)
    check_grads(jax.jit(back), x, order=1, rtol=1e-3)
    directions = np.random.default_rng(2).normal(size=(6, 2))  # that are no units

    def along(d: Any) -> Any:
        return jax.jvp(lambda q: found.inverse_dynamics(q, x[1], x[2]), (x[0],), (jnp.broadcast_to(d, x[0].shape),))[1]

    exact = np.einsum("smk,dk->dsm", wanted.inverse_dynamics_derivatives(*x)[..., :2], directions)
    np.testing.assert_allclose(jax.vmap(along)(directions), exact, atol=1e-12)


class Traced(Arithmetic):
    """JAX's own functions."""

    functions: ClassVar[dict[Op, Any]] = {Op.SIN: jnp.sin, Op.COS: jnp.cos}

    def constant(self, value: Any) -> float:
        return float(value)

    def function(self, node: Any, args: Any) -> Any:
        return self.functions[node.op](*args)


def test_products_with_many_directions_are_transposed_as_they_are() -> None:
    found = symdyn.load(symdyn.example("arm7"), "gravity_forces", backend="jax")
    q = jnp.asarray(np.random.default_rng(4).uniform(-1, 1, 7))
    V, W = (jnp.asarray(np.random.default_rng(k).uniform(-1, 1, (9, 7))) for k in (5, 6))

    def along(directions: Any) -> Any:
        return jax.vmap(lambda v: jax.jvp(found.gravity_forces, (q,), (v,))[1])(directions)

    assert "symdyn_times" in str(jax.make_jaxpr(along)(V))
    (back,) = jax.linear_transpose(along, V)(W)
    np.testing.assert_allclose(back, W @ jax.jacfwd(found.gravity_forces)(q), rtol=1e-12)


def test_gradients_are_those_that_jax_takes_of_the_equations_themselves() -> None:
    scene = symdyn.example("pendulum")
    free = ("m", "l", "g", "b")
    f = symdyn.load(scene, "forward_dynamics", backend="jax", free=free).forward_dynamics
    opened = replace(scene, parameters=tuple(replace(one, value=None) for one in scene.parameters))
    (function,) = symdyn.dynamics.derive(opened, ["forward_dynamics"]).functions

    def straight(*given: Any) -> Any:
        pairs = zip(function.arguments, given, strict=True)
        values = {x: array[k] for one, array in pairs for k, x in enumerate(one.symbols)}
        return jnp.stack(evaluate(function.entries, Traced(), values))

    def end_of(call: Any) -> Any:
        def end(q: Any, u: Any, *rest: Any) -> Any:
            def step(state: Any, _: Any) -> Any:
                u = state[1] + 0.05 * call(*state, *rest)
                return (state[0] + 0.05 * u, u), state[0]

            (q, _), path = jax.lax.scan(step, (q, u), None, 20)
            return q[0] + (path**2).sum()

        return end

    given = [np.array(x) for x in ([0.7], [0.3], [0.2], [1.1, 0.6, 9.7, 0.05])]
    mine, theirs = (jax.jit(jax.grad(end_of(one), (0, 1, 2, 3)))(*given) for one in (f, straight))
    for one, other in zip(mine, theirs, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10)
    np.testing.assert_allclose(
        jax.hessian(end_of(f), 3)(*given), jax.hessian(end_of(straight), 3)(*given), rtol=1e-9, atol=1e-12
    )


def test_float32_stays_and_float64_is_never_cut() -> None:
    found, wanted = both("two_link", "inverse_dynamics")
    x = (*states("two_link"), np.array(TWO_LINK))
    narrow = [one.astype(np.float32) for one in x]

    assert found.inverse_dynamics(*narrow).dtype == "float32"
    assert found.inverse_dynamics(narrow[0], *x[1:]).dtype == "float64"
    with jax.enable_x64(False):
        result = jax.jit(found.inverse_dynamics)(*narrow)
        assert result.dtype == "float32"
        np.testing.assert_allclose(result, wanted.inverse_dynamics(*x), rtol=1e-4, atol=1e-4)
        slopes = jax.vmap(jax.jacfwd(found.inverse_dynamics), (0, 0, 0, None))(*narrow)
        assert slopes.dtype == "float32"
        with pytest.raises(ArgumentError, match="float64 is given, which JAX takes for float32"):
            found.inverse_dynamics(*x)
    with pytest.raises(ArgumentError, match="complex128 is given; there is code for float64 and float32"):
        found.inverse_dynamics(x[0] * 1j, *x[1:])
    with pytest.raises(ArgumentError, match="bfloat16 is given"):
        found.inverse_dynamics(*(jnp.asarray(one, "bfloat16") for one in x))


def test_empty_batches_nan_and_plain_lists() -> None:
    found, _ = both("two_link", "inverse_dynamics")
    f = found.inverse_dynamics

    assert f(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(2), TWO_LINK).shape == (0, 2)
    assert jax.jit(jax.vmap(jax.jacfwd(f), (0, 0, 0, None)))(*np.zeros((3, 0, 2)), np.ones(5)).shape == (0, 2, 2)
    result = f([[0.0, 0.0], [np.nan, 0.0]], [0, 0], [0, 0], TWO_LINK)
    assert jnp.isfinite(result[0]).all()
    assert jnp.isnan(result[1]).any()


def test_what_is_prepared_is_differentiated_too_and_all_of_it_pickles() -> None:
    found, wanted = both("two_link", "inverse_dynamics", prepare=True)
    x, p = states("two_link", 2), np.array(TWO_LINK)
    given = wanted.prepare(p)

    np.testing.assert_array_equal(found.inverse_dynamics(*x, found.prepare(p)), wanted.inverse_dynamics(*x, given))
    check_grads(lambda *x: found.inverse_dynamics(*x[:3], found.prepare(x[3])), (*x, p), order=2)
    again = pickle.loads(pickle.dumps(found))
    one = pickle.loads(pickle.dumps(found.inverse_dynamics))
    np.testing.assert_array_equal(again.inverse_dynamics(*x, given), one(*x, given))


def test_threads_share_what_is_derived_and_compiled_once() -> None:
    found, _ = both("scara", "inverse_dynamics")
    x, results = states("scara", 400), []

    def work() -> None:
        call = jax.jit(jax.vmap(jax.jacfwd(found.inverse_dynamics, (0, 1, 2))))
        results.append(np.concatenate(call(*x), -1))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert len(results) == 4
    assert all(np.array_equal(results[0], one) for one in results)


def test_another_platform_is_refused_in_words() -> None:
    found, _ = both("pendulum", "forward_dynamics")
    given = [jnp.ones(len(x.entries)) for x in found.forward_dynamics.operands]
    with pytest.raises(BuildError, match="runs on the CPU and on CUDA, there is no kernel for rocm"):
        jax.jit(found.forward_dynamics).trace(*given).lower(lowering_platforms=("rocm",))


def test_what_jax_keeps_on_disk_finds_the_same_code_in_another_process(tmp_path: Any) -> None:
    code = (
        "import sys, jax, numpy as np, symdyn\n"
        "jax.config.update('jax_compilation_cache_dir', sys.argv[1])\n"
        "jax.config.update('jax_persistent_cache_min_compile_time_secs', 0)\n"
        "f = symdyn.load(symdyn.example('cart_pole'), 'mass_matrix', backend='jax').mass_matrix\n"
        "print(np.asarray(jax.jit(f)(np.zeros(2, 'float32'))).tolist())\n"
    )
    runs = [
        subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    assert runs[0] == runs[1] != ""


def test_time_inputs_and_parameters_move_too() -> None:
    f = symdyn.load(read_text(DRIVEN), "forward_dynamics", backend="jax").forward_dynamics
    rng = np.random.default_rng(0)
    given = [rng.uniform(0.5, 1.0, (3,) if x.scalar else (3, len(x.entries))) for x in f.operands]

    assert [x.name for x in f.operands] == ["q", "qd", "tau", "t", "inputs", "params"]
    assert f(*given[:3], t=1.0, m=2.0).shape == (3, 2)
    check_grads(jax.jit(f), given, order=2, rtol=1e-3)
    columns, rows = (jax.vmap(way(f, (0, 1, 2, 3, 4, 5)))(*given) for way in (jax.jacfwd, jax.jacrev))
    for one, other in zip(columns, rows, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_the_page_does_what_it_says() -> None:
    text = (Path(__file__).parent.parent / "docs" / "jax-torch.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(import jax.*?)```", text, re.DOTALL)
    exec(code, {})
