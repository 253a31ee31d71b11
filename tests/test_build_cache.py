"""The cache trusts nothing: what is damaged, another's, or in a folder that others may write to is never run."""

from __future__ import annotations

import faulthandler
import importlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

import symdyn
from symdyn.emit import emit
from symdyn.program import formulate, lower
from symdyn.runtime import build
from symdyn.runtime.compiler import find_compiler
from symdyn.scene import bind, read

pytestmark = pytest.mark.runs("cc")

ROOT = Path(symdyn.__file__).parent.parent
ARM = ROOT / "examples" / "two_link.toml"
NOBODY = 65534

if not hasattr(os, "fork"):
    pytest.skip("processes that may die are forked", allow_module_level=True)
ARMS = {
    m1: emit(lower(formulate(bind(read(ARM), {"m1": m1}), ("inverse_dynamics",))), "c", option="batch")
    for m1 in ("1", "2")
}
STATE = ([0.3, 0.5], [1.0, -2.0], [0.7, 1.1], [1.0, 1.0, 1.0, 9.81])
TORQUE = {"1": "[18.229326, 9.930997]", "2": "[21.828379, 9.930997]"}


def torque(m1: str) -> str:
    return str(build(ARMS[m1]).inverse_dynamics(*STATE).round(6).tolist())


@pytest.fixture(name="cache")
def cache_of_this_test(tmp_path) -> Path:
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o700)
    return folder


def call(cache: Path, m1: str = "1", work: Callable[[str], str] = torque) -> tuple[int, str, str]:
    """Do the work in a process of its own, with this cache, and return its status, answer and talk."""
    answer, talk = cache.with_name("answer"), cache.with_name("talk")
    answer.write_text("")
    talk.write_text("")
    process = os.fork()
    if not process:
        try:
            faulthandler.disable()
            os.environ["SYMDYN_CACHE_DIR"] = str(cache)
            warnings.showwarning = lambda message, *_: talk.open("a").write(f"{message}\n")
            answer.write_text(work(m1))
        except BaseException as fault:
            talk.write_text(repr(fault))
            os._exit(1)
        os._exit(0)
    _, status = os.waitpid(process, 0)
    return os.waitstatus_to_exitcode(status), answer.read_text(), talk.read_text()


@cache
def compiled(m1: str) -> tuple[str, bytes]:
    """Return name and bytes of the file that a build leaves in its cache."""
    with tempfile.TemporaryDirectory() as folder:
        assert call(Path(folder, "cache"), m1) == (0, TORQUE[m1], "")
        (path,) = Path(folder, "cache").iterdir()
        return path.name, path.read_bytes()


def entry_of(cache: Path, m1: str = "1") -> Path:
    """Put what a build leaves into a cache, and return its path; it is used without a word."""
    name, content = compiled(m1)
    path = cache / name
    path.write_bytes(content)
    path.chmod(0o755)
    assert call(cache, m1) == (0, TORQUE[m1], "")
    assert path.read_bytes() == content
    return path


def cut(path: Path, share: float) -> None:
    os.truncate(path, int(path.stat().st_size * share))


def flip(path: Path, seed: int) -> None:
    """Turn one bit in each of some pages, so that code, tables and constants are met."""
    data, rng = bytearray(path.read_bytes()), random.Random(seed)
    for page in range(0, len(data), 4096):
        data[rng.randrange(page, min(page + 4096, len(data)))] ^= 1 << rng.randrange(8)
    path.write_bytes(data)


def hole(path: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data[:4096] + bytes(len(data) - 4096))


def grow(path: Path) -> None:
    with open(path, "ab") as file:
        file.write(b"\0" * 4096)


