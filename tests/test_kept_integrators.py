"""heyoka's integrators in the cache: the bits of fresh ones, made again for what differs, never read unchecked."""

from __future__ import annotations

import hashlib
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.errors import SymdynWarning
from symdyn.runtime.cache import Kept, seal
from symdyn.scene import bind
from symdyn.simulation.integrate import heyoka_expressions

heyoka = pytest.importorskip("heyoka")

MADE: list[float] = []


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "cache"))
    MADE.clear()
    return tmp_path / "cache"


def turning(tolerance: float = 1e-10, speed: float = 1.0):
    """Return the integrator of a pendulum whose length stays a parameter."""
    x, v = heyoka.make_vars("x", "v")
    rates = [v, -heyoka.par[0] * heyoka.sin(x) * speed]

    def make():
        MADE.append(tolerance)
        return heyoka.taylor_adaptive(list(zip([x, v], rates, strict=True)), [0.0, 0.0], tol=tolerance)

    return heyoka_expressions.integrator([x, v, *rates], {"tol": tolerance}, make)


def end(ta, length: float) -> bytes:
    ta.time, ta.state[:], ta.pars[:] = 0.0, [0.5, 0.0], [length]
    ta.propagate_until(3.0)
    return ta.state.tobytes()


def test_a_kept_integrator_has_the_bits_of_a_fresh_one_at_all_values(cache):
    fresh, again = turning(), turning()
    assert len(MADE) == 1
    assert fresh is not again, "each has a state of its own"
    for length in (9.81, 2.0):
        assert end(fresh, length) == end(again, length)


def test_what_differs_is_made_again(cache, monkeypatch):
    turning()
    turning(1e-12)
    turning(speed=2.0)
    monkeypatch.setattr(heyoka, "__version__", "0")
    turning()
    monkeypatch.setattr(heyoka_expressions, "processor", lambda: ("another",))
    turning()
    assert len(MADE) == 5


class Trap:
    """What leaves a file behind where its pickle is read."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


@pytest.mark.skipif(sys.platform == "win32", reason="no modes and links there")
@pytest.mark.parametrize("how", ["no seal", "damaged", "another's name", "others may write", "a link"])
def test_what_is_not_ours_is_never_read_as_code(cache, tmp_path, how):
    turning()
    (entry,) = cache.glob("*.heyoka")
    trap = pickle.dumps(Trap(tmp_path / "sprung"))
    if how == "no seal":
        entry.write_bytes(trap)
    elif how == "damaged":
        entry.write_bytes(bytes(255 - byte if k == 40 else byte for k, byte in enumerate(entry.read_bytes())))
    else:
        other = entry.with_name("other.heyoka" if how == "another's name" else entry.name)
        other.write_bytes(trap)
        seal(other)
        if how == "others may write":
            entry.chmod(0o666)
        if how == "another's name":
            other.replace(entry)
        if how == "a link":
            entry.rename(tmp_path / entry.name)
            entry.symlink_to(tmp_path / entry.name)
    with pytest.warns(SymdynWarning, match="made again"):
        turning()
    assert not (tmp_path / "sprung").exists()
    assert len(MADE) == 2
    turning()
    assert len(MADE) == 2, "a whole one is kept again"


def test_without_a_folder_to_keep_it_in_it_is_made(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "file" / "cache"))
    assert end(turning(), 1.0) == end(turning(), 1.0)


def test_what_cannot_be_read_as_an_integrator_is_made_again(cache):
    turning()
    (entry,) = cache.glob("*.heyoka")
    Kept(entry.name).keep(b"of another kind", 9)
    end(turning(), 1.0)
    assert len(MADE) == 2


def test_a_cache_that_may_only_be_read_serves_as_well(cache, monkeypatch):
    Kept("a.thing").keep(b"whole", 1)
    monkeypatch.setattr(os, "utime", lambda *_: (_ for _ in ()).throw(OSError(30, "Read-only file system")))
    assert Kept("a.thing").content() == b"whole"


def test_those_that_were_wanted_last_stay(cache):
    for k in range(3):
        Kept(f"{k}.thing").keep(b"%d" % k, 3)
        os.utime(cache / f"{k}.thing", (k, k))
    assert Kept("0.thing").content() == b"0"
    Kept("3.thing").keep(b"3", 3)
    assert sorted(path.name for path in cache.iterdir()) == ["0.thing", "2.thing", "3.thing"]


@pytest.mark.runs("cc")
@pytest.mark.long
def test_runs_at_other_values_of_parameters_take_the_same_integrator(cache):
    runs = []
    for mass in (1, 2):
        for _ in range(2):
            scene = bind(symdyn.example("double_pendulum"), {"m1": mass})
            run = symdyn.simulate(scene, until=1.0, start={"q1": 1.0, "q2": 2.0})
            runs.append(hashlib.sha256(np.ascontiguousarray(run.q)).hexdigest())
    assert runs[0] == runs[1] != runs[2] == runs[3]
    assert len(list(cache.glob("*.heyoka"))) == 1


@pytest.mark.slow
@pytest.mark.runs("cc")
@pytest.mark.long
@pytest.mark.skipif(not hasattr(heyoka.llvm_state, "set_diskcache_path"), reason="this heyoka keeps nothing")
@pytest.mark.skipif(os.name != "posix", reason="modes of POSIX")
def test_heyoka_keeps_its_own_code_where_only_the_user_may_write(tmp_path):
    arm, home = Path(__file__).parent.parent / "examples" / "pendulum.toml", tmp_path / "home"
    home.mkdir()
    (tmp_path / "spoilt" / "heyoka" / "cache.db").mkdir(parents=True)
    for name, mode in (("own", 0o700), ("shared", 0o777), ("spoilt", 0o700)):
        (tmp_path / name).mkdir(exist_ok=True)
        (tmp_path / name).chmod(mode)
        places = {"HOME": str(home), "XDG_CACHE_HOME": str(home), "SYMDYN_CACHE_DIR": str(tmp_path / name)}
        words = [sys.executable, "-m", "symdyn", "simulate", str(arm), "--until", "1", "--start", "q1=1"]
        where = {key: value for key, value in os.environ.items() if key != "HEYOKA_CACHE_DIR"}
        told = subprocess.run([*words, "--method", "taylor"], check=True, capture_output=True, env=where | places)
        assert b"[warning]" not in told.stdout + told.stderr
    assert (tmp_path / "own" / "heyoka" / "cache.db").exists()
    assert list((tmp_path / "shared").iterdir()) == []
    assert list(home.rglob("*.db")) == []
