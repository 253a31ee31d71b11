"""Modes of ẋ = A x, of M δξ̈ + D δξ̇ + K δξ = 0 at a place of rest, and their motions, which can be drawn.

Eigenvalues of A that are zero are separated from the others before rounding can move them:

    T⁻¹ A T = [N  R]        N nilpotent, of the size of all zero eigenvalues; A' has none
              [0  A']       v = T (z, y) is the shape of λ ≠ 0: A' y = λ y, (λ - N) z = R y

Rounding moves a double zero, as of what drifts freely, by its root, 1e-8. So zeros are taken out first: what A maps to
nothing spans a space, A acts on what is left beside it, and so on while something is mapped to nothing. States have
different units, so A is balanced before sizes are compared.

At a place of rest, to first order in what moves the mechanism:

    M = ∂e/∂u̇    D = ∂e/∂u    K = X e        all at the place, at u = u̇ = 0
    (K - ω² M) v = 0                         frequencies ω and shapes v, as long as nothing damps

A mode is drawn as q(t) = q₀ moved by Re(a v e^{iφ(t)}), at a visible size, without growth and decay. Positions on which
no velocity depends do not determine the size, and stay fixed where they would go far: the observer rides along.

Reference: Kublanovskaya's staircase; Golub and Van Loan, Matrix Computations (2013), 7.6.5 and 7.5.7 (balancing).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import argument, suggesting
from symdyn.draw import Reel, Stage, film
from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs import COLUMNS
from symdyn.errors import LinearizeError
from symdyn.frozen import dataclass, replace
from symdyn.simulation import CHECKS, opened
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization

Complexes = npt.NDArray[np.complex128]


class array(np.ndarray[Any, np.dtype[np.complex128]]):  # noqa: N801  by this name it is printed, as any other
    """Complex numbers that an attribute has, poles and zeros: a call, as of other tools' methods, returns them too."""

    @suggesting
    def __call__(self) -> Complexes:
        """Return them."""
        return np.asarray(self)

    def __array_wrap__(self, found: Any, context: Any = None, return_scalar: bool = False) -> Any:
        """Return what is computed of them as of any other array."""
        return np.asarray(found)[()]


NOTHING = 1e-9
"""Singular values of the balanced A over its largest that are zero."""

PARTED = 1e-6
"""Distance of eigenvalues over the largest that rounding makes of one that is multiple."""

SIDEWAYS = 1e-9
"""Real parts, or of samples |z| - 1, over the size of the largest eigenvalue that are zero."""

ROUNDING = 1e-14
"""Entries over the largest that rounding leaves where there is nothing."""

ROUNDS = 12
"""Times that all states are balanced at most."""


def pairs_of(values: Iterable[complex]) -> list[list[float]]:
    """Return complex numbers for JSON, real and imaginary parts."""
    return [[float(value.real), float(value.imag)] for value in values]