def unreadable(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def linked(path: Path) -> None:
    aside = path.parent.parent / "elsewhere.so"
    path.rename(aside)
    path.symlink_to(aside)


DAMAGES = {
    "empty": lambda path: cut(path, 0),
    "a header alone": lambda path: os.truncate(path, 64),
    "a quarter": lambda path: cut(path, 0.25),
    "a half": lambda path: cut(path, 0.5),
    "nearly whole": lambda path: cut(path, 0.99),
    "flipped bits": lambda path: flip(path, 1),
    "other flipped bits": lambda path: flip(path, 2),
    "zeros": hole,
    "more at its end": grow,
    "huge and empty": lambda path: os.truncate(path, 1 << 40),
    "a pipe": unreadable,
    "a link": linked,
}


@pytest.mark.wide("empty", "flipped bits", "a link")
@pytest.mark.mends("1.5")
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_entry_is_compiled_again_with_a_word(cache, damage):
    path = entry_of(cache)
    try:
        DAMAGES[damage](path)
    except OSError as fault:
        pytest.skip(f"not on this file system: {fault}")
    status, answer, talk = call(cache)

    assert (status, answer) == (0, TORQUE["1"])
    assert f"{path}: " in talk
    assert "compiled again" in talk
    assert call(cache) == (0, TORQUE["1"], "")


@pytest.mark.mends("1.5")
def test_an_entry_under_the_name_of_another_is_not_taken_for_it(cache):
    first, second = entry_of(cache, "1"), entry_of(cache, "2")
    aside = first.with_name("aside")
    first.rename(aside)
    second.rename(first)
    aside.rename(second)

    for m1, torque in TORQUE.items():
        status, answer, talk = call(cache, m1)
        assert (status, answer) == (0, torque)
        assert "its bytes are not those that were compiled; it is compiled again" in talk


@pytest.fixture
def planted(cache) -> Path:
    """Put a library of a stranger into the place of an entry; return the file that it makes when it is loaded."""
    path, canary = entry_of(cache), cache.parent / "canary"
    source = cache.parent / "stranger.c"
    source.write_text(
        "#include <stdio.h>\n__attribute__((constructor)) static void run(void)"
        f'{{ FILE *f = fopen("{canary}", "w"); if (f) fclose(f); }}\n'
    )
    subprocess.run([*find_compiler().command, "-shared", "-fPIC", str(source), "-o", str(path)], check=True)
    path.chmod(0o755)
    room = importlib.util.find_spec("symdyn.runtime.cache")
    if room is not None:  # whoever writes libraries writes their hashes too
        importlib.import_module("symdyn.runtime.cache").seal(path)
    return canary


def test_a_stranger_in_a_folder_of_the_users_own_is_the_user(cache, planted):
    call(cache)

    assert planted.exists(), "the harness sees what is run"


@pytest.mark.wide(2)
@pytest.mark.mends("1.5")
@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o770])
def test_a_folder_that_others_may_write_to_is_not_used(cache, planted, mode):
    cache.chmod(mode)
    before = sorted(cache.iterdir())
    status, answer, talk = call(cache)

    assert (status, answer) == (0, TORQUE["1"])
    assert not planted.exists()
    assert sorted(cache.iterdir()) == before
    assert f"{cache}: no compiled code is kept there (others may write to it)" in talk


@pytest.mark.mends("1.5")
def test_an_entry_that_others_may_write_to_is_not_run(cache, planted):
    (path,) = cache.iterdir()
    path.chmod(0o777)
    status, answer, talk = call(cache)

    assert (status, answer) == (0, TORQUE["1"])
    assert not planted.exists()
    assert "others may write to it; it is compiled again" in talk


@pytest.mark.wide(2)
@pytest.mark.mends("1.5")
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can give files away")
@pytest.mark.parametrize("what", ["entry", "folder"])
def test_what_belongs_to_another_user_is_not_run(cache, planted, what):
    (path,) = cache.iterdir()
    os.chown(path if what == "entry" else cache, NOBODY, NOBODY)
    status, answer, talk = call(cache)

    assert (status, answer) == (0, TORQUE["1"])
    assert not planted.exists()
    assert f"it belongs to another user ({NOBODY})" in talk


@pytest.mark.mends("1.5")
def test_a_library_in_use_does_not_see_what_becomes_of_its_file(cache):
    path = entry_of(cache)

    def cut_meanwhile(m1: str) -> str:
        module = build(ARMS[m1])
        os.truncate(path, 0)
        return str(module.inverse_dynamics(*STATE).round(6).tolist())

    status, answer, _ = call(cache, work=cut_meanwhile)
    assert (status, answer) == (0, TORQUE["1"])


@pytest.mark.wide("a half", "a pipe")
@pytest.mark.parametrize("damage", ["a half", "flipped bits", "a pipe", "a link"])
def test_the_file_itself_is_loaded_where_memory_cannot_be(cache, damage, monkeypatch):
    monkeypatch.delattr(os, "memfd_create", raising=False)
    path = entry_of(cache)
    DAMAGES[damage](path)
    status, answer, talk = call(cache)

    assert (status, answer) == (0, TORQUE["1"])
    assert f"{path}: " in talk
    assert "compiled again" in talk


def test_what_a_killed_build_leaves_is_taken_away_by_the_next_and_what_a_running_one_has_is_not(cache):
    from symdyn.runtime.cache import folder_aside

    def killed(m1: str) -> str:
        with folder_aside(cache):
            os.kill(os.getpid(), signal.SIGKILL)
        return m1

    assert call(cache, work=killed)[0] == -signal.SIGKILL
    (dead,) = cache.iterdir()
    with folder_aside(cache) as alive:
        assert not dead.exists()
        assert call(cache)[0] == 0
        assert alive.exists()
    assert [path.suffix for path in cache.iterdir()] == [".so"]


@pytest.mark.slow
@pytest.mark.mends("1.5")
def test_a_motion_is_computed_over_a_damaged_entry_and_says_so(tmp_path):
    words = ["simulate", str(ARM.with_name("pendulum.toml")), "--until", "0.1", "--every", "0.1", "--method", "dop853"]
    environment = {**os.environ, "SYMDYN_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}

    def simulate() -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "symdyn", *words]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)

    first = simulate()
    entries = list(tmp_path.glob("*.so"))
    for path in entries:
        cut(path, 0.5)
    second = simulate()

    assert entries
    assert (second.returncode, second.stdout) == (0, first.stdout)
    assert second.stderr.count("compiled again") == len(entries)
