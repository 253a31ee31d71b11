"""Jobs of one function at many parameter sets: what is asked for, read, and what comes of one block.

A block is `prepare`, the function at every place, and measures over these. Rows go through it two thousand at a time,
which stay in the cache of a core from the draw to the measures: with forty parameters a hundred thousand at a time take
three times as long.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.dynamics import Workspace, derive_one
from symdyn.errors import DerivationError, SimulateError, suggestion
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, evaluate
from symdyn.program import Program
from symdyn.runtime import Loaded, Operand, load
from symdyn.scene import Quantity, Scene, SceneUnits, bind
from symdyn.scene.values import Faults, split_commas
from symdyn.simulation import Measure, Problem
from symdyn.simulation.prescribed import Columns, drive_names, parameter_values, read_number, words
from symdyn.study.design import read_design
from symdyn.study.distributions import Over, read_over
from symdyn.study.job import BlockResult, Job, Measured, Wanted, check_names, impossible, read_measured
from symdyn.study.runs import ENDED, FAILED, MOST_TOLD
from symdyn.unlocked import cached_property

At: TypeAlias = str | Path | Mapping[str, Any] | None

BLOCK = 50_000
"""Sets of a block times places: a hundredth of a second, a few times what giving a block to a worker costs."""

FEWEST = 1000

TABLE = ".csv"


def places_job(
    scene: Scene,
    function: str,
    at: At,
    over: Over,
    measure: Wanted,
    design: str | None,
    count: int | None,
    seed: int,
    size: int | None,
    faults: Faults,
) -> Job:
    """Return a job of calls of a function of the scene; arguments as of `symdyn.sweep`, `size` being its block.

    With one point, the statistics of measures may be left out. A block of None takes some milliseconds.

    Raises:
        SimulateError: with every fault, those that there are already among them.
    """
    faults.close(SimulateError)
    moving = (*scene.coordinates, *scene.first_order)
    letters = _entries(scene, function, faults)
    varied = read_over(scene, over, [name for name in letters if name not in moving], faults)
    planned = read_design(varied, design, count, seed, faults)
    measures = read_measured(measure, faults)
    check_names(measures, [one.name for one in varied], faults)
    for one in measures:
        if one.function is not None:
            faults.add("measure", f"{one.name} is a function of a run, and there is none; give a formula of {function}")
    measures = tuple(one for one in measures if one.function is None)
    if size is not None and size < 1:
        faults.add("block", f"{size} is no number of sets; give 1 or more")
    faults.close(SimulateError)
    assert planned is not None, "what is missing is a fault"
    first = dict(zip(planned.names, planned.values(0, 1)[0].tolist(), strict=True))
    scene = bind(scene, {one.name: first[one.name] for one in scene.free_parameters if one.name in first})
    mine = {one.name for one in scene.parameters}
    free = tuple(name for name in planned.names if name in mine)
    with faults.noted():
        parameter_values(scene)
    faults.close(SimulateError)
    call = called(scene, function, free)
    there, where = _places(scene, call, at, planned.names, faults)
    measures = tuple(one for one in (_checked(scene, one, call, len(there[TIME]), faults) for one in measures) if one)
    for name in planned.names:
        if name not in mine and name not in call.letters:
            faults.add("over", f"{function} takes no {name}; {suggestion(name, (*mine, *call.letters))}")
    faults.close(SimulateError)
    size = size or max(FEWEST, BLOCK // len(there[TIME]))
    asked = {"function": function, "at": there, "varied": {"values": list(free)}}
    return Job("places", block, scene, planned, measures, asked, (("function", function), ("at", where)), size)


def _entries(scene: Scene, function: str, faults: Faults) -> tuple[str, ...]:
    try:
        arguments = derive_one(Workspace(scene), function).arguments
    except DerivationError as fault:
        faults.add("function", str(fault))
        return ()
    return tuple(str(entry.value) for one in arguments for entry in one.symbols)


def _checked(scene: Scene, one: Measured, call: Called, places: int, faults: Faults) -> Measured | None:
    known = {*call.letters, *(p.name for p in scene.parameters)}
    found = Measure.read(scene, one.formula, faults, more=call.letters, alone="end" if places == 1 else "")
    for name in [] if found is None else dict.fromkeys(n for inside in found.insides for n in inside.symbols):
        if name not in known:
            faults.add("measure", f"{one.name}: {call.name} neither takes nor gives {name}; {suggestion(name, known)}")
    return None if found is None else replace(one, formula=found.text)


def _places(scene: Scene, call: Called, at: At, varied: Iterable[str], faults: Faults) -> tuple[dict[str, Array], str]:
    """Return every entry of every argument over places, and time, shape (S,) each; and the same in words."""
    start = Problem(scene).initial
    usual = dict(zip(scene.coordinates, start.q.tolist(), strict=True))
    known = [name for one in call.operands for name in one.entries]
    given, where = _given(scene, at, faults)
    for name in given:
        if name not in (*known, TIME):
            faults.add("at", f"{call.name} takes no {name}; {suggestion(name, known)}")
        elif name in varied:
            faults.add("at", f"{name} is varied; leave it out here")
    count = max((len(one) for one in given.values() if one.ndim), default=1)
    for name, one in given.items():
        if one.ndim and len(one) not in (1, count):
            faults.add("at", f"{name} has {len(one)} places, and another one has {count}")
    faults.close(SimulateError)
    there = {name: np.broadcast_to(given.get(name, np.asarray(usual.get(name, 0.0))), (count,)) for name in known}
    times = given.get(TIME, np.arange(count, dtype=np.float64))
    return there | {TIME: np.broadcast_to(times, (count,))}, where


def _given(scene: Scene, at: At, faults: Faults) -> tuple[dict[str, Array], str]:
    """Return what is given by name, and the same in words that are equal where the numbers are."""
    if isinstance(at, Path) or (isinstance(at, str) and at.strip().endswith(TABLE)):
        with faults.noted():
            table = Columns.read(Path(at.strip() if isinstance(at, str) else at))
            return _told({TIME: table.t, **table.values})
        return {}, ""
    entries: Mapping[str, Any] = words(split_commas(at), "at", faults) if isinstance(at, str) else dict(at or {})
    values, units = parameter_values(scene), SceneUnits(scene)
    found: dict[str, Array] = {}
    for name, said in entries.items():
        if isinstance(said, str):
            number = read_number(said, values, f"at: {name}", faults, units.letter(str(name)), units.scene)
            found[str(name)] = np.asarray(np.nan if number is None else number)
        else:
            array = _array(said)
            if array is None:
                faults.add("at", f"{name} is no finite numbers, one or an array (S,)")
            found[str(name)] = np.zeros(()) if array is None else array
    return _told(found)


def _array(specified: Any) -> Array | None:
    try:
        found = np.asarray(specified)
    except ValueError:  # rows of several lengths
        return None
    fits = found.ndim < 2 and found.dtype.kind in "iuf" and found.size > 0 and bool(np.isfinite(found).all())
    return found.astype(np.float64) if fits else None


def _told(result: dict[str, Array]) -> tuple[dict[str, Array], str]:
    from hashlib import sha256

    text = ";".join(f"{name}={one.tolist()!r}" for name, one in sorted(result.items()))
    return result, text if len(text) < 500 else f"sha256 {sha256(text.encode()).hexdigest()}"


ROWS = 2000
"""Numbers of parameter sets that go through at a time, times places: 2,000 of the PUMA's 40 are 640 kB."""

TIME = "t"

PARAMETERS = "params"

NO_NUMBER = "the function has no finite value"


@dataclass(frozen=True)
class Called:
    """A function that is called at places, and what its numbers are called."""

    loaded: Loaded  # the function and `prepare`, compiled, if anything is to be prepared
    name: str  # of the function
    results: tuple[str, ...]  # a name for each entry of what it returns

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


def block(job: Job, first: int, last: int) -> BlockResult:
    """Return measures over places, of parameter sets from `first` on; those that are none of the scene fail alone."""
    free = tuple(job.requested["varied"]["values"])
    call = called(job.scene, job.requested["function"], free)
    read = reading(job.scene, tuple(one.formula for one in job.measures), call.letters, free)
    at: dict[str, Array] = job.requested["at"]
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
