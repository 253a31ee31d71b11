"""Arrays of JAX on a card: the code's own way, kernels and handlers as C++, which XLA calls with columns on the CPU."""

from __future__ import annotations

import ctypes
import re
import shutil
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cuda_on_host
import numpy as np
import pytest
from test_backends_jax import TWO_LINK, _wide, both, check_grads, jax, jnp, states  # noqa: F401  a fixture among them

import symdyn
from symdyn.emit import emit
from symdyn.errors import ArgumentError, BuildError
from symdyn.program import formulate, lower
from symdyn.runtime import build
from symdyn.runtime.library import SUFFIX

pytestmark = [pytest.mark.targets, pytest.mark.runs]

card = pytest.importorskip("symdyn.runtime.backends.jax_functions")

STREAM = 7
"""What handlers are told to use here: on the CPU XLA has no stream for them."""


class Host(cuda_on_host.Host):
    """A card for arrays on the CPU; what XLA is asked for there, and what the kernels say."""

    said = ""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, "-isystem", jax.ffi.include_dir())
        self.libraries_made: list[ctypes.CDLL] = []

    def row(self, platform: str = "cpu") -> Any:
        return card.Card(lambda: "host", self.build, partial(card.hand_over, platform))

    def build(self, files: Mapping[str, str], machine: str) -> tuple[Path, ctypes.CDLL]:
        ((name, text),) = files.items()
        ways = {
            "frame->api->XLA_FFI_Stream_Get(&stream)": f"(stream.stream = (void *){STREAM}, (XLA_FFI_Error *)NULL)",
            'return status == cudaSuccess ? "" : cudaGetErrorString(status)': f'(void)status; return "{self.said}"',
        }
        for one, other in ways.items():
            assert one in text
            text = text.replace(one, other)
        path, library = super().build({name: text}, machine)
        self.libraries_made.append(library)
        return path, library


