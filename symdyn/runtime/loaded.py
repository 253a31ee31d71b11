"""A scene's functions, ready to call: `symdyn.load("arm.toml").inverse_dynamics(q, qd, qdd)`, and `lambdify`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NoReturn, overload

from symdyn.arguments import checked
from symdyn.dynamics import Equations, Function, LoopChoices, Requested, Workspace, called, request_of, row_of
from symdyn.emit import TARGETS, C, emit
from symdyn.errors import ArgumentError, EmitError, SceneError, UnknownNameError, choice, nearest, quoted, suggestion
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import growing
from symdyn.program import Program, formulate, identifier, lower, prepare as prepare_program
from symdyn.runtime.numeric_function import Later, Makers, NumericFunction, numeric_function, plain, soon
from symdyn.runtime.runners import RUNNERS, or_warn, run_or_python
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.shown import Shown

MOST_SHOWN = 4
"""Functions that a terminal shows."""


@dataclass(frozen=True)
class Loaded(Shown):
    """The functions of a scene; each is an attribute, and `loaded["pose:tool"]` is `loaded.pose_tool`.

    It pickles: the other process loads the same functions, from its cache or by compiling them.

    Attributes:
        scene: the mechanism, its parameters bound.
        requests: what was asked for, such as "pose:tool".
        calls: the functions by name. Each takes arrays (n,) or (..., n) whose leading dimensions broadcast, by place or
            by name, and `out=`.
        signatures: how each is called, such as "mass_matrix(q, params) -> M: (2),(5)->(2,2)".
        compiled: whether they are NumPy ufuncs in C; else they are functions of the generated NumPy module.
        compiler, machine: as they were asked for.
        closing: what was chosen about closed loops.
        free: values of parameters that stay arguments, which are taken where a call gives none.
        prepared: whether `prepare(params)` is among them, and all others take its result in place of `params`.
        backend: whose arrays they take.
        again: a function and its arguments, which make all of it in another process; None for NumPy's.
        accuracy: what was asked for of many states; "" for that of the type.
    """

    scene: Scene
    requests: tuple[str, ...]
    calls: Mapping[str, NumericFunction]
    signatures: Mapping[str, str]
    compiled: bool
    compiler: str | None = None
    machine: str = "native"
    prepared: bool = False
    closing: LoopChoices = LoopChoices()
    free: Mapping[str, float] = field(default_factory=dict)
    backend: str = "NumPy"
    again: tuple[Callable[..., Loaded], tuple[Any, ...]] | None = None
    accuracy: str = ""

    def __post_init__(self) -> None:
        """Make every function an attribute, found without a detour."""
        self.__dict__.update(self.calls)

    def __getattr__(self, name: str) -> NumericFunction:
        """Return the function that was asked for as `name`; AttributeError if it is none of the functions."""
        found = self._found(name) if "requests" in self.__dict__ and not name.startswith("_") else None
        if found is None:
            raise AttributeError(self._missing(name))
        return found

    def __getitem__(self, request: str) -> NumericFunction:
        """Return the function that was asked for as `request`, or that has this name.

        Raises:
            UnknownNameError: there is none; with the names of those that are there.
        """
        found = self._found(request)
        if found is None:
            raise UnknownNameError(self._missing(request))
        return found

    def __call__(self, *values: object, **named: object) -> NoReturn:
        one = next(iter(self.calls))
        raise ArgumentError(f"load returns functions by name, which take the values: load(...).{one}(...)")

    def __contains__(self, request: object) -> bool:
        """Tell whether a function is there, by what it was asked for as or by its name."""
        return self._found(request) is not None

    def __iter__(self) -> Iterator[str]:
        return iter(self.calls)

    def _found(self, request: object) -> NumericFunction | None:
        if not isinstance(request, str):
            return None
        names = dict(zip(self.requests, list(self.calls)[-len(self.requests) :], strict=False))
        return self.calls.get(names.get(request, identifier(request)))

    def _missing(self, name: object) -> str:
        known = ", ".join(self.__dict__.get("calls", ()))
        near = nearest(name, self.__dict__.get("calls", ()))
        meant = f"did you mean {near}?" if near else "load(…, functions=…) takes others, such as pose:BODY"
        return f"there is no function {quoted(name)}; there are {known}; {meant}"

    def __repr__(self) -> str:
        kind = self.backend if not self.compiled or self.backend != "NumPy" else "compiled"
        lines = [f"\n    {signature}" for signature in self.signatures.values()]
        more = [f"\n    ... ({len(lines)} in all)"] if len(lines) > MOST_SHOWN else []
        return f"<{self.scene.name}, {kind}:{''.join([*lines[:MOST_SHOWN], *more])}>"

    def __dir__(self) -> list[str]:
        return [*self.calls, "calls", "compiled", "scene", "signatures"]

    def __reduce__(self) -> tuple[Callable[..., Loaded], tuple[Any, ...]]:
        settings = (self.compiler, self.machine, self.prepared, self.closing, self.free, self.accuracy)
        return self.again or (loaded, (self.scene, self.requests, *settings))


def names_of(word: str, given: object) -> tuple[str, ...]:
    """Return one name or several as a tuple; SceneError where it is neither."""
    names = (given,) if isinstance(given, str) else tuple(given) if isinstance(given, Iterable) else (given,)
    strange = [name for name in names if not isinstance(name, str)]
    if strange:
        raise SceneError(f"{word}: {quoted(strange[0])} is no name; give text, or a list of texts")
    return names


def values_of(scene: Scene, free: Sequence[str]) -> dict[str, float]:
    """Return the scene's values of parameters that stay arguments; one without a value is an argument anyway."""
    known = {p.name: p.value for p in scene.parameters}
    strange = [name for name in free if name not in known]
    told = {name: f'"{name}" is not a parameter; {suggestion(name, known)}' for name in strange}
    faults = [f"free: {scene.derived_words(name) or told[name]}" for name in strange]
    if faults:
        raise SceneError(faults)
    numbers = {name: value.at({}) for name in free if (value := known[name]) is not None}
    return {name: float(number) for name, number in numbers.items() if number is not None}


