"""Compilers work while proofs run: each file is written and compiled once, and nobody waits for one in vain."""

from __future__ import annotations

import gc
import os
import signal
import threading
import time
from pathlib import Path

import pytest
from patience import HANG

import symdyn
from symdyn.emit import emit
from symdyn.program import lower
from symdyn.runtime import RUNNERS, machine
from symdyn.runtime.commands import threads
from symdyn.runtime.compiler import find_compiler
from symdyn.verify import building as room
from symdyn.verify.building import Building

pytestmark = pytest.mark.usefixtures("optimised")

PROGRAM = lower(symdyn.dynamics.derive(symdyn.example("two_link"), ["mass_matrix"]))


@pytest.mark.runs("cc")
def test_what_has_begun_is_not_made_again(monkeypatch: pytest.MonkeyPatch) -> None:
    written = []
    emit = room.emit
    monkeypatch.setattr(room, "emit", lambda *words, **named: written.append(words[1]) or emit(*words, **named))

    with Building(PROGRAM, "double") as building:
        building.begin(["numpy", "c"], many=["c"])
        building.begin(["numpy", "c"])
        made = building.modules(["numpy", "c"])
        sources, module = building.compiled("c", RUNNERS["c"].many)

    assert (list(made.built), made.missing, made.refused) == (["numpy", "c"], (), "")
    assert sources.option == "batch"
    assert module.mass_matrix
    assert sorted(written) == ["c", "c", "numpy"]


@pytest.mark.runs("cc")
@pytest.mark.parametrize("target", ["c", "ufunc"])  # of one part, and of several that are compiled at a time
def test_whoever_interrupts_does_not_wait_for_compilers(
    target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, done, compiler = (tmp_path / name for name in ("begun", "done", "slow"))
    slow = f'case "$*" in *two_link*) touch "{begun}"; sleep {2 * HANG}; touch "{done}";; esac'
    compiler.write_text(f'#!/bin/sh\n{slow}\nexec {find_compiler().command[0]} "$@"\n')
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "cache"))

    def interrupted() -> None:
        with Building(PROGRAM, "double") as building:
            building.begin([target])
            _wait_for(begun)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not done.exists()


def _wait_for(path: Path) -> None:
    """Wait until a file is there."""
    until = time.monotonic() + HANG
    while not path.exists():
        assert time.monotonic() < until, f"{path.name} never came"
        time.sleep(0.01)


def _slow(folder: Path, program: str, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    """Put a program on the path that takes long once it is asked; return what it makes then and when it is done."""
    begun, done = folder / "begun", folder / "done"
    (folder / program).write_text(f'#!/bin/sh\nread asked\ntouch "{begun}"\nsleep {2 * HANG}\ntouch "{done}"\n')
    (folder / program).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    return begun, done


@pytest.mark.wide("node")
@pytest.mark.runs
@pytest.mark.parametrize(("program", "target"), [("octave-cli", "matlab"), ("node", "js")])
def test_whoever_interrupts_a_call_waits_for_no_interpreter(
    program: str, target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, young: None
) -> None:
    begun, done = _slow(tmp_path, program, monkeypatch)
    heard = signal.signal(signal.SIGINT, signal.default_int_handler)
    sources = emit(lower(symdyn.dynamics.derive(symdyn.example("cart_pole"), ["mass_matrix"])), target)

    def interrupt() -> None:
        _wait_for(begun)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt, daemon=True).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            RUNNERS[target].run(sources).mass_matrix([0.1, 0.2])
    finally:
        signal.signal(signal.SIGINT, heard)
    gc.collect()  # nobody uses it any longer
    assert not done.exists()


@pytest.mark.runs
def test_whoever_interrupts_does_not_wait_for_the_compiler_of_octave(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, done = _slow(tmp_path, "mkoctfile", monkeypatch)
    monkeypatch.setattr(machine, "find_octave", lambda: "octave")

    def interrupted() -> None:
        with threads() as pool:
            pool.submit(machine.run_matlab, emit(PROGRAM, "matlab", option="mex"))
            _wait_for(begun)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not done.exists()
