"""The function `excite`: a motion from which base parameters of a mechanism are best identifiable, within its limits.

Many motions are drawn (Sobol's sequence, moved at random), each scaled into the limits of positions and speeds; the
best are improved, and the best of those that keep all limits between samples too is returned.

    z       coefficients, shape (k, n): k functions of time for each of n coordinates, in parts of half their range
    A       stacked rows of the base regressor over the noise of each drive and √N, shape (N, n, p)
    g       how far each bounded number is outside, in parts of half its range, shape (N, bounds); <= 0 inside

Minimised is criterion(A) + 1/(2 ρ) Σ (max(0, λ + ρ g)² - λ²)/N, an augmented Lagrangian whose multipliers λ and weight
ρ grow from round to round, by L-BFGS. Slopes are exact: of A by the regressor's own backward derivative, of forces by
that of inverse dynamics, of points by their Jacobians; each is one call for all N instants.

Reference: Nocedal and Wright, Numerical optimization (2006), 17.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import checked, native
from symdyn.errors import IdentifyError, SimulateError, choice, suggestion
from symdyn.frozen import dataclass
from symdyn.identification.bounds import Bound, Box, fits, read_bounds, usual_notes
from symdyn.identification.excitation import CRITERIA, FAMILIES, Basis, Criterion, Excitation, Improved, Reached
from symdyn.runtime import Loaded, load
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.scene.values import Faults
from symdyn.simulation import Start, Trajectory
from symdyn.simulation.prescribed import drive_names

ROUNDS, STEPS = 6, 40
"""Rounds of multipliers, and steps of L-BFGS in each."""

WEIGHT, HEAVIER = 100.0, 2.0
"""Of what is outside: at first, and times as much in every round."""

SAME = 1e-9
"""Singular value of the regressor at random positions, over the largest, of a direction that no motion identifies."""

PLACES = 200


@dataclass(frozen=True)
class Motion:
    """A motion at N instants.

    Attributes:
        q, u, a: positions, velocities, accelerations, shape (N, n) each.
    """

    q: Array
    u: Array
    a: Array


class Functions:
    """The compiled functions of a scene that the search calls.

    Attributes:
        bounds: what must be kept.
        noise: standard deviation of each drive's force, shape (n,).
        directions: combinations of base parameters that are identifiable, shape (columns, p).
    """

    def __init__(self, scene: Scene, bounds: Sequence[Bound], noise: Array, seed: int) -> None:
        points = sorted({one.index // 3 for one in bounds if one.kind == "place"})
        self.points = {k: scene.points[k].name for k in points}
        self.forced = any(one.kind == "force" for one in bounds)
        names = ["base_regressor", "base_regressor_vjp", "inverse_dynamics"]
        names += ["inverse_dynamics_vjp"] if self.forced else []
        names += [f"{what}:{name}" for name in self.points.values() for what in ("pose", "jacobian")]
        self.calls: Loaded = load(scene, names)
        self.bounds, self.noise = tuple(bounds), noise
        n = len(scene.velocities)
        drawn = np.random.default_rng(seed).uniform(-1, 1, (3, PLACES, n))
        Y = self.calls["base_regressor"](*(drawn * np.pi))
        size, V = np.linalg.svd(Y.reshape(-1, Y.shape[-1]))[1:]
        rank = int((size > SAME * size[0]).sum()) if size.size and size[0] > 0 else 0
        self.directions, self.fewer = V[:rank].T, rank < len(V)

    def rows(self, motion: Motion) -> Array:
        Y = self.calls["base_regressor"](motion.q, motion.u, motion.a)
        scale = np.sqrt(len(motion.q)) * self.noise[:, None]
        return np.asarray(np.matmul(Y, self.directions) / scale if self.fewer else Y / scale)

    def back(self, motion: Motion, slope: Array) -> tuple[Array, Array, Array]:
        """Return slopes by q, u and a, shape (N, n) each, of a number whose slope by A is given."""
        N, n = motion.q.shape
        weights = (np.matmul(slope, self.directions.T) if self.fewer else slope) / self.noise[:, None] / np.sqrt(N)
        found = self.calls["base_regressor_vjp"](motion.q, motion.u, motion.a, weights.reshape(N, -1))
        return found[:, :n], found[:, n : 2 * n], found[:, 2 * n :]

    def forces(self, motion: Motion) -> Array:
        """Return driving forces, shape (N, n)."""
        return np.asarray(self.calls["inverse_dynamics"](motion.q, motion.u, motion.a))

    def bounded(self, motion: Motion) -> Array:
        """Return the numbers that have bounds, shape (N, bounds)."""
        known = {"position": motion.q, "velocity": motion.u, "acceleration": motion.a}
        known |= {"force": self.forces(motion)} if self.forced else {}
        if self.points:
            known["place"] = np.zeros((len(motion.q), 3 * (max(self.points) + 1)))
            for k, name in self.points.items():
                known["place"][:, 3 * k : 3 * k + 3] = self.calls[f"pose:{name}"](motion.q)[..., 3]
        return np.stack([known[one.kind][:, one.index] for one in self.bounds], axis=1)

    def bounded_back(self, motion: Motion, slope: Array) -> tuple[Array, Array, Array]:
        """Return slopes by q, u and a of a number whose slope by what has bounds is given, shape (N, bounds)."""
        N, n = motion.q.shape
        parts = {kind: np.zeros((N, n)) for kind in ("position", "velocity", "acceleration", "force")}
        parts["place"] = np.zeros((N, 3 * (max(self.points, default=-1) + 1)))
        for k, one in enumerate(self.bounds):
            parts[one.kind][:, one.index] += slope[:, k]
        q, u, a = parts["position"], parts["velocity"], parts["acceleration"]
        if self.forced:
            found = self.calls["inverse_dynamics_vjp"](motion.q, motion.u, motion.a, parts["force"])
            q, u, a = q + found[:, :n], u + found[:, n : 2 * n], a + found[:, 2 * n :]
        for k, name in self.points.items():
            J = self.calls[f"jacobian:{name}"](motion.q)[:, :3]
            q = q + np.einsum("ki,kij->kj", parts["place"][:, 3 * k : 3 * k + 3], J)
        return q, u, a


class Search:
    """The objective function, at N instants of a period."""

    def __init__(self, functions: Functions, basis: Basis, criterion: Criterion) -> None:
        """Keep what does not change: coordinates are middle + half Φ z."""
        self.functions, self.basis, self.criterion = functions, basis, criterion
        bounds = functions.bounds
        rooms = sorted((one for one in bounds if one.kind == "position"), key=lambda one: one.index)
        self.middle = np.array([(one.low + one.high) / 2 for one in rooms])
        self.half = np.array([one.size for one in rooms])
        size = np.array([one.size for one in bounds])
        self.ends = [(np.array([getattr(one, end) for one in bounds]), sign / size) for end, sign in
                     (("high", 1.0), ("low", -1.0))]  # fmt: skip

    def motion(self, z: Array, basis: Basis | None = None) -> Motion:
        """Return the motion of coefficients (k, n), or of several, (P, k, n), at P times as many instants."""
        one = basis or self.basis
        found = [np.matmul(part, z * self.half) for part in (one.position, one.rate, one.second)]
        return Motion(*(part.reshape(-1, len(self.half)) for part in (found[0] + self.middle, *found[1:])))

    def outside(self, motion: Motion) -> Array:
        """Return g, above and then below, shape (N, 2 bounds); -inf where there is no end."""
        x = self.functions.bounded(motion)
        return np.hstack([(x - end) * scale for end, scale in self.ends])

    def value(self, z: Array) -> float:
        """Return the criterion as a user is shown it."""
        return self.criterion.value(self.functions.rows(self.motion(z)))

    def slope(self, z: Array, multipliers: Array, weight: float, margin: float) -> tuple[float, Array]:
        """Return what is minimised, and its slope by z, (k, n)."""
        motion = self.motion(z)
        value, slope = self.criterion.slope(self.functions.rows(motion))
        pressed = np.maximum(0.0, multipliers + weight * (self.outside(motion) + margin))
        N, half = len(pressed), len(self.functions.bounds)
        value += float((pressed**2 - multipliers**2).sum()) / (2 * weight * N)
        pushed = (pressed[:, :half] * self.ends[0][1] + pressed[:, half:] * self.ends[1][1]) / N
        parts = zip(self.functions.back(motion, slope), self.functions.bounded_back(motion, pushed), strict=True)
        q, u, a = (one + other for one, other in parts)
        found = self.basis.position.T @ q + self.basis.rate.T @ u + self.basis.second.T @ a
        return value, found * self.half

    def minimum(self, z: Array, margin: float, report: Callable[[float], None] = lambda part: None) -> Array:
        """Return coefficients next to z at which no number is nearer to a bound than `margin`, as far as that goes."""
        from scipy.optimize import minimize

        multipliers = np.zeros((len(self.basis.position), 2 * len(self.functions.bounds)))
        weight = WEIGHT
        for turn in range(ROUNDS):
            options: Any = {"maxiter": STEPS, "maxcor": 20}
            more = (z.shape, multipliers, weight, margin)
            z = minimize(self._flat, z.ravel(), more, "L-BFGS-B", True, options=options).x.reshape(z.shape)
            multipliers = np.maximum(0.0, multipliers + weight * (self.outside(self.motion(z)) + margin))
            weight *= HEAVIER
            report((turn + 1) / ROUNDS)
        return z

    def _flat(self, x: Array, shape: tuple[int, int], *more: Any) -> tuple[float, Array]:
        value, slope = self.slope(x.reshape(shape), *more)
        return value, slope.ravel()


DRAWN = 256
"""Motions that are drawn."""

SAMPLES = 20
"""Instants a term at which the criterion is looked at, of a period."""

FINE = 20
"""Times as many instants at which limits are looked at in the end."""

MARGIN, TRIES = 0.005, 4
"""Distance from limits, in parts of half their range, that the search keeps; more where that is too little."""

NEAR = 0.02
"""Distance at which a limit is one that a motion goes to."""

SHOWN = ("condition", "scaled_condition", "determinant")

MOST_ROWS = 1_000_000


@checked(IdentifyError)
def excite(
    scene: SceneLike,
    period: float = 10.0,
    family: str = "fourier",
    terms: int = 5,
    criterion: str = "condition",
    box: Box = (),
    noise: Mapping[str, float] | None = None,
    starts: int = 4,
    seed: int = 0,
    every: float = 0.01,
    values: Mapping[str, object] | None = None,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Excitation:
    """Return a periodic motion from which base parameters are well identifiable, and which keeps its limits.

    The same arguments give the same motion, digit by digit, on the same machine.

    >>> import symdyn
    >>> from symdyn.identification import excite
    >>> found = excite(symdyn.example("two_link"), period=4, terms=3, starts=1, every=0.1,
    ...     values=dict(m1=1, m2=1, h1=1, h2=1, g=9.81), box={"M1": (-40, 40)})
    >>> bool(abs(found.tau[:, 0]).max() < 40)
    True

    Args:
        scene: the mechanism, without loops, every joint driven.
        period: of the motion, s.
        family: what it is a sum of, "fourier" or "splines".
        terms: rounds a period of the fastest of a Fourier series; splines have as many coefficients.
        criterion: what judges it, "condition", "scaled_condition" or "determinant".
        box: more limits, {"tool.z": (0.1, None), "tau2": (-40, 40)} or ["tool.z=0.1..", "tau2=-40..40"]: of
            coordinates, velocities, accelerations, driving forces and places of declared points, in ground axes; they
            narrow those that joints of the scene have.
        noise: standard deviation of the force of each drive, by its name, N m or N; without, 1 each.
        starts: of the drawn motions, how many are improved.
        seed: of what is drawn.
        every: s between samples.
        values: of parameters, in place of those that the scene gives.
        progress: takes the part that is done, 0 to 1.
        say: takes notes.

    Raises:
        IdentifyError: with every fault, one line each: what cannot be moved freely, empty limits, unknown names;
            or no motion was found that keeps all limits.
        SceneError: a value that the scene cannot have, or of no parameter.
    """
    (period, every), (terms, starts, seed) = native(float, period, every), native(int, terms, starts, seed)
    scene = scene_of(scene, values)
    faults = Faults("")
    for fault in fits(scene):
        faults.add("", fault)
    bounds = () if faults.lines else _bounds(scene, box, faults)
    _check(period, family, terms, criterion, starts, seed, every, faults)
    sizes = _noise(scene, noise or {}, faults)
    faults.close(IdentifyError)
    notes = usual_notes(bounds)
    if say is not None:
        for note in notes:
            say(note)
    functions = Functions(scene, bounds, sizes, seed)
    if not functions.directions.size:
        raise IdentifyError(f"{scene.name}: no base parameter takes part in its driving forces; give bodies a mass")
    row, count = FAMILIES[family], SAMPLES * terms
    search = Search(functions, row.basis(np.arange(count) * period / count, period, terms), CRITERIA[criterion])
    fine = row.basis(np.arange(count * FINE + 1) * period / (count * FINE), period, terms)
    z, margin, improved = _best(search, fine, _drawn(search, starts, seed), progress or (lambda part: None))
    t = np.linspace(0.0, period, round(period / every) + 1)
    motion = search.motion(z, row.basis(t, period, terms))
    run = Trajectory(scene, t, motion.q, motion.u, motion.a, functions.forces(motion), {}, notes=tuple(notes))
    A = functions.rows(Motion(motion.q[:-1], motion.u[:-1], motion.a[:-1]))
    condition, scaled, determinant = (CRITERIA[name].value(A) for name in SHOWN)
    reached = _reached(search, fine, z)
    coefficients = z * search.half
    coefficients[0] += search.middle
    return Excitation(
        run=run,
        family=family,
        criterion=criterion,
        period=period,
        terms=terms,
        seed=seed,
        condition=condition,
        scaled_condition=scaled,
        determinant=determinant,
        starts=improved,
        reached=reached,
        margin=margin,
        coefficients=coefficients,
        notes=tuple(notes),
    )


def _check(
    period: float, family: str, terms: int, criterion: str, starts: int, seed: int, every: float, faults: Faults
) -> None:
    for name, given, known in (("family", family, FAMILIES), ("criterion", criterion, CRITERIA)):
        if given not in known:
            faults.add(name, f"there is no {given!r:.60}; {choice(given, known)}")
    for name, number in (("period", period), ("every", every)):
        if not (isinstance(number, (int, float)) and math.isfinite(number) and number > 0):
            faults.add(name, f"{number!r:.60} is no time; give seconds above zero")
            return
    least = FAMILIES[family].least if family in FAMILIES else 1
    for name, number, low, high in (
        ("terms", terms, least, 50),
        ("starts", starts, 1, DRAWN),
        ("seed", seed, 0, 2**63),
    ):
        if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or not low <= number <= high:
            faults.add(name, f"{number!r:.60} is not a whole number from {low} to {high}")
    if not 2 <= period / every <= MOST_ROWS:
        faults.add("every", f"{every:g} s in a period of {period:g} s are no 2 to {MOST_ROWS} rows; give another")


def _noise(scene: Scene, noise: Mapping[str, float], faults: Faults) -> Array:
    """Return the standard deviation of each drive's force, shape (nv,)."""
    names = drive_names(scene)
    found = np.ones(len(names))
    for name, size in noise.items():
        if name not in names:
            faults.add("noise", f"{name} is no drive of {scene.name}; {suggestion(name, names)}")
        elif not (isinstance(size, (int, float)) and math.isfinite(size) and size > 0):
            faults.add(f"noise: {name}", f"{size!r:.60} is no standard deviation; give N m or N above zero")
        else:
            found[names.index(name)] = size
    return found


