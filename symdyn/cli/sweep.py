"""`symdyn sweep SCENE --over "m1=linspace(1,2,100)" --measure "max(abs(tau2))"`: one scene at many values."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from symdyn.cli import CTRL_C
from symdyn.cli.scene_options import read_scene
from symdyn.cli.talk import Bar, fail, give, print_paths, print_table, say, wrote
from symdyn.cli.trajectory_options import controller, pairs, reported_forces
from symdyn.emit import check_folder
from symdyn.errors import SimulateError
from symdyn.rounding import in_digits
from symdyn.simulation import Problem, Run
from symdyn.study import SUFFIX, Runs, beside, check_study_plot, sweep
from symdyn.table import Table

TABLE = ".csv"

DIGITS = 6
FEW_DIGITS = 4  # of what comes of runs beside their summary

AS_SAID = ("design", "count", "seed", "scheduler", "workers", "block", "function", "at")
"""Options that are arguments of `symdyn.sweep`."""

ROWS = 20  # of a grid that are shown one by one

FAILED = 3
"""Runs that did not end that are told on a terminal; `told` of the runs has more."""


def run(options: argparse.Namespace) -> int:
    """Compute and tell."""
    scene = read_scene(options)
    file = None if options.output is None else Path(options.output)
    _check_outcome(file, options)
    start, rates = pairs(options.start, "--start"), pairs(options.start_rates, "--start-rates")
    problem = Problem(scene, reported_forces(scene, options), start, rates)
    run = {name: one for name, one in vars(options).items() if name in Run.Fields.__annotations__ and one is not None}
    with Bar(f"sweeping {scene.name}") as progress:
        runs = sweep(
            problem,
            options.over,
            options.measure,
            feedback=controller(scene, options),
            output=file if file is not None and file.suffix == SUFFIX else None,
            progress=progress,
            say=say,
            **{name: getattr(options, name) for name in AS_SAID},
            **run,
        )
    if file is not None:
        if file.suffix == TABLE:
            runs.to_csv(file)
        print_paths(file)
    nothing = not any(runs.known(name).size for name in runs.measures) and runs.complete
    report(runs, options, lambda: {} if nothing or runs.left else _outcome(runs, problem, Run(**run), options))
    if nothing:
        why = runs.reasons.get(0, "failed" if runs.failed else f"{', '.join(runs.measures)} is no finite number")
        fail(f"no run has measures; run 0: {why}")
        return 1
    return 0 if runs.complete else CTRL_C


def summary(runs: Runs) -> dict[str, Any]:
    """Return what is told of runs, for JSON."""
    measures = {}
    for name in runs.measures:
        low, middle, high = runs.quantiles(name).tolist()
        known = [float(one) for one in runs.extremes(name)]
        measures[name] = {
            "unit": runs.units[name], "least": known[0], "q05": low, "median": middle, "q95": high, "most": known[1],
            "mean": runs.mean(name), "sd": runs.sd(name),
        }  # fmt: skip
    return {
        "runs": len(runs), "failed": runs.failed, "stopped": runs.stopped, "left": runs.left, **runs.about,
        "measures": measures, "reasons": {str(number): words for number, words in runs.reasons.items()},
    }  # fmt: skip


def report(runs: Runs, options: argparse.Namespace, outcome: Callable[[], dict[str, Any]]) -> None:
    """Print a summary and what else comes of runs, and say which runs did not reach their end."""
    told, columns = summary(runs), dict[str, Any]()
    if options.json:
        columns = {} if options.output else {"columns": {name: runs[name].tolist() for name in runs}}
        give(told | columns)
    else:
        keys = ("mean", "sd", "least", "q05", "median", "q95", "most")
        rows = [
            [name, one["unit"], *(in_digits(one[key], DIGITS) for key in keys)]
            for name, one in told["measures"].items()
        ]
        title = f"{runs.scene}: {len(runs)} runs over {', '.join(runs.names)} ({runs.about['design']})"
        heads = ("measure", "unit", "mean", "sd", "least", "5 %", "median", "95 %", "most")
        print_table(Table(heads, rows, range(2, 9), title))
        if runs.about["design"] == "grid" and len(runs) <= ROWS:
            print_table(runs.table().written)
    for count, what in ((runs.failed, "failed, and have no measures"), (runs.stopped, "ended before their time")):
        if count:
            say(f"{count} of {len(runs)} runs {what}")
    for name in runs.measures:
        ended = len(runs) - runs.left - runs.failed
        if count := ended - runs.known(name).size:
            say(f"{name} is no finite number in {count} of {ended} runs that ended, which are left out of the summary")
    for number, words in list(runs.reasons.items())[:FAILED]:
        values = ", ".join(f"{name} = {value:.6g}" for name, value in zip(runs.names, runs.values[number], strict=True))
        say(f"run {number} ({values}): {words}")
    more = outcome()
    if options.json and more:
        give(told | more | columns)


def _check_outcome(file: Path | None, options: argparse.Namespace) -> None:
    """Raise SimulateError for what could not be told, or written to a file, in the end."""
    if file is not None and file.suffix not in (SUFFIX, TABLE):
        raise SimulateError(f"{file}: sweeps are kept in {SUFFIX} stores, or written as {TABLE} tables")
    if file is not None:
        check_folder(file, SimulateError)
    check_study_plot(None if options.plot is None else Path(options.plot), options.plot_kind)
    if options.plot is None and options.plot_kind is not None:
        raise SimulateError("--plot-kind: of --plot FILE, which is not given")
    if options.first_order and options.function is not None:
        raise SimulateError("--first-order is of runs, and --function makes none; leave one of the two away")
    if options.first_order and options.feedback is not None:
        raise SimulateError("--first-order: of runs without --feedback; leave one of the two away")


def _outcome(runs: Runs, problem: Problem, run: Run, options: argparse.Namespace) -> dict[str, Any]:
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
            shown = []
            for key in ("first", "total"):
                span = " … ".join(in_digits(x, 2) for x in one[f"{key}_interval"])
                shown.append(f"{in_digits(one[key], FEW_DIGITS)} ({span})")
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
