"""What python-control finds for systems that are written here by hand; prints tests/data/control.json.

    python tests/control_reference.py > tests/data/control.json         (python-control 0.10.2, slycot not needed)

A cart with a pole, upright, its equations from a book: Åström and Murray, Feedback Systems (2008), example 2.1, for a
uniform rod; and the benchmark bicycle at 5 m/s, from M, C1, K0 and K2 of tests/data/bicycle_benchmark.json. Two of
several inputs and outputs: the textbook's arm of two links, hanging, with viscous joints (examples/two_link.toml), and
a half-car, whose springs a road moves at both ends: heave and pitch, and the acceleration of heave, which has a D.
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


def second_order(M, D, K, F):
    """Return A and B of M q'' + D q' + K q = F w."""
    n, inverse = len(M), np.linalg.inv(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ K, -inverse @ D]])
    return A, np.vstack([np.zeros((n, F.shape[1])), inverse @ F])


def arm(m1=1.0, m2=2.0, h1=0.4, h2=0.3, g=9.81, b=0.3):
    """Return A, B, C, D of q1, q2, their rates, under both torques."""
    far, both = m2 * h2**2, m2 * h1 * h2
    M = np.array([[(m1 + m2) * h1**2 + far + 2 * both, far + both], [far + both, far]])
    low, high = m2 * g * h2, (m1 + m2) * g * h1
    A, B = second_order(M, b * np.eye(2), np.array([[high + low, low], [low, low]]), np.eye(2))
    return A, B, np.eye(2, 4), np.zeros((2, 2))


def half_car(m=600.0, J=900.0, a=1.2, b=1.5, kf=18e3, kr=22e3, cf=1300.0, cr=1500.0):
    """Return A, B, C, D of heave, pitch, their rates, under the road's heights in front and behind."""
    ends = np.array([[1.0, 1.0], [-a, b]])
    A, B = second_order(
        np.diag([m, J]), ends @ np.diag([cf, cr]) @ ends.T, ends @ np.diag([kf, kr]) @ ends.T, ends @ np.diag([kf, kr])
    )
    return A, B, np.vstack([np.eye(2, 4), A[2]]), np.vstack([np.zeros((2, 2)), B[2]])


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


TIMES, GAINS = 8, [0.5, 2.0, 10.0]
"""Of responses, and of a root locus."""


def answered(system, until, period):
    """Return zeros, responses over time, sampled ones too, of all outputs to all inputs, and what of the first loop.

    Of the first output to the first input these are margins, a root locus, and what is told of a step of the loop.
    """
    t, loop = np.linspace(0.0, until, 401), system[0, 0]
    sampled = control.c2d(system, period, "zoh")
    k = period * np.arange(TIMES)
    step = control.step_response(system, t)
    told = control.step_info(control.feedback(loop, 1), np.linspace(0.0, until, 4001))
    return {
        "A": system.A.tolist(), "B": system.B.tolist(), "C": system.C.tolist(), "D": system.D.tolist(),
        "period": period, "until": until, "poles": pairs(control.poles(system)),
        "zeros": pairs(control.zeros(system[: system.ninputs, :])),
        "margins": [*map(float, control.stability_margins(loop))],
        "sampled_margins": [*map(float, control.stability_margins(control.c2d(loop, period, "zoh")))],
        "step": step.outputs.reshape(system.noutputs, system.ninputs, -1)[:, :, ::50].tolist(),
        "impulse": control.impulse_response(system, t).outputs.reshape(system.noutputs, system.ninputs, -1)[
            :, :, ::50
        ].tolist(),
        "sampled_step": control.step_response(sampled, k).outputs.reshape(system.noutputs, system.ninputs, -1).tolist(),
        "sampled_impulse": control.impulse_response(sampled, k)
        .outputs.reshape(system.noutputs, system.ninputs, -1)
        .tolist(),
        "step_info": {key: float(x) for key, x in told.items()},
        "root_locus": [pairs(row) for row in control.root_locus_map(loop, GAINS).loci],
    }  # fmt: skip


def loop_of(A, B, Q, R):
    """Return what the regulator's loop answers, cut open at the drive, closed: stable, and what of a step is told."""
    return control.ss(A, B, control.lqr(A, B, np.diag(Q), np.diag(R))[0], 0)


def together(A, B, C, Q, R):
    """Return the poles of the loop of a regulator and a filter, and gains that place poles."""
    plant = control.ss(A, B, C, 0)
    K = control.lqr(A, B, np.diag(Q), np.diag(R))[0]
    L = control.lqe(A, B, C, np.eye(B.shape[1]), 1e-4 * np.eye(len(C)))[0]
    controller = control.ss(A - B @ K - L @ C, L, K, 0)
    return {
        "closed_poles": pairs(control.poles(control.feedback(plant, controller))),
        "place": control.acker(A, B, [-2, -3, -4 + 1j, -4 - 1j]).tolist() if B.shape[1] == 1 else None,
    }


if __name__ == "__main__":
    gains = {
        "cart_pole": (*cart_pole()[:2], [10.0, 100.0, 0.0, 0.0], [0.1]),
        "bicycle": (*bicycle()[:2], [10.0, 1.0, 0.0, 0.0], [1.0]),
    }
    result = {
        "made_by": f"python tests/control_reference.py, python-control {control.__version__}",
        "cart_pole": found(*cart_pole(), [10.0, 100.0, 0.0, 0.0], [0.1], 0.02, [0.1, 1.0, 10.0]),
        "bicycle": found(*bicycle(), [10.0, 1.0, 0.0, 0.0], [1.0], 0.05, [0.1, 0.7, 5.0]),
        "answers": {
            **{f"loop of {name}": answered(loop_of(*one), 4.0, 0.02) for name, one in gains.items()},
            "arm": answered(control.ss(*arm()), 12.0, 0.05),
            "half_car": answered(control.ss(*half_car()), 6.0, 0.02),
        },
        "together": {
            "cart_pole": together(*cart_pole(), *gains["cart_pole"][2:]),
            "bicycle": together(*bicycle(), *gains["bicycle"][2:]),
            "arm": together(*arm()[:3], [10.0, 1.0, 0.0, 0.0], [0.1, 0.2]),
        },
    }
    print(json.dumps(result).replace("}, ", "},\n"))
