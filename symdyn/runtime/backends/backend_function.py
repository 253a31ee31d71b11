"""A function of a scene over another library's arrays: names, defaults and faults as those for NumPy have them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from symdyn.dynamics import LoopChoices, Workspace
from symdyn.emit import C, render
from symdyn.emit.code import REALS
from symdyn.program import Program, formulate, lower, prepare as prepare_program
from symdyn.runtime.backends.words import VALUE, Code, Word
from symdyn.runtime.loaded import Loaded, usual
from symdyn.runtime.numeric_function import NumericFunction, numeric_function, signature
from symdyn.scene import Scene


@dataclass(frozen=True)
class Library:
    """What a backend does with words.

    Attributes:
        title: what people call it.
        real: the type that is made ready at once.
        make: returns what it calls, of a program and a real type ("double", "float"), and of the columns of each
            argument where the program returns J.
        call: returns what a word computes of arguments given by place: ValueError where they do not fit.
        stack: returns entries as one array, along its last dimension.
    """

    title: str
    real: str
    make: Callable[[Program, str, tuple[int, ...]], Any]
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
    backend: str,
    library: Library,
    scene: Scene,
    requests: tuple[str, ...] | None,
    compiler: str | None,
    machine: str,
    prepare: bool,
    closing: LoopChoices,
    free: Mapping[str, float],
    again: Callable[..., Loaded],
) -> Loaded:
    """Return the functions of a scene for one backend; `again` makes them in another process."""
    requests = usual(Workspace(scene, closing)) if requests is None else requests
    program = lower(formulate(scene, requests, closing=closing))
    program = prepare_program(program) if prepare else program
    settings = (backend, scene, requests, compiler, machine, program.is_prepared, closing, free)
    code = Code(program, library.make)
    code.ready(library.real)
    told = _docstrings(program)
    asked = [Program.PREPARE] * (len(program.routines) - len(requests)) + list(requests)
    calls = {}
    for place, (routine, request) in enumerate(zip(program.routines, asked, strict=True)):
        name = routine.function.name
        source = None if request == Program.PREPARE else (scene, request, closing)
        call = partial(library.call, Word(VALUE, None, code, place, source))
        call.__doc__ = told[name]
        one = numeric_function(scene, name, routine.function, call, free, (_one_of, (again, settings, name)))
        fields = {key: getattr(one, key) for key in NumericFunction.__dataclass_fields__ if key != "words"}
        calls[name] = BackendFunction(**fields, stack=library.stack)
    functions = [one.function for one in program.routines]
    signatures = {one.name: signature(one.name, one) for one in functions}
    return Loaded(
        scene, requests, calls, signatures, True, compiler, machine, program.is_prepared, closing, free,
        library.title, (again, settings),
    )  # fmt: skip


def _one_of(again: Callable[..., Loaded], settings: tuple[Any, ...], name: str) -> NumericFunction:
    """Return one of the functions, in a process that has none of them yet."""
    return again(*settings).calls[name]


def _docstrings(program: Program) -> dict[str, str]:
    """Return what `help` says about every function of a program, by its name, where it is no ufunc."""
    page = C.draft(program, REALS["double"], "").page
    names = (routine.function.name for routine in program.routines)
    texts = (render("ufunc/doc.txt.jinja", {"page": page, "function": one, "ufunc": False}) for one in page.functions)
    return {name: text.strip("\n") for name, text in zip(names, texts, strict=True)}
