"""One function at many parameter sets: `prepare`, the function at every place, and measures over these.

Rows go through it a few hundred at a time, which stay in the cache of a core from the draw to the measures: with forty
parameters a hundred thousand at a time take three times as long.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from symdyn.algebra.numeric import Array, Batches
from symdyn.build.backends.door import load
from symdyn.build.loaded import Loaded
from symdyn.build.numeric_function import Operand
from symdyn.graph import Graph, evaluate
from symdyn.program.prepare import PREPARE
from symdyn.scene import Quantity, Scene, express
from symdyn.scene.values.table import Faults
from symdyn.scene.values.value import value_of
from symdyn.simulation.ensemble.measures import Measure, Sums, read_measure, sums_of
from symdyn.simulation.prescribed.forces import drive_names
from symdyn.study.found import Found, impossible
from symdyn.study.job import Job
from symdyn.study.study import ENDED, FAILED, MOST_TOLD

ROWS = 512
"""Numbers of parameter sets that go through at a time, times places: 512 of the PUMA's 40 are 160 kB."""

TIME = "t"

PARAMETERS = "params"

NO_NUMBER = "the function has no finite value"


@dataclass(frozen=True)
class Called:
    """A function that is called at places, and what its numbers are called.

    Attributes:
        loaded: the function and `prepare`, compiled, if anything is to be prepared.
        name: of the function.
        results: a name for each entry of what it returns.
    """

    loaded: Loaded
    name: str
    results: tuple[str, ...]

    @property
    def operands(self) -> tuple[Operand, ...]:
        """What is given by place: all arguments but parameters."""
        return tuple(one for one in self.loaded[self.name].operands if one.name not in (PARAMETERS, "prepared"))

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters that are arguments, in order."""
        first = self.loaded.calls[PREPARE if self.loaded.prepared else self.name]
        return next((one.entries for one in first.operands if one.name == PARAMETERS), ())

    @property
    def letters(self) -> tuple[str, ...]:
        """What measures may name beside parameters of the scene."""
        return (TIME, *(name for one in self.operands for name in one.entries), *self.results)


@lru_cache(maxsize=4)
def called(scene: Scene, function: str, free: tuple[str, ...]) -> Called:
    """Return a function with these parameters as arguments, compiled once a process.

    Raises:
        DerivationError: there is no such function.
    """
    found = load(scene, [function], prepare=True, free=free)
    name = list(found.calls)[-1]
    return Called(found, name, _results(scene, found, name))


def _results(scene: Scene, found: Loaded, name: str) -> tuple[str, ...]:
    """Return a name for every entry of the result: those of drives, else its own with places: tau1, M1_2, K."""
    result, shape = found.signatures[name].split(" -> ")[1].split(":")[0], _shape(found, name)
    if result == "tau" and shape == (len(scene.velocities),):
        return drive_names(scene)
    return tuple(result + "_".join(str(i + 1) for i in at) for at in np.ndindex(*shape))


def _shape(found: Loaded, name: str) -> tuple[int, ...]:
    inside = found.signatures[name].rsplit("->", 1)[1].strip("()")
    return tuple(int(one) for one in inside.split(",") if one)


@lru_cache(maxsize=4)
def _measures(scene: Scene, formulas: tuple[str, ...], letters: tuple[str, ...]) -> tuple[Measure, ...]:
    found = [read_measure(scene, formula, Faults(""), more=letters) for formula in formulas]
    return tuple(one for one in found if one is not None)


def at_places(job: Job, first: int, last: int) -> Found:
    """Return measures over places, of parameter sets from `first` on; those that are none of the scene fail alone."""
    call = called(job.scene, job.asked["function"], tuple(job.asked["varied"]["values"]))
    measures = _measures(job.scene, tuple(one.formula for one in job.measures), call.letters)
    at: dict[str, Array] = job.asked["at"]
    rows = max(1, ROWS // len(at[TIME]))
    found = np.empty((last - first, len(measures)))
    told: dict[int, str] = {}
    for begin in range(first, last, rows):
        values = job.design.values(begin, min(begin + rows, last))
        wrong = impossible(job, values)
        some = found[begin - first : begin - first + len(values)]
        some[:] = _chunk(job, call, measures, at, values)
        some[list(wrong)] = np.nan
        for row in np.flatnonzero(~np.isfinite(some).all(axis=1)):
            if len(told) < MOST_TOLD:
                told[begin + int(row)] = wrong.get(int(row), NO_NUMBER)
    failed = ~np.isfinite(found).all(axis=1)
    found[failed] = np.nan
    return Found(found, np.where(failed, FAILED, ENDED).astype(np.uint8), told)


def _chunk(job: Job, call: Called, measures: tuple[Measure, ...], at: dict[str, Array], values: Array) -> Array:
    """Return measures of a few parameter sets, shape (n, measures)."""
    columns = dict(zip(job.design.names, values.T, strict=True))
    places = len(at[TIME])
    arguments = []
    for one in call.operands:
        varied = [name for name in one.entries if name in columns]
        rows = np.empty((len(values) if varied else 1, places, len(one.entries)))
        for k, name in enumerate(one.entries):
            rows[..., k] = columns[name][:, None] if name in columns else at[name]
        arguments.append(rows[..., 0] if one.scalar else rows)
    names = call.parameters
    if names:
        last = values if names == job.design.names else np.stack([columns[name] for name in names], axis=-1)
        last = call.loaded.calls[PREPARE](last) if call.loaded.prepared else last
        arguments.append(last[:, None, :])
    with np.errstate(all="ignore"):
        result = np.asarray(call.loaded.calls[call.name](*arguments))
        result = result.reshape(*np.broadcast_shapes(result.shape[:2], (len(values), places)), -1)
        known = {name: result[..., k] for k, name in enumerate(call.results)}
        for one, given in zip(call.operands, arguments, strict=False):
            known |= {name: given if one.scalar else given[..., k] for k, name in enumerate(one.entries)}
        numbers = {p.name: np.asarray(float(value_of(p.value, {}) or 0.0)) for p in job.scene.parameters if p.value}
        numbers |= {name: columns[name] for name in job.asked["varied"]["values"]}
        known |= {TIME: at[TIME]} | {name: column[..., None] for name, column in numbers.items()}
        sums = {one: _sums(one, known, at[TIME], len(values)) for measure in measures for one in measure.insides}
        found = [np.broadcast_to(one.value(sums, numbers), (len(values),)) for one in measures]
    return np.stack(found, axis=-1)


def _sums(inside: Quantity, known: dict[str, Any], t: Array, count: int) -> Sums:
    """Return what folds take of a formula over places."""
    graph = Graph()
    letters = {graph.symbol(name): known[name] for name in inside.symbols}
    (y,) = evaluate([express(inside, graph)], Batches(), letters)
    return sums_of(t, np.broadcast_to(np.asarray(y, dtype=np.float64), (count, len(t))))
