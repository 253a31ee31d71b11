"""Matrices whose rows and columns have names; weights and variances, from Python, a command line or an .npz file."""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias
from zipfile import BadZipFile, ZipFile, ZipInfo

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.bounds import BOUNDS
from symdyn.errors import LinearizeError, listed, quoted, suggestion
from symdyn.frozen import dataclass
from symdyn.linear.locus import array_of
from symdyn.scene.values import Faults, Parameter, split_commas
from symdyn.simulation.prescribed import read_number


@dataclass(frozen=True)
class Axis:
    """What the rows or columns of a matrix stand for, and their units."""

    names: tuple[str, ...]
    units: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.names)

    def of(self, places: Sequence[int]) -> Axis:
        """Return some of them."""
        return Axis(tuple(self.names[k] for k in places), tuple(self.units[k] for k in places))

    def squared(self, form: str) -> Axis:
        """Return it with the units of variances, "{}", of weights, "1/{}", and their like."""
        squares = [f"{unit}^2" if unit.isalpha() else f"({unit})^2" for unit in self.units]
        return Axis(self.names, tuple(u and form.format(x) for u, x in zip(self.units, squares, strict=True)))

    def place(self, name: str | None, what: str) -> int:
        """Return the place of a name, or of the only one there is; `what` says what has it.

        Raises:
            LinearizeError: no such name, or none given where there are several.
        """
        if name is None and len(self) == 1:
            return 0
        if name is None:
            raise LinearizeError(f"{what}: name one of {', '.join(self.names) or 'none that there are'}")
        if name not in self.names:
            more = f'; linearize(..., outputs=["{name}"]) asks for others' if what == "output" else ""
            raise LinearizeError(f"{what}: {name} is not known; {suggestion(name, self.names)}{more}")
        return self.names.index(name)


def places(
    outputs: Axis, inputs: Axis, channel: tuple[str | None, str | None], states: Sequence[str] = ()
) -> tuple[int, int]:
    """Return the places of an output and an input, or of the only ones there are.

    Raises:
        LinearizeError: as of `Axis.place`; an input in the output's place, an output or a state in the input's.
    """
    output, input = channel
    if output in inputs.names and output not in outputs.names:
        write = f'"{input if input in outputs.names else (*outputs.names, "")[0]}", "{output}"'
        raise LinearizeError(f"output: {output} is an input; outputs come first, then inputs: ({write})")
    if input is not None and input in (*outputs.names, *states) and input not in inputs.names:
        kind = "an output" if input in outputs.names else "a state"
        known = (
            f"inputs are {listed(inputs.names)}" if inputs.names else "there is none: declare a drive, or [inputs.u]"
        )
        raise LinearizeError(f"input: {input} is {kind}, and no input; {known}")
    return outputs.place(output, "output"), inputs.place(input, "input")


Weights: TypeAlias = Mapping[str, float | str] | Sequence[Sequence[float]] | Sequence[float] | float | Array

SYMMETRIC = 1e-9
"""Differences from symmetry, and eigenvalues below zero, over the largest entry of a weight, that are rounding."""


