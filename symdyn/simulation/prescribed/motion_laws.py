"""Motion laws of one coordinate: position, velocity and acceleration at given times.

    0.3*sin(2*t)                            a formula in t and parameters, differentiated exactly
    constant(x)                             rest at x
    cubic(a, b, T)                          from a to b within T: s = 3z² - 2z³, z = (t - start) / T
    quintic(a, b, T)                        s = 10z³ - 15z⁴ + 6z⁵: at rest and without acceleration at both ends
    cycloidal(a, b, T)                      s = z - sin(2πz) / 2π
    trapezoidal(a, b, T, ramp)              constant acceleration for `ramp`, constant velocity, constant deceleration
    spline(t1, x1, t2, x2, ...)             twice differentiable through the points, at rest at both ends

The laws from a to b take start=... as last argument (0 s), ramp is T/4 if it is not given; before and after a law the
coordinate rests.

A law may also be a function of time in Python. If it returns a position alone, it is differentiated by differences,
whose step is chosen by their agreement: of sin(2 t) the rate comes out to 1e-13 and the acceleration to 2e-11. If it
returns position, velocity and acceleration, these are taken as they are.

Reference: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), sections 2.1 to 3.2.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array, Batches
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import SimulateError, suggestion
from symdyn.frozen import dataclass, field
from symdyn.graph import Graph, evaluate, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Faults, FormulaError, Parameter, acceleration_name, split_commas
from symdyn.simulation.prescribed.formulas_in_time import Columns, bound, jump_of, read_formula, read_number

Motion3 = tuple[Array, Array, Array]
Profile = Callable[[Array], Motion3]

EVER = (-np.inf, np.inf)


@dataclass(frozen=True)
class Law:
    """The motion of one coordinate. It pickles as what it was made of.

    Attributes:
        text: as the user wrote it.
        span: first and last time at which it is known; infinite for formulas.
    """

    text: str
    span: tuple[float, float]
    _profile: Profile = field(repr=False, compare=False)
    _made: tuple[Callable[..., Law], tuple[Any, ...]] = field(repr=False, compare=False)

    def __reduce__(self) -> tuple[Callable[..., Law], tuple[Any, ...]]:
        return self._made

    def __call__(self, times: npt.ArrayLike) -> Motion3:
        """Return position, velocity and acceleration at `times`, each of its shape; rad or m, per s, per s²."""
        return self._profile(np.asarray(times, dtype=np.float64))

    def jump(self, first: float, last: float) -> float | None:
        """Return the first time between two, s, at which the formula of a law jumps, None where no step was found."""
        make, (formula, *_) = self._made
        return jump_of(formula, first, last) if make is formula_law and {*formula.symbols} <= {TIME} else None


def read_law(
    text: str, values: Mapping[str, Quantity], where: str, faults: Faults, unit: str = "", scene: Scene | None = None
) -> Law | None:
    """Return the law that a text of the module's legend says, at values of the parameters; None after a fault.

    `unit` is that of what moves; values that are written with one of another kind are faults.
    """
    name, bracket, rest = text.strip().partition("(")
    if bracket and name.strip() in LAWS and _closes_last(rest):
        return _named(name.strip(), rest.strip()[:-1], text, values, where, faults, unit)
    formula = read_formula(text, (TIME, *values), where, faults, unit=unit, scene=scene)
    if formula is None:
        return None
    try:
        return formula_law(bound(formula, values), text)
    except FormulaError as error:
        faults.add(where, f'"{text}" {error}')
        return None


def formula_law(
    formula: Quantity, text: str, tables: Mapping[str, Callable[[Array], Array]] = MappingProxyType({})
) -> Law:
    """Return the law of a formula in t, and in inputs by their tables, to which those of their rates belong."""
    graph = Graph()
    t = graph.symbol(TIME)
    rates = {one: acceleration_name(one) for one in tables if acceleration_name(one) in tables}
    seeds = {t: graph.one} | {graph.symbol(name): graph.symbol(rate) for name, rate in rates.items()}
    try:
        x = formula.express(graph)
        (v,) = tangents([x], seeds)
        (a,) = tangents([v], seeds)
    except ZeroDivisionError:
        raise FormulaError("divides by zero") from None

    def profile(times: Array) -> Motion3:
        with np.errstate(all="ignore"):
            told = {graph.symbol(name): table(times) for name, table in tables.items()}
            found = evaluate([x, v, a], Batches(), {t: times, **told})
        q, qd, qdd = (np.broadcast_to(np.asarray(one, dtype=np.float64), times.shape).copy() for one in found)
        return q, qd, qdd

    return Law(text, EVER, profile, (formula_law, (formula, text, dict(tables))))


def constant(value: float, text: str = "") -> Law:
    """Return rest at a value."""
    made = (constant, (value, text))
    return Law(text or f"{value:g}", EVER, lambda t: (np.full_like(t, value), 0 * t, 0 * t), made)


# From a to b


def _cubic(z: Array) -> Motion3:
    return z * z * (3 - 2 * z), 6 * z * (1 - z), 6 - 12 * z


def _quintic(z: Array) -> Motion3:
    return z**3 * (10 + z * (6 * z - 15)), 30 * (z * (1 - z)) ** 2, 60 * z * (1 - z) * (1 - 2 * z)


def _cycloidal(z: Array) -> Motion3:
    turn = 2 * np.pi
    return z - np.sin(turn * z) / turn, 1 - np.cos(turn * z), turn * np.sin(turn * z)


def _ramped(ramp: float, z: Array) -> Motion3:
    """Return the trapezoidal profile for a ramp as a fraction of the duration, 0 < ramp <= 1/2."""
    v = 1 / (1 - ramp)
    a = v / ramp
    parts = [z < ramp, z <= 1 - ramp]
    s = np.select(parts, [a * z * z / 2, v * (z - ramp / 2)], 1 - a * (1 - z) ** 2 / 2)
    return s, np.select(parts, [a * z, np.full_like(z, v)], a * (1 - z)), np.select(parts, [a + 0 * z, 0 * z], -a)


def between(a: float, b: float, duration: float, start: float, unit: Profile, text: str) -> Law:
    """Return the law from a to b, from `start` on for `duration`, by a profile on 0..1."""

    def profile(times: Array) -> Motion3:
        z = (times - start) / duration
        moving = (z >= 0) & (z <= 1)
        s, v, w = unit(np.clip(z, 0.0, 1.0))
        way = b - a
        q = np.where(z >= 1, b, a + way * s)
        return q, np.where(moving, way * v / duration, 0.0), np.where(moving, way * w / duration**2, 0.0)

    return Law(text, EVER, profile, (between, (a, b, duration, start, unit, text)))


# Through points


def through(t: Array, x: Array, text: str) -> Law:
    """Return the cubic spline through points, at rest at both ends and beyond them."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(t, x, bc_type="clamped")

    def profile(times: Array) -> Motion3:
        inside = (times >= t[0]) & (times <= t[-1])
        clipped = np.clip(times, t[0], t[-1])
        return spline(clipped), np.where(inside, spline(clipped, 1), 0.0), np.where(inside, spline(clipped, 2), 0.0)

    return Law(text, EVER, profile, (through, (t, x, text)))