@dataclass(frozen=True, eq=False)
class Mode:
    """One way of moving, of an eigenvalue that is not zero, or of a pair of conjugate ones.

    Attributes:
        value: eigenvalue λ, 1/s; of a pair the one with positive imaginary part.
        shape: what moves in it, shape (nx,), its largest entry 1; of complex entries the angle is the phase.
    """

    value: complex
    shape: Complexes

    @property
    def oscillates(self) -> bool:
        """Whether it is a pair."""
        return self.value.imag > 0

    @property
    def frequency(self) -> float:
        """Natural frequency |λ|/2π, Hz, of a pair and of a real eigenvalue alike."""
        return abs(self.value) / (2 * math.pi)

    @property
    def damping(self) -> float:
        """Damping ratio -Re λ/|λ|: 1 of what decays without oscillating, -1 of what grows so; 0 of λ = 0."""
        return -self.value.real / (abs(self.value) or 1.0)


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The eigenvalues of A.

    Attributes:
        zeros: how many are zero.
        still: what A maps to nothing, a column each, shape (nx, nullity).
        modes: the others, those that grow fastest first.
        size: the largest of them, 1/s; 0 if all are zero.
        sampled: whether they are z - 1 of a system from sample to sample.
        drifting: what grows with time, in a multiple zero or pair on the edge with fewer shapes, shape (nx, many).
    """

    zeros: int
    still: Array
    modes: tuple[Mode, ...]
    size: float
    sampled: bool
    drifting: Complexes

    @property
    def values(self) -> Complexes:
        """All eigenvalues, pairs in full, shape (nx,): those that grow fastest first, zeros last."""
        found: list[complex] = []
        for mode in self.modes:
            found += [mode.value, mode.value.conjugate()] if mode.oscillates else [mode.value]
        return np.array([*found, *[0j] * self.zeros], dtype=np.complex128)

    @property
    def growing(self) -> tuple[Mode, ...]:
        """Those that grow."""
        return self._that(1)

    @property
    def decaying(self) -> tuple[Mode, ...]:
        """Those that decay."""
        return self._that(-1)

    def _that(self, way: int) -> tuple[Mode, ...]:
        ways = growth([mode.value for mode in self.modes], self.size, self.sampled)
        return tuple(mode for mode, one in zip(self.modes, ways, strict=True) if one == way)

    @property
    def lasting(self) -> tuple[complex, ...]:
        """Eigenvalues that do not decay, those that grow fastest first."""
        return (*(mode.value for mode in self.growing + self._that(0)), *[0j] * self.zeros)

    @property
    def staying(self) -> Complexes:
        """What moves in modes that do not decay, shape (nx, many); of a multiple zero what stays."""
        return np.column_stack([self.still.astype(np.complex128), *(x.shape for x in self.growing + self._that(0))])


def growth(values: Sequence[complex] | Complexes, size: float, sampled: bool = False) -> Array:
    """Return 1 of each eigenvalue that grows, -1 of one that decays, 0 of one that does neither, to rounding.

    `size` is that of the largest; `sampled` values are z - 1.
    """
    each = np.asarray(values, dtype=np.complex128)
    beyond = np.abs(1 + each) - 1 if sampled else each.real
    return np.sign(np.where(np.abs(beyond) > SIDEWAYS * size, beyond, 0.0))


def spectrum(A: Array, whole: float = 0.0, sampled: bool = False) -> Spectrum:
    """Return the eigenvalues of A, shape (nx, nx), 1/s; zero is what is nothing beside the size of the `whole`.

    `sampled` ones are those of A - 1.
    """
    n = len(A)
    A = A - np.eye(n) if sampled else A
    scale = balance(A)
    left = A * scale[None, :] / scale[:, None]  # D⁻¹ A D
    size = float(np.abs(left).max(initial=whole))
    Q, zeros, still = np.eye(n), 0, np.zeros((n, 0))
    while zeros < n:
        part = left[zeros:, zeros:]
        _, values, rows = np.linalg.svd(part)
        lost = int(np.sum(values <= NOTHING * max(size, 1e-300)))
        if not lost:
            break
        turn = np.eye(n)
        turn[zeros:, zeros:] = np.vstack([rows[len(rows) - lost :], rows[: len(rows) - lost]]).T
        left, Q = turn.T @ left @ turn, Q @ turn
        left[zeros:, zeros : zeros + lost] = 0.0
        still = scale[:, None] * Q[:, :lost] if not zeros else still
        zeros += lost
    values, below = np.linalg.eig(left[zeros:, zeros:]) if zeros < n else (np.zeros(0), np.zeros((0, 0)))
    values, fewer = _as_one(np.asarray(values, dtype=np.complex128), below, sampled)
    N, R = left[:zeros, :zeros], left[:zeros, zeros:]
    modes = []
    for value, y in zip(values, below.T, strict=True):
        if value.imag < 0:
            continue
        shifted = value * np.eye(zeros) - N
        try:
            z = np.linalg.solve(shifted, R @ y)
        except np.linalg.LinAlgError:  # an eigenvalue that doubles cannot tell from zero beside the others
            z = np.linalg.lstsq(shifted, R @ y, rcond=None)[0]
        shape = scale * (Q @ np.concatenate([z, y]))
        modes.append(Mode(complex(value), np.asarray(shape / shape[np.abs(shape).argmax()], dtype=np.complex128)))
    top = max((abs(mode.value) for mode in modes), default=0.0)
    modes.sort(key=lambda mode: (-round(mode.value.real / top, 9), abs(mode.value)))
    chain = scale[:, None] * Q[:, still.shape[1] : zeros]
    powers = [(np.linalg.matrix_power(left - one * np.eye(n), many), many) for one, many in fewer.items()]
    wider = [scale[:, None] * (Q @ np.linalg.svd(power)[2][-many:].conj().T) for power, many in powers]
    return Spectrum(zeros, still, tuple(modes), top, sampled, np.hstack([A @ chain, chain, *wider]))


def _as_one(values: Complexes, shapes: Array | Complexes, sampled: bool) -> tuple[Complexes, dict[complex, int]]:
    """Return eigenvalues, those of one that rounding parts about the edge at their mean; how many have fewer shapes.

    A double eigenvalue with one shape, as of a body that turns and drifts, is found to the root of rounding,
    the mean of the two to rounding itself.
    """
    top, found, fewer = float(np.abs(values).max(initial=0.0)), values.copy(), dict[complex, int]()
    for value in values:
        near = np.abs(values - value) <= PARTED * top
        mean = values[near].mean()
        if (many := int(np.count_nonzero(near))) > 1 and not growth([mean], top, sampled)[0]:
            found[near] = mean if sampled else complex(0.0, mean.imag)
            if mean.imag > PARTED * top and np.linalg.matrix_rank(shapes[:, near], tol=PARTED) < many:
                fewer[complex(mean)] = many
    return found, fewer


def balance(A: Array) -> Array:
    """Return scales d, powers of two, shape (nx,), that make rows and columns of D⁻¹ A D of one size."""
    d, left = np.ones(len(A)), np.abs(A) * (1 - np.eye(len(A)))
    left[left <= ROUNDING * np.abs(A).max(initial=0.0)] = 0.0  # it would be blown up
    for _ in range(ROUNDS):
        changed = False
        for k in range(len(A)):
            column, row = float(np.linalg.norm(left[:, k])), float(np.linalg.norm(left[k]))
            if not (column > 0 and row > 0 and math.isfinite(column) and math.isfinite(row)):
                continue
            factor = 2.0 ** round(math.log2(row / column) / 2)
            if factor != 1.0:
                changed = True
                d[k] *= factor
                left[:, k] *= factor
                left[k] /= factor
        if not changed:
            break
    return d


def untouched(A: Array, among: Sequence[int]) -> list[int]:
    """Return the states, of some, on which no rate depends."""
    scale = balance(A)
    left = np.abs(A * scale[None, :] / scale[:, None])
    size = left.max(initial=0.0)
    return [k for k in among if left[:, k].max(initial=0.0) <= NOTHING * size]


MODE_PERIOD, MOMENTS = 2.0, 61
"""Seconds that one round is shown in, and moments of it."""

ANGLE, PART = 0.3, 0.12
"""The largest displacement: of an angle, rad, and of a length over the size of the mechanism."""

FAR = 2.0
"""Times that displacement beyond which a position on which nothing depends stays."""

MOVES = 1e-6
"""Displacements over the largest state of a mode below which nothing is seen to move."""


def motion(one: Linearization, mode: Mode) -> tuple[Array, Array]:
    """Return times, s, shape (N,), and coordinates, shape (N, nq), of one round of a mode.

    Raises:
        LinearizeError: no position that is a state moves in it.
    """
    shape, units = mode.shape[: one.positions], one.states.units[: one.positions]
    if not np.abs(shape).max(initial=0.0) > MOVES * np.abs(mode.shape).max(initial=0.0):
        raise LinearizeError(f"{one.scene.name}: in the mode {mode.value:.6g} only velocities change; it has no shape")
    length = Stage(one.scene, one.point.q[None]).extent
    limits = np.array([ANGLE if unit == "rad" else PART * length for unit in units])
    along = _ridden(one)
    rest = [k for k in range(one.positions) if k not in along and shape[k]] or list(range(one.positions))
    shape = shape / float((np.abs(shape) / limits)[rest].max())
    shape = np.where(np.abs(shape) <= FAR * limits, shape, 0.0)
    turn = np.linspace(0.0, 2 * math.pi, MOMENTS)
    course = np.exp(1j * turn) if mode.oscillates else (1 - np.cos(turn)) / 2
    shifts = np.real(np.outer(course, shape))
    numbers, point = opened(one.scene).numbers(), one.point.q
    labels = COLUMNS["q"](Workspace(one.scene))
    held = [labels.index(name) for name in (*one.states.names[: one.positions], *one.dropped)]
    found = [numbers.newton(numbers.normalised(point + one.moves @ shift), held) for shift in shifts]
    return turn / (2 * math.pi) * MODE_PERIOD, np.array(found)


def _ridden(one: Linearization) -> list[int]:
    """Return positions on which no velocity depends, nor any position but these."""
    found: list[int] = []
    while True:
        rest = [k for k in range(len(one.states)) if k not in found]
        positions = [i for i, k in enumerate(rest) if k < one.positions]
        more = [rest[i] for i in untouched(one.A[np.ix_(rest, rest)], positions)]
        if not more:
            return found
        found += more


def shown(one: Linearization) -> list[Mode]:
    """Return the modes in which something moves."""
    return [mode for mode in one.modes if np.abs(mode.shape[: one.positions]).max(initial=0.0) > MOVES]


def files(one: Linearization, path: str | Path, reel: Reel | None = None) -> list[tuple[Path, Mode]]:
    """Return the file of every mode that can be shown: the one given, numbered where there are several.

    Raises:
        LinearizeError: nothing moves in any mode.
        SimulateError: an ending that no moving picture has.
    """
    path = Path(path)
    CHECKS["film"](path, reel)
    modes = shown(one)
    if not modes:
        raise LinearizeError(f"{one.scene.name}: {argument('animate')}: no mode has a shape; all eigenvalues are zero")
    if len(modes) == 1:
        return [(path, modes[0])]
    return [(path.with_name(f"{path.stem}-{k + 1}{path.suffix}"), mode) for k, mode in enumerate(modes)]


@suggesting
def animate_modes(
    one: Linearization, path: str | Path, reel: Reel | None = None, note: Callable[[str], None] | None = None
) -> Sequence[tuple[Path, Mode]]:
    """Write every mode as a film, of a kind that `symdyn.draw.film` writes, and return which is where.

    `note` takes what is not shown, once.

    Raises:
        LinearizeError, SimulateError: as of `files`.
        DrawError: a file that cannot be written.
    """
    found, shown = files(one, path, reel), reel or Reel()
    for place, mode in found:
        film(one.scene, *motion(one, mode), place, fps=shown.fps, size=shown.size, loop=shown.loop, note=note)
        note = None
    return found


STILL = 1e-9
"""Of ω² over the largest, of an inertia, of what keeps K from being symmetric: less is none."""


@dataclass(frozen=True, eq=False)
class SecondOrder:
    """The matrices at a place of rest, of displacements along velocities."""

    M: Array  # inertia, shape (n, n)
    D: Array  # damping, shape (n, n)
    K: Array  # stiffness, shape (n, n)

    @property
    def moved(self) -> tuple[int, ...]:
        """The velocities against which there is an inertia; others decide no motion."""
        size = np.abs(self.M).max(initial=0.0)
        return tuple(k for k, row in enumerate(self.M) if np.abs(row).max() > STILL * size)

    def of(self, some: tuple[int, ...]) -> SecondOrder:
        """Return the matrices of some velocities alone."""
        part = np.ix_(some, some)
        return SecondOrder(self.M[part], self.D[part], self.K[part])

    @property
    def moves(self) -> bool:
        """Whether every motion has a positive inertia, without which there are no modes."""
        along = np.linalg.eigvalsh(self.M)
        return bool(len(along) and along[0] > STILL * np.abs(along).max())

    @property
    def symmetric(self) -> bool:
        """Whether the forces have a potential."""
        return bool(np.abs(self.K - self.K.T).max(initial=0.0) <= STILL * np.abs(self.K).max(initial=1e-300))

    @property
    def kind(self) -> str:
        """What the potential energy says, after Lagrange and Dirichlet: "stable" where it is least, else "unstable".

        "undecided" where second derivatives do not tell, or forces have no potential.
        """
        least, size = np.linalg.eigvalsh((self.K + self.K.T) / 2).min(initial=np.inf), np.abs(self.K).max(initial=0.0)
        if not self.symmetric or not size or abs(least) <= STILL * size:
            return "undecided"
        return "stable" if least > 0 else "unstable"

    @cached_property
    def spectrum(self) -> Spectrum:
        """Eigenvalues of the motion with damping."""
        n = len(self.M)
        below = -np.linalg.solve(self.M, np.hstack([self.K, self.D]))
        return spectrum(np.block([[np.zeros((n, n)), np.eye(n)], [below]]))

    @property
    def modes(self) -> tuple[tuple[float, Array], ...]:
        """ω², ascending, and shapes, shape (n,), their largest entry 1, as long as nothing damps; of symmetric K."""
        n = len(self.M)
        K = (self.K + self.K.T) / 2
        free = replace(self, K=K, D=np.zeros((n, n))).spectrum
        found = [(0.0, way) for way in free.still[:n].T]
        for mode in free.modes:
            if mode.oscillates or mode.value.real > 0:
                way = mode.shape[:n]
                found.append((float((-(mode.value**2)).real), (way / way[np.abs(way).argmax()]).real))
        shapes = [(square, _clean(way)) for square, way in found]
        return tuple(sorted(shapes, key=lambda one: (one[0], int(np.abs(one[1]).argmax()))))


def _clean(way: Array) -> Array:
    """Return a shape with its largest entry 1, and without what is rounding."""
    way = np.where(np.abs(way) > STILL * np.abs(way).max(), way, 0.0)
    return np.asarray(way / way[np.abs(way).argmax()]) + 0.0  # -0 is 0
