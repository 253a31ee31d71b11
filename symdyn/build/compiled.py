"""A scene's functions without any file in sight."""

from __future__ import annotations

from typing import overload

from symdyn.build.runners import RUNNERS, Call, run_or_python
from symdyn.dynamics import LoopChoices
from symdyn.emit import emit
from symdyn.emit.code.python import NUMPY
from symdyn.errors import EmitError
from symdyn.program import formulate, lower
from symdyn.scene import Scene


@overload
def lambdify(
    scene: Scene, name: str, target: str = NUMPY.name, real: str = "double", closing: LoopChoices = ...
) -> Call: ...
@overload
def lambdify(
    scene: Scene, name: tuple[str, ...], target: str = NUMPY.name, real: str = "double", closing: LoopChoices = ...
) -> tuple[Call, ...]: ...
def lambdify(
    scene: Scene,
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
    program = lower(formulate(scene, tuple(dict.fromkeys(wanted)), closing=closing))
    sources = emit(program, target, real, option=runners[target].many)
    calls = dict(zip(dict.fromkeys(wanted), run_or_python(sources, runners[target].run)[0].values(), strict=True))
    return calls[name] if isinstance(name, str) else tuple(calls[one] for one in wanted)
