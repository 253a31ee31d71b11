"""Floating-point exceptions: what a C function raises beyond what its result says.

A caller may have traps enabled. For ordinary, tiny and denormal states nothing but the inexact flag may be raised, and
for a NaN none at all: NaN goes in, NaN comes out. Only infinite results raise overflow, and infinite angles invalid.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import platform
import warnings
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from symdyn.bench.case import Case, worst
from symdyn.bench.stress.scenes import Calls, arm, calls, looked_at, one_body, rubbing
from symdyn.dynamics import Function
from symdyn.scene import Scene
from symdyn.verdict import Unclaimed

Array = npt.NDArray[np.float64]


FLAGS = {  # invalid, division by zero, overflow, underflow
    "x86_64": (1, 4, 8, 16),
    "AMD64": (1, 4, 8, 16),
    "aarch64": (1, 2, 4, 8),
    "arm64": (1, 2, 4, 8),
}
NOWHERE = "no function has a value at all of the states"
NAMES = ("invalid", "division by zero", "overflow", "underflow")


def builtin() -> Iterator[Case | Unclaimed]:
    """Yield the cases of the built-in scenes."""
    for kind, one in (("6 axes", arm()), ("one body", one_body()), ("dry friction", rubbing())):
        yield from _of(kind, one)


def of_scene(scene: Scene) -> Iterator[Case | Unclaimed]:
    """Yield the same cases of a scene."""
    if scene.velocities:
        yield from _of("as it is", scene)


def _of(kind: str, one: Scene) -> Iterator[Case | Unclaimed]:
    made = calls(one, looked_at(one))
    mathematics = ctypes.util.find_library("m")
    masks = FLAGS.get(platform.machine())
    if "C" not in made.modules or mathematics is None or masks is None:
        why = "no C compiler found" if "C" not in made.modules else "flags of this machine are not known here"
        yield Unclaimed(f"exceptions that C functions raise, {kind}", why)
        return
    library = ctypes.CDLL(mathematics)
    for text, value, allowed in (
        ("ordinary states", None, ()),
        ("a NaN", np.nan, ()),
        ("angles of 1e-160", 1e-160, ("underflow",)),
    ):
        found: list[tuple[float | None, str]] = []
        for routine in made.program.routines:
            function = routine.function
            rng = np.random.default_rng(6)
            for count in (1, 70):
                given = [rng.uniform(0.5, 5.0, (count, len(a.symbols))) for a in function.arguments]
                if value is not None and function.arguments[0].name == "q":
                    given[0][:, 0] = value
                call = getattr(made.modules["C"], function.name)
                library.feclearexcept(sum(masks))
                call(*given) if count > 1 else call(*[x[0] for x in given])
                raised = library.fetestexcept(sum(masks))
                words = [name for name, mask in zip(NAMES, masks, strict=True) if raised & mask and name not in allowed]
                wrong = None if words and _undefined(made, function, given) else float(len(words))
                found.append((wrong, f"{function.name}, {count} states: {', '.join(words) or 'none'}"))
        yield Case(f"{text}, {kind}", "exceptions that C functions raise", 0.0, *worst(found, NOWHERE))
    yield Case(f"a NaN and ordinary states, {kind}", "exceptions in NumPy", 0.0, *worst(_in_numpy(made)))


def _undefined(made: Calls, function: Function, given: Sequence[Array]) -> bool:
    """Return whether numbers are given at which the function has no value: there, C may raise what it likes."""
    if not all(np.isfinite(x).all() for x in given):
        return False
    states = {argument.name: x for argument, x in zip(function.arguments, given, strict=True)}
    return len(made.truth(function.name, states).kept) < len(given[0])


def _in_numpy(made: Calls) -> list[tuple[float, str]]:
    """Return which functions of the NumPy module raise where the caller has made an exception of every flag."""
    found = []
    for routine in made.program.routines:
        function = routine.function
        rng = np.random.default_rng(6)
        for count, value in ((1, None), (70, None), (1, np.nan), (70, np.nan)):
            given = [rng.uniform(0.5, 1.5, (count, len(a.symbols))) for a in function.arguments]
            if value is not None:
                given[0][:, 0] = value
            call = getattr(made.modules["NumPy"], function.name)
            with np.errstate(all="raise"), warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    call(*given) if count > 1 else call(*[x[0] for x in given])
                except (ArithmeticError, ValueError, Warning) as fault:
                    found.append((1.0, f"{function.name}, {count} states: {fault}"))
    return found or [(0.0, "none") for _ in made.program.routines[:1]]
