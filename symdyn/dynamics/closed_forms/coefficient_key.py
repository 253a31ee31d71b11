"""Names of Lagrange's coefficients, what they multiply, and how many terms of them are still worth printing."""

from __future__ import annotations

from itertools import combinations
from operator import index
from typing import Any

from symdyn.errors import DerivationError, quoted
from symdyn.graph import Graph
from symdyn.scene import Scene

Key = tuple[Any, ...]  # name and indices from 0, such as ("k_z", 0, 1)

Rates = tuple[tuple[str, int], ...]
"""What a coefficient multiplies: accelerations ("qdd", j) and velocities ("qd", j), j from 0; () for nothing."""

MOST_TERMS = 100_000


def coefficients(n: int) -> dict[str, list[Rates]]:
    """Return the coefficients of Lagrange's equations of n velocities, and what each column of them multiplies.

    τ_i + Q_i = Σ k_z,ij q̈_j + Σ k_C,i,jk q̇_j q̇_k + Σ k_D,ij q̇_j² + k_G,i + k_E,i        sums over j, j < k, j
    """
    return {
        "k_z": [(("qdd", j),) for j in range(n)],
        "k_C": [(("qd", j), ("qd", k)) for j, k in combinations(range(n), 2)],
        "k_D": [(("qd", j), ("qd", j)) for j in range(n)],
        "k_G": [()],
        "k_E": [()],
    }


def check_key(key: object, n: int) -> None:
    """Raise DerivationError unless `key` is that of a coefficient of a mechanism with n coordinates."""
    sizes = {"k_z": (n, n), "k_C": (n, n * (n - 1) // 2), "k_D": (n, n), "k_G": (n,), "k_E": (n,), "K": (), "P": ()}
    name, *places = key if isinstance(key, tuple) and key else (key,)
    shape = sizes.get(name) if isinstance(name, str) else None
    fits = shape is not None and len(places) == len(shape)
    try:  # whole numbers of any library
        fits = fits and all(0 <= index(i) < size for i, size in zip(places, shape or (), strict=True))
    except TypeError:
        fits = False
    if not fits:
        pairs = f"pair in 0..{n * (n - 1) // 2 - 1}" if n > 1 else "no pair, as one coordinate has none"
        raise DerivationError(
            f"there is no coefficient {quoted(key)}; give ('k_z', i, j), ('k_C', i, pair), ('k_D', i, j), ('k_G', i), "
            f"('K',) or ('P',), with i and j in 0..{n - 1} and {pairs}"
        )


def ordered_graph(scene: Scene) -> Graph:
    """Return a graph on which parameters were born first: forms print them in declared order, before coordinates."""
    graph = Graph()
    for parameter in scene.parameters:
        graph.symbol(parameter.name)
    return graph


def too_long(scene: Scene, result: str, else_: str = "") -> DerivationError:
    """Return the error for closed forms that nobody could read; `result` says how long, `else_` what also works."""
    return DerivationError(
        f"the closed form of {scene.name} is too long to be of use: {result}, and {MOST_TERMS} is the limit; "
        f"symdyn generate writes NumPy and C code, which grows with the number of joints only{else_}"
    )
