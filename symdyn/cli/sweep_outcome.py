"""What `symdyn sweep` tells of runs beside their summary: plots, Sobol's indices, error bars to first order."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from symdyn.cli.talk import print_table, say, wrote
from symdyn.errors import SimulateError
from symdyn.rounding import in_digits
from symdyn.simulation import Problem, Run
from symdyn.study import Runs, beside, check_study_plot
from symdyn.table import Table

DIGITS = 4


def check_outcome(options: argparse.Namespace) -> None:
    """Raise SimulateError for what could not be told in the end."""
    check_study_plot(None if options.plot is None else Path(options.plot), options.plot_kind)
    if options.plot is None and options.plot_kind is not None:
        raise SimulateError("--plot-kind: of --plot FILE, which is not given")
    if options.first_order and options.function is not None:
        raise SimulateError("--first-order is of runs, and --function makes none; leave one of the two away")


def report_outcome(runs: Runs, problem: Problem, run: Run, options: argparse.Namespace) -> dict[str, Any]:
    """Print and write what is asked for; return the same for JSON."""
    told: dict[str, Any] = {}
    if runs.has_indices:
        told["indices"] = _indices(runs, options.json)
    if options.first_order:
        told["first_order"] = _first_order(runs, problem, run, options)
    if options.plot is not None:
        runs.save_plot(options.plot, kind=options.plot_kind)
        wrote(options.plot)
    return told


def _indices(runs: Runs, quiet: bool) -> dict[str, Any]:
    """Return Sobol's indices of all measures, and print them."""
    told: dict[str, Any] = {}
    rows = []
    for measure in runs.measures:
        try:
            found = runs.indices(measure)
        except SimulateError as fault:  # too few runs have a value: the others are told
            say(str(fault))
            continue
        for note in found.notes:
            say(note)
        told[measure] = {
            name: {
                "first": float(found.first[k]), "first_interval": found.first_interval[k].tolist(),
                "total": float(found.total[k]), "total_interval": found.total_interval[k].tolist(),
            }
            for k, name in enumerate(found.names)
        }  # fmt: skip
        for name, one in told[measure].items():
            shown = (
                in_digits(one[key], DIGITS) + " (" + " … ".join(in_digits(x, 2) for x in one[f"{key}_interval"]) + ")"
                for key in ("first", "total")
            )
            rows.append((measure, name, *shown))
    if rows and not quiet:
        heads = ("measure", "name", "first order", "total")
        print_table(Table(heads, rows, (2, 3), "Sobol's indices, with 95 % intervals"))
    return told


def _first_order(runs: Runs, problem: Problem, run: Run, options: argparse.Namespace) -> dict[str, Any]:
    """Return standard deviations both ways, and print them."""
    found = beside(runs, problem, run, options.over, options.measure)
    rows = []
    for one in found:
        shares = ", ".join(f"{name} {in_digits(100 * part, 3)} %" for name, part in one.shares.items())
        unit = runs.units.get(one.measure, "")
        rows.append((one.measure, unit, in_digits(one.first_order, 6), in_digits(one.runs, 6), shares))
        if not one.near:
            say(
                f"{one.measure}: sd {in_digits(one.first_order, 3)} to first order, {in_digits(one.runs, 3)} over "
                f"{len(runs)} runs: it is not linear over what varies; trust the runs"
            )
    if not options.json:
        heads = ("measure", "unit", "first order", "runs", "variance is due to")
        print_table(Table(heads, rows, (2, 3), "standard deviations"))
    return {
        one.measure: {"first_order": one.first_order, "runs": one.runs, "shares": dict(one.shares), "near": one.near}
        for one in found
    }
