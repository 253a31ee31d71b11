"""`symdyn identify --by output-error`: parameters with which simulated runs are closest to measured ones."""

from __future__ import annotations

import argparse

from symdyn.cli.talk import Waiting, give, print_table, say
from symdyn.cli.trajectory_options import pairs
from symdyn.rounding import finite
from symdyn.scene import Scene
from symdyn.scene.values import split_commas

OUTPUT_ERROR = "output-error"

RUNS = ("parameters", "start")
"""Options that are of output error alone."""


def add_run_options(verb: argparse.ArgumentParser) -> None:
    """Add what output error takes."""
    group = verb.add_argument_group("output error, for closed mechanisms and what is not measured")
    group.add_argument("--by", choices=("regression", OUTPUT_ERROR), default="regression", help="default: regression")
    group.add_argument("--parameters", metavar="LIST", help="names that are looked for; else all that the data tell")
    group.add_argument("--start", metavar="LIST", help="guesses of coordinates at the start that were not measured")


def run_output_error(scene: Scene, options: argparse.Namespace) -> int:
    """Fit runs, print.

    Raises:
        IdentifyError: what the data do not tell.
    """
    from symdyn.identification import output_error

    names = [name for part in split_commas(options.parameters or "") if (name := part.strip())]
    with Waiting() as progress:
        progress("fitting runs")
        found = output_error(scene, options.data, names or None, start=pairs(options.start, "--start") or None)
    for note in found.notes:
        say(note)
    if options.json:
        keys = ("name", "unit", "before", "after", "standard_error")
        numbers = (one.tolist() for one in (found.before, found.estimate, found.standard_errors))
        rows = zip(found.names, found.units, *numbers, strict=True)
        give(
            finite({"estimates": [dict(zip(keys, row, strict=True)) for row in rows], "degrees_of_freedom": found.dof})
        )
        return 0
    print_table(found.table())
    return 0
