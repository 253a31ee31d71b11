"""A run as a table: CSV, a data frame of pandas, a data set of xarray. These packages are the user's own."""

from __future__ import annotations

import importlib
import math
from collections.abc import Mapping, Sequence
from decimal import ROUND_HALF_EVEN, Context, Decimal
from typing import TYPE_CHECKING, Any

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.simulation.columns import Column
from symdyn.table import Table

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import xarray


def columns_csv(names: Sequence[str], table: Array, low: Array | None = None) -> str:
    """Return lines of CSV; columns from the second on have 32 digits with `low`, what they are beyond their doubles."""
    rows: list[list[float | str]] = table.tolist()
    for k, more in enumerate([] if low is None else low.tolist()):
        rows[k][1 : 1 + len(more)] = map(in_full, table[k, 1 : 1 + len(more)].tolist(), more)
    return Table(names, rows).csv()


def in_full(high: float, low: float) -> str:
    """Return a double-double with 32 digits.

    >>> in_full(0.1, -5.551115123125783e-18)
    '0.10000000000000000000000000000000'
    """
    if not math.isfinite(high):
        return repr(high)
    exact = Context(prec=800).add(Decimal(high), Decimal(low))
    return str(Context(prec=32, rounding=ROUND_HALF_EVEN).plus(exact))


def frame(columns: Sequence[Column], table: Array, about: Mapping[str, Any]) -> pandas.DataFrame:
    """Return a data frame over the index t, s; units by column stand in `attrs`, beside what is known of the run."""
    found: pandas.DataFrame = _package("pandas").DataFrame(
        table[:, 1:],
        index=_package("pandas").Index(table[:, 0], name=columns[0].name),
        columns=[one.name for one in columns[1:]],
    )
    found.attrs |= {"units": {one.name: one.unit for one in columns}, **about}
    return found


def data_set(columns: Sequence[Column], table: Array, about: Mapping[str, Any]) -> xarray.Dataset:
    """Return a data set over the coordinate t; unit and kind of every variable stand in its `attrs`."""
    time, *others = columns
    variables = {
        one.name: (time.name, values, {"units": one.unit, "long_name": one.kind})
        for one, values in zip(others, table[:, 1:].T, strict=True)
    }
    at = {time.name: (time.name, table[:, 0], {"units": time.unit, "long_name": time.kind})}
    found: xarray.Dataset = _package("xarray").Dataset(variables, at, dict(about))
    return found


def _package(name: str) -> Any:
    """Return a package.

    Raises:
        SimulateError: it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise SimulateError(
            f"to_{name}() needs {name}, which is not installed; pip install {name}, or take .table() and .to_csv()"
        ) from None
