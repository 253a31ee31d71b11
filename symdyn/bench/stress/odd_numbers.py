"""Numbers that are hardly any, NaN, infinities, denormals, -0, float, and the exceptions that they raise.

Scenes are hardly any too: none or one body. A caller may have traps enabled: for ordinary, tiny and denormal states
nothing but the inexact flag may be raised, and for a NaN none at all: NaN goes in, NaN comes out. Only infinite results
raise overflow, and infinite angles invalid.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import platform
import warnings
from collections.abc import Iterator, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.bench.measurements import Case, worst
from symdyn.bench.reference import positions_of
from symdyn.bench.stress.scenes import Calls, arm, calls, looked_at, one_body, rubbing
from symdyn.bench.stress.solving import shares
from symdyn.dynamics import Function
from symdyn.emit.code import REALS, Real
from symdyn.errors import SceneError
from symdyn.graph import reachable
from symdyn.scene import Scene, read_text
from symdyn.verdict import Unclaimed

STATES = 4


def builtin() -> Iterator[Case]:
    """Yield the cases of the built-in scenes."""
    for one in (arm(), one_body(), one_body("prismatic")):
        kind = "6 axes" if one.name == "arm" else f"one body, {one.joints[0].type}"
        yield from _of(kind, one)
    yield from _of("dry friction", rubbing())
    yield _weightless()
    yield _nothing()


def of_scene(one: Scene) -> Iterator[Case]:
    """Yield the same cases of a scene."""
    if one.velocities:
        yield from _of("as it is", one)


def _of(kind: str, one: Scene) -> Iterator[Case]:
    names = looked_at(one)
    made = calls(one, names)
    given = _states(one, made, names)
    yield Case(
        f"NaN in one entry, {kind}", "results that hide a NaN they depend on", 0.0, *_hidden(made, given, np.nan)
    )
    infinite = worst([_hidden(made, given, np.inf), _hidden(made, given, -np.inf)])
    if infinite[0] is not None:  # some entry has a sine
        yield Case(f"±infinity in one entry, {kind}", "finite results of a sine of infinity", 0.0, *infinite)
    yield Case(f"-0 for 0, {kind}", "results that differ, ulps of the largest entry", 4.0, *_minus_zero(made, given))
    tiny = {name: value * 1e-310 if name != "params" else value for name, value in given.items()}
    tiny["q"] = given["q"]
    metric = "error / running error bound"
    yield Case(f"denormal rates and forces, {kind}", metric, Real.ALLOWED, *_worst_share(made, names, tiny))
    if not one.is_constrained and "1" not in positions_of(one).units:
        tiny["q"] = given["q"] * 1e-310
        yield Case(f"denormal states, {kind}", metric, Real.ALLOWED, *_worst_share(made, names, tiny))
    singles = calls(one, names, real="float")
    rounded = {name: value.astype(np.float32).astype(float) for name, value in given.items()}
    yield Case(f"float, {kind}", metric, Real.ALLOWED, *_worst_share(singles, names, rounded, REALS["float"].roundoff))


def _states(one: Scene, made: Calls, names: tuple[str, ...]) -> dict[str, Array]:
    rng = np.random.default_rng(5)
    given = {"q": positions_of(one).draw("range", STATES, rng)}
    for name in names:
        for argument in made.function(name).arguments:
            if argument.name not in given:
                given[argument.name] = rng.uniform(0.5, 1.5, (STATES, len(argument.symbols)))
    return given


def _worst_share(
    made: Calls, names: tuple[str, ...], given: dict[str, Array], roundoff: float = REALS["double"].roundoff
) -> tuple[float | None, str]:
    found = [(*shares(made, name, given, roundoff), name) for name in names]
    return worst([(share, f"{name}, {where}") for share, where, name in found])


def _hidden(made: Calls, given: dict[str, Array], value: float) -> tuple[float | None, str]:
    """Return how many entries are finite although `value` is in an argument entry that they need.

    Of an infinity only those are counted that take its sine, which is no number.
    """
    found = []
    for routine in made.program.routines:
        function = routine.function
        for argument in function.arguments:
            for place, symbol in enumerate(argument.symbols):
                needing = _needing(function, symbol, sines=np.isinf(value))
                if not needing:
                    continue
                spoiled = {name: array.copy() for name, array in given.items()}
                spoiled[argument.name][:, place] = value
                for way, computed in made.results(function.name, spoiled).items():
                    finite = np.isfinite(computed[:, needing])
                    found.append((float(finite.sum()), f"{function.name}, {symbol.value}, {way}"))
    return worst(found)


def _needing(function: Function, symbol: object, sines: bool) -> list[int]:
    """Return which entries depend on a symbol, or on its sine."""
    from symdyn.graph import Op

    entries = []
    for k, entry in enumerate(function.entries):
        below = reachable([entry])
        direct = any(node is symbol for node in below)
        turned = any(node.op in (Op.SIN, Op.COS) and any(arg is symbol for arg in node.args) for node in below)
        if turned if sines else direct:
            entries.append(k)
    return entries


def _minus_zero(made: Calls, given: dict[str, Array]) -> tuple[float | None, str]:
    found = []
    for routine in made.program.routines:
        function = routine.function
        zeros = {name: np.zeros_like(value) if name != "params" else value for name, value in given.items()}
        units = next((a.units for a in function.arguments if a.name == "q"), ())
        zeros["q"] = given["q"] * ("1" in units)
        minus = {name: np.where(value == 0, -0.0, value) for name, value in zeros.items()}
        plain = made.results(function.name, zeros)
        for way, computed in made.results(function.name, minus).items():
            known = np.isfinite(plain[way])  # what a singular position makes of zero is no number
            if not known.any():
                continue
            size = np.max(np.abs(plain[way]), where=known, initial=0.0) or 1.0
            gap = np.abs(np.where(np.isfinite(computed), computed, np.inf) - np.where(known, plain[way], 0.0))[known]
            found.append((float(np.max(gap, initial=0.0)) / (2.0**-52 * size), f"{function.name}, {way}"))
    return worst(found)


def _nothing() -> Case:
    """Return how many scenes in which nothing can move are taken, and not refused in one line."""
    found = []
    fixed = 'bodies.b.mass = 1\njoints.f = { type = "fixed", parent = "ground", child = "b" }'
    for kind, text in (("no bodies", ""), ("one fixed body", fixed)):
        try:
            read_text(text, "nothing")
        except SceneError as fault:
            found.append((float(len(fault.faults) - 1), kind))
        else:
            found.append((1.0, kind))
    return Case("no bodies, or none that moves", "scenes that are taken without a word", 0.0, *worst(found))


def _weightless() -> Case:
    """Return how many functions of a mechanism of one joint without anything to move it fail to be zero or empty."""
    joint = 'joints.j = { type = "revolute", parent = "ground", child = "b" }'
    weightless = read_text(f"bodies.b = {{}}\n{joint}", "weightless")
    made = calls(weightless, ("inverse_dynamics", "mass_matrix", "gravity_forces"))
    given = {name: np.ones((2, 1)) for name in ("q", "qd", "qdd")}
    found = []
    for name in ("inverse_dynamics", "mass_matrix", "gravity_forces"):
        for way, computed in made.results(name, given).items():
            found.append((float(np.count_nonzero(computed)), f"{name}, {way}"))
    return Case("a body without mass", "entries that are not zero", 0.0, *worst(found))


FLAGS = {  # invalid, division by zero, overflow, underflow
    "x86_64": (1, 4, 8, 16),
    "AMD64": (1, 4, 8, 16),
    "aarch64": (1, 2, 4, 8),
    "arm64": (1, 2, 4, 8),
}
NOWHERE = "no function has a value at all of the states"
NAMES = ("invalid", "division by zero", "overflow", "underflow")


def traps() -> Iterator[Case | Unclaimed]:
    """Yield the cases of the built-in scenes."""
    for kind, one in (("6 axes", arm()), ("one body", one_body()), ("dry friction", rubbing())):
        yield from _traps_of(kind, one)


def traps_of_scene(scene: Scene) -> Iterator[Case | Unclaimed]:
    """Yield the same cases of a scene."""
    if scene.velocities:
        yield from _traps_of("as it is", scene)


def _traps_of(kind: str, one: Scene) -> Iterator[Case | Unclaimed]:
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
