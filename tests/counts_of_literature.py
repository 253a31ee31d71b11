"""Operations as the literature counts them: what depends on parameters alone is worked out once for a robot."""

from __future__ import annotations

from collections import Counter

from symdyn.dynamics.mechanism.cost import operations
from symdyn.dynamics.outputs import Counts
from symdyn.dynamics.outputs.named_functions import BINDING, Function


def state_dependent_counts(function: Function) -> Counts:
    """Return the operations of `function` that depend on q, q̇, q̈ or τ. Twice a number is an addition."""
    state = {symbol for a in function.arguments if a.name not in BINDING[0][1] for symbol in a.symbols}
    return Counts(**Counter(operations(function.entries, state)))