def column_curve(columns: Columns, name: str, rate: str, acceleration: str) -> Any:
    """Return a spline through columns of a table: positions, and rates and accelerations if given.

    With positions alone it is a cubic spline, with velocities the cubic, with accelerations too the quintic Hermite
    interpolant.
    """
    from scipy.interpolate import BPoly, CubicHermiteSpline, CubicSpline

    t, x = columns.t, columns.values[name]
    v, a = columns.values.get(rate), columns.values.get(acceleration)
    if v is not None and a is not None:
        return BPoly.from_derivatives(t, np.stack([x, v, a], axis=1))
    return CubicSpline(t, x) if v is None else CubicHermiteSpline(t, x, v)


def column_law(columns: Columns, name: str, rate: str, acceleration: str) -> Law:
    """Return the law of columns of a table, so that a recorded motion comes back at its own times digit for digit."""
    t, x = columns.t, columns.values[name]
    v, a = columns.values.get(rate), columns.values.get(acceleration)
    curve = column_curve(columns, name, rate, acceleration)

    def profile(times: Array) -> Motion3:
        q, qd, qdd = (np.asarray(curve(times, order), dtype=np.float64) for order in range(3))
        place = np.searchsorted(t, times).clip(0, len(t) - 1)
        exact = t[place] == times
        q[exact] = x[place[exact]]
        if v is not None:
            qd[exact] = v[place[exact]]
        if a is not None:
            qdd[exact] = a[place[exact]]
        return q, qd, qdd

    made = (column_law, (columns, name, rate, acceleration))
    return Law(f"{columns.source}: {name}", (float(t[0]), float(t[-1])), profile, made)


