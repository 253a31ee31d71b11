"""The cache trusts nothing: what is damaged, another's, or in a folder that others may write to is never run."""

from __future__ import annotations

import importlib
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

import symdyn
from symdyn.build.compiler import find_compiler
from symdyn.errors import BuildError

ROOT = Path(symdyn.__file__).parent.parent
ARM = ROOT / "examples" / "two_link.toml"
NOBODY = 65534

try:
    find_compiler()
except BuildError:
    pytest.skip("no C compiler", allow_module_level=True)

CALL = """
import sys, symdyn
arm = symdyn.load(sys.argv[1], "inverse_dynamics", parameters={"m1": sys.argv[2]})
print(arm.inverse_dynamics([0.3, 0.5], [1.0, -2.0], [0.7, 1.1], [1, 1, 1, 9.81]).round(6).tolist(), arm.compiled)
"""

TORQUE = {"1": "[18.229326, 9.930997] True", "2": "[21.828379, 9.930997] True"}


@pytest.fixture
def cache(tmp_path) -> Path:
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o700)
    return folder


def call(cache: Path, m1: str = "1", code: str = CALL) -> tuple[int, str, str]:
    """Load the arm in a process of its own and return its status, answer and talk."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "SYMDYN_CACHE_DIR": str(cache)}
    ran = subprocess.run(
        [sys.executable, "-c", code, str(ARM), m1], env=environment, capture_output=True, text=True, check=False
    )
    return ran.returncode, ran.stdout.strip(), ran.stderr


def entry_of(cache: Path, m1: str = "1") -> Path:
    """Return the file that a load leaves in the cache."""
    before = set(cache.iterdir())
    assert call(cache, m1) == (0, TORQUE[m1], "")
    (path,) = set(cache.iterdir()) - before
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
    room = importlib.util.find_spec("symdyn.build.entry")
    if room is not None:  # whoever writes libraries writes their hashes too
        importlib.import_module("symdyn.build.entry").seal(path)
    return canary


def test_a_stranger_in_a_folder_of_the_users_own_is_the_user(cache, planted):
    call(cache)

    assert planted.exists(), "the harness sees what is run"


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
    cuts = f"{CALL}import os\nos.truncate({str(path)!r}, 0)\n{CALL.splitlines()[-1]}"
    status, answer, _ = call(cache, code=cuts)

    assert (status, answer) == (0, f"{TORQUE['1']}\n{TORQUE['1']}")


def test_the_file_itself_is_loaded_where_memory_cannot_be(cache):
    path = entry_of(cache)
    by_path = "import os; vars(os).pop('memfd_create', None)\n" + CALL
    assert call(cache, code=by_path) == (0, TORQUE["1"], "")
    for damage in DAMAGES.values():
        damage(path)
        status, answer, talk = call(cache, code=by_path)
        assert (status, answer) == (0, TORQUE["1"])
        assert "compiled again" in talk
