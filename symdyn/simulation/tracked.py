"""Coordinates along paths of points and frames: on one branch, through singular places, as far as they lead.

    A, σ, r      path_equations.py

Newton's method starts at the place before, moved by u h + u̇ h²/2. A step is cut until the method hardly corrects it, so
that a branch is kept however far samples are apart. Where σ vanishes branches meet. Coordinates that are smooth go
through, and det(A⁺ A') < 0 across such a place tells that the branch has changed; no step ends so near that digits are
lost. A sample there is taken from polynomials through eight places around it, and must fulfil the equations; one that
is only near, and has no better ones around, is as it is, and told.
Where coordinates would have to jump, or the path leaves what can be reached, rows end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.simulation.following import CLOSED
from symdyn.simulation.path_equations import AGREED, PathEquations, PathPlace

CLEAR = 1e-2
"""σ over its usual size below which a sample loses digits."""

AVOIDED = 1e-3
"""The same, below which no step ends."""

FAR, CORRECTED = 0.3, 0.05
"""How far a step may go, rad or characteristic lengths; how much of it Newton's method may correct."""

AROUND = 1.0
"""How far places around a sample may go, rad or characteristic lengths."""

SHORTEST = 1e-10
"""Steps below it, over the size of the time, lead nowhere."""

NODES = np.array([-4, -3, -2, -1, 1, 2, 3, 4])


@dataclass(frozen=True)
class Passed:
    """A singular place that was gone through, to another branch."""

    t: float
    q: Array


class Stuck(Exception):  # noqa: N818  an end, not a fault
    """No place follows on this branch."""

    def __init__(self, here: PathPlace) -> None:
        super().__init__()
        self.here = here


class Branch:
    """Places along a path that smooth coordinates come to."""

    def __init__(self, equations: PathEquations, span: tuple[float, float]) -> None:
        """Take the equations and the first and last time at which paths and laws are known."""
        self.equations, self.span = equations, span
        self.passed: list[Passed] = []

    def on(self, here: PathPlace, t: float) -> PathPlace:
        """Return the place at t, later or earlier, that smooth coordinates come to.

        Raises:
            Stuck: they end on the way.
        """
        step = t - here.t
        while here.t != t:
            step = t - here.t if abs(step) >= abs(t - here.t) else step
            found = next((one for one in (self._step(here, step * f, t) for f in (1.0, 0.7, 0.45)) if one), None)
            if found is None:
                step /= 4
                if abs(step) < SHORTEST * max(1.0, abs(t)):
                    raise Stuck(here)
                continue
            self._look_back(here, found)
            here, step = found, 2 * step
        return here

    def _step(self, here: PathPlace, step: float, end: float) -> PathPlace | None:
        t = end if step == end - here.t else here.t + step
        way = here.u * step + here.a * step**2 / 2
        size = float(np.abs(way[self.equations.loose] / self.equations.columns).max(initial=0.0))
        if not size <= FAR:
            return None
        guess = self.equations.moved(here.q, way)
        q = self.equations.placed(t, guess)
        if (
            q is None
            or float(np.abs(q - guess).max(initial=0.0))
            > CORRECTED * size * self.equations.columns.max(initial=1.0) + 1e-9
        ):
            return None
        try:
            found = self.equations.place(t, q)
        except SimulateError:
            if t != end:
                return None
            found = PathPlace(t, q, here.u, here.a, self.equations.scaled(self.equations.matrix(t, q)), 0.0)
        return None if found.clear < AVOIDED and t != end else found

    def _look_back(self, one: PathPlace, other: PathPlace) -> None:
        """Remember a singular place between two."""
        if self.equations.left or other.clear < AVOIDED or one.clear < AVOIDED or not self.equations.rank:
            return
        back = np.linalg.pinv(one.A)
        if np.linalg.det(back @ other.A) > 0:
            return
        from scipy.interpolate import BPoly
        from scipy.optimize import brentq

        places = sorted((one, other), key=lambda place: place.t)
        ends = [p.t for p in places]
        H = [self.equations.functions("kinematics", p.q, self.equations.following.still) for p in places]
        curve = BPoly.from_derivatives(ends, [[p.q, h @ p.u] for p, h in zip(places, H, strict=True)])

        def side(t: float) -> float:
            return float(np.linalg.det(back @ self.equations.scaled(self.equations.matrix(t, curve(t)))))

        t = float(brentq(side, ends[0], ends[1], xtol=1e-12)) if side(ends[0]) * side(ends[1]) < 0 else sum(ends) / 2
        if not any(abs(t - known.t) < 1e-5 * max(1.0, abs(t)) for known in self.passed):
            self.passed.append(Passed(t, np.asarray(curve(t))))

    def sampled(self, here: PathPlace, t: float) -> tuple[PathPlace, PathPlace]:
        """Return the place at t, and one to go on from.

        Raises:
            Stuck: coordinates are not smooth there, or end on the way.
        """
        found = self.on(here, t)
        if found.clear >= CLEAR:
            return found, found
        rate = max(1e-3, abs(here.clear - found.clear) / max(1e-12, abs(t - here.t)))
        gap = 2 * CLEAR / rate
        fast = float(np.abs(found.u[self.equations.loose] / self.equations.columns).max(initial=0.0))
        for _ in range(4):
            if t - 4 * gap < self.span[0] or t + 4 * gap > self.span[1] or 4 * gap * fast > AROUND:
                break
            try:
                return self._through(here, t, gap)
            except Stuck:
                gap *= 2
        if found.clear < AVOIDED:
            raise Stuck(here)
        return found, found

    def _through(self, here: PathPlace, t: float, gap: float) -> tuple[PathPlace, PathPlace]:
        """Return the place at t by those around it, and the last of these."""
        nodes, now = [], here
        for k in NODES:
            now = self.on(now, t + k * gap)
            nodes.append(now)
        if min(one.clear for one in nodes) < CLEAR:
            raise Stuck(here)
        return self._between(nodes, t, here), now

    def _between(self, nodes: Sequence[PathPlace], t: float, here: PathPlace) -> PathPlace:
        """Return what polynomials through places say in their middle."""
        from scipy.interpolate import BarycentricInterpolator

        gap = np.array([one.t - t for one in nodes])
        q, u, a = (
            np.asarray(BarycentricInterpolator(gap, np.array([getattr(one, part) for one in nodes]))(0.0))
            for part in ("q", "u", "a")
        )
        q = self.equations.numbers.normalised(q)
        q[self.equations.following.places] = self.equations.following.at(t)[0]
        A = self.equations.matrix(t, q)
        sizes = [max(1.0, float(np.abs(x).max(initial=0.0))) for x in (q, u, a)]
        off = (self.equations.missed(t, q), A @ u - self.equations.first(t), A @ a - self.equations.second(t, q, u))
        allowed = (10 * CLOSED, AGREED, 100 * AGREED)
        if any(
            float(np.abs(x).max(initial=0.0)) > most * size for x, most, size in zip(off, allowed, sizes, strict=True)
        ):
            raise Stuck(here)
        return PathPlace(t, q, u, a, self.equations.scaled(A), 0.0)
