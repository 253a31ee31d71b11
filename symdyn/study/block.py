"""One block of a job, in any process: a function of this module, which a worker imports; what it built stays there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.errors import SymdynError
from symdyn.simulation import Ensemble, ensemble
from symdyn.study.block_result import BlockResult, impossible
from symdyn.study.job import Job
from symdyn.study.place_block import at_places
from symdyn.study.study import ENDED, FAILED, MOST_TOLD, STOPPED

Rows: TypeAlias = NDArray[np.int64]

NO_NUMBER = "the motion has no finite value"


def block(job: Job, k: int) -> BlockResult:
    """Return what comes of block k of a job."""
    found: BlockResult = KINDS[job.kind].run(job, *job.span(k))
    return found


def _runs(job: Job, first: int, last: int) -> BlockResult:
    """Return measures over runs; those at values that the scene cannot have fail alone, and the others go on."""
    values = job.design.values(first, last)
    measures = np.full((len(values), len(job.measures)), np.nan)
    codes = np.full(len(values), FAILED, dtype=np.uint8)
    told, notes = impossible(job, values), dict[str, None]()
    rows = np.array([row for row in range(len(values)) if row not in told], dtype=np.int64)
    for some, found in _possible(job, values, rows, told):
        words = [found.words[one] for one in found.stopped]
        if found.interrupted:
            raise KeyboardInterrupt
        notes |= dict.fromkeys(found.notes)
        began = np.isfinite(found.q).all(axis=1)
        ended = found.complete
        codes[some] = np.where(began & ended, ENDED, np.where(began, STOPPED, FAILED))
        for column, one in enumerate(job.measures):
            measures[some, column] = found.measures[one.formula]
        told |= {int(row): word for row, word, whole in zip(some, words, ended, strict=True) if not whole}
        told |= {int(row): NO_NUMBER for row in some[ended & ~began]}
    measures[codes == FAILED] = np.nan
    return BlockResult(
        measures, codes, dict(sorted((first + row, word) for row, word in told.items())[:MOST_TOLD]), tuple(notes)
    )


def _possible(job: Job, values: Array, rows: Rows, reported: dict[int, str]) -> Iterator[tuple[Rows, Ensemble]]:
    """Yield rows and their runs; rows that spoil the others are found by halving, and their words go to `reported`."""
    if not len(rows):
        return
    try:
        found = _together(job, values[rows])
    except SymdynError as fault:
        if len(rows) == 1:
            reported[int(rows[0])] = " ".join(str(fault).split())
            return
        for half in np.array_split(rows, 2):
            yield from _possible(job, values, half, reported)
        return
    yield rows, found


def _together(job: Job, values: Array) -> Ensemble:
    """Return runs at these values."""
    asked, columns = job.asked, dict(zip(job.design.names, values.T, strict=True))
    parts: dict[str, Any] = {
        part: dict(asked.get(part, {})) | {n: columns[n] for n in names} for part, names in asked["varied"].items()
    }
    formulas = [one.formula for one in job.measures]
    return ensemble(
        job.scene, forces=asked["forces"], **parts, measures=formulas, workers=job.threads, **vars(asked["run"])
    )


@dataclass(frozen=True)
class BlockKind:
    """What is computed of a set of values.

    Attributes:
        run: from job, the number of the first run, and that behind the last one.
    """

    run: Callable[[Job, int, int], BlockResult]


KINDS: Mapping[str, BlockKind] = {"runs": BlockKind(_runs), "places": BlockKind(at_places)}
"""What a job can be of."""
