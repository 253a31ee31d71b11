"""Coordinates that follow paths of points and frames, with laws of coordinates beside them.

If there are several solutions, the coordinates next to the guess are taken at the first time. Messages say when, where,
and what would help. From there coordinates stay on one branch, through singular places, as far as they lead:

    A, σ, r      path_equations.py

Newton's method starts at the place before, moved by u h + u̇ h²/2. A step is cut until the method hardly corrects it,
so that a branch is kept however far samples are apart. Where σ vanishes branches meet. Smooth coordinates go through;
det(A⁺ A') < 0 across such a place shows that the branch has changed, and no step ends so near that digits are lost. A
sample there is taken from polynomials through eight places around it, and must fulfil the equations. One that is only
near, with no better ones around, stays as it is and is reported. Where coordinates would have to jump, or the path
leaves what can be reached, rows end.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.dynamics.loops import direction_words
from symdyn.errors import DerivationError, SimulateError
from symdyn.frozen import dataclass
from symdyn.scene.values import velocity_name
from symdyn.simulation.following import CLOSED, GUESSES, Followed, Following, Known, Tied
from symdyn.simulation.initial import no_equations
from symdyn.simulation.integrate.integration import END
from symdyn.simulation.path_equations import AGREED, PathEquations, PathPlace
from symdyn.simulation.prescribed.point_path import Approach, ScenePath

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
        guess = self.equations.retract(here.q, way)
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


NEAR = 0.3
"""How far from a guess Newton's method may end, rad or m, to be believed to be on its branch."""

SMALL = 1e-3
"""Parts of a direction that are not told."""


def _way_out() -> str:
    other = f"begin on another branch ({argument('start')})"
    return f"keep the path away from there, {other}, or leave a component free (_)"


@np.errstate(all="ignore")  # numbers that no double holds are looked for, and told
def along(
    tied: Tied,
    given: Sequence[str],
    laws: Known,
    quasi: Mapping[int, Known],
    path: ScenePath,
    rates: Callable[[Array, Array], dict[str, Array]],
    t: Array,
    guess: Array,
) -> Followed:
    """Return what follows at times, as far as it goes.

    Args:
        tied: the mechanism and its functions, those of "pose", "jacobian" and "jdot_qdot" of what has a path too.
        given: names of the coordinates with a law.
        laws: of these, as of `followed`.
        quasi: laws of velocities that are no rates of coordinates.
        path: of points and frames.
        rates: rates of "kinematics", "constraint_jacobian" and every "jacobian" at q and u, asked for where freedoms
            are left.
        t: times, s, ascending.
        guess: coordinates, shape (nq,).

    Raises:
        SimulateError: the path is out of reach at the first time, or begins at a singular place.
    """
    equations = PathEquations(Following(tied, given, laws, quasi), path.points, rates)
    first, notes = _first(equations, float(t[0]), guess)
    notes = [*notes, *_left(equations, first)]
    no_equations(equations.numbers, first.q)
    rows, more, stopped = (_integrated if equations.integrating else _continued)(equations, first, t, path.span)
    q, u, a = (np.array([getattr(row, part) for row in rows]) for part in ("q", "u", "a"))
    off = np.array([float(np.abs(equations.missed(row.t, row.q)).max(initial=0.0)) for row in rows])
    return Followed(q, u, a, off, (*notes, *more), stopped)


def _first(equations: PathEquations, t: float, guess: Array) -> tuple[PathPlace, list[str]]:
    """Return the place at the first time that is next to a guess, and what is said of it."""
    equations.looked_at(t, guess)
    notes: list[str] = []
    q = equations.placed(t, guess)
    if q is None or float(np.abs(q - guess).max(initial=0.0)) > NEAR:
        walked = _walked(equations, t, guess)
        q = q if walked is None else walked
    if q is None:
        drawn = [equations.numbers.drawn(seed) for seed in range(GUESSES)]
        found = [one for one in (equations.placed(t, near) for near in drawn) if one is not None]
        if not found:
            ends = [equations.nearest(t, near) for near in (guess, *drawn[:8])]
            best = min(ends, key=lambda end: end[1])[0]
            raise SimulateError(f"path: t = {t:g} s: out of reach: {_misses(equations, t, best)}; {_reach(equations)}")
        q = min(found, key=lambda one: float(np.abs(np.sin((one - guess) / 2)).max(initial=0.0)))
        notes.append(f"path: nothing is found from the start; one of random guesses is taken: give {argument('start')}")
    q = _turned_back(equations, t, q, guess)
    equations.looked_at(t, q)
    if equations.clear(equations.matrix(t, q)) < AVOIDED and not equations.left:
        raise SimulateError(
            f"path: t = {t:g} s: it begins at a singular place, {_singular(equations, t, q)}; "
            f"begin elsewhere, on another branch ({argument('start')}), or leave a component free (_)"
        )
    return equations.place(t, q), notes


