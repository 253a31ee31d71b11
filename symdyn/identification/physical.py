"""Inertias that bodies can have, near the scene's own, that give the estimated base parameters.

Least squares determine base parameters. Many masses and inertias give the same ones, and some of these are impossible
for any body. Wanted are linear parameters pi (`unknowns`) with

    minimise    |E pi - e|^2 / Sigma  +  sum |M^-1/2 (P_k - P0_k) M^-1/2|^2 / spread^2  +  ...
    so that     P_k >= MARGIN s_k 1         every body: its pseudo-inertia is positive definite
                S pi >= 0                   armature, damping, dry friction

    E, e, Sigma     what was estimated: combinations of pi, their estimates and covariance
    P_k             pseudo-inertia [[J/rho^2, h/rho], [h/rho, m]] of body k, kg; linear in its ten parameters; rho a
                    length of the scene, P0_k: as declared
    M               |P0_k| with no eigenvalue below FLOOR s_k: the metric in which masses and inertias are compared
    s_k             size of the body, kg
    y               R (pi - best): variables in which the distance is |y|

The data decide what they identify, by their covariance. The second term decides the rest, the same in whatever frame; a
body of point masses, or an impossible one, has a metric too. A change of variables makes both squares one, |y|^2, so
that the solver projects a point onto the cones: a problem that is well conditioned whatever the units are.

References: Wensing, Kim and Slotine, Linear matrix inequalities for physically consistent inertial parameter
identification (2018); Lee, Wensing and Park, Geometric robot dynamic identification: a convex programming approach
(2020), for the distance, its constant metric.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import IdentifyError
from symdyn.extras import install
from symdyn.frozen import dataclass
from symdyn.identification.linear_model import TEN, Unknowns

TOLERANCES = (1e-10, 1e-8, 1e-6)
"""Of the solver, one after the other where it does not get as far."""

UPPER = tuple((i, j) for j in range(4) for i in range(j + 1))
"""Entries of a symmetric 4 by 4 matrix, column by column, as clarabel wants its triangle."""


def pseudo_rows(k: int, p: int, length: float) -> Array:
    """Return the triangle of the pseudo-inertia of body k as rows, shape (10, p); lengths in rho."""
    m, x, y, z, xx, yy, zz, xy, xz, yz = range(TEN * k, TEN * (k + 1))
    rows = np.zeros((TEN, p))
    square = length**2
    for at, (i, j) in enumerate(UPPER):
        if i == j == 3:
            rows[at, m] = 1
        elif j == 3:
            rows[at, (x, y, z)[i]] = 1 / length
        elif i == j:
            for other in (xx, yy, zz):
                rows[at, other] = (-0.5 if other == (xx, yy, zz)[i] else 0.5) / square
        else:
            rows[at, {(0, 1): xy, (0, 2): xz, (1, 2): yz}[i, j]] = -1 / square
    return rows


def matrix(upper: Array) -> Array:
    """Return a symmetric 4 by 4 matrix from its upper triangle."""
    found = np.zeros((4, 4))
    for (i, j), x in zip(UPPER, upper, strict=True):
        found[i, j] = found[j, i] = x
    return found


def triangle(full: Array) -> Array:
    """Return the upper triangle with the length that the matrix has: off the diagonal times the root of two."""
    return np.array([full[i, j] * (1 if i == j else sqrt(2)) for i, j in UPPER])


class Cones:
    """What values must satisfy: rows G pi + c in a product of cones."""

    def __init__(self, count: int) -> None:
        self.zero: list[tuple[Array, float]] = []
        self.above: list[tuple[Array, float]] = []
        self.definite: list[tuple[Array, float]] = []
        self.count = count

    def equal(self, row: Array, value: float) -> None:
        """Take a row whose product is to be a value."""
        self.zero.append((row, value))

    def not_negative(self, row: Array, least: float) -> None:
        """Take a row whose product is to be no less."""
        self.above.append((row, least))

    def positive_definite(self, rows: Array, least: float) -> None:
        """Take the triangle of a matrix, none of whose eigenvalues is to be below `least`."""
        self.definite.append((rows, least))

    def hold(self, values: Array) -> bool:
        """Tell whether values satisfy all of it."""
        return (
            all(abs(row @ values - value) <= 1e-9 * abs(value) for row, value in self.zero)
            and all(row @ values >= least for row, least in self.above)
            and all(np.linalg.eigvalsh(matrix(rows @ values))[0] >= least for rows, least in self.definite)
        )

    def stacked(self) -> tuple[Array, Array]:
        """Return G and c."""
        every = [*self.zero, *self.above]
        rows = [row[None, :] for row, _ in every]
        more = [np.array([-value]) for _, value in every]
        scale = triangle(np.ones((4, 4)))
        for upper, least in self.definite:
            rows.append(scale[:, None] * upper)
            more.append(-least * triangle(np.eye(4)))
        return np.vstack(rows), np.concatenate(more)


def projected(cones: Cones, best: Array, R: Array) -> Array:
    """Return what the cones hold nearest to `best`, by |R (pi - best)|."""
    try:
        import clarabel
    except ImportError:
        raise IdentifyError(
            f"these estimates are those of no body; finding ones near them needs clarabel: {install('identify')}"
        ) from None
    from scipy.sparse import csc_matrix, identity

    G, c = cones.stacked()
    back = np.linalg.solve(R, np.eye(cones.count))
    kinds = [(clarabel.ZeroConeT, len(cones.zero)), (clarabel.NonnegativeConeT, len(cones.above))]
    shapes = [kind(n) for kind, n in kinds if n] + [clarabel.PSDTriangleConeT(4) for _ in cones.definite]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    for tolerance in TOLERANCES:
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
        problem = (identity(cones.count, format="csc"), np.zeros(cones.count), csc_matrix(-G @ back), G @ best + c)
        solution = clarabel.DefaultSolver(*problem, shapes, settings).solve()
        status = str(solution.status)
        if status in ("Solved", "AlmostSolved"):
            break
    else:
        if "Infeasible" in status:
            advice = "no bodies have what is asked of them; ask less of masses and ellipsoids"
        else:
            advice = (
                "the solver of cones does not get through: standard errors of these estimates lie too far apart, as "
                "those of a log with hardly any noise, or of units that are off; look at both, and at outliers"
            )
        raise IdentifyError(f"{advice} (clarabel ends with {status})")
    return np.asarray(best + back @ np.array(solution.x))


MARGIN = 1e-6
"""Smallest eigenvalue of a pseudo-inertia that is sought, in sizes of the body."""

FLOOR = 1e-2
"""Smallest eigenvalue of the metric, in sizes of the body: what is declared as zero may become this, and more."""

SPREAD = 1.0
"""How far a body may be from the scene's own where data show it, in its own size: standard deviation of the prior."""

