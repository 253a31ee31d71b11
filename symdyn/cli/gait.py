"""`symdyn gait SCENE --section "strikes foot_a" --swap a=b`: a periodic motion, its period and Floquet multipliers."""

from __future__ import annotations

import argparse
from pathlib import Path

from symdyn.cli.scene_options import read_scene_to_move
from symdyn.cli.talk import Waiting, answer, print_paths, print_table, print_text
from symdyn.cli.trajectory_options import pairs, reported_forces, write_table
from symdyn.linear import poles_in_words, read_values
from symdyn.rounding import in_digits
from symdyn.simulation import Gait, Problem, gait
from symdyn.table import Table

DIGITS = 6
"""Of numbers in the table over a parameter."""


def run(options: argparse.Namespace) -> int:
    """Look for it and tell; over a parameter in a table."""
    scene = read_scene_to_move(options)
    over = None if options.over is None else read_values(options.over, scene=scene)
    start, rates = pairs(options.start, "--start"), pairs(options.start_rates, "--start-rates")
    problem = Problem(scene, reported_forces(scene, options), start, rates)
    asked = {"until": options.until, "rtol": options.rtol}
    with Waiting(f"looking for a periodic motion of {scene.name}"):
        found = gait(
            problem,
            section=options.section or "",
            swap=options.swap or "",
            period=options.period,
            **{name: one for name, one in asked.items() if one is not None},
        )
        branch = () if over is None else found.continued(over[0], over[1].tolist())
    if options.output is not None:
        write_table(found.run, Path(options.output))
        print_paths(options.output)
    if over is None:
        answer(found.as_json(), lambda: print_text("\n".join(found.words)))
        return 0
    name, values = over
    told = [{name: value, **one.as_json()} for value, one in zip(values.tolist(), branch, strict=True)]
    answer(told, lambda: print_table(_table(name, values.tolist(), branch)))
    return 0


def _table(name: str, values: list[float], branch: tuple[Gait, ...]) -> Table[object]:
    """Return periodic motions over a parameter."""
    rows = [
        (
            *(in_digits(value, DIGITS), in_digits(one.period, DIGITS), "yes" if one.stable else "no"),
            *(in_digits(float(abs(one.multipliers).max(initial=0.0)), DIGITS), poles_in_words(one.multipliers)),
        )
        for value, one in zip(values, branch, strict=True)
    ]
    return Table((name, "period", "stable", "largest", "multipliers"), rows, (0, 1, 3))
