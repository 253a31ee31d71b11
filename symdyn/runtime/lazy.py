"""Functions that are compiled when they are first called, each into a library of its own, double and float apart.

What a function computes is compiled once, by the flags of all others: its bits are the same at every call.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np

from symdyn.emit import Code, emit
from symdyn.program import Program
from symdyn.runtime.commands import threads
from symdyn.runtime.compiler import PATIENCE, find_compiler
from symdyn.runtime.dialects import Needs
from symdyn.runtime.extension import extension_kind
from symdyn.runtime.library import SUFFIX, LibraryKind, load_library
from symdyn.runtime.lock import Lock
from symdyn.runtime.runners import or_warn, run_python


class Makers:
    """What makes ufuncs of C, compiled by one compiler.

    Attributes:
        asked: the compiler that was asked for, as for `symdyn.runtime.build`.
        module: the extension module that all have in common.
    """

    def __init__(self, compiler: str | None = None, machine: str = "native") -> None:
        """Build the extension module, or find it in the cache.

        Raises:
            BuildError: no headers of Python, no compiler, or its own words when it refuses.
        """
        self.asked = compiler
        self._compiler = find_compiler(compiler, machine)
        kind = extension_kind(Code.RUNTIME.name)
        self.module: ModuleType = load_library(Code.RUNTIME.key, self._compiler, PATIENCE, kind, Code.RUNTIME.source)[1]

    def places(self, made: Code, soon: bool = False) -> list[int]:
        """Return where the entries of code are in memory, compiled unless they are in the cache.

        Raises:
            BuildError: no compiler, or its own words when it refuses.
        """
        symbols = tuple(one.symbol for one in made.entries)
        kind = LibraryKind(SUFFIX, Needs(exports=symbols, soon=soon), ("entries",), ctypes.CDLL)
        library = load_library(made.files, self._compiler, PATIENCE, kind)[1]
        return [ctypes.cast(getattr(library, one), ctypes.c_void_p).value or 0 for one in symbols]

    def ufunc(self, code: Code, number: int, place: int, later: Callable[[str, bool], int] | None = None) -> np.ufunc:
        """Return the ufunc of one of the entries of code for one state in double; `later` says where the others are."""
        entry, floats = code.entries[number], later is not None and code.fits_float
        made: np.ufunc = self.module.make(
            entry.name, entry.doc, entry.signature, entry.shapes, entry.params, floats, place, later
        )
        return made


class Places:
    """Where the code of one function is in memory, compiled when it is first asked for.

    A ufunc holds on to it, and it to none, so that both end with whoever calls it.
    """

    def __init__(self, makers: Makers, make: Callable[[], Program], accuracy: str = "") -> None:
        """Take what makes a program of one function, and what accuracy rows of states shall have."""
        self.makers, self._make, self.accuracy = makers, make, accuracy
        self._lock = Lock()
        self._program: Program | None = None
        self._found: dict[tuple[str, bool], int] = {}

    @property
    def program(self) -> Program:
        """The program, made when it is first needed; `cached_property` has a lock that a forked child finds shut."""
        with self._lock:
            if self._program is None:
                self._program = self._make()
        return self._program

    def __call__(self, real: str, rows: bool) -> int:
        """Return where the code of a kind is, 0 where rows are computed state by state.

        Raises:
            BuildError: the code for one state cannot be compiled.
        """
        with self._lock:
            if (real, rows) not in self._found:
                made = partial(self._compiled, Code.of(self.program, real, rows, self.accuracy))
                self._found[real, rows] = (or_warn(made, self.makers.asked) or 0) if rows else made()
        return self._found[real, rows]

    def ufunc(self) -> np.ufunc | None:
        """Return the function, compiled for one state in double; None where an operand is empty.

        Raises:
            BuildError: it cannot be compiled.
        """
        made = Code.of(self.program)
        if not made.entries:
            return None
        self._found["double", False] = place = self._compiled(made)
        return self.makers.ufunc(made, 0, place, self)

    def _compiled(self, made: Code) -> int:
        return self.makers.places(made)[0]


class Later:
    """A function that is made and compiled when it is first called; the NumPy module's where that cannot be done."""

    def __init__(self, makers: Makers, make: Callable[[], Program], accuracy: str = "") -> None:
        """Take what makes a program of one function; accuracy as for `emit`."""
        self._places = Places(makers, make, accuracy)
        self._lock = Lock()
        self._found: Callable[..., Any] | None = None

    def __call__(self, *values: Any, **named: Any) -> Any:
        """Return the result."""
        return self.found()(*values, **named)

    def found(self) -> Callable[..., Any]:
        """Return the function itself.

        Raises:
            DerivationError: there is no program, for its parameters' values make it divide by zero.
            BuildError: the compiler that was asked for, in words or as $CC, fails.
        """
        with self._lock:
            if self._found is None:
                self._found = or_warn(self._places.ufunc, self._places.makers.asked) or plain(self._places.program)[0]
        return self._found

    def doc(self) -> str | None:
        """Return what `help` says, for which nothing is compiled."""
        entries = Code.of(self._places.program).entries
        return entries[0].doc if entries else self.found().__doc__

    def everything(self) -> None:
        """Compile all of it now.

        Raises:
            BuildError: the compiler that was asked for, in words or as $CC, fails.
        """
        found = self.found()
        for kind in getattr(found, "types", ()):
            for rows in (False, True):
                self._places({"f": "float", "d": "double"}[kind[0]], rows)


def compile_all(calls: Iterable[Callable[..., Any]]) -> None:
    """Compile what would be compiled when it is called.

    Raises:
        BuildError: the compiler that was asked for, in words or as $CC, fails.
    """
    with threads() as pool:
        list(pool.map(Later.everything, [one for one in calls if isinstance(one, Later)]))


def plain(program: Program, real: str = "double") -> list[Callable[..., Any]]:
    """Return the functions of a program that the NumPy module has."""
    sources = emit(program, real=real)
    module = run_python(sources)
    return [getattr(module, name) for name in sources.functions]


def soon(program: Program) -> Mapping[str, Callable[..., Any]]:
    """Return the functions of a program by name, of doubles, compiled in a tenth of the time that `load` takes."""

    def make() -> dict[str, Callable[..., Any]]:
        makers, made = Makers(), Code.of(program)
        places = makers.places(made, soon=True) if made.entries else ()
        return {made.entries[k].name: makers.ufunc(made, k, at) for k, at in enumerate(places)}

    found = or_warn(make) or {}
    names = [one.function.name for one in program.routines]
    others = {} if all(name in found for name in names) else dict(zip(names, plain(program), strict=True))
    return {name: found.get(name) or others[name] for name in names}
