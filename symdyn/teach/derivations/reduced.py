"""One freedom left, others being cyclic or prescribed: its inertia m and potential V, with ½ m ṙ² + V constant.

    c     cyclic coordinates, their momenta p kept          m = M_rr - M_rc M_cc⁻¹ M_cr,  V = P + ½ pᵀ M_cc⁻¹ p
    led   prescribed, at constant rates Ω, L without them   m = M_rr,                     V = P - ½ Ωᵀ M_LL Ω

Without either, m is the mass and V = P. Drives and friction are left out.

Reference: Routh; Goldstein, Classical Mechanics, 8.3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from symdyn.algebra import Array, Batches, Form
from symdyn.dynamics.mechanism import TIME, prescribed
from symdyn.errors import DerivationError, NoValueError, SymdynError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, gradient, reachable, repeated, substitute
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.elsewhere import elsewhere
from symdyn.teach.document import Block, Step, Try
from symdyn.teach.lesson import Lesson, named
from symdyn.teach.shown_state import Chosen
from symdyn.unlocked import cached_property

POLE = 0.1
"""Of a curvature: where half the step changes it by more, V has a pole and no level place."""

GRID = 1441
"""Places of a turn, or of a way, at which curves are computed."""


@dataclass(frozen=True)
class Reduced:
    """A mechanism with one freedom that its symmetries leave.

    Attributes:
        r: which coordinate is left.
        cyclic, led: the others.
        static: W = P - K of the motion with ṙ = 0, a node in the rates of the others: steady motions are where it is
            level along r.
        momenta: values of p, shape (len(cyclic),).
    """

    lesson: Lesson
    chosen: Chosen
    r: int
    cyclic: tuple[int, ...]
    led: tuple[int, ...]
    static: Expr
    momenta: Array

    @property
    def q(self) -> Expr:
        """The coordinate."""
        return self.lesson.state.q[self.r]

    @property
    def turns(self) -> bool:
        """Whether it is an angle."""
        return SceneUnits(self.lesson.scene).coordinates[self.r] == "rad"

    @property
    def places(self) -> list[tuple[float, float, float]]:
        """What is level of a whole turn, or of a slide about where the lesson has it."""
        here = self.chosen.values[self.q]
        low, high = (-math.pi, math.pi) if self.turns else (here - 2 * abs(here) - 1, here + 2 * abs(here) + 1)
        return self.level(low, high)

    @property
    def couples(self) -> bool:
        """Whether the others have a say: their inertia depends on it."""
        lesson = self.lesson
        (kinetic,) = substitute([lesson.energy.K], {lesson.state.qd[self.r]: lesson.graph.zero})
        return not zero(lesson, gradient(kinetic, [self.q])[0])

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return m and V at places, each of the shape of x; what has no value there is NaN or infinite.

        V is NaN where m is negative: numbers that no bodies have, and no motion near such a place is told.
        """
        with np.errstate(all="ignore"):
            found = self._inertia_and_potential({self.q: x})
            shaped = [np.broadcast_to(np.asarray(one, dtype=np.float64), x.shape) for one in found]
            n, V = 1 + len(self.cyclic), shaped[-1]
            matrix = np.stack(shaped[:-1], axis=-1).reshape(*x.shape, n, n)
            m = matrix[..., 0, 0]
            if n > 1:
                inner, beside = matrix[..., 1:, 1:], matrix[..., 1:, 0]
                inverse = np.linalg.pinv(np.where(np.isfinite(inner), inner, 0.0), rcond=1e-14)
                m = m - np.einsum("...i,...ij,...j", beside, inverse, beside)
                V = V + 0.5 * np.einsum("i,...ij,j", self.momenta, inverse, self.momenta)
                V = np.where(np.linalg.cond(inner) < 1e13, V, np.inf)
        return m, np.where(m < 0, np.nan, V)

    @cached_property
    def _inertia_and_potential(self) -> Callable[[Mapping[Expr, Any]], list[Any]]:
        """What gives the entries of M of r and cyclic coordinates, and the potential, at values of r."""
        lesson, others = self.lesson, [self.r, *self.cyclic]
        M = [gradient(p, lesson.state.qd) for p in lesson.momenta]
        entries = [M[i][j] for i in others for j in others]
        potential = self.static if self.led else lesson.energy.P
        fixed = {x: value for x, value in self.chosen.values.items() if x is not self.q}
        return repeated([*entries, potential], Batches(), fixed=fixed)

    def of(self, form: Form) -> float:
        """Return the value of a form of parameters."""
        return self.chosen.of(form.express(self.lesson.graph))[0]

    def rates(self, x: float) -> Array:
        """Return the rates of cyclic coordinates when r rests at a place, shape (len(cyclic),)."""
        M = [gradient(p, self.lesson.state.qd) for p in self.lesson.momenta]
        entries = [M[i][j] for i in self.cyclic for j in self.cyclic]
        values = self.chosen.with_values({self.q: x}).of(*entries)
        return np.asarray(np.linalg.solve(np.array(values).reshape(len(self.cyclic), -1), self.momenta))

    def level(self, low: float, high: float) -> list[tuple[float, float, float]]:
        """Return (place, V'', m) of all places between two where V is level, ascending."""
        step, found = (high - low) / GRID, list[tuple[float, float, float]]()
        x: Array = low + step * (np.arange(-2.0, GRID + 3) + 1 / 7)  # beside zeros of sines, and beyond both ends
        slope = np.gradient(self.at(x)[1], step)
        good = np.isfinite(slope)
        for k in np.flatnonzero((slope[:-1] * slope[1:] < 0) & good[:-1] & good[1:]):
            place = self._bisected(float(x[k]), float(x[k + 1]))
            if not low + step / 9 < place < high + step / 9:
                continue
            m, V = self.at(place + step * np.array([-1.0, -0.5, 0.0, 0.5, 1.0]))
            wide, narrow = V[0] - 2 * V[2] + V[4], 4 * (V[1] - 2 * V[2] + V[3])
            if np.isfinite(wide + narrow) and abs(wide - narrow) < POLE * abs(wide):  # no pole
                found.append((0.0 if abs(place) < 1e-9 else place, float(narrow) / step**2, float(m[2])))
        return found

    def _bisected(self, low: float, high: float) -> float:
        """Return where V is level between two places."""

        def slope(x: float) -> float:
            h = 1e-4
            V = self.at(np.array([x - 2 * h, x - h, x + h, x + 2 * h]))[1]
            return float(V[0] - 8 * V[1] + 8 * V[2] - V[3])

        sign = slope(low) > 0
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (middle, high) if (slope(middle) > 0) == sign else (low, middle)
        return (low + high) / 2


