"""Which integrator fits a system: Taylor's where it applies, implicit methods where the system is stiff, else DOP853.

A system is stiff where a motion dies out so fast, -Re λ, that an explicit method would have to follow it although
nothing oscillates or grows nearly as fast; λ are the eigenvalues of ∂f/∂x at the start. What dies out as fast as
something else grows is a saddle, as at a pendulum's top, which friction has no part in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import MethodError
from symdyn.extras import install
from symdyn.scene.values import suggestion
from symdyn.simulation.equations.implicit import differences
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.integrate.heyoka_expressions import overlooks, refuses, size
from symdyn.simulation.integrate.method import DOUBLES, Method

STIFF_STEPS, STIFF_RATIO = 3000.0, 50.0
"""Beyond both a system is stiff: steps that stability asks of an explicit method, decay over oscillation or growth."""

OTHERWISE = "dop853"
"""What steps over a change point of loops, where series end."""

LARGEST = 3000
"""Operations that heyoka compiles within a few seconds."""


@dataclass(frozen=True)
class Choice:
    """An integrator and why it was taken.

    Attributes:
        name: its key in `METHODS`.
        method: the integrator.
        reason: in words, "" for none.
        otherwise: the one to take where it cannot go on, if nobody asked for it; None for none.
    """

    name: str
    method: Method
    reason: str
    otherwise: str | None = None


def choose(
    system: StateEquations,
    x: Array,
    until: float,
    requested: str | None = None,
    rtol: float | None = None,
    limited: bool = False,
) -> Choice:
    """Return the integrator for a system that starts at x: the one of `METHODS` that was asked for, or that fits.

    A relative tolerance below what doubles have takes the one that computes in more; `limited` says whether limits of
    joints end the run.

    Raises:
        SimulateError: there is no such method, it does not apply, or its library is missing.
    """
    if requested is not None:
        return _asked(system, requested.lower(), limited, rtol, "take dop853")
    if rtol is not None and rtol < DOUBLES:
        return replace(_asked(system, _finer(), limited, rtol), reason="doubles have no such tolerance")
    if is_stiff(system, x, until):
        if system.loop is not None and system.loop.period is not None:
            return Choice(
                "radau", METHODS["radau"], "the system is stiff, and multistep methods would begin anew at samples"
            )
        name = "cvode" if METHODS["cvode"].installed else "radau"
        return Choice(name, METHODS[name], "the system is stiff")
    why = refuses(system)
    if not why and overlooks(system):
        why = f"a series may overlook a turn of {overlooks(system)}"
    if not why and size(system) > LARGEST:
        why = f"{size(system)} operations would take heyoka long to compile"
    if not why and not METHODS["taylor"].installed:
        why = f"heyoka is not installed; {install('simulate')}"
    if not why:
        return Choice("taylor", METHODS["taylor"], "", OTHERWISE if system.closed else None)
    return Choice("dop853", METHODS["dop853"], f"no Taylor method: {why}")


def _finer() -> str:
    """Return the method with the most digits."""
    return min(METHODS, key=lambda name: METHODS[name].finest)


def _asked(system: StateEquations, name: str, limited: bool, rtol: float | None, other: str = "") -> Choice:
    """Return a method by its name; `other` is what else to do where it does not apply."""
    if name not in METHODS:
        raise MethodError(f"method {name} is not known; {suggestion(name, METHODS)}")
    method = METHODS[name]
    if not method.installed:
        raise MethodError(f"method {name} needs {method.library}; {install(method.extra)}")
    why = method.refuses(system)
    if not method.finds_events and not why and limited:
        why = "joints have limits, which end runs, and it looks for no events (--ignore-limits lets it)"
    coarser = f"give --rtol {DOUBLES:g} or more" if rtol is not None and rtol < DOUBLES else ""
    if why:
        raise MethodError(f"method {name} does not apply: {why}; {' and '.join(filter(None, (other, coarser)))}")
    if coarser and not method.beyond_doubles:
        raise MethodError(f"method {name} computes in doubles: {coarser}, or no method, which takes {_finer()}")
    return Choice(name, method, "")


def is_stiff(system: StateEquations, x: Array, until: float) -> bool:
    """Tell whether a system is stiff at the start; a jump there, which looks infinitely steep, is no stiffness."""
    return dies_out_fast(lambda step: differences(system, 0.0, x, step), until)


def dies_out_fast(jacobian: Callable[[float], Array], until: float) -> bool:
    """Tell whether a system is stiff, from its ∂f/∂x by differences of a relative size."""
    decays = []
    for step in (1e-5, 1e-6):
        eigenvalues = np.linalg.eigvals(jacobian(step))
        decay = float(np.max(-eigenvalues.real, initial=0.0))
        lively = float(np.max(np.maximum(np.abs(eigenvalues.imag), eigenvalues.real), initial=0.0))
        if not (decay * until > STIFF_STEPS and decay > STIFF_RATIO * lively):
            return False
        decays.append(decay)
    return decays[1] < 2 * decays[0]