@pytest.fixture
def host(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Host:
    """Let arrays on the CPU go to kernels, which are compiled as C++."""
    monkeypatch.setenv("CC", "gcc -ffp-contract=off -O1 -mno-fma")
    made = Host(tmp_path)
    monkeypatch.setitem(card.CARDS, "cpu", made.row())
    return made


@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize("name", ["two_link", "four_bar", "arm7"])
def test_kernels_have_the_bits_of_scalar_c(name: str, dtype: str, host: Host) -> None:
    scene = symdyn.example(name)
    requests = ("inverse_dynamics", "forward_dynamics", "mass_matrix")
    found = symdyn.load(scene, requests, backend="jax", machine="portable")
    real = {"float64": "double", "float32": "float"}[dtype]
    c = build(emit(lower(formulate(scene, requests)), "c", real), machine="portable")
    rng = np.random.default_rng(0)
    for one in found:
        operands = [(x.name, len(x.entries)) for x in found[one].operands]
        rows = [rng.uniform(0.5, 1, size if n == "params" else (2, 65, size)).astype(dtype) for n, size in operands]
        sets = [x if n == "params" else None for x, (n, _) in zip(rows, operands, strict=True)]
        wanted = [
            getattr(c, one)(*(x[i, k] if s is None else s for x, s in zip(rows, sets, strict=True)))
            for i in range(2)
            for k in range(65)
        ]
        for result in (found[one](*rows), jax.jit(found[one])(*rows)):
            assert result.dtype == dtype
            np.testing.assert_array_equal(result, np.array(wanted).reshape(result.shape), err_msg=one)
    assert len(host.texts) == 1
    assert ctypes.c_void_p.in_dll(host.libraries_made[0], "last_stream").value == STREAM


def test_leading_dimensions_are_states_lockstep_and_those_of_one_are_broadcast(host: Host) -> None:
    found, wanted = both("arm7", "inverse_dynamics", "mass_matrix")
    q, u, a = np.random.default_rng(0).normal(size=(3, 2, 3, 5, 7))
    f, g = found.inverse_dynamics, wanted.inverse_dynamics
    some = (q[0, 0], u[:, :1, 0], a[1, 2, 3])  # (5, 7), (2, 1, 7), (7)
    twice = jax.vmap(jax.vmap(f, (None, 0, None)), (1, None, None), 1)

    cases = [
        (f(q, u, a), g(q, u, a)),
        (f(q[:, :1], u[:1, :, :1], a), g(q[:, :1], u[:1, :, :1], a)),
        (f(some[0], some[1], some[2]), g(some[0], some[1], some[2])),
        (twice(q[0, 0].T, u[0, 1], a[1, 2, 3]), g(q[0, 0], u[0, 1][:, None], a[1, 2, 3])),
        (found.mass_matrix(q), wanted.mass_matrix(q)),
        (jax.vmap(found.mass_matrix, 3, 1)(np.moveaxis(q, 2, -1)), wanted.mass_matrix(q.transpose(0, 2, 1, 3))),
        (found.mass_matrix(q[0, 0, 0]), wanted.mass_matrix(q[0, 0, 0])),
    ]
    for result, exact in cases:
        assert result.shape == exact.shape
        np.testing.assert_allclose(result, exact, rtol=1e-11, atol=1e-11)
    assert len(host.texts) == 1


def moves(function: Any, *given: Any) -> int:
    """Return how often XLA writes an array in another order beside the calls."""
    text = jax.jit(function).lower(*given).compile().as_text()
    assert "custom-call" in text
    return len(re.findall(r"%\S*(?:copy|transpose)\S* = ", text[text.index("\nENTRY") :]))


def test_columns_are_taken_where_they_lie_and_handed_on(host: Host) -> None:
    f = both("two_link", "inverse_dynamics", "forward_dynamics", "mass_matrix")[0]
    rows, columns = np.zeros((300, 2)), np.zeros((2, 300))
    p = np.array(TWO_LINK)

    def there_and_back(q: Any, u: Any, a: Any) -> Any:
        return f.forward_dynamics(q, u, f.inverse_dynamics(q, u, a, p), p)

    lockstep = jax.vmap(jax.vmap(there_and_back, 1, 1), 1, 1)

    assert moves(lambda q, u, a: f.inverse_dynamics(q.T, u.T, a.T, p).T, *[columns] * 3) == 0
    assert moves(jax.vmap(partial(f.inverse_dynamics, params=p), 1, 1), *[columns] * 3) == 0
    assert moves(lambda q, u, a: jnp.sin(there_and_back(2 * q.T, u.T, a.T)).T, *[columns] * 3) == 0
    assert moves(lockstep, *[columns.reshape(2, 3, 100)] * 3) == 0
    assert moves(jax.vmap(lambda q: f.mass_matrix(q, p), 1, 2), columns) == 0
    for call in (lambda q, u, a: f.inverse_dynamics(q, u, a, p), there_and_back):
        assert moves(call, rows, rows, rows) == 4  # three come in as rows, one goes out


@pytest.mark.parametrize("name", ["two_link", "cart_pole"])
def test_derivatives_go_the_same_way(name: str, host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    f = both(name, "inverse_dynamics")[0].inverse_dynamics
    rest = (np.array(TWO_LINK),) if f.operands[-1].name == "params" else ()
    x = states(name, 2)
    check_grads(jax.jit(f), (*x, *rest), order=2)
    axes, found = (0, 0, 0, *[None] * len(rest)), []
    for many in (4, 1):
        monkeypatch.setattr("symdyn.runtime.backends.jax_functions.MANY", many)
        found += [jax.vmap(way(f, (0, 1, 2)), axes)(*x, *rest) for way in (jax.jacfwd, jax.jacrev)]
        found += [jax.jit(jax.vmap(way(f, (0, 1, 2)), axes))(*x, *rest) for way in (jax.jacfwd, jax.jacrev)]
    exact = symdyn.load(symdyn.example(name), "inverse_dynamics_derivatives").inverse_dynamics_derivatives(*x, *rest)
    for one in found:
        np.testing.assert_allclose(jnp.concatenate(one, -1), exact, atol=1e-12)
    assert len(host.texts) > 3


def test_a_run_is_differentiated_by_its_parameters(host: Host) -> None:
    """Through a loop, where each step is one call."""

    def end_of(f: Any) -> Any:
        def end(q: Any, p: Any) -> Any:
            def step(state: Any, _: Any) -> Any:
                u = state[1] + 0.05 * f(*state, jnp.zeros(2), p)
                return (state[0] + 0.05 * u, u), None

            return (jax.lax.scan(step, (q, jnp.zeros(2)), None, 10)[0][0] ** 2).sum()

        return end

    on_card = symdyn.load(symdyn.example("two_link"), "forward_dynamics", backend="jax").forward_dynamics
    q, p = np.array([0.3, 0.7]), np.array(TWO_LINK)
    found = jax.grad(end_of(on_card), (0, 1))(q, p)
    assert len(host.texts) > 1
    del card.CARDS["cpu"]
    plain = symdyn.load(symdyn.example("two_link"), "forward_dynamics", backend="jax").forward_dynamics
    wanted = jax.grad(end_of(plain), (0, 1))(q, p)
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


def test_one_set_of_parameters_is_for_all_states_and_several_are_refused(host: Host) -> None:
    found, wanted = both("two_link", "mass_matrix")
    q, p = np.random.default_rng(0).uniform(0.5, 1, (5, 2)), np.array(TWO_LINK)
    exact = wanted.mass_matrix(q, p)
    for result in (*(found.mass_matrix(q, one) for one in (p, p[None])), jax.vmap(found.mass_matrix, (0, None))(q, p)):
        np.testing.assert_allclose(result, exact, rtol=1e-14)
    for call in (found.mass_matrix, jax.jit(found.mass_matrix), jax.vmap(found.mass_matrix)):
        with pytest.raises(
            ArgumentError, match="mass_matrix: on cpu one params is for all states, and there are 5; call it"
        ):
            call(q, np.broadcast_to(p, (5, 5)))


def test_prepared_numbers_empty_batches_and_what_is_no_number(host: Host) -> None:
    found, wanted = both("two_link", "inverse_dynamics", prepare=True)
    x, p = states("two_link", 4), np.array(TWO_LINK)
    given = found.prepare(p)
    exact = wanted.inverse_dynamics(*x, wanted.prepare(p))
    np.testing.assert_allclose(found.inverse_dynamics(*x, given), exact, rtol=1e-13)
    assert found.inverse_dynamics(*(one[:0] for one in x), given).shape == (0, 2)
    slopes = jax.jit(jax.vmap(jax.jacfwd(found.inverse_dynamics), (0, 0, 0, None)))
    assert slopes(*(one[:0] for one in x), given).shape == (0, 2, 2)
    bad = np.where(np.arange(4)[:, None] == 2, np.nan, x[0])
    result = np.asarray(found.inverse_dynamics(bad, *x[1:], given))
    assert np.isnan(result[2]).any()
    assert np.isfinite(result[[0, 1, 3]]).all()


def test_float32_has_all_its_digits_in_derivatives(host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    """A card multiplies matrices of floats with ten bits, unless it is told otherwise."""
    monkeypatch.setattr("symdyn.runtime.backends.jax_functions.MANY", 1)
    f = both("two_link", "inverse_dynamics")[0].inverse_dynamics
    x = [one.astype("float32") for one in (*states("two_link"), np.array(TWO_LINK))]
    for way in (jax.jacfwd, jax.jacrev):
        call = jax.vmap(way(f, (0, 1, 2)), (0, 0, 0, None))
        text = jax.jit(call).lower(*x).as_text()
        dots = re.findall(r"dot_general.*", text)
        assert dots
        assert all(one.count("HIGHEST") == 2 for one in dots)
        assert {one.dtype.name for one in call(*x)} == {"float32"}


def test_what_a_card_refuses_is_told_in_its_own_words(host: Host) -> None:
    host.said = "too many resources requested for launch"
    found = both("two_link", "mass_matrix")[0]
    with pytest.raises(jax.errors.JaxRuntimeError, match="mass_matrix: the card refused the kernel: too many"):
        found.mass_matrix(np.zeros((5, 2)), TWO_LINK).block_until_ready()


CALLS = re.compile(r"symdyn_[\w-]+_xla")
"""What XLA calls handlers."""


def lowered(f: Any, *platforms: str) -> str:
    """Return what XLA is told of a function for platforms."""
    traced = jax.jit(f).trace(np.zeros((2, 3, 2)), np.array(TWO_LINK))
    return str(traced.lower(lowering_platforms=platforms).as_text())


def test_programs_are_lowered_for_the_platform_that_is_asked_for_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, f = Host(tmp_path), both("two_link", "mass_matrix")[0].mass_matrix
    monkeypatch.setitem(card.CARDS, "cuda", made.row("CUDA"))
    on_cpu = lowered(f, "cpu")
    assert made.texts == []
    on_card = lowered(f, "cuda")
    assert len(made.texts) == 1
    names = [set(CALLS.findall(text)) for text in (on_cpu, on_card)]
    assert [len(one) for one in names] == [1, 1]
    assert names[0] != names[1]
    assert "(tensor<2x6xf64>, tensor<5x1xf64>) -> tensor<4x6xf64>" in on_card
    assert set(CALLS.findall(lowered(f, "cpu", "cuda"))) == names[0] | names[1]
    assert len(made.texts) == 1


def test_where_no_card_is_it_is_said() -> None:
    f = both("two_link", "mass_matrix")[0].mass_matrix
    with pytest.raises(BuildError, match=r"JAX sees no card \(.*cuda.*\), and kernels are compiled for the one"):
        lowered(f, "cuda")


def test_code_is_for_the_oldest_of_several_cards(monkeypatch: pytest.MonkeyPatch) -> None:
    cards = {"cuda": [SimpleNamespace(compute_capability=one) for one in ("12.0", "8.9", "9.0")]}
    monkeypatch.setattr(jax, "local_devices", lambda backend: cards[backend])
    assert card.CARDS["cuda"].machine() == "sm_89"


def nvidia(machine: str) -> Any:
    return replace(card.CARDS["cuda"], machine=lambda: machine)


@pytest.mark.skipif(shutil.which("nvcc") is None, reason="no nvcc")
def test_nvcc_makes_a_library_that_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Through JAX, as far as it goes without a card: the program for CUDA stands, and its handler is known by name."""
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path))
    monkeypatch.setitem(card.CARDS, "cuda", nvidia("sm_90"))
    f = both("two_link", "mass_matrix")[0].mass_matrix
    told: list[tuple[str, str]] = []
    monkeypatch.setattr(jax.ffi, "register_ffi_target", lambda name, _, platform: told.append((name, platform)))
    before = len(list(tmp_path.rglob(f"*{SUFFIX}")))
    (name,) = CALLS.findall(lowered(f, "cuda"))
    program = lower(formulate(symdyn.example("two_link"), ("mass_matrix",)))
    assert nvidia("sm_90").kernels(program, "double", ()) == {("mass_matrix", ""): name}
    assert len(list(tmp_path.rglob(f"*{SUFFIX}"))) == before + 1
    assert told == [(name, "CUDA")]
    with pytest.raises(BuildError, match="nvcc"):
        nvidia("sm_1").kernels(program, "double", ())


def test_without_nvcc_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NVCC", "no_such_nvcc")
    monkeypatch.setitem(card.CARDS, "cuda", nvidia("sm_90"))
    f = both("two_link", "mass_matrix")[0].mass_matrix
    with pytest.raises(BuildError, match="NVCC = no_such_nvcc: there is no such program; install NVIDIA's CUDA"):
        lowered(f, "cuda")
