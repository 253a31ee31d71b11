"""Functions for PyTorch: the values of those for NumPy, and derivatives that PyTorch's own differences agree with."""

from __future__ import annotations

import pickle
import re
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from driven_cart import DRIVEN

import symdyn
from symdyn.errors import ArgumentError
from symdyn.scene import read_text

pytestmark = [pytest.mark.targets, pytest.mark.runs]

torch = pytest.importorskip("torch")
gradcheck, gradgradcheck = torch.autograd.gradcheck, torch.autograd.gradgradcheck

TWO_LINK = [1.0, 2.0, 1.1, 0.9, 9.81]
"""m1, m2, h1, h2, g."""


def states(name: str, count: int = 3, seed: int = 1) -> list[Any]:
    """Return q, and twice as many velocities, as tensors that want gradients."""
    scene, rng = symdyn.example(name), np.random.default_rng(seed)
    n = len(scene.velocities)
    arrays = (rng.normal(size=(count, len(scene.coordinates))), *rng.normal(size=(2, count, n)))
    return [torch.tensor(one, requires_grad=True) for one in arrays]


def both(name: str, *requests: str, **options: Any) -> tuple[Any, Any]:
    """Return the functions for PyTorch and for NumPy."""
    scene = symdyn.example(name)
    return symdyn.load(scene, requests, backend="torch", **options), symdyn.load(scene, requests, **options)


def plain(*tensors: Any) -> list[Any]:
    return [one.detach() for one in tensors]


@pytest.mark.parametrize("name", ["pendulum", "two_link", "arm7", "four_bar", "heavy_top", "quadruped"])
def test_all_functions_are_those_of_numpy(name: str) -> None:
    scene = symdyn.example(name)
    found, wanted = symdyn.load(scene, backend="torch"), symdyn.load(scene)
    rng = np.random.default_rng(0)

    assert list(found) == list(wanted)
    assert found.signatures == wanted.signatures
    for one in found:
        given = [rng.uniform(0.5, 1, (3,) if x.scalar else (3, len(x.entries))) for x in found[one].operands]
        result = found[one](*map(torch.tensor, given))
        # alone on its graph, as load derives them one by one, a function may add up in another order
        np.testing.assert_allclose(result.numpy(), wanted[one](*given), rtol=1e-12, atol=1e-12)


def test_leading_dimensions_broadcast_and_vmap_takes_any_axis() -> None:
    found, wanted = both("two_link", "inverse_dynamics")
    f, vmap = found.inverse_dynamics, torch.func.vmap
    q, u, a = plain(*states("two_link", 5))
    many = torch.rand(5, 5, dtype=q.dtype) + 0.5
    p = torch.tensor(TWO_LINK, dtype=q.dtype)

    def g(*given: Any) -> Any:
        return wanted.inverse_dynamics(*(one.numpy() for one in given))

    cases = [
        (f(q[:, None], u, a[:2, None, None], TWO_LINK), g(q[:, None], u, a[:2, None, None], p)),
        (vmap(f, (1, None, 0, None))(q.T, u[0], a, p), g(q, u[0], a, p)),
        (vmap(f, (0, 0, 0, 0), 1)(q, u, a, many), g(q, u, a, many).T),
        (vmap(vmap(f, (None, 0, 0, 0)), (0, None, None, None))(q, u, a, many), g(q[:, None], u, a, many)),
    ]
    for result, exact in cases:
        np.testing.assert_allclose(result.numpy(), exact, rtol=1e-14)


def test_arguments_are_named_as_for_numpy() -> None:
    found, wanted = both("cart_pole", "mass_matrix", free="mp")
    q = torch.tensor([0.1, 0.7], dtype=torch.float64)
    mass = torch.tensor(0.3, requires_grad=True)

    np.testing.assert_array_equal(found.mass_matrix(q=q, mp=1.5), wanted.mass_matrix(q.numpy(), mp=1.5))
    found.mass_matrix(q.float(), mp=mass)[0, 0].backward()
    np.testing.assert_allclose(mass.grad, 1.0)
    assert found.mass_matrix(q.float()).dtype == torch.float32
    with pytest.raises(ArgumentError, match="there is no mq"):
        found.mass_matrix(q, mq=1.0)
    with pytest.raises(ArgumentError, match="q has 3 in its last dimension; give 2 numbers, x, theta"):
        found.mass_matrix(torch.zeros(3))
    with pytest.raises(ArgumentError, match=r"torch\.float16 is given"):
        found.mass_matrix(q.half(), torch.zeros(1).half())
    with pytest.raises(ArgumentError, match="runs on the CPU and on CUDA, and a tensor is on meta"):
        found.mass_matrix(q.to("meta"))
    for wrong in (None, "abc", {"x": 1}):
        with pytest.raises(ArgumentError, match="q is no array of real numbers; give 2 numbers, x, theta"):
            found.mass_matrix(wrong)


@pytest.mark.parametrize(
    ("name", "request_"),
    [
        ("two_link", "inverse_dynamics"),
        ("cart_pole", "forward_dynamics"),
        ("cart_pole", "kinetic_energy"),
        ("heavy_top", "forward_dynamics"),
        ("four_bar", "forward_dynamics"),
        ("two_link", "mass_matrix"),
    ],
)
def test_derivatives_agree_with_differences_forwards_backwards_and_twice(name: str, request_: str) -> None:
    f = both(name, request_)[0][request_]
    rng = np.random.default_rng(5)
    given = [torch.tensor(rng.uniform(0.5, 1.0, (2, len(x.entries))), requires_grad=True) for x in f.operands]

    assert gradcheck(f, given, check_forward_ad=True)
    assert gradgradcheck(f, given, rtol=1e-2, atol=1e-4)
    assert gradcheck(lambda q, *rest: f(q[:, None], *rest), given)


