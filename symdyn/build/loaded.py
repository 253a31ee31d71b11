"""A scene's functions, ready to call: `symdyn.load("arm.toml").inverse_dynamics(q, qd, qdd)`, and `lambdify`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, overload

from symdyn.build.extension import build_extension
from symdyn.build.runners import RUNNERS, Call, run_or_python
from symdyn.dynamics import LoopChoices, Unasked, available, row_of
from symdyn.emit import emit
from symdyn.emit.code.python import NUMPY
from symdyn.emit.code.ufunc import LEAN, UFUNC
from symdyn.errors import EmitError
from symdyn.program import Program, Routine, formulate, identifier, lower
from symdyn.program import prepare as prepare_program
from symdyn.program.prepare import is_prepared
from symdyn.scene import Scene, SceneLike, bind, scene_of
from symdyn.shown import Shown


@dataclass(frozen=True)
class Loaded(Shown):
    """The functions of a scene; each is an attribute, and `loaded["pose:tool"]` is `loaded.pose_tool`.

    It pickles: the other process loads the same functions, from its cache or by compiling them.

    Attributes:
        scene: the mechanism, its parameters bound.
        requests: what was asked for, such as "pose:tool".
        calls: the callables by name. Each takes arrays (n,) or (..., n) whose leading dimensions broadcast, and `out=`.
        signatures: how each is called, such as "mass_matrix(q, params) -> M: (2),(5)->(2,2)".
        compiled: whether they are NumPy ufuncs in C; else they are functions of the generated NumPy module.
        compiler, machine: as they were asked for.
        closing: what was chosen about closed loops.
        prepared: whether `prepare(params)` is among them, and all others take its result in place of `params`.
    """

    scene: Scene
    requests: tuple[str, ...]
    calls: Mapping[str, Callable[..., Any]]
    signatures: Mapping[str, str]
    compiled: bool
    compiler: str | None = None
    machine: str = "native"
    prepared: bool = False
    closing: LoopChoices = LoopChoices()  # noqa: RUF009  frozen

    def __post_init__(self) -> None:
        """Make every function an attribute, found without a detour."""
        self.__dict__.update(self.calls)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Raise AttributeError: `name` is none of the functions."""
        raise AttributeError(self._missing(name))

    def __getitem__(self, request: str) -> Callable[..., Any]:
        """Return the function that was asked for as `request`, or that has this name.

        Raises:
            KeyError: there is none; with the names of those that are there.
        """
        names = dict(zip(self.requests, list(self.calls)[-len(self.requests) :], strict=False))
        found = self.calls.get(names.get(request, identifier(request)))
        if found is None:
            raise KeyError(self._missing(request))
        return found

    def _missing(self, name: str) -> str:
        known = ", ".join(self.__dict__.get("calls", ()))
        return f"there is no function {name!r}; there are {known}; load(…, functions=…) takes others"

    def __repr__(self) -> str:
        kind = "compiled" if self.compiled else "NumPy"
        lines = "".join(f"\n    {signature}" for signature in self.signatures.values())
        return f"<{self.scene.name}, {kind}:{lines}>"

    def __reduce__(self) -> tuple[Callable[..., Loaded], tuple[Scene, tuple[str, ...]]]:
        again = partial(load, compiler=self.compiler, machine=self.machine, prepare=self.prepared, closing=self.closing)
        return again, (self.scene, self.requests)


