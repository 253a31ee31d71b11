"""Blocks that workers of another process import, and what they find instead of symdyn."""

from __future__ import annotations

import os
import signal
import sys
import time
from importlib.abc import MetaPathFinder
from pathlib import Path
from typing import Any

import numpy as np

import symdyn


def squares(job: int, k: int) -> Any:
    return job * np.arange(100.0 * k, 100.0 * (k + 1)) ** 2


def who(job: Path, k: int) -> int:
    """Leave a mark that a worker computed it, and say which."""
    with open(job / f"{k}", "a") as file:
        file.write(f"{os.getpid()}\n")
    return os.getpid()


def slow(job: Path, k: int) -> int:
    time.sleep(0.05)
    return who(job, k)


def killed(job: Path, k: int) -> Any:
    """Kill the process that computes one of the first blocks, the first time."""
    who(job, k)
    if k == 3 and not (job / "killed").exists():
        (job / "killed").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return squares(7, k)


def deadly(job: None, k: int) -> Any:
    if k == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return k


def wrong(job: None, k: int) -> Any:
    if k == 2:
        raise symdyn.SymdynError("m1: -1 is not positive")
    return k


def library(job: symdyn.Scene, k: int) -> tuple[int, Any]:
    """Return who computed it, and forces of a compiled function that each worker loads once."""
    if "arm" not in KEPT:
        KEPT["arm"] = symdyn.load(job, "inverse_dynamics")
        KEPT["loads"] = KEPT.get("loads", 0) + 1
    assert KEPT["loads"] == 1
    time.sleep(0.05)  # so that the other worker is asked as well
    return os.getpid(), KEPT["arm"].inverse_dynamics([0.1 * k, 0.2], [0, 1], [1, 0], m1=1, m2=2, h1=1, h2=1, g=9.81)


KEPT: dict[str, Any] = {}


class Hidden(MetaPathFinder):
    """A worker where symdyn is not installed."""

    def find_spec(self, name: str, path: object, target: object = None) -> None:
        if name.partition(".")[0] == "symdyn":
            raise ModuleNotFoundError("No module named 'symdyn'", name="symdyn")


def hide(dask_worker: object = None) -> None:
    for name in [one for one in sys.modules if one.partition(".")[0] == "symdyn"]:
        del sys.modules[name]
    sys.meta_path.insert(0, Hidden())


def other_version() -> None:
    from symdyn import resources

    resources.version = lambda: "0.0.1"  # type: ignore[assignment]
