"""What forces and motions are said in: words, files, tables, arrays over time, functions, and any mixture of these.

    "F=2*t, M=3"                     formulas or laws, as in a shell
    "run.csv", "laws.toml"           files
    {"F": "2*t", "M": 3}             formulas, of SymPy too, and numbers by name
    {"F": (t, x)}, {"t": t, "F": x}  numbers over rising times
    {"F": function}                  a function; whoever reads knows of what
    a data frame, a data set, a run  columns over the column or index t; those that mean something here are taken
    a list of any of these

Every mistake is told once, by the name that it was given under.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from numbers import Real
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import numpy as np

from symdyn.arguments import argument, is_function, is_sympy, with_names
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import quoted
from symdyn.scene import Quantity, tables_of
from symdyn.scene.values import Faults, FormulaError, formula_text, show, split_commas
from symdyn.simulation.prescribed.formulas_in_time import Columns, columns_of, read_file, words


class Tabular(Protocol):
    """A table of a package, or a run: columns by name."""

    def keys(self) -> Any:
        """Return the names of the columns."""

    def __getitem__(self, name: Any, /) -> Any:
        """Return a column."""


Entries: TypeAlias = str | Path | Mapping[str, Any] | Callable[..., Any] | Tabular | Sequence[Any]
"""What the module's legend lists."""

KINDS = 'a formula such as "2*t", a number, (times, values), or a function of t'
OF_ARRAYS = 'the times of all arrays are called "t"'


@dataclass
class SpecifiedEntries:
    """Entries sorted by kind.

    Attributes:
        texts: formulas or laws: where they stand, name, text.
        tables: numbers over time.
        functions: name and function; the name is "" where a function stands for all.
    """

    texts: list[tuple[str, str, str]] = field(default_factory=list)
    tables: list[Columns] = field(default_factory=list)
    functions: list[tuple[str, Callable[..., Any]]] = field(default_factory=list)


def read_entries(
    entries: Entries, what: str, faults: Faults, needed: Collection[str] | None = None
) -> SpecifiedEntries:
    """Return what entries say; `what` is the option, "forces" or "motion"; `needed` as of `Columns.read`."""
    found, plain = SpecifiedEntries(), list[str]()
    alone = isinstance(entries, (str, Path, Mapping)) or is_function(entries) or _is_table(entries)
    for entry in [entries] if alone or not isinstance(entries, Sequence) else entries:
        with faults.noted():
            if isinstance(entry, (str, Path)):
                _words(str(entry), what, found, plain, faults, needed)
            elif _is_table(entry):
                found.tables.append(_table(entry, what))
            elif isinstance(entry, Mapping):
                _by_name(entry, what, found, faults)
            elif told := _controller(entry, what, ""):
                faults.add(what, told)
            elif is_function(entry):
                found.functions.append(("", entry))
            elif hasattr(entry, "keys"):
                faults.add(what, f"{type(entry).__name__} has neither a column nor an index t, the times in s")
            else:
                gains = what == "forces" and _dimensions(entry) == 2
                own = "gains as feedback=, or " * gains + "its .forces, or " * hasattr(entry, "forces")
                faults.add(what, f"{_spoken(entry)} says no {what}; give {own}{KINDS} by name, text, or a table")
    found.texts += [(what, name, text) for name, text in words(plain, what, faults).items()]
    return found


def _words(
    entry: str, what: str, found: SpecifiedEntries, plain: list[str], faults: Faults, needed: Collection[str] | None
) -> None:
    """Sort what a shell says: a file, or name=formula, several with commas between."""
    for part in split_commas(entry) if "=" in entry and what != "path" else [entry]:  # a point of a path has commas
        suffix = "" if "=" in part else Path(part).suffix.lower()
        if suffix == ".csv":
            found.tables.append(Columns.read(Path(part), needed))
        elif suffix == ".toml":
            found.texts += [(part, name, text) for name, text in _toml(Path(part), what, faults)]
        else:
            plain.append(part)


