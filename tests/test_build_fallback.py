"""Without a compiler, or without a cache to write to, every door does its work all the same, and says what it lacks."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import symdyn
from symdyn.build.compiler import find_compiler

pytestmark = pytest.mark.runs("cc")

ROOT = Path(symdyn.__file__).parent.parent
ARM = str(ROOT / "examples" / "two_link.toml")
PENDULUM = str(ROOT / "examples" / "pendulum.toml")

ZERO = "[0, 0], [1, 1, 1, 1, 9.81]"
SHORT = "'--until', '0.1', '--every', '0.1'"
DOORS = {
    "load": f"print(symdyn.load({ARM!r}, 'mass_matrix').mass_matrix({ZERO}).tolist())",
    "lambdify": f"print(symdyn.lambdify(symdyn.read({ARM!r}), 'mass_matrix', 'c')({ZERO}).tolist())",
    "simulate": f"sys.exit(main(['simulate', {PENDULUM!r}, {SHORT}, '--method', 'dop853']))",
    "inverse": f"sys.exit(main(['inverse', {PENDULUM!r}, '--motion', 'q1=sin(t)', {SHORT}]))",
    "verify": f"sys.exit(main(['verify', {ARM!r}, '--functions', 'mass_matrix']))",
    "bench": f"sys.exit(main(['bench', {PENDULUM!r}, '--quick', '--functions', 'mass_matrix', '--no-trajectories']))",
}

ANSWERS = {  # what the answer begins with, or holds
    "load": "[[5.0, 2.0], [2.0, 1.0]]",
    "lambdify": "[[5.0, 2.0], [2.0, 1.0]]",
    "simulate": "t,q1,",
    "inverse": "t,q1,",
    "verify": "mass_matrix",
    "bench": "mass_matrix",
}

OPENING = """
import sys, warnings
sys.modules["ziglang"] = None
import symdyn
from symdyn.cli import main
"""


def answer(door: str, folder: Path, opening: str = "", **environment: str) -> tuple[str, str]:
    """Return what a door says on stdout and on stderr, in a process with this environment; it must succeed."""
    given = {"SYMDYN_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": str(ROOT), "TMPDIR": str(folder)}
    ran = subprocess.run(
        [sys.executable, "-c", OPENING + opening + DOORS[door]],
        env=os.environ | given | environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    assert ANSWERS[door] in ran.stdout
    return ran.stdout, ran.stderr


def left_behind(folder: Path) -> list[str]:
    """Return what stands in the folder; NumPy and others leave nothing there."""
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.mends("1.7")
@pytest.mark.parametrize("door", [door for door in DOORS if door != "bench"])  # which has a cache of its own
def test_a_cache_that_cannot_be_written_ends_no_work(tmp_path, door):
    (tmp_path / "cache").write_text("a file, no folder")
    _, talk = answer(door, tmp_path)

    assert talk.count("cache: no compiled code is kept there (File exists)") == 1
    assert "Traceback" not in talk
    assert left_behind(tmp_path) == ["cache"]


@pytest.mark.parametrize("door", ["load", "simulate"])
def test_a_full_disk_ends_no_work(tmp_path, door):
    compiler = tmp_path / "cc"  # fails as compilers do there, and only there
    compiler.write_text(
        f'#!/bin/sh\ncase "$*" in *cache*) echo full >&2; exit 1; esac\nexec {find_compiler().command[0]} "$@"\n'
    )
    compiler.chmod(0o700)
    opening = (
        "import shutil\nusage = shutil.disk_usage\n"
        "shutil.disk_usage = lambda at: usage(at)._replace(free=0) if 'cache' in str(at) else usage(at)\n"
    )
    _, talk = answer(door, tmp_path, opening, CC=str(compiler))

    assert "no compiled code is kept there (No space left on device)" in talk
    assert "Traceback" not in talk


@pytest.mark.mends("1.7")
@pytest.mark.parametrize("door", DOORS)
def test_a_missing_compiler_ends_no_work(tmp_path, door):
    (tmp_path / "empty").mkdir()
    out, talk = answer(door, tmp_path, PATH=str(tmp_path / "empty"), CC="")

    assert "no C compiler found" in out + talk
    assert "Traceback" not in talk


@pytest.mark.mends("1.7")
@pytest.mark.parametrize("door", ["load", "bench"])
def test_missing_headers_of_python_end_no_work(tmp_path, door):
    opening = "import pathlib, symdyn.build.extension as room\nroom.INCLUDE = pathlib.Path('nowhere')\n"
    out, talk = answer(door, tmp_path, opening)

    assert "there is no Python.h" in out + talk
    assert "Traceback" not in talk


@pytest.mark.mends("1.7")
@pytest.mark.parametrize("door", ["load", "lambdify", "simulate"])
def test_no_folder_to_compile_in_ends_no_work(tmp_path, door):
    opening = "import tempfile\ntempfile._get_default_tempdir = lambda *_: 1 / 0\ntempfile.tempdir = '/nowhere'\n"
    (tmp_path / "cache").write_text("a file, no folder")
    _, talk = answer(door, tmp_path, opening)

    assert "no folder to compile in" in talk
    assert "Traceback" not in talk
