"""symdyn: equations of motion of mechanisms, from a declared scene to proved code.

    scene = symdyn.read("arm.toml")                         a frozen Scene; or declare it with symdyn.scene
    scene = symdyn.example("four_bar")                      one of those that come with the package
    M = symdyn.lambdify(scene, "mass_matrix")               a NumPy callable of q, (n,) or (..., n)
    arm = symdyn.load("arm.toml")                           all its functions, compiled: arm.mass_matrix(q)
    symdyn.equations(scene).latex()                         to be read: LaTeX, text, or SymPy's matrices by .sympy()
    symdyn.closed_form(scene).sympy("k_z", 0, 1)            one coefficient for SymPy
    symdyn.certify(scene).passed                            derivations proved equal, code measured
    symdyn.simulate(scene, until=10)                        a trajectory; symdyn.inverse: the forces of a motion
    symdyn.inverse_kinematics(scene, "tool=x, y, z, rpy(a, b, c)")   all postures in which an arm has a pose
    symdyn.ensemble(scene, start={"q1": array})             many runs at once, and measures of each
    symdyn.sensitivity(scene, until=10)                     d(end of a run)/d(start, parameters)
    symdyn.sweep(scene, "m1=linspace(1,2,5)", "max(abs(q1))")   runs at many values, and measures of them
    symdyn.uncertainty(scene, {"m1": 0.01})                 error bars on motions and forces, to first order
    symdyn.linearize(scene)                                 A, B, C, D, modes about an operating point
    symdyn.collocation(scene, until=2, cost="F**2")         an optimal control problem, for solvers
    symdyn.identify(scene, "log.csv")                       parameters from measured motion, with standard errors
    symdyn.picture(scene)                                   SVG text; symdyn.animation: HTML; symdyn.film: MP4

    from symdyn.dynamics import derive                      named functions on one expression graph
    from symdyn.program import lower                        the same as assignments
    from symdyn.emit import emit, write                     source text: emit(lower(derive(scene)), "c")
    from symdyn.runtime import build                        the same, compiled and loaded

Everything is imported when it is first used: `dir(symdyn)` lists these functions and the packages behind them.
"""

from __future__ import annotations

import os
import sys
from typing import Any, NoReturn

import lazy_loader

from symdyn.shown import shown_by

_offered, _, _names = lazy_loader.attach_stub(__name__, __file__)
_packages = [name for name in _names if os.path.exists(os.path.join(__path__[0], name)) or name == "errors"]

__all__ = [name for name in _names if name not in _packages]


def __dir__() -> list[str]:
    return [*__all__, *_packages, *(name for name in globals() if name.startswith("__")), "__version__"]


def _bundle(noun: object) -> dict[str, str]:
    from symdyn.notebook import bundle  # above all nouns, and imported when a notebook asks

    return bundle(noun)


shown_by(_bundle)


class _Root(type(sys.modules[__name__])):  # type: ignore[misc]  # what it is is lazy_loader's
    """This package, which lets those inside say what is meant where one is called like a function."""

    def __setattr__(self, name: str, value: object) -> None:
        if name in _packages and "__call__" not in vars(type(value)):
            value.__class__ = type("Package", (type(value),), {"__call__": _told})
        super().__setattr__(name, value)


def _told(package: Any, *_: object, **__: object) -> NoReturn:
    from symdyn.errors import ArgumentError, hint  # an error's own

    name = package.__name__.rpartition(".")[2]
    told = hint("packages", name) or f"dir(symdyn.{name}) tells what it has"
    raise ArgumentError(f"symdyn.{name} is a package, and not called; {told}")


sys.modules[__name__].__class__ = _Root


def _offering(name: str) -> str:
    """Return the package that offers a name, "" for none."""
    from importlib import import_module  # an error's own

    fronts = (import_module(f"symdyn.{one}") for one in _packages)
    return next((one.__name__ for one in fronts if name in getattr(one, "__all__", ())), "")


def __getattr__(name: str) -> object:
    """Import what is offered when it is first asked for."""
    if name in _names:
        return _offered(name)
    if name == "__version__":
        from symdyn.resources import version

        return version()
    if os.path.exists(os.path.join(__path__[0], f"{name}.py")):  # `from symdyn import shell` asks here first
        raise AttributeError(name)
    from symdyn.errors import choice, hint  # an error's own

    moved = hint("functions", name).replace("$", name)
    told = moved or choice(name, __all__)
    if not moved and not name.startswith("_") and (package := _offering(name)):
        told = f"it is {package}.{name}"
    raise AttributeError(f"symdyn has no {name!r}; {told}", name=name, obj=sys.modules[__name__])