def zero(lesson: Lesson, node: Expr) -> bool:
    """Tell whether a node vanishes as a function; False where that cannot be decided."""
    try:
        return node.is_zero or lesson.vanishes(node)
    except (DerivationError, KeyError):
        return False


def led_by(lesson: Lesson) -> tuple[int, ...]:
    """Return the velocities whose motion is prescribed."""
    return lesson.scene.prescribed_velocities


def cyclic_of(lesson: Lesson) -> tuple[int, ...]:
    """Return the coordinates that L does not know, of those that no motion is prescribed of."""
    led = led_by(lesson)
    return tuple(k for k in range(lesson.state.n) if k not in led and zero(lesson, lesson.slopes[k]))


def reduced(lesson: Lesson, chosen: Chosen) -> Reduced | None:
    """Return the one freedom that is left; None where there are more, or none, or time acts."""
    state, graph = lesson.state, lesson.graph
    led, cyclic = led_by(lesson), cyclic_of(lesson)
    left = [k for k in range(state.n) if k not in (*led, *cyclic)]
    if len(left) != 1 or (led and cyclic) or len(state.q) != state.n:
        return None
    if not all(zero(lesson, lesson.slopes[k]) for k in led):
        return None
    motion = prescribed(lesson.scene, graph)
    known = dict(zip((state.qd[k] for k in led), motion.velocity, strict=True))
    held = {state.qd[left[0]]: graph.zero} | {state.q[k]: graph.zero for k in (*led, *cyclic)}  # L knows none of them
    (static,) = substitute([-lesson.L], known | held)
    if graph.symbol(TIME) in reachable([static, *motion.velocity]):
        return None
    try:
        momenta = np.array(chosen.of(*(lesson.momenta[k] for k in cyclic)))
    except NoValueError:
        return None
    return Reduced(lesson, chosen, left[0], cyclic, led, static, momenta)


AMPLITUDES = (10, 30, 60, 90)
"""Degrees."""

EVEN = 1e-6
"""Of a ratio of periods: less is none."""

PARTS = 400
"""Of the integral for a period."""


