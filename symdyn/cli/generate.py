"""`symdyn generate SCENE`: its functions as files of a target, such as a NumPy module or C."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

from symdyn.cli.scene_options import again, closing_of, functions_of, read_scene, say_values_alone
from symdyn.cli.talk import Waiting, asking, print_paths, say
from symdyn.dynamics import Equations, LoopChoices, Requested, Workspace, kept_in_lines
from symdyn.emit import TARGETS, emit, write
from symdyn.errors import EmitError
from symdyn.program import RowLoop, formulate, lower, prepare, tunable
from symdyn.runtime import complete
from symdyn.scene import Scene

MADE, BEGINNING = b"Written by symdyn generate", 1000
"""What a file beside sources says of itself in its first bytes, so many."""

LARGE = 5_000
"""Products from which on it is told that a function in lines might have a loop."""


def target_name(name: str) -> str:
    """Return the name of a target; argparse.ArgumentTypeError of one that there is not."""
    try:
        return TARGETS[name].name
    except EmitError as fault:
        raise argparse.ArgumentTypeError(str(fault)) from fault


def run(options: argparse.Namespace) -> int:
    """Write the files and print their paths."""
    scene = read_scene(options)
    closing = closing_of(options, scene)
    with Waiting("deriving") as progress:
        target = TARGETS[options.target]
        asked = functions_of(options, scene)
        if asked is None and target.functions:
            asked = target.functions(scene, option_of(options))
        if options.static and target.functions:
            raise EmitError(f"{scene.name}: target {target.name} ({target.text}) is about motion; leave --static out")
        outputs, left_out = Requested.of(Workspace(scene, closing)).available() if asked is None else (asked, [])
        for reason in left_out:
            say(f"symdyn: {reason}")
        if asked is None and not scene.points:
            say(f"symdyn: {scene.name}: {asking(scene.leaves)}")
        by_names = tuple(f"_by_{one}" for one in ("parameters", *(one.name for one in scene.parameters)))
        if not target.tunes and not any(one.partition(":")[0].endswith(by_names) for one in outputs):
            say_values_alone(options, scene, f"target {target.name}")
        if target.tunes:
            program = tunable(scene, outputs, options.formulation, closing)
        else:
            program = lower(equations_of(options, scene, outputs, closing, lines=not target.loops))
        looped = any(routine.function.loop for routine in program.routines)  # so a table holds the scene
        if target.loops and not (options.formulation or looped) and (told := kept_in_lines(scene, outputs)):
            say(f"symdyn: {told}")
        if options.prepare:
            program = prepare(program)
            if not program.is_prepared:
                say(f"symdyn: {scene.name}: nothing to prepare, no function has a free parameter")
        if options.accuracy and not any(routine.counts.sincos for routine in program.routines):
            say(f"symdyn: {scene.name}: no function takes a sine; --accuracy {options.accuracy} makes none faster")
        progress("printing")
        command = again(options, always="target")
        sources = emit(program, options.target, options.real, command, option_of(options), options.accuracy)
        for given, made in zip(program.routines, sources.program.routines, strict=True):
            one, large = given.function, given.counts.multiplications > LARGE
            if large and not made.function.solve and RowLoop.of(one):
                say(f"symdyn: {scene.name}: {one.name} is in lines; C ends it with a loop, and has less text")
        progress("compiling")
        sources, told = complete(sources)
        if told:
            say(f"symdyn: {told}")
        more = dict(TARGETS[sources.target].beside(sources))
    print_paths(*write({**sources, **_ours(more, Path(options.output))}, options.output))
    return 0


def option_of(options: argparse.Namespace) -> str:
    """Return which of the target's options was chosen, with its size."""
    return options.option if options.stack is None else f"stack={options.stack}"


def equations_of(
    options: argparse.Namespace, scene: Scene, outputs: Sequence[str], closing: LoopChoices, lines: bool = True
) -> Equations:
    """Return what becomes code, at rest if that is asked for; as to `lines` see `formulate`."""
    equations = formulate(scene, outputs, options.formulation, closing, lines or options.static)
    return equations.at_rest() if options.static else equations


def _ours(files: Mapping[str, str], folder: Path) -> dict[str, str]:
    """Return the files beside sources without those that stand in the folder and are somebody else's; says which."""
    kept = {}
    for name, text in files.items():
        path = folder / name
        try:
            theirs = path.is_file() and MADE not in path.read_bytes()[:BEGINNING]
        except OSError:  # what is wrong `write` tells
            theirs = False
        if not theirs:
            kept[name] = text
        else:
            say(f"{name}: is not of symdyn and left as it is; generate into another folder to have ours")
    return kept