def loaded(
    scene: Scene,
    requests: tuple[str, ...] | None,
    compiler: str | None,
    machine: str,
    prepare: bool,
    closing: LoopChoices,
    free: Mapping[str, float],
    accuracy: str = "",
) -> Loaded:
    """Return the functions of a scene whose parameters are as they shall be; `free` are values that a call may omit.

    None as `requests` stands for those that `load` takes unasked.
    """
    workspace = Workspace(scene, closing)
    requests = usual(workspace) if requests is None else requests
    makers = or_warn(lambda: Makers(compiler, machine), compiler)
    heads = _heads(workspace, requests) if makers and not prepare else None
    if makers and heads:
        prepared, makes = False, [partial(_program, workspace, one) for one in heads]
    else:
        program = lower(formulate(scene, requests, closing=closing, lines=not C.loops))
        program = prepare_program(program) if prepare else program
        prepared, heads = program.is_prepared, tuple(one.function for one in program.routines)
        makes = [partial(replace, program, routines=(one,)) for one in program.routines]
    found: Sequence[Callable[..., Any]] = [Later(makers, one, accuracy) for one in makes] if makers else plain(program)
    settings = (scene, requests, compiler, machine, prepared, closing, free, accuracy)
    calls = {}
    for call, head in zip(found, heads, strict=True):
        one = numeric_function(scene, head.name, head, call, free, (one_of, (loaded, settings, head.name)))
        if isinstance(call, Later) and one.flags:  # looked at in Python, so that the docstring cannot wait for `help`
            one.__dict__["__doc__"] = call.doc()
        direct = isinstance(call, Later) and not one.flags
        calls[head.name] = makers.module.named(one, call) if makers and direct else one
    told = {name: call.description for name, call in calls.items()}
    made = Loaded(scene, requests, calls, told, makers is not None, compiler, machine, prepared, closing, free)
    return replace(made, accuracy=accuracy)


@growing()
def _heads(workspace: Workspace, requests: Sequence[str]) -> tuple[Function, ...] | None:
    """Return how functions are called, underived; None where only their derivations tell."""
    found = [called(workspace, one) for one in requests]
    return None if None in found else tuple(one for one in found if one)


