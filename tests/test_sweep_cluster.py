"""Blocks of a study on real clusters of Dask: whatever happens to workers, nothing is lost and nothing is twice."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cluster_blocks as blocks
import numpy as np
import pytest
from patience import HANG

import symdyn
from symdyn.errors import StudyError
from symdyn.study.job import EXECUTORS, executor

distributed = pytest.importorskip("distributed")
cluster = pytest.importorskip("symdyn.study.cluster")

EXAMPLES = Path(__file__).parent.parent / "examples"

WHERE = [name for name in EXECUTORS if name != "here"]

pytestmark = [pytest.mark.runs(), pytest.mark.long]


@pytest.fixture(scope="module")
def two() -> Iterator[Any]:
    """Return a client of two worker processes, each of one thread."""
    with local(2) as found:
        yield found


class local:  # noqa: N801  used as a function
    """A cluster on this machine, as somebody else would begin it."""

    def __init__(self, workers: int) -> None:
        self.cluster = distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL
        )
        self.client = distributed.Client(self.cluster, set_as_default=False)

    def __enter__(self) -> Any:
        self.client.wait_for_workers(len(self.cluster.workers))
        return self.client

    def __exit__(self, *_: object) -> None:
        self.client.close()
        self.cluster.close()


def expected(count: int) -> list[Any]:
    return [blocks.squares(7, k) for k in range(count)]


@pytest.mark.parametrize("where", WHERE)
def test_every_executor_computes_each_block_once(where: str) -> None:
    with executor(where, 2) as found:
        assert found.workers == 2
        pairs = list(found.results(blocks.squares, 7, range(20)))

    assert sorted(k for k, _ in pairs) == list(range(20))
    assert all(np.array_equal(dict(pairs)[k], one) for k, one in enumerate(expected(20)))


def test_a_worker_that_is_killed_loses_nothing_and_nothing_comes_twice(tmp_path: Path) -> None:
    with local(2) as client, executor(client) as found:
        pairs = list(found.results(blocks.killed, tmp_path, range(12)))

    assert (tmp_path / "killed").exists()
    assert sorted(k for k, _ in pairs) == list(range(12)), "each comes once"
    assert len((tmp_path / "3").read_text().split()) >= 2, "the one that was under way is computed again"
    assert all(dict(pairs)[k].tobytes() == one.tobytes() for k, one in enumerate(expected(12)))


@pytest.mark.slow
def test_the_only_worker_that_is_killed_is_made_up_for(tmp_path: Path) -> None:
    with executor("processes", 1) as found:  # the job was in its memory, and in no other
        pairs = dict(found.results(blocks.killed, tmp_path, range(6)))

    assert (tmp_path / "killed").exists()
    assert all(pairs[k].tobytes() == one.tobytes() for k, one in enumerate(expected(6)))


@pytest.mark.slow
def test_a_block_that_kills_whoever_computes_it_is_named() -> None:
    with (
        executor("processes", 1) as found,
        pytest.raises(StudyError, match=r"block \d, or one beside it: .* was killed.*smaller"),
    ):
        list(found.results(blocks.deadly, None, range(4)))


def test_what_a_block_raises_is_raised_here(two: Any) -> None:
    with executor(two) as found, pytest.raises(symdyn.SymdynError, match="m1: -1 is not positive"):
        list(found.results(blocks.wrong, None, range(4)))


def test_few_blocks_are_ever_begun_ahead(two: Any, tmp_path: Path) -> None:
    begun: list[int] = []

    def numbers() -> Iterator[int]:
        for k in range(200):
            begun.append(k)
            yield k

    with executor(two) as found:
        for taken, _ in enumerate(found.results(blocks.squares, 7, numbers())):
            assert len(begun) <= taken + 2 * cluster.AHEAD * found.workers + 1

    assert len(begun) == 200


@pytest.mark.slow
def test_a_caller_that_stops_leaves_nothing_under_way(two: Any, tmp_path: Path) -> None:
    with executor(two) as found:
        results: Any = found.results(blocks.slow, tmp_path, range(100))
        next(results)
        tasks = [task for _, task in results.gi_frame.f_locals["under_way"].values()]
        results.close()
    assert len(tasks) > 2
    assert all(task.cancelled() for task in tasks)
    before = len(list(tmp_path.iterdir()))
    time.sleep(1.0)

    assert before <= len(list(tmp_path.iterdir())) <= cluster.AHEAD * 2 + 1


@pytest.mark.slow
@pytest.mark.runs("cc")
def test_workers_that_begin_at_the_same_time_load_one_library(
    two: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    two.run(lambda folder: __import__("os").environ.__setitem__("SYMDYN_CACHE_DIR", folder), str(tmp_path / "cache"))
    arm = symdyn.example("two_link")
    with executor(two) as found:
        pairs = dict(found.results(blocks.library, arm, range(40)))

    assert len({process for process, _ in pairs.values()}) == 2
    assert len(list((tmp_path / "cache").glob("two_link-*.so"))) == 1
    assert len(list((tmp_path / "cache").glob("*.so"))) == 2, "and the extension module that serves all scenes"
    ours = symdyn.load(arm, "inverse_dynamics")
    for k, (_, forces) in pairs.items():
        state = [0.1 * k, 0.2], [0, 1], [1, 0]
        assert np.array_equal(forces, ours.inverse_dynamics(*state, m1=1, m2=2, h1=1, h2=1, g=9.81))


def refused(where: Any, words: str, workers: int | None = None) -> None:
    with pytest.raises(StudyError, match=words), executor(where, workers):
        pass


@pytest.mark.slow
def test_workers_that_lack_symdyn_or_have_another_are_told() -> None:
    with local(1) as client:
        client.run(blocks.other_version)
        refused(client, r"tcp://.*: this worker has symdyn 0\.0\.1, and here is")
        client.run(blocks.hide)
        refused(client, r"this worker cannot import symdyn .*; install")


@pytest.mark.slow
def test_a_worker_that_comes_later_is_looked_at_too() -> None:
    with local(1) as client, executor(client) as found:
        client.run(blocks.other_version)
        with pytest.raises(StudyError, match=r"has symdyn 0\.0\.1, and the study is made by"):
            list(found.results(blocks.squares, 7, range(4)))


@pytest.mark.slow
def test_a_scheduler_that_goes_away_is_told() -> None:
    def go_on(found: Any, results: Iterator[tuple[int, Any]]) -> None:
        for k, _ in results:
            if k == 3:
                found.close()

    here = local(1)
    told = "the connection is lost; what is done is kept"
    with here as client, executor(client) as one, pytest.raises(StudyError, match=told):
        go_on(here.cluster, one.results(blocks.squares, 7, range(1000)))


@pytest.mark.parametrize(
    ("where", "workers", "words"),
    [
        ("thread", None, "'thread' is not known; give here, threads, processes, or an address"),
        ("threads", 0, "workers: 0 is none; give 1 or more"),
        ("tcp://127.0.0.1:9", 2, "a scheduler has the workers that it has"),
        ("tcp://127.0.0.1:9", None, r"nothing answers at tcp://127.0.0.1:9 .*dask scheduler"),
        ("udp://127.0.0.1:9", None, "nothing answers at udp://127.0.0.1:9"),
        ("tcp://", None, "nothing answers at tcp://"),
    ],
)
def test_places_that_are_none_are_told(where: str, workers: int | None, words: str, monkeypatch: Any) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    refused(where, words, workers)


@pytest.mark.slow
@pytest.mark.parametrize("where", EXECUTORS)
def test_ctrl_c_waits_for_what_is_under_way_and_begins_no_more(where: str) -> None:
    done: list[int] = []

    def go_on(results: Iterator[tuple[int, Any]]) -> None:
        for k, _ in results:
            done.append(k)
            if len(done) == 5:
                signal.raise_signal(signal.SIGINT)

    with executor(where, None if where == "here" else 2) as found, pytest.raises(KeyboardInterrupt):
        go_on(found.results(blocks.squares, 7, range(1000)))

    assert len(done) == len(set(done))
    assert 5 <= len(done) <= 5 + 2 * cluster.AHEAD * 2
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


TERMINAL = """
import os, signal, sys, threading
from distributed import Nanny
from symdyn.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it, and so would children
start = Nanny.start_unsafe
def begun(self):
    threading.Timer(float(sys.argv[1]), os.killpg, (os.getpgrp(), signal.SIGINT)).start()
    Nanny.start_unsafe = start
    return start(self)
