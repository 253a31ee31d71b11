"""Functions that `symdyn.load` compiles when they are first called: what is compiled when, and that bits stay."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import time
import weakref
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path
from threading import Event

import numpy as np
import pytest
from children import forked, status_of
from patience import HANG

import symdyn
from symdyn import shell
from symdyn.dynamics import Workspace, available, called, derive_one
from symdyn.emit.targets.ufunc import Code
from symdyn.errors import BuildError, DerivationError
from symdyn.runtime.compiler import find_compiler
from symdyn.simulation.integrate.heyoka_expressions import without_sympy

loaded = import_module("symdyn.runtime.loaded")  # a name that its package offers for something else

pytestmark = [pytest.mark.runs("cc"), pytest.mark.usefixtures("optimised")]

ARM = Path(__file__).parent.parent / "examples" / "two_link.toml"
PARAMS = np.array([1.0, 1.0, 1.0, 1.0, 9.81])
STATES = np.random.default_rng(5).uniform(-3, 3, (3, 50, 2))


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path))
    return tmp_path


def kept(cache) -> int:
    """Return how many libraries of the arm are in the cache."""
    return len([path for path in cache.iterdir() if path.name.startswith("two_link")])


@pytest.mark.long
def test_each_kind_of_code_is_compiled_when_it_is_first_needed(cache):
    arm = symdyn.load(ARM, ["inverse_dynamics", "mass_matrix"])
    assert kept(cache) == 0
    arm.inverse_dynamics(*STATES[:, 0], PARAMS)
    assert kept(cache) == 1
    arm.inverse_dynamics(*STATES, PARAMS)
    assert kept(cache) == 2
    arm.inverse_dynamics(*STATES[:, 0].astype("float32"), PARAMS.astype("float32"))
    assert kept(cache) == 3
    arm.inverse_dynamics(*STATES.astype("float32"), PARAMS.astype("float32"))
    assert kept(cache) == 4
    arm.mass_matrix(STATES[0, 0], PARAMS)
    assert kept(cache) == 5


@pytest.mark.long
def test_asked_for_at_once_nothing_is_left_to_compile(cache):
    arm = symdyn.load(ARM, "inverse_dynamics", at_once=True)
    assert kept(cache) == 4
    arm.inverse_dynamics(*STATES, PARAMS)
    arm.inverse_dynamics(*STATES.astype("float32"), PARAMS.astype("float32"))
    assert kept(cache) == 4


def test_bits_are_those_of_the_first_call_in_any_order(cache):
    first, second = (symdyn.load(ARM, "forward_dynamics").forward_dynamics for _ in range(2))
    one, many = first(*STATES[:, 7], PARAMS), first(*STATES, PARAMS)
    many_first, then_one = second(*STATES, PARAMS), second(*STATES[:, 7], PARAMS)
    for again in (first(*STATES[:, 7], PARAMS), then_one):
        assert again.tobytes() == one.tobytes()
    for again in (first(*STATES, PARAMS), many_first):
        assert again.tobytes() == many.tobytes()


def test_help_and_names_work_before_any_call(cache):
    arm = symdyn.load(ARM, "mass_matrix")
    assert "shape (..., 2, 2); kg m^2" in arm.mass_matrix.__doc__
    assert kept(cache) == 0
    values = dict(zip(("m1", "m2", "h1", "h2", "g"), PARAMS.tolist(), strict=True))
    fresh = symdyn.load(ARM, "mass_matrix")
    assert fresh.mass_matrix([0.0, 1.0], **values).shape == (2, 2)


@pytest.mark.slow
@pytest.mark.long
def test_prepared_parameters_reach_functions_that_are_compiled_apart(cache):
    arm, plain = symdyn.load(ARM, "inverse_dynamics", prepare=True), symdyn.load(ARM, "inverse_dynamics")
    found = arm.inverse_dynamics(*STATES, arm.prepare(PARAMS))
    np.testing.assert_allclose(found, plain.inverse_dynamics(*STATES, PARAMS), rtol=1e-12, atol=1e-12)


def counting(folder: Path, seconds: float = 0) -> str:
    """Return a compiler that is slow with the arm and notes each time that it compiles it."""
    compiler = folder / "cc"
    note = f'case "$*" in *two_link*.c*) echo 1 >>{folder}/times; sleep {seconds};; esac\n'
    compiler.write_text(f'#!/bin/sh\n{note}exec {find_compiler().command[0]} "$@"\n')
    compiler.chmod(0o700)
    return str(compiler)


def noted(folder: Path) -> list[str]:
    """Return a word each time that the counting compiler has begun; its file is there before the word in it is."""
    times = folder / "times"
    return times.read_text().split() if times.exists() else []


@pytest.mark.long
def test_threads_that_call_first_together_compile_once(cache, tmp_path):
    call = symdyn.load(ARM, "inverse_dynamics", compiler=counting(tmp_path, 0.1)).inverse_dynamics
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: call(*STATES, PARAMS).tobytes(), range(8)))
    assert len(set(found)) == 1
    assert noted(tmp_path) == ["1", "1"]  # one state, many


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
@pytest.mark.long
def test_a_child_forked_while_a_thread_compiles_compiles_for_itself(cache, tmp_path):
    call = symdyn.load(ARM, "inverse_dynamics", compiler=counting(tmp_path, 0.5)).inverse_dynamics
    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(call, *STATES[:, 0], PARAMS)
        while not noted(tmp_path):
            time.sleep(0.01)
        child = forked(lambda: np.isfinite(call(*STATES[:, 0], PARAMS)).all())
        assert np.isfinite(first.result()).all()
    assert status_of(child) == 0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
@pytest.mark.long
def test_a_child_forked_while_a_thread_derives_derives_for_itself(cache, monkeypatch):
    begun, on = Event(), Event()

    def slow(given):
        begun.set()
        assert on.wait(HANG)
        return symdyn.program.lower(given)

    def at_once():
        loaded.lower = symdyn.program.lower
        return np.isfinite(call(*STATES[:, 0], PARAMS)).all()

    monkeypatch.setattr(loaded, "lower", slow)
    call = symdyn.load(ARM, "inverse_dynamics").inverse_dynamics
    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(call, *STATES[:, 0], PARAMS)
        assert begun.wait(HANG)
        child = forked(at_once)
        found = status_of(child)
        on.set()
        assert np.isfinite(first.result()).all()
    assert found == 0


INTERRUPTED = """
import signal, sys, symdyn
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it, and so would children
symdyn.load(sys.argv[1], "inverse_dynamics", compiler=sys.argv[2], at_once=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.long
def test_whoever_interrupts_a_load_at_once_does_not_wait_for_compilers(cache, tmp_path):
    running = subprocess.Popen([sys.executable, "-c", INTERRUPTED, str(ARM), counting(tmp_path, 2 * HANG)])
    try:
        while not noted(tmp_path):
            assert running.poll() is None
            time.sleep(0.01)
        running.send_signal(signal.SIGINT)
        assert running.wait(HANG) != 0
    finally:
        running.kill()
    assert noted(tmp_path) == ["1"]


@pytest.mark.heavy("quadruped")
@pytest.mark.wide(4)
@pytest.mark.parametrize("path", sorted(ARM.parent.glob("*.toml")), ids=lambda path: path.stem)
def test_how_functions_are_called_is_known_before_they_are_derived(path):
    scene = symdyn.read(path)
    told = 0
    for request in available(scene)[0]:
        function = called(Workspace(scene), request)
        if function is None:
            continue
        made = derive_one(Workspace(scene), request)
        assert (function.name, function.shape, function.result) == (made.name, made.shape, made.result)
        assert function.labels == made.labels
        first, second = (
            [(a.name, a.scalar, a.text, [str(x.value) for x in a.symbols]) for a in one.arguments]
            for one in (function, made)
        )
        assert first == second
        told += not function.entries
    assert bool(told) is not (scene.is_constrained or bool(scene.loads) or bool(scene.inputs))


def test_nothing_is_derived_before_it_is_called(cache, monkeypatch):
    arm = symdyn.load(ARM)
    asked = []
    monkeypatch.setattr(loaded, "lower", lambda given: asked.append(given) or symdyn.program.lower(given))
    arm.mass_matrix(STATES[0, 0], PARAMS)
    arm.mass_matrix(STATES[0, 1], PARAMS)
    (given,) = asked
    assert [one.name for one in given.functions] == ["mass_matrix"]


def test_what_does_not_exist_is_an_error_of_load(cache):
    with pytest.raises(DerivationError, match="moves no mass"):
        symdyn.load(ARM.parent / "pendulum.toml", "forward_dynamics", parameters={"m": 0})
    assert "forward_dynamics" not in symdyn.load(ARM.parent / "pendulum.toml", parameters={"m": 0})


def test_nothing_is_left_of_functions_that_nobody_holds(cache, young):
    arm = symdyn.load(ARM, "inverse_dynamics")
    arm.inverse_dynamics(*STATES, PARAMS)
    held = weakref.ref(arm.inverse_dynamics.call)
    del arm
    gc.collect()
    assert held() is None


def failing(folder: Path, when: str) -> str:
    """Return a compiler that fails where its words or what it compiles hold a text."""
    compiler = folder / "cc"
    words = f'for one in "$@"; do case "$one" in *.c) grep -q "{when}" "$one" && exit 1;; esac; done\n'
    compiler.write_text(f'#!/bin/sh\n{words}exec {find_compiler().command[0]} "$@"\n')
    compiler.chmod(0o700)
    return str(compiler)


def test_a_compiler_that_fails_at_float_is_an_error_of_that_call(cache, tmp_path):
    arm = symdyn.load(ARM, "inverse_dynamics", compiler=failing(tmp_path, "__inverse_dynamics(const float"))
    single = [*STATES[:, 0].astype("float32"), PARAMS.astype("float32")]
    assert np.isfinite(arm.inverse_dynamics(*STATES[:, 0], PARAMS)).all()
    with pytest.raises(BuildError, match="could not compile"):
        arm.inverse_dynamics(*single)
    assert np.isfinite(arm.inverse_dynamics(*STATES[:, 0], PARAMS)).all()


def test_a_constant_too_large_for_float_leaves_double_alone(cache):
    pendulum = symdyn.read(ARM.parent / "pendulum.toml")
    heavy = symdyn.load(pendulum, "gravity_forces", parameters={pendulum.parameters[0].name: 10**60})
    assert [kind[-1] for kind in heavy.gravity_forces.call.found().types] == ["d"]
    assert not Code.of(symdyn.program.lower(symdyn.dynamics.derive(heavy.scene, ["gravity_forces"]))).fits_float
    usual = symdyn.load(pendulum, "gravity_forces")
    assert [kind[-1] for kind in usual.gravity_forces.call.found().types] == ["f", "d"]


def test_the_same_program_gives_the_same_text():
    program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.read(ARM), ["mass_matrix"]))
    for real in ("double", "float"):
        for rows in (False, True):
            assert Code.of(program, real, rows) == Code.of(program, real, rows)


def test_sympy_is_hidden_in_a_process_of_the_shell_alone(monkeypatch):
    monkeypatch.delitem(sys.modules, "sympy", raising=False)
    with without_sympy():
        assert "sympy" not in sys.modules
    monkeypatch.setattr(shell, "_OWN", [True])
    with without_sympy():
        assert sys.modules["sympy"] is None
    assert "sympy" not in sys.modules
