"""`symdyn stress [SCENE]`: hard cases with a metric and a bound each; exit status 1 if a bound is exceeded.

Without a scene, built-in ones: near-singular mass matrices, long chains, huge angles, fast spin, stiff springs, change
points, chaos. With one, the cases that make sense for it.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from symdyn.cli.scene_options import add_reading_options, read_scene, reading_words

if TYPE_CHECKING:
    from symdyn.bench.stress import Stress


def register(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the verb."""
    verb = verbs.add_parser("stress", help="hard cases for the numerics", description=__doc__)
    add_reading_options(verb, optional=True)
    verb.add_argument("--families", metavar="LIST", help="comma-separated; default: all; --families '' lists them")
    verb.add_argument("-o", "--output", metavar="DIR", help="write stress.html, stress.md and stress.json there")
    verb.add_argument("--json", action="store_true", help="print JSON")
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the cases, write, print."""
    from symdyn.bench.report import as_json, stress_html, stress_markdown
    from symdyn.bench.stress import FAMILIES, stress
    from symdyn.cli.generate import split
    from symdyn.cli.talk import Waiting, say
    from symdyn.emit.files import write

    if options.families is not None and not options.families.strip():
        for name, family in FAMILIES.items():
            print(f"{name:10s}{family.text}")
        return 0
    scene = None if options.scene is None else read_scene(options)
    families = split(options.families) if options.families is not None else None
    with Waiting() as progress:
        found = stress(scene, families, _command(options), progress)
    if options.json:
        print(as_json(found.as_dict()), end="")
    else:
        show(found)
    if options.output is not None:
        files = {
            "stress.html": stress_html(found),
            "stress.md": stress_markdown(found),
            "stress.json": as_json(found.as_dict()),
        }
        for path in write(files, options.output):
            say(f"symdyn: wrote {path}")
    return 0 if found.passed else 1


def _command(options: argparse.Namespace) -> str:
    words = ["symdyn", "stress", *(reading_words(options) if options.scene is not None else ())]
    words += ["--families", options.families.replace(" ", "")] if options.families else []
    words += ["-o", "DIR"] if options.output is not None else []
    return " ".join(words)


def show(found: Stress) -> None:
    """Print the table."""
    from symdyn.bench.report import stress_rows
    from symdyn.cli.talk import print_table

    columns = ("family", "case", "metric", "bound ", "measured ", "", "worst")
    print_table(f"{found.scene or 'built-in scenes'}: hard cases", columns, stress_rows(found))
    for note in found.notes:
        print(f"Note: {note}")
    failed = sum(not case.passed for case in found.cases)
    print(f"{len(found.cases)} cases, {failed or 'none'} failed")
