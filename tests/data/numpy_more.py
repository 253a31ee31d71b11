"""What lessons ask of NumPy beside what the stand-in has, in as few lines as a pendulum needs."""

import math
from bisect import bisect_left, bisect_right

import numpy as np

np.__version__ = "0+tests"
np.int_ = np.int64
np.nanargmin = lambda x: np.asarray(x).argmin()
np.log10 = lambda x: np._map(math.log10, x)
np.real = lambda x: np.asarray(x).real
np.issubdtype = lambda a, b: True
np.append = lambda a, b: np.concatenate([np.asarray(a).ravel(), np.asarray(b).ravel()])
np.geomspace = lambda a, b, n: np.asarray([a * (b / a) ** (i / (n - 1)) for i in range(n)])
np.searchsorted = lambda a, v, side="left": np._map(
    lambda x: (bisect_left if side == "left" else bisect_right)(np.asarray(a).f, x), v
)


def diff(x, axis=-1):
    """Return what neighbours along an axis differ by."""
    x = np.asarray(x)
    before = [slice(None)] * (axis % x.ndim)
    return x[(*before, slice(1, None))] - x[(*before, slice(None, -1))]


def diagonal(A, axis1=0, axis2=1):
    """Return the diagonals of the last two axes."""
    k = np.arange(A.shape[-1])
    return A[..., k, k]


def stacked(one):
    """Return a function of matrices as one of stacks of them."""

    def of(A, *given, **named):
        A = np.asarray(A)
        if A.ndim == 2:
            return one(A, *given, **named)
        lead = A.shape[:-2]
        made = [one(each, *given, **named) for each in A.reshape((-1, *A.shape[-2:]))]
        if isinstance(made[0], tuple):
            return tuple(np.stack(each).reshape((*lead, *each[0].shape)) for each in zip(*made, strict=True))
        return np.stack(made).reshape((*lead, *np.asarray(made[0]).shape))

    return of


def eig(A):
    """Return eigenvalues, all different, and vectors: roots of the characteristic polynomial, columns of adj(x 1 - A).

    Both by Faddeev and Le Verrier.
    """
    n, M, c = len(A), [np.zeros(A.shape)], [1.0]
    for k in range(1, n + 1):
        M.append(A @ M[-1] + c[-1] * np.eye(n))
        c.append(-sum(np.diagonal(A @ M[-1]).f) / k)
    values = np.roots(c)
    if not any(x.imag for x in values.f):
        values = values.real
    columns = []
    for x in values.f:
        adjugate = sum(M[k + 1] * x ** (n - 1 - k) for k in range(n))
        longest = max(adjugate.T, key=np.linalg.norm)
        columns.append((longest / np.linalg.norm(longest)).tolist())
    return values, np.asarray(columns).T


np.diff, np.diagonal = diff, diagonal
pinv = stacked(np.linalg.pinv)
np.linalg.pinv = lambda A, rcond=1e-15: pinv(A, float(np.asarray(rcond).max()))
np.linalg.eig, np.linalg.eigvals = stacked(eig), stacked(lambda A: eig(A)[0])
for name in ("eigh", "eigvalsh", "inv", "det"):
    setattr(np.linalg, name, stacked(getattr(np.linalg, name)))
