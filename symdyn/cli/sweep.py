"""`symdyn sweep SCENE --over "m1=linspace(1,2,100)" --measure "max(abs(tau2))"`: one scene at many values."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from symdyn.cli.scene_options import read_scene
from symdyn.cli.sweep_outcome import check_outcome, report_outcome
from symdyn.cli.talk import Bar, fail, give, print_paths, print_table, say
from symdyn.cli.trajectory_options import pairs, reported_forces
from symdyn.errors import SimulateError
from symdyn.rounding import in_digits
from symdyn.simulation import Problem, Run
from symdyn.study import SUFFIX, Runs, sweep
from symdyn.table import Table

CTRL_C = 130

TABLE = ".csv"

DIGITS = 6

FAILED = 3
"""Runs that did not end that are told on a terminal; `told` of the runs has more."""


def run(options: argparse.Namespace) -> int:
    """Compute and tell."""
    scene = read_scene(options)
    file = None if options.output is None else Path(options.output)
    if file is not None:
        _check(file)
    check_outcome(options)
    start, rates = pairs(options.start, "--start"), pairs(options.start_rates, "--start-rates")
    problem = Problem(scene, reported_forces(scene, options), start, rates)
    run = {name: one for name, one in vars(options).items() if name in Run.Fields.__annotations__ and one is not None}
    with Bar(f"sweeping {scene.name}") as progress:
        runs = sweep(
            problem,
            options.over,
            options.measure,
            design=options.design,
            count=options.count,
            seed=options.seed,
            output=file if file is not None and file.suffix == SUFFIX else None,
            scheduler=options.scheduler,
            workers=options.workers,
            block=options.block,
            function=options.function,
            at=options.at,
            progress=progress,
            say=say,
            **run,
        )
    if file is not None:
        if file.suffix == TABLE:
            runs.to_csv(file)
        print_paths(file)
    nothing = not any(runs.known(name).size for name in runs.measures) and runs.complete
    report(runs, options, lambda: {} if nothing or runs.left else report_outcome(runs, problem, Run(**run), options))
    if nothing:
        why = runs.reasons.get(0, "failed" if runs.failed else f"{', '.join(runs.measures)} is no finite number")
        fail(f"no run has measures; run 0: {why}")
        return 1
    return 0 if runs.complete else CTRL_C


def _check(file: Path) -> None:
    """Raise SimulateError for a file that could not be written in the end."""
    if file.suffix not in (SUFFIX, TABLE):
        raise SimulateError(f"{file}: sweeps are kept in {SUFFIX} stores, or written as {TABLE} tables")
    if not file.parent.is_dir():
        raise SimulateError(f"{file}: there is no folder {file.parent}")


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
        "measures": measures, "told": {str(number): words for number, words in runs.reasons.items()},
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
