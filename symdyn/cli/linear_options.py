"""The flags that ask more of `symdyn linearize`, what is wrong with them, and root loci, which are of many systems."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from symdyn.cli.linear_tools import ASKED, PICTURES, Data, Lines, written
from symdyn.cli.scene_options import split
from symdyn.cli.trajectory_options import add_film_options, flattened, pairs, reel
from symdyn.draw import FILMS
from symdyn.errors import LinearizeError
from symdyn.linear import System, locus_over
from symdyn.scene import Scene
from symdyn.scene.values import Faults
from symdyn.simulation import CHECKS, Problem

ENDINGS = {
    "bode": (".csv", *PICTURES),
    "locus": (".csv", *PICTURES),
    "gains": (".json",),
    "animate": tuple(FILMS),
}
"""What files may be, by the option that names them."""


def add_flags(verb: argparse.ArgumentParser) -> None:
    """Add a flag for every row, and those that say more of them."""
    group = verb.add_argument_group("of the linear system")
    for one in ASKED:
        group.add_argument(one.flag, **one.how)
    group.add_argument("--hertz", metavar="RANGE", help="frequencies of --bode, Hz: geomspace(0.1,10,200) or [1, 2, 5]")
    group.add_argument("--gains", metavar="FILE", help="where --lqr writes its gains, .json, for simulate --feedback")
    add_film_options(group)
    group = verb.add_argument_group("over a parameter or a speed")
    group.add_argument("--over", metavar="RANGE", help='eigenvalues over "v=linspace(0,10,100)", and critical values')
    group.add_argument(
        "--speed", metavar="LIST", help="rates of a steady motion, which may name that of --over, e.g. x_dot=v"
    )
    group.add_argument("--locus", nargs="+", metavar="FILE", help="the root locus of --over: .csv, .svg, .pdf or .png")


def check_flags(options: argparse.Namespace) -> None:
    """Raise LinearizeError for flags that want another one, or files that could not be written in the end."""
    faults = Faults("")
    for name, wants in {"hertz": "bode", "gains": "lqr", "locus": "over"}.items():
        if getattr(options, name) is not None and getattr(options, wants) is None:
            faults.add(f"--{name}", f"belongs to --{wants}, which is not given")
    if options.over is not None:
        alone = [one.flag for one in ASKED if one.given(options)]
        alone += [flag for flag, given in (("--output", options.output), ("--along", options.along)) if given]
        if options.outputs is not None:
            faults.add("--outputs", "has no part in eigenvalues, which are what --over finds; leave it out")
        for flag in alone:
            faults.add(flag, "is of one system, and --over makes many; give one of them")
        if options.at == "rest":
            faults.add("--at", "rest may be many places; name one, and it is followed: --at NAME=VALUE")
    for option, endings in ENDINGS.items():
        given = getattr(options, option) or ()
        for path in map(Path, [given] if isinstance(given, str) else given):
            ending = path.suffix.lower()
            if ending not in endings:
                faults.add(f"--{option}", f"{path} is no {' or '.join(endings)} file")
            elif not path.parent.is_dir():
                faults.add(str(path), f"there is no folder {path.parent}")
            elif option == "animate":
                with faults.noted():
                    CHECKS["film"](path, reel(options))
            elif ending in PICTURES:
                with faults.noted():
                    CHECKS["plot"](path)
    if not options.animate:
        with faults.noted():
            reel(options)
    faults.close(LinearizeError)


def check_one(systems: Sequence[System], options: argparse.Namespace) -> None:
    """Raise LinearizeError where several systems would go into one file."""
    files = [one.flag for one in ASKED if one.given(options) and one.writes and getattr(options, one.writes)]
    if len(systems) > 1 and files:
        raise LinearizeError(
            f"{', '.join(files)}: there are {len(systems)} systems; give the place of one, as --at LIST"
        )


def rates_of(options: argparse.Namespace) -> dict[str, str]:
    """Return the velocities that --rates and --speed give, formulas by name."""
    return pairs(options.rates, "--rates") | pairs(options.speed, "--speed")


def locus_over_range(scene: Scene, options: argparse.Namespace) -> tuple[Lines, Data]:
    """Return lines and data of the root locus over a range, and write its files."""
    problem = Problem(scene, flattened(options.forces), pairs(options.at, "--at"), rates_of(options))
    found = locus_over(problem, options.over, split(options.independent) or (), options.anywhere)
    title = f"{scene.name}: eigenvalues over {found.name}"
    lines = found.lines() + written(options.locus or [], found.table().csv, lambda kind: found.plot(title, kind))
    return lines, found.as_json()
