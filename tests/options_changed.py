"""Every option of every verb with a value that is not the usual one: another answer, other files, or another status.

A row is what stands before an option, and its value; `{}` as a scene is the usual one of the verb.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from symdyn.cli import VERBS, main, parser

HERE = Path(__file__).parent
EXAMPLES = HERE.parent / "examples"
TWO = str(EXAMPLES / "two_link.toml")
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


RUN = f"simulate {CART} --until 0.5 --forces F=cos(9*t) -o run.csv"

ANY = {"--no-units": f"| {UNLIKE}", "--json": ""}
"""Of scenes."""

RUNS = {"--start": "theta=0.5", "--start-rates": "theta=0.5", "--rtol": "1e-3", "--atol": "1e-2", "--method": "radau"}
"""Of runs."""

LOOPS = {"--formulation": "lagrange", "--independent": f"phi | {BAR}", "--baumgarte": f"5,5 | {BAR}"}
"""Of equations."""

SHOWN = {
    "--reactions": "ground",
    "--plot": "run.svg",
    "--plot-columns": "x | --plot run.svg",
    "--animate": "run.svg",
    "--fps": "5 | --animate run.svg",
    "--size": "100x90 | --animate run.svg",
    "--once": "| --animate run.svg",
}
"""Of what is shown of a motion."""

TRIED: dict[str, Verb] = {
    "equations": Verb(
        CART,
        {
            **ANY,
            "--symbolic": f"all | {DOOR}",
            "--bind": "mc=2 | --document",
            "--format": "text",
            "--as": "matrix",
            "--angles": f"short | {TWO}",
            "--document": "",
            "--digits": f"2 | {DOOR} --format text",
        },
    ),
    "walkthrough": Verb(
        f"{CART} -o lesson.md",
        {
            **ANY,
            "--detail": "brief",
            "--until": "energies",
            "--format": "latex",
            "--language": "sk",
            "--road": "dalembert",
            "--exercises": "",
            "--grade": "1 | --exercises",
            "--ask": "velocity | --exercises",
            "--sheet": "questions | --exercises",
            "--seed": "7 | --exercises",
            "--bind": "g=1",
            "--output": "other.md",
        },
    ),
    "generate": Verb(
        f"{CART} -o out --functions mass_matrix,forward_dynamics",
        {
            **ANY,
            **LOOPS,
            "--target": "c",
            "--functions": "mass_matrix",
            "--real": "float | --target c",
            "--accuracy": "1e-10 | --target c --batch",
            "--batch": "| --target c",
            "--header-only": "| --target c",
            "--doubles": "| --target ufunc",
            "--external": "| --target casadi",
            "--mex": "| --target matlab",
            "--prepare": f"| {DOOR} --symbolic all",
            "--static": "",
            "--bind": "g=1",
            "--output": "elsewhere",
        },
    ),
    "simulate": Verb(
        f"{CART} --until 0.4 --start theta=0.05 -o run.csv --method dop853",
        {
            **ANY,
            **RUNS,
            **SHOWN,
            "--until": "0.5",
            "--forces": "F=t",
            "--feedback": "gains.json",
            "--period": "0.1 | --feedback gains.json",
            "--delay": "0.01 | --feedback gains.json --period 0.1",
            "--limits": "F=0.1 | --feedback gains.json --start theta=0.2",
            "--ignore-limits": f"| {CRANK} --start q1=0",
            "--stop": "theta-0.1",
            "--report": "t-0.1",
            "--every": "0.1",
            "--output": "other.csv",
            "--bind": "g=1",
            "--digits": "3",
        },
        (f"linearize {CART} --lqr --gains gains.json",),
    ),
    "sweep": Verb(
        f"{CART} --over mc=[1,2] --measure max(theta) --until 0.1 --start theta=0.3 --method dop853",
        {
            **ANY,
            **RUNS,
            "--over": "mc=[1,3]",
            "--every": "0.05 | --measure mean(theta)",
            "--ignore-limits": f"| {CRANK} --over q1_dot=[2,3] --measure max(q1) --start q1=0",
            "--measure": "min(theta)",
            "--until": "0.2",
            "--design": "sobol | --over mc=uniform(1,2) --count 4",
            "--count": "5 | --over mc=uniform(1,2) --design random",
            "--seed": "5 | --over mc=uniform(1,2) --design random --count 4",
            "--forces": "F=t",
            "--output": "found.zarr",
            "--plot": "found.svg",
            "--plot-kind": "histogram | --plot found.svg",
            "--first-order": "",
            "--bind": "g=1",
        },
    ),
    "inverse": Verb(
        f"{CART} --motion theta=t**2+0.3 --until 0.4 -o forces.csv",
        {
            **ANY,
            **SHOWN,
            "--motion": "x=t**2",
            "--start": "x=0.5",
            "--until": "0.5",
            "--every": "0.1",
            "--output": "other.csv",
            "--bind": "g=1",
        },
    ),
    "linearize": Verb(
        CART,
        {
            **ANY,
            "--at": "theta=pi",
            "--rates": "theta=1 | --anywhere",
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
            "--anywhere": "| --at theta=1",
            "--format": "latex",
            "--transfer": "",
            "--reach": "",
            "--bode": "bode.svg",
            "--dt": "0.1",
            "--bind": "g=1",
        },
        (RUN,),
    ),
    "info": Verb(
        CART,
        {
            **ANY,
            **LOOPS,
            "--symbolic": f"all | {DOOR}",
            "--bind": "g=1",
            "--units": "",
            "--frames": "",
            "--base-parameters": "",
        },
    ),
    "draw": Verb(
        f"{CART} -o cart.svg",
        {
            **ANY,
            "--output": "other.svg",
            "--at": "theta=1",
            "--view": "30,20",
            "--frames": "",
            "--labels": "bodies",
            "--body": "pole",
            "--scheme": "dark",
        },
    ),
    "convert": Verb(
        f"{GRIPPER} made.toml",
        {**ANY, "--no-snap": "", "--floating-base": "base"},
    ),
    "new": Verb("fresh", {"--template": "rrr", "--example": "arm7", "--n": "5 | --template chain", "--json": ""}),
}
"""Verbs that answer soon, with their options."""

ELSEWHERE: dict[str, str] = {
    "--quiet": "what is said beside the answer: tests/test_streams.py",
    "--digits": "of tables: tests/test_cli.py",
    "--no-snap": "of `convert`, by the same reader of scenes",
    "--allow-invalid-inertia": "likewise: tests/test_formats_urdf.py",
    "--spanning-tree": "likewise: tests/test_scene_loops.py",
    "--floating-base": "of `convert`, likewise",
    "--symbolic": "of `info` and `equations`, likewise; code is the same, since names have the values that numbers had",
    "--bind": "of `info` and `equations`, likewise",
    "--force": "writes over files: tests/test_cli_convert.py",
    "--schema": "of no scene: tests/test_scene_schema.py",
    "--watch": "ends with Ctrl-C: tests/test_watch.py",
    "--lossy": "tests/test_formats_urdf_writer.py",
    "--scheduler": "where it is computed: the same numbers, tests/test_sweep_cluster.py",
    "--workers": "likewise",
    "--block": "likewise",
    "--function": "of places: tests/test_sweep_places.py",
    "--at": "likewise",
    "--path": "of an arm: tests/test_inverse_paths.py",
    "--speed": "of what rolls: tests/test_linearize.py",
    "--independent": "of closed scenes: tests/test_linearize.py",
    "--forces": "of scenes with inputs: tests/test_inputs_in_runs.py",
}
"""Options that all verbs share, or nearly all, where they are not in a verb's own table."""


