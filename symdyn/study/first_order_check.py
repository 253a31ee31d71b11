"""Measures of a run to first order, beside the same measures over many runs: these differ where it is not linear."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from symdyn.errors import SimulateError
from symdyn.scene.values import Faults
from symdyn.simulation import Problem, Run, measure_slopes
from symdyn.study.covariances import read_spread
from symdyn.study.study import Study

NEAR = 0.1
"""Part by which two standard deviations may differ, beside what so few runs leave open."""


@dataclass(frozen=True)
class Beside:
    """The standard deviation of one measure, two ways.

    Attributes:
        measure: its name.
        first_order: by derivatives.
        runs: of the runs that have a value.
        shares: which part of the former's square each name is to blame for.
        near: whether they agree as far as so many runs can tell.
    """

    measure: str
    first_order: float
    runs: float
    shares: Mapping[str, float]
    near: bool


def beside(
    study: Study, problem: Problem, run: Run, over: Mapping[str, Any] | Iterable[str] | str, measures: Sequence[str]
) -> tuple[Beside, ...]:
    """Return the standard deviations of measures to first order beside those of a study of that problem and run.

    Other arguments are as of `sweep`; of the run only `until` and `every` are looked at.

    Raises:
        SimulateError: with every fault; or a measure without a value at the means.
    """
    scene, faults = problem.scene, Faults("")
    spread = faults.taken(lambda: read_spread(scene, over, None, faults), None)
    faults.close(SimulateError)
    assert spread is not None, "what is missing is a fault"
    named = [text.partition("=") for text in measures]
    names = [name.strip() for name, _, _ in named]
    formulas = [formula.strip() if equals else name for name, equals, formula in named]
    slopes = measure_slopes(problem.moved(*spread.moved(scene)), run, formulas, spread.names)
    lacking = [name for name, row in zip(names, slopes, strict=True) if not np.all(np.isfinite(row))]
    if lacking:
        raise SimulateError(f"{scene.name}: to first order there is no value of {', '.join(lacking)}")
    told = []
    for name, row in zip(names, slopes, strict=True):
        parts = row * (spread.covariance @ row)
        first, many = sqrt(max(float(parts.sum()), 0.0)), study.sd(name)
        shares = {
            one: float(part / parts.sum()) if first else 0.0 for one, part in zip(spread.names, parts, strict=True)
        }
        count = max(len(study.known(name)), 2)
        near = abs(many - first) <= (NEAR + 3 / sqrt(2 * count)) * max(first, many)
        told.append(Beside(name, first, many, shares, near))
    return tuple(told)
