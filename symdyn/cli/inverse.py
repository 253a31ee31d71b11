"""`symdyn inverse SCENE --motion M --path P`: motion prescribed over time, driving forces and reactions computed."""

from __future__ import annotations

import argparse
from dataclasses import replace

from symdyn.cli.scene_options import read_scene_to_move
from symdyn.cli.talk import Waiting, answer, fail, print_table, say
from symdyn.cli.trajectory_options import check_outputs, collected, deliver, flattened, pairs, reported_forces
from symdyn.errors import SimulateError
from symdyn.simulation import Problem, inverse, inverse_kinematics


def branch(text: str) -> int:
    """Return the number of a branch; 0 for a list of all."""
    if text != "all" and not (text.isdecimal() and int(text)):
        raise argparse.ArgumentTypeError(f"{text} is no branch; give 1 for the one next to the start, 2, ..., or all")
    return 0 if text == "all" else int(text)


def run(options: argparse.Namespace) -> int:
    """Compute and write."""
    scene = read_scene_to_move(options)
    laws, paths = flattened(options.motion), flattened(options.path)
    if not laws and not paths and not scene.prescribed_velocities:
        raise SimulateError("nothing says how it moves; give --motion coordinate=law, or --path point=x,y,z")
    problem = Problem(scene, reported_forces(scene, options))
    start, _ = collected(lambda: pairs(options.start, "--start"), lambda: check_outputs(scene, options))
    problem = replace(problem, start=start)  # type: ignore[arg-type]
    if options.branch == 0:
        found = inverse_kinematics(problem, paths, laws)
        for line in found.notes:
            say(line)
        answer(found.as_json(), lambda: print_table(found.table))
        return 0
    span = {"until": options.until, "every": options.every}
    with Waiting(f"computing forces of {scene.name}"):
        told = lambda line: say(f"symdyn: {line}")  # noqa: E731
        trajectory = inverse(problem, laws, (), options.reactions, told, path=paths, branch=options.branch, **span)
    deliver(trajectory, options)
    if trajectory.complete:
        return 0
    fail(f"{trajectory.stopped}; the rows until then are kept")
    return 1
