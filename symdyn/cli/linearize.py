"""`symdyn linearize SCENE`: A, B, C, D next to a point of rest, a steady motion or along a run; modes and stability."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from symdyn.cli.linear_options import add_flags, check_flags, check_one, locus_over_range, rates_of
from symdyn.cli.linear_tools import ASKED
from symdyn.cli.scene_options import add_reading_options, read_scene_to_move, split
from symdyn.cli.talk import Waiting, give, print_paths, print_text, say
from symdyn.cli.trajectory_options import collected, flattened, pairs
from symdyn.errors import LinearizeError
from symdyn.linear import System, SystemsFile
from symdyn.scene import Scene
from symdyn.scene.values import split_commas
from symdyn.simulation import Problem

FORMATS: Mapping[str, Callable[[System], str]] = {"text": System.text, "latex": System.latex}

REST = "rest"


def add_options(verb: argparse.ArgumentParser) -> None:
    """Add what the verb takes."""
    add_reading_options(verb)
    verb.add_argument(
        "--at",
        metavar="LIST",
        help="coordinates there, e.g. theta=pi,x=0, or rest for all positions of rest; else as the scene starts",
    )
    verb.add_argument("--rates", metavar="LIST", help="velocities there, e.g. q1=2")
    verb.add_argument(
        "--forces",
        nargs="+",
        action="append",
        metavar="F",
        help='name=formula of a drive or an input, such as "tau1=-2*q1+r" with [inputs.r]; or a .toml or .csv file',
    )
    verb.add_argument("--along", metavar="FILE", help="a run, .csv or .npz, as simulate -o writes it")
    verb.add_argument(
        "--outputs",
        metavar="LIST",
        help="formulas in coordinates, velocities, point_tip_x, reaction_hinge_fx, ...; default: all coordinates",
    )
    verb.add_argument(
        "--independent", metavar="LIST", help="coordinates that determine the others; else the best conditioned"
    )
    verb.add_argument(
        "--anywhere", action="store_true", help="take points too that are neither of rest nor of a steady motion"
    )
    verb.add_argument("--format", choices=tuple(FORMATS), default="text", help="default: text")
    verb.add_argument("-o", "--output", metavar="FILE", help=".npz, .mat or .csv")
    add_flags(verb)


def run(options: argparse.Namespace) -> int:
    """Linearise, print, write."""
    scene = read_scene_to_move(options)
    check_flags(options)
    if options.over:
        with Waiting() as progress:
            progress("linearising")
            lines, data = locus_over_range(scene, options)
        if options.json:
            give(data)
        else:
            print_text("\n".join(lines))
        return 0
    if options.along is not None and (options.at or options.rates):
        raise LinearizeError("--along takes its points from a run; leave --at and --rates out")
    if options.at == REST and options.rates:
        raise LinearizeError("--at rest has no velocities; leave --rates out, or say where with --at")
    file = SystemsFile(Path(options.output)) if options.output else None
    with Waiting() as progress:
        progress("linearising")
        systems, notes = _systems(scene, options)
        check_one(systems, options)
        told = [_json(one, options) if options.json else _text(one, options) for one in systems]
    for note in notes:
        say(f"symdyn: {note}")
    if file is not None:
        file.write([one.linearization for one in systems])
        print_paths(options.output)
    if options.json:
        give(told if options.along is not None or options.at == REST else told[0])
    elif not (options.output and options.along):
        print_text("\n\n".join(map(str, told)))
    return 0


def _systems(scene: Scene, options: argparse.Namespace) -> tuple[list[System], Sequence[str]]:
    """Return the linear systems that the options ask for, and what is said of how they were found."""
    outputs = [] if options.outputs is None else split_commas(options.outputs) or [""]
    independent = split(options.independent) or ()
    problem = Problem(scene, flattened(options.forces))
    if options.at == REST or options.along is not None:
        where = REST if options.along is None else Path(options.along)
        return System.find(problem, where, outputs, independent, options.anywhere)
    _, start = collected(
        lambda: problem.driving, lambda: Problem(scene, (), pairs(options.at, "--at"), rates_of(options)).initial
    )
    problem = replace(problem, start=start)  # type: ignore[arg-type]
    return System.find(problem, "start", outputs, independent, options.anywhere)


def _text(system: System, options: argparse.Namespace) -> str:
    more = ["\n".join(one.find(system, options)[0]) for one in ASKED if one.given(options)]
    return "\n\n".join([FORMATS[options.format](system), *more])


def _json(system: System, options: argparse.Namespace) -> dict[str, Any]:
    more = {one.name: one.find(system, options)[1] for one in ASKED if one.given(options)}
    return system.as_json() | more
