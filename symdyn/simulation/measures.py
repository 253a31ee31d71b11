"""Measures of a run: formulas of statistics, each of what a run shows at its samples.

    max(abs(tau2))              largest value of a formula over the samples of a run
    max(q1) - end(q2)           statistics are numbers, with which formulas go on
    rms(q1_dot)/max(abs(F))

A fold sees the samples, `every` seconds apart, as who reads `simulate`'s rows does; peaks are looked for between them,
by the dense output of the run. Integrals, and so `mean` and `rms`, are sums of trapezoids.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import TypeAlias

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.arguments import SympyExpression, is_function
from symdyn.errors import SimulateError, SymdynError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Graph, evaluate
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import LETTERS, Faults, Unit, UnitError, formula_text, shorten, spell, substituted
from symdyn.simulation.columns import column_units, unit_of
from symdyn.simulation.equations.compiled_routines import opened
from symdyn.simulation.force_columns import columns_for, formula_values
from symdyn.simulation.forward import simulate
from symdyn.simulation.prescribed.formulas_in_time import read_formula, read_seen
from symdyn.simulation.problem import Problem, Run
from symdyn.simulation.trajectory import Trajectory
from symdyn.simulation.trajectory_builder import DenseOutput
from symdyn.simulation.variations import variations


@dataclass(frozen=True)
class Sums:
    """What is kept of one formula over the samples of runs, each of shape (N,).

    Attributes:
        first, last: its values at the start and at the end.
        least, most: its smallest and largest values.
        when_least, when_most: when these were met first, s.
        area, squares: integrals of it and of its square, by trapezoids.
        span: how long the runs took, s.
        settled: when the formula stays within `BAND` of its way from the first to the last value, s, and of its peak
            where it comes back to the first; NaN where it still leaves that in the last tenth of the run.
    """

    first: Array
    last: Array
    least: Array
    most: Array
    when_least: Array
    when_most: Array
    area: Array
    squares: Array
    span: Array
    settled: Array


BAND, LATEST = 0.02, 0.9
"""What is near the last value, over the way to it, and the share of a run after which nothing counts as settled."""


@dataclass(frozen=True)
class Fold:
    """What becomes of one formula over a run: a number."""

    text: str  # what it is, one line
    of: Callable[[Sums], Array]  # the number, from what was kept
    unit: Callable[[str], str] = lambda unit: unit  # of it, from that of the formula
    whole: bool = False  # whether it takes all samples at once
    peak: int = 0  # 1 where the largest value between samples changes it, -1 where the smallest does


def _seconds(unit: str) -> str:
    """Return the unit of an integral over time: "m" of "m/s", "N s" of "N"; "" of what has none, or one of two."""
    try:
        return (Unit.read(unit) * Unit.read("s")).coherent_text if unit else ""
    except UnitError:
        return ""


FOLDS: Mapping[str, Fold] = {
    "max": Fold("largest value", lambda s: s.most, peak=1),
    "min": Fold("smallest value", lambda s: s.least, peak=-1),
    "mean": Fold("mean over time", lambda s: np.where(s.span > 0, s.area / np.where(s.span > 0, s.span, 1.0), s.first)),
    "rms": Fold(
        "root of the mean square over time",
        lambda s: np.sqrt(np.where(s.span > 0, s.squares / np.where(s.span > 0, s.span, 1.0), s.first**2)),
    ),
    "start": Fold("value at the start", lambda s: s.first),
    "end": Fold("value at the end", lambda s: s.last),
    "integral": Fold("integral over time", lambda s: s.area, _seconds),
    "when_max": Fold("time of the largest value, s", lambda s: s.when_most, lambda unit: "s", peak=1),
    "when_min": Fold("time of the smallest value, s", lambda s: s.when_least, lambda unit: "s", peak=-1),
    "settling_time": Fold("time from which it stays near its end, s", lambda s: s.settled, lambda unit: "s", True),
}


@dataclass(frozen=True)
class Measure:
    """A number of a run, by a formula.

    Attributes:
        text: as the user wrote it, or the name of a function.
        folds: key of `FOLDS` and the formula inside, by the letter that stands for the fold.
        formula: of these letters and of parameters.
        function: that gives the number of a run, in place of a formula.
    """

    text: str
    folds: tuple[tuple[str, str, Quantity], ...]
    formula: Quantity
    function: Callable[[Trajectory], float] | None = None

    @classmethod
    def of_run(cls, text: str, function: Callable[[Trajectory], float]) -> Measure:
        """Return a measure that is a function of a run; it is folded as a formula that has its value all the time."""
        return cls(text, (("value", "end", Quantity.symbol(f"measure {text}")),), Quantity.symbol("value"), function)

    def known(self, run: Trajectory) -> dict[str, Array]:
        """Return the number of a run by the symbol that stands for it, nothing of a formula."""
        if self.function is None:
            return {}
        try:
            return {f"measure {self.text}": np.asarray(float(0 + self.function(run)))}  # text is no number
        except Exception as fault:
            why = f"{type(fault).__name__}: {fault}"
            raise SimulateError(f"measure {self.text}: {why}; a function takes a run and returns a number") from fault

    @property
    def insides(self) -> tuple[Quantity, ...]:
        """The formulas that are folded."""
        return tuple(inside for _, _, inside in self.folds)

    @property
    def peaks(self) -> tuple[tuple[Quantity, int], ...]:
        """The formulas whose largest (1) or smallest (-1) values count."""
        return tuple((inside, FOLDS[fold].peak) for _, fold, inside in self.folds if FOLDS[fold].peak)

    def unit(self, scene: Scene, called: str = "") -> str:
        """Return its unit; "" where a number in it may carry one, or nothing tells it."""
        if self.function is not None:
            return ""
        return SceneUnits(scene).of_formula(self.formula, fold_units(scene, self.folds), called)

    def folded(self, t: Array, inside: Callable[[Quantity], Array]) -> dict[str, Array]:
        """Return its folds by their letters, shape (N,), of formulas inside at times (T,), values (N, T)."""
        return {letter: fold_over(fold, t, inside(formula)) for letter, fold, formula in self.folds}

    def value(self, sums: Mapping[Quantity, Sums], parameters: Mapping[str, Array]) -> Array:
        """Return the measure of every run, shape (N,), NaN where it has no value; sums by formula inside."""
        graph = Graph()
        known: dict[object, Array] = {graph.symbol(name): value for name, value in parameters.items()}
        with np.errstate(all="ignore"):
            known |= {graph.symbol(letter): FOLDS[fold].of(sums[inside]) for letter, fold, inside in self.folds}
            (found,) = evaluate([self.formula.express(graph)], Batches(), known)  # type: ignore[arg-type]
        return np.asarray(found, dtype=np.float64)

    @classmethod
    def read(
        cls, scene: Scene, text: object, faults: Faults, more: Sequence[str] = (), alone: str = ""
    ) -> Measure | None:
        """Return a measure of runs of a scene, which may name `more` than what runs show; None after a fault.

        `alone` is the fold of a formula that has none, where it may have none.

        >>> import symdyn
        >>> measure = Measure.read(symdyn.example("cart_pole"), "max(abs(F)) - 2*end(x)", Faults(""))
        >>> [fold for _, fold, _ in measure.folds]
        ['max', 'end']
        """
        said, count, where = formula_text(text), len(faults.lines), "measure"
        if alone and not any(f"{fold}(" in said.replace(" ", "") for fold in FOLDS):
            said = f"{alone}({said})"
        folds: list[tuple[str, str, Quantity]] = []
        left, rest = "", said
        while (match := _FOLDED.search(rest)) is not None:
            close = _closing(rest, match.end())
            if close is None:
                faults.add(where, f'"{said}" has a bracket that is not closed')
                return None
            inside = rest[match.end() : close]
            if (inner := _FOLDED.search(inside)) is not None:
                faults.add(where, f'"{said}" takes a statistic of a number: {inner[1]}(...) inside {match[1]}(...)')
                return None
            formula = read_seen(scene, inside, where, faults, (*more, *LETTERS.columns), column_units)
            letter = _letter(scene, len(folds), said)
            if formula is not None:
                folds.append((letter, match[1], formula))
            left, rest = f"{left}{rest[: match.start()]}{letter}", rest[close + 1 :]
        if len(faults.lines) > count:
            return None
        known = [*(letter for letter, _, _ in folds), *(one.name for one in scene.parameters), *scene.derived_formulas]
        seen = {*_seen(scene, said), *more, *(one.name for one in scene.outputs)}
        own = Faults("")
        found = read_formula(left + rest, [*known, *seen], where, own, scene=scene)
        own.lines[:] = [
            line.replace("write * for a product", f"statistics are {_listed()}; {ALSO}") for line in own.lines
        ]
        found = found and substituted(found, scene.derived_formulas)
        loose = [name for name in (found.symbols if found else ()) if name not in known]
        for one in loose:
            own.add(where, f'"{said}" takes {one} at no time; write max({one}), end({one}) or another of {_listed()}')
        if found is not None and not loose and not folds:
            first = next(iter(scene.coordinates), "t")
            own.add(where, f'"{said}" takes no statistic of a run; write such as max(abs({first}))')
        if found is not None and not own.lines:
            SceneUnits(scene).check(found, where, own, fold_units(scene, folds))
        for letter, fold, folded in folds:
            own.lines[:] = [re.sub(rf"\b{letter}\b", f"{fold}({shorten(spell(folded))})", line) for line in own.lines]
        faults.lines += own.lines
        return None if own.lines or found is None else cls(said, tuple(folds), found)


def sums_of(t: Array, y: Array) -> Sums:
    """Return what is kept of formulas over samples: times (T,), values (..., T), all finite or the sums are NaN."""
    dt, low, high = np.diff(t), y.argmin(axis=-1), y.argmax(axis=-1)
    missing = np.isnan(y).any(axis=-1)

    def at(k: Array) -> Array:
        return np.where(missing, np.nan, t[k])

    with np.errstate(all="ignore"):
        area, squares = (((x[..., :-1] + x[..., 1:]) / 2 * dt).sum(axis=-1) for x in (y, y**2))
    span = np.full(y.shape[:-1], t[-1] - t[0])
    return Sums(
        y[..., 0], y[..., -1], y.min(axis=-1), y.max(axis=-1), at(low), at(high), area, squares, span, _settled(t, y)
    )


def _settled(t: Array, y: Array) -> Array:
    """Return from when on formulas stay near their ends, straight between samples, as of `Sums`."""
    off = y - y[..., -1:]
    way, peak = np.abs(off[..., 0]), np.abs(off).max(axis=-1)
    band = BAND * np.where(way > BAND * peak, way, peak)
    out = np.abs(off) > band[..., None]
    last = len(t) - 1 - out[..., ::-1].argmax(axis=-1)
    k = np.minimum(last, len(t) - 2)
    here, after = (np.take_along_axis(off, one[..., None], axis=-1)[..., 0] for one in (k, k + 1))
    with np.errstate(all="ignore"):
        part = (np.abs(here) - band) / (np.abs(here) - np.sign(here) * after)
        found = np.where(out.any(axis=-1), t[k] + part * (t[k + 1] - t[k]), t[0])
    return np.where(np.isnan(y).any(axis=-1) | (found > t[0] + LATEST * (t[-1] - t[0])), np.nan, found)


def fold_over(fold: str, t: Array, y: Array) -> Array:
    """Return a fold of formulas over samples, or over one: times (T,), values (N, T); shape (N,)."""
    if len(t) > 1:
        return FOLDS[fold].of(sums_of(t, y))
    one, zero = y[:, 0], np.zeros(len(y))
    return FOLDS[fold].of(Sums(one, one, one, one, zero + t[0], zero + t[0], zero, zero, zero, zero + t[0]))


def sums_over(
    insides: Sequence[Quantity], run: Trajectory, told: Mapping[str, Array] | None = None
) -> Mapping[Quantity, Sums]:
    """Return what is kept of formulas over the rows of a run, of which more may be `told` by name."""
    told = dict(told or {})
    if not insides:
        return {}
    known = dict(zip(*(run.names, run.table()[1].T), strict=True))
    known |= columns_for(run, (name for one in insides for name in one.symbols if name not in told))
    known |= told | {name: np.asarray(value) for name, value in opened(run.scene).values.items()}
    series = dict.fromkeys((n for one in insides for n in one.symbols), np.nan) | known
    rows = formula_values(insides, series, run.t)
    with np.errstate(all="ignore"):
        return {one: sums_of(run.t, y) for one, y in zip(insides, rows, strict=True)}


Measures: TypeAlias = (
    str | Measure | Callable[[Trajectory], float]
    | Sequence[str | Measure | SympyExpression | Callable[[Trajectory], float]]
)  # fmt: skip
"""What is kept of every run: formulas, or functions of a run."""

ALSO = "in Python a measure may be a function of a run, too"

ROUNDS, LOOKS = 2, 33
"""How often a peak is looked at more closely, and times of a look."""


def at_peak(kept: Sums, inside: Quantity, sign: int, run: Trajectory) -> Sums:
    """Return sums with the largest value between samples, or the smallest (sign -1), by the run's dense output."""
    value, when, t = "most" if sign > 0 else "least", "when_most" if sign > 0 else "when_least", run.t
    hits = run.dense.run.hits if isinstance(run.dense, DenseOutput) and np.isfinite(kept.area) else None
    corners = [one.t for one in hits or () if t[0] < one.t < t[-1]]  # of impacts: between them a run is smooth
    with suppress(SymdynError):  # what an integrator cannot pass again
        for look in range(not corners, 0 if hits is None else 1 + ROUNDS):
            k = int(np.searchsorted(t, getattr(kept, when)))
            fine = np.linspace(t[max(k - 1, 0)], t[min(k + 1, len(t) - 1)], LOOKS)
            t = fine if look else np.union1d(t[[0, k, -1]], corners)
            near = sums_over((inside,), run(t))[inside]
            if not sign * getattr(near, value) >= sign * getattr(kept, value):
                break
            kept = replace(kept, **{name: getattr(near, name) for name in (value, when)})
    return kept