def _program(workspace: Workspace, head: Function) -> Program:
    """Return the program of a function; one that is a loop over a table is there already, unless it may not exist."""
    scene, loop = workspace.scene, head.loop if head.is_loop_alone else None
    if loop and not loop.may_fail(scene):
        return lower(Equations(scene, workspace.graph, (head,), workspace.closing))
    return lower(formulate(scene, (head.request,), closing=workspace.closing, lines=not C.loops))


def one_of(again: Callable[..., Loaded], settings: tuple[Any, ...], name: str) -> NumericFunction:
    """Return one of the functions, in a process that has none of them yet."""
    return again(*settings).calls[name]


def usual(workspace: Workspace) -> tuple[str, ...]:
    """Return the functions that `load` takes unasked; what may be lacking is then derived in the workspace."""
    outputs, _ = Requested.of(workspace).available()
    return tuple(name for name in outputs if not row_of(name)[0].is_large)


def load_program(program: Program) -> Mapping[str, Callable[..., Any]]:
    """Return the functions of a program by name, of doubles, compiled in a tenth of the time that `load` takes."""
    return soon(program)


@overload
def lambdify(
    scene: SceneLike, name: str, target: str = "numpy", real: str = "double", closing: LoopChoices = ...
) -> NumericFunction: ...
@overload
def lambdify(
    scene: SceneLike, name: tuple[str, ...], target: str = "numpy", real: str = "double", closing: LoopChoices = ...
) -> tuple[NumericFunction, ...]: ...
@checked(ArgumentError)
def lambdify(
    scene: SceneLike,
    name: str | tuple[str, ...],
    target: str = "numpy",
    real: str = "double",
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> NumericFunction | tuple[NumericFunction, ...]:
    """Return one of the scene's functions, or several, as callables of arrays (n,) or (..., n).

    >>> import symdyn
    >>> mass_matrix = symdyn.lambdify(symdyn.example("two_link"), "mass_matrix")
    >>> mass_matrix
    <mass_matrix(q, params) -> M: (2),(5)->(2,2)>
    >>> mass_matrix([[0, 0], [0, 1]], m1=1, m2=2, h1=1, h2=1, g=9.81).round(4).tolist()
    [[[9.0, 4.0], [4.0, 2.0]], [[7.1612, 3.0806], [3.0806, 2.0]]]

    Args:
        scene: the mechanism.
        name: a function such as "inverse_dynamics" or "pose:tool", or a tuple of them, which gives a tuple.
        target: a key of `RUNNERS` that takes batches, such as "c", which is compiled; where what it takes is missing,
            the functions are those of the NumPy module, and a warning says so, once.
        real: "double" or "float".
        closing: what to choose about closed loops, see `symdyn.dynamics.LoopChoices`.

    Raises:
        DerivationError: there is no such function.
        EmitError: a target that is unknown or takes no batches, a real type that it does not have.
        BuildError: the compiler that $CC names is not there or fails.
    """
    runners = {name: runner for name, runner in RUNNERS.items() if runner.batches}
    if target not in runners:
        told = "symdyn.load(scene, backend=...) has it" if target in ("jax", "torch") else choice(target, runners)
        raise EmitError(f"target {target!r} is not known; {told}")
    known = scene_of(scene)
    wanted = tuple(request_of(one, known) for one in names_of("name", name))
    lines = not TARGETS[target].loops
    program = lower(formulate(known, tuple(dict.fromkeys(wanted)), closing=closing, lines=lines))
    sources = emit(program, target, real, option=runners[target].many)
    found = run_or_python(sources, runners[target].run)[0].values()
    names, settings = tuple(dict.fromkeys(wanted)), (target, real, closing)
    made = {}
    for one, routine, call in zip(names, program.routines, found, strict=True):
        again = _one_made, (known, one, names, *settings)
        made[one] = numeric_function(known, routine.function.name, routine.function, call, {}, again)
    return made[wanted[0]] if isinstance(name, str) else tuple(made[one] for one in wanted)


def _one_made(scene: Scene, name: str, names: tuple[str, ...], *settings: Any) -> NumericFunction:
    """Return one of the functions of `lambdify`, in a process that has none of them yet."""
    return lambdify(scene, names, *settings)[names.index(name)]
