"""Weights and variances as users give them: by name, or as matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import LinearizeError
from symdyn.linear.axis import Axis
from symdyn.linear.ranges import number_in
from symdyn.linear.run_files import check_arrays
from symdyn.scene.values import Faults, FormulaError, suggestion

Weights: TypeAlias = Mapping[str, float] | Sequence[Sequence[float]] | Array

SYMMETRIC = 1e-9
"""Differences from symmetry, and eigenvalues below zero, over the largest entry of a weight, that are rounding."""


def read_weights(option: str, specified: Sequence[str], names: Sequence[str]) -> dict[str, Any]:
    """Return weights by name of `Q=x:10;theta:100`, numbers being formulas, or of an .npz file.

    Raises:
        LinearizeError: with every fault.
    """
    faults, found = Faults(""), dict[str, Any]()
    for text in specified:
        if text.lower().endswith(".npz"):
            found |= _arrays(text, names, faults)
            continue
        name, equals, rest = (part.strip() for part in text.partition("="))
        if not equals or name not in names:
            faults.add(option, f'"{text}" is no {names[0]}=NAME:1;NAME:2, no {names[1]}=... and no .npz file')
            continue
        if name in found:
            faults.add(option, f"{name} is given twice")
        found[name] = {}
        for part in filter(None, (one.strip() for one in rest.split(";"))):
            key, colon, value = (one.strip() for one in part.rpartition(":"))
            if not colon:
                faults.add(option, f'{name}: "{part}" has no weight; write {part}:1')
                continue
            if key in found[name]:
                faults.add(option, f"{name}: {key} is named twice")
            try:
                found[name][key] = number_in(value)
            except FormulaError as error:
                faults.add(option, f"{name}: {key}: {error}")
    faults.close(LinearizeError)
    return found


def _arrays(name: str, requested: Sequence[str], faults: Faults) -> dict[str, Any]:
    try:
        check_arrays(Path(name))
        with np.load(name, allow_pickle=False) as said:
            found = {key: value for key, value in said.items() if key in requested}
    except (OSError, ValueError, KeyError, EOFError) as error:
        faults.add(name, f"cannot be read as .npz: {error}")
        return {}
    if not found:
        faults.add(name, f"has no array {' or '.join(requested)}")
    return found


def weight(name: str, given: Weights | None, axis: Axis, faults: Faults, definite: bool = False) -> Array:
    """Return a weight as a symmetric matrix; what is wrong with it goes to the faults."""
    n = len(axis)
    if given is None:
        return np.eye(n)
    if isinstance(given, Mapping):
        found = np.zeros(n)
        for key, value in given.items():
            if key not in axis.names:
                faults.add(name, f"{key} is not known; {suggestion(key, axis.names)}")
            elif not np.isfinite(value) or value < 0 or (definite and value == 0):
                faults.add(
                    name, f"{key}: {value:g} is no weight; give one {'above zero' if definite else 'of 0 or more'}"
                )
            else:
                found[axis.names.index(key)] = value
        if definite:
            found = np.where([one in given for one in axis.names], found, 1.0)
        return np.diag(found)
    try:
        M = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        M = np.zeros(0)
    largest = float(np.abs(M).max(initial=0.0))
    if M.shape != (n, n) or not np.isfinite(M).all():
        faults.add(name, f"is no matrix of {n} x {n} finite numbers, for {', '.join(axis.names)}")
        return np.eye(n)
    if np.abs(M - M.T).max(initial=0.0) > SYMMETRIC * largest:
        faults.add(name, "is not symmetric")
    sizes, ways = np.linalg.eigh((M + M.T) / 2)
    if n and (sizes[0] < -SYMMETRIC * largest or (definite and sizes[0] <= SYMMETRIC * largest)):
        kind, most = "definite" if definite else "semidefinite", axis.names[int(np.abs(ways[:, 0]).argmax())]
        faults.add(name, f"is not positive {kind}: it has the eigenvalue {sizes[0]:.6g}, mostly of {most}")
    return np.asarray((M + M.T) / 2)
