"""The search of the site as a browser ranks: Sphinx's own searchtools.js under Node, over the index of a build.

python tests/searched.py build/site        fails where the first hit of a word is another page than is meant
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

MEANT = {
    "install": "start", "units": "units", "Jupyter": "equations", "notebook": "equations", "gif": "pictures",
    "state space": "linearize", "degrees of freedom": "scenes", "mass matrix": "python", "noise": "simulate",
    "saturation": "simulate", "step response": "control", "PID": "simulate", "LQG": "control", "solve_ivp": "python",
    "transfer function": "control", "Bode": "control", "Nyquist": "control", "equilibrium": "linearize",
    "linearization": "linearize", "eigenvalues": "linearize", "Coriolis": "equations", "inverse dynamics": "simulate",
    "forward dynamics": "simulate", "reaction forces": "reactions", "closed loop": "scenes",
    "kinematic loop": "scenes", "variable mass": "scenes", "URDF": "robots", "LaTeX": "equations",
    "SymPy": "equations", "C code": "c",
    "MATLAB": "matlab", "Simulink": "from-simulink", "FMU": "fmu", "CasADi": "notebooks/casadi", "JAX": "jax-torch",
    "identification": "identify", "calibration": "identify", "Monte Carlo": "sweeps", "sensitivity": "simulate",
    "limit cycle": "simulate", "gait": "simulate", "Poincaré map": "simulate", "Floquet": "simulate",
    "animation": "pictures",
    "friction": "scenes", "spring": "scenes", "quaternion": "scenes", "LQR": "control", "Kalman": "control",
    "controllability": "control", "root locus": "control", "Lagrange": "equations", "Jacobian": "derivatives",
    "Hamiltonian": "equations", "feedback linearization": "control", "zero dynamics": "control",
    "transmissibility": "recipes", "base excitation": "scenes", "shaking table": "scenes",
    "quarter car": "scenes", "gravity compensation": "howto", "inverted pendulum": "howto",
    "torsion spring": "scenes", "lookup table": "words", "inertia tensor": "words", "minimum time": "collocation",
    "optimal control": "collocation", "inverse kinematics": "simulate", "python-control": "from-control",
    "Pinocchio": "from-pinocchio", "PyDy": "from-sympy", "Simscape": "from-simulink", "CUDA": "targets",
    "simulate": "api/symdyn.simulate", "linearize": "linearize", "lambdify": "api/symdyn.lambdify",
    "backlash": "scenes", "dead zone": "scenes", "cable": "scenes", "pulley": "scenes", "friction cone": "scenes",
    "rise time": "control", "gain margin": "control", "phase margin": "control",
    "dead time": "control", "delay": "control", "model predictive control": "control", "H-infinity": "from-control",
    "feedforward": "control", "hybrid systems": "simulate", "computed torque": "control",
    "license": "targets",
    "foot": "scenes", "restitution": "scenes", "impact": "simulate", "stick-slip": "simulate", "jerk": "simulate",
    "workspace": "simulate", "MPC": "control", "trim": "linearize", "operating point": "linearize",
    "Hessian": "derivatives", "LQI": "control", "integral action": "control", "accelerometer": "control",
    "quaternions": "scenes", "singularity": "simulate", "gear ratio": "scenes", "mobility": "scenes",
    "EKF": "control", "extended Kalman filter": "control", "Tustin": "control", "zero-order hold": "control",
    "bandwidth": "control", "Nichols": "control", "Nichols chart": "control", "model reduction": "control",
    "vibration isolation": "recipes", "PSD": "recipes", "ISO 8608": "recipes", "flywheel": "recipes",
    "balancing": "recipes", "tuned mass damper": "recipes", "Stewart platform": "recipes", "hexapod": "recipes",
    "quadrotor": "recipes", "impedance control": "recipes", "Euler angles": "recipes", "DC motor": "recipes",
    "gyroscope": "gallery/gyroscope", "friction coefficient": "scenes", "moment of inertia": "words", "CAD": "words",
    "centre of mass": "words", "units of plots": "pictures", "plot in degrees": "pictures", "export": "simulate",
    "Excel": "simulate", "CSV": "simulate", "figure for a paper": "pictures",
    "save a figure for a paper": "pictures", "center of mass": "words",
    "moment of inertia from CAD": "words", "export to Excel": "simulate", "export to MATLAB": "simulate",
    "collocation": "collocation", "troubleshooting": "troubleshooting", "quick start": "start",
    "flexible": "recipes", "flexible beam": "recipes", "Campbell diagram": "recipes",
    "parametric excitation": "recipes", "aerodynamic drag": "recipes", "anti-roll bar": "recipes", "tire": "recipes",
    "quantization": "simulate", "sensor noise": "simulate", "event detection": "simulate",
    "trapezoidal velocity profile": "simulate",
    "rotary pendulum": "gallery/furuta", "slew rate": "scenes", "rate limit": "scenes", "Pacejka": "recipes",
    "magic formula": "recipes", "confidence interval": "identify", "constraint stabilisation": "scenes",
    "bang-bang": "collocation", "encoder resolution": "simulate", "cross-validation": "identify",
    "matplotlib style": "pictures", "YAML": "scenes", "eigenvectors": "linearize", "torque ripple": "recipes",
    "seat suspension": "scenes", "tire model": "recipes", "H2 norm": "from-control", "change a parameter": "units",
    "friction compensation": "control", "Luenberger": "control", "LaTeX export": "equations", "subs": "equations",
    "eigenfrequency": "linearize", "minimum effort": "collocation", "obstacle avoidance": "collocation",
    "Arduino": "c", "lumped mass": "recipes", "end effector": "simulate", "multiprocessing": "scale",
    "error propagation": "sweeps", "unilateral constraint": "scenes", "robot arm": "robots",
    "Sobol index": "sweeps", "white noise": "recipes", "parameter values": "units",
}  # fmt: skip
"""Words of the field, and the page that a reader looks for."""

UNMEANT = ("decisions", "architecture", "walkthroughs/")
"""Pages about the inside, and lessons as they come out: no first hit of any of these words."""

SCRIPT = """
const fs = require("fs"), vm = require("vm"), [site, ...words] = process.argv.slice(1);
const world = vm.createContext({
  document: {getElementById: () => null}, _: text => text, _ready: () => {},
  DOCUMENTATION_OPTIONS: {}, SPHINX_HIGHLIGHT_ENABLED: false,
});
const read = (name, more = "") => vm.runInContext(fs.readFileSync(`${site}/${name}`, "utf-8") + more, world);
world.window = world;
read("_static/searchtools.js", "\\nthis.Search = Search;");
read("_static/language_data.js");
read("_static/search_phrases.js");
read("searchindex.js");
const ranked = word => world.Search._performSearch(...world.Search._parseQuery(word)).reverse();
const found = words.map(word => [word, ranked(word).slice(0, 5).map(hit => hit[0] + hit[2])]);
console.log(JSON.stringify(Object.fromEntries(found)));
"""


def ranked(site: Path, words: Iterable[str]) -> dict[str, list[str]]:
    """Return the first five hits of each search, page and section, best first."""
    done = subprocess.run(["node", "-e", SCRIPT, str(site), *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, list[str]] = json.loads(done.stdout)
    return found


def missed(site: Path) -> list[str]:
    """Return a line for each word whose first hit is not the page that is meant."""
    hits = ranked(site, MEANT)
    return [
        f"{word}: {', '.join(hits[word]) or 'nothing'}; meant is {page}"
        for word, page in MEANT.items()
        if not hits[word] or hits[word][0].partition("#")[0] != page or hits[word][0].startswith(UNMEANT)
    ]


if __name__ == "__main__":
    if not shutil.which("node"):
        print("the search is not tried: there is no Node.js")
        sys.exit()
    lines = missed(Path(sys.argv[1]))
    print("\n".join(lines) or f"{len(MEANT)} words lead to the pages that are meant")
    sys.exit(bool(lines))
