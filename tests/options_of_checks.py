"""Options of verbs that judge and measure, each with a value that is not the usual one; and what no row can show."""

from __future__ import annotations

from options_tried import BAR, CART, OPTIONS, ROD, TWO, Verb, read

TALK = ("--json", "--quiet", "--digits")

LOG = f"{OPTIONS}/log.csv"
POSES = f"{OPTIONS}/poses.csv"
FILES = f"generate {CART} -o out --functions mass_matrix"

CHECKED: dict[str, Verb] = {
    "check-derivation": Verb(
        f"{OPTIONS}/right.tex {CART}",
        {
            **{option: row.replace("| ", f"| {OPTIONS}/right.tex ") for option, row in read().items()},
            "--symbolic": f"all | {OPTIONS}/energy.tex {OPTIONS}/rod.urdf",
            "--no-snap": f"| {OPTIONS}/energy.tex {OPTIONS}/rod.urdf",
            "--floating-base": f"base | {OPTIONS}/energy.tex {OPTIONS}/rod.urdf",
            "--quiet": f"| {OPTIONS}/energy.tex {OPTIONS}/rod.urdf",
            "--bind": "l=0",
            "--what": f"k_z12 | {OPTIONS}/bare.tex {CART}",
            "--book": f"| {OPTIONS}/book.tex {TWO}",
            "--language": "sk",
            "--json": "",
        },
    ),
    "verify": Verb(
        f"{CART} --functions mass_matrix",
        {
            **read("--targets numpy"),
            "--bind": "mp=0",
            "--functions": "gravity_forces",
            "--formulation": "lagrange",
            "--independent": f"phi | {BAR} --functions forward_dynamics",
            "--baumgarte": f"5,5 | {BAR} --functions forward_dynamics",
            "--prepare": f"| {TWO}",
            "--real": "float",
            "--accuracy": "1e-10 | --targets c",
            "--targets": "js",
            "--files": "out",
            "--seed": "5",
            "--rigorous": "",
            "--at": "theta=0.3 | --rigorous",
            "--states": "1 | --rigorous",
            "--json": "",
            "--digits": "1",
        },
        (FILES,),
    ),
    "identify": Verb(
        f"{CART} {LOG}",
        {
            **read(files=LOG),
            "--symbolic": f"all | {ROD} {LOG} -o found.toml",
            "--bind": "l=0.7",
            "--band": "2",
            "--friction": "all",
            "--hold-back": "0.25",
            "--units": "F=kN",
            "--payload": f"{LOG}:pole:mass=1",
            "--keep-outliers": f"| {CART} {OPTIONS}/outlier.csv",
            "--output": "found.csv",
            "--total-mass": "3 | -o found.toml",
            "--force": "| -o there.toml",
            "--by": f"output-error | {ROD} {LOG} --symbolic all",
            "--parameters": f"fv1 | {ROD} {LOG} --symbolic all --by output-error",
            "--start": f"q1=0.1 | {ROD} {LOG} --symbolic all --by output-error",
            "--excite": f"| {ROD} --terms 2",
            "--box": f"q1=-0.1..0.1 | {ROD} --excite --terms 2",
            "--period": f"2 | {ROD} --excite --terms 2",
            "--family": f"splines | {ROD} --excite --terms 2",
            "--terms": f"3 | {ROD} --excite",
            "--criterion": f"determinant | {ROD} --excite --terms 2",
            "--noise": f"tau1=0.5 | {ROD} --excite --terms 2",
            "--starts": f"2 | {ROD} --excite --terms 2",
            "--seed": f"5 | {ROD} --excite --terms 2",
            "--every": f"0.1 | {ROD} --excite --terms 2",
            "--plot": f"run.svg | {ROD} --excite --terms 2",
            "--json": "",
            "--digits": "2",
        },
        (f"convert {CART} there.toml",),
    ),
    "calibrate": Verb(
        f"{CART} {POSES}",
        {
            **read("--point rod -o found.toml", files=POSES),
            "--bind": "l=0.7",
            "--point": "pole",
            "--parameters": "l,tip.x",
            "--units": "x=mm",
            "--keep-outliers": "",
            "--output": "found.csv",
            "--force": "| -o there.toml",
            "--plot": "run.svg",
            "--json": "",
            "--digits": "2",
        },
        (f"convert {CART} there.toml",),
    ),
    "bench": Verb(
        f"{CART} --quick --no-trajectories --functions mass_matrix --json",
        {
            **read(),
            "--bind": "mp=0",
            "--functions": "gravity_forces",
            "--quick": "",
            "--no-trajectories": "",
            "--seed": "5",
            "--output": "out",
            "--json": "",
        },
    ),
    "stress": Verb(
        f"{CART} --families angles",
        {
            **read(),
            "--bind": "mp=0",
            "--families": "numbers",
            "--output": "out",
            "--json": "",
            "--digits": "1",
        },
    ),
    "completion": Verb("bash", {"--json": ""}),
    "doctor": Verb("", {"--json": ""}),
    "play": Verb("", {}),
}

NOTHING: dict[str, tuple[str, ...]] = {
    "--digits": ("check-derivation", "completion", "convert", "doctor", "draw", "generate", "inverse", "new"),
    "--quiet": ("completion", "doctor", "new"),
}
"""Options of all verbs, and verbs that round no number for people, or say nothing beside their answer."""

ELSEWHERE: dict[tuple[str, str], str] = {
    ("bench", "--digits"): "of times, which differ each time: the same table as of stress, tests/test_shell.py",
    ("info", "--schema"): "of no scene: tests/test_scene_schema.py",
    ("draw", "--watch"): "ends with Ctrl-C: tests/test_playground.py",
    **{("play", option): "ends with Ctrl-C: tests/test_playground.py" for option in (*read(), *TALK, "--bind")},
    ("sweep", "--scheduler"): "where it is computed, the same numbers: tests/test_sweep_cluster.py",
    ("sweep", "--workers"): "likewise: tests/test_sweep.py",
    **{("sweep", option): "of places: tests/test_sweep_places.py" for option in ("--function", "--at")},
    ("inverse", "--path"): "of an arm: tests/test_inverse_paths.py",
    ("inverse", "--branch"): "of an arm: tests/test_arm_branches.py",
    **{("gait", option): "of what returns: tests/test_gait.py" for option in ("--allow-invalid-inertia", "--no-units")},
    ("linearize", "--speed"): "of what rolls: tests/test_linear_control.py",
    ("linearize", "--mode"): "of contacts: tests/test_linearize_contacts.py",
    ("walkthrough", "--math-editor"): "takes a package of npm: tests/test_teach_math_editor.py",
}
"""Options that are shown to do something by another test: verb, option and which."""
