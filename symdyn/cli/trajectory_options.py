"""What the verbs that end in a trajectory share: its options, and where it goes."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from symdyn.simulation import Trajectory

T = TypeVar("T")


def add_output_options(verb: argparse.ArgumentParser) -> None:
    """Add where the trajectory goes and how dense it is."""
    verb.add_argument("--every", type=float, metavar="DT", help="seconds between samples (default: 200 samples)")
    verb.add_argument(
        "--reactions",
        nargs="?",
        const="body",
        default="",
        metavar="AXES",
        help="columns of all joint reactions and multipliers too; axes: body (of the child, the default), joint (of "
        "the joint frame on the parent) or ground",
    )
    verb.add_argument("-o", "--output", metavar="FILE", help=".csv or .npz (default: CSV on stdout)")
    verb.add_argument("--plot", metavar="FILE", help="a plot: .svg, .png or .html")
    verb.add_argument("--animate", metavar="FILE", help="the mechanism as it moves: .html, or .svg without buttons")


def collected(*parts: Callable[[], object]) -> tuple[object, ...]:
    """Return what the parts return; the faults of all of them together.

    Raises:
        SimulateError: with every fault, one line each.
    """
    from symdyn.errors import SimulateError

    found: list[object] = []
    faults: list[str] = []
    for part in parts:
        try:
            found.append(part())
        except SimulateError as error:
            faults += error.faults
    if faults:
        raise SimulateError(tuple(dict.fromkeys(faults)))
    return tuple(found)


def check_outputs(options: argparse.Namespace) -> None:
    """Raise SimulateError for files that could not be written in the end, before anything is computed."""
    from symdyn.errors import SimulateError
    from symdyn.simulation.plot import check_plot
    from symdyn.simulation.record import check_film, writer_for

    checks: list[Callable[[], object]] = [lambda: _axes(options.reactions)]
    if options.output:
        checks.append(lambda: writer_for(Path(options.output)))
    if options.plot:
        checks.append(lambda: check_plot(Path(options.plot)))
    if options.animate:
        checks.append(lambda: check_film(Path(options.animate)))
    for name in (options.output, options.plot, options.animate):
        if name and not Path(name).parent.is_dir():
            folder = str(Path(name).parent)

            def missing(folder: str = folder, name: str = name) -> None:
                raise SimulateError(f"{name}: there is no folder {folder}")

            checks.append(missing)
    collected(*checks)


def _axes(named: str) -> None:
    from symdyn.scene.values.table import Faults
    from symdyn.simulation.prescribed.formulas_in_time import close
    from symdyn.simulation.reaction_columns import axes_of

    faults = Faults("")
    axes_of(named, faults)
    close(faults)


def deliver(trajectory: Trajectory, options: argparse.Namespace) -> None:
    """Write the trajectory, or print it as CSV; the paths of files that were written go to stdout."""
    import sys

    from symdyn.cli.talk import print_paths
    from symdyn.simulation.plot import plot
    from symdyn.simulation.record import csv_text, film, record

    if options.output:
        record(trajectory, Path(options.output))
        print_paths(options.output)
    elif not (options.plot or options.animate):
        sys.stdout.write(csv_text(trajectory))
    if options.plot:
        plot(trajectory, Path(options.plot))
        print_paths(options.plot)
    if options.animate:
        film(trajectory, Path(options.animate))
        print_paths(options.animate)


def pairs(text: str | None, option: str) -> dict[str, str]:
    """Return name and formula of every part of `q1=0.3,q2=pi/2`.

    Raises:
        SimulateError: a part that is no name=formula.
    """
    from symdyn.scene.values.formula import split_commas
    from symdyn.scene.values.table import Faults
    from symdyn.simulation.prescribed.formulas_in_time import close, words

    faults = Faults("")
    found = words(split_commas(text or ""), option, faults)
    close(faults)
    return found


def flattened(entries: Sequence[Sequence[str]] | None) -> list[str]:
    """Return the words of an option that may be given several times."""
    return [word for words in entries or () for word in words]
