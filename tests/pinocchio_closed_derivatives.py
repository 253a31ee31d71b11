"""Derivatives of constrained dynamics by Pinocchio: the robot of `pinocchio_derivatives`, a point held to the ground.

    python tests/pinocchio_closed_derivatives.py tests/data/closed_derivatives_pinocchio.json    with the package pin

Pinocchio takes coordinates as independent; along the manifold of closed positions and velocities its derivatives are
those that anybody finds. Multipliers are the force of the ground on the hand, axes of the ground.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
from pinocchio_derivatives import model, states, written

POINT = (0.2, 0.1, -0.3)
"""What is held: a point of the hand."""


def results(robot: pin.Model, q: np.ndarray, u: np.ndarray, tau: np.ndarray) -> dict[str, list]:
    """Return what Pinocchio says of a state whose velocity is made to keep the point at rest."""
    held = robot.getJointId("hinge")
    data, theirs, at = robot.createData(), written(q), pin.SE3(np.eye(3), np.array(POINT))
    pin.forwardKinematics(robot, data, theirs)
    place = data.oMi[held] * at
    frame = robot.addFrame(pin.Frame(f"held {robot.nframes}", held, at, pin.FrameType.OP_FRAME))
    data = robot.createData()
    G = pin.computeFrameJacobian(robot, data, theirs, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
    u = u - np.linalg.pinv(G) @ (G @ u)
    contact = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D, robot, held, at, 0, pin.SE3(np.eye(3), place.translation), pin.LOCAL_WORLD_ALIGNED
    )
    models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    models.append(contact)
    datas.append(contact.createData())
    pin.initConstraintDynamics(robot, data, models, datas)
    exact = pin.ProximalSettings(1e-14, 1e-14, 0.0, 1)
    du = pin.constraintDynamics(robot, data, theirs, u, tau, models, datas, exact).copy()
    found = pin.computeConstraintDynamicsDerivatives(robot, data, models, datas, exact)
    by_q, by_u, by_tau, force_by_q, force_by_u, force_by_tau = (np.array(one) for one in found)
    facts = {
        "q": q, "qd": u, "tau": tau, "anchor": place.translation, "qdd": du, "multipliers": data.lambda_c,
        "forward_dynamics": np.hstack([by_q, by_u, by_tau]),
        "force_derivatives": np.hstack([force_by_q, force_by_u, force_by_tau]),
    }  # fmt: skip
    return {name: np.asarray(one).tolist() for name, one in facts.items()}


def main() -> None:
    """Write the file."""
    facts = {
        "source": f"Pinocchio {pin.__version__}: python tests/pinocchio_closed_derivatives.py FILE",
        "convention": "quaternions w, x, y, z; columns [q | qd | tau] along v and w of the moved frames, unprojected",
        "point": POINT,
        "states": [results(model(), q, u, tau) for q, u, tau in states()],
    }
    Path(sys.argv[1]).write_text(
        json.dumps(facts).replace("], [", "],\n[").replace('], "', '],\n"') + "\n", encoding="utf-8"
    )


if __name__ == "__main__":
    main()
