"""One function at many parameter sets: `prepare`, the function at every place, and measures over these.

Rows go through it two thousand at a time, which stay in the cache of a core from the draw to the measures: with forty
parameters a hundred thousand at a time take three times as long.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.graph import Expr, Graph, evaluate
from symdyn.program import Program
from symdyn.runtime import Loaded, Operand, load
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Faults
from symdyn.simulation import Measure
from symdyn.simulation.prescribed import drive_names
from symdyn.study.block_result import BlockResult, impossible
from symdyn.study.job import Job
from symdyn.study.study import ENDED, FAILED, MOST_TOLD
from symdyn.unlocked import cached_property

ROWS = 2000
"""Numbers of parameter sets that go through at a time, times places: 2,000 of the PUMA's 40 are 640 kB."""

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

    @cached_property
    def operands(self) -> tuple[Operand, ...]:
        """What is given by place: all arguments but parameters."""
        return tuple(one for one in self.loaded[self.name].operands if one.name not in (PARAMETERS, "prepared"))

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """The parameters that are arguments, in order."""
        first = self.loaded.calls[Program.PREPARE if self.loaded.prepared else self.name]
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


def _results(scene: Scene, loaded: Loaded, name: str) -> tuple[str, ...]:
    """Return a name for every entry of the result: those of drives, else its own with places: tau1, M1_2, K."""
    result, shape = loaded.signatures[name].split(" -> ")[1].split(":")[0], _shape(loaded, name)
    if result == "tau" and shape == (len(scene.velocities),):
        return drive_names(scene)
    return tuple(result + "_".join(str(i + 1) for i in at) for at in np.ndindex(*shape))


def _shape(loaded: Loaded, name: str) -> tuple[int, ...]:
    inside = loaded.signatures[name].rsplit("->", 1)[1].strip("()")
    return tuple(int(one) for one in inside.split(",") if one)


@dataclass(frozen=True)
class PlaceReading:
    """Formulas of a study, read once a process.

    Attributes:
        measures: of all of them, in order.
        expressed: formulas as expressions, with the symbols of their letters, by the identity of the formula.
        numbers: values of parameters that are not varied and that formulas name.
    """

    measures: tuple[Measure, ...]
    expressed: Mapping[int, tuple[Expr, dict[str, Expr]]]
    numbers: dict[str, Any]

    @cached_property
    def needed(self) -> set[str]:
        """Letters that are looked at over places, or afterwards."""
        return {name for _, symbols in self.expressed.values() for name in symbols}

    def value(self, formula: Quantity, known: Mapping[str, Any]) -> Any:
        """Return the value of one of the formulas; arrays broadcast."""
        expression, symbols = self.expressed[id(formula)]
        letters = {symbol: known[name] for name, symbol in symbols.items()}
        return evaluate([expression], Batches(), letters)[0]


@lru_cache(maxsize=4)
def reading(scene: Scene, formulas: tuple[str, ...], letters: tuple[str, ...], free: tuple[str, ...]) -> PlaceReading:
    """Return formulas of measures; those that can be read."""
    found = [Measure.read(scene, formula, Faults(""), more=letters) for formula in formulas]
    measures = tuple(one for one in found if one is not None)
    expressed = {}
    for formula in (one for measure in measures for one in (*measure.insides, measure.formula)):
        graph = Graph()
        expressed[id(formula)] = formula.express(graph), {name: graph.symbol(name) for name in formula.symbols}
    named = {name for _, symbols in expressed.values() for name in symbols} - set(free)
    values = {p.name: p.value for p in scene.parameters if p.name in named and p.value is not None}
    numbers = {name: np.asarray(float(value.at({}) or 0.0)) for name, value in values.items()}
    return PlaceReading(measures, expressed, numbers)


def at_places(job: Job, first: int, last: int) -> BlockResult:
    """Return measures over places, of parameter sets from `first` on; those that are none of the scene fail alone."""
    free = tuple(job.asked["varied"]["values"])
    call = called(job.scene, job.asked["function"], free)
    read = reading(job.scene, tuple(one.formula for one in job.measures), call.letters, free)
    at: dict[str, Array] = job.asked["at"]
    fixed = [np.stack([at[name] for name in one.entries], axis=-1)[None] for one in call.operands]
    names, rows = job.design.names, max(1, ROWS // len(at[TIME]))
    found = np.empty((last - first, len(job.measures)))
    told: dict[int, str] = {}
    with np.errstate(all="ignore"):
        for begin in range(first, last, rows):
            values = job.design.values(begin, min(begin + rows, last))
            some = found[begin - first : begin - first + len(values)]
            _chunk(names, call, read, fixed, at, values, some)
            wrong = impossible(job, values)
            if wrong:
                some[list(wrong)] = np.nan
            if len(told) < MOST_TOLD and not np.isfinite(some).all():
                missing = np.flatnonzero(~np.isfinite(some).all(axis=1))[: MOST_TOLD - len(told)]
                told |= {begin + int(row): wrong.get(int(row), NO_NUMBER) for row in missing}
    failed = ~np.isfinite(found).all(axis=1)
    found[failed] = np.nan
    return BlockResult(found, np.where(failed, FAILED, ENDED).astype(np.uint8), told)


def _chunk(
    names: tuple[str, ...],
    call: Called,
    read: PlaceReading,
    fixed: list[Array],
    at: dict[str, Array],
    values: Array,
    found: Array,
) -> None:
    """Put measures of a few parameter sets into `found`, shape (n, measures)."""
    columns = {name: values[:, k] for k, name in enumerate(names)}
    arguments, count, places = [], len(values), len(at[TIME])
    for one, usual in zip(call.operands, fixed, strict=True):
        varied = [name for name in one.entries if name in columns]
        rows = np.repeat(usual, count, axis=0) if varied else usual
        for name in varied:
            rows[..., one.entries.index(name)] = columns[name][:, None]
        arguments.append(rows)
    given = [rows[..., 0] if one.scalar else rows for one, rows in zip(call.operands, arguments, strict=True)]
    if call.parameters:
        last = values if call.parameters == names else np.stack([columns[name] for name in call.parameters], axis=-1)
        last = call.loaded.calls[Program.PREPARE](last) if call.loaded.prepared else last
        given.append(last[:, None, :])
    result = np.asarray(call.loaded.calls[call.name](*given))
    result = result.reshape(*result.shape[:2], -1)
    needed = read.needed
    known = {name: result[..., k] for k, name in enumerate(call.results) if name in needed}
    for one, rows in zip(call.operands, arguments, strict=True):
        known |= {name: rows[..., k] for k, name in enumerate(one.entries) if name in needed}
    numbers = read.numbers | {name: column for name, column in columns.items() if name in needed}
    known |= {TIME: at[TIME]} | {name: column[..., None] for name, column in numbers.items()}

    def over_places(inside: Quantity) -> Array:
        return np.broadcast_to(np.asarray(read.value(inside, known), dtype=np.float64), (count, places))

    for k, measure in enumerate(read.measures):
        folds = measure.folded(at[TIME], over_places)
        found[:, k] = read.value(measure.formula, numbers | folds)
