"""Positions, velocities and accelerations that follow from laws of some coordinates through the constraints.

    g              coordinates with a law         q̇ = H u
    r, G           residuals and matrix of all constraints; those on velocities alone are 0 in r and stand in G only

    positions      q_g = q_g(t),  r(q) = 0              Newton's method from the position before
    velocities     H_g u = q̇_g,  G u = 0
    accelerations  H_g u̇ = q̈_g - Ḣ_g u,  G u̇ = -Ġ u

Where positions do not follow so, as those of a rolling wheel do not, q̇ = H u is integrated, and each sample is brought
back to the constraints on positions. What neither laws nor constraints determine is refused, with two exceptions:
coordinates in no constraint rest, and idle motions are the least ones. `followed` goes from time to time as far as
positions exist.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.dynamics.loops import Numbers, free_motions, idle_motions
from symdyn.errors import DerivationError, SimulateError
from symdyn.frozen import dataclass
from symdyn.scene import Scene
from symdyn.scene.values import Joint, velocity_name
from symdyn.simulation.initial import CONSISTENT, closed_start, no_equations
from symdyn.simulation.integrate.integration import END

Known = Callable[[Array], tuple[Array, Array, Array]]

CLOSED = 1e-10
"""Largest residual, over the size of the numbers, of a position that follows from the others."""

AGREED = 1e-7
"""Largest velocity against a row, over the size of the velocities, of laws that agree with it."""

STEPS = 30

GUESSES = 30
"""Random positions from which one is looked for where nothing is found from the start."""

NEGLIGIBLE = 1e-10
"""Singular values below it, over the largest, are zero."""

NOTHING = 1e-7
"""Components of unit motions below it are zero."""

RTOL, ATOL = 1e-12, 1e-13
"""Tolerances of positions that are integrated."""


@dataclass(frozen=True)
class Tied:
    """A mechanism with loops, contacts or rows.

    Attributes:
        numbers: it, in numbers.
        functions: "kinematics" H, "turning" Ḣ u, "constraint_residual" r, "constraint_jacobian" G and
            "constraint_bias" Ġ u of the independent rows, each of its name, q and u.
        holding: whether each kept row holds a position.
    """

    numbers: Numbers
    functions: Callable[[str, Array, Array], Array]
    holding: Array


class Following:
    """The equations of the module's legend at a time and a position."""

    def __init__(self, tied: Tied, given: Sequence[str], laws: Known, quasi: Mapping[int, Known]) -> None:
        self.tied = tied
        self.numbers, self.functions, self.holding = tied.numbers, tied.functions, tied.holding
        self.given, self.laws, self.quasi = list(given), laws, quasi
        self.scene = self.numbers.scene
        self.still = np.zeros(self.numbers.state.n)
        self.places = [self.scene.coordinates.index(name) for name in given]
        tabled = [joint for joint, u in _velocities_of(self.scene) if all(k in quasi for k in u)]
        told = {name for joint in tabled for name in joint.coordinates}
        self.moving = np.array([k for k, name in enumerate(given) if name not in told], dtype=int)
        rates = [velocity_name(given[k]) for k in self.moving]
        names = list(self.scene.velocities)
        exact = [names.index(rate) for rate in rates if rate in names] + list(quasi)
        self.loose = np.array([k for k in range(len(names)) if k not in exact], dtype=int)

    def at(self, t: float) -> tuple[Array, Array, Array]:
        """Return positions, rates and second rates of the laws at one time."""
        position, rate, second = self.laws(np.array([t]))
        return position[0], rate[0], second[0]

    def matrix(self, q: Array, holding: bool = False) -> Array:
        """Return H_g over unit rows of tabled velocities over G, of position-level rows only on request."""
        H, G = self.functions("kinematics", q, self.still), self.functions("constraint_jacobian", q, self.still)
        if holding:
            return np.vstack([H[self.places], G[self.holding]])
        return np.vstack([H[[self.places[k] for k in self.moving]], np.eye(len(self.still))[list(self.quasi)], G])

    def missed(self, q: Array) -> float:
        """Return the largest residual."""
        return float(np.abs(self.functions("constraint_residual", q, self.still)).max(initial=0.0))

    def placed(self, t: float, q: Array) -> Array:
        """Return the position next to a guess that keeps laws and loops.

        Raises:
            SimulateError: there is none near by.
        """
        wanted = self.at(t)[0]
        q = q.copy()
        q[self.places] = wanted
        for _ in range(STEPS):
            r = self.functions("constraint_residual", q, self.still)
            size = float(np.abs(r).max(initial=0.0))
            if size <= 1e-14 * max(1.0, float(np.abs(q).max(initial=0.0))):
                break
            H, G = self.functions("kinematics", q, self.still), self.functions("constraint_jacobian", q, self.still)
            step = shortest(np.vstack([H[self.places], G]), np.concatenate([wanted - q[self.places], -r]))
            tried = self.numbers.retract(q, step)
            tried[self.places] = wanted
            if not self.missed(tried) < size and size < CLOSED:
                break
            q = tried
        off = self.missed(q)
        if not off <= CLOSED * max(1.0, float(np.abs(q).max(initial=0.0))):
            values = ", ".join(f"{x:.6g}" for x in wanted)
            what = f" with {', '.join(self.given)} = {values}" if self.given else ""
            raise SimulateError(f"motion: t = {t:g} s: the loops cannot be closed{what}; they miss by {off:.3g}")
        return q

    def begun(self, t: float, guess: Array) -> tuple[Array, tuple[str, ...]]:
        """Return the position at the first time, next to a guess or else to random ones, and what is said of it.

        Raises:
            SimulateError: there is none near any of them.
        """
        chosen = sorted({*np.flatnonzero(abs(guess - self.numbers.start()) > CONSISTENT).tolist()} - {*self.places})
        wanted, notes = guess.copy(), list[str]()
        wanted[self.places] = self.at(t)[0]
        held = {k for joint, u in _velocities_of(self.scene) if {*joint.coordinates} <= {*self.given} for k in u}
        with suppress(SimulateError, DerivationError):  # then Newton's method without a line search has its chance
            assembly, notes = closed_start(self.numbers, wanted, chosen, sorted(held))
            guess = np.array(assembly.q)
        try:
            return self.placed(t, guess), tuple(notes)
        except SimulateError as fault:
            found = list[Array]()
            for seed in range(GUESSES):
                with suppress(SimulateError):
                    found.append(self._nearer(self.placed(t, self.numbers.drawn(seed)), guess))
            if not found:
                raise SimulateError(
                    f"{fault} from the start, and no less from {GUESSES} random guesses; give laws for fewer "
                    f"coordinates, others that fit, or a start near by: {argument('start', {self._follower: 0.3})}"
                ) from None
        q = min(found, key=lambda one: float(np.abs(one - guess).max(initial=0.0)))
        return q, (f"motion: the loops do not close from the start; one of random guesses is taken: {self._told(q)}",)

    def _nearer(self, q: Array, guess: Array) -> Array:
        """Return a position with whole turns taken back, and what is in no loop where a guess has it."""
        allowed = CLOSED * max(1.0, float(np.abs(q).max(initial=0.0)))
        for k in set(range(len(q))) - set(self.places):
            for value in (guess[k], q[k] - 2 * np.pi * np.round((q[k] - guess[k]) / (2 * np.pi))):
                tried = q.copy()
                tried[k] = value
                if self.missed(tried) <= allowed:
                    q = tried
                    break
        return q

    @property
    def _follower(self) -> str:
        """The first coordinate that has no law; the first of all where each has one."""
        return next((name for name in self.scene.coordinates if name not in self.given), self.scene.coordinates[0])

    def _told(self, q: Array) -> str:
        """Return, as an argument, where coordinates without a law are."""
        at = zip(self.scene.coordinates, q.tolist(), strict=True)
        return argument("start", {name: float(f"{x:.4g}") for name, x in at if name not in self.given})

    def velocities(self, t: float, q: Array) -> Array:
        """Return u.

        Raises:
            SimulateError: the laws contradict each other, or the rows.
        """
        A, b = self.matrix(q), self.first(t)
        u = self.solved(A, b)
        if float(np.abs(A @ u - b).max(initial=0.0)) > AGREED * max(1.0, float(np.abs(u).max(initial=0.0))):
            raise SimulateError(
                f"motion: t = {t:g} s: the loops and rows do not allow the velocities of {', '.join(self.given)} "
                f"together; give laws for fewer coordinates of {self.scene.name}"
            )
        return u

    def accelerations(self, t: float, q: Array, u: Array) -> Array:
        return self.solved(self.matrix(q), self.second(t, q, u))

    def first(self, t: float) -> Array:
        """Return the right side of `matrix` for velocities."""
        return self._demanded(t, 1)

    def second(self, t: float, q: Array, u: Array) -> Array:
        """Return the right side of `matrix` for accelerations."""
        b = self._demanded(t, 2)
        b[: len(self.moving)] -= self.functions("turning", q, u)[[self.places[k] for k in self.moving]]
        bias = self.functions("constraint_bias", q, u)
        b[len(b) - len(bias) :] = -bias
        return b

    def solved(self, A: Array, b: Array) -> Array:
        """Return x with A x = b, what laws say as it is."""
        x = A[: len(self.moving) + len(self.quasi)].T @ b[: len(self.moving) + len(self.quasi)]
        x[self.loose] = 0.0
        x[self.loose] = shortest(A[:, self.loose], b - A @ x)
        return x

    def _demanded(self, t: float, order: int) -> Array:
        """Return the right side for velocities (1) or accelerations (2), less what depends on velocities."""
        tabled = [float(law(np.array([t]))[order - 1][0]) for law in self.quasi.values()]
        return np.concatenate([self.at(t)[order][self.moving], tabled, np.zeros(len(self.holding))])

    def rolls(self, q: Array) -> bool:
        """Tell whether rows that hold velocities only determine what laws and positions do not."""
        return _rank(self.matrix(q)) > _rank(self.matrix(q, holding=True))

    def integrated(self, t: Array, q: Array) -> Iterator[Array]:
        """Yield positions at times by integration of the velocities, each of shape (nq,); errors as of `integrated`."""

        def rates(now: float, at: Array) -> Array:
            here = at.copy()
            here[self.places] = self.at(now)[0]
            return np.asarray(self.functions("kinematics", here, self.still) @ self.velocities(now, here))

        told = (
            "what follows through the rows has no finite rate there; let the motion end sooner, or give laws for "
            f"other coordinates than {', '.join(self.given)}"
        )
        return integrated(rates, t, q, ATOL, "motion: t = {:.6g} s: " + told)

    def undetermined(self, q: Array) -> tuple[str, ...]:
        """Return which coordinates rest and which motions are idle.

        Raises:
            SimulateError: laws are missing.
        """
        free = free_motions(self.matrix(q))
        if not len(free):
            return ()
        loose = [k for k in range(len(self.still)) if float(np.abs(free[:, k]).max()) > NOTHING]
        names = [name for name in self.names_of(loose) if name not in self.given]
        if not any(not row[k].is_zero for row in self.numbers.constraints.G for k in loose):
            return (f"no law is given for {', '.join(names)}: at rest",)
        G = self.functions("constraint_jacobian", q, self.still)
        idle = idle_motions(self.numbers, G, q)
        ways = np.array([way for _, way in idle]).reshape(-1, len(self.still))
        if _rank(np.vstack([ways, free])) == _rank(ways):
            return tuple(f"idle: {words}; it is least" for words, _ in idle)
        raise SimulateError(
            f"motion: laws are missing: {len(free)} freedom{'s' * (len(free) != 1)} of {self.scene.name} "
            f"{'is' if len(free) == 1 else 'are'} left, and {', '.join(names)} not determined"
            f"{' by ' + ', '.join(self.given) if self.given else ''}; give {len(free)} more, such as "
            f"{argument('motion', {names[0]: 0.3})} for rest"
        )

    def names_of(self, velocities: Sequence[int]) -> list[str]:
        """Return the coordinates that velocities move."""
        found: dict[str, None] = {}
        for joint, u in _velocities_of(self.scene):
            if len(u) == len(joint.coordinates):
                found |= {joint.coordinates[k - u[0]]: None for k in velocities if k in u}
            elif set(u) & set(velocities):
                found |= dict.fromkeys(joint.coordinates)
        return list(found)