def _bounds(scene: Scene, box: Box, faults: Faults) -> tuple[Bound, ...]:
    try:
        return read_bounds(scene, Start.guess(scene).tolist(), box, faults)
    except SimulateError as fault:
        faults.lines += fault.faults
        return ()


def _drawn(search: Search, starts: int, seed: int) -> list[Array]:
    """Return the best motions of many that are drawn, scaled into limits of positions, velocities, accelerations."""
    from scipy.stats import qmc

    basis, n = search.basis, len(search.half)
    size = basis.count * n
    points = qmc.Sobol(size, scramble=False).random(DRAWN)
    z = ((points + np.random.default_rng(seed).random(size)) % 1.0 * 2 - 1).reshape(DRAWN, basis.count, n)
    z[:, 0] *= 0.5
    waves = z.copy()
    waves[:, 0] = 0.0
    room = np.full((DRAWN, n), np.inf)
    for kind, part in (("position", basis.position), ("velocity", basis.rate), ("acceleration", basis.second)):
        largest = np.abs(np.matmul(part, waves)).max(axis=1) * search.half
        for one in search.functions.bounds:
            if one.kind == kind:
                free = (1 - np.abs(z[:, 0, one.index])) * search.half[one.index]
                low = free if kind == "position" else np.full(DRAWN, min(one.high, -one.low))
                room[:, one.index] = np.minimum(room[:, one.index], low / largest[:, one.index])
    z[:, 1:] *= 0.95 * room[:, None]
    scored = []
    for k in range(DRAWN):
        motion = search.motion(z[k])
        outside = np.maximum(0.0, search.outside(motion)).max(axis=0).sum()
        scored.append((search.criterion.slope(search.functions.rows(motion))[0] + 10 * outside, k))
    return [z[k] for _, k in sorted(scored)[:starts]]


