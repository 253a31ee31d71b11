"""A function of a scene, ready to call with arrays: values go by place or by name, and errors name what they are about.

A call by place alone is the compiled function's own. Only a call that it refuses, or that names values, is handled
here.

Functions may be compiled at their first call, each into a library of its own, double and float apart. All use the same
compiler flags, and a function is compiled once: its bits are the same at every call.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from inspect import Parameter, Signature
from types import ModuleType
from typing import Any, ClassVar

import numpy as np

from symdyn.dynamics import Function
from symdyn.dynamics.outputs import POSE
from symdyn.emit import Code, emit
from symdyn.errors import ArgumentError, listed, suggestion
from symdyn.frozen import dataclass, field
from symdyn.program import Program
from symdyn.runtime.cache import Lock
from symdyn.runtime.commands import Needs, threads
from symdyn.runtime.compiler import PATIENCE, find_compiler
from symdyn.runtime.library import SUFFIX, LibraryKind, extension_kind, load_library
from symdyn.runtime.runners import or_warn, run_python
from symdyn.scene import Scene
from symdyn.scene.values import spell
from symdyn.shown import Shown

WORDS = frozenset({"out", "axes", "casting", "dtype", "order", "signature", "subok"})
"""Keywords of NumPy; what has one of these names in a scene is given by place."""

REAL = "biuf"
"""Kinds of NumPy's types that are real numbers."""

TURNS, A_POSE = 1e-6, "[R p], shape (3, 4), or (4, 4) with [0, 0, 0, 1] below, or the 12 numbers of its three rows"
"""By how much entries of R Rᵀ may miss the identity, at most; what a pose is."""

FLAGS = ("mask",)
"""Arguments whose entries are 0 or 1."""

BY_NAME = ("params", "inputs", "internal", "tau")
"""Arguments whose entries a call is likely to name."""


@dataclass(frozen=True)
class Operand:
    """One argument of a function.

    Attributes:
        name: such as "q" or "params".
        entries: names of its entries, such as "m1".
        scalar: whether it is one number, as time is.
    """

    name: str
    entries: tuple[str, ...]
    scalar: bool


