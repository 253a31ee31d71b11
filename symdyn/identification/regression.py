"""Weighted least squares on rows of a base regressor: parameters, their covariance, and the noise that is left.

    Y β = τ + e         a row for each joint and cosine of the band (`filtered.projected`)
    s_j(f)              variance of e by joint and frequency: constant; f² and f⁴ (noise of positions, differentiated
                        twice) and slow (what the model lacks) where the likelihood insists; from residuals over what
                        their leverage leaves of them
    R                   correlation of joints, which one noisy position makes
    Cov β = A⁻¹ Yᵀ W Ω W Y A⁻¹,  A = Yᵀ W Y,  W = diag 1/s,  Ω = s^½ R s^½ at equal frequencies

Directions of β whose effect in the rows is no larger than noise of the motion alone would make keep the scene's values:

    λ = |N v|² / |Y v|²     largest first: Y are the rows, N one draw of what noise of the motion makes of them
    v = e_k - Σ c_i e_i     for each direction that is mostly noise, of a column k of its own; c is the regression of
                            that column on the others, and of it only what is sure

What noise of the motion pulls the others by is taken out: rows of Y + N fit τ = Y β + e, so that least squares find

    β - A⁻¹ Nᵀ W N β        to the first order (Fuller 1987, section 2.2), N Nᵀ from the same draw

Outliers are left out and reported by joint and time: samples of driving forces that no noise of their joint explains,
by residuals next to their median absolute deviation, joint by joint (Hampel 1974).

References: Khalil and Dombre (2002), section 12.4; Gautier, Numerical calculation of the base inertial parameters
(1991); Fuller, Measurement Error Models (1987); White, A heteroskedasticity-consistent covariance matrix estimator
(1980).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import IdentifyError
from symdyn.frozen import dataclass, field
from symdyn.identification.filtered import Flags, Indices
from symdyn.shown import Suggesting

BURIED = 0.25
"""Part of the information of a direction that noise of the motion may make, and it still counts as identifiable."""

SURE = 3.0
"""Standard errors from which a column is part of another."""

LEAST = 1e-9
"""Part of the largest singular value below which columns depend on each other."""


def hidden(felt: Array, columns: Array, noise: Array) -> Array:
    """Return directions that noise of the motion buries, shape (u, p).

    Args:
        felt: orthogonal directions that the rows determine equally well, shape (n, p): |columns @ one| = 1.
        columns: of the rows, shape (M, p).
        noise: one draw of what noise makes of them, shape (M, p).
    """
    part = noise @ felt.T
    if np.sum(part**2) < BURIED:
        return np.zeros((0, felt.shape[1]))
    share, turned = np.linalg.eigh(part.T @ part)
    return cleared(turned.T[share >= BURIED] @ felt, columns)


def echelon(rows: Array) -> Array:
    """Return rows of the same space, each with one column that the others lack; by QR with pivoting."""
    return _echelon(rows)[0]


def _echelon(rows: Array) -> tuple[Array, Indices]:
    """Return rows of the same space, and the column that each has for itself."""
    from scipy.linalg import qr

    if not len(rows):
        return rows, np.zeros(0, np.int64)
    pivots = np.sort(qr(rows, mode="economic", pivoting=True)[2][: len(rows)])
    return np.asarray(np.linalg.solve(rows[:, pivots], rows)), np.asarray(pivots, dtype=np.int64)


def cleared(rows: Array, columns: Array) -> Array:
    """Return directions that noise buries, without what chance mixes into them.

    A column that is noise is, by chance, a little like every other one. What it truly shares with others is its
    regression on them; of that stays what is sure against its standard error (White 1980).
    """
    if not len(rows):
        return rows
    rows = np.linalg.svd(rows, full_matrices=False)[2]
    rows, pivots = _echelon(rows)
    found = np.zeros_like(rows)
    for row, pivot in zip(found, pivots, strict=True):
        row[pivot] = 1.0
        others = np.setdiff1d(np.arange(rows.shape[1]), pivots)
        while len(others):
            inverse = np.linalg.pinv(columns[:, others], rcond=LEAST)
            shared = inverse @ columns[:, pivot]
            off = columns[:, pivot] - columns[:, others] @ shared
            sure = np.abs(shared) > SURE * np.linalg.norm(inverse * off, axis=1)
            if sure.all():
                row[others] = -shared
                break
            others = others[sure]
    return found


BALANCED = 1e-6
"""Part of its terms to which an equation without a driving force holds: noise is never taken as less."""

ROUNDS = 8
"""Of weights and parameters in turn."""


ALONE = 1e-3
"""Share of the null space in a parameter, below which it is identifiable by itself."""

CLEAR, LOW = 9.0, 0.02
"""Gain of twice the logarithm of likelihood from which noise has one colour more; least variance, part of the mean."""

MOST = 0.98
"""Share of a row that the estimate may follow: what is left of it is noise."""


@dataclass(frozen=True)
class Regression(Suggesting):
    """Rows of a regressor, and what least squares make of them.

    Attributes:
        names: of the parameters, shape (p,).
        Y: rows, shape (M, p), in the units of the driving forces.
        tau: measured, less what is known of it, shape (M,).
        joint: index of the velocity of each row, shape (M,).
        frequency: Hz of each row, shape (M,).
        weights: one over the standard deviation of each row, shape (M,).
        estimate: β, shape (p,).
        covariance: of the estimate in the identifiable directions, shape (p, p).
        information: its pseudo-inverse there, shape (p, p).
        null_space: basis of directions that are not identifiable, orthonormal in units of `scale`, shape (u, p).
        scale: of the columns, shape (p,).
        condition: of the weighted rows, columns scaled to one, in the identifiable directions.
        dof: rows less identifiable directions.
        deviation: standard deviation of the noise of each velocity's rows, shape (nv,); NaN where there are none.
        shares: of each velocity's rows, how many degrees of freedom the estimate took, and how many it left, from
            which its noise was estimated, shape (nv, 2).
        pull: by how many standard errors noise of the motion pulls each parameter, which is taken out of the estimate,
            shape (p,).
    """

    names: tuple[str, ...]
    Y: Array
    tau: Array
    joint: Indices
    frequency: Array
    weights: Array
    estimate: Array
    covariance: Array
    information: Array
    null_space: Array
    scale: Array
    condition: float
    dof: int
    deviation: Array
    shares: Array
    pull: Array

    @property
    def residuals(self) -> Array:
        """τ - Y β, shape (M,)."""
        return np.asarray(self.tau - self.Y @ self.estimate)

    @property
    def errors(self) -> Array:
        """Standard errors, shape (p,); NaN for what is not identifiable."""
        found = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        found[~self.identifiable] = np.nan
        return found

    @property
    def error_dof(self) -> float:
        """Degrees of freedom of a standard error: the fewest from which the noise of one velocity was estimated."""
        left = self.shares[self.shares[:, 0] > 0, 1]
        return max(1.0, float(left.min())) if len(left) else 1.0

    def interval(self, level: float = 0.95) -> Array:
        """Return the interval of each parameter that holds its value with this probability, shape (p, 2)."""
        from scipy.stats import t

        if not 0 < level < 1:
            raise IdentifyError(f"level = {level:g} is no probability; give one between 0 and 1, such as 0.95")
        wide = float(t.ppf(0.5 + level / 2, self.error_dof)) * self.errors
        return np.stack([self.estimate - wide, self.estimate + wide], axis=1)

    def felt(self, direction: Array) -> bool:
        """Whether rows determine a lost direction, in units of `scale`: then noise of the motion hides it."""
        effect = np.linalg.norm((self.Y * self.weights[:, None] / self.scale) @ direction)
        return bool(effect > 1e3 * LEAST * np.linalg.norm(direction))

    def reach(self, level: float = 0.95) -> float:
        """Return the bound of (β - estimate)ᵀ information (β - estimate) that holds with a probability.

        The square is a sum over velocities of chi-square variables over noise estimated from few rows each: mean and
        variance of F distributions, added and matched by one chi-square (Satterthwaite 1946).
        """
        from scipy.stats import chi2

        mean = spread = 0.0
        for taken, left in self.shares:
            if taken > 0:
                n = max(float(left), 5.0)
                mean += taken * n / (n - 2)
                spread += 2 * taken * n**2 * (taken + n - 2) / ((n - 2) ** 2 * (n - 4))
        return float(spread / (2 * mean) * chi2.ppf(level, 2 * mean**2 / spread)) if mean else 0.0

    @property
    def identifiable(self) -> Flags:
        """Whether each parameter is identifiable by itself, shape (p,)."""
        return np.asarray(np.linalg.norm(self.null_space, axis=0) < ALONE)


@dataclass(frozen=True)
class Rows:
    """Rows of one or more motions, before they are solved.

    Attributes:
        Y, tau, joint, frequency: as in `Regression`.
        group: rows of one group are of one frequency of one motion, shape (M,).
        buried: one draw of what noise of the motion makes of Y, shape (M, p); () where there is none.
        force: as measured, where tau is what is left of it, shape (M,); () where tau is.
    """

    Y: Array
    tau: Array
    joint: Indices
    frequency: Array
    group: Indices
    buried: Array = field(default_factory=lambda: np.zeros((0, 0)))
    force: Array = field(default_factory=lambda: np.zeros(0))


def solve(names: Sequence[str], rows: Rows, prior: Array, band: float, joints: int) -> Regression:
    """Return the weighted least squares of rows.

    Args:
        names: of the parameters, shape (p,).
        rows: Y, τ, joint, frequency and group of each; rows of one group are of one frequency of one motion.
        prior: what directions that are not identifiable keep, shape (p,); NaN counts as zero.
        band: highest frequency, Hz.
        joints: how many velocities there are.
    """
    Y, tau, joint = rows.Y, rows.tau, rows.joint
    kept = np.nan_to_num(prior)
    deviation = np.ones(joints)
    for j in range(joints):
        if (of := joint == j).any():
            deviation[j] = max(float(np.sqrt(np.mean((rows.force if rows.force.size else tau)[of] ** 2))), 1e-300)
    variance = deviation[joint] ** 2
    variance = np.where(variance > 1e-200, variance, max(float(variance.max()), 1e-300))
    for _ in range(ROUNDS):
        weights = 1 / np.sqrt(variance)
        beta, leverage, *_ = solved(Y, tau, weights, kept, rows.buried)
        residuals = tau - Y @ beta
        before, variance = variance, _variance(residuals, leverage, joint, rows.frequency / band, joints)
        for of in (joint == j for j in np.unique(joint) if not tau[joint == j].any()):  # what is nothing in all
            variance[of] = np.maximum(variance[of], (BALANCED * np.sqrt(np.mean((Y[of] @ np.diag(beta)) ** 2))) ** 2)
        if np.abs(np.log(variance / before)).max() < 1e-3:
            break
    weights = 1 / np.sqrt(variance)
    beta, leverage, null_space, scale, condition = solved(Y, tau, weights, kept, rows.buried)
    residuals = tau - Y @ beta
    correlation = _correlation(residuals * weights / np.sqrt(1 - leverage), joint, rows.group, joints)
    covariance, information = _covariance(Y * weights[:, None], correlation, joint, rows.group, scale, null_space)
    shares = np.array([(leverage[joint == j].sum(), (1 - leverage[joint == j]).sum()) for j in range(joints)])
    shown = np.array([np.sqrt(np.mean(variance[joint == j])) if (joint == j).any() else np.nan for j in range(joints)])
    pulled = _pulled(Y * weights[:, None], rows.buried, weights, beta, scale, null_space)
    errors = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    return Regression(
        tuple(names), Y, tau, joint, rows.frequency, weights, beta - pulled, covariance, information, null_space, scale,
        condition, len(tau) - (len(beta) - len(null_space)), shown, shares, pulled / errors,
    )  # fmt: skip


def _pulled(weighted: Array, buried: Array, weights: Array, beta: Array, scale: Array, null_space: Array) -> Array:
    """Return by how much noise of the motion pulls an estimate, shape (p,)."""
    if not buried.size:
        return np.zeros(len(beta))
    inside = np.eye(len(beta)) - null_space.T @ null_space
    S, N = weighted / scale, buried * weights[:, None] / scale
    inverse = np.linalg.pinv(inside @ S.T @ S @ inside, rcond=1e-15, hermitian=True)
    return np.asarray(-inverse @ inside @ N.T @ N @ (beta * scale) / scale)


def solved(
    Y: Array, tau: Array, weights: Array, kept: Array, buried: Array
) -> tuple[Array, Array, Array, Array, float]:
    """Return β, leverages, null space, scale, condition; all but one QR of the rows is of their few columns."""
    weighted = Y * weights[:, None]
    scale = np.linalg.norm(weighted, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    Q, R = np.linalg.qr(weighted / scale)
    _, s, Vt = np.linalg.svd(R, full_matrices=len(Y) < Y.shape[1])
    s = np.append(s, np.zeros(Y.shape[1] - len(s)))
    lost = s <= LEAST * s[0]
    null_space = Vt[lost]
    if buried.size:
        felt = Vt[~lost] / s[~lost, None]
        null_space = np.vstack([null_space, hidden(felt, weighted / scale, buried * weights[:, None] / scale)])
    inside = Vt[~lost]
    if len(null_space):
        _, sizes, basis = np.linalg.svd(null_space)
        rank = int(np.sum(sizes > LEAST * sizes[0]))
        null_space, inside = basis[:rank], basis[rank:]
    U, s, Wt = np.linalg.svd(R @ inside.T, full_matrices=False)
    basis = Q @ U
    w = Wt.T @ ((basis.T @ ((tau - Y @ kept) * weights)) / s)
    leverage = np.minimum(np.sum(basis**2, axis=1), MOST)
    return kept + (w @ inside) / scale, leverage, null_space, scale, float(s[0] / s[-1]) if len(s) else np.inf


def _variance(residuals: Array, leverage: Array, joint: Indices, part: Array, joints: int) -> Array:
    """Return the variance of every row by joint and frequency, `part` of the band."""
    found = np.empty(len(residuals))
    for j in range(joints):
        of = joint == j
        if of.any():
            left = 1 - leverage[of]
            found[of] = _coloured(residuals[of] ** 2 / left, left, part[of])
    return found


def _coloured(square: Array, left: Array, f: Array) -> Array:
    """Return the expectation of squares over frequency: constant, and with each term that the data insist on.

    A square counts as what the estimate has `left` of its degree of freedom: rows that the estimate follows show
    no noise, and weights that grow where residuals vanish would run away.
    """
    from scipy.optimize import nnls

    mean = max(float(np.sum(left * square) / np.sum(left)), 1e-300)
    best = np.full(len(square), mean)
    terms = [np.ones_like(f)]
    others = [f**2, f**4, 1 / (1 + (f / 0.1) ** 2)]
    root = np.sqrt(left)
    while others:
        tried = []
        for one in others:
            design, fitted = np.stack([*terms, one], axis=1), best
            for _ in range(6):
                weigh = root / fitted
                fitted = design @ nnls(design * weigh[:, None], square * weigh)[0]
                fitted = np.maximum(fitted, LOW * mean)
            tried.append(fitted)
        gains = [_likely(square, left, fitted) - _likely(square, left, best) for fitted in tried]
        k = int(np.argmax(gains))
        if gains[k] < CLEAR:
            break
        best = tried[k]
        terms.append(others.pop(k))
    return best


def _likely(square: Array, left: Array, variance: Array) -> float:
    """Return twice the logarithm of the likelihood of squares of normal numbers, each of its degrees of freedom."""
    return -float(np.sum(left * (np.log(variance) + square / variance)))


def _correlation(z: Array, joint: Indices, group: Indices, joints: int) -> Array:
    """Return the correlation of joints at equal frequencies, shape (joints, joints)."""
    table = np.zeros((int(group.max()) + 1, joints))
    there = np.zeros_like(table)
    table[group, joint], there[group, joint] = z, 1.0
    count = np.maximum(there.T @ there, 1.0)
    found = table.T @ table / count
    size = np.sqrt(np.maximum(np.diag(found), 1e-300))
    correlation: Array = found / np.outer(size, size)
    correlation = np.where(np.abs(correlation) > SURE / np.sqrt(count), correlation, 0.0)
    np.fill_diagonal(correlation, 1.0)
    return correlation


def _covariance(
    weighted: Array, correlation: Array, joint: Indices, group: Indices, scale: Array, null_space: Array
) -> tuple[Array, Array]:
    """Return covariance and information of β."""
    p = weighted.shape[1]
    inside = np.eye(p) - null_space.T @ null_space
    S = weighted / scale
    cubes = np.zeros((int(group.max()) + 1, len(correlation), p))
    cubes[group, joint] = S
    middle = np.einsum("gjp,jl,glr->pr", cubes, correlation, cubes, optimize=True)
    A = np.linalg.pinv(inside @ (S.T @ S) @ inside, rcond=1e-15, hermitian=True)
    covariance = inside @ A @ middle @ A @ inside
    covariance = (covariance + covariance.T) / 2
    information = np.linalg.pinv(covariance, rcond=1e-14, hermitian=True)
    outer = np.outer(scale, scale)
    return covariance / outer, information * outer


FAR = 6.0
"""Standard deviations, estimated from the median, beyond which a sample is left out."""

ROUNDING = 1e-6
"""Part of the root mean square of a force below which no residual is far."""

GAUSS = 1.4826
"""Standard deviation over median absolute deviation of a normal distribution."""


@dataclass(frozen=True)
class Outlier:
    """One stretch of samples that were left out.

    Attributes:
        source: of the log.
        drive: name of the driving force.
        start, end: times of the first and the last sample, s.
        samples: how many.
        worst: the largest residual there, N m or N.
    """

    source: str
    drive: str
    start: float
    end: float
    samples: int
    worst: float


def far(residuals: Array, used: Flags, tau: Array) -> Flags:
    """Return which samples are far off, shape (N, nv), from residuals of all samples and those that are used."""
    found = np.zeros(residuals.shape, dtype=bool)
    for j in range(residuals.shape[1]):
        own = residuals[used[:, j], j]
        if len(own) < 3:
            continue
        centre = float(np.median(own))
        size = GAUSS * float(np.median(np.abs(own - centre)))
        size = max(size, ROUNDING * float(np.sqrt(np.mean(tau[used[:, j], j] ** 2))))
        found[:, j] = np.abs(residuals[:, j] - centre) > FAR * size
    return found & used


def stretches(out: Flags, residuals: Array, t: Array, source: str, drives: tuple[str, ...]) -> list[Outlier]:
    """Return what was left out as stretches of neighbours, in the order of joints and times."""
    found = []
    for j, drive in enumerate(drives):
        places = np.flatnonzero(out[:, j])
        for part in np.split(places, np.flatnonzero(np.diff(places) > 3) + 1) if len(places) else []:
            worst = residuals[part, j][int(np.abs(residuals[part, j]).argmax())]
            found.append(Outlier(source, drive, float(t[part[0]]), float(t[part[-1]]), len(part), float(worst)))
    return found