def _by_name(entries: Mapping[Any, Any], what: str, specified_entries: SpecifiedEntries, faults: Faults) -> None:
    """Sort what is given by name; numbers under "t" are the times of all arrays."""
    entries, over = with_names(entries), dict[str, Any]()
    for name, value in entries.items():
        try:
            text = _text(value)
        except FormulaError as error:
            faults.add(f"{what}: {name}", str(error))
            continue
        if not isinstance(name, str):
            faults.add(what, f"{name!r} is no name; names are text")
        elif name == TIME:
            if text is not None or callable(value):
                faults.add(what, f"t = {text or 'a function'} is not what moves; t are the times of arrays")
        elif text is not None:
            specified_entries.texts.append((what, name, text))
        elif told := _controller(value, what, f"symdyn.Feedback(CONTROLLER, {name!r})"):
            faults.add(f"{what}: {name}", told)
        elif is_function(value):
            specified_entries.functions.append((name, value))
        elif entries.get(TIME) is not None and not isinstance(value, tuple):
            over[name] = value
        else:
            pair = _over(value)
            if isinstance(pair, (tuple, list)) and len(pair) == 2 and all(_dimensions(one) == 1 for one in pair):
                with faults.noted():
                    specified_entries.tables.append(columns_of(f"{what}: {name}", pair[0], {name: pair[1]}, every=True))
            else:
                faults.add(f"{what}: {name}", f"{_spoken(value)} is no course over time; give {KINDS}; {OF_ARRAYS}")
    if over:
        with faults.noted():
            specified_entries.tables.append(columns_of(what, entries[TIME], over, every=True))


CONTROLLERS, PARTS = ("symdyn.", "control.", "scipy.signal."), ("feedback", "law", "num", "B", "numerator", "to_tf")
"""Modules of controllers, ours and others', and attributes of which one has some."""


def _controller(value: Any, what: str, given: str) -> str:
    """Return what is told of a controller, ours or another library's, "" of anything else; a run takes it `given`."""
    ours = any(kind.__module__.startswith(CONTROLLERS) for kind in type(value).__mro__)
    if not ours or not any(hasattr(value, name) for name in PARTS):
        return ""
    way = f"give it as {argument('feedback', python=f'feedback={given}')}"
    told = way if what == "forces" else f"{what} takes a course over time: {KINDS}"
    return f"{_spoken(value)} is a controller; {told}"


def _over(value: Any) -> Any:
    """Return times and numbers of a series over an index, or of an array over a coordinate t; else what was given."""
    if not hasattr(value, "to_numpy"):
        return value
    times = getattr(value, "coords", {}).get(TIME) if not hasattr(value, "index") else value.index
    return value if times is None else (times, value.to_numpy())


def _text(value: Any) -> str | None:
    """Return a formula or a number as text, None for what is neither."""
    if isinstance(value, Quantity) or is_sympy(value):
        return formula_text(value)
    if isinstance(value, str):
        return value.strip()
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (Real, Decimal)):
        return None
    return repr(float(value)) if isinstance(value, float) else str(value)  # NumPy's doubles have another repr


def _is_table(entry: Any) -> bool:
    """Tell whether something is a table of a package, or a run: columns by name over t, but no plain mapping."""
    if isinstance(entry, dict) or not (hasattr(entry, "keys") and hasattr(entry, "__getitem__")):
        return False
    try:
        return has_index(entry) or _dimensions(entry[TIME]) == 1
    except (KeyError, TypeError, ValueError, IndexError):
        return False


def has_index(entry: Any) -> bool:
    """Whether something is a data frame over the times: its index is called t."""
    return getattr(getattr(entry, "index", None), "name", None) == TIME


def _table(entry: Any, what: str) -> Columns:
    """Return the columns of a table that are one number a time."""
    times = entry.index if has_index(entry) else entry[TIME]
    names = [name for name in entry.keys() if name != TIME]  # noqa: SIM118  a data frame yields columns, a run rows
    arrays = {name: np.asarray(entry[name]) for name in names if isinstance(name, str)}
    numbers = {name: x for name, x in arrays.items() if x.ndim == 1 and x.dtype.kind in "iuf"}
    curves = getattr(entry, "curves", {})
    found = columns_of(f"{what}: {type(entry).__name__}", times, numbers)
    return replace(found, curves=curves) if isinstance(curves, Mapping) else found


def _dimensions(value: Any) -> int:
    """Return how many indices something has, -1 where its rows differ in length."""
    try:
        return int(np.ndim(value))
    except ValueError:
        return -1


def _spoken(value: Any) -> str:
    kind = type(value).__name__
    return f"an array of shape {value.shape}" if isinstance(value, np.ndarray) else f"{kind} {quoted(value)}"


def _toml(path: Path, table: str, faults: Faults) -> list[tuple[str, str]]:
    """Return name and text of every entry of a TOML file, under [table] or without it."""
    root = tables_of(read_file(path), str(path))
    inner = root.get(table, root)
    if not isinstance(inner, Mapping):
        faults.add(str(path), f"{table} = {show(inner)} is not a table; write [{table}] and name = law below")
        return []
    found = []
    for name, value in inner.items():
        if isinstance(value, (str, int, Decimal)) and not isinstance(value, bool):
            found.append((name, str(value)))
        else:
            faults.add(str(path), f"{name} = {show(value)} is neither a number nor a formula in quotes")
    return found
