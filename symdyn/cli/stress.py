"""`symdyn stress [SCENE]`: hard cases with a metric and a bound each.

Exit status 1 if a bound is exceeded, or a case is not shown.

Without a scene, built-in ones: near-singular mass matrices, long chains, huge angles, fast spin, stiff springs, change
points, chaos. With one, the cases that make sense for it.
"""

from __future__ import annotations

import argparse

from symdyn.bench import FAMILIES, stress
from symdyn.cli.scene_options import again, read_scene, split
from symdyn.cli.talk import Waiting, give, print_table, print_text, wrote
from symdyn.emit import write


def run(options: argparse.Namespace) -> int:
    """Run the cases, write, print."""
    if options.families is not None and not options.families.strip():
        print_text("\n".join(f"{name:10s}{family.text}" for name, family in FAMILIES.items()))
        return 0
    scene = None if options.scene is None else read_scene(options)
    with Waiting() as progress:
        command = again(options) + (" -o DIR" if options.output is not None else "")
        found = stress(scene, split(options.families), command, progress)
    if options.json:
        give(found.as_dict())
    else:
        print_table(found.table)
        for line in found.lines:
            print(line)
        not_shown = f", {len(found.not_shown)} not shown" if found.not_shown else ""
        print(f"{len(found.cases)} cases, {len(found.failed) or 'none'} failed{not_shown}")
    if options.output is not None:
        wrote(*write(found.files(), options.output))
    return 0 if found.passed else 1
