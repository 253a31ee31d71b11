"""Tables of numbers: rows of a scene, files beside it, and the formulas that read them by name."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

from symdyn.bounds import BOUNDS
from symdyn.errors import SceneError, suggestion
from symdyn.scene.declaration.reading import read_bounded
from symdyn.scene.values.curve import METHODS, Curve, Rows, cell_of, cells_of
from symdyn.scene.values.entry import Entry, EntryReader, Faults, plain, show
from symdyn.scene.values.folding import map_quantities, with_tables
from symdyn.scene.values.key import Key, Part, fields_of, keys_of, one_of
from symdyn.scene.values.quantity import FormulaError, Quantity
from symdyn.scene.values.shape import TEXT

Thing = TypeVar("Thing")

MOST_BYTES = BOUNDS["bytes of a TOML file"]


def read_columns(source: str, path: str) -> Rows:
    """Return the numbers of a CSV file beside a scene, in its folder or below.

    Raises:
        FormulaError: the path leads elsewhere, there is no such file, or it holds something else.
    """
    if Path(path).is_absolute() or ".." in Path(path).parts:
        raise FormulaError(f"{path} lies elsewhere; put it into the folder of the scene, or below")
    try:
        content = read_bounded(Path(source).parent / path, MOST_BYTES, "a CSV file", "no curve needs as much")
        return cells_of(content.decode("utf-8"))
    except (SceneError, ValueError) as error:
        text = str(error)
        raise FormulaError(text if path in text else f"{path}: {text}") from None


def _points(table: EntryReader, key: str, usual: Rows) -> Rows:
    raw = plain(table.raw.get(key, ()))
    try:
        if isinstance(raw, str):
            return read_columns(table.faults.source, raw)
        rows = [plain(row) for row in raw] if isinstance(raw, (list, tuple)) else [raw]
        if key in table and not rows:
            raise ValueError("has no rows; write [[0, 0], [1, 5]]")
        if all(isinstance(row, (list, tuple)) for row in rows):
            return tuple(tuple(cell_of(cell) for cell in row) for row in rows)  # type: ignore[attr-defined]
        raise ValueError(f'{show(raw)} is no list of rows such as [[0, 0], [1, 5]], nor a file such as "curve.csv"')
    except (FormulaError, ValueError) as error:
        table.fault(f"{key}: {error}")
        return usual


NOTHING: Rows = ()

_0, _1 = Fraction(0), Fraction(1)

LEVEL: dict[int, Rows] = {1: ((_0, _1), (_1, _1)), 2: ((None, _0, _1), (_0, _1, _1), (_1, _1, _1))}
"""What stands in for a table that is none, by the number of its arguments."""

TABLE: tuple[Part, ...] = (
    Key(
        "points",
        _points,
        NOTHING,
        'points = "curve.csv", or [[0, 0], [1, 5]]',
        holds='rows x, y, x ascending, or a CSV file of them; of two arguments rows y, z, ... below a row "", x, ...',
        shape={"anyOf": [TEXT, {"type": "array", "items": {"type": "array"}}]},
        said=lambda rows: [["" if x is None else Quantity.number(x) for x in row] for row in rows],
    ),
    one_of("method", [*METHODS], "between points", "linear"),
)


def curves_of(entries: Sequence[Entry], faults: Faults) -> dict[str, Curve]:
    """Return the tables of numbers that are declared, by name."""
    keys = keys_of(TABLE)
    curves = [Curve(one.name, **fields_of(TABLE, EntryReader(one, faults, keys))) for one in entries]
    for entry, curve in zip(entries, curves, strict=True):
        for told in curve.faults() if curve.points else ():
            faults.add(entry.where, f"points: {told}")
    return {curve.name: curve for curve in curves}


def tabled(thing: Thing, curves: dict[str, Curve], faults: Faults) -> Thing:
    """Return a noun with tables of numbers in its formulas, those of files that no one has declared too."""

    def read(name: str, arguments: int) -> Curve:
        front = f'table("{name}", ...)'
        if name not in curves and name.endswith(".csv"):
            curves[name] = Curve(re.sub(r"\W+", "_", name.removesuffix(".csv")), NOTHING)
            with faults.noted():
                curves[name] = replace(curves[name], points=read_columns(faults.source, name))
                for told in curves[name].faults():
                    faults.add(front, told)
        found = curves.get(name)
        if found is None:
            faults.add(front, f"is no table; {suggestion(name, curves)}" if curves else "is no table; declare [tables]")
        elif found.points and found.arguments != arguments:
            faults.add(front, f"takes {found.arguments} arguments, here are {arguments}")
        elif not any(found.faults()):
            return found
        return Curve(name, LEVEL[arguments])  # why it is none is told, and nothing else of formulas that hold it

    return map_quantities(thing, lambda one: with_tables(one, read))
