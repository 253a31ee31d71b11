"""Compilers that are missing, broken, slow or run twice at once; code that was compiled before."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from formulas import every_op
from patience import HANG

import symdyn.runtime.library as library_room
from symdyn.emit import emit
from symdyn.errors import BuildError, SymdynWarning
from symdyn.program import lower
from symdyn.runtime import build
from symdyn.runtime.cache import warn_once
from symdyn.runtime.compiler import find_compiler

pytestmark = pytest.mark.runs("cc")

ARGS = ([0.0, 0.0], [2.0, 3.0], [10.0])


@pytest.fixture(scope="module")
def sources():
    return emit(lower(every_op()), "c")


@pytest.fixture
def cache(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.delenv("CC", raising=False)
    return tmp_path / "cache"


@pytest.fixture
def working(cache):
    try:
        return find_compiler()
    except BuildError:
        pytest.skip("no C compiler")


def script(folder: Path, text: str) -> str:
    path = folder / "fakecc"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return str(path)


def test_without_a_compiler_the_numpy_module_is_named_as_the_way_out(cache, sources, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("symdyn.runtime.compiler.find_spec", lambda name: None)
    with pytest.raises(BuildError, match=r"no C compiler found .*`symdyn generate SCENE --target numpy`"):
        build(sources)


def test_the_ziglang_package_is_the_last_resort(monkeypatch, tmp_path):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("symdyn.runtime.compiler.find_spec", lambda name: object() if name == "ziglang" else None)
    assert find_compiler().command == (sys.executable, "-m", "ziglang", "cc")


def test_a_compiler_that_is_not_there_is_named(cache, sources, monkeypatch):
    monkeypatch.setenv("CC", "no-such-cc -O1")
    with pytest.raises(BuildError, match="environment variable CC = no-such-cc -O1: there is no such program"):
        build(sources)
    with pytest.raises(BuildError, match="compiler = other-cc: there is no such program"):
        build(sources, compiler="other-cc")


def test_a_broken_compiler_is_named(cache, sources, monkeypatch):
    monkeypatch.setenv("CC", "false")
    with pytest.raises(BuildError, match=r"false could not compile every_op\.c \(exit 1\):\n\(it said nothing\)"):
        build(sources)


def test_the_compilers_own_words_are_shown(cache, sources, tmp_path):
    fake = script(tmp_path, 'echo "sorry, dinner time" >&2; exit 3')
    with pytest.raises(BuildError, match=r"\(exit 3\):\nsorry, dinner time"):
        build(sources, compiler=fake)
    assert list(cache.iterdir()) == []


def test_a_compiler_that_makes_nothing_is_caught(cache, sources):
    with pytest.raises(BuildError, match=r"true could not compile every_op\.c \(exit 0\)"):
        build(sources, compiler="true")


def test_a_compiler_that_makes_rubbish_is_caught(cache, sources, tmp_path):
    fake = script(tmp_path, 'for a in "$@"; do case $a in *.so) echo rubbish > "$a";; esac; done')
    with pytest.raises(BuildError, match="made a library that this Python cannot load"):
        build(sources, compiler=fake)


def test_a_compiler_that_hangs_is_stopped_with_its_children(cache, sources, tmp_path):
    done = tmp_path / "done"
    fake = script(tmp_path, f'case "$1" in --version|-E) exit 0;; esac\nsleep {HANG}; touch "{done}"')
    with pytest.raises(BuildError, match=r"did not finish every_op\.c within 0\.3 s and was stopped"):
        build(sources, compiler=fake, patience=0.3)
    assert not done.exists()


def test_a_cache_that_cannot_be_written_is_named_and_code_is_compiled_all_the_same(
    working, sources, tmp_path, monkeypatch
):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "file"))
    warn_once.cache_clear()
    with pytest.warns(SymdynWarning, match=r"file: no compiled code is kept there .*set SYMDYN_CACHE_DIR"):
        assert build(sources).scalar(*ARGS) == 21.0


def test_what_was_compiled_is_not_compiled_again(working, cache, sources, monkeypatch):
    first = build(sources)
    monkeypatch.setattr(library_room, "compile_library", lambda *_: pytest.fail("compiled again"))
    assert build(sources).path == first.path
    assert [path.name for path in cache.iterdir()] == [first.path.name]


def test_other_text_another_type_or_another_compiler_is_another_library(working, cache, sources, monkeypatch):
    paths = {build(sources).path, build(emit(sources.program, "c", "float")).path}
    paths.add(build(emit(sources.program, "c", command="another header")).path)
    paths.add(build(sources, compiler=f"{working.command[0]} -O1").path)
    paths.add(build(sources, compiler=f"{working.command[0]} -g").path)
    assert len(paths) == 5


def test_portable_and_native_code_are_kept_apart(working, cache, sources):
    native, portable = find_compiler(), find_compiler(machine="portable")
    elsewhere = replace(native, features=native.features + "#define __AVX9__ 1\n")
    assert len({library_room.entry_name(sources, compiler) for compiler in (native, portable, elsewhere)}) == 3
    assert "native" not in " ".join(portable.machine)


def test_an_unknown_machine_is_named():
    with pytest.raises(BuildError, match="machine 'mainframe' is not known; there are native, portable"):
        find_compiler(machine="mainframe")


def test_flags_for_a_machine_on_the_users_command_line_stay(working):
    asked = [find_compiler(f"{working.command[0]} -march={name}") for name in ("x86-64", "x86-64-v3")]
    assert [one.machine for one in asked] == [(), ()]
    assert "__AVX2__" in asked[1].features
    assert "__AVX2__" not in asked[0].features


BUILD = """
from formulas import every_op
from symdyn.runtime import build
from symdyn.program import lower
print(build(lower(every_op())).scalar([0.0, 0.0], [2.0, 3.0], [10.0]))
"""


def test_two_builds_at_once_both_succeed(working, cache):
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
    command = [sys.executable, "-c", BUILD]
    both = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    assert [process.communicate(timeout=HANG)[0].strip() for process in both] == ["21.0", "21.0"]
    assert [path.suffix for path in cache.iterdir()] == [library_room.SUFFIX]
