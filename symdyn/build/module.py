"""Compiled functions as Python callables with the manners of the NumPy module: shapes checked, batches broadcast."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.build.threads import run_rows
from symdyn.program.assemble import shared

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class CFunction:
    """One compiled function.

    Attributes:
        name: as in messages.
        arguments: (name, length) in calling order.
        shape: of the result for one state.
        dtype: "float64" or "float32", of arguments and result.
        text: what it computes.

    Where the library has an entry for rows, a batch with one set of params, or of what was prepared from them, is one
    call.
    """

    name: str
    arguments: tuple[tuple[str, int], ...]
    shape: tuple[int, ...]
    dtype: str
    text: str
    _call: Any = field(repr=False, compare=False)
    _rows: Any = field(default=None, repr=False, compare=False)
    _threads: int = field(default=1, repr=False, compare=False)

    def __call__(self, *values: npt.ArrayLike, **named: npt.ArrayLike) -> Any:
        """Return the result for one state, arguments (n,), or for a batch of them, (..., n), which broadcast.

        Returns:
            An array of the leading dimensions and `shape`; a NumPy scalar where both are ().

        Raises:
            TypeError: an argument is missing, unknown or given twice.
            ValueError: a last dimension of the wrong length, or leading dimensions that do not broadcast.
        """
        arrays = self._checked(self._ordered(values, named))
        batch = self._batch(arrays)
        out = np.empty(batch + self.shape, self.dtype)
        count = prod(batch)
        if self._rows is not None and count > 1 and self._share_params(arrays):
            self._run_rows(arrays, batch, out)
        else:
            self._run([_spread(array, batch) for array in arrays], out, count)
        return out[()]

    def _ordered(self, values: Sequence[npt.ArrayLike], named: Mapping[str, npt.ArrayLike]) -> list[npt.ArrayLike]:
        """Return the values in calling order, whether given by place or by name."""
        names = [name for name, _ in self.arguments]
        rest = names[len(values) :]
        if len(values) > len(names) or set(rest) != set(named):
            given = [f"{len(values)} by place", *(f"{name} by name" for name in named)]
            raise TypeError(f"{self.name} takes ({', '.join(names)}); given were {', '.join(given)}")
        return [*values, *(named[name] for name in rest)]

    def _checked(self, values: Sequence[npt.ArrayLike]) -> list[Array]:
        """Return the arguments as arrays with the right last dimension."""
        arrays = [np.asarray(value, dtype=self.dtype) for value in values]
        for array, (name, length) in zip(arrays, self.arguments, strict=True):
            if array.shape[-1:] != (length,):
                found = f"{self.name}: {name} has shape {array.shape}"
                raise ValueError(f"{found}; its last dimension must have length {length}")
        return arrays

    def _batch(self, arrays: Sequence[Array]) -> tuple[int, ...]:
        """Return the leading dimensions that all arguments broadcast to."""
        batches = [array.shape[:-1] for array in arrays]
        if not any(batches):
            return ()
        try:
            return np.broadcast_shapes(*batches)
        except ValueError:
            names = ", ".join(name for name, _ in self.arguments)
            raise ValueError(f"{self.name}: leading dimensions {batches} of {names} do not broadcast") from None

    @property
    def _shared(self) -> str:
        """The argument that the entry for rows takes once for all states."""
        return shared([name for name, _ in self.arguments])

    def _share_params(self, arrays: Sequence[Array]) -> bool:
        """Tell whether all states have one set of params."""
        common = self._shared
        return all(
            array.size == length or name != common for array, (name, length) in zip(arrays, self.arguments, strict=True)
        )

    def _run_rows(self, arrays: Sequence[Array], batch: tuple[int, ...], out: Array) -> None:
        """Call the function once for all states."""
        common = self._shared
        rows = [
            np.ascontiguousarray(array) if name == common else _spread(array, batch)
            for array, (name, _) in zip(arrays, self.arguments, strict=True)
        ]
        places = [*(row.ctypes.data for row in rows), out.ctypes.data]
        lengths = [*(0 if name == common else length for name, length in self.arguments), prod(self.shape)]
        run_rows(self._rows, places, [length * out.itemsize for length in lengths], prod(batch), self._threads)

    def _run(self, rows: Sequence[Array], out: Array, count: int) -> None:
        """Call the function once a state, walking through contiguous memory."""
        size = out.itemsize
        places = [row.ctypes.data for row in rows] + [out.ctypes.data]
        strides = [length * size for _, length in self.arguments] + [prod(self.shape) * size]
        for state in range(count):
            self._call(*(place + state * stride for place, stride in zip(places, strides, strict=True)))


def _spread(array: Array, batch: tuple[int, ...]) -> Array:
    """Return the array contiguous, one row a state of the batch."""
    return np.ascontiguousarray(
        array if array.shape[:-1] == batch else np.broadcast_to(array, (*batch, array.shape[-1]))
    )


@dataclass(frozen=True)
class Module:
    """A compiled scene; every function is an attribute.

    Attributes:
        name: of the scene.
        real: "double" or "float".
        path: the shared library.
        functions: in the order of the program.
    """

    name: str
    real: str
    path: Path
    functions: tuple[CFunction, ...]

    def __getattr__(self, name: str) -> CFunction:
        """Return the function called `name`."""
        for function in self.__dict__.get("functions", ()):
            if function.name == name:
                found: CFunction = function
                return found
        known = ", ".join(function.name for function in self.__dict__.get("functions", ()))
        raise AttributeError(f"there is no function {name!r}; there are {known}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(function.name for function in self.functions)]


def bind(library: ctypes.CDLL, symbol: str, arity: int) -> Any:
    """Return a C function of `arity` addresses and nothing to return."""
    call = getattr(library, symbol)
    call.argtypes = [ctypes.c_void_p] * arity
    call.restype = None
    return call


def bind_rows(library: ctypes.CDLL, symbol: str, arity: int) -> Any:
    """Return a C function of a count and `arity` addresses, None where the library does not have it."""
    if not hasattr(library, symbol):
        return None
    call = getattr(library, symbol)
    call.argtypes = [ctypes.c_size_t, *[ctypes.c_void_p] * arity]
    call.restype = None
    return call