def _velocities_of(scene: Scene) -> Iterator[tuple[Joint, range]]:
    """Yield the joints that move, with the numbers of their velocities."""
    first = 0
    for joint in scene.moving:
        yield joint, range(first, first + len(joint.rates))
        first += len(joint.rates)


def integrated(rates: Callable[[float, Array], Array], t: Array, q: Array, atol: float, told: str) -> Iterator[Array]:
    """Yield what is q at the first of some times, at all of them.

    Raises:
        SimulateError: there are no finite rates on the way, in the words `told`, which have a place for the time.
    """
    from scipy.integrate import DOP853

    yield q
    if len(t) < 2:
        return
    solver, curve = DOP853(rates, t[0], q, t[-1], rtol=RTOL, atol=atol), None
    for now in t[1:]:
        while solver.t < now:
            solver.step()
            curve = None
            if solver.status == "failed":
                raise SimulateError(told.format(solver.t))
        curve = curve or solver.dense_output()
        yield np.asarray(curve(now), dtype=np.float64)


def shortest(A: Array, b: Array) -> Array:
    """Return the shortest of all x that come closest to A x = b."""
    return np.asarray(np.linalg.lstsq(A, b, rcond=NEGLIGIBLE)[0], dtype=np.float64)


def _rank(A: Array) -> int:
    return int(np.linalg.matrix_rank(A, tol=NEGLIGIBLE * float(np.abs(A).max(initial=1.0)))) if A.size else 0


