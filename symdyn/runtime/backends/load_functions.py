"""A scene's functions, ready to call: `symdyn.load("arm.toml").inverse_dynamics(q, qd, qdd)`, with NumPy or another."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from symdyn.arguments import checked
from symdyn.dynamics import LoopChoices, request_of
from symdyn.emit.code import ShortSines
from symdyn.errors import ArgumentError, BuildError, EmitError, MissingProgram, choice
from symdyn.extras import install
from symdyn.frozen import dataclass, replace
from symdyn.runtime.loaded import Loaded, loaded, names_of, values_of
from symdyn.runtime.numeric_function import compile_all
from symdyn.scene import SceneLike, bind, scene_of


@dataclass(frozen=True)
class Backend:
    """Whose arrays functions take."""

    title: str  # what people call it
    package: str  # what is imported, and the extra that installs it; "" for NumPy, which is always there
    load: Callable[..., Loaded]  # as `symdyn.runtime.loaded.loaded`


def _over(backend: str, *settings: Any) -> Loaded:
    from symdyn.runtime.backends.words import loaded_for

    library = import_module(f"symdyn.runtime.backends.{backend}_functions").LIBRARY
    return loaded_for(library, _again, backend, *settings)


BACKENDS: dict[str, Backend] = {
    "numpy": Backend("NumPy", "", loaded),
    "jax": Backend("JAX", "jax", partial(_over, "jax")),
    "torch": Backend("PyTorch", "torch", partial(_over, "torch")),
}


@checked(ArgumentError)
def load(
    scene: SceneLike,
    functions: str | Sequence[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    compiler: str | None = None,
    machine: str = "native",
    prepare: bool = False,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
    free: str | Sequence[str] = (),
    backend: str = "numpy",
    at_once: bool = False,
    accuracy: str = "",
) -> Loaded:
    """Return the functions of a scene, each compiled into a NumPy ufunc when it is first called, and then kept.

    Where there is no compiler, or no header of Python, they are those of the generated NumPy module: slower, in float64
    alone, otherwise the same. A warning says so, once.

    >>> import symdyn
    >>> cart = symdyn.load(symdyn.example("cart_pole"), ["mass_matrix", "pose:tip"], free="mp")
    >>> cart
    <cart_pole, compiled:
        mass_matrix(q, params) -> M: (2),(1)->(2,2)
        pose_tip(q, params) -> T: (2),(1)->(3,4)>
    >>> cart.mass_matrix([0, 0]).round(6).tolist()
    [[1.1, -0.025], [-0.025, 0.008333]]
    >>> float(cart.mass_matrix([0, 0], mp=1.5)[0, 0])
    2.5

    Args:
        scene: a scene, or a file that `symdyn.read` understands.
        functions: one such as "inverse_dynamics" or "pose:tool", or several; None takes the dynamics and the
            kinematics of the declared points, but not the Coriolis matrix and the coefficients k_z, k_C and so on,
            which are large.
        parameters: values for free parameters, as numbers or formulas; the others are the last operand, `params`.
        compiler: as for `symdyn.runtime.build`.
        machine: likewise.
        closing: what to choose about closed loops, see `symdyn.dynamics.LoopChoices`.
        prepare: whether to take work on parameters alone out of the calls: `prepared = arm.prepare(params)`, once, is
            then the last operand of all other functions. Without free parameters there is nothing to prepare.
        free: name of a parameter that stays an argument though it has a value, or names; a call gives it in SI,
            or takes that value.
        backend: whose arrays the functions take: "numpy", or "jax" or "torch", which differentiate them. They run over
            the same C, which they cannot do without; arrays of both on CUDA go to kernels that nvcc compiles.
        at_once: whether to compile all functions now, for one state and for many, in both real types.
        accuracy: "1e-10" for shorter sines of many states in float64, which are faster; each is within 8e-12 of the
            true one. "" for all that the type allows.

    Raises:
        SceneError: the file has faults, or a parameter does not exist.
        DerivationError: a function does not exist.
        BuildError: the compiler that was asked for, here or as $CC, is not there or fails; an unknown
            machine or backend, or one whose package is not installed.
        EmitError: there is no such accuracy, or the backend does not have it.
    """
    row = find_backend(backend)
    if ShortSines.find(accuracy) and row.package:
        raise EmitError(f"accuracy {accuracy} is for NumPy's arrays, not for those of {row.title}; leave it out")
    known = scene_of(scene)
    bound = scene_of(known, parameters)
    values = values_of(bound, names_of("free", free))
    if values and parameters is not None and bound is not known:
        # what is bound to zero is gone from formulas, and could not be given by name
        bound = bind(known, {name: value for name, value in parameters.items() if name not in values})
    known = bound
    names = None if functions is None else names_of("functions", functions)
    opened = tuple(replace(p, value=None) if p.name in values else p for p in known.parameters)
    known = replace(known, parameters=opened)
    requests = None if names is None else tuple(dict.fromkeys(request_of(name, known) for name in names))
    settings = (known, requests, compiler, machine, prepare, closing, values)
    found = row.load(*settings, accuracy) if accuracy else row.load(*settings)
    if at_once:
        compile_all(call.call for call in found.calls.values())
    return found


def find_backend(name: str) -> Backend:
    """Return a row of the table.

    Raises:
        BuildError: there is no such backend.
        MissingProgram: its package is not installed.
    """
    if name not in BACKENDS:
        raise BuildError(f"backend {name!r} is not known; {choice(name, BACKENDS)}")
    row = BACKENDS[name]
    if row.package and find_spec(row.package) is None:
        raise MissingProgram(f"backend {name!r}: {row.title} is not installed; `{install(row.package)}` does that")
    return row


def _again(backend: str, *settings: Any) -> Loaded:
    return find_backend(backend).load(*settings)
