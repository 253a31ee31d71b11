"""Without a compiler, or without a cache to write to, every door does its work all the same, and says what it lacks."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

import symdyn
import symdyn.runtime.compiler as compiler_room
import symdyn.runtime.library as library_room
from symdyn.errors import BuildError
from symdyn.runtime.cache import warn_once
from symdyn.runtime.compiler import find_compiler

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


@pytest.mark.wide("load")
@pytest.mark.mends("1.7")
@pytest.mark.parametrize("door", [door for door in DOORS if door != "bench"])  # which has a cache of its own
def test_a_cache_that_cannot_be_written_ends_no_work(tmp_path, door):
    (tmp_path / "cache").write_text("a file, no folder")
    _, talk = answer(door, tmp_path)

    assert talk.count("cache: no compiled code is kept there (File exists)") == 1
    assert "Traceback" not in talk
    assert left_behind(tmp_path) == ["cache"]


@pytest.mark.wide("load")
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


@pytest.mark.wide("load")
@pytest.mark.mends("1.7")
@pytest.mark.parametrize("door", DOORS)
def test_a_missing_compiler_ends_no_work(tmp_path, door):
    (tmp_path / "empty").mkdir()
    out, talk = answer(door, tmp_path, PATH=str(tmp_path / "empty"), CC="")

    assert "no C compiler found" in out + talk
    assert "Traceback" not in talk


@pytest.mark.wide("load")
@pytest.mark.mends("1.7")
@pytest.mark.parametrize("door", ["load", "bench"])
def test_missing_headers_of_python_end_no_work(tmp_path, door):
    opening = "import pathlib, symdyn.runtime.library as room\nroom.INCLUDE = pathlib.Path('nowhere')\n"
    out, talk = answer(door, tmp_path, opening)

    assert "there is no Python.h" in out + talk
    assert "Traceback" not in talk


@pytest.mark.wide("load")
@pytest.mark.mends("1.7")
@pytest.mark.parametrize("door", ["load", "lambdify", "simulate"])
def test_no_folder_to_compile_in_ends_no_work(tmp_path, door):
    opening = "import tempfile\ntempfile._get_default_tempdir = lambda *_: 1 / 0\ntempfile.tempdir = '/nowhere'\n"
    (tmp_path / "cache").write_text("a file, no folder")
    _, talk = answer(door, tmp_path, opening)

    assert "no folder to compile in" in talk
    assert "Traceback" not in talk


def late(monkeypatch: pytest.MonkeyPatch) -> None:
    run = compiler_room._run
    monkeypatch.setattr(compiler_room, "_run", lambda command, patience, *more: run(command, min(patience, 0.5), *more))


def held(room: object, name: str) -> Callable[[pytest.MonkeyPatch], None]:
    """Let a function meet a file that a scanner of viruses holds, as Windows says it."""

    def refuse(*_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    return lambda monkeypatch: monkeypatch.setattr(room, name, refuse)


SCANNED = "nothing can be compiled there (Permission denied)"

WAYS = {  # how a compiler that was found fails: what the script `cc` does, what is changed in Python, what is told
    "it refuses": ("echo no >&2; exit 3", None, "(exit 3): no"),
    "it crashes": ("kill -SEGV $$", None, "could not compile"),
    "there is no linker": ('case "$*" in *" -c "*) exec CC "$@";; esac; echo no ld >&2; exit 1', None, "no ld"),
    "it hangs": ("sleep 60", late, "did not finish"),
    "it makes nothing": ("exit 0", None, "could not compile"),
    "its library is refused": (
        'for a in "$@"; do case $a in *.so | *.o) echo no > "$a";; esac; done',
        None,
        "made a library that this Python cannot load",
    ),
    "its library is held": ('exec CC "$@"', held(os, "replace"), SCANNED),
    "what it opens is held": ('exec CC "$@"', held(library_room, "seal"), SCANNED),
    "it cannot be run": (None, None, "cannot be run"),
}


def failing(folder: Path, way: str) -> str:
    """Put a compiler that fails into a folder that comes first in the path."""
    does = WAYS[way][0]
    folder.mkdir()
    asks = 'case "$1" in --version|-E) exec CC "$@";; esac\n'
    text = "#!/nowhere/sh\n" if does is None else f"#!/bin/sh\n{asks}{does}\n"
    (folder / "cc").write_text(text.replace("CC", find_compiler().command[0]))
    (folder / "cc").chmod(0o755)
    return f"{folder}{os.pathsep}{os.environ['PATH']}"


@pytest.mark.wide(2)
@pytest.mark.heavy("what it opens is held")
@pytest.mark.parametrize("way", WAYS)
def test_however_compiling_fails_the_numpy_module_answers(
    way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", failing(tmp_path / "bin", way))
    warn_once.cache_clear()
    _, change, told = WAYS[way]
    if change is not None:
        change(monkeypatch)

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        arm = symdyn.load(ARM, "mass_matrix")
        mass_matrix = symdyn.lambdify(symdyn.read(ARM), "mass_matrix", "c")
    said = [str(one.message) for one in caught if "those of the NumPy module" in str(one.message)]
    assert 1 <= len(said) <= 2  # those that name a file, one for each
    assert [line for line in said if told not in line or "\n" in line] == []
    assert not arm.compiled
    assert arm.mass_matrix([0, 0], [1, 1, 1, 1, 9.81]).tolist() == [[5, 2], [2, 1]]
    assert mass_matrix([0, 0], [1, 1, 1, 1, 9.81]).tolist() == [[5, 2], [2, 1]]
    assert not list((tmp_path / "cache").glob("*"))


@pytest.mark.parametrize("named", ["argument", "variable"])
def test_a_compiler_that_was_asked_for_is_an_error_where_it_fails(
    named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(tmp_path / "bin", "it refuses")
    compiler = str(tmp_path / "bin" / "cc")
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("CC", compiler if named == "variable" else "")
    with pytest.raises(BuildError, match="could not compile"):
        symdyn.load(ARM, "mass_matrix", compiler=compiler if named == "argument" else None)


def test_a_wrong_machine_is_no_failing_compiler() -> None:
    with pytest.raises(BuildError, match="'mainframe' is not known"):
        symdyn.load(ARM, "mass_matrix", machine="mainframe")
