"""How well a computed motion keeps the laws of mechanics: energy balance, constraints, conserved momenta.

The balance is K + P - W less its value at the start, where W is the work of drives, damping, friction and loads,
integrated along; P holds gravity and springs.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from symdyn.simulation.equations.state_equations import StateEquations

Array = npt.NDArray[np.float64]


def observe(system: StateEquations, t: Array, x: Array) -> tuple[dict[str, Array], dict[str, float]]:
    """Return columns of energies, powers and residuals at states x, shape (N, nx), and the largest violations."""
    K, P = (np.broadcast_to(system.tell(name, t, x).reshape(-1), t.shape) for name in ("kinetic", "potential"))
    columns = {"kinetic_energy": K, "potential_energy": P}
    W = x[:, -1] if system.works else np.zeros_like(t)
    if system.works:
        power = system.tell("power", t, x)
        columns |= {"drive_power": power[..., 0], "other_power": power[..., 1], "work": W}
    columns["energy_error"] = (K + P - W) - (K[0] + P[0] - W[0])
    monitors = {"energy": _largest(columns["energy_error"]), "energy_scale": _largest(np.abs(K) + np.abs(P - P[0]))}
    if system.closed:
        for name, told in (("loop_error", "constraint_residual"), ("loop_rate_error", "row_rates")):
            columns[name] = np.abs(system.tell(told, t, x)).max(axis=-1, initial=0.0)
        monitors |= {"loops": _largest(columns["loop_error"]), "loop_rates": _largest(columns["loop_rate_error"])}
    if system.quaternions:
        lengths = [np.abs(np.einsum("ni,ni->n", x[:, part], x[:, part]) - 1.0) for part in system.quaternions]
        monitors["quaternions"] = max(_largest(one) for one in lengths)
    if system.momenta:
        places = [system.told.index(k) for k in system.conserved]
        values = system.tell("momenta", t, x).reshape(len(t), -1)[:, places]
        columns |= {name: values[:, k] for k, name in enumerate(system.momenta)}
        monitors["momenta"] = _largest(values - values[0])
    return columns, monitors


def _largest(values: Array) -> float:
    return float(np.max(np.abs(values), initial=0.0))