def test_gradients_go_back_thrice() -> None:
    f = both("two_link", "inverse_dynamics")[0].inverse_dynamics
    q, u, a = states("two_link", 2)

    def slopes(q: Any) -> Any:
        (found,) = torch.autograd.grad((f(q, u, a, TWO_LINK) ** 2).sum(), q, create_graph=True)
        return found

    assert gradgradcheck(slopes, (q,))


def test_all_of_j_is_what_the_scene_says() -> None:
    found, wanted = both("scara", "inverse_dynamics", "inverse_dynamics_derivatives")
    x, func = plain(*states("scara")), torch.func
    exact = wanted.inverse_dynamics_derivatives(*(one.numpy() for one in x))

    for way in (func.jacfwd, func.jacrev):
        blocks = func.vmap(way(found.inverse_dynamics, (0, 1, 2)))(*x)
        np.testing.assert_allclose(torch.cat(blocks, -1), exact, atol=1e-12)
    energy = func.vmap(func.hessian(lambda q, u, a: (found.inverse_dynamics(q, u, a) ** 2).sum()))(*x)
    np.testing.assert_allclose(energy, energy.mT, atol=1e-10)


def test_types_stay_empty_batches_nan_and_plain_lists() -> None:
    found, _ = both("two_link", "inverse_dynamics")
    f = found.inverse_dynamics
    x = plain(*states("two_link"))

    assert f(*(one.float() for one in x), TWO_LINK).dtype == torch.float32
    assert f(x[0].float(), *x[1:], TWO_LINK).dtype == torch.float64
    assert f([0, 0], [0, 0], [0, 0], TWO_LINK).dtype == torch.get_default_dtype()
    assert f(x[0].numpy(), *x[1:], TWO_LINK).dtype == torch.float64
    empty = torch.zeros(0, 2, dtype=torch.float64, requires_grad=True)
    result = f(empty, empty, empty, TWO_LINK)
    assert result.shape == (0, 2)
    result.sum().backward()
    assert empty.grad is not None
    result = f([[0.0, 0.0], [float("nan"), 0.0]], [0, 0], [0, 0], TWO_LINK)
    assert result[0].isfinite().all()
    assert result[1].isnan().any()


def test_tensors_that_are_views_are_taken_as_they_lie() -> None:
    found, wanted = both("scara", "inverse_dynamics")
    x = [one.T for one in plain(*states("scara", 4))]  # columns, of which every other is taken
    x = [one.contiguous().T[::2] for one in x]

    np.testing.assert_array_equal(found.inverse_dynamics(*x), wanted.inverse_dynamics(*(one.numpy() for one in x)))
    z = torch.complex(x[0], x[0]).conj().imag  # a view with its sign still to come
    assert z.is_neg()
    np.testing.assert_array_equal(
        found.inverse_dynamics(z, *x[1:]), wanted.inverse_dynamics(*(one.numpy() for one in (-x[0], *x[1:])))
    )


def test_what_is_prepared_is_differentiated_too_and_all_of_it_pickles() -> None:
    found, wanted = both("two_link", "inverse_dynamics", prepare=True)
    x, p = states("two_link", 2), torch.tensor(TWO_LINK, dtype=torch.float64, requires_grad=True)
    given = wanted.prepare(TWO_LINK)

    assert gradcheck(lambda *x: found.inverse_dynamics(*x[:3], found.prepare(x[3])), (*x, p))
    again, one = (pickle.loads(pickle.dumps(what)) for what in (found, found.inverse_dynamics))
    np.testing.assert_array_equal(again.inverse_dynamics(*plain(*x), given), one(*plain(*x), given))


def test_threads_share_what_is_derived_and_compiled_once() -> None:
    found, _ = both("scara", "inverse_dynamics")
    results = []

    def work() -> None:
        x = states("scara", 100)
        found.inverse_dynamics(*x).sum().backward()
        results.append(x[0].grad)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert len(results) == 4
    assert all(torch.equal(results[0], one) for one in results)


def test_torch_compile_calls_it() -> None:
    found, _ = both("two_link", "inverse_dynamics")
    x = plain(*states("two_link"))
    compiled = torch.compile(lambda *x: 2 * found.inverse_dynamics(*x, TWO_LINK), backend="eager")

    assert torch.equal(compiled(*x), 2 * found.inverse_dynamics(*x, TWO_LINK))


def test_time_inputs_and_parameters_move_too() -> None:
    f = symdyn.load(read_text(DRIVEN), "forward_dynamics", backend="torch").forward_dynamics
    rng = np.random.default_rng(0)
    given = [rng.uniform(0.5, 1.0, (3,) if x.scalar else (3, len(x.entries))) for x in f.operands]

    assert [x.name for x in f.operands] == ["q", "qd", "tau", "t", "inputs", "params"]
    assert f(*given[:3], t=1.0, m=2.0).shape == (3, 2)
    tensors = [torch.tensor(one, requires_grad=True) for one in given]
    assert gradcheck(f, tensors, check_forward_ad=True)
    assert gradgradcheck(f, tensors)


def test_the_page_does_what_it_says() -> None:
    text = (Path(__file__).parent.parent / "docs" / "jax-torch.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(import torch.*?)```", text, re.DOTALL)
    exec(code, {})
