"""Formulas in time and state, tables in CSV and sample times, as a user gives them: read and checked.

The names in a formula are checked and its parameters bound. A table has a header with the column t, then rows with
rising times.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import partial
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.arguments import F, argument, checked
from symdyn.bounds import BOUNDS
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import SceneError, SimulateError, SymdynError, hint, suggestion
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Graph, evaluate, reachable
from symdyn.scene import Quantity, Scene, SceneUnits, parse, read_bounded
from symdyn.scene.values import (
    Faults,
    FormulaError,
    Letter,
    Parameter,
    Unit,
    fits,
    formula_text,
    question,
    spell,
    substituted,
)

TIMES = ("until", "every", "period", "delay", "dt")
"""Arguments in seconds."""

LARGEST_FILE = BOUNDS["bytes of a file of numbers or formulas"]
"""A million rows of three numbers have room in it."""


def read_formula(
    text: object,
    allowed: Iterable[str],
    where: str,
    faults: Faults,
    advice: Callable[[str], str] | None = None,
    unit: str = "",
    scene: Scene | None = None,
) -> Quantity | None:
    """Return a formula whose symbols are among `allowed`; None after a fault, with advice about a name behind it.

    `unit` is that of what it is for; a value, or terms in symbols of a `scene`, of another kind are faults.
    """
    known = tuple(dict.fromkeys(allowed))
    try:
        formula = parse(formula_text(text))
        measured = SceneUnits(scene).dimensions.letter if scene is not None and formula.unit else lambda _: None
        fits(formula, Unit.read(unit) if unit else None, {one: measured(one) for one in known})
        bound(formula, {})
    except FormulaError as error:
        faults.add(where, f"{text} {error}" if str(error).startswith(("is in ", "divides ")) else str(error))
        return None
    unknown = [name for name in formula.symbols if name not in known]
    for name in unknown:
        more = f", {told}" if advice and (told := advice(name)) else ""
        near = hint("characters", name) or (suggestion(name, known, scene) if known else "give a number")
        faults.add(where, f'"{text}" uses {name}, which is not known here; {near}{more}')
    if scene is not None and unit and not unknown:
        SceneUnits(scene).check(formula, where, faults, unit=unit)
    return None if unknown else formula


def read_seen(
    scene: Scene,
    text: object,
    where: str,
    faults: Faults,
    more: Sequence[str] = (),
    units: Callable[[Iterable[str]], Mapping[str, str]] = lambda names: {},
) -> Quantity | None:
    """Return a formula in what can be looked at: `LETTERS`, parameters, outputs, and `more`; None after a fault.

    `units` tells those of `more`.
    """
    words = re.findall(r"\w+", formula_text(text))
    parameters = (one.name for one in scene.parameters)
    outputs = {one.name: one.formula for one in scene.outputs} | scene.definitions
    known = (*scene.formula_names(words), *parameters, *outputs, *more)
    formula = read_formula(text, known, where, faults, scene=scene)
    if formula is None:
        return None
    seen = substituted(formula, outputs)
    SceneUnits(scene).check(seen, where, faults, units(seen.symbols))
    return seen


def parameter_values(scene: Scene) -> dict[str, Quantity]:
    """Return the values of the scene's parameters, the derived ones among them.

    Raises:
        SimulateError: one has no value.
    """
    free = [parameter.name for parameter in scene.free_parameters]
    if free:
        binding = argument("values", dict.fromkeys(free, 1))
        have = "has" if len(free) == 1 else "have"
        raise SimulateError(f"{scene.name}: {', '.join(free)} {have} no value; give them, as in {binding}")
    values = {parameter.name: parameter.value for parameter in scene.parameters if parameter.value is not None}
    return values | {name: substituted(formula, values) for name, formula in scene.derived_formulas.items()}


def bound(formula: Quantity, values: Mapping[str, Quantity]) -> Quantity:
    """Return the formula with values in place of parameters.

    Raises:
        FormulaError: it divides by what is now zero, or takes a root or logarithm that does not exist.
    """
    found = substituted(formula, values)
    try:
        found.express(Graph())  # sees that cos(pi/2) is zero, which a float does not
    except ZeroDivisionError:
        raise FormulaError("divides by zero; check the denominator") from None
    return found


AHEAD = np.concatenate([np.linspace(0.0, 100.0, 100_001), np.geomspace(100.0, 1e6, 1000)[1:]])
"""Times, s, between which a formula is looked at for steps."""

ACROSS, STEP = 1e-12, 1e-6
"""How close to a step a formula is taken on both sides, of the time there, and how far it goes, of its size or 1."""


def jump_of(formula: Quantity, first: float = -math.inf, last: float = math.inf) -> float | None:
    """Return a time between two, s, at which a formula in t alone jumps, None where no step was found."""
    graph = Graph()
    node = formula.express(graph)
    guards = [guard for one in reachable([node]) for guard in one.guards]

    def at(nodes: Sequence[Expr], times: Array) -> list[Array]:
        with np.errstate(all="ignore"):
            found = evaluate(nodes, Batches(), {graph.symbol(TIME): times})
        return [np.broadcast_to(np.asarray(one, dtype=np.float64), times.shape) for one in found]

    for guard, values in zip(guards, at(guards, AHEAD) if guards else (), strict=True):
        (turned,) = np.nonzero(np.diff(values > 0))
        low, high = AHEAD[turned], AHEAD[turned + 1]
        while len(low) and np.any(high - low > ACROSS * np.maximum(1.0, high)):
            middle = (low + high) / 2
            same = (at([guard], middle)[0] > 0) == (at([guard], low)[0] > 0)
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        (before,), (after,) = at([node], low), at([node], high)
        steps = np.abs(after - before) > STEP * np.maximum(1.0, np.abs(before))
        steps &= (low > first) & (high <= last)
        if steps.any():
            return float(high[steps][0])
    return None


def number_of(formula: Quantity, values: Mapping[str, Quantity], where: str, faults: Faults) -> float | None:
    """Return the value of a formula in parameters, None after a fault."""
    try:
        value = bound(formula, values).at({})
    except FormulaError as error:
        faults.add(where, f"{spell(formula)} {error}")
        return None
    assert value is not None, "all symbols were checked"
    return float(value)


def read_number(
    given: object, values: Mapping[str, Quantity], where: str, faults: Faults, letter: Letter,
    scene: Scene | None = None, spread: bool = False,
) -> float | None:  # fmt: skip
    """Return a number of SI that is given for a letter, or text with its unit, a formula in parameters; else None.

    A bare one may be asked for its unit, see `question`, and terms in symbols of a `scene` are measured: every argument
    that takes values by name is read here.
    """
    if asked := question(letter, given, spread):
        faults.add(where.removesuffix(f": {letter.name}"), asked)  # which says the name
    if isinstance(given, Real):
        return float(given)
    formula = read_formula(given, values, where, faults, unit=letter.unit, scene=scene)
    return None if formula is None else number_of(formula, values, where, faults)


def in_seconds(given: Mapping[str, Any], error: Callable[[Any], Exception] = SimulateError) -> dict[str, Any]:
    """Return arguments, times that are text, "5 s" or "10 ms", in s; an error with every fault."""
    faults, found = Faults(""), dict(given)
    for name, value in given.items():
        if name in TIMES and isinstance(value, str) and value[:1].isdigit() and value[-1:].isalpha():
            found[name] = read_number(value, {}, name, faults, Parameter(name, unit="s"))
    faults.close(error)
    return found


def timed(error: type[SymdynError]) -> Callable[[F], F]:
    """Let a function or method check its arguments, as of `checked`, and take times that are text."""
    return checked(error, partial(in_seconds, error=error))


def read_range(
    given: Any, where: str, faults: Faults, letter: Letter, values: Mapping[str, Quantity], scene: Scene | None = None
) -> tuple[float, float]:
    """Return a smallest and a largest value; None is none, and one number above 0, or its text, the largest size."""
    size, before = isinstance(given, Real | str), len(faults.lines)
    try:
        pair = (given, given) if size else given
        first, last = (None if one is None else read_number(one, values, where, faults, letter, scene) for one in pair)
    except (TypeError, ValueError, OverflowError):
        first = last = math.nan
    least, most = -np.inf if first is None else -first if size else first, np.inf if last is None else last
    if len(faults.lines) == before and (math.isnan(least) or math.isnan(most) or (size and most <= 0)):
        told = 'is neither a size above 0 nor a smallest and a largest value, such as (-1, 1), (None, 5) or "5 deg"'
        faults.add(where, f"{given!r} {told}")
    elif least > most:
        faults.add(where, f"nothing lies between {least:g} and {most:g}; give the smaller value first")
    return (least, most) if len(faults.lines) == before else (-np.inf, np.inf)


def words(entries: Iterable[str], what: str, faults: Faults) -> dict[str, str]:
    """Return name and text of every `name=text` in order; what is none is a fault of the option `what`."""
    found: dict[str, str] = {}
    for entry in entries:
        name, equals, text = (piece.strip() for piece in entry.partition("="))
        if not name or not equals or not text:
            files = what in ("forces", "motion")
            known = "is neither a file nor name=formula" if files else "is not name=formula"
            known += "; tables are .csv files, as to_csv writes them" * (files and entry.endswith(".npz"))
            finder = argument("start", "rest", "symdyn.linear.linearize_at_rest(scene)")
            rest = f"; linearize finds positions of rest, {finder}; start at one of them" * (entry == "rest")
            faults.add(what, f'"{entry}" {known}{rest}')
        elif name in found:
            faults.add(what, f"{name} is given twice, as {found[name]} and as {text}")
        elif what in ("forces", "motion") and text.endswith((".csv", ".toml")):
            faults.add(what, f"{name}: a file is given alone, {text}; its columns are called after what they are")
        else:
            found[name] = text
    return found


def read_file(path: Path) -> str:
    """Return the text of a file.

    Raises:
        SimulateError: it cannot be read, and why.
    """
    try:
        return read_bounded(path, LARGEST_FILE, "a file", "give fewer rows").decode("utf-8-sig")
    except SceneError as fault:
        raise SimulateError(fault.faults) from None
    except UnicodeDecodeError as error:
        raise SimulateError(f"{path}: byte {error.start} is not UTF-8; save the file as UTF-8 text") from None


MOST = 10
"""Faults of one file that are told; the rest is counted."""


@dataclass(frozen=True)
class Columns:
    """Numbers over time.

    Attributes:
        source: the file, or what else they come from, for messages.
        t: times, s, shape (N,), strictly rising.
        values: the other columns by name, each of shape (N,).
        every: whether each of them must mean something; of a table those that do are taken.
        curves: functions of t by name, of what is known between the times.
    """

    source: str
    t: Array
    values: Mapping[str, Array]
    every: bool = False
    curves: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def read(cls, path: Path, needed: Collection[str] | None = None, timed: bool = True) -> Columns:
        """Return the columns of a CSV file.

        Args:
            path: of the file.
            needed: columns that have to be numbers; others that are not are left out. None: all have to be.
            timed: whether rows are of rising times, in the column t; else t numbers them.

        Raises:
            SimulateError: with every fault of the file, one line each.
        """
        faults = Faults(str(path))
        text, most = read_file(path), BOUNDS["numbers of a file of columns"]
        if (many := text.count(",") + text.count("\n")) > most:
            raise SimulateError(f"{path}: holds some {many} numbers; {most} are the most that is read: give fewer rows")
        try:
            rows = [row for row in csv.reader(io.StringIO(text)) if any(cell.strip() for cell in row)]
        except csv.Error as error:
            raise SimulateError(f"{path}: is no CSV: {error}") from None
        names = [cell.strip() for cell in rows[0]] if rows else []
        if timed and TIME not in names:
            faults.add("", f"has no column t; {_first_row(names)}")
        for name in [name for name, count in Counter(names).items() if count > 1][:MOST]:
            faults.add("", f"has the column {name} twice")
        if len(rows) < 3:
            faults.add("", f"has {counted(max(0, len(rows) - 1), 'row')} of numbers; at least two are needed")
        faults.close(SimulateError)
        try:
            must = set(names if needed is None else {TIME, *needed} if timed else needed)
            table = np.array([_numbers(row, names, k, must, faults) for k, row in enumerate(rows[1:], start=2)])
            t = table[:, names.index(TIME)] if timed else np.arange(len(table), dtype=np.float64)
            for k in np.nonzero(np.diff(t) <= 0)[0]:
                faults.add(f"row {k + 3}", f"t = {t[k + 1]:g} does not come after t = {t[k]:g}; sort the rows by time")
        except SceneError as error:  # so many that reading ended
            raise SimulateError([*error.faults[:MOST], f"{path}: and more faults than are counted"]) from None
        if len(faults.lines) > MOST:
            faults.lines[MOST:] = [f"{path}: and {len(faults.lines) - MOST} faults more"]
        faults.close(SimulateError)
        told = {name: table[:, k] for k, name in enumerate(names) if name != TIME}
        return cls(str(path), t, {name: x for name, x in told.items() if name in must or np.isfinite(x).all()})


def _first_row(names: Sequence[str]) -> str:
    """Return what is wrong with a first row that does not name t, in words."""
    text = ",".join(names)
    if text.startswith("#"):
        return f'the first row is "{text:.40}"; the first row must name the columns, so remove what stands above them'
    for sign, called in ((";", "semicolons"), ("\t", "tabs")):
        if sign in text:
            return f"{called} stand between the names; write commas between columns, and points in numbers"
    usual = "the first row must name the columns, such as t,q1,q2"
    here = ", ".join(names[:MOST]) + (", ..." if len(names) > MOST else "")
    return f"{usual}; it has {here}; call the times, in s, t" if names else usual


def columns_of(source: str, times: Any, values: Mapping[str, Any], every: bool = False) -> Columns:
    """Return arrays over times as columns.

    Raises:
        SimulateError: with every fault, one line each: what is no numbers, lengths that differ, times that do not rise.
    """
    faults = Faults(source)
    t = _array(times, TIME, faults)
    columns = {name: _array(x, name, faults) for name, x in values.items()}
    for name, x in columns.items():
        if x is not None and t is not None and len(x) != len(t):
            told = f"{counted(len(x), 'value')} at {counted(len(t), 'time')}; give {len(t)}, one for each of {TIME}"
            faults.add("", f"{name} has {told}")
    if t is not None and len(t) < 2:
        faults.add("", f"has {counted(len(t), 'time')}; at least two are needed")
    if t is not None:
        for k in np.flatnonzero(np.diff(t) <= 0)[:1]:
            faults.add("", f"t = {t[k + 1]:g} does not come after t = {t[k]:g}; sort by time")
    faults.close(SimulateError)
    assert t is not None
    return Columns(source, t, {name: x for name, x in columns.items() if x is not None}, every)


def _array(values: Any, name: str, faults: Faults) -> Array | None:
    try:
        found = np.asarray(values)
    except ValueError:  # rows of several lengths
        found = np.empty((0, 0))
    if found.ndim != 1 or found.dtype.kind not in "iuf":
        shape = f" but of shape {found.shape}" * (found.ndim != 1 and bool(found.size))
        faults.add("", f"{name} is no row of numbers{shape}; give one number for each time, such as [0.0, 0.1]")
        return None
    numbers = found.astype(np.float64)
    for k in np.flatnonzero(~np.isfinite(numbers))[:1]:
        faults.add("", f"{name} has {numbers[k]} as value {k + 1}; give finite numbers")
        return None
    return numbers


def counted(number: int, noun: str) -> str:
    """Return "1 row", "2 rows"."""
    return f"{number} {noun}{'s' * (number != 1)}"


def _numbers(row: list[str], names: list[str], number: int, must: Collection[str], faults: Faults) -> list[Any]:
    """Return the cells of a row as numbers, NaN where one is none, which is a fault of columns that must be."""
    where = f"row {number}"
    if len(row) != len(names):
        told = f"has {counted(len(row), 'cell')}; the header names {counted(len(names), 'column')}"
        faults.add(where, f"{told}: give as many cells, or leave the row out")
        return [np.nan] * len(names)
    found = []
    for name, cell in zip(names, row, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = np.nan
        if not np.isfinite(value) and name in must:
            faults.add(where, f'{name} = "{cell.strip()}" is not a finite number; leave the row out')
        found.append(value)
    return found


SAMPLES = 200
"""Samples after the first, if no spacing is given."""

FINEST = 20_000_000
"""Samples that are more than anybody reads."""


def sample_times(until: float, every: float | None, faults: Faults) -> Array:
    """Return 0, every, 2 every, ..., until."""
    if not (math.isfinite(until) and until > 0):
        faults.add("", f"until = {until:g} s is not a time after the start; give a positive one")
    elif every is None:
        return np.linspace(0.0, until, SAMPLES + 1)
    elif not 0 < every <= until * (1 + 1e-9):
        least = "a positive one" if not every > 0 else f"at most until = {until:g} s, the length of the run"
        faults.add("", f"every = {every:g} s is no spacing of samples; give {least}")
    elif (many := until / every) > FINEST:
        faults.add("", f"every = {every:g} s makes {many:.3g} samples of {until:g} s; {FINEST:.3g} are the most")
    else:
        times: Array = every * np.arange(math.floor(many * (1 + 1e-12)) + 1, dtype=np.float64)
        late = until - times[-1] > 1e-9 * every
        return np.append(times if late else times[:-1], until)
    return np.zeros(1)
