"""What comes of one block, and which values are none of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.study.job import Job


@dataclass(frozen=True)
class BlockResult:
    """What came of one block.

    Attributes:
        measures: shape (n, measures).
        codes: how each run ended, shape (n,), of bytes.
        told: in words what ended the first few of those that did not reach their end, by number of the run.
        notes: what a user should know, such as the method.
    """

    measures: Array
    codes: Any
    told: Mapping[int, str]
    notes: tuple[str, ...] = ()


def impossible(job: Job, values: Array) -> dict[int, str]:
    """Return, by row, why values are none of the scene: parameters above zero that are not."""
    told: dict[int, str] = {}
    positive = {one.name for one in job.scene.parameters if one.positive}
    above = [k for k, name in enumerate(job.design.names) if name in positive]
    if np.isfinite(values).all() and (values[:, above] > 0).all():
        return told
    for name, column in zip(job.design.names, values.T, strict=True):
        wrong = ~(column > 0) if name in positive else ~np.isfinite(column)
        why = "it must be positive" if name in positive else "it must be finite"
        told |= {int(row): f"{name} = {column[row]:g}; {why}" for row in np.flatnonzero(wrong)}
    return told