NOTHING = 1e-9
"""Shares in a combination below it, beside the largest, are rounding, and show nothing of a parameter's size."""

SHARPEST = 1e-8
"""Relative standard error below which estimates are not believed: what a log in doubles can show at best."""


@dataclass(frozen=True)
class Physical:
    """Linear parameters that a mechanism can have.

    Attributes:
        unknowns: what they are values of.
        values: shape (p,), in the order of `unknowns.names`.
        distance: from the estimates, in the metric of their covariance: their Mahalanobis distance; 1 is one standard
            error. Zero: the estimates are those of bodies as they are.
        missed: length of what is missed of the estimates by that of the estimates.
        identifiable: how many combinations were estimated.
        margins: smallest eigenvalue of the pseudo-inertia of every body by its trace, shape (bodies,); a third of a
            fourth is a ball, zero is a body without thickness, below zero is none. Lengths are in `length`.
        before: the same of the scene as declared.
        length: rho, m.
        kept: names of bodies that no estimate touches; they are as the scene declares them.
        at_limit: what stands at the edge of what can be, such as "link3" or "damping of elbow".
        projected: whether a solver of cones was needed.
    """

    unknowns: Unknowns
    values: Array
    distance: float
    missed: float
    identifiable: int
    margins: Array
    before: Array
    length: float
    kept: tuple[str, ...]
    at_limit: tuple[str, ...]
    projected: bool

    @property
    def base(self) -> Array:
        """Base parameters of these values, shape (b,)."""
        return np.asarray(self.unknowns.map @ self.values)