# Reading


LAWS: Mapping[str, tuple[str, ...]] = {
    "constant": ("x",),
    "cubic": ("a", "b", "T", "start"),
    "quintic": ("a", "b", "T", "start"),
    "cycloidal": ("a", "b", "T", "start"),
    "trapezoidal": ("a", "b", "T", "ramp", "start"),
    "spline": (),
}
"""Names of the laws and of their arguments, in order; a spline takes times and points by turns."""

IN_TIME = {"T": "s", "start": "s", "ramp": "s"}
"""Units of the arguments that are no positions."""

UNITS: Mapping[str, Profile] = {"cubic": _cubic, "quintic": _quintic, "cycloidal": _cycloidal}


def _closes_last(rest: str) -> bool:
    """Tell whether the bracket that opened before `rest` closes at its end."""
    depth = 1
    for place, letter in enumerate(rest.rstrip()):
        depth += (letter == "(") - (letter == ")")
        if depth == 0:
            return place == len(rest.rstrip()) - 1
    return False


def _named(
    name: str, inside: str, text: str, values: Mapping[str, Quantity], where: str, faults: Faults, unit: str
) -> Law | None:
    given: dict[str, str] = {}
    plain: list[str] = []
    before = len(faults.lines)
    for part in split_commas(inside):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if equals and key not in LAWS[name]:
            faults.add(where, f'"{text}": {name} has no argument {key}; {suggestion(key, LAWS[name] or ("t, x",))}')
        elif equals:
            given[key] = value
        else:
            plain.append(part)
    keys = LAWS[name] or ("T", "x") * len(plain)  # of a spline
    kinds = [IN_TIME.get(key, unit) for key in keys] + [""] * len(plain)
    read = [_number(one, text, values, where, faults, kind) for one, kind in zip(plain, kinds, strict=False)]
    if name == "spline":
        return _points(read, text, where, faults) if len(faults.lines) == before else None
    if len(read) > len(LAWS[name]):
        faults.add(where, f'"{text}": {name} takes ({", ".join(LAWS[name])}); {len(read)} arguments were given')
        return None
    numbers = dict(zip(LAWS[name], read, strict=False))
    numbers |= {
        key: _number(value, text, values, where, faults, IN_TIME.get(key, unit)) for key, value in given.items()
    }
    missing = [key for key in LAWS[name] if key not in numbers and key not in ("start", "ramp")]
    if missing:
        faults.add(where, f'"{text}": {", ".join(missing)} missing; {name} takes ({", ".join(LAWS[name])})')
    if len(faults.lines) > before:
        return None
    return _made(name, {key: value for key, value in numbers.items() if value is not None}, text, where, faults)


def _number(
    text: str, whole: str, values: Mapping[str, Quantity], where: str, faults: Faults, unit: str
) -> float | None:
    return read_number(text, values, f"{where}: {whole}", faults, Parameter("", unit=unit))