def _best(
    search: Search, fine: Basis, drawn: Sequence[Array], report: Callable[[float], None]
) -> tuple[Array, float, tuple[Improved, ...]]:
    """Return the best motion that keeps all limits, its margin, and what became of starts; IdentifyError for none."""
    found: list[tuple[Array, float]] = []
    for k, z in enumerate(drawn):
        found.append(_kept(search, fine, z, lambda part, k=k: report((k + part) / len(drawn))))  # type: ignore[misc]
    improved = tuple(
        Improved(search.value(before), search.value(after), margin > 0)
        for before, (after, margin) in zip(drawn, found, strict=True)
    )
    keeping = [k for k, one in enumerate(improved) if one.keeps]
    if not keeping:
        nearest = max(found, key=lambda one: one[1])[0]
        outside = [
            f"{one.bound.name} goes from {one.low:.4g} to {one.high:.4g} {one.bound.unit}"
            for one in _reached(search, fine, nearest)
            if one.low < one.bound.low or one.high > one.bound.high
        ]
        raise IdentifyError(
            f"{search.functions.calls.scene.name}: no motion was found that keeps all limits; the nearest leaves "
            f"{'some: ' + ', '.join(outside) if outside else 'them only just'}; widen these, or try more starts "
            f"than {len(drawn)}"
        )
    best = min(keeping, key=lambda k: improved[k].after)
    return *found[best], improved