def swings_step(lesson: Lesson, left: Reduced) -> Step | None:
    """Return periods of swings of finite amplitude about the valley, over that of small ones."""
    if not left.turns:
        return None
    if told := elsewhere(lesson, "swings"):
        return Step("swings", told, ())
    valleys = [one for one in left.level(-math.pi, math.pi) if one[1] > 0]
    if not valleys:
        return None
    place, curvature, m = min(valleys, key=lambda one: (abs(one[0]) > EVEN, one[0] < 0, abs(one[0])))
    small = 2 * math.pi * math.sqrt(m / curvature)
    rows, ratios, over = [], [], list[Block]()
    for degrees in AMPLITUDES:
        taken = swing(left, place, math.radians(degrees))
        if taken is None:
            over = [lesson.say("swings.over", amplitude=f"{degrees}°", place=_angle(lesson, place))]
            break
        ratios.append(taken / small)
        rows.append((f"{degrees}°", f"{lesson.written(taken)} s", lesson.written(taken / small)))
    if not rows:
        return None
    table = lesson.table(("swings.amplitude", "swings.period", "swings.ratio"), rows)
    key = "longer" if min(ratios) > 1 + EVEN else "shorter" if max(ratios) < 1 - EVEN else "other"
    claim = lesson.say(f"swings.{key}", q=named(left.q), place=_angle(lesson, place), period=f"{lesson.about(small)} s")
    return Step("swings", claim, (table, *over), lesson.say("swings.reason"), show=("phase", "plots"))


def _angle(lesson: Lesson, place: float) -> str:
    return "π" if abs(place - math.pi) < EVEN else f"{lesson.about(place if abs(place) > EVEN else 0.0)} rad"


def swing(left: Reduced, place: float, amplitude: float) -> float | None:
    """Return the period of a swing from `place + amplitude`, s, T = 2 ∫ √(m/(2 (E - V))) dr; None beyond its valley.

    With r = middle + half sin s the integrand has no end at which it is infinite, and equal steps converge fast.
    """
    E = float(left.at(np.array([place + amplitude]))[1][0])
    beyond = np.diff(left.at(place + np.linspace(0, amplitude, 101))[1])
    x = place - np.linspace(0, 2 * math.pi, 2001)
    V = left.at(x)[1]
    past = np.flatnonzero(~(E > V))
    if not len(past) or past[0] == 0 or not (np.all(beyond > 0) and np.all(np.diff(V[: past[0] + 1]) > 0)):
        return None
    low, high = float(x[past[0]]), float(x[past[0] - 1])
    for _ in range(60):
        middle = (low + high) / 2
        if E - float(left.at(np.array([middle]))[1][0]) > 0:
            high = middle
        else:
            low = middle
    other, top = (low + high) / 2, place + amplitude
    s = (np.arange(PARTS) + 0.5) * math.pi / PARTS - math.pi / 2
    half = (top - other) / 2
    m, V = left.at((top + other) / 2 + half * np.sin(s))
    if not np.all(E - V > 0):
        return None
    return float(2 * np.sum(np.sqrt(m / (2 * (E - V))) * half * np.cos(s)) * math.pi / PARTS)


# The parameter that crosses a threshold which a sentence states

SPAN = 10.0
"""How many times its value, and what part of it, a threshold may be."""

TRIED = 200


def at_bound(lesson: Lesson, chosen: Chosen, value: Form) -> Try | None:
    """Return where |value| = 1 as one parameter changes, a rate before all others; None for what has no such place.

    The value is of parameters alone, such as g/(R Ω²), the cosine of a place that exists where this is below one.
    """
    parameters = {one.name: one for one in lesson.scene.parameters}
    names = list(dict.fromkeys(value.symbols))
    if not names or not set(names) <= set(parameters):
        return None
    node = value.express(lesson.graph)
    for name in sorted(names, key=lambda one: parameters[one].unit != "rad/s"):
        symbol = lesson.graph.symbol(name)
        (now,) = chosen.of(symbol)
        found = _crossing(chosen, node, symbol, now) if now else None
        if found is not None:
            return Try(name, found, parameters[name].unit)
    return None


def _crossing(chosen: Chosen, node: Expr, symbol: Expr, now: float) -> float | None:
    """Return the value of a symbol nearest to `now` at which |node| passes one."""

    def off(power: float) -> float:
        try:
            return abs(chosen.with_values({symbol: now * SPAN**power}).of(node)[0]) - 1
        except (SymdynError, ArithmeticError):
            return math.nan

    powers = [k / TRIED for k in range(-TRIED, TRIED + 1)]
    values = [off(power) for power in powers]
    pairs = [k for k in range(2 * TRIED) if values[k] * values[k + 1] < 0]
    if not pairs:
        return None
    low, high = (powers[min(pairs, key=lambda k: abs(powers[k])) + k] for k in (0, 1))
    rises = off(high) > 0
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (low, middle) if (off(middle) > 0) == rises else (middle, high)
    return float(now * SPAN ** ((low + high) / 2))
