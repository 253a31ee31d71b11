"""Derivatives by Pinocchio of a free flyer with a ball and a hinge: reference numbers for tests.

    python tests/pinocchio_derivatives.py tests/data/derivatives_pinocchio.json      with the package pin, and no symdyn

Pinocchio's quaternions are x, y, z, w; they are written here as w, x, y, z. Its tangents are v, ω along the moved axes.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin

BODIES = {  # mass, centre of mass, inertia about it: xx, yy, zz, xy, xz, yz
    "trunk": (3.0, (0.1, -0.2, 0.05), (0.4, 0.5, 0.6, 0.03, -0.02, 0.01)),
    "arm": (1.5, (0.0, 0.1, -0.3), (0.2, 0.15, 0.1, 0.0, 0.01, -0.02)),
    "hand": (0.7, (0.2, 0.0, 0.1), (0.05, 0.06, 0.07, 0.004, 0.003, 0.002)),
}
PLACES = {"ball": ((0.3, 0.1, 0.2), (0.3, -0.4, 0.5)), "hinge": ((0.0, 0.2, -0.6), (0.0, 0.7, 0.0))}


def placed(joint: str) -> pin.SE3:
    """Return the placement of a joint in its parent."""
    shift, angles = PLACES[joint]
    return pin.SE3(pin.rpy.rpyToMatrix(*angles), np.array(shift))


def inertia(body: str) -> pin.Inertia:
    """Return the inertia of a body."""
    mass, com, (xx, yy, zz, xy, xz, yz) = BODIES[body]
    return pin.Inertia(mass, np.array(com), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


def model() -> pin.Model:
    """Return the robot."""
    found, carrier = pin.Model(), 0
    for joint, kind, body in (
        ("flight", pin.JointModelFreeFlyer(), "trunk"),
        ("ball", pin.JointModelSpherical(), "arm"),
        ("hinge", pin.JointModelRX(), "hand"),
    ):
        carrier = found.addJoint(carrier, kind, placed(joint) if joint in PLACES else pin.SE3.Identity(), joint)
        found.appendBodyToJoint(carrier, inertia(body), pin.SE3.Identity())
    return found


def states() -> list[tuple[np.ndarray, ...]]:
    """Return q (quaternions w, x, y, z), velocities and accelerations: as it starts, moving so, and two at random."""
    rng = np.random.default_rng(13)
    start = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0], float)
    found = [(start, np.zeros(10), np.zeros(10)), (start, *rng.uniform(-1, 1, (2, 10)))]
    for _ in range(2):
        q = rng.uniform(-1, 1, 12)
        for k in (3, 7):
            q[k : k + 4] /= np.linalg.norm(q[k : k + 4])
        found.append((q, *rng.uniform(-2, 2, (2, 10))))
    return found


def written(q: np.ndarray) -> np.ndarray:
    """Return coordinates as Pinocchio writes them."""
    found = q.copy()
    for k in (3, 7):
        found[k : k + 4] = np.roll(q[k : k + 4], -1)
    return found


def results(robot: pin.Model, q: np.ndarray, u: np.ndarray, du: np.ndarray) -> dict[str, list]:
    """Return what Pinocchio says of a state."""
    data, theirs = robot.createData(), written(q)
    tau = pin.rnea(robot, data, theirs, u, du).copy()
    found = {"q": q, "qd": u, "qdd": du, "tau": tau}
    pin.computeRNEADerivatives(robot, data, theirs, u, du)
    M = np.triu(data.M) + np.triu(data.M, 1).T
    found["inverse_dynamics_derivatives"] = np.hstack([data.dtau_dq, data.dtau_dv, M])
    data = robot.createData()
    pin.computeABADerivatives(robot, data, theirs, u, tau)
    inverse = np.triu(data.Minv) + np.triu(data.Minv, 1).T
    found["forward_dynamics_derivatives"] = np.hstack([data.ddq_dq, data.ddq_dv, inverse])
    data = robot.createData()
    found["centre_of_mass"] = pin.centerOfMass(robot, data, theirs, u).copy()
    found["centre_of_mass_jacobian"] = pin.jacobianCenterOfMass(robot, data, theirs).copy()
    found["centroidal_momentum_matrix"] = pin.computeCentroidalMap(robot, data, theirs).copy()
    pin.computeCentroidalMomentumTimeVariation(robot, data, theirs, u, np.zeros(10))
    found["centroidal_momentum_bias"] = np.array(data.dhg.vector)
    return {name: np.asarray(one).tolist() for name, one in found.items()}


def main() -> None:
    """Write the file."""
    robot = model()
    facts = {
        "source": f"Pinocchio {pin.__version__}: python tests/pinocchio_derivatives.py FILE",
        "convention": "quaternions w, x, y, z; columns [q | qd | qdd or tau], along v and w of the moved frames",
        "states": [results(robot, *state) for state in states()],
    }
    Path(sys.argv[1]).write_text(
        json.dumps(facts).replace("], [", "],\n[").replace('], "', '],\n"') + "\n", encoding="utf-8"
    )


if __name__ == "__main__":
    main()
