"""A function and its derivatives as functions of their own: what a backend calls where it differentiates.

    f(x)                    m entries of arguments x, one after another
    ALONG   J d             for a direction d of each argument that moves
    BACK    wᵀ J            for weights w of the entries; a number has none
    ALL     J               all columns
    BENT    H(w) d          H the second derivatives of wᵀ f

They are derived when they are first called. There are two ways to them. `stated` goes by the scene's own words
(`inverse_dynamics_jvp`), which are cheap and proved; its arguments are those that velocities move, in trees whose
velocities are rates of coordinates. `plain` differentiates what the code computes by all of its arguments, entry by
entry: free parameters, inputs, time, parts of quaternions, all coordinates of a closed scene.

Over another library's arrays names, defaults and faults are as those for NumPy have them.

On a card kernels compute them: the files of the GPU target and what hosts call of them, compiled by nvcc, and kept. A
kernel takes columns, entry i of all states together, and gives columns; all states have one set of parameters. What
differs by library of arrays is how columns come to it. Tests compile all this with nvcc, and run it as C++ over arrays
on the CPU. It has not been run on a card.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import prod
from pathlib import Path
from threading import RLock
from typing import Any, ClassVar

from symdyn.dynamics import Argument, Equations, Function, LoopChoices, Workspace, row_of
from symdyn.dynamics.outputs import differentiable
from symdyn.emit import TARGETS, C, Entries, Sources, emit, render
from symdyn.emit.code import REALS
from symdyn.errors import ArgumentError, DerivationError
from symdyn.frozen import dataclass, field, fields, replace
from symdyn.graph import Expr, gradient, tangents
from symdyn.program import Program, Routine, formulate, lower, prepare as prepare_program
from symdyn.runtime.compiler import CUDA, NOTHING, find_compiler
from symdyn.runtime.library import SUFFIX, LibraryKind, load_library
from symdyn.runtime.loaded import Loaded, one_of, usual
from symdyn.runtime.numeric_function import NumericFunction, numeric_function, signature
from symdyn.scene import Scene
from symdyn.unlocked import cached_property

GPU = TARGETS["gpu"]

Files = Mapping[str, str]

PLAIN = LibraryKind(SUFFIX, NOTHING, ("cuda",), ctypes.CDLL)


@dataclass(frozen=True)
class Kernels:
    """What makes what a library of arrays calls of a program's kernels, for one architecture; equal ones make it once.

    Attributes:
        machine: the architecture, as the compiler calls it.
        build: returns the library of files for an architecture, and its path.
        write: returns files and what is called there, of sources of target "gpu".
        open: returns what is called, of sources, these entries, and the library and its path.
    """

    machine: str
    build: Callable[[Files, str], tuple[Path, ctypes.CDLL]]
    write: Callable[[Sources], Entries]
    open: Callable[[Sources, Entries, Path, ctypes.CDLL], Any]

    def __call__(self, program: Program, real: str, _: tuple[int, ...]) -> Any:
        """Return what is called of a program's kernels in one real type."""
        sources = emit(program, GPU.name, real)
        entries = self.write(sources)
        return self.open(sources, entries, *self.build(entries.files, self.machine))


def compiled(files: Files, machine: str, kind: LibraryKind = PLAIN) -> tuple[Path, ctypes.CDLL]:
    """Return the library that nvcc makes for an architecture, kept as all that compilers make, and its path.

    Raises:
        BuildError: nvcc is not there, or refuses.
    """
    path, library = load_library(files, replace(find_compiler(language=CUDA), machine=(f"-arch={machine}",)), kind=kind)
    return path, library


def architecture(capability: Sequence[int]) -> str:
    """Return what nvcc calls cards of a compute capability.

    >>> architecture((9, 0))
    'sm_90'
    """
    return "sm_{}{}".format(*capability)


def several(function: str, place: Any, name: str, count: int) -> ArgumentError:
    """Return what is said where states on a card have sets of parameters of their own."""
    return ArgumentError(
        f"{function}: on {place} one {name} is for all states, and there are {count}; "
        "call it once for each, or on the CPU"
    )


VALUE, ALONG, BACK, ALL, BENT = "", "_jvp", "_vjp", "_derivatives", "_hessian_vector"

LOCK = RLock()
"""One derivation at a time: what two threads ask for at once is derived once."""


@dataclass(frozen=True, eq=False)
class Code:
    """A program, and what is made of it: by real type and by whom, once, when it is first called.

    `columns` are those of each argument where it returns J, () of all else.
    """

    program: Program
    make: Callable[[Program, str, tuple[int, ...]], Any]
    columns: tuple[int, ...] = ()
    made: dict[Any, Any] = field(default_factory=dict)

    def ready(self, real: str, make: Callable[[Program, str, tuple[int, ...]], Any] | None = None) -> Any:
        """Return what the backend calls, for one real type; `make` makes it where it is not the backend's own."""
        with LOCK:
            if (real, make) not in self.made:
                self.made[real, make] = (make or self.make)(self.program, real, self.columns)
            return self.made[real, make]


