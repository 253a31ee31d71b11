"""How freely a hand moves, from the numbers of its Jacobian: singular values, and their product.

Reference: Yoshikawa, Manipulability of robotic mechanisms, Int. J. Robotics Research 4 (1985) 3.
"""

from __future__ import annotations

from typing import Any

from symdyn.arguments import checked
from symdyn.errors import ArgumentError, choice

PARTS = {"linear": slice(0, 3), "angular": slice(3, 6), "all": slice(None)}


@checked(ArgumentError)
def singular_values(jacobian: Any, part: str = "linear") -> Any:
    """Return the singular values of Jacobians, largest first: half the axes of the ellipsoid of velocities.

    >>> import numpy as np, symdyn
    >>> J = symdyn.lambdify(symdyn.example("puma560"), "jacobian:tool")(np.zeros(6))
    >>> symdyn.dynamics.singular_values(J).round(6).tolist()
    [0.731605, 0.452145, 0.254827]

    Args:
        jacobian: numbers of "jacobian:NAME" in any frame, shape (..., 6, n); any rows with "all".
        part: "linear" for the rows of velocities, "angular", or "all", whose values depend on the unit of length.

    Returns:
        shape (..., k), k the fewer of rows and columns; m or 1.

    Raises:
        ArgumentError: no such part, or no numbers in such rows and columns.
    """
    import numpy as np

    if part not in PARTS:
        raise ArgumentError(f"part = {part!r} is not known; {choice(part, PARTS)}")
    try:
        J = np.asarray(jacobian, dtype=np.float64)
    except (TypeError, ValueError):
        J = np.array(np.nan)
    if J.ndim < 2 or (part != "all" and J.shape[-2] != 6) or not np.isfinite(J).all():
        rows = "rows and columns" if part == "all" else "six rows"
        raise ArgumentError(f"jacobian has shape {J.shape}; give finite numbers in {rows}, those of jacobian:NAME")
    return np.linalg.svd(J[..., PARTS[part], :], compute_uv=False)


@checked(ArgumentError)
def manipulability(jacobian: Any, part: str = "linear") -> Any:
    """Return Yoshikawa's measure of Jacobians, shape (...): √det(J Jᵀ), the product of `singular_values`.

    >>> from symdyn.dynamics import manipulability
    >>> round(float(manipulability([[-1, -1], [1, 0]], "all")), 12)
    1.0

    Args:
        jacobian: likewise; of a planar arm the rows along which it moves, `manipulability(J[:2], "all")`.
        part: likewise, with the same errors.
    """
    import numpy as np

    return np.prod(singular_values(jacobian, part), axis=-1)