def measured(run: Trajectory, measures: Sequence[Measure]) -> Array:
    """Return measures of one run, shape (measures,)."""
    sums = sums_over(tuple(dict.fromkeys(inside for one in measures for inside in one.insides)), run)
    known = {name: np.asarray(value) for name, value in opened(run.scene).values.items()}
    return np.array([float(one.value(sums, known)) for one in measures])


def measure_slopes(problem: Problem, run: Run, measures: Sequence[str], names: Sequence[str]) -> Array:
    """Return the derivatives of measures of a run by each of the names, shape (measures, names); NaN where none is.

    A fold is taken of the run as it is to first order on both sides of every name: the largest value follows the
    sample where it is, and a measure that jumps from one sample to another has no derivative there.
    Names are as of `variations`; of the run only `until` and `every` are looked at.

    Raises:
        SimulateError: with every fault.
    """
    faults = Faults("")
    read = read_measures(problem.scene, measures, faults)
    faults.close(SimulateError)
    made = simulate(problem.as_read, until=run.until, every=run.every, say=lambda _: None)
    found = variations(made, problem.driving, problem.initial, names)
    slopes = np.zeros((len(read), len(names)))
    for k in range(len(names)):
        step = found.step(k)
        ahead, behind = (measured(found.beside(made, k, sign * step), read) for sign in (1, -1))
        slopes[:, k] = (ahead - behind) / (2 * step)
    return slopes


