"""A run as a table: CSV, a data frame of pandas, a data set of xarray. These packages are the user's own."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from symdyn.algebra.numeric import Array
from symdyn.errors import SimulateError
from symdyn.simulation.columns import Column

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import xarray


def csv_text(names: Sequence[str], table: Array) -> str:
    """Return a header, then the shortest digits that read back to the same doubles."""
    lines = [",".join(names), *(",".join(map(repr, row)) for row in table.tolist())]
    return "\n".join(lines) + "\n"


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
