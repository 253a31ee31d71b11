"""Zeros of joints by FIGAROH 1.0.2, run by `calibration.py --figaroh` in an environment that has it.

    PYTHON benchmarks/figaroh_calibration.py FOLDER        FOLDER holds arm.urdf and poses.json; prints JSON

The base and the tool are known; what it estimates are its own joint offsets from positions of the last frame.
"""

import csv
import json
import os
import sys
from pathlib import Path

CONFIG = """
extends: null
robot: {{name: arm7, properties: {{joints: {{active_joints: [{joints}]}}}}}}
tasks:
  calibration:
    enabled: true
    type: kinematic_calibration
    kinematics: {{base_frame: universe, tool_frame: link7}}
    joints: {{active_joints: [{joints}]}}
    parameters: {{calibration_level: joint_offset, outlier_threshold: 1.0}}
    measurements:
      markers: [{{ref_joint: joint7, measurable_dof: [true, true, true, false, false, false]}}]
      poses: {{base_pose: [0, 0, 0, 0, 0, 0], tool_pose: [0, 0, 0, 0, 0, 0]}}
    data: {{source_file: {data}, number_of_samples: {count}}}
"""


def main(folder: Path) -> None:
    """Fit and print estimates with standard deviations by name."""
    import pinocchio
    from figaroh.calibration import BaseCalibration
    from figaroh.calibration.calibration_tools import calc_updated_fkm

    said = json.loads((folder / "poses.json").read_text())
    joints = [f"joint{k}" for k in range(1, 8)]
    data = folder / "poses.csv"
    with data.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["x1", "y1", "z1", *joints])
        rows.writerows([*p, *q] for p, q in zip(said["p"], said["q"], strict=True))
    config = folder / "config.yaml"
    config.write_text(CONFIG.format(joints=", ".join(joints), data=data, count=len(said["q"])))

    arm = folder / "arm.urdf"  # FIGAROH has no offsets of joints without limits
    limit = 'type="revolute"><limit lower="-3" upper="3" effort="9" velocity="9"/>'
    arm.write_text(arm.read_text().replace('type="continuous">', limit))

    class Robot:
        model = pinocchio.buildModelFromUrdf(str(arm))
        data = model.createData()
        q0 = pinocchio.neutral(model)

    class Arm(BaseCalibration):
        def cost_function(self, var):
            return self.PEE_measured - calc_updated_fkm(self.model, self.data, var, self.q_measured, self.calib_config)

    made = Arm(Robot(), str(config))
    made.calib_config |= {"known_baseframe": True, "known_tipframe": True}
    made.initialize()
    made.solve(plotting=False, enable_logging=False)
    made.calc_stddev(made.LM_result)
    names = made.calib_config["param_name"]
    print(json.dumps({n: (float(x), float(s)) for n, x, s in zip(names, made.LM_result.x, made.std_dev, strict=True)}))


if __name__ == "__main__":
    os.environ["MPLBACKEND"] = "Agg"
    main(Path(sys.argv[1]))