_FOLDED = re.compile(rf"\b({'|'.join(FOLDS)})\s*\(")
_LETTER = "fold_{}"


def fold_units(scene: Scene, folds: Sequence[tuple[str, str, Quantity]]) -> dict[str, str]:
    """Return the units of the folds of a measure, by their letters; "" of one that nothing tells."""
    return {letter: FOLDS[fold].unit(unit_of(inside, scene)) for letter, fold, inside in folds}


def _seen(scene: Scene, text: str) -> tuple[str, ...]:
    return (*scene.formula_names(re.findall(r"\w+", text)), *LETTERS.columns)


def read_measures(scene: Scene, texts: Sequence[object], faults: Faults) -> tuple[Measure, ...]:
    """Return measures, those without fault."""
    found = []
    for k, text in enumerate(texts):
        if isinstance(text, Measure):
            found.append(text)
        elif is_function(text):
            found.append(Measure.of_run(getattr(text, "__name__", "measure"), text))
        elif str(text) in map(str, texts[:k]):
            faults.add("measure", f'"{text}" is given twice')
        else:
            found += [one for one in (Measure.read(scene, text, faults),) if one is not None]
    return tuple(found)


def _listed() -> str:
    return ", ".join(FOLDS)


def _letter(scene: Scene, k: int, text: str) -> str:
    """Return a letter that neither the scene nor the text has."""
    taken = {
        *(one.name for one in scene.parameters),
        *(one.name for one in scene.outputs),
        *scene.formula_names(),
        *re.findall(r"\w+", text),
    }
    letter = _LETTER.format(k + 1)
    while letter in taken:
        letter = f"{letter}_"
    return letter


def _closing(text: str, begin: int) -> int | None:
    """Return where the bracket closes that stands open at `begin`; None where it does not."""
    depth = 1
    for k in range(begin, len(text)):
        depth += (text[k] == "(") - (text[k] == ")")
        if depth == 0:
            return k
    return None
