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

SEARCHES = {
    "recipes#two-link-arm-double-pendulum": ("two-link arm", "double pendulum", "planar manipulator"),
    "recipes#slider-crank-at-constant-speed-driving-torque-and-joint-reactions": (
        "slider-crank", "torque at constant speed",
    ),
    "recipes#motor-with-a-gear": ("motor with gear ratio", "reflected inertia", "rotor inertia"),
    "scenes#velocity-constraints-rolling-contact-knife-edges-formulas": ("rolling without slipping",),
    "words#bodies": ("inertia from CAD", "centre of mass offset", "point mass"),
    "words#springs": ("spring preload",),
    "scenes#contacts-stops-and-dry-friction": ("end stop", "contact", "contact force"),
    "simulate#limits-of-joints": ("joint limit",),
    "scenes#ropes": ("rope over a pulley",),
    "scenes#gears-racks-screws-worms": ("belt drive",),
    "scenes#springs-dampers-friction-and-loads": ("viscous friction", "friction model", "bearing friction"),
    "scenes#user-defined-states-actuators-filters-controllers": ("hydraulic cylinder",),
    "words#top-level": ("gravity direction",),
    "robots#coordinates-poses-base": ("floating base",),
    "scenes#joints": ("generalized coordinates",),
    "simulate#forward-dynamics-the-motion-under-forces": (
        "initial velocity", "initial conditions", "random disturbance force",
    ),
    "simulate#inverse-dynamics-the-forces-of-a-motion": ("waypoints", "joint torque"),
    "recipes#vibration-isolation-and-transmissibility": ("sinusoidal base excitation", "harmonic excitation"),
    "simulate#integrators": ("step size", "DAE index"),
    "simulate#monitors-energy-momentum-contact-forces": ("energy drift",),
    "simulate#feedback-controllers-sampling-saturation": (
        "noise and sampled controller", "digital control", "disturbance", "measurement noise",
    ),
    "simulate#inverse-kinematics-paths-of-a-point-or-frame": ("path following", "singular configuration"),
    "pictures#animations-and-films-html-gif-mp4": ("animation without notebook", "save animation"),
    "units": ("angle in degrees", "units degrees", "degrees to radians"),
    "reactions": ("constraint force", "joint reaction forces"),
    "reactions#multipliers": ("Lagrange multiplier",),
    "reactions#what-a-reaction-contains": ("bending moment",),
    "control#lqr-and-kalman-gains": ("LQR weights", "Kalman noise units", "process noise covariance"),
    "control#pole-placement-state-feedback-with-an-observer": (
        "pole placement", "state feedback with observer", "observer poles",
    ),
    "control#gain-phase-and-delay-margins": ("margin",),
    "control#poles-zeros-frequency-responses": ("Bode diagram",),
    "control#step-response": ("settling time",),
    "simulate#lqr-pid-transfer-functions-observers": (
        "PD controller", "PI controller", "lead compensator", "notch filter",
    ),
    "control#sampled-discrete-time-systems": ("discretize",),
    "linearize#eigenvalues-modes-and-stability": ("resonance",),
    "linearize#in-python": ("equilibria python", "eigenvalue formula"),
    "identify#motor-currents-instead-of-forces": ("payload identification motor current",),
    "words#frames-and-axes": ("tilted axis",),
    "identify#viscous-and-coulomb-friction-from-a-log": ("friction identification",),
    "identify": ("identify parameters from data", "inertia identification", "measured data"),
    "sweeps": (
        "parameter sweep 1000 values parallel", "tolerance of parts", "Monte Carlo simulation", "parameter study",
        "parameter uncertainty",
    ),
    "sweeps#sensitivity-analysis-sobol-indices": ("Sobol sensitivity", "sensitivity analysis"),
    "collocation": ("rest to rest", "warm start initial guess solver"),
    "identify#method": ("time delay in torque measurement",),
    "performance-of-runs": ("real-time factor speed of simulation", "how long does a run take"),
    "troubleshooting#slow-or-not-compiled": ("simulation gets stuck", "simulation diverges"),
    "derivatives": ("jacobian of end effector",),
    "equations#sympy-matrices": ("mass matrix sympy", "state space form symbolic",),
    "scenes#inputs-and-outputs": ("time varying input",),
    "pictures#plots-of-runs": ("phase portrait", "plot own axes"),
    "excitation": ("optimal excitation trajectory", "persistent excitation condition number"),
    "simulate#export-csv-excel-matlab-pandas-xarray": ("save and load a run",),
    "from-simulink": ("simulink s-function",),
    "lessons": ("lecture notes",),
    "equations#functions-of-these-formulations": ("Kane's method",),
    "collocation#cost-constraints-and-bounds": ("free final time", "torque limit"),
    "fmu": ("export to Simulink", "export to Modelica"),
    "equations": ("symbolic equations of motion",),
    "linearize": ("small angle approximation",),
}  # fmt: skip
"""Pages, or their sections, and what a student or a control engineer types who looks for them."""

MEANT |= {search: where for where, searches in SEARCHES.items() for search in searches}

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
    """Return a line for each search whose first hit is not the page, or the section, that is meant."""
    hits = ranked(site, MEANT)
    return [
        f"{word}: {', '.join(hits[word]) or 'nothing'}; meant is {where}"
        for word, where in MEANT.items()
        if not any(where in (hit, hit.partition("#")[0]) for hit in hits[word][:1]) or hits[word][0].startswith(UNMEANT)
    ]


if __name__ == "__main__":
    if not shutil.which("node"):
        print("the search is not tried: there is no Node.js")
        sys.exit()
    lines = missed(Path(sys.argv[1]))
    print("\n".join(lines) or f"{len(MEANT)} words lead to the pages that are meant")
    sys.exit(bool(lines))
