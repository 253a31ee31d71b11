"""The door `sweep`: runs of one scene at many values, in blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from symdyn.scene import Scene, SceneLike, bind, scene_of
from symdyn.scene.units import coordinate_units, velocity_units
from symdyn.scene.values.names import suggestion
from symdyn.scene.values.table import Faults
from symdyn.simulation.prescribed.formulas_in_time import close, parameter_values
from symdyn.study.block import Found, block
from symdyn.study.design import read_design
from symdyn.study.distributions import read_over
from symdyn.study.job import Job, Measured
from symdyn.study.study import MOST_TOLD, Study

BLOCK = 1024
"""Runs of a block, where nothing else is said."""


def sweep(
    scene: SceneLike,
    over: Mapping[str, Any] | Iterable[str] | str,
    measure: str | Sequence[str],
    *,
    until: float = 10.0,
    start: Mapping[str, Any] | None = None,
    start_rates: Mapping[str, Any] | None = None,
    design: str | None = None,
    count: int | None = None,
    seed: int = 0,
    block: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Study:
    """Return what comes of many runs of a scene.

    >>> import symdyn
    >>> study = symdyn.sweep(symdyn.example("pendulum"), "m1=linspace(1,2,3)", "max(abs(q1))", until=1)
    >>> study.values[:, 0].tolist()
    [1.0, 1.5, 2.0]

    Args:
        scene: the mechanism.
        over: what is varied: texts "NAME=DISTRIBUTION" (see `symdyn.study.distributions`), or lists by name; a name is
            a parameter, a coordinate or a velocity at the start.
        measure: formulas of folds over a run, such as "max(abs(tau2))"; "NAME=FORMULA" names one.
        until: time of the end of every run, s.
        start: coordinates as for `simulate`, the same for every run.
        start_rates: velocities likewise.
        design: a key of `DESIGNS`; None takes a grid of lists, or random draws.
        count: how many runs are drawn.
        seed: of what is drawn; the same seed gives the same numbers, however the work is divided.
        block: runs of one block.
        progress: called with the share that is done.

    Raises:
        SimulateError: with every fault of the arguments, one line each.
    """
    job = prepared(
        scene_of(scene), over, measure, until=until, start=start, start_rates=start_rates, design=design, count=count,
        seed=seed, block=block,
    )  # fmt: skip
    return made(job, progress)


def prepared(
    scene: Scene,
    over: Mapping[str, Any] | Iterable[str] | str,
    measure: str | Sequence[str],
    *,
    until: float,
    start: Mapping[str, Any] | None,
    start_rates: Mapping[str, Any] | None,
    design: str | None,
    count: int | None,
    seed: int,
    block: int | None,
) -> Job:
    """Return what `sweep` is to make; arguments and errors as there."""
    faults = Faults("")
    known = {one.name: one.value for one in scene.parameters if one.value is not None}
    varied = read_over(over, known, faults)
    planned = read_design(varied, design, count, seed, faults)
    parts: dict[str, list[str]] = {"values": [], "start": [], "start_rates": []}
    for one in varied:
        part = _part(scene, one.name)
        if part is None:
            there = (*(p.name for p in scene.parameters), *scene.coordinates, *scene.velocities)
            faults.add("over", f"{one.name} is not known; {suggestion(one.name, there)}")
        else:
            parts[part].append(one.name)
    measures = tuple(_measured(text) for text in ([measure] if isinstance(measure, str) else measure))
    close(faults)
    assert planned is not None, "what is missing is a fault"
    first = dict(zip(planned.names, planned.values(0, 1)[0].tolist(), strict=True))
    free = {one.name: first[one.name] for one in scene.free_parameters if one.name in first}
    scene = bind(scene, free) if free else scene
    parameter_values(scene)
    asked = {"until": until, "start": dict(start or {}), "start_rates": dict(start_rates or {}), "varied": parts}
    said = tuple((key, str(value)) for key, value in asked.items() if key != "varied")
    return Job("runs", scene, planned, measures, asked, said, block or BLOCK)


def _part(scene: Scene, name: str) -> str | None:
    if name in [one.name for one in scene.parameters]:
        return "values"
    return "start" if name in scene.coordinates else "start_rates" if name in scene.velocities else None


def _measured(text: str) -> Measured:
    name, equals, formula = (part.strip() for part in text.partition("="))
    return Measured(name, formula) if equals else Measured(text.strip(), text.strip())


def units_of(job: Job) -> dict[str, str]:
    """Return the unit of every column, "" where it is not known."""
    scene = job.scene
    known = {one.name: one.unit for one in scene.parameters}
    known |= dict(zip(scene.coordinates, coordinate_units(scene), strict=True))
    known |= {name: f"{unit}/s" for name, unit in zip(scene.velocities, velocity_units(scene), strict=True)}
    return {name: known.get(name, "") for name in job.design.names} | {one.name: one.unit for one in job.measures}


def made(job: Job, progress: Callable[[float], None] | None = None) -> Study:
    """Return the study that a job makes."""
    began = perf_counter()
    count = job.design.count
    measures = np.full((count, len(job.measures)), np.nan)
    codes = np.zeros(count, dtype=np.uint8)
    told: dict[int, str] = {}
    for k in range(job.blocks):
        found: Found = block(job, k)
        first, last = job.span(k)
        measures[first:last], codes[first:last] = found.measures, found.codes
        told = dict(sorted((told | dict(found.told)).items())[:MOST_TOLD])
        if progress is not None:
            progress((k + 1) / job.blocks)
    return Study(
        job.scene.name, job.design.names, units_of(job), job.design.values(),
        {one.name: measures[:, k] for k, one in enumerate(job.measures)}, codes, told, job.told,
        wall=perf_counter() - began,
    )  # fmt: skip