AHEAD = 1e-7
"""s by which it is looked ahead for whether a wheel falls or rises."""

THIRDS = 30
"""Steps to a place where a wheel lies flat, each of which leaves two thirds of an interval."""


@dataclass(frozen=True)
class Followed:
    """What follows, at the first R of the times asked for.

    Attributes:
        q, u, a: positions, velocities and accelerations, shapes (R, nq), (R, nv), (R, nv).
        off: largest residual that is left, shape (R,).
        notes: what a user should know.
        stopped: "end", or why nothing follows at the next time.
    """

    q: Array
    u: Array
    a: Array
    off: Array
    notes: tuple[str, ...]
    stopped: str


def followed(
    tied: Tied, given: Sequence[str], laws: Known, quasi: Mapping[int, Known], t: Array, guess: Array
) -> Followed:
    """Return what follows from laws at times, as far as it goes; see the legend of `following`.

    Args:
        tied: the mechanism and its functions.
        given: names of the coordinates with a law.
        laws: their positions, rates and second rates at times (N,), each of shape (N, given).
        quasi: laws of velocities that are no rates of coordinates: value, rate and second rate at times.
        t: times, s, ascending.
        guess: of the coordinates at the first time, shape (nq,).

    Raises:
        SimulateError: laws that contradict the rows at the first time, or leave motions undetermined.
    """
    one, numbers = Following(tied, given, laws, quasi), tied.numbers
    q, begun = one.begun(float(t[0]), guess)
    no_equations(numbers, q)
    notes = (*begun, *one.undetermined(q))
    path = one.integrated(t, q) if one.rolls(q) else None
    rows: list[tuple[Array, Array, Array, float]] = []
    stopped = END
    for now in t.tolist():
        try:
            q = one.placed(now, q if path is None else next(path))
            u = one.velocities(now, q)
            rows.append((q, u, one.accelerations(now, q, u), one.missed(q)))
        except SimulateError as fault:
            if not rows:
                raise
            stopped = str(fault)
            break
    positions, velocities, accelerations, off = (np.array(part) for part in zip(*rows, strict=True))
    fallen = _fallen(one, t, positions, velocities)
    n, stopped = fallen or (len(rows), stopped)
    return Followed(positions[:n], velocities[:n], accelerations[:n], off[:n], notes, stopped)