def load(
    scene: SceneLike,
    functions: str | Sequence[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    compiler: str | None = None,
    machine: str = "native",
    prepare: bool = False,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> Loaded:
    """Return the functions of a scene, compiled into a Python extension that is kept in the cache.

    Where there is no compiler, or no header of Python, they are those of the generated NumPy module: slower, in float64
    alone, otherwise the same. A warning says so, once.

    Args:
        scene: a scene, or a file that `symdyn.read` understands.
        functions: one such as "inverse_dynamics" or "pose:tool", or several; None takes the dynamics and the
            kinematics of the declared points, but not the Coriolis matrix and the coefficients k_z, k_C and so on,
            which are large.
        parameters: values for free parameters, as numbers or formulas; the others are the last operand, `params`.
        compiler: as for `symdyn.build.build`.
        machine: likewise.
        closing: what to choose about closed loops.
        prepare: whether to take work on parameters alone out of the calls: `prepared = arm.prepare(params)`, once, is
            then the last operand of all other functions. Without free parameters there is nothing to prepare.

    Raises:
        SceneError: the file has faults, or a parameter does not exist.
        DerivationError: a function does not exist.
        BuildError: the compiler that was asked for, here or as $CC, is not there; a compiler refuses; an unknown
            machine.
    """
    known = scene_of(scene)
    known = bind(known, parameters) if parameters else known
    names = (functions,) if isinstance(functions, str) else functions
    requests = tuple(dict.fromkeys(usual(known, closing) if names is None else names))
    program = lower(formulate(known, requests, closing=closing))
    program = prepare_program(program) if prepare else program
    calls, compiled = load_program(program, compiler, machine)
    signatures = {name: _signature(name, routine) for name, routine in zip(calls, program.routines, strict=True)}
    return Loaded(known, requests, calls, signatures, compiled, compiler, machine, is_prepared(program), closing)


def usual(
    scene: Scene,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> tuple[str, ...]:
    """Return the functions that `load` takes unasked."""
    outputs, _ = available(scene, closing)
    return tuple(name for name in outputs if not is_large(name))


def is_large(request: str) -> bool:
    """Tell whether an output is one of those that are written, and loaded only when they are asked for."""
    return row_of(request)[0].unasked is Unasked.WRITTEN


def load_program(
    program: Program, compiler: str | None = None, machine: str = "native", lean: bool = False
) -> tuple[dict[str, Callable[..., Any]], bool]:
    """Return the functions of a program by name, and whether they are compiled; see `load`, and for `lean` `UFUNC`."""
    sources = emit(program, UFUNC.name, option=LEAN if lean else "")
    return run_or_python(sources, lambda given: build_extension(given, compiler, machine=machine)[1])


def _signature(name: str, routine: Routine) -> str:
    """Return how a function is called, and the lengths of its operands."""
    function = routine.function
    names = ", ".join(argument.name for argument in function.arguments)
    lengths = ",".join(f"({','.join(map(str, argument.shape))})" for argument in function.arguments)
    shape = ",".join(map(str, function.shape))
    return f"{name}({names}) -> {function.result}: {lengths}->({shape})"


@overload
def lambdify(
    scene: SceneLike, name: str, target: str = NUMPY.name, real: str = "double", closing: LoopChoices = ...
) -> Call: ...
@overload
def lambdify(
    scene: SceneLike, name: tuple[str, ...], target: str = NUMPY.name, real: str = "double", closing: LoopChoices = ...
) -> tuple[Call, ...]: ...
def lambdify(
    scene: SceneLike,
    name: str | tuple[str, ...],
    target: str = NUMPY.name,
    real: str = "double",
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> Call | tuple[Call, ...]:
    """Return one of the scene's functions, or several, as callables of arrays (n,) or (..., n).

    Args:
        scene: the mechanism.
        name: a function such as "inverse_dynamics" or "pose:tool", or a tuple of them, which gives a tuple.
        target: a key of `RUNNERS` that takes batches, such as "c", which is compiled; where what it takes is missing,
            the functions are those of the NumPy module, and a warning says so, once.
        real: "double" or "float".
        closing: what to choose about closed loops.

    Raises:
        DerivationError: there is no such function.
        EmitError: a target that is unknown or takes no batches, a real type that it does not have.
        BuildError: a compiler that refuses, or that $CC names and is not there.
    """
    runners = {name: runner for name, runner in RUNNERS.items() if runner.batches}
    if target not in runners:
        raise EmitError(f"target {target!r} is not known; give {' or '.join(runners)}")
    wanted = (name,) if isinstance(name, str) else tuple(name)
    program = lower(formulate(scene_of(scene), tuple(dict.fromkeys(wanted)), closing=closing))
    sources = emit(program, target, real, option=runners[target].many)
    calls = dict(zip(dict.fromkeys(wanted), run_or_python(sources, runners[target].run)[0].values(), strict=True))
    return calls[name] if isinstance(name, str) else tuple(calls[one] for one in wanted)
