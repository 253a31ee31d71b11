"""Compilers work while proofs run: each file is written and compiled once, and nobody waits for one in vain."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

import symdyn
from symdyn.build import RUNNERS
from symdyn.build.compiler import find_compiler
from symdyn.program import lower
from symdyn.verify import building as room
from symdyn.verify.building import Building

PROGRAM = lower(symdyn.derive(symdyn.example("two_link"), ["mass_matrix"]))


@pytest.mark.runs("cc")
def test_what_has_begun_is_not_made_again(monkeypatch: pytest.MonkeyPatch) -> None:
    written = []
    emit = room.emit
    monkeypatch.setattr(room, "emit", lambda *words, **named: written.append(words[1]) or emit(*words, **named))

    with Building(PROGRAM, "double") as building:
        building.begin(["numpy", "c"], many=["c"])
        building.begin(["numpy", "c"])
        modules, refused = building.modules([], ["numpy", "c"])
        sources, module = building.compiled("c", RUNNERS["c"].many)

    assert (list(modules), refused) == (["numpy", "c"], "")
    assert sources.option == "batch"
    assert module.mass_matrix
    assert sorted(written) == ["c", "c", "numpy"]


@pytest.mark.runs("cc")
@pytest.mark.parametrize("target", ["c", "ufunc"])  # of one part, and of several that are compiled at a time
def test_whoever_interrupts_does_not_wait_for_compilers(
    target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, done, compiler = (tmp_path / name for name in ("begun", "done", "slow"))
    slow = f'case "$*" in *two_link*) touch "{begun}"; sleep 60; touch "{done}";; esac'
    compiler.write_text(f'#!/bin/sh\n{slow}\nexec {find_compiler().command[0]} "$@"\n')
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "cache"))

    def interrupted() -> None:
        with Building(PROGRAM, "double") as building:
            building.begin([target])
            while not begun.exists():
                time.sleep(0.01)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not done.exists()
