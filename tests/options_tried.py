"""Options of verbs that read, move, draw and write scenes, each with a value that is not the usual one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
EXAMPLES = HERE.parent / "examples"
TWO, ARM = str(EXAMPLES / "two_link.toml"), str(EXAMPLES / "arm7.toml")
OPTIONS = HERE / "data" / "options"
ROD, NO_BODY, PUSHED = (str(OPTIONS / name) for name in ("rod.urdf", "no_body.toml", "pushed.toml"))
CART, BAR, DOOR, GRIPPER, CRANK, UNLIKE = (
    str(path)
    for path in (
        EXAMPLES / "cart_pole.toml",
        EXAMPLES / "four_bar.toml",
        HERE / "data" / "door.toml",
        HERE / "data" / "gripper_arm.urdf",
        HERE / "data" / "limited.toml",
        HERE / "data" / "units" / "unlike.toml",
    )
)


@dataclass(frozen=True)
class Verb:
    """A verb as it is called, and its options.

    Attributes:
        line: the scene and what else must be said.
        options: by option its value, and behind | what else stands in both calls.
        before: command lines that are run before, in the same folder.
    """

    line: str
    options: Mapping[str, str]
    before: tuple[str, ...] = ()


def read(beside: str = "", symbolic: str = "", files: str = "") -> dict[str, str]:
    """Return rows of the options that say how a scene is read.

    Args:
        beside: what is said of the robot.
        symbolic: of it where its parameters have names, if it is something else.
        files: what follows every scene.
    """
    robot = f"{ROD} {files} {beside}"
    return {
        "--symbolic": f"all | {ROD} {files} {symbolic or beside}",
        "--no-snap": f"| {robot}",
        "--floating-base": f"base | {robot}",
        "--quiet": f"| {robot}",
        "--allow-invalid-inertia": f"| {NO_BODY} {files}",
        "--spanning-tree": "rail",  # which is refused, since nothing carries the cart then
        "--no-units": f"| {UNLIKE} {files}",
    }


RUN = f"simulate {CART} --until 0.5 --forces F=cos(9*t) -o run.csv"

MOVED: dict[str, Verb] = {
    "equations": Verb(
        CART,
        {
            **read(),
            "--symbolic": f"all | {DOOR}",
            "--bind": "mc=2 | --document",
            "--format": "text",
            "--as": "matrix",
            "--formulation": "dalembert",
            "--angles": f"short | {TWO}",
            "--document": "",
            "--output": "page.tex",
            "--json": "",
            "--digits": f"2 | {DOOR} --format text",
        },
    ),
    "walkthrough": Verb(
        f"{CART} -o lesson.md",
        {
            "--digits": "2",
            **read(),
            "--symbolic": f"inertia | {ROD}",  # lessons have letters for all numbers
            "--detail": "full",
            "--until": "energies",
            "--format": "latex",
            "--language": "sk",
            "--formulation": "dalembert",
            "--exercises": "",
            "--grade": "1 | --exercises",
            "--variants": "2 | --exercises --format stack -o q.xml",
            "--ask": "velocity | --exercises",
            "--sheet": "questions | --exercises",
            "--seed": "7 | --exercises",
            "--json": "",
            "--bind": "g=1",
            "--output": "other.md",
        },
    ),
    "generate": Verb(
        f"{CART} -o out --functions mass_matrix,forward_dynamics",
        {
            **read(),
            "--target": "c",
            "--functions": "mass_matrix",
            "--real": "float | --target c",
            "--accuracy": "1e-10 | --target c --batch",
            "--batch": "| --target c",
            "--header-only": "| --target c",
            "--stack": f"0 | {ARM} --target c --functions inverse_dynamics_derivatives",
            "--doubles": "| --target ufunc",
            "--external": "| --target casadi",
            "--mex": "| --target matlab",
            "--formulation": "lagrange",
            "--independent": f"phi | {BAR}",
            "--baumgarte": f"5,5 | {BAR}",
            "--prepare": f"| {DOOR} --symbolic all",
            "--static": "",
            "--bind": "g=1",
            "--output": "elsewhere",
            "--json": "",
        },
    ),
    "simulate": Verb(
        f"{CART} --until 0.4 --start theta=0.05 -o run.csv --method dop853",
        {
            **read("--start q1=0.1"),
            "--until": "0.5",
            "--forces": "F=t",
            "--feedback": "gains.json",
            "--period": "0.1 | --feedback gains.json",
            "--delay": "0.01 | --feedback gains.json --period 0.1",
            "--limits": "F=0.1 | --feedback gains.json --start theta=0.2",
            "--ignore-limits": f"| {CRANK} --start q1=0",
            "--start": "theta=0.5",
            "--start-rates": "theta=0.5",
            "--stop": "theta-0.1",
            "--report": "t-0.1",
            "--method": "radau",
            "--rtol": "1e-3",
            "--atol": "1e-2",
            "--every": "0.1",
            "--reactions": "ground",
            "--output": "other.csv",
            "--plot": "run.svg",
            "--plot-columns": "x | --plot run.svg",
            "--animate": "run.svg",
            "--fps": "5 | --animate run.svg",
            "--size": "100x90 | --animate run.svg",
            "--once": "| --animate run.svg",
            "--json": "",
            "--bind": "g=1",
            "--digits": "3",
        },
        (f"linearize {CART} --lqr --gains gains.json",),
    ),
    "sweep": Verb(
        f"{CART} --over mc=[1,2] --measure max(theta) --until 0.1 --start theta=0.3 --method dop853",
        {
            "--digits": "2",
            **read(
                "--over q1_dot=[0,1] --measure max(q1) --start q1=0.1",
                "--over m1=[2,3] --measure max(q1) --start q1=0.1",
            ),
            "--over": "mc=[1,3]",
            "--every": "0.05 | --measure mean(theta)",
            "--method": "radau",
            "--ignore-limits": f"| {CRANK} --over q1_dot=[2,3] --measure max(q1) --start q1=0",
            "--measure": "min(theta)",
            "--until": "0.2",
            "--design": "sobol | --over mc=uniform(1,2) --count 4",
            "--count": "5 | --over mc=uniform(1,2) --design random",
            "--seed": "5 | --over mc=uniform(1,2) --design random --count 4",
            "--forces": "F=t",
            "--start": "theta=0.5",
            "--start-rates": "theta=0.5",
            "--rtol": "1e-3",
            "--atol": "1e-2",
            "--output": "found.zarr",
            "--plot": "found.svg",
            "--plot-kind": "histogram | --plot found.svg",
            "--first-order": "",
            "--json": "",
            "--block": "1 | -o found.zarr",
            "--bind": "g=1",
            "--feedback": "gains.json",
            "--period": "0.05 | --feedback gains.json",
            "--delay": "0.01 | --feedback gains.json --period 0.05",
            "--limits": "0.1 | --feedback gains.json --measure max(F)",
        },
        (f"linearize {CART} --lqr --gains gains.json",),
    ),
    "inverse": Verb(
        f"{CART} --motion theta=t**2+0.3 --until 0.4 -o forces.csv",
        {
            **read("--motion q1=t"),
            "--motion": "x=t**2",
            "--start": "x=0.5",
            "--until": "0.5",
            "--every": "0.1",
            "--reactions": "ground",
            "--output": "other.csv",
            "--plot": "run.svg",
            "--plot-columns": "x | --plot run.svg",
            "--animate": "run.svg",
            "--fps": "5 | --animate run.svg",
            "--size": "100x90 | --animate run.svg",
            "--once": "| --animate run.svg",
            "--json": "",
            "--forces": f"u=t | {PUSHED}",
            "--bind": "g=1",
        },
    ),
    "gait": Verb(
        f"{EXAMPLES / 'pendulum.toml'} --section q1 --until 20 --start q1=0.3",
        {
            **{
                name: one
                for name, one in read("--section q1 --start q1=0.3 --forces tau1=-9*q1").items()
                if name not in ("--allow-invalid-inertia", "--no-units")
            },
            "--section": "q1_dot",
            "--swap": "q1=q1",
            "--period": "6.3",
            "--until": "1",
            "--forces": "tau1=0.1",
            "--start": "q1=0.1",
            "--start-rates": "q1=1",
            "--rtol": "1e-6",
            "--over": "b=[0,0.01]",
            "--output": "run.csv",
            "--json": "",
            "--bind": "b=0",
            "--digits": "3",
        },
    ),
    "linearize": Verb(
        CART,
        {
            "--digits": "2",
            **read("", "--over m1=[2,3]"),
            "--start": "theta=pi",
            "--start-rates": "theta=1 | --anywhere",
            "--forces": "F=1 | --anywhere",
            "--along": "run.csv",
            "--lqr": "",
            "--kalman": "",
            "--gains": "gains.json | --lqr",
            "--hertz": "[1,2,5] | --bode bode.csv",
            "--over": "mc=[1,2]",
            "--locus": "locus.csv | --over mc=[1,2]",
            "--output": "found.npz",
            "--animate": "modes.svg",
            "--fps": "5 | --animate modes.svg",
            "--size": "100 | --animate modes.svg",
            "--once": "| --animate modes.svg",
            "--outputs": "theta",
            "--anywhere": "| --start theta=1",
            "--format": "latex",
            "--show": "transfer",
            "--bode": "bode.svg",
            "--dt": "0.1",
            "--json": "",
            "--independent": f"psi | {BAR} --anywhere",
            "--bind": "g=1",
        },
        (RUN,),
    ),
    "info": Verb(
        CART,
        {
            "--digits": f"2 | {ROD} --base-parameters",
            **read(),
            "--symbolic": f"all | {DOOR}",
            "--bind": "g=1",
            "--formulation": "lagrange",
            "--independent": f"phi | {BAR}",
            "--baumgarte": f"5,5 | {BAR}",
            "--units": "",
            "--frames": "",
            "--base-parameters": "",
            "--json": "",
        },
    ),
    "draw": Verb(
        f"{CART} -o cart.svg",
        {
            "--bind": f"a=1.2 | {BAR}",
            **read(),
            "--output": "other.svg",
            "--at": "theta=1",
            "--view": "30,20",
            "--frames": "",
            "--labels": "bodies",
            "--body": "pole",
            "--scheme": "dark",
            "--json": "",
        },
    ),
    "convert": Verb(
        f"{CART} made.toml",
        {
            **read(files="made.toml"),
            "--bind": "g=1",
            "--force": f"| {CART} there.toml",
            "--lossy": f"| {CART} made.urdf",
            "--json": "",
        },
        (f"convert {CART} there.toml",),
    ),
    "new": Verb(
        "fresh",
        {
            "--template": "rrr",
            "--example": "arm7",
            "--n": "5 | --template chain",
            "--force": "| there",
            "--json": "",
        },
        ("new there",),
    ),
}
"""Verbs that answer soon, with their options."""
