"""`symdyn inverse SCENE --motion M`: motion prescribed over time, driving forces and reactions computed."""

from __future__ import annotations

import argparse

from symdyn.cli.scene_options import add_reading_options, read_scene_to_move
from symdyn.cli.talk import Waiting, fail, say
from symdyn.cli.trajectory_options import add_output_options, check_outputs, collected, deliver, flattened
from symdyn.simulation import inverse, read_motion
from symdyn.simulation.prescribed.scene_motion import motion_times


def add_options(verb: argparse.ArgumentParser) -> None:
    """Add what the verb takes."""
    add_reading_options(verb)
    verb.add_argument(
        "--motion",
        nargs="+",
        action="append",
        required=True,
        metavar="M",
        help="coordinate=law: a formula in t, or constant, cubic, quintic, cycloidal, trapezoidal or spline, such as "
        '"q1=quintic(0, pi/2, 2)"; or a .toml or .csv file',
    )
    verb.add_argument("--until", type=float, metavar="T", help="time of the end, s (default: the times of a .csv file)")
    add_output_options(verb)


def run(options: argparse.Namespace) -> int:
    """Compute and write."""
    scene = read_scene_to_move(options)
    entries = flattened(options.motion)
    motion, _, times = collected(
        lambda: read_motion(scene, entries),
        lambda: check_outputs(options),
        lambda: motion_times(entries, options.until, options.every),
    )
    with Waiting() as progress:
        progress(f"computing forces of {scene.name}")
        trajectory = inverse(
            scene,
            motion,  # type: ignore[arg-type]
            times,  # type: ignore[arg-type]
            options.reactions,
            lambda line: say(f"symdyn: {line}"),
        )
    deliver(trajectory, options)
    if trajectory.complete:
        return 0
    fail(f"{trajectory.stopped}; the rows until then are kept")
    return 1