def _kept(search: Search, fine: Basis, z: Array, report: Callable[[float], None]) -> tuple[Array, float]:
    """Return an improved motion and its margin, which is above zero where it keeps all limits."""
    margin, found, left = MARGIN, z, -math.inf
    for tried in range(TRIES):
        found = search.minimum(z if tried == 0 else found, margin, report if tried == 0 else lambda part: None)
        left = _margin(search, fine, found)
        if left > 0:
            break
        margin += max(margin, -left)
    return found, left


def _margin(search: Search, fine: Basis, z: Array) -> float:
    """Return the least distance to a limit over the whole period, in parts of half its range.

    Between two instants a number is beyond the larger of both by an eighth of h² |second derivative| at most, which is
    taken from second differences of the fine instants.
    """
    g = search.outside(search.motion(z, fine))
    g = g[:, np.isfinite(g).all(axis=0)]
    between = np.abs(np.diff(g, n=2, axis=0)).max(axis=0, initial=0.0) / 8
    return float(-(g.max(axis=0) + between).max())


def _reached(search: Search, fine: Basis, z: Array) -> tuple[Reached, ...]:
    """Return how near a motion comes to each of its limits."""
    x = search.functions.bounded(search.motion(z, fine))
    found = []
    for one, column in zip(search.functions.bounds, x.T, strict=True):
        low, high = float(column.min()), float(column.max())
        active = min(low - one.low, one.high - high) < NEAR * one.size
        found.append(Reached(one, low, high, active))
    return tuple(found)
