"""PyTorch's tensors on a card: the code's own way, kernels and launchers as C++, over tensors on the CPU."""

from __future__ import annotations

import ctypes
import shutil
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import cuda_on_host
import numpy as np
import pytest
from test_backends_torch import both, plain, states

import symdyn
from symdyn.emit import emit
from symdyn.errors import ArgumentError, BuildError
from symdyn.program import formulate, lower
from symdyn.runtime import build
from symdyn.runtime.library import SUFFIX

pytestmark = [pytest.mark.targets, pytest.mark.runs]

torch = pytest.importorskip("torch")
card = pytest.importorskip("symdyn.runtime.backends.torch_functions")
vmap, jacfwd, jacrev = torch.func.vmap, torch.func.jacfwd, torch.func.jacrev

STREAM = 7
"""What launchers are told to use here; as C++ they have none."""


class Host(cuda_on_host.Host):
    """A card for tensors on the CPU, and how often it was made the current device."""

    chosen = 0

    def row(self) -> Any:
        return card.Card(lambda _: "host", self.build, self.choose, lambda _: STREAM)

    def choose(self, _: Any) -> Any:
        self.chosen += 1
        return nullcontext()


@pytest.fixture
def host(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Host:
    """Let tensors on the CPU go to kernels, which are compiled as C++."""
    monkeypatch.setenv("CC", "gcc -ffp-contract=off -O1 -mno-fma")
    made = Host(tmp_path)
    monkeypatch.setitem(card.CARDS, "cpu", made.row())
    return made


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
@pytest.mark.parametrize("name", ["two_link", "four_bar", "arm7"])
def test_kernels_have_the_bits_of_scalar_c(name: str, dtype: Any, host: Host) -> None:
    scene = symdyn.example(name)
    requests = ("inverse_dynamics", "forward_dynamics", "mass_matrix")
    found = symdyn.load(scene, requests, backend="torch", machine="portable")
    real = {torch.float64: "double", torch.float32: "float"}[dtype]
    c = build(emit(lower(formulate(scene, requests)), "c", real), machine="portable")
    rng = np.random.default_rng(0)
    for one in found:
        operands = [(x.name, len(x.entries)) for x in found[one].operands]
        rows = [
            torch.tensor(rng.uniform(0.5, 1, size if n == "params" else (130, size)), dtype=dtype)
            for n, size in operands
        ]
        result = found[one](*rows)
        sets = [x.numpy() if n == "params" else None for x, (n, _) in zip(rows, operands, strict=True)]
        wanted = [
            getattr(c, one)(*(x.numpy()[k] if s is None else s for x, s in zip(rows, sets, strict=True)))
            for k in range(130)
        ]
        assert result.dtype == dtype
        np.testing.assert_array_equal(result.numpy(), np.array(wanted).reshape(result.shape), err_msg=one)
    assert host.chosen == 3


def test_columns_are_taken_where_they_lie_and_results_are_columns(host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    found = both("two_link", "inverse_dynamics")[0]
    q, u, a = (torch.rand(2, 300, dtype=torch.float64).T for _ in range(3))
    seen: list[tuple[Any, ...]] = []
    make = card.Kernels.__call__

    def watched(self: Any, *given: Any) -> Any:
        return [lambda *some, run=run: seen.append(some) or run(*some) for run in make(self, *given)]

    monkeypatch.setattr(card.Kernels, "__call__", watched)
    tau = found.inverse_dynamics(q, u, a, [1.0, 2.0, 1.1, 0.9, 9.81])
    (given,) = seen
    assert given[:2] == (STREAM, 300)
    assert given[2:5] == (q.data_ptr(), u.data_ptr(), a.data_ptr())
    assert given[-1] == tau.data_ptr()
    assert tau.T.is_contiguous()
    many = found.inverse_dynamics(q.reshape(3, 100, 2), u.reshape(3, 100, 2), a[:100], [1.0, 2.0, 1.1, 0.9, 9.81])
    assert many.shape == (3, 100, 2)
    torch.testing.assert_close(many[0], tau[:100], rtol=0, atol=0)


@pytest.mark.parametrize("name", ["two_link", "cart_pole"])
def test_derivatives_go_the_same_way(name: str, host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = symdyn.example(name)
    f = symdyn.load(scene, "inverse_dynamics", backend="torch").inverse_dynamics
    q, u, a = states(name)
    params = torch.rand(len(f.operands[-1].entries), dtype=torch.float64) + 0.5
    rest = (params.requires_grad_(),) if f.operands[-1].name == "params" else ()
    assert torch.autograd.gradcheck(f, (q, u, a, *rest))
    assert torch.autograd.gradgradcheck(f, (q, u, a, *rest))
    axes = (0, 0, 0, *[None] * len(rest))
    J = [vmap(way(f), axes)(*plain(q, u, a, *rest)) for way in (jacfwd, jacrev)]
    monkeypatch.setattr("symdyn.runtime.backends.torch_functions.MANY", 1)
    J += [vmap(way(f), axes)(*plain(q, u, a, *rest)) for way in (jacfwd, jacrev)]
    for one in J[1:]:
        torch.testing.assert_close(one, J[0])
    assert len(host.texts) > 3


def test_one_set_of_parameters_is_for_all_states_and_several_are_refused(host: Host) -> None:
    found, wanted = both("two_link", "mass_matrix")
    q, p = torch.rand(5, 2, dtype=torch.float64), torch.rand(5, dtype=torch.float64) + 0.5
    exact = wanted.mass_matrix(q.numpy(), p.numpy())
    for some in (p, p[None], p.expand(5, 5)):
        np.testing.assert_allclose(found.mass_matrix(q, some).numpy(), exact, rtol=1e-14)
    assert found.mass_matrix(q[:0], p).shape == (0, 2, 2)
    with pytest.raises(
        ArgumentError, match="mass_matrix: on cpu one params is for all states, and there are 5; call it"
    ):
        found.mass_matrix(q, p.expand(5, 5).clone())


def test_prepared_numbers_are_made_and_taken(host: Host) -> None:
    found, wanted = both("two_link", "mass_matrix", prepare=True)
    q, p = torch.rand(5, 2, dtype=torch.float64), torch.rand(5, dtype=torch.float64) + 0.5
    exact = wanted.mass_matrix(q.numpy(), wanted.prepare(p.numpy()))
    np.testing.assert_allclose(found.mass_matrix(q, found.prepare(p)).numpy(), exact, rtol=1e-14)


def test_nothing_is_on_another_device_than_the_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tensors on "meta" have no memory: whatever were made elsewhere would have an address."""
    runs: list[int] = []

    def nothing(_: int, states: int, *places: int) -> bytes:
        assert not any(places)
        runs.append(states)
        return b""

    monkeypatch.setattr(card.Kernels, "__call__", lambda *_: [nothing] * 9)
    row = card.Card(lambda _: "none", lambda *_: None, lambda _: nullcontext(), lambda _: 0)
    monkeypatch.setitem(card.CARDS, "meta", row)
    found = symdyn.load(symdyn.example("two_link"), "inverse_dynamics", backend="torch").inverse_dynamics
    q, u, a = (one.detach().to("meta").requires_grad_() for one in states("two_link", 5))
    tau = found(q, u, a, m1=q.new_ones(()), m2=2.0, h1=1.0, h2=1.0, g=9.81)
    (slopes,) = torch.autograd.grad(tau.sum(), q, create_graph=True)
    (twice,) = torch.autograd.grad(slopes.sum(), u)
    some = (*plain(q, u, a), a.new_ones(5))
    monkeypatch.setattr("symdyn.runtime.backends.torch_functions.MANY", 1)
    ways = (jacfwd, jacrev, lambda f: jacfwd(jacrev(f)), lambda f: jacrev(jacfwd(f)))
    J = [vmap(way(found), (0, 0, 0, None))(*some) for way in ways]
    _, along = torch.func.jvp(lambda q: found(q, *some[1:]), some[:1], some[:1])
    assert {one.device.type for one in (tau, slopes, twice, along, *J)} == {"meta"}
    assert [one.shape for one in J] == [(5, 2, 2), (5, 2, 2), (5, 2, 2, 2), (5, 2, 2, 2)]
    assert 5 in runs
    with pytest.raises(ArgumentError, match=r"tensors are on meta and cpu; give all on one device, x.to\('meta'\)"):
        found(q, torch.rand(5, 2, dtype=q.dtype), a, [1.0] * 5)


def test_what_a_card_refuses_is_told_in_its_own_words(host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(card.Kernels, "__call__", lambda *_: [lambda *_: b"too many resources requested for launch"])
    found = both("two_link", "mass_matrix")[0]
    with pytest.raises(BuildError, match="mass_matrix: cpu refused the kernel: too many resources requested"):
        found.mass_matrix(torch.rand(5, 2), [1.0] * 5)


def nvidia(machine: str) -> Any:
    row = replace(card.CARDS["cuda"], machine=lambda _: machine)
    return card.kernels(row, torch.device("cpu"))


@pytest.mark.skipif(shutil.which("nvcc") is None, reason="no nvcc")
def test_nvcc_makes_a_library_that_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path))
    program = lower(formulate(symdyn.example("two_link"), ("mass_matrix",)))
    made = nvidia("sm_90")
    for _ in range(2):
        (run,) = made(program, "double", ())
        assert run.restype is ctypes.c_char_p
    assert len(list(tmp_path.rglob(f"*{SUFFIX}"))) == 1
    with pytest.raises(BuildError, match="nvcc"):
        nvidia("sm_1")(program, "double", ())


def test_without_nvcc_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NVCC", "no_such_nvcc")
    program = lower(formulate(symdyn.example("two_link"), ("mass_matrix",)))
    with pytest.raises(
        BuildError, match="NVCC = no_such_nvcc: there is no such program; install NVIDIA's CUDA toolkit"
    ):
        nvidia("sm_90")(program, "double", ())
