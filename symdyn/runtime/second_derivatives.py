"""All second derivatives of a tree's dynamics as arrays, whose packed ones are compiled.

Those of forward dynamics at any size: what lines would be too many for is products of matrices here.

    T        second derivatives of inverse dynamics at u̇ of forward dynamics, packed ones at their places
    D        its derivatives X u̇ by q, q̇, τ
    M_k      X_k M, shape (nv, nv), entries of T by q and q̈

    X_j X_k u̇ = -M⁻¹ (T_kj + M_k D_j + M_j D_k)        M⁻¹ = ∂u̇/∂τ
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from symdyn.arguments import checked
from symdyn.dynamics import second_derivative_places
from symdyn.errors import ArgumentError, DerivationError
from symdyn.frozen import dataclass
from symdyn.runtime.loaded import lambdify
from symdyn.runtime.numeric_function import NumericFunction
from symdyn.scene import SceneLike, scene_of

Array = npt.NDArray[np.float64]
Places = tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]


class ForwardBlocks(NamedTuple):
    """Second derivatives of u̇, entry i, k, j being X_j X_k u̇_i; those by q̇ and τ, and by τ twice, are zero."""

    q: Array  # k of q, j over q, q̇, τ, shape (nv, nv, 3 nv)
    qd: Array  # k and j of q̇, shape (nv, nv, nv)


@dataclass(frozen=True)
class SecondDerivatives:
    """All second derivatives of a tree's dynamics, one state a call; see `second_derivatives`."""

    nv: int
    forward_dynamics: NumericFunction
    jacobian: NumericFunction
    packed: NumericFunction
    whole: Places
    blocks: Places

    def inverse(self, q: Any, qd: Any, qdd: Any, *params: Any) -> Array:
        """Return those of τ by q, q̇, q̈, shape (nv, 3 nv, 3 nv), N m or N; entry i, k, j is X_j X_k τ_i."""
        found, (to, source) = np.zeros((self.nv, 3 * self.nv, 3 * self.nv)), self.whole
        found.ravel()[to] = self.packed(q, qd, qdd, *params)[source]
        return found

    def forward(self, q: Any, qd: Any, tau: Any, *params: Any) -> ForwardBlocks:
        """Return those of u̇ by q, q̇, τ, rad/s^2 or m/s^2."""
        n = self.nv
        packed = self.packed(q, qd, self.forward_dynamics(q, qd, tau, *params), *params)
        D = self.jacobian(q, qd, tau, *params)
        T, (to, source) = np.zeros(n * n * 4 * n), self.blocks
        T[to] = packed[source]
        by_q, by_qd, by_qdd = np.split(T, (2 * n**3, 3 * n**3))
        S = (by_qdd.reshape(n * n, n) @ D).reshape(n, n, 3 * n)
        S[:, :, :n] += S[:, :, :n].transpose(0, 2, 1).copy()
        S[:, :, : 2 * n] += by_q.reshape(n, n, 2 * n)
        inverse = -D[:, 2 * n :]
        return ForwardBlocks(
            (inverse @ S.reshape(n, -1)).reshape(n, n, 3 * n), (inverse @ by_qd.reshape(n, -1)).reshape(n, n, n)
        )


@checked(ArgumentError)
def second_derivatives(scene: SceneLike, target: str = "c") -> SecondDerivatives:
    """Return all second derivatives of inverse and forward dynamics of a tree, as functions of arrays.

    >>> import numpy as np, symdyn
    >>> from symdyn.runtime import second_derivatives
    >>> arm = second_derivatives(symdyn.example("arm7"))
    >>> arm.inverse(*np.zeros((3, 7))).shape, arm.forward(*np.zeros((3, 7))).q.shape
    ((7, 21, 21), (7, 7, 21))

    Args:
        scene: the mechanism, a tree whose joints have velocities of their own.
        target: as of `lambdify`.

    Raises:
        DerivationError: the scene is no such tree, or has time, inputs or states in its forces, or packed second
            derivatives are too many lines.
    """
    known = scene_of(scene)
    n, at = len(known.velocities), second_derivative_places(known)
    names = "forward_dynamics", "forward_dynamics_derivatives", "inverse_dynamics_second_derivatives_packed"
    place: dict[tuple[int, int, int], int] = {}
    for source, (i, k, j) in enumerate(at.tolist()):
        place[i, j, k] = source
        if j >= 2 * n:
            place[j - 2 * n, k, 2 * n + i] = place[j - 2 * n, 2 * n + i, k] = source
    place |= {(i, k, j): source for source, (i, k, j) in enumerate(at.tolist())}
    (i, k, j), found = np.array(list(place), dtype=np.int64).T, np.array(list(place.values()), dtype=np.int64)
    whole = (9 * n * n * i + 3 * n * k + j, found)
    of_q, of_qd = k < n, (k >= n) & (k < 2 * n) & (j >= n) & (j < 2 * n)
    by_q, by_qdd = of_q & (j < 2 * n), of_q & (j >= 2 * n)
    to = (
        (2 * n * n * i + 2 * n * k + j)[by_q],
        (2 * n**3 + n * n * i + n * (k - n) + j - n)[of_qd],
        (3 * n**3 + n * n * i + n * k + j - 2 * n)[by_qdd],
    )
    blocks = np.concatenate(to), np.concatenate([found[by_q], found[of_qd], found[by_qdd]])
    accelerations, jacobian, packed = lambdify(known, names, target)
    more = {one.name for each in (accelerations, jacobian, packed) for one in each.operands[3:]}
    if beside := sorted(more - {"params"}):
        raise DerivationError(
            f"{known.name}: functions that take {', '.join(beside)} are called by themselves: {names[2]}"
        )
    return SecondDerivatives(n, accelerations, jacobian, packed, whole, blocks)
