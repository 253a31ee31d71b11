"""Drake: mass matrices and inverse dynamics of an SDF file at states that came as JSON; run by a Python that has Drake.

    python benchmarks/peers/drake_sdf.py FILE < states > numbers

States and numbers are those of `benchmarks/sdf_drake.py`. Of a free body ours are the velocities in its own axes, and
Drake's those in the world's: v = T v'. Ball joints, which have three angles in Drake, are not compared.
"""

from __future__ import annotations

import json
import sys

import numpy as np
from pydrake.all import MultibodyForces, MultibodyPlant, Parser, Quaternion, RigidTransform, RotationMatrix


def main() -> None:
    """Print the numbers of every state."""
    given = json.load(sys.stdin)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(sys.argv[1])
    plant.mutable_gravity_field().set_gravity_vector(given["gravity"])
    plant.Finalize()
    found = []
    for state in given["states"]:
        context = plant.CreateDefaultContext()
        T = np.zeros((plant.num_velocities(), len(state["v"])))
        i = k = 0
        for name, kind, nq, nv, child in given["joints"]:
            q = np.array(state["q"][i : i + nq])
            if kind == "free":
                body = plant.GetBodyByName(child)
                R = RotationMatrix(Quaternion(q[3:] / np.linalg.norm(q[3:])))
                plant.SetFreeBodyPose(context, body, RigidTransform(R, q[:3]))
                first = body.floating_velocities_start_in_v()
                T[first : first + 3, k + 3 : k + 6] = T[first + 3 : first + 6, k : k + 3] = R.matrix()
            elif nv:
                joint = plant.GetJointByName(name)
                positions = plant.GetPositions(context)
                positions[joint.position_start() : joint.position_start() + nq] = q
                plant.SetPositions(context, positions)
                T[joint.velocity_start() : joint.velocity_start() + nv, k : k + nv] = np.eye(nv)
            i, k = i + nq, k + nv
        M = T.T @ plant.CalcMassMatrix(context) @ T
        tau = None
        if not given["floats"]:
            plant.SetVelocities(context, T @ state["v"])
            forces = MultibodyForces(plant)
            plant.CalcForceElementsContribution(context, forces)
            tau = (T.T @ plant.CalcInverseDynamics(context, T @ state["a"], forces)).tolist()
        found.append({"M": M.tolist(), "tau": tau})
    json.dump(found, sys.stdout)


main()