def _walked(equations: PathEquations, t: float, guess: Array) -> Array | None:
    """Return the first place on the branch of a guess: its frames go straight there; None where that leads nowhere."""
    following, numbers, still = equations.following, equations.numbers, equations.following.still
    wanted = following.at(t)[0]
    q = guess.copy()
    q[following.places] = wanted
    names = list(numbers.scene.velocities)
    held = [velocity_name(name) for name in following.given]
    try:
        if following.holding.any():
            q = numbers.newton(q, [names.index(name) for name in held if name in names])
            if not numbers.is_closed(q):
                return None
        ways = []
        for path, asked in equations.requested(t):
            T = equations.functions(f"pose:{path.name}", q, still)
            ways.append(Approach(path.name, path.rows, asked, T[:, :3], T[:, 3]))
        rest = Following(following.tied, following.given, lambda s: _resting(wanted, len(s)), {})
        walk = PathEquations(rest, ways, equations.rates)
        walk.looked_at(0.0, q)
        branch, here = Branch(walk, (0.0, 1.0)), walk.place(0.0, q)
        end = branch.on(here, 1.0) if here.clear > AVOIDED else None
    except (Stuck, SimulateError, DerivationError):
        return None
    return None if end is None or branch.passed else equations.placed(t, end.q)


def _resting(q: Array, count: int) -> tuple[Array, Array, Array]:
    still = np.zeros((count, len(q)))
    return still + q, still, still


def _turned_back(equations: PathEquations, t: float, q: Array, guess: Array) -> Array:
    """Return a place with the turns that change nothing taken back, next to a guess."""
    allowed = CLOSED * max(1.0, equations.length)
    for k, turns in enumerate(np.round((q - guess) / (2 * np.pi))):
        tried = q.copy()
        tried[k] -= 2 * np.pi * turns
        if turns and float(np.abs(equations.missed(t, tried)).max(initial=0.0)) <= allowed:
            q = tried
    return q


def _left(equations: PathEquations, first: PathPlace) -> list[str]:
    """Return which coordinates rest, and what chooses where freedoms are left."""
    notes, following = [], equations.following
    resting = [name for name in following.names_of(equations.idle.tolist()) if name not in following.given]
    if resting:
        notes.append(f"no law is given for {', '.join(resting)}, which {equations.names} does not depend on: at rest")
    if equations.left:
        free = [name for name in following.names_of(equations.loose.tolist()) if name not in following.given]
        more = "1 freedom is" if equations.left == 1 else f"{equations.left} freedoms are"
        notes.append(
            f"path: {more} left: the velocities of {', '.join(free)} are those with the least sum of squares; or give "
            f"{'a law' if equations.left == 1 else f'{equations.left} laws'} beside, such as "
            f"{argument('motion', {free[-1]: 0.3})}"
        )
    return notes


def _continued(
    equations: PathEquations, first: PathPlace, t: Array, span: tuple[float, float]
) -> tuple[list[PathPlace], list[str], str]:
    """Return places at times, notes of singular ones, and why they end."""
    branch, here, rows, stopped = Branch(equations, span), first, [first], END
    for k, now in enumerate(t[1:].tolist(), start=1):
        try:
            row, here = branch.sampled(here, now)
        except Stuck as stuck:
            stopped = _stopped(equations, stuck.here, t[k : k + 2])
            break
        rows.append(row)
    last = rows[-1].t
    notes = [
        f"path: t = {one.t:.6g} s: through a singular place to another branch, {_singular(equations, one.t, one.q)}"
        for one in sorted(branch.passed, key=lambda one: one.t)
        if one.t <= last or stopped == END
    ]
    near = min((row for row in rows), key=lambda row: row.clear if row.clear > 0 else 1.0)
    if 0 < near.clear < CLEAR and not branch.passed:
        notes.append(f"path: t = {near.t:.6g} s: near a singular place, {_singular(equations, near.t, near.q)}")
    return rows, notes, stopped


