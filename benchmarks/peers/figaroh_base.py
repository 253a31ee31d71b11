"""FIGAROH's base parameters of a log: run by the Python that has it, `python figaroh_base.py FOLDER`.

Its regressor with friction, its elimination of columns that do nothing, its decimation of both sides, and its base
parameters by QR, which are least squares. It is not weighted, as `get_baseParams` is not.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np
from figaroh.tools.qrdecomposition import QRDecomposer
from figaroh.tools.regressor import build_regressor_basic, build_regressor_reduced, get_index_eliminate
from figaroh.tools.robot import Robot
from scipy.signal import decimate

OPTIONS = {
    "is_joint_torques": True, "is_external_wrench": False, "force_torque": None, "has_friction": True,
    "has_actuator_inertia": False, "has_joint_offset": False, "act_idxv": list(range(99)),
}  # fmt: skip


def main(folder: Path) -> None:
    """Print seconds and how many parameters there are; write torques of the fresh motion."""
    data = np.load(folder / "log.npz")
    robot = Robot(str(folder / "arm.urdf"), package_dirs=str(folder))
    begin = time.perf_counter()
    W = build_regressor_basic(robot, data["q"], data["qd"], data["qdd"], OPTIONS)
    count, n = data["tau"].shape
    names = [f"p{k}" for k in range(W.shape[1])]
    dead, _ = get_index_eliminate(W, dict.fromkeys(names, 0.0), 1e-6)
    W, kept = build_regressor_reduced(W, dead), [name for k, name in enumerate(names) if k not in dead]
    factor = max(1, int(0.4 / (float(data["band"]) * float(data["step"]))))
    rows = [decimate(one, factor, axis=0, zero_phase=True) for one in W.reshape(n, count, -1)]
    tau = np.concatenate([decimate(one, factor, zero_phase=True) for one in data["tau"].T])
    solver = QRDecomposer()
    values = solver.double_decomposition(tau, np.vstack(rows), kept)[3]
    seconds = time.perf_counter() - begin
    fresh = build_regressor_basic(robot, data["q_new"], data["qd_new"], data["qdd_new"], OPTIONS)
    fresh = build_regressor_reduced(fresh, dead)[:, solver.base_indices]
    np.save(folder / "tau.npy", (fresh @ values).reshape(n, -1).T)
    print(json.dumps({"seconds": seconds, "count": len(values)}))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