Nanny.start_unsafe = begun
sys.exit(main(sys.argv[2:]))
"""


@pytest.mark.slow
@pytest.mark.mends("30.attacks.7")
@pytest.mark.runs("cc")
@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("after", [0.0, 0.3])
def test_ctrl_c_while_workers_begin_is_one_line(after: float, tmp_path: Path) -> None:
    """A terminal sends it to all processes, those among them that just begin."""
    words = "sweep pendulum.toml --over q1=uniform(0.1,1) --until 0.1 --measure end(q1) --scheduler processes"
    (tmp_path / "pendulum.toml").write_bytes((EXAMPLES / "pendulum.toml").read_bytes())
    done = subprocess.run(
        [sys.executable, "-c", TERMINAL, str(after), *words.split()],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}, capture_output=True, text=True,
        start_new_session=True, timeout=HANG, check=False,
    )  # fmt: skip

    assert done.returncode == 130
    assert [line for line in done.stderr.splitlines() if not line.startswith("symdyn: ")] == []
    assert "symdyn: interrupted" in done.stderr


PLACES = {
    "over": ["m1=uniform(1,2)", "m2=normal(2,0.1)", "h1=lognormal(1,0.1)", "q1=linspace(0,1,3)"],
    "measure": ["M1", "max(abs(M2))"],
    "function": "inverse_dynamics",
    "at": "q2=0.3,q1_ddot=1",
    "values": {"h2": 0.5, "g": 9.81},
    "design": "random",
    "count": 3000,
    "seed": 5,
}


def swept(**more: Any) -> symdyn.study.Runs:
    return symdyn.sweep(symdyn.example("two_link"), **(PLACES | more))


@pytest.mark.slow
@pytest.mark.runs("cc")
def test_a_sweep_whose_worker_is_killed_has_the_same_bytes(tmp_path: Path) -> None:
    expected, killed = swept(block=100), []

    def kill(share: float) -> None:
        if share > 0.2 and not killed:
            killed.extend(client.run(os.getpid).values())
            os.kill(killed[0], signal.SIGKILL)

    with local(2) as client:
        found = swept(block=100, scheduler=client, output=tmp_path / "killed.zarr", progress=kill)

    assert killed
    assert found.complete
    assert np.asarray(found.values).tobytes() == np.asarray(expected.values).tobytes()
    for name in expected.measures:
        assert found[name].tobytes() == expected[name].tobytes()


@pytest.mark.slow
@pytest.mark.runs("cc")
def test_a_sweep_that_is_interrupted_on_one_cluster_goes_on_on_another(tmp_path: Path) -> None:
    path, shares = tmp_path / "two.zarr", []

    def stop(share: float) -> None:
        shares.append(share)
        if len(shares) == 5:
            signal.raise_signal(signal.SIGINT)

    first = swept(block=100, scheduler="threads", workers=2, output=path, progress=stop)
    assert 0 < first.left < 3000
    assert "the same command goes on" in first.notes[-1]
    shares.clear()
    with local(1) as client:
        found = swept(block=100, scheduler=client.scheduler.address, output=path, progress=shares.append)

    assert len(shares) == first.left / 100, "no block is computed twice"
    expected = swept(block=700)
    assert all(found[name].tobytes() == expected[name].tobytes() for name in expected.measures)
