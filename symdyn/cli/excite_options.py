"""`symdyn identify SCENE --excite`: its options, and where the exciting motion goes."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from symdyn.cli.scene_options import read_scene, say_values_alone
from symdyn.cli.talk import Bar, give, print_text, say, wrote
from symdyn.cli.trajectory_options import flattened, pairs
from symdyn.errors import IdentifyError, SimulateError
from symdyn.identification import excite
from symdyn.simulation import CHECKS

CHOSEN = ("period", "family", "terms", "criterion", "starts", "seed", "every")

EXCITING = (*CHOSEN, "box", "noise", "plot")
"""Options that are of exciting motions alone."""


def run_exciting(options: argparse.Namespace) -> int:
    """Find the motion, tell of it, write it."""
    if options.data:
        raise IdentifyError(f"--excite finds a motion to be measured; {options.data[0]} would be the log of one")
    try:
        for name in options.output:
            CHECKS["table"](Path(name))
        if options.plot:
            CHECKS["plot"](Path(options.plot))
    except SimulateError as fault:
        raise IdentifyError(fault.faults) from None
    scene = read_scene(options)
    say_values_alone(options, scene, "--excite")
    chosen: dict[str, Any] = {name: one for name in CHOSEN if (one := getattr(options, name)) is not None}
    with Bar(f"exciting {scene.name}") as progress:
        found = excite(
            scene,
            **chosen,
            box=flattened(options.box),
            noise=_noise(options.noise),
            progress=progress,
            say=lambda line: say(f"symdyn: {line}"),
        )
    for name in options.output:
        found.run.save(name)
        wrote(name)
    if options.plot:
        found.run.save_plot(options.plot)
        wrote(options.plot)
    if options.json:
        columns = dict(zip(found.names, found.run.table()[1].T.tolist(), strict=True))
        give(found.as_json() | ({} if options.output else {"columns": columns}))
    elif options.output:
        print_text("\n".join(found.lines()))
    else:
        for line in found.lines():
            say(line)
        sys.stdout.write(found.to_csv())
    return 0


def _noise(text: str | None) -> dict[str, float]:
    """Return the standard deviations of `tau1=0.5,tau2=0.2`."""
    found, faults = {}, []
    for name, number in pairs(text, "--noise").items():
        try:
            found[name] = float(number)
        except ValueError:
            faults.append(f"--noise: {name}={number} is no number; give N m or N, such as tau1=0.5")
    if faults:
        raise IdentifyError(faults)
    return found
