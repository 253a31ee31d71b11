"""`symdyn simulate SCENE --forces F --until T`: forces prescribed over time, motion computed."""

from __future__ import annotations

import argparse

from symdyn.cli import CTRL_C
from symdyn.cli.scene_options import read_scene_to_move
from symdyn.cli.talk import Bar, fail, say
from symdyn.cli.trajectory_options import check_outputs, collected, controller, deliver, pairs, reported_forces
from symdyn.rounding import in_digits
from symdyn.simulation import Problem, Run, Trajectory, simulate

COARSE, NOTHING = 1e-3, 1e-12
"""Part of the energy by which a balance may be off and still holds, and what is rounding, J."""


def run(options: argparse.Namespace) -> int:
    """Compute, write, and tell how well the laws were kept."""
    scene = read_scene_to_move(options)
    run = Run(
        options.until, options.every, options.method, options.rtol, options.atol, options.stop, options.ignore_limits
    )
    forces, start, feedback, _, _ = collected(
        lambda: Problem(scene, reported_forces(scene, options)).driving,
        lambda: (
            Problem(
                *(scene, reported_forces(scene, options) if scene.rates else ()),
                *(pairs(options.start, "--start"), pairs(options.start_rates, "--start-rates")),
            ).initial
        ),
        lambda: controller(scene, options),
        lambda: check_outputs(scene, options),
        lambda: run.checked(scene, options.report),
    )
    with Bar(f"simulating {scene.name}") as progress:
        trajectory = simulate(
            Problem(scene, forces, start),  # type: ignore[arg-type]
            reports=options.report,
            reactions=options.reactions,
            feedback=feedback,
            progress=progress,
            say=lambda line: say(f"symdyn: {line}"),
            **vars(run),
        )
    deliver(trajectory, options)
    ended = status(trajectory)
    for event in trajectory.events:
        if not event.stops:
            say(f"event: {event.formula} = 0 at t = {event.t!r} s")
    for impact in trajectory.impacts[:SHOWN]:
        say(f"contact: {impact.words}")
    if len(trajectory.impacts) > SHOWN:
        say(f"contact: {len(trajectory.impacts) - SHOWN} more; --json and run.impacts have all of them")
    for line in trajectory.cut_lines:
        say(f"saturation: {line}")
    if not trajectory.ended:
        (fail if ended else say)(ending(trajectory))
    say(balance(trajectory))
    return ended


SHOWN = 20
"""Events of contacts that are told, at most."""


def ending(trajectory: Trajectory) -> str:
    """Return why a run ended before its time."""
    if trajectory.interrupted:
        return f"interrupted at t = {in_digits(float(trajectory.t[-1]), 6)} s; what was computed until then is kept"
    if trajectory.complete:
        return f"stopped: {trajectory.stopped} = 0 at t = {trajectory.events[-1].t!r} s"
    return trajectory.stopped


def balance(trajectory: Trajectory) -> str:
    """Return what a run took, and how well it keeps the laws."""
    steps = f"{trajectory.steps} step{'s' * (trajectory.steps != 1)}"
    times = f"{steps} in {trajectory.wall:.3g} s, {trajectory.preparing:.3g} s to prepare"
    return f"{times}; {errors(trajectory)}"


def errors(trajectory: Trajectory) -> str:
    """Return the largest violations of the laws in words."""
    monitors = trajectory.monitors

    def size(energy: float, digits: int) -> str:
        return trajectory.scene.in_shown_unit(in_digits(energy, digits), "J")

    off, scale = monitors["energy"], monitors["energy_scale"]
    known = "holds to" if off <= max(NOTHING, COARSE * scale) else "is off by"
    parts = [f"energy balance {known} {size(off, 2)} of {size(scale, 3)}"]
    if "loops" in monitors:
        parts.append(
            f"loops to {in_digits(monitors['loops'], 2)}, their rates to {in_digits(monitors['loop_rates'], 2)}"
        )
    if "momenta" in monitors:
        parts.append(f"conserved momenta to {in_digits(monitors['momenta'], 2)}")
    return ", ".join(parts)


def status(trajectory: Trajectory) -> int:
    """Return the exit status: 130 after Ctrl-C, 1 where the integrator gave up."""
    if trajectory.interrupted:
        return CTRL_C
    return 0 if trajectory.complete else 1