@dataclass(frozen=True, eq=False)
class Word:
    """One function that can be called: a function of the scene, or one of its derivatives.

    Attributes:
        kind: VALUE, ALONG, BACK, ALL or BENT.
        way: how it belongs to its function; None where it is that function.
        code: the program that it is in.
        place: which of its routines it is.
        source: the scene and what was asked for, where the scene's own words tell its derivatives.
    """

    kind: str
    way: DerivativeRule | None
    code: Code
    place: int = 0
    source: tuple[Scene, str, LoopChoices] | None = None

    @property
    def routine(self) -> Routine:
        return self.code.program.routines[self.place]

    @cached_property
    def arguments(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """(name, shape) in calling order."""
        return tuple((one.name, one.shape) for one in self.routine.function.arguments)

    @cached_property
    def names(self) -> tuple[str, ...]:
        return tuple(name for name, _ in self.arguments)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        return self.routine.function.shape

    @cached_property
    def directions(self) -> dict[str, str]:
        """What the direction of each argument is called, a name that nothing has: "dq" of "q"."""
        found: dict[str, str] = {}
        for name in self.names:
            found[name] = f"d{name}"
            while found[name] in (*self.names, *(one for other, one in found.items() if other != name)):
                found[name] = f"d{found[name]}"
        return found

    @cached_property
    def plain(self) -> DerivativeRule:
        """Its derivatives by all arguments, those that are no numbers left out."""
        return DerivativeRule(
            self, tuple((name, prod(shape)) for name, shape in self.arguments), partial(_derived, self)
        )

    @cached_property
    def stated(self) -> DerivativeRule | None:
        """Its derivatives as the scene's own words; None where it has none that say the same."""
        if self.source is None or Program.PREPARED in self.names:
            return None
        scene, request, closing = self.source
        try:
            row = row_of(f"{_behind(request, ALONG)}", scene)[0]
            along = differentiable(row)
        except DerivationError:
            return None
        lengths = dict(self.arguments)
        if scene.is_constrained or not lengths.keys() >= set(along) or ("q" in along and not _are_rates(scene)):
            return None
        varied = tuple((name, prod(lengths[name])) for name in along)
        return DerivativeRule(
            self, varied, lambda kind: lower(formulate(scene, (_behind(request, kind),), closing=closing))
        )

    def way_for(self, moving: Sequence[str]) -> DerivativeRule:
        """Return the way to derivatives along these arguments."""
        stated = self.stated
        return stated if stated is not None and set(moving) <= {name for name, _ in stated.varied} else self.plain


@dataclass(frozen=True, eq=False)
class DerivativeRule:
    """One way to the derivatives of a function."""

    of: Word  # the function
    varied: tuple[tuple[str, int], ...]  # name and length of the arguments that move, in the order of the columns of J
    derive: Callable[[str], Program]  # returns the program of a derivative by its kind
    known: dict[str, Word] = field(default_factory=dict)

    def word(self, kind: str) -> Word:
        """Return one of the derivatives, derived when it is first asked for."""
        with LOCK:
            if kind not in self.known:
                columns = tuple(length for _, length in self.varied) if kind == ALL else ()
                self.known[kind] = Word(kind, self, Code(self.derive(kind), self.of.code.make, columns))
            return self.known[kind]

    @property
    def varied_names(self) -> tuple[str, ...]:
        return tuple(name for name, _ in self.varied)

    @property
    def columns(self) -> int:
        """How many columns J has."""
        return sum(length for _, length in self.varied)

    def direction(self, name: str) -> str:
        """Return what the direction of an argument is called."""
        return self.of.directions[name]


def weights_of(of: Word) -> str:
    """Return what the weights of a function's entries are called, "" where it is a number and has none."""
    if not of.shape:
        return ""
    found = "weights"
    while found in of.names:
        found = f"{found}_"
    return found


def _behind(request: str, kind: str) -> str:
    name, colon, place = request.partition(":")
    return f"{name}{kind}{colon}{place}"


def _are_rates(scene: Scene) -> bool:
    """Tell whether velocities are the rates of the coordinates, each of its own."""
    state = Workspace(scene).state
    return tuple(state.rates) == tuple(state.qd)


def _derived(of: Word, kind: str) -> Program:
    """Return a program of a derivative by differentiation of what the code computes."""
    program, function = of.code.program, of.routine.function
    graph = program.graph
    moving = [x for one in function.arguments for x in one.symbols]
    directions = [_along(of, one) for one in function.arguments]
    seeds = dict(zip(moving, (x for one in directions for x in one.symbols), strict=True))
    entries: Sequence[Expr] = function.entries
    named = weights_of(of)
    weights = [graph.symbol(f"{named}[{k}]") for k in range(len(entries))] if named else [graph.one]
    weighed = [Argument(named, tuple(weights), "weights of the entries", ())] if named else []
    slopes = partial(gradient, graph.dot(weights, entries), moving)
    size = len(moving)
    if kind == ALONG:
        found, more, shape = tangents(entries, seeds), directions, function.shape
    elif kind == BACK:
        found, more, shape = slopes(), weighed, (size,)
    elif kind == ALL:
        found, more = [x for one in entries for x in gradient(one, moving)], []
        shape = (len(entries), size) if function.shape else (size,)
    else:
        found, more, shape = tangents(slopes(), seeds), [*weighed, *directions], (size,)
    own = [one for one in function.arguments if one.name not in ("params", Program.PREPARED)]
    last = [one for one in function.arguments if one.name in ("params", Program.PREPARED)]
    made = Function(
        name=f"{function.name}{kind}",
        text=f"derivatives of the {function.text}",
        arguments=(*own, *more, *last),
        result="slopes",
        shape=shape,
        entries=tuple(found),
        units="",
        formulation="differentiated",
    )
    return lower(Equations(program.scene, graph, (made,)))


def _along(of: Word, argument: Argument) -> Argument:
    name = of.directions[argument.name]
    graph = of.code.program.graph
    symbols = tuple(graph.symbol(f"{name}[{k}]") for k in range(len(argument.symbols)))
    return Argument(name, symbols, f"direction of {argument.name}", (), argument.scalar)


@dataclass(frozen=True)
class Library:
    """What a backend does with words.

    Attributes:
        title: what people call it.
        real: returns the type that is made ready at once.
        make: returns what it calls, of a program and a real type ("double", "float"), and of the columns of each
            argument where the program returns J; by a `compiler` for a `machine`.
        call: returns what a word computes of arguments given by place: ValueError where they do not fit.
        stack: returns entries as one array, along its last dimension.
    """

    title: str
    real: Callable[[], str]
    make: Callable[..., Any]
    call: Callable[..., Any]
    stack: Callable[[Sequence[Any]], Any]


@dataclass(frozen=True, eq=False, repr=False)
class BackendFunction(NumericFunction):
    """A function of another library's arrays (n,) or (..., n); see `NumericFunction`."""

    stack: Callable[[Sequence[Any]], Any] = list
    words: ClassVar[frozenset[str]] = frozenset()

    def _stack(self, values: Sequence[Any]) -> Any:
        return self.stack(values)

    def _shape(self, value: Any) -> tuple[int, ...] | None:
        shape = getattr(value, "shape", None)
        return super()._shape(value) if shape is None else tuple(shape)


def is_weak(value: Any) -> bool:
    """Tell whether a value is a number of Python, or a list of such: it takes the type of the arrays beside it."""
    if isinstance(value, (list, tuple)):
        return all(is_weak(one) for one in value)
    return isinstance(value, (bool, int, float))


def loaded_for(
    library: Library,
    again: Callable[..., Loaded],
    backend: str,
    scene: Scene,
    requests: tuple[str, ...] | None,
    compiler: str | None,
    machine: str,
    prepare: bool,
    closing: LoopChoices,
    free: Mapping[str, float],
) -> Loaded:
    """Return the functions of a scene for one backend, as `symdyn.load` does; `again` makes them in another process."""
    requests = usual(Workspace(scene, closing)) if requests is None else requests
    program = lower(formulate(scene, requests, closing=closing))
    program = prepare_program(program) if prepare else program
    settings = (backend, scene, requests, compiler, machine, program.is_prepared, closing, free)
    code = Code(program, partial(library.make, compiler=compiler, machine=machine))
    code.ready(library.real())
    page = C.draft(program, REALS["double"], "").page
    names = (routine.function.name for routine in program.routines)
    texts = (render("ufunc/doc.txt.jinja", {"page": page, "function": one, "ufunc": False}) for one in page.functions)
    told = {name: text.strip("\n") for name, text in zip(names, texts, strict=True)}
    asked = [Program.PREPARE] * (len(program.routines) - len(requests)) + list(requests)
    calls = {}
    for place, (routine, request) in enumerate(zip(program.routines, asked, strict=True)):
        name = routine.function.name
        source = None if request == Program.PREPARE else (scene, request, closing)
        call = partial(library.call, Word(VALUE, None, code, place, source))
        call.__doc__ = told[name]
        one = numeric_function(scene, name, routine.function, call, free, (one_of, (again, settings, name)))
        given = {key.name: getattr(one, key.name) for key in fields(NumericFunction)}
        calls[name] = BackendFunction(**given, stack=library.stack)
    functions = [one.function for one in program.routines]
    signatures = {one.name: signature(one.name, one) for one in functions}
    return Loaded(
        scene, requests, calls, signatures, True, compiler, machine, program.is_prepared, closing, free,
        library.title, (again, settings),
    )  # fmt: skip