def read_weights(option: str, specified: Sequence[str], names: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """Return weights by name of `Q=x:10;theta:100`, numbers being formulas, or of an .npz file.

    `names` are those of the weights, and what each has an entry for.

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
            first, second = [*names][:2]
            weights = f"{first}={text.replace('=', ':').replace(',', ';')}"
            likely = f"; write {weights}" if equals and name.isidentifier() and "[" not in text else ""
            faults.add(option, f'"{text}" is no {first}=NAME:1;NAME:2, no {second}=... and no .npz file{likely}')
            continue
        if name in found:
            faults.add(option, f"{name} is given twice")
        found[name] = {}
        if not rest:
            faults.add(option, f"{name}: weighs nothing; write {name}={(*names[name], 'NAME')[0]}:1, or leave it out")
        for part in filter(None, split_commas(rest.replace(";", ","))):
            key, colon, value = (one.strip() for one in part.rpartition(":"))
            if not colon and part.startswith(("diag", "eye", "[")):
                said = re.findall(r"[0-9][0-9.e+-]*", part)
                sizes = said if len(said) == len(names[name]) else ["1"] * len(names[name])
                write = ";".join(map(":".join, zip(names[name], sizes, strict=True)))
                faults.add(option, f'{name}: "{part}" names nothing; write {name}={write}, or matrices in an .npz file')
                continue
            if not colon:
                lacks, write = (
                    ("weight", f"{part}:1")
                    if part[0].isalpha()
                    else ("name", f"{name}={(*names[name], 'NAME')[0]}:{part}")
                )
                faults.add(option, f'{name}: "{part}" has no {lacks}; write {write}')
                continue
            if key in found[name]:
                faults.add(option, f"{name}: {key} is named twice")
            number = read_number(value, {}, f"{option}: {name}: {key}", faults, Parameter("")) or 0.0
            measured = name != "N" and re.search(r"\d ?(/ ?)?(?![eE][+-]?\d)[^\W\d_]", value)
            found[name][key] = value if measured else number
    faults.close(LinearizeError)
    return found


def _arrays(name: str, requested: Collection[str], faults: Faults) -> dict[str, Any]:
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


ENDING = ".npy"
"""Of the arrays in a .npz file."""


def check_arrays(path: Path, needed: Sequence[str] = ()) -> None:
    """Look at the names and sizes of the arrays of a .npz file, some needed, before any of them is unpacked.

    Raises:
        LinearizeError: more than is read.
        OSError, ValueError: it is no such file, lacks an array, or an array says that it has more than is there.
    """
    most = BOUNDS["bytes of the arrays of a file"]
    try:
        with ZipFile(path) as packed:
            inside = {one.filename.removesuffix(ENDING): one for one in packed.infolist()}
            if (size := sum(one.file_size for one in packed.infolist())) > most:
                raise LinearizeError(f"{path}: holds arrays of {size >> 20} MB; {most >> 20} are the most that is read")
            if missing := [name for name in needed if name not in inside]:
                raise ValueError(f"it has no {', '.join(missing)}")
            for name, one in inside.items():
                if one.filename.endswith(ENDING) and _told(packed, one) > one.file_size:
                    raise ValueError(f"{name} says that it has more numbers than are there")
    except (BadZipFile, zlib.error, NotImplementedError, RuntimeError) as fault:
        raise ValueError(fault) from None


def _told(packed: ZipFile, one: ZipInfo) -> int:
    """Return the bytes that an array of a .npz file says it has."""
    with packed.open(one) as file:
        newer = np.lib.format.read_magic(file) != (1, 0)
        read = np.lib.format.read_array_header_2_0 if newer else np.lib.format.read_array_header_1_0
        shape, _, kind = read(file)
    return math.prod(shape) * kind.itemsize


LARGEST = 1e150
"""No weight is as large: its square is a double."""


def weight(
    name: str, given: Weights | None, axis: Axis, faults: Faults, definite: bool = False, inputs: Axis | None = None
) -> Array:
    """Return a weight as a symmetric matrix; what is wrong with it goes to the faults.

    The axis of variances, V and W, has their units. Of drives, `inputs` are all there are: the others are disturbances.
    """
    n = len(axis)
    if given is None:
        return np.eye(n)
    if isinstance(given, Mapping):
        found, kind = np.zeros(n), "variance" if name in ("V", "W") else "weight"
        units = dict(zip(axis.names, (axis if kind == "variance" else axis.squared("1/{}")).units, strict=True))
        for key, one in given.items():
            value, letter = _number(one), Parameter(str(key), unit=units.get(key, ""))
            if isinstance(one, str):
                read = read_number(one, {}, f"{name}: {key}", faults, letter)
                value = float(definite) if read is None else read  # what cannot be read is told already
            if inputs is not None and key in inputs.names and key not in axis.names:
                told = f"there is a drive to control by: {', '.join(axis.names)}; {key} controls where its joint has"
                faults.add(name, f"{key} disturbs, as {told} drive = false")
            elif key not in axis.names:
                measured = f"; V is of outputs, which linearize chooses: {argument('outputs', [*axis.names, key])}"
                outputs = {"Q": "; outputs are weighed by Q = lin.C.T @ W @ lin.C", "V": measured}
                faults.add(name, f"{key} is not known; {suggestion(key, axis.names)}{outputs.get(name, '')}")
            elif not value < LARGEST or value < 0 or (definite and value == 0):
                least = "above zero" if definite else "of 0 or more"
                faults.add(name, f"{key}: {quoted(one)} is no {kind}; give one {least}")
            else:
                found[axis.names.index(key)] = value
        if definite:
            found = np.where([one in given for one in axis.names], found, 1.0)
        return np.diag(found)
    M: Array = array_of(given)
    if M.shape in ((), (n,)):  # one for all, or a diagonal
        M = np.diag(np.broadcast_to(M, n))
    largest = float(np.abs(M).max(initial=0.0))
    if M.shape != (n, n) or not largest < LARGEST:
        told = f"is no weight of {n} x {n} finite numbers, a diagonal of {n} or one for all"
        faults.add(name, f"{told}, for {', '.join(axis.names)}; it has the shape {M.shape}")
        return np.eye(n)
    if np.abs(M - M.T).max(initial=0.0) > SYMMETRIC * largest:
        faults.add(name, "is not symmetric")
    sizes, ways = np.linalg.eigh((M + M.T) / 2)
    if n and (sizes[0] < -SYMMETRIC * largest or (definite and sizes[0] <= SYMMETRIC * largest)):
        kind, most = "definite" if definite else "semidefinite", axis.names[int(np.abs(ways[:, 0]).argmax())]
        faults.add(name, f"is not positive {kind}: it has the eigenvalue {sizes[0]:.6g}, mostly of {most}")
    return np.asarray((M + M.T) / 2)


def _number(given: Any) -> float:
    try:
        return float(given)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def read_matrix(letter: str, given: object, faults: list[str]) -> Array:
    """Return a matrix; what is wrong with it goes to the faults."""
    found: Array = array_of(given)
    if found.ndim != 2 or not np.isfinite(found).all():
        faults.append(f"{letter} is no matrix of finite numbers, as in [[0, 1], [-2, -3]]")
        return np.zeros((0, 0))
    return found


def read_axis(what: str, given: Axis | Sequence[str] | None, letter: str, count: int, faults: list[str]) -> Axis:
    """Return names of states, inputs or outputs; what is wrong with them goes to the faults."""
    if isinstance(given, Axis):
        names, units = given.names, given.units
    else:
        names = tuple(f"{letter}{k + 1}" for k in range(count)) if given is None else tuple(given)
        units = ("",) * len(names)
    if len(names) != count or not all(isinstance(one, str) for one in names):
        faults.append(f"{what}: give {count} names, not {len(names)}")
    elif len(set(names)) < count:
        faults.append(f"{what}: {next(one for one in names if names.count(one) > 1)} is named twice")
    return Axis(names, units)
