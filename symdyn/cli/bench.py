"""`symdyn bench SCENE`: run time against error of every function in every implementation, as a page and as tables.

Writes bench.html (one page, pictures inside), bench.md and bench.json; prints the best choices of each function.
"""

from __future__ import annotations

import argparse

from symdyn.bench import Bench, bench
from symdyn.cli.scene_options import again, functions_of, read_scene
from symdyn.cli.talk import Waiting, answer, print_table, say, wrote
from symdyn.emit import write
from symdyn.rounding import in_digits
from symdyn.table import Table

LONG = (
    "every function is derived, compiled and measured in every implementation, at 800 states: a minute or more "
    "for two joints, longer for more; --quick is a first look, and --functions takes some of them"
)
"""Said where all is measured."""


def run(options: argparse.Namespace) -> int:
    """Measure, write, print."""
    scene = read_scene(options)
    if not options.quick:
        say(f"symdyn: {LONG}")
    with Waiting() as progress:
        command = again(options) + (" -o DIR" if options.output is not None else "")
        functions = functions_of(options, scene)
        found = bench(scene, functions, options.quick, options.trajectories, options.seed, command, progress)
    if options.output is not None:
        paths = write(found.files(), options.output)
    answer(found.as_dict(), lambda: show(found))
    if options.output is not None:
        wrote(*paths)
    return 0


def show(result: Bench) -> None:
    """Print the best choices of every function."""
    lines = [
        (one.function, one.label, one.nanoseconds, in_digits(one.relative, 2, "e"), _worst(one.errors))
        for function in result.functions
        for one in result.best(function)
    ]
    columns = ("function", "implementation", "ns a state", "error 99 %", "backward")
    title = f"{result.scene}: the best choices, none beaten in both time and error"
    print_table(Table(columns, lines, (2, 3, 4), title))
    print("Errors are relative to the largest entry, in the worst region; backward errors in units of the roundoff.")
    if result.motion is not None:
        ends = [
            (c.method, f"{p.tolerance:.0e}", in_digits(p.seconds, 3), in_digits(p.error, 2, "e"))
            for c, p in result.motion.choices
        ]
        print()
        heads = ("method", "rtol", "seconds", "error at the end")
        title = f"{result.scene}: the best choices for {result.motion.until:g} s of motion"
        print_table(Table(heads, ends, (1, 2, 3), title))
    for note in (*result.notes, *(result.motion.notes if result.motion is not None else ())):
        print(f"Note: {note}")


def _worst(errors: object) -> str:
    worst = [one.backward[2] for one in errors if one.backward is not None]  # type: ignore[attr-defined]
    return in_digits(max(worst), 2) if worst else ""