@dataclass(frozen=True, eq=False, repr=False)
class NumericFunction(Shown):
    """A function of arrays (n,) or (..., n), whose leading dimensions broadcast.

    `f(q, qd, qdd, params)` goes by place; `f(q, qd, qdd, m1=2, h1=1)` names the entries of what is left out, and
    `f(q, qd, params=x)` whole arguments; drives have their names, as in `f(q, qd, F=1)`. It pickles: the other process
    makes it again.

    Attributes:
        name: such as "mass_matrix".
        call: what computes, by place alone.
        operands: its arguments, in order.
        description: how it is called, such as "mass_matrix(q, params) -> M: (2),(5)->(2,2)".
        usual: values of entries that a call need not give, such as inputs, and zero for joints without a drive.
        fixed: parameters that are numbers in its code, with their values as text.
        again: a function and its arguments, which make it in another process.
    """

    name: str
    call: Callable[..., Any]
    operands: tuple[Operand, ...]
    description: str
    usual: Mapping[str, float] = field(default_factory=dict)
    fixed: Mapping[str, str] = field(default_factory=dict)
    again: tuple[Callable[..., Any], tuple[Any, ...]] | None = None
    words: ClassVar[frozenset[str]] = WORDS
    flags: ClassVar[tuple[int, ...]] = ()

    def __post_init__(self) -> None:
        self.__dict__["flags"] = tuple(k for k, one in enumerate(self.operands) if one.name in FLAGS)
        self.__dict__.update(__name__=self.name, __qualname__=self.name, __doc__=self.call.__doc__)

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Return the result; see the class.

        Raises:
            ArgumentError: a value that is missing, given twice, or nothing that the function takes.
        """
        if len(given) < len(self.operands) or not self.words.issuperset(named):
            values = {key: named.pop(key) for key in list(named) if key not in self.words}
            given = self._completed(given, values)
        if self.flags:
            self._check_flags(given)
        try:
            return self.call(*given, **named)
        except (TypeError, ValueError) as error:
            if (flat := self._row_by_row(given)) is not given:
                return self(*flat, **named)
            faults = self._faults(given)
            if not faults:
                raise
            raise ArgumentError(f"{self.name}: {'; '.join(faults)}") from error

    def __repr__(self) -> str:
        return f"<{self.description}>"

    def __reduce__(self) -> Any:
        if self.again is None:
            raise TypeError(f"{self.name} does not say how to make it again")
        return self.again

    @property
    def __signature__(self) -> Signature:
        takes = [Parameter(one.name, Parameter.POSITIONAL_OR_KEYWORD) for one in self.operands]
        names = [name for one in self.operands if one.name in BY_NAME for name in one.entries if name.isidentifier()]
        taken = {one.name for one in self.operands} | self.words
        kind = Parameter.KEYWORD_ONLY
        free = [Parameter(name, kind, default=self.usual.get(name)) for name in names if name not in taken]
        return Signature([*takes, *free])

    def _completed(self, given: Sequence[Any], named: dict[str, Any]) -> tuple[Any, ...]:
        known = {one.name: value for one, value in zip(self.operands, given, strict=False)}
        faults = []
        for one in self.operands[len(given) :]:
            if one.name in named and not (one.name in one.entries and isinstance(named[one.name], int | float)):
                known[one.name] = named.pop(one.name)
                continue
            taken = {name: named.pop(name) for name in one.entries if name in named}
            missing = [name for name in one.entries if name not in taken and name not in self.usual]
            if missing:
                faults.append(f"{one.name} is missing" + (f": {listed(missing)}" if missing != [one.name] else ""))
            elif one.scalar:
                known[one.name] = (taken or self.usual)[one.entries[0]]
            else:
                try:
                    known[one.name] = self._stack([taken.get(name, self.usual.get(name)) for name in one.entries])
                except (ValueError, RuntimeError) as error:
                    raise ArgumentError(f"values by name do not broadcast: {error}") from error
        faults += [self._strange(name, known) for name in named]
        if faults:
            raise ArgumentError(f"{self.name}: {'; '.join(faults)}; {self.description}")
        return (*(known[one.name] for one in self.operands), *given[len(self.operands) :])

    def _strange(self, name: str, known: Mapping[str, Any]) -> str:
        if name in self.fixed:
            return (
                f'{name} has the value {self.fixed[name]} in the scene and is a number here; load(…, free="{name}") '
                "takes it by name"
            )
        if name in known:
            return f"{name} is given by position and by name"
        for one in self.operands:
            if name in one.entries and one.name in known:
                return f"{name} is given by name and in {one.name}"
        names = [name for one in self.operands if one.name not in known for name in (one.name, *one.entries)]
        return f"there is no {name}" + (f"; {suggestion(name, names)}" if names else "")

    def _check_flags(self, given: Sequence[Any]) -> None:
        """Raise ArgumentError where a number is neither 0 nor 1; numbers that are known later are not looked at."""
        for k in self.flags:
            one, value = self.operands[k], given[k]
            if isinstance(value, (np.ndarray, list, tuple)) and self._shape(value) is not None:
                wrong = (found := np.asarray(value))[(found != 0) & (found != 1)]
                if wrong.size:
                    told = f"give 0 or 1 of each of {listed(one.entries)}"
                    raise ArgumentError(f"{self.name}: {one.name} has {wrong.flat[0]:g}; {told}")

    def _row_by_row(self, given: Sequence[Any]) -> Sequence[Any]:
        """Return the arguments with poses (..., 3, 4) or (..., 4, 4) as their 12 entries; themselves without such."""
        found = list(given)
        for k, one in enumerate(self.operands[: len(found)]):
            shape = self._shape(found[k]) if one.name == POSE else None
            if shape and shape[-2:] in ((3, 4), (4, 4)):
                T, R = np.asarray(found[k]), np.asarray(found[k])[..., :3, :3]
                off = (np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)) > TURNS).any() or (np.linalg.det(R) < 0).any()
                if off or (T[..., 3:, :] != [0, 0, 0, 1]).any():
                    raise ArgumentError(f"{self.name}: {one.name} turns by no rotation; give {A_POSE}, R a rotation")
                found[k] = T[..., :3, :].reshape(*shape[:-2], 12)
        return found if any(a is not b for a, b in zip(found, given, strict=True)) else given

    def _faults(self, given: Sequence[Any]) -> list[str]:
        """Return what is wrong with arguments, as far as it can be told."""
        if len(given) > len(self.operands) + 1:
            return [f"{len(given)} arguments are given; {self.description}"]
        faults, leading = [], {}
        for one, value in zip(self.operands, given, strict=False):
            shape = self._shape(value)
            several = A_POSE if one.name == POSE else f"{len(one.entries)} numbers, {listed(one.entries)}"
            wanted = "one number" if one.scalar else several
            if passive := [name for name in one.entries if name.startswith("tau[")]:
                wanted += f" ({', '.join(passive)}: of what no drive moves, 0)"
            if shape is None:
                faults.append(f"{one.name} is no array of real numbers; give {wanted}")
            elif not one.scalar and shape[-1:] != (len(one.entries),):
                found = f"has {shape[-1]} in its last dimension" if shape else "is one number"
                faults.append(f"{one.name} {found}; give {wanted}")
            else:
                leading[one.name] = shape if one.scalar else shape[:-1]
        try:
            np.broadcast_shapes(*leading.values())
        except ValueError:
            shown = ", ".join(f"{name} {shape}" for name, shape in leading.items())
            faults.append(f"leading dimensions do not broadcast: {shown}")
        return faults

    def _shape(self, value: Any) -> tuple[int, ...] | None:
        """Return the shape of real numbers, None of anything else."""
        try:
            array = np.asarray(value)
        except ValueError:  # rows of several lengths
            return None
        return array.shape if array.dtype.kind in REAL else None

    def _stack(self, values: Sequence[Any]) -> Any:
        return np.stack(np.broadcast_arrays(*values), axis=-1)


def numeric_function(
    scene: Scene,
    name: str,
    function: Function,
    call: Callable[..., Any],
    usual: Mapping[str, float],
    again: tuple[Callable[..., Any], tuple[Any, ...]],
) -> NumericFunction:
    """Return a function that computes as `call`, with the names that a scene gives its arguments' entries."""
    drives = {f"tau[{k}]": drive for k, drive in enumerate(scene.drives) if drive}
    operands = tuple(
        Operand(one.name, tuple(drives.get(str(x.value), str(x.value)) for x in one.symbols), one.scalar)
        for one in function.arguments
    )
    passive = {f"tau[{k}]": 0.0 for k, drive in enumerate(scene.drives) if not drive}
    free = {entry for one in operands for entry in one.entries}
    usual = {**passive, **{one.name: float(one.value.at({}) or 0) for one in scene.inputs}, **usual}
    fixed = {p.name: spell(p.value) for p in scene.parameters if p.value is not None and p.name not in free}
    return NumericFunction(name, call, operands, signature(name, function), usual, fixed, again)


def signature(name: str, function: Function) -> str:
    """Return how a function is called, and the lengths of its operands."""
    names = ", ".join(argument.name for argument in function.arguments)
    lengths = ",".join(f"({','.join(map(str, argument.shape))})" for argument in function.arguments)
    shape = ",".join(map(str, function.shape))
    return f"{name}({names}) -> {function.result}: {lengths}->({shape})"


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
        kind = extension_kind(Code.RUNTIME.name, soon=True)  # it copies states, which others are computed from
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
        """Compile all of it now; BuildError where the compiler that was asked for, in words or as $CC, fails."""
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
