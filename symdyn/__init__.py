"""symdyn: equations of motion of mechanisms, from a declared scene to proved code.

    scene = symdyn.read("arm.toml")                         a frozen Scene; or declare it with symdyn.scene
    scene = symdyn.example("four_bar")                      one of those that come with the package
    equations = symdyn.derive(scene, ["mass_matrix"])       named functions on one expression graph
    M = symdyn.lambdify(scene, "mass_matrix")               a NumPy callable of q, (n,) or (..., n)
    arm = symdyn.load("arm.toml")                           all its functions, compiled: arm.mass_matrix(q)
    symdyn.equations(scene).latex()                         to be read: LaTeX, text, or SymPy's matrices by .sympy()
    symdyn.closed_form(scene).sympy("k_z", 0, 1)            one coefficient for SymPy
    symdyn.certify(scene).passed                            derivations proved equal, code measured
    symdyn.simulate(scene, until=10)                        a trajectory; symdyn.inverse: the forces of a motion
    symdyn.ensemble(scene, start={"q1": array})             many runs at once, and measures of each
    symdyn.sensitivity(scene, until=10)                     d(end of a run)/d(start, parameters)
    symdyn.sweep(scene, "m1=linspace(1,2,5)", "max(abs(q1))")   runs at many values, and measures of them
    symdyn.uncertainty(scene, {"m1": 0.01})                 error bars on motions and forces, to first order
    symdyn.linearize(scene)                                 A, B, C, D and modes next to a point
    symdyn.collocation(scene, until=2, cost="F**2")         a motion that is looked for, for solvers: optimal control
    symdyn.identify(scene, "log.csv")                       parameters from measured motion, with standard errors
    symdyn.picture(scene)                                   SVG text; symdyn.animation: HTML; symdyn.film: MP4

    from symdyn.emit import emit, write                     source text: emit(symdyn.lower(equations), "c")
    from symdyn.build import build                          the same, compiled and loaded

Everything is imported when it is first used: `dir(symdyn)` lists these doors and the rooms behind them.
"""

from __future__ import annotations

from importlib import import_module
from sys import modules

TYPE_CHECKING = False  # importing typing would take longer than all else here
if TYPE_CHECKING:
    from symdyn.build import lambdify
    from symdyn.build.backends.door import load
    from symdyn.draw import animation, film, picture
    from symdyn.dynamics import derive
    from symdyn.dynamics.closed_forms.closed_form import closed_form
    from symdyn.emit.print.equations_of_motion import equations
    from symdyn.errors import SymdynError
    from symdyn.identification import identify
    from symdyn.linear import linearize
    from symdyn.program import lower
    from symdyn.scene import Scene, example, read
    from symdyn.simulation import inverse, sensitivity, simulate
    from symdyn.simulation.ensemble.door import ensemble
    from symdyn.study import sweep, uncertainty
    from symdyn.transcription import collocation
    from symdyn.verify import certify

    from . import (  # noqa: F401
        bench,
        build,
        draw,
        dynamics,
        emit,
        errors,
        graph,
        identification,
        linear,
        program,
        scene,
        simulation,
        study,
        teach,
        transcription,
        verify,
    )

    __version__: str

_ROOMS = (
    "bench",
    "build",
    "draw",
    "dynamics",
    "emit",
    "errors",
    "graph",
    "identification",
    "linear",
    "program",
    "scene",
    "simulation",
    "study",
    "teach",
    "transcription",
    "verify",
)

_DOORS = {
    "Scene": "symdyn.scene",
    "SymdynError": "symdyn.errors",
    "animation": "symdyn.draw",
    "certify": "symdyn.verify",
    "collocation": "symdyn.transcription",
    "closed_form": "symdyn.dynamics.closed_forms.closed_form",
    "derive": "symdyn.dynamics",
    "ensemble": "symdyn.simulation.ensemble.door",
    "equations": "symdyn.emit.print.equations_of_motion",
    "example": "symdyn.scene",
    "film": "symdyn.draw",
    "identify": "symdyn.identification",
    "inverse": "symdyn.simulation",
    "lambdify": "symdyn.build",
    "linearize": "symdyn.linear",
    "load": "symdyn.build.backends.door",
    "lower": "symdyn.program",
    "picture": "symdyn.draw",
    "read": "symdyn.scene",
    "sensitivity": "symdyn.simulation",
    "simulate": "symdyn.simulation",
    "sweep": "symdyn.study",
    "uncertainty": "symdyn.study",
}

__all__ = [
    "Scene",
    "SymdynError",
    "animation",
    "certify",
    "closed_form",
    "collocation",
    "derive",
    "ensemble",
    "equations",
    "example",
    "film",
    "identify",
    "inverse",
    "lambdify",
    "linearize",
    "load",
    "lower",
    "picture",
    "read",
    "sensitivity",
    "simulate",
    "sweep",
    "uncertainty",
]


def __dir__() -> list[str]:
    """Return what there is for a user."""
    return [*__all__, *_ROOMS, *(name for name in globals() if name.startswith("__")), "__version__"]


if not TYPE_CHECKING:  # else a type checker would believe that there is whatever is asked for

    def __getattr__(name):
        """Import a door or a room when it is first asked for."""
        if name in _DOORS:
            return getattr(import_module(_DOORS[name]), name)
        if name in _ROOMS:
            return import_module(f"symdyn.{name}")
        if name == "__version__":
            from symdyn.resources import version

            return version()
        said = f"symdyn has no {name!r}; it has {', '.join(__all__)}"
        raise AttributeError(said, name=name, obj=modules[__name__])
