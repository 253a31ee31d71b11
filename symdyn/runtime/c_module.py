"""Compiled C, and targets with a C interface, called as the NumPy module is: shapes checked, batches broadcast.

Rows of a batch run on several threads of Python: the C code needs no thread library. A call through ctypes releases the
interpreter's lock, so the parts run side by side. Threads live for one call: a forked process has none to inherit. The
calling thread works too. Another one is started only for enough work to pay, which is the number of states times the
cost of one.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.arguments import suggesting
from symdyn.dynamics import Function
from symdyn.dynamics.outputs import Counts
from symdyn.emit import C, Entries, Sources, emit
from symdyn.emit.code import REALS
from symdyn.errors import BuildError
from symdyn.frozen import dataclass, field
from symdyn.program import Program, shared
from symdyn.runtime.cache import check_target
from symdyn.runtime.compiler import CPLUSPLUS, PATIENCE, RUSTC, Compiler, find_compiler
from symdyn.runtime.library import load_functions

WORTH = 12_500_000
"""Price of what a thread must have to be worth starting: 180 µs on the fastest core that was measured, so that a call
may cost as much again on two threads and is no slower than on one (`benchmarks/two_threads.py`)."""

NUMBER = 10
"""Price of a number that is read or written, in multiplications, as operations are priced."""

GRAIN = 64
"""Parts start at multiples of so many states, as blocks do: the result does not depend on the number of threads."""


def price(function: Function, itemsize: int = 8) -> float:
    """Return what one state of a function costs: its operations, and the numbers of its own, of `itemsize` bytes each.

    Vectors hold twice as many numbers of half the size. The two parts of a double-double are priced as one number: what
    takes longer than it is priced at is only put on threads later than it might be.
    """
    common = shared([one.name for one in function.arguments])
    own = [prod(one.shape) for one in function.arguments if one.name != common]
    numbers = sum(own) + prod(function.shape)
    return (Counts.of(function).cost + NUMBER * numbers) * itemsize / 8


def split(states: int, threads: int, price: float) -> list[tuple[int, int]]:
    """Return (first, past the last) state of each part; one part where more are not worth their threads.

    Args:
        states: how many there are.
        threads: at most so many parts.
        price: of one state, see `price`.

    Example:
        >>> split(30000, 2, price=1000)
        [(0, 15040), (15040, 30000)]
        >>> split(30000, 2, price=100)
        [(0, 30000)]
    """
    number = max(1, min(threads, int(states * price / WORTH)))
    grain = max(1, -(-states // (number * GRAIN))) * GRAIN
    return [(first, min(first + grain, states)) for first in range(0, states, grain)] or [(0, 0)]


def run_rows(
    call: Callable[..., Any],
    places: Sequence[int],
    strides: Sequence[int],
    parts: Sequence[tuple[int, int]],
    held: object = None,
) -> None:
    """Call an entry for rows on every part of the states, each on a thread of its own, the first on the caller's.

    Where no thread can be started, as when Python ends, the caller does what is left.

    Args:
        call: takes a number of states, then addresses.
        places: address of each array's first state.
        strides: bytes from one state to the next; 0 for params, which all states share.
        parts: (first, past the last) state of each.
        held: the arrays, which stay until all threads are done, also those that a second Ctrl-C does not wait for.
    """

    def work(part: tuple[int, int], _held: object = held) -> None:
        first, last = part
        call(last - first, *(place + first * stride for place, stride in zip(places, strides, strict=True)))

    if len(parts) == 1:
        work(parts[0])
        return
    begun: list[Future[None]] = []
    with ThreadPoolExecutor(len(parts) - 1) as pool:
        with suppress(RuntimeError):
            for part in parts[1:]:
                begun.append(pool.submit(work, part))
        for part in (parts[0], *parts[1 + len(begun) :]):
            work(part)
        for one in begun:
            one.result()  # raises what it has raised


Array = npt.NDArray[Any]


@suggesting
def build(
    what: Program | Sources,
    compiler: str | None = None,
    real: str = "double",
    patience: float = PATIENCE,
    machine: str = "native",
    threads: int = 1,
) -> Module:
    """Return the compiled functions of a program, or of C sources that `emit` made.

    Args:
        what: a program, which gets code for batches, or sources of C, which carry their own real type.
        compiler: command to compile with; None looks for $CC, cc, gcc, clang and the ziglang package.
        real: "double", "float" or "dd", for a program.
        patience: seconds until a compiler that hangs is stopped.
        machine: "native" for code that runs on this machine, "portable" for any of its family.
        threads: on how many threads a batch is run at most; on fewer where it is too small for them.

    Raises:
        BuildError: no compiler, or its own words when it refuses.
        EmitError: the program cannot be written in C.
    """
    sources = emit(what, C.name, real, option="batch") if isinstance(what, Program) else what
    check_target(sources, C.name)
    if sources.option.startswith("stack"):
        raise BuildError("functions that take work space are called from C alone; emit them without option stack")
    if not any(name.endswith(".c") for name in sources):
        raise BuildError("header-only sources have no file to compile; emit them without that option")
    return _module(sources, find_compiler(compiler, machine), patience, threads)


def run_cpp(sources: Sources) -> Module:
    """Return the functions of sources that `emit(program, "cpp")` made: its templates for doubles, behind those of C.

    Raises:
        BuildError: sources of another target, or the compiler's own words where it refuses them.
        MissingCompiler: there is no C++ compiler.
    """
    check_target(sources, "cpp")
    return _module(sources, find_compiler(language=CPLUSPLUS))


def run_rust(sources: Sources) -> Module:
    """Return the functions of sources that `emit(program, "rust")` made, behind those of C; raises as `run_cpp`."""
    check_target(sources, "rust")
    return _module(sources, find_compiler(language=RUSTC))


def _module(sources: Sources, compiler: Compiler, patience: float = PATIENCE, threads: int = 1) -> Module:
    made = Entries.of(sources)
    path, library = load_functions(made.files, made.symbols.values(), compiler, patience)
    return Module(sources.program.scene.name, sources.real, path, functions_of(sources, library, threads))


def functions_of(sources: Sources, library: ctypes.CDLL, threads: int = 1) -> tuple[CFunction, ...]:
    """Return the functions of sources as a library has them, each under the names of the scene and its own."""
    opening, real = sources.stem, REALS[sources.real]
    pair = (real.parts,) if real.parts > 1 else ()
    return tuple(
        CFunction(
            name=name,
            arguments=tuple((a.name, a.shape + pair) for a in routine.function.arguments),
            shape=routine.function.shape + pair,
            dtype=real.dtype,
            text=routine.function.text,
            _call=bind(
                library, f"{opening}_{name}", [a.scalar and not pair for a in routine.function.arguments], real.dtype
            ),
            _rows=bind_rows(library, f"{opening}_{name}_rows", len(routine.function.arguments) + 1),
            _threads=threads,
            _price=price(routine.function, np.dtype(real.dtype).itemsize) if threads > 1 else 0.0,
        )
        for name, routine in zip(sources.functions, sources.program.routines, strict=True)
    )


@dataclass(frozen=True)
class CFunction:
    """One compiled function.

    Attributes:
        name: as in messages.
        arguments: (name, shape) in calling order, the shape () for one number.
        shape: of the result for one state.
        dtype: "float64" or "float32", of arguments and result.
        text: what it computes.

    Of double-doubles both parts of a number are the last dimension, of length 2, of arguments and result.

    Where the library has an entry for rows, a batch with one set of params, or of what was prepared from them, is one
    call.
    """

    name: str
    arguments: tuple[tuple[str, tuple[int, ...]], ...]
    shape: tuple[int, ...]
    dtype: str
    text: str
    _call: Any = field(repr=False, compare=False)
    _rows: Any = field(default=None, repr=False, compare=False)
    _threads: int = field(default=1, repr=False, compare=False)
    _price: float = field(default=0.0, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Say what it computes, as functions of the other targets do."""
        self.__dict__["__doc__"] = f"Return the {self.text}."

    def __call__(self, *values: npt.ArrayLike, **named: npt.ArrayLike) -> Any:
        """Return the result for one state, arguments (n,), or for a batch of them, (..., n), which broadcast.

        An argument that is one number has no dimension of its own.

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

    @property
    def _cores(self) -> list[tuple[int, ...]]:
        """Own dimensions of every argument, (1,) for one number."""
        return [shape or (1,) for _, shape in self.arguments]

    def _ordered(self, values: Sequence[npt.ArrayLike], named: Mapping[str, npt.ArrayLike]) -> list[npt.ArrayLike]:
        """Return the values in calling order, whether given by place or by name."""
        names = [name for name, _ in self.arguments]
        rest = names[len(values) :]
        if len(values) > len(names) or set(rest) != set(named):
            given = [f"{len(values)} by position", *(f"{name} by name" for name in named)]
            raise TypeError(f"{self.name} takes ({', '.join(names)}); given were {', '.join(given)}")
        return [*values, *(named[name] for name in rest)]

    def _checked(self, values: Sequence[npt.ArrayLike]) -> list[Array]:
        """Return the arguments as arrays with one dimension of their own, of length 1 for single numbers."""
        shapes = [shape for _, shape in self.arguments]
        arrays = [np.asarray(value, dtype=self.dtype) for value in values]
        arrays = [array if shape else array[..., None] for array, shape in zip(arrays, shapes, strict=True)]
        for array, (name, _), core in zip(arrays, self.arguments, self._cores, strict=True):
            if array.shape[-len(core) :] != core:
                found = f"{self.name}: {name} has shape {array.shape}"
                wanted = f"dimension must have length {core[0]}" if len(core) == 1 else f"dimensions must be {core}"
                raise ValueError(f"{found}; its last {wanted}")
        return [
            array if len(core) == 1 else array.reshape(*array.shape[: -len(core)], prod(core))
            for array, core in zip(arrays, self._cores, strict=True)
        ]

    def _batch(self, arrays: Sequence[Array]) -> tuple[int, ...]:
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
        common = self._shared
        return all(
            array.size == prod(shape) or name != common
            for array, (name, shape) in zip(arrays, self.arguments, strict=True)
        )

    def _run_rows(self, arrays: Sequence[Array], batch: tuple[int, ...], out: Array) -> None:
        common = self._shared
        rows = [
            np.ascontiguousarray(array) if name == common else _spread(array, batch)
            for array, (name, _) in zip(arrays, self.arguments, strict=True)
        ]
        places = [*(row.ctypes.data for row in rows), out.ctypes.data]
        lengths = [*(0 if name == common else prod(shape) for name, shape in self.arguments), prod(self.shape)]
        parts = split(prod(batch), self._threads, self._price)
        run_rows(self._rows, places, [length * out.itemsize for length in lengths], parts, held=(rows, out))

    def _run(self, rows: Sequence[Array], out: Array, count: int) -> None:
        """Call the function once a state, walking through contiguous memory."""
        shapes = [shape for _, shape in self.arguments]
        columns = [
            _addresses(row, prod(shape), count) if shape else row.ravel().tolist()
            for row, shape in zip(rows, shapes, strict=True)
        ]
        for given in zip(*columns, _addresses(out, prod(self.shape), count), strict=True):
            self._call(*given)


def _addresses(array: Array, length: int, count: int) -> Sequence[Any]:
    first, step = array.ctypes.data, length * array.itemsize
    return [first + state * step for state in range(count)]


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
        real: "double", "float" or "dd".
        path: the shared library.
        functions: in the order of the program.
    """

    name: str
    real: str
    path: Path
    functions: tuple[CFunction, ...]

    def __getattr__(self, name: str) -> CFunction:
        for function in self.__dict__.get("functions", ()):
            if function.name == name:
                found: CFunction = function
                return found
        known = ", ".join(function.name for function in self.__dict__.get("functions", ()))
        raise AttributeError(f"there is no function {name!r}; there are {known}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(function.name for function in self.functions)]


def bind(library: ctypes.CDLL, symbol: str, scalars: Sequence[bool], dtype: str) -> Any:
    """Return a C function of addresses, or of numbers where `scalars` says so, and of the address of its result."""
    call = getattr(library, symbol)
    number = ctypes.c_float if dtype == "float32" else ctypes.c_double
    call.argtypes = [*(number if scalar else ctypes.c_void_p for scalar in scalars), ctypes.c_void_p]
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
