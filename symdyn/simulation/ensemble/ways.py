"""The table of ways to run an ensemble; the first that applies is taken."""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.simulation.ensemble import abreast, one_by_one, taylor_abreast
from symdyn.simulation.ensemble.task import Task, Way

WAYS: Mapping[str, Way] = {
    "abreast": abreast.WAY,
    "taylor abreast": taylor_abreast.WAY,
    "one by one": one_by_one.WAY,
}
"""By name, in the order in which they are tried; the last one takes everything."""


def choose(task: Task) -> tuple[str, Way, str]:
    """Return the way that runs a task, its name, and why no faster one does, "" if none was refused."""
    why: list[str] = []
    for name, way in WAYS.items():
        if way.methods and task.method is not None and task.method not in way.methods:
            continue
        reason = way.refuses(task)
        if not reason:
            return name, way, "; ".join(dict.fromkeys(why))
        why.append(reason)
    raise AssertionError("the last way takes everything")