def _integrated(
    equations: PathEquations, first: PathPlace, t: Array, span: tuple[float, float]
) -> tuple[list[PathPlace], list[str], str]:
    """Return the same where positions follow from velocities alone."""
    rows, stopped, way = [first], END, equations.integrated(t, first)
    try:
        next(way)
        for k, now in enumerate(t[1:].tolist(), start=1):
            q = equations.placed(now, next(way))
            if q is None:
                stopped = _stopped(equations, rows[-1], t[k : k + 2])
                break
            rows.append(equations.place(now, q))
    except SimulateError as fault:
        stopped = f"{fault}; {_way_out()}"
    near = min(rows, key=lambda row: row.clear)
    said = f"path: t = {near.t:.6g} s: near a singular place, {_singular(equations, near.t, near.q)}"
    return rows, [said] if near.clear < CLEAR else [], stopped


# Words


def _stopped(equations: PathEquations, here: PathPlace, ahead: Array) -> str:
    """Return why a path ends at a place, on the way to the times that are next."""
    for t in ahead.tolist():
        best, off = equations.nearest(t, here.q)
        if off > 10 * CLOSED * max(1.0, equations.length):
            return (
                f"path: t = {here.t:.6g} s: it goes out of reach there: at t = {t:.6g} s "
                f"{_misses(equations, t, best)}; {_reach(equations)}"
            )
    return (
        f"path: t = {here.t:.6g} s: singular: the coordinates cannot go on smoothly, "
        f"{_singular(equations, here.t, here.q)}; {_way_out()}"
    )


def _reach(equations: PathEquations) -> str:
    beside = f", or other laws of {', '.join(equations.following.given)}" if equations.following.given else ""
    return f"give a path nearer to where {equations.names} can be{beside}"


def _misses(equations: PathEquations, t: float, q: Array) -> str:
    """Return how far points and frames are from their paths at a position."""
    found, still, scene = [], equations.following.still, equations.following.scene
    for path, asked in equations.requested(t):
        T = equations.functions(f"pose:{path.name}", q, still)
        off = asked.residual(T[:, :3], T[:, 3])
        held = np.isfinite(asked.origin)
        gap, turn = (float(np.linalg.norm(x)) for x in (off[: held.sum()], off[held.sum() :]))
        place = ", ".join("_" if not known else f"{x:.6g}" for x, known in zip(asked.origin, held, strict=True))
        parts = [f"({place}) by {scene.in_shown_unit(f'{gap:.6g}', 'm')}"] * (gap > CLOSED)
        parts += [f"its turning by {scene.in_shown_unit(f'{turn:.6g}', 'rad')}"] * (turn > CLOSED)
        if parts:
            found.append(f"{path.name} misses {' and '.join(parts)}")
    loops = float(np.abs(equations.functions("constraint_residual", q, still)).max(initial=0.0))
    if loops > 1e-6:
        found.append(f"the loops are open by {loops:.3g}")
    return ", ".join(found) or "nothing is missed"


def _singular(equations: PathEquations, t: float, q: Array) -> str:
    """Return what cannot move and which coordinates move without it, at a singular place."""
    A = equations.scaled(equations.matrix(t, q))
    U, _, Vt = np.linalg.svd(A)
    k = equations.rank - 1
    y, way = U[:, k] / equations.row_sizes, Vt[k]
    first, found = len(A) - sum(path.rows for path in equations.paths), []
    for path, asked in equations.requested(t):
        wrench = asked.S.T @ y[first : first + path.rows]
        first += path.rows
        force, moment = wrench[:3] * equations.length, wrench[3:]  # what it can do does no work on them
        low = SMALL * max(float(np.linalg.norm(force)), float(np.linalg.norm(moment)), SMALL)
        line, axis = ("" if np.linalg.norm(one) <= low else direction_words(_rounded(one)) for one in (force, moment))
        if line and axis:
            found.append(f"{path.name} turns about {axis} only as it moves along {line}")
        elif line or axis:
            found.append(f"{path.name} cannot {'move along' if line else 'turn about'} {line or axis}")
    shares = np.abs(way) / np.abs(way).max(initial=1e-300)
    names = equations.following.names_of([int(one) for one, x in zip(equations.loose, shares, strict=True) if x > 1e-3])
    where = ", ".join(f"{name} = {x + 0.0:.6g}" for name, x in zip(equations.numbers.scene.coordinates, q, strict=True))
    return f"at {where}: {', '.join(found) or 'its loops open a freedom'}, and {', '.join(names)} can move without it"


def _rounded(vector: Array) -> Array:
    unit = vector / np.linalg.norm(vector) * np.sign(vector[np.argmax(np.abs(vector))])  # a line has no sense
    return np.where(np.abs(unit) < 1e-4, 0.0, unit)