def nearest_physical(
    unknowns: Unknowns,
    combinations: Array,
    estimate: Array,
    covariance: Array,
    total_mass: float | None = None,
    inside: Mapping[str, tuple[Sequence[float], Sequence[float]]] | None = None,
    spread: float = SPREAD,
) -> Physical:
    """Return what bodies can have of all that fits the estimates, the nearest to the scene's own.

    Args:
        unknowns: the linear parameters of the scene.
        combinations: E, shape (k, p): what was estimated; `unknowns.map` for all base parameters.
        estimate: e, shape (k,).
        covariance: of the estimates, shape (k, k).
        total_mass: of all bodies together, kg; None leaves it to the data.
        inside: for bodies by name, an ellipsoid that holds all of their mass: centre and half axes along the body
            axes, m.
        spread: how far a body may be from the scene's own, in its own size, where data are weak.

    Raises:
        IdentifyError: clarabel is needed and is not installed; nothing has this mass or lies in these ellipsoids.
    """
    count = len(unknowns.bodies)
    length, sizes = _sizes(unknowns)
    prior = prior_of(unknowns)
    # one change of variables for both squares: y = R (pi - best), so that the objective is |y|^2
    weigh, target = _weighed(prior, combinations, estimate, covariance)
    metric = _metric(unknowns, prior, combinations, estimate, length, sizes) / spread
    stacked = np.vstack([weigh, metric])
    _, R = np.linalg.qr(stacked)
    wanted = np.concatenate([target, np.zeros(len(metric))])
    best = prior + np.linalg.lstsq(stacked, wanted, rcond=None)[0]
    felt = [bool(np.any(combinations[:, TEN * k : TEN * (k + 1)])) for k in range(count)]
    if total_mass is not None:
        felt = [True] * count
    cones = Cones(len(best))
    for k in range(count):
        if felt[k]:
            cones.positive_definite(pseudo_rows(k, len(best), length), 2 * MARGIN * sizes[k])
    for row in unknowns.signs:
        cones.not_negative(row, 0.0)
    for name, (centre, axes) in (inside or {}).items():
        cones.not_negative(_inside(unknowns, name, centre, axes), 0.0)
    if total_mass is not None:
        cones.equal(_masses(count, len(best)), total_mass)
    values = best
    if not cones.hold(best):
        values = projected(cones, best, R)
    for k in range(count):
        if not felt[k]:
            values[TEN * k : TEN * (k + 1)] = unknowns.values[TEN * k : TEN * (k + 1)]
    edge = [
        one for k, one in enumerate(unknowns.bodies) if felt[k] and _least(values, k, length) < 4 * MARGIN * sizes[k]
    ]
    edge += _settled(unknowns, values, spread * np.abs(np.diag(metric)))
    off = weigh @ (values - prior) - target
    size = float(np.linalg.norm(estimate))
    return Physical(
        unknowns,
        values,
        float(np.linalg.norm(off)),
        float(np.linalg.norm(combinations @ values - estimate)) / size if size else 0.0,
        len(estimate),
        _margins(values, count, length),
        _margins(unknowns.values, count, length),
        length,
        tuple(one for k, one in enumerate(unknowns.bodies) if not felt[k]),
        tuple(edge),
        values is not best,
    )


def _settled(unknowns: Unknowns, values: Array, scale: Array) -> list[str]:
    """Make exactly zero what the solver has left within rounding of it, and return what that is."""
    found = []
    for what, row in zip(unknowns.signed, unknowns.signs, strict=True):
        touched = np.flatnonzero(row)
        if row @ values < 1e-6 * float(np.sum(np.abs(row[touched]) / np.maximum(scale[touched], 1e-300))):
            found.append(what)
            if len(touched) == 1:
                values[touched] = 0.0
    return found


# The squares


def _sizes(unknowns: Unknowns) -> tuple[float, Array]:
    """Return rho, m, and the size of every body, kg, above zero."""
    ten = unknowns.ten(unknowns.values)
    mass, moments = np.abs(ten[:, 0]), np.abs(ten[:, 4:7]).sum(axis=1) / 2
    total = float(mass.sum())
    length = sqrt(float(moments.sum()) / total) if total > 0 and moments.sum() > 0 else 1.0
    sizes = mass + moments / length**2
    largest = float(sizes.max(initial=0.0)) or 1.0
    return length, np.maximum(sizes, 1e-3 * largest)