def _fallen(one: Following, t: Array, q: Array, u: Array) -> tuple[int, str] | None:
    """Return how many rows there are before a wheel comes to lie flat, also between two samples, and what is said.

    w, the sine of the angle between axis and normal, is |sin|: it falls before such a place and rises behind it.
    """
    numbers, found = one.numbers, []
    for k, gap in enumerate(numbers.contact_gaps):

        def w(at: Array, k: int = k) -> float:
            return float(numbers.at([numbers.contact_gaps[k].sine], at)[0])

        moves = [(w(numbers.retract(at, AHEAD * rate)) - w(at)) for at, rate in zip(q, u, strict=True)]
        for i in range(len(q) - 1):
            if not moves[i] < 0 < moves[i + 1]:
                continue
            low, high = float(t[i]), float(t[i + 1])
            for _ in range(THIRDS):  # a third of the interval less at every step
                left, right = low + (high - low) / 3, high - (high - low) / 3
                one_third, two_thirds = one.placed(left, q[i]), one.placed(right, q[i])
                low, high = (low, right) if w(one_third) < w(two_thirds) else (left, high)
            if gap.is_flat(w(one.placed(low, q[i]))):
                found.append((i + 1, f"motion: t = {low:.6g} s: {gap.fell_flat}"))
                break
    return min(found, default=None)
