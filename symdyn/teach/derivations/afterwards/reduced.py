"""One freedom that is left when others are cyclic or led: its inertia m and its potential V, so that ½ m ṙ² + V stays.

    c     cyclic coordinates, their momenta p kept          m = M_rr - M_rc M_cc⁻¹ M_cr,  V = P + ½ pᵀ M_cc⁻¹ p
    led   prescribed, at constant rates Ω, L without them   m = M_rr,                     V = P - ½ Ωᵀ M_LL Ω

Without either, m is the mass and V = P. Drives and friction are left out.

Reference: Routh; Goldstein, Classical Mechanics, 8.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.dynamics.mechanism import TIME, prescribed
from symdyn.errors import DerivationError, NoValueError
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute
from symdyn.scene import SceneUnits
from symdyn.teach.lesson import Lesson
from symdyn.teach.shown_state import Chosen

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
    def couples(self) -> bool:
        """Whether the others have a say: their inertia depends on it."""
        lesson = self.lesson
        (kinetic,) = substitute([lesson.energy.K], {lesson.state.qd[self.r]: lesson.graph.zero})
        return not zero(lesson, gradient(kinetic, [self.q])[0])

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return m and V at places, each of the shape of x; what has no value there is NaN or infinite.

        V is NaN where m is negative: numbers that no bodies have, and no motion near such a place is told.
        """
        lesson, others = self.lesson, [self.r, *self.cyclic]
        M = [gradient(p, lesson.state.qd) for p in lesson.momenta]
        entries = [M[i][j] for i in others for j in others]
        potential = self.static if self.led else lesson.energy.P
        values = {**self.chosen.values, self.q: x}
        with np.errstate(all="ignore"):
            found = evaluate([*entries, potential], Batches(), values)
            shaped = [np.broadcast_to(np.asarray(one, dtype=np.float64), x.shape) for one in found]
            n, V = len(others), shaped[-1]
            matrix = np.stack(shaped[:-1], axis=-1).reshape(*x.shape, n, n)
            m = matrix[..., 0, 0]
            if n > 1:
                inner, beside = matrix[..., 1:, 1:], matrix[..., 1:, 0]
                inverse = np.linalg.pinv(np.where(np.isfinite(inner), inner, 0.0), rcond=1e-14)
                m = m - np.einsum("...i,...ij,...j", beside, inverse, beside)
                V = V + 0.5 * np.einsum("i,...ij,j", self.momenta, inverse, self.momenta)
                V = np.where(np.linalg.cond(inner) < 1e13, V, np.inf)
        return m, np.where(m < 0, np.nan, V)

    def rates(self, x: float) -> Array:
        """Return the rates of cyclic coordinates when r rests at a place, shape (len(cyclic),)."""
        M = [gradient(p, self.lesson.state.qd) for p in self.lesson.momenta]
        entries = [M[i][j] for i in self.cyclic for j in self.cyclic]
        values = self.chosen.moved({self.q: x}).of(*entries)
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
    return lesson.scene.led_velocities


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