def _made(name: str, numbers: Mapping[str, float], text: str, where: str, faults: Faults) -> Law | None:
    if name == "constant":
        return constant(numbers["x"], text)
    a, b, T, start = numbers["a"], numbers["b"], numbers["T"], numbers.get("start", 0.0)
    if not T > 0:
        faults.add(where, f'"{text}": T = {T:g} s is not a duration; give a positive one')
        return None
    if name != "trapezoidal":
        return between(a, b, T, start, UNITS[name], text)
    ramp = numbers.get("ramp", T / 4)
    if not 0 < ramp <= T / 2:
        faults.add(where, f'"{text}": ramp = {ramp:g} s is not within 0 and T/2 = {T / 2:g} s')
        return None
    return between(a, b, T, start, partial(_ramped, ramp / T), text)


def _points(numbers: Sequence[float | None], text: str, where: str, faults: Faults) -> Law | None:
    t, x = np.array(numbers[::2], dtype=np.float64), np.array(numbers[1::2], dtype=np.float64)
    if len(t) != len(x) or len(t) < 2:
        faults.add(
            where, f'"{text}": spline takes times and points by turns, two points at least: spline(0, 0, 1, 0.5)'
        )
        return None
    if np.any(np.diff(t) <= 0):
        faults.add(where, f'"{text}": the times of the points must rise')
        return None
    return through(t, x, text)


def read_function(function: Callable[[float], Any], where: str, faults: Faults) -> Law | None:
    """Return the law of a function of time that returns x, or (x, ẋ, ẍ); None after a fault."""
    if required_arguments(function) not in (1, None):
        faults.add(where, "a function takes one argument, the time in s, and returns x or (x, rate, acceleration)")
        return None
    return function_law(function, where)


def required_arguments(function: Callable[..., Any]) -> int | None:
    """Return how many arguments a function must be given, None where it does not tell or takes any number."""
    try:
        given = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return None
    if any(one.kind is one.VAR_POSITIONAL for one in given):
        return None
    return sum(
        one.default is one.empty and one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD) for one in given
    )


def function_law(function: Callable[[float], Any], where: str) -> Law:
    """Return the law of a function of time; it raises SimulateError where that raises, or returns what is no motion."""

    def at(t: float) -> Array:
        try:
            said = function(t)
        except Exception as fault:
            words = f": {fault}" if str(fault) else ""
            raise SimulateError(f"{where}: the function raised {type(fault).__name__}{words} at t = {t:g} s") from fault
        try:
            found = np.asarray(said, dtype=np.float64)
        except (TypeError, ValueError):
            found = np.empty(0)
        if found.size not in (1, 3) or found.ndim > 1:
            raise SimulateError(
                f"{where}: the function returned {said!r:.80} at t = {t:g} s; give x, or (x, rate, acceleration)"
            )
        return found.reshape(-1)

    def profile(times: Array) -> Motion3:
        rows = []
        for t in times.reshape(-1).tolist():
            found = at(t)
            rows.append(found if len(found) == 3 else np.array([found[0], *_differences(at, t)]))
        q, qd, qdd = np.array(rows).reshape(*times.shape, 3).transpose(-1, *range(times.ndim))
        return q, qd, qdd

    return Law("function", EVER, profile, (function_law, (function, where)))


FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
"""Central differences of order 8 at -4, ..., 4 steps."""

STEPS = (0.2, 0.08, 0.032, 0.0128, 0.005, 0.002, 0.0008)
"""s; which one is short enough, and not too short for the digits of a double, its neighbour tells."""


def _differences(at: Callable[[float], Array], t: float) -> tuple[float, float]:
    """Return ẋ and ẍ, each by the shorter of the two neighbouring steps that agree best; NaN where none has a value."""

    def near(time: float) -> float:
        try:
            return float(at(time)[0])
        except SimulateError:  # before its beginning, or behind its end
            return math.nan

    values = [np.array([near(t + k * h) for k in range(-4, 5)]) for h in STEPS]
    found = []
    for weights, order in ((FIRST, 1), (SECOND, 2)):
        some = np.array([weights @ x / h**order for x, h in zip(values, STEPS, strict=True)])
        apart = np.abs(np.diff(some))
        found.append(float(some[1 + int(np.nanargmin(apart))]) if np.any(np.isfinite(apart)) else math.nan)
    return found[0], found[1]
