"""`symdyn calibrate SCENE POSES.csv --point tool`: geometric parameters from measured poses, with standard errors."""

from __future__ import annotations

import argparse
from pathlib import Path

from symdyn.cli.identify import check_files
from symdyn.cli.scene_options import again, read_scene, split
from symdyn.cli.talk import Waiting, answer, print_table, print_text, say, wrote
from symdyn.cli.trajectory_options import pairs
from symdyn.emit import write_file
from symdyn.errors import IdentifyError, SimulateError
from symdyn.identification import Calibration, calibrate
from symdyn.rounding import finite, in_digits
from symdyn.simulation import CHECKS


def run(options: argparse.Namespace) -> int:
    """Calibrate, print, write."""
    check_files(options, (".toml", ".urdf", ".csv"))
    try:
        CHECKS["plot"](Path(options.plot or "plot.svg"))
    except SimulateError as fault:
        raise IdentifyError(fault.faults) from None
    asked = split(options.parameters), not options.keep_outliers, pairs(options.units, "--units")
    with Waiting("calibrating"):
        found = calibrate(read_scene(options), options.data, options.point, *asked)
    for note in found.notes:
        say(note)
    for path in map(Path, options.output):
        write_file(path, _text(found, path.suffix.lower()[1:], again(options)))
        wrote(path)
    if options.plot:
        found.save_plot(options.plot)
        wrote(options.plot)
    answer(finite(found.as_dict()), lambda: _show(found))
    return 0


def _text(found: Calibration, format: str, command: str) -> str:
    if format == "csv":
        return found.tables[0].csv()
    made = found.text(format, [f"calibrated by: {command}"])
    for line in made.lost:
        say(f"symdyn: left out: {line}")
    return made.text


def _show(found: Calibration) -> None:
    for table in found.tables:
        print_table(table)
    numbers = [in_digits(x, 3) for x in (found.regression.condition, found.observability)]
    print_text(f"condition number {numbers[0]}, observability {numbers[1]}, {found.regression.dof} degrees of freedom")
