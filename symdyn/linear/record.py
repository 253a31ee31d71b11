"""Linear systems on disk: NumPy's .npz, MATLAB's .mat, and CSV with names on rows and columns."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np

from symdyn.emit import Contents, write_file
from symdyn.errors import EmitError, LinearizeError
from symdyn.linear.linearization import Linearization
from symdyn.linear.regulator import Axis
from symdyn.linear.report import as_json
from symdyn.table import Table


def arrays(systems: Sequence[Linearization]) -> dict[str, Any]:
    """Return the arrays of a system, or of several, then with one more axis in front; times and points beside them."""
    parts: dict[str, Any] = {letter: np.array([getattr(one, letter) for one in systems]) for letter in "ABCD"}
    parts |= {name: np.array([getattr(one.point, name) for one in systems]) for name in ("t", "q", "u", "tau")}
    parts["eigenvalues"] = np.array([one.eigenvalues for one in systems])
    parts = {name: part[0] if len(systems) == 1 else part for name, part in parts.items()}
    for name in ("states", "inputs", "outputs"):
        axis: Axis = getattr(systems[0], name)
        parts[name], parts[f"{name[:-1]}_units"] = np.array(axis.names), np.array(axis.units)
    return parts


def write_npz(systems: Sequence[Linearization], file: IO[bytes]) -> None:
    """Write arrays, names, units, and JSON of the rest."""
    about = np.array(json.dumps([_about(one) for one in systems], ensure_ascii=False))
    np.savez_compressed(file, **arrays(systems), about=about)


def write_mat(systems: Sequence[Linearization], file: IO[bytes]) -> None:
    """Write arrays, names and units for MATLAB and Octave; several systems have a last axis more, one a system."""
    from scipy.io import savemat

    parts = arrays(systems)
    if len(systems) > 1:
        parts |= {letter: np.moveaxis(parts[letter], 0, -1) for letter in "ABCD"}
    names = [name for name, part in parts.items() if part.dtype.kind == "U"]
    parts |= {name: np.array(parts[name].tolist(), dtype=object) for name in names}
    whole = io.BytesIO()
    savemat(whole, parts)  # type: ignore[arg-type]  # a file serves
    text = whole.getvalue()
    file.write(b"symdyn linearize".ljust(116) + text[116:])  # in place of the date


def csv_text(systems: Sequence[Linearization]) -> str:
    """Return A, B, C, D one below the other: the matrix, its row, and a column for every state and input."""
    first = systems[0]
    heads = ("t", "matrix", "row", "unit", *first.states.names, *first.inputs.names)
    rows: list[tuple[str | float, ...]] = []
    for one in systems:
        for left, right, axis, name in ((one.A, one.B, one.states, "rate"), (one.C, one.D, one.outputs, "output")):
            units = [_rate(unit) if name == "rate" else unit for unit in axis.units]
            for row, unit, x, w in zip(axis.names, units, left.tolist(), right.tolist(), strict=True):
                rows.append((one.point.t, name, row, unit, *x, *w))
    return Table(heads, rows).csv()


def _rate(unit: str) -> str:
    return f"{unit}^2" if unit.endswith("/s") else f"{unit}/s"


def _about(one: Linearization) -> dict[str, Any]:
    return {key: value for key, value in as_json(one).items() if key not in ("A", "B", "C", "D", "formulas")}


WRITERS: Mapping[str, Callable[[Sequence[Linearization]], Contents]] = {
    ".npz": lambda found: partial(write_npz, found),
    ".mat": lambda found: partial(write_mat, found),
    ".csv": csv_text,
}


@dataclass(frozen=True)
class SystemsFile:
    """A file that linear systems are written to.

    Raises:
        LinearizeError: an ending that is none of `WRITERS`, or no such folder.
    """

    path: Path

    def __post_init__(self) -> None:
        if self.path.suffix.lower() not in WRITERS:
            raise LinearizeError(f"{self.path}: linear systems are written to {' or '.join(WRITERS)} files")
        if not self.path.parent.is_dir():
            raise LinearizeError(f"{self.path}: there is no folder {self.path.parent}")

    def write(self, systems: Sequence[Linearization]) -> None:
        """Write systems of the same states, inputs and outputs.

        Raises:
            LinearizeError: systems of different states, or a file that cannot be written.
        """
        if len({(one.states, one.inputs, one.outputs) for one in systems}) != 1:
            raise LinearizeError(f"{self.path}: these are systems of different states; write one at a time, with --at")
        try:
            write_file(self.path, WRITERS[self.path.suffix.lower()](systems))
        except EmitError as fault:
            raise LinearizeError(str(fault)) from None