def prior_of(unknowns: Unknowns) -> Array:
    """Return the values that others are to be near, shape (p,): the scene's own.

    A body with inertia and without mass is one whose mass was not needed: it gets the one with which its radius of
    gyration is that of the scene.
    """
    _, sizes = _sizes(unknowns)
    found = unknowns.values.copy()
    for k, ten in enumerate(unknowns.ten(unknowns.values)):
        if ten[0] == 0 and ten[4:7].any():
            found[TEN * k] = sizes[k]
    return found


def _weighed(prior: Array, combinations: Array, estimate: Array, covariance: Array) -> tuple[Array, Array]:
    """Return W E and W (e - E pi0), with W^T W the inverse of the covariance."""
    if not len(estimate):
        return np.zeros((0, len(prior))), np.zeros(0)
    reach = np.abs(combinations) @ np.abs(prior)
    least = SHARPEST * np.maximum(np.abs(estimate), reach)
    least = np.maximum(least, 1e-3 * float(least.max()) or SHARPEST)
    sizes = np.sqrt(np.diag(covariance) + least**2)
    w, V = np.linalg.eigh((covariance + np.diag(least**2)) / np.outer(sizes, sizes))
    floor = len(w) * np.finfo(np.float64).eps * w[-1]  # rounding may have made the least negative
    half = (V / np.sqrt(np.maximum(w, floor))).T / sizes
    return half @ combinations, half @ (estimate - combinations @ prior)


def _metric(
    unknowns: Unknowns, prior: Array, combinations: Array, estimate: Array, length: float, sizes: Array
) -> Array:
    """Return D, shape (p, p): |D (pi - pi0)|^2 is the distance from the scene's own."""
    p, count = len(prior), len(unknowns.bodies)
    found = np.zeros((p, p))
    for k in range(count):
        part = pseudo_rows(k, p, length)
        w, V = np.linalg.eigh(matrix(part @ prior))
        half = V @ np.diag(np.maximum(np.abs(w), FLOOR * sizes[k]) ** -0.5) @ V.T
        for c in range(TEN):
            turned = half @ matrix(part[:, TEN * k + c]) @ half
            found[TEN * k : TEN * (k + 1), TEN * k + c] = triangle(turned)
    for c in range(TEN * count, p):
        rows = zip(estimate, combinations, strict=True)
        touching = [abs(e / row[c]) for e, row in rows if abs(row[c]) > NOTHING * np.abs(row).max()]
        found[c, c] = 1 / (max(abs(float(prior[c])), *touching, 0.0) or 1.0)
    return found


def _margins(values: Array, count: int, length: float) -> Array:
    found = []
    for k in range(count):
        w = np.linalg.eigvalsh(matrix(pseudo_rows(k, len(values), length) @ values))
        total = float(np.abs(w).sum())
        found.append(float(w[0]) / total if total else 0.0)
    return np.array(found)


def _least(values: Array, k: int, length: float) -> float:
    return float(np.linalg.eigvalsh(matrix(pseudo_rows(k, len(values), length) @ values))[0])


def _masses(count: int, p: int) -> Array:
    row = np.zeros(p)
    row[: TEN * count : TEN] = 1
    return row


def _inside(unknowns: Unknowns, name: str, centre: Sequence[float], axes: Sequence[float]) -> Array:
    """Return the row of tr(P Q) >= 0: the second moments about the centre, each by its half axis squared, are below m.

    Reference: Wensing, Kim and Slotine (2018), section IV.
    """
    if name not in unknowns.bodies:
        told = ", ".join(unknowns.bodies)
        raise IdentifyError(f'inside: "{name}" is no body of {unknowns.scene.name}; there are {told}')
    if len(centre) != 3 or len(axes) != 3 or not all(a > 0 for a in axes):
        raise IdentifyError(f"inside: {name}: give a centre of three numbers and three half axes above zero, m")
    k, c, a = unknowns.bodies.index(name), np.array(centre, float), np.array(axes, float)
    rows = pseudo_rows(k, len(unknowns.values), 1.0)
    at = {place: rows[n] for n, place in enumerate(UPPER)}
    found: Array = at[3, 3] * (1 - float(((c / a) ** 2).sum()))
    for i in range(3):
        found = found - at[i, i] / a[i] ** 2 + at[i, 3] * (2 * c[i] / a[i] ** 2)
    return found