def options_of(verb: str) -> set[str]:
    """Return all options that a verb takes, by their long names."""
    kinds = [one for one in parser()._actions if isinstance(one, argparse._SubParsersAction)]
    taken = kinds[0].choices[verb].complete()._actions
    return {one.option_strings[-1] for one in taken if one.option_strings} - {"--help"}


def outcome(line: str, folder: Path, before: tuple[str, ...] = ()) -> tuple[int, str, str, dict[str, bytes]]:
    """Return status, answer, what is said beside it and files of a line, after others in the same folder, timeless."""
    folder.mkdir()
    told, said, here = io.StringIO(), io.StringIO(), Path.cwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(said):
            for one in before:
                main(one.split())
            told.truncate(told.seek(0))
            said.truncate(said.seek(0))
            status = main(line.split())
    except SystemExit as ended:
        status = int(str(ended.code))
    finally:
        os.chdir(here)
    files = {
        str(path.relative_to(folder)): re.sub(rb"symdyn [^\n]*", b"", path.read_bytes())  # the command that made it
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
    if status == 2:
        raise AssertionError(f"{line}: {said.getvalue()[-300:]}")
    return status, _timeless(told.getvalue()), _timeless(said.getvalue()), files


def _timeless(text: str) -> str:
    """Return what is told without the times that it took, which are others each time."""
    return re.sub(r"[\d.e-]+ s(?= to prepare|, )", "", text)


def lines(verb: str, option: str) -> tuple[str, str]:
    """Return command lines without an option and with it."""
    one = TRIED[verb]
    value, _, beside = (part.strip() for part in one.options[option].partition("|"))
    scene, *rest = one.line.split()
    words = beside.split()
    if words and not words[0].startswith("-"):
        scene, words = words[0], words[1:]
    plain = [verb, scene, *_without(rest, [option, *words][1:]), *words]
    return " ".join(plain), " ".join([*_without(plain, [option]), option, value]).strip()


def _without(words: list[str], options: list[str]) -> list[str]:
    """Return words without options that are said again, and their values."""
    found: list[str] = []
    skip = False
    for word in words:
        named = {"-o": "--output"}.get(word, word)
        if skip and not word.startswith("-"):
            skip = False
            continue
        skip = named.startswith("--") and named in options
        if not skip:
            found.append(word)
    return found


assert set(TRIED) <= set(VERBS)
