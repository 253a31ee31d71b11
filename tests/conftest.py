"""What every test may ask for."""

from __future__ import annotations

import gc
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import chosen
import programs
import pytest
from browser import chromium
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers
from hypothesis.internal.entropy import deterministic_PRNG
from patience import HANG

# Else every process that a test starts compiles all of symdyn anew, and every worker all tests; git ignores the files.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

os.environ.setdefault("MUJOCO_GL", "off")  # nothing is rendered, and what renders is looked for by a process
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: small matrices wait for threads on a busy machine
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a shell's background; what tests start ignored it
    signal.signal(signal.SIGINT, signal.default_int_handler)

for way in ("CONNECT", "TCP"):  # before Dask, and for what it starts
    os.environ[f"DASK_DISTRIBUTED__COMM__TIMEOUTS__{way}"] = f"{HANG}s"

settings.register_profile(
    "always the same", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("always the same")  # what a machine is busy with fails no test, and new cases are the fuzzer's
providers._get_local_constants = lambda: providers._local_constants  # else a number in any file changes what is tried
with deterministic_PRNG():
    pass  # it collects garbage the first time: here there is none yet, and later seconds of looking for some

gc.set_threshold(30_000_000)  # graphs are large and hold no circles: to look for some takes seconds each time

CACHE = Path(__file__).parent.parent / "build" / "cache"
"""Compiled code of tests, apart from the user's: one for all workers, and for the next runs."""

os.environ["HEYOKA_CACHE_DIR"] = str(CACHE / "heyoka")  # before heyoka, which keeps its code below the home else

KEPT = 2 * 86400.0
"""Seconds after which what was compiled is compiled again."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-golden", action="store_true", help="rewrite committed output instead of comparing")
    parser.addoption("--quick", action="store_true", help="only what starts no program and takes no long")


def pytest_configure(config: pytest.Config) -> None:
    programs.begin()
    if not hasattr(config, "workerinput"):  # before there are workers, which would take away what another looks at
        for old in CACHE.glob("[!.]*"):
            if time.time() - old.stat().st_mtime > KEPT:
                shutil.rmtree(old, ignore_errors=True) if old.is_dir() else old.unlink(missing_ok=True)


@pytest.hookimpl(tryfirst=True)  # before those are left out that are slow
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark as slow what other cases of the same law stand for; leave out of quick runs what takes long or programs."""
    functions = chosen.by_function(items).values()
    config.stash[chosen.UNMET] = [name for cases in functions for name in chosen.unmet(cases)]
    for cases in functions:
        for item in chosen.spared(cases):
            item.add_marker(pytest.mark.slow)
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.runs("chromium"))
    if config.getoption("--quick"):
        kept = {item for cases in functions for item in chosen.quick(cases)}
        config.hook.pytest_deselected(items=[item for item in items if item not in kept])
        items[:] = [item for item in items if item in kept]


def pytest_collection_finish() -> None:
    gc.freeze()  # what was imported stays


def pytest_sessionfinish() -> None:
    gc.freeze()  # whoever ends need not look for circles in what is left


@pytest.fixture
def young() -> None:
    """`gc.collect()` looks through what the test makes: to look through what all before it left takes a minute."""
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Iterator[None]:
    if not session.config.pluginmanager.hasplugin("dsession"):  # whose workers alone import what that takes
        import sooner

        sooner.begin(well=session.config.getoption("markexpr") == "slow")
    with programs.starting(False):
        if worker := os.environ.get("PYTEST_XDIST_WORKER"):
            _compile_first(int(worker.removeprefix("gw")), int(os.environ["PYTEST_XDIST_WORKER_COUNT"]))
        return (yield)


def _compile_first(worker: int, workers: int) -> None:
    """Import the tests of each n-th file: what one worker has compiled so the others find, instead of doing it too."""
    for path in sorted(Path(__file__).parent.glob("test_*.py"))[worker::workers]:
        with suppress(Exception, pytest.skip.Exception):  # whoever collects it tells
            import_module(path.stem)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    with programs.starting(item.get_closest_marker("runs") is not None):
        return (yield)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    for mark in item.iter_markers("runs"):
        if absent := programs.missing(mark.args):
            pytest.skip(f"there is no {' and no '.join(absent)}")


@pytest.fixture
def update_golden(request: pytest.FixtureRequest) -> bool:
    """Whether golden files are to be rewritten: `pytest --update-golden`."""
    return bool(request.config.getoption("--update-golden"))


@pytest.fixture
def numpy_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let certificates measure the NumPy module alone: for tests of what is proved, since compiling takes longest."""
    from symdyn.verify import building

    monkeypatch.setattr(building, "RUNNERS", {"numpy": building.RUNNERS["numpy"]})


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Return a Chromium; the test is skipped where there is none."""
    with chromium() as found:
        yield found


@pytest.fixture(scope="session", autouse=True)
def cache_of_tests() -> Iterator[None]:
    """Keep compiled code of tests out of the user's cache."""
    before = os.environ.get("SYMDYN_CACHE_DIR")
    os.environ["SYMDYN_CACHE_DIR"] = str(CACHE)
    yield
    if before is None:
        del os.environ["SYMDYN_CACHE_DIR"]
    else:
        os.environ["SYMDYN_CACHE_DIR"] = before


@pytest.fixture(scope="module")
def optimised() -> Iterator[None]:
    """Compile well, as users have it, in all of a module: for tests of what optimised code does."""
    import sooner

    with sooner.optimised():
        yield


ZIG = Path(__file__).parent.parent / "build" / "zig"


@pytest.fixture(scope="session")
def zig() -> list[str]:
    """The compiler of the ziglang package, put into a folder that `make clean` takes away."""
    if find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang"]
    program = ZIG / "ziglang" / "zig"
    if not program.is_file():
        words = [sys.executable, "-m", "pip", "install", "--quiet", "--target", str(ZIG), "ziglang"]
        got = subprocess.run(words, capture_output=True, text=True, check=False)
        if got.returncode:
            pytest.skip(f"zig cannot be had here: {got.stderr.strip().splitlines()[-1]}")
    return [str(program)]
