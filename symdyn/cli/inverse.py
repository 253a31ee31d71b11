"""`symdyn inverse SCENE --motion M --path P`: motion prescribed over time, driving forces and reactions computed."""

from __future__ import annotations

import argparse
from dataclasses import replace

from symdyn.cli.scene_options import add_reading_options, read_scene_to_move
from symdyn.cli.talk import Waiting, fail, say
from symdyn.cli.trajectory_options import (
    add_output_options,
    check_outputs,
    collected,
    deliver,
    flattened,
    pairs,
    reported_forces,
    seconds,
)
from symdyn.errors import SimulateError
from symdyn.simulation import Problem, inverse, motion_times, read_motion, read_path


def add_options(verb: argparse.ArgumentParser) -> None:
    """Add what the verb takes."""
    add_reading_options(verb)
    verb.add_argument(
        "--motion",
        nargs="+",
        action="append",
        metavar="M",
        help="coordinate=law: a formula in t, or constant, cubic, quintic, cycloidal, trapezoidal or spline, such as "
        '"q1=quintic(0, pi/2, 2)"; or a .toml or .csv file',
    )
    verb.add_argument(
        "--path",
        nargs="+",
        action="append",
        metavar="P",
        help='point=x, y, z: laws of its place in ground axes, _ where it is free, such as "tool=0.5, 0.1*t, _"; '
        "behind them rpy(roll, pitch, yaw), quaternion(w, x, y, z) or pointing(z, a, b, c); or point=FILE.csv, or a "
        ".toml file",
    )
    verb.add_argument(
        "--start",
        metavar="LIST",
        help="coordinates, e.g. q1=0.3,q2=pi/2, in place of the scene's: where those without a law rest, and of "
        "several solutions, next to which one is taken",
    )
    verb.add_argument(
        "--forces",
        nargs="+",
        action="append",
        metavar="F",
        help='of inputs what is given over time, such as "u=12*sin(t)"; or a .toml or .csv file',
    )
    verb.add_argument(
        "--until", type=seconds, metavar="T", help="time of the end, s (default: the times of a .csv file)"
    )
    add_output_options(verb)


def run(options: argparse.Namespace) -> int:
    """Compute and write."""
    scene = read_scene_to_move(options)
    laws, paths = flattened(options.motion), flattened(options.path)
    if not laws and not paths:
        raise SimulateError("nothing says how it moves; give --motion coordinate=law, or --path point=x,y,z")
    problem = Problem(scene, reported_forces(scene, options))
    motion, path, _, times, start, _ = collected(
        lambda: read_motion(scene, laws),
        lambda: read_path(scene, paths),
        lambda: problem.inputs,
        lambda: motion_times(laws, paths, options.until, options.every),
        lambda: pairs(options.start, "--start"),
        lambda: check_outputs(scene, options),
    )
    problem = replace(problem, start=start)  # type: ignore[arg-type]
    with Waiting() as progress:
        progress(f"computing forces of {scene.name}")
        told = lambda line: say(f"symdyn: {line}")  # noqa: E731
        trajectory = inverse(problem, motion, times, options.reactions, told, path=path)  # type: ignore[arg-type]
    deliver(trajectory, options)
    if trajectory.complete:
        return 0
    fail(f"{trajectory.stopped}; the rows until then are kept")
    return 1
