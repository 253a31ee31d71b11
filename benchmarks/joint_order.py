"""What numbers in another tool's order of joints are worth: `python benchmarks/joint_order.py`.

Pinocchio's order of the joints of ANYmal and Talos, taken for ours: how far inverse dynamics is off then, over its
largest entry, at five random states. Needs Pinocchio and example-robot-data (`pip install -e '.[bench]'`).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parent.parent / "tests")]

ROBOTS = {
    "anymal": "anymal_b_simple_description/robots/anymal.urdf",
    "talos": "talos_data/robots/talos_reduced.urdf",
}


def main() -> None:
    """Print the least and the largest error of each robot."""
    import pinocchio
    from robots import robot_folder

    import symdyn

    folder = robot_folder()
    if folder is None:
        raise SystemExit("example-robot-data is not installed: pip install -e '.[bench]'")
    for name, path in ROBOTS.items():
        file = str(folder / path)
        model = pinocchio.buildModelFromUrdf(file, pinocchio.JointModelFreeFlyer())
        robot = symdyn.read(file, floating_base="root_joint", snap=False)
        order = robot.order(list(model.names)[1:], quaternion="xyzw")
        function, rng, off = symdyn.lambdify(robot, "inverse_dynamics"), np.random.default_rng(1), []
        for _ in range(5):
            q, v, a = rng.uniform(-np.pi, np.pi, len(robot.coordinates)), *rng.normal(size=(2, len(robot.velocities)))
            q[3:7] /= np.linalg.norm(q[3:7])  # as Pinocchio has it, with w last
            right = [np.empty_like(one) for one in (q, v, a)]
            right[0][order.q], right[1][order.v], right[2][order.v] = q, v, a
            taken = np.concatenate([q[:3], q[[6, 3, 4, 5]], q[7:]])
            known = function(*right)[order.v]
            off.append(float(np.abs(function(taken, v, a) - known).max() / np.abs(known).max()))
        print(f"{name}: {100 * min(off):.2g} to {100 * max(off):.2g} % of the largest entry")


if __name__ == "__main__":
    main()
