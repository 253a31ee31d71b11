"""Derivatives of inverse and forward dynamics, side by side: our generated C, Pinocchio in C++, and CasADi's C.

    python benchmarks/derivatives.py [--quick] [--robots arm7,chain16] [--peers ours_c,pinocchio_cpp] [--rounds 15]
                                     [--docs docs] [-o build/bench/derivatives]

Ours write [∂τ/∂q | ∂τ/∂q̇ | M] and [∂q̈/∂q | ∂q̈/∂q̇ | M⁻¹]; Pinocchio's are computeRNEADerivatives and
computeABADerivatives; CasADi's the jacobians of rnea (beside crba) and aba, and the C of Pinocchio's own derivatives
over its symbols. Where feet are held
to the ground, ours are unprojected and Pinocchio's are computeConstraintDynamicsDerivatives behind constraintDynamics.
All are compared with ours before they are timed, and with 50 digits. Peers and robots that are not installed are
skipped with a note, and so are the bars that are about them:

    pip install -e '.[bench]'
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(Path(__file__).resolve().parent), str(ROOT), str(ROOT / "tests")]

import derivatives_page as page  # noqa: E402
import machine  # noqa: E402
import report  # noqa: E402
from cases import EXAMPLES, Case, chain, tree  # noqa: E402
from harness import Timed, measure  # noqa: E402
from held import Held, held_quadruped  # noqa: E402
from native import FOLDER  # noqa: E402
from peers import ours_c, pinocchio_cpp, pinocchio_held  # noqa: E402
from robots import robot_folder  # noqa: E402
from run import installed, ready, say  # noqa: E402

from symdyn.bench.reference import Reference, reference  # noqa: E402
from symdyn.scene import (  # noqa: E402
    Quantity,
    Scene,
    read,
)

PEERS = ("ours_c", "pinocchio_cpp", "casadi_c", "casadi_analytical")

OUTPUTS = ("inverse_dynamics_derivatives", "forward_dynamics_derivatives")
HELD_OUTPUTS = ("forward_dynamics_unprojected_derivatives",)


class NotInstalledError(Exception):
    """The file of a robot is not here."""


def robot_file(name: str, floating_base: str | None = None) -> Scene:
    """Return a robot of example-robot-data without friction and damping, which Pinocchio's recursions leave out.

    Some of its files have a massless base whose inertia is negative by 1e-22.

    Raises:
        NotInstalledError: without that package.
    """
    folder = robot_folder()
    if folder is None:
        raise NotInstalledError("example-robot-data is not installed")
    found = read(folder / name, floating_base=floating_base, allow_invalid_inertia=True)
    joints = tuple(replace(joint, damping=Quantity.number(0), friction=Quantity.number(0)) for joint in found.joints)
    return replace(found, joints=joints)


ANYMAL, TALOS = "anymal_b_simple_description/robots/anymal.urdf", "talos_data/robots/talos_reduced.urdf"

SCENES: dict[str, Callable[[], Scene]] = {
    "puma560": lambda: read(EXAMPLES / "puma560.toml"),
    "arm7": lambda: read(EXAMPLES / "arm7.toml"),
    "anymal": lambda: robot_file(ANYMAL),
    "chain16": lambda: chain(16),
    "tree32": tree,
    "talos": lambda: robot_file(TALOS),
    "anymal_floating": lambda: robot_file(ANYMAL, "floating"),
    "quadruped": lambda: read(EXAMPLES / "quadruped.toml"),
}
"""Small ones first; the last two float, all others stand on a fixed base."""

ROBOTS = (*SCENES, "quadruped_held")

QUICK = ("puma560", "arm7")

HOLDING = {ours_c: ours_c, pinocchio_cpp: pinocchio_held}
"""Who computes derivatives where points are held, by who computes the others."""


@dataclass(frozen=True)
class Accuracy:
    """Errors of one implementation against 50 digits, over the states that it is timed at.

    Attributes:
        relative: 99th percentile of the largest error of an entry over the largest entry.
        share: largest error of an entry over its own running error bound, which has every operation rounded once.
    """

    relative: float
    share: float


def accuracy(known: Reference, timed: Timed) -> Accuracy:
    """Return the errors of an implementation."""
    errors = known.errors(timed.result())
    largest = np.max(np.abs(known.high), axis=1)
    relative = np.percentile(np.max(errors, axis=1) / largest, 99)
    share = np.max(errors / np.maximum(known.bound, np.finfo(float).tiny))
    return Accuracy(float(relative), float(share))


def main(arguments: list[str] | None = None) -> int:
    """Measure, and write results.json, results.md, and the page if asked."""
    options = parser().parse_args(arguments)
    start, opening = time.monotonic(), machine.load()
    names = options.robots.split(",") if options.robots else list(QUICK if options.quick else ROBOTS)
    unknown = [name for name in names if name not in ROBOTS]
    if unknown:
        there = ", ".join(ROBOTS)
        print(f"benchmarks: there is no robot {', '.join(unknown)}; there are {there}", file=sys.stderr)
        return 2
    rounds, seconds = options.rounds or (5 if options.quick else 15), 0.002 if options.quick else 0.004
    notes: dict[str, None] = {}
    peers = installed(options.peers.split(","), notes)
    known: dict[str, Case] = {}
    measured, errors = [], []
    for name in names:
        try:
            case = known[name] = Case(name, SCENES[name]()) if name in SCENES else held_quadruped()
        except NotInstalledError as fault:
            notes[f"{name}: all of it: {fault}"] = None
            continue
        held = isinstance(case, Held)
        for output in HELD_OUTPUTS if held else OUTPUTS:
            say(f"{name} {output}", start)
            timed = ready(case, output, [HOLDING[peer] for peer in peers if peer in HOLDING] if held else peers, notes)
            exact = reference(function_of(case, output), case.states, len(case.states["q"]))
            errors += [accuracy(exact, one) for one in timed]
            measured += measure(timed, rounds, seconds)
    about = machine.describe(opening, [(peer.NAME, peer.version()) for peer in peers])
    words = ["python benchmarks/derivatives.py", *([" --quick"] if options.quick else [])]
    about |= {"rounds": rounds, "command": "".join(words)}
    found = report.collect(about, known, measured, [], list(notes))
    for row, error in zip(found["times"], errors, strict=True):
        formulation = function_of(known[row["robot"]], row["output"]).formulation
        row |= {"relative": error.relative, "share": error.share, "formulation": formulation}
    write(found, Path(options.output), Path(options.docs) if options.docs else None)
    say("done", start)
    return 0


def function_of(case: Case, output: str) -> Any:
    """Return the function that the code of an output is printed from."""
    return case.programs[output].routines[0].function


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.add_argument("--quick", action="store_true", help="two robots and fewer rounds")
    found.add_argument("--robots", help="names, comma-separated; all by default")
    found.add_argument("--peers", default=",".join(PEERS), help="names, comma-separated; all by default")
    found.add_argument("--rounds", type=int, help="samples of each")
    found.add_argument("--docs", help="folder whose performance.md gets the results")
    found.add_argument("-o", "--output", default=str(FOLDER / "derivatives"), help="folder for results")
    return found


def write(found: dict[str, Any], folder: Path, docs: Path | None) -> None:
    """Write JSON and Markdown, and put the latter into the documentation if asked."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "results.json").write_text(json.dumps(found, indent=1) + "\n", "utf-8")
    text = page.markdown(found)
    (folder / "results.md").write_text(text, "utf-8")
    if docs:
        place = docs / "performance.md"
        place.write_text(page.placed(place.read_text("utf-8"), text), "utf-8")
    print(folder / "results.md")


if __name__ == "__main__":
    sys.exit(main())
