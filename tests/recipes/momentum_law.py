"""Recipe: a law is one row. Import this file, and `symdyn verify` proves for every scene that p = ∂K/∂u.

Reference: Landau and Lifshitz, Mechanics (1976), section 40; for quasi-velocities u, Boltzmann and Hamel.
"""

from __future__ import annotations

from symdyn.dynamics import Workspace
from symdyn.graph import gradient
from symdyn.verify import LAWS, Claim, entries, everywhere


def momentum_is_a_slope(w: Workspace) -> Claim:
    """Return that the generalized momentum is the slope of the kinetic energy."""
    (K,) = entries(w, "kinetic_energy")
    return Claim("momentum_law", "dK/dqd", "p", tuple(gradient(K, w.state.qd)), entries(w, "momentum"))


LAWS.append(everywhere(momentum_is_a_slope, "kinetic_energy", "momentum"))
