"""`symdyn linearize SCENE`: A, B, C, D next to a point of rest, a steady motion or along a run; modes and stability."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from symdyn.cli.linear_tools import ASKED, PICTURES, Data, Lines, written
from symdyn.cli.scene_options import read_scene_to_move, split
from symdyn.cli.talk import Waiting, give, print_paths, print_text, say
from symdyn.cli.trajectory_options import collected, flattened, pairs, reel
from symdyn.draw import FILMS
from symdyn.errors import LinearizeError
from symdyn.linear import System, SystemsFile, locus_over
from symdyn.scene import Scene
from symdyn.scene.values import Faults, choice, split_commas
from symdyn.simulation import CHECKS, Problem

ENDINGS = {
    "bode": (".csv", *PICTURES),
    "locus": (".csv", *PICTURES),
    "gains": (".json",),
    "animate": tuple(FILMS),
}
"""What files may be, by the option that names them."""


def check_flags(options: argparse.Namespace) -> None:
    """Raise LinearizeError for flags that want another one, or files that could not be written in the end."""
    faults = Faults("")
    words = {one.name: one for one in ASKED if one.shown}
    for word in () if options.show is None else split(options.show) or ("",):
        if word not in words:
            faults.add("--show", f'there is no "{word}"; {choice(word, words)}')
    if options.bode == []:
        faults.add("--bode", "names no file; --show bode prints the responses")
    if options.hertz is not None and not words["bode"].given(options):
        faults.add("--hertz", "belongs to --show bode, which is not given")
    for name, wants in {"gains": "lqr", "locus": "over"}.items():
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


FORMATS: Mapping[str, Callable[[System], str]] = {"text": System.text, "latex": System.latex}

REST = "rest"


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
