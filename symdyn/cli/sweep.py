"""`symdyn sweep SCENE --over "m1=linspace(1,2,100)" --measure "max(abs(tau2))"`: one scene at many values."""

from __future__ import annotations

import argparse

from symdyn.cli.scene_options import add_reading_options, read_scene
from symdyn.cli.talk import Bar, give, print_table, say
from symdyn.cli.trajectory_options import pairs
from symdyn.rounding import in_digits
from symdyn.study.door import sweep
from symdyn.study.study import Study


def add_options(verb: argparse.ArgumentParser) -> None:
    """Add what the verb takes."""
    add_reading_options(verb)
    verb.add_argument(
        "--over", action="append", default=[], metavar="VARIED", help='e.g. "m1=linspace(1,2,5)", "k=normal(10,1)"'
    )
    verb.add_argument(
        "--measure", action="append", default=[], metavar="FORMULA", help='what is kept of a run: "max(abs(tau2))"'
    )
    verb.add_argument("--until", type=float, required=True, metavar="T", help="time of the end of every run, s")
    verb.add_argument("--start", metavar="LIST", help="where all runs start, e.g. q1=0.3,q2=pi/2")
    verb.add_argument("--start-rates", metavar="LIST", help="velocities there, e.g. q1=2")
    verb.add_argument("--design", metavar="NAME", help="grid, random, latin or sobol")
    verb.add_argument("--count", type=int, metavar="N", help="runs that are drawn")
    verb.add_argument("--seed", type=int, default=0, metavar="N", help="of what is drawn (default: 0)")


def run(options: argparse.Namespace) -> int:
    """Compute and tell."""
    scene = read_scene(options)
    with Bar(f"sweeping {scene.name}") as progress:
        study = sweep(
            scene,
            options.over,
            options.measure,
            until=options.until,
            start=pairs(options.start, "--start"),
            start_rates=pairs(options.start_rates, "--start-rates"),
            design=options.design,
            count=options.count,
            seed=options.seed,
            progress=progress,
        )
    tell(study, options)
    return 0


def tell(study: Study, options: argparse.Namespace) -> None:
    """Print a summary."""
    rows = []
    for name in study.measures:
        low, middle, high = study.quantiles(name)
        rows.append([name, study.units[name], *(in_digits(float(one), 4) for one in (low, middle, high))])
    if options.json:
        columns = {name: study[name].tolist() for name in study}
        give({"runs": len(study), "failed": study.failed, "columns": columns})
    else:
        print_table(f"{study.scene}: {len(study)} runs", ("measure", "unit", "5 % ", "median ", "95 % "), rows)
    for number, words in study.told.items():
        say(f"run {number}: {words}")
