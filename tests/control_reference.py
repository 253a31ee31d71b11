"""What python-control finds for two systems that are written here by hand; prints tests/data/control.json.

    python tests/control_reference.py > tests/data/control.json         (python-control 0.10.2, slycot not needed)

A cart with a pole, upright, its equations from a book: Åström and Murray, Feedback Systems (2008), example 2.1, for a
uniform rod; and the benchmark bicycle at 5 m/s, from M, C1, K0 and K2 of tests/data/bicycle_benchmark.json.
"""

from __future__ import annotations

import json
from pathlib import Path

import control
import numpy as np

BICYCLE = json.loads((Path(__file__).parent / "data" / "bicycle_benchmark.json").read_text())


def cart_pole():
    """Return A, B, C of x, theta, their rates, under a force on the cart: examples/cart_pole.toml, theta upwards."""
    mc, mp, length, b, g = 1.0, 0.1, 0.5, 0.1, 9.81
    half, J = length / 2, mp * length**2 / 12
    M = np.array([[mc + mp, -mp * half], [-mp * half, mp * half**2 + J]])  # theta turns counter-clockwise
    K, D = np.diag([0.0, -mp * g * half]), np.diag([b, 0.0])
    inverse = np.linalg.inv(M)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ K, -inverse @ D]])
    return A, np.vstack([np.zeros((2, 1)), inverse[:, :1]]), np.eye(2, 4)


def bicycle(v=5.0, g=9.81):
    """Return A, B, C of phi, delta, their rates, under a torque on the handlebars."""
    M, C1, K0, K2 = (np.array(BICYCLE[name], dtype=float) for name in ("M", "C1", "K0", "K2"))
    inverse = np.linalg.inv(M)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ (g * K0 + v**2 * K2), -inverse @ (v * C1)]])
    return A, np.vstack([np.zeros((2, 1)), inverse[:, 1:]]), np.eye(2, 4)


def pairs(values):
    return sorted([float(z.real), float(z.imag)] for z in np.atleast_1d(values))


def found(A, B, C, Q, R, period, hertz):
    """Return what python-control finds of a system."""
    system = control.ss(A, B, C, np.zeros((len(C), B.shape[1])))
    sampled = control.c2d(system, period, "zoh")
    K, _, poles = control.lqr(A, B, np.diag(Q), np.diag(R))
    discrete = control.dlqr(sampled.A, sampled.B, np.diag(Q), np.diag(R))[0]
    L, _, filtered = control.lqe(A, B, C, np.eye(B.shape[1]), 1e-4 * np.eye(len(C)))
    response = control.frequency_response(system, 2 * np.pi * np.array(hertz)).frdata
    channels = []
    for i in range(len(C)):
        one = control.ss(A, B, C[[i]], 0)
        channels.append({"zeros": pairs(control.zeros(one)), "poles": pairs(control.poles(one))})
    return {
        "A": A.tolist(), "B": B.tolist(), "C": C.tolist(), "Q": Q, "R": R, "period": period, "hertz": hertz,
        "controllability_rank": int(np.linalg.matrix_rank(control.ctrb(A, B))),
        "observability_rank": int(np.linalg.matrix_rank(control.obsv(A, C))),
        "channels": channels, "lqr": K.tolist(), "lqr_poles": pairs(poles), "dlqr": discrete.tolist(),
        "lqe": L.tolist(), "lqe_poles": pairs(filtered), "zoh_A": sampled.A.tolist(), "zoh_B": sampled.B.tolist(),
        "response_real": response.real[:, 0].tolist(), "response_imaginary": response.imag[:, 0].tolist(),
    }  # fmt: skip


if __name__ == "__main__":
    result = {
        "made_by": f"python tests/control_reference.py, python-control {control.__version__}",
        "cart_pole": found(*cart_pole(), [10.0, 100.0, 0.0, 0.0], [0.1], 0.02, [0.1, 1.0, 10.0]),
        "bicycle": found(*bicycle(), [10.0, 1.0, 0.0, 0.0], [1.0], 0.05, [0.1, 0.7, 5.0]),
    }
    print(json.dumps(result).replace("}, ", "},\n"))
