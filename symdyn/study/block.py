"""One block of a job, in any process: a function of this module, which a worker imports; what it built stays there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.errors import SymdynError
from symdyn.study.job import Job
from symdyn.study.study import ENDED, FAILED, MOST_TOLD


@dataclass(frozen=True)
class Found:
    """What came of one block.

    Attributes:
        measures: shape (n, measures).
        codes: how each run ended, shape (n,), of bytes.
        told: in words what ended the first few of those that did not reach their end, by number of the run.
    """

    measures: Array
    codes: Any
    told: Mapping[int, str]


def block(job: Job, k: int) -> Found:
    """Return what comes of block k of a job."""
    first, last = job.span(k)
    values = job.design.values(first, last)
    found: Found = KINDS[job.kind].run(job, values, first)
    return found


def _runs(job: Job, values: Array, first: int) -> Found:
    """Return measures over runs of `simulate`."""
    from symdyn.simulation import simulate

    measures = np.full((len(values), len(job.measures)), np.nan)
    codes = np.full(len(values), FAILED, dtype=np.uint8)
    told: dict[int, str] = {}
    for row, some in enumerate(values):
        by_name = dict(zip(job.design.names, some.tolist(), strict=True))
        parts = {part: {n: by_name[n] for n in names} for part, names in job.asked["varied"].items()}
        start = job.asked["start"] | parts["start"]
        rates = job.asked["start_rates"] | parts["start_rates"]
        try:
            run = simulate(job.scene, until=job.asked["until"], values=parts["values"], start=start, start_rates=rates)
        except SymdynError as fault:
            told[first + row] = str(fault)
            continue
        codes[row] = ENDED
        for k, one in enumerate(job.measures):
            measures[row, k] = np.max(np.abs(run[one.formula.removeprefix("max(abs(").removesuffix("))")]))
    return Found(measures, codes, dict(sorted(told.items())[:MOST_TOLD]))


@dataclass(frozen=True)
class Kind:
    """What is computed of a set of values.

    Attributes:
        run: from job, values of shape (n, names), and the number of the first run.
    """

    run: Callable[[Job, Array, int], Found]


KINDS: Mapping[str, Kind] = {"runs": Kind(_runs)}
"""What a job can be of."""
