"""What the verbs that end in a trajectory share: its options, and where it goes.

Times on a command line: seconds, or a number with a unit of time.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from symdyn.cli.talk import Bar, give, print_paths, say
from symdyn.draw import Reel, film
from symdyn.emit import check_folder
from symdyn.errors import SimulateError, UnknownNameError
from symdyn.scene import Scene, parse
from symdyn.scene.values import Faults, FormulaError, split_commas
from symdyn.simulation import CHECKS, Feedback, Trajectory, axes_of, feedback_of, read_feedback
from symdyn.simulation.prescribed import words


def reel(options: argparse.Namespace) -> Reel:
    """Return how a film is shown; SimulateError of a size that is none, or words of a film that is not asked for."""
    told = [f"--{name}" for name in ("fps", "size", "once") if getattr(options, name) not in (None, False)]
    if told and not options.animate:
        raise SimulateError(f"{', '.join(told)}: of --animate, which is not given; give --animate FILE too")
    size = re.fullmatch(r"(\d{1,5})(?:x(\d{1,5}))?", options.size) if options.size else None
    if options.size and size is None:
        raise SimulateError(f"--size {options.size}: give width and height in pixels, 1280x720, or a width alone")
    pixels = None if size is None else (int(size[1]), int(size[2])) if size[2] else int(size[1])
    return Reel(options.fps, pixels, not options.once)


def _check_chosen(scene: Scene, options: argparse.Namespace) -> None:
    """Raise SimulateError for columns of a plot that no run has, or that no plot is asked for."""
    if options.plot_columns and not options.plot:
        raise SimulateError("--plot-columns: of --plot, which is not given; give --plot FILE too")
    try:
        groups = ([one] if isinstance(one, str) else one for one in _chosen(options))
        Trajectory.check_columns(scene, [name for some in groups for name in some])
    except UnknownNameError as fault:
        raise SimulateError(f"--plot-columns: {fault}") from None


def _chosen(options: argparse.Namespace) -> list[str | list[str]]:
    """Return the names and patterns that --plot-columns says, those of one panel, `x+theta`, as a list."""
    parts = [part.strip() for part in split_commas(options.plot_columns or "")]
    return [[one.strip() for one in part.split("+")] if "+" in part else part for part in parts if part]


def collected(*parts: Callable[[], object]) -> tuple[object, ...]:
    """Return what the parts return; the faults of all of them together.

    Raises:
        SimulateError: with every fault, one line each.
    """
    faults = Faults("")
    found = [faults.taken(part, None) for part in parts]
    faults.lines[:] = dict.fromkeys(faults.lines)
    faults.close(SimulateError)
    return tuple(found)


def write_table(trajectory: Trajectory, path: Path) -> None:
    """Write a trajectory to a .csv or .npz file."""
    (trajectory.to_csv if path.suffix.lower() == ".csv" else trajectory.to_npz)(path)


def _film(trajectory: Trajectory, path: Path, options: argparse.Namespace) -> None:
    with Bar(f"drawing {path.name}") as progress:
        shown, note = reel(options), lambda line: say(f"symdyn: {line}")
        film(trajectory, path, fps=shown.fps, size=shown.size, loop=shown.loop, reported=progress, note=note)


OUTPUTS: dict[str, tuple[Callable[..., None], Callable[..., None]]] = {
    "output": (lambda path, _: CHECKS["table"](path), lambda found, path, _: write_table(found, path)),
    "plot": (lambda path, _: CHECKS["plot"](path), lambda found, path, more: found.save_plot(path, _chosen(more))),
    "animate": (lambda path, more: CHECKS["film"](path, reel(more)), _film),
}
"""Options that name a file: what raises SimulateError where it cannot be one, and what writes a trajectory there."""


def check_outputs(scene: Scene, options: argparse.Namespace) -> None:
    """Raise SimulateError for files that could not be written in the end, before anything is computed."""
    files = {key: name for key in OUTPUTS if (name := getattr(options, key))}
    collected(
        lambda: _axes(options.reactions),
        lambda: reel(options),
        lambda: _check_chosen(scene, options),
        *(partial(OUTPUTS[key][0], Path(name), options) for key, name in files.items()),
        *(partial(check_folder, Path(name), SimulateError) for name in files.values()),
    )


def _axes(named: str) -> None:
    faults = Faults("")
    axes_of(named, faults)
    faults.close(SimulateError)


def deliver(trajectory: Trajectory, options: argparse.Namespace) -> None:
    """Write the trajectory, or print it as CSV; the paths of files that were written go to stdout."""
    files = options.output or options.plot or options.animate
    if options.json:
        names, table = trajectory.table()
        columns = dict(zip(names, table.T.tolist(), strict=True))
        give(trajectory.about() | ({} if files else {"columns": columns}))
    elif not files:
        sys.stdout.write(trajectory.to_csv())
    for key, (_, write) in OUTPUTS.items():
        if name := getattr(options, key):
            write(trajectory, Path(name), options)
            print_paths(name)


def pairs(text: str | None, option: str) -> dict[str, str]:
    """Return name and formula of every part of `q1=0.3,q2=pi/2`; SimulateError of a part that is no name=formula."""
    faults = Faults("")
    found = words(split_commas(text or ""), option, faults)
    faults.close(SimulateError)
    return found


def controller(scene: Scene, options: argparse.Namespace) -> Feedback | None:
    """Return the controller of --feedback, None where none is asked for.

    Raises:
        SimulateError: with every fault, one line each; or options of a controller that is not given.
    """
    if options.feedback is not None:
        limits = options.limits or ""
        by_name = limits if limits and "=" not in limits else pairs(limits, "--limits")
        found = feedback_of(scene, options.feedback, options.period, options.delay, by_name, options.until or 0.0)
        period = None if options.period is None else read_feedback(scene, options.feedback).period
        if period is not None and options.period != period:
            say(f"--period {options.period:g}: {options.feedback} is made for {period:g} s; its poles are others here")
        return found
    told = [f"--{name}" for name in ("period", "delay", "limits") if getattr(options, name) is not None]
    if told:
        raise SimulateError(f"{', '.join(told)}: of --feedback, which is not given; give --feedback FILE too")
    return None


def reported_forces(scene: Scene, options: argparse.Namespace) -> list[str]:
    """Return what --forces says; of a formula for an input that is in another unit than SI's, say that it is in SI."""
    entries = flattened(options.forces)
    chosen = {one.name: one for one in scene.inputs if one.written}
    parts = (part.partition("=") for one in entries for part in split_commas(one))
    said = [(name.strip(), text.strip()) for name, _, text in parts]
    for name in dict.fromkeys(name for name, text in said if name in chosen and _names_something(text)):
        say(f"{name} is in {chosen[name].unit} here, its file says {chosen[name].written}")
    return entries


def _names_something(text: str) -> bool:
    """Tell whether a text is a formula without a unit that names something, letters of which may stand in SI."""
    try:
        found = parse(text)
    except FormulaError:
        return False
    return bool(found.symbols) and not found.unit


def flattened(entries: Sequence[Sequence[str]] | None) -> list[str]:
    """Return the words of an option that may be given several times."""
    return [word for words in entries or () for word in words]
