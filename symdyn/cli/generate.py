"""`symdyn generate SCENE`: its functions as files of a target, such as a NumPy module or C."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from symdyn.cli.scene_options import (
    add_closing,
    add_formulation,
    add_prepare,
    add_reading_options,
    closing_of,
    closing_words,
    read_scene,
    reading_words,
)

if TYPE_CHECKING:
    from symdyn.dynamics import LoopChoices
    from symdyn.scene import Scene


def register(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the verb."""
    words = "write a NumPy module, C or JavaScript"
    verb = verbs.add_parser("generate", help=words, description=__doc__, add_options=_add_options)
    verb.set_defaults(run=run)


def _add_options(verb: argparse.ArgumentParser) -> None:
    """Add what the verb takes; targets say what they are and what can be asked of them."""
    from symdyn.emit import TARGETS
    from symdyn.emit.code.real import REALS

    first, *_ = TARGETS
    add_reading_options(verb)
    known = "; ".join(f"{name}: {target.text}" for name, target in TARGETS.items())
    verb.add_argument("--target", choices=tuple(TARGETS), default=first, help=f"{known} (default: {first})")
    verb.add_argument("--functions", metavar="LIST", help="comma-separated, e.g. inverse_dynamics,pose:tool")
    verb.add_argument("--real", choices=tuple(REALS), default="double", help="number type (default: double)")
    group = verb.add_mutually_exclusive_group()
    for name in dict.fromkeys(name for target in TARGETS.values() for name in target.options):
        does = "; ".join(f"{t.title}: {t.options[name]}" for t in TARGETS.values() if name in t.options)
        group.add_argument(f"--{name}", dest="option", action="store_const", const=name, default="", help=does)
    add_formulation(verb)
    add_closing(verb)
    add_prepare(verb)
    verb.add_argument("--static", action="store_true", help="at rest: every velocity is zero and no argument")
    verb.add_argument("-o", "--output", metavar="DIR", default=".", help="folder to write to (default: here)")


def run(options: argparse.Namespace) -> int:
    """Write the files and print their paths."""
    from symdyn.cli.talk import Waiting, asking, print_paths, say
    from symdyn.emit import emit, write
    from symdyn.program import at_rest, formulate, lower, prepare
    from symdyn.program.prepare import is_prepared
    from symdyn.scene.robot_words import leaves

    scene = read_scene(options)
    closing = closing_of(options, scene)
    with Waiting() as progress:
        progress("deriving")
        outputs, left_out = requested(scene, options.functions, closing)
        for reason in left_out:
            say(f"symdyn: {reason}")
        if options.functions is None and not scene.points:
            say(f"symdyn: {scene.name}: {asking(leaves(scene))}")
        equations = formulate(scene, outputs, options.formulation, closing)
        program = lower(at_rest(equations) if options.static else equations)
        if options.prepare:
            program = prepare(program)
            if not is_prepared(program):
                say(f"symdyn: {scene.name}: nothing to prepare, no function has a free parameter")
        progress("printing")
        sources = emit(program, options.target, options.real, command(options), options.option)
    print_paths(*write(sources, options.output))
    return 0


def requested(scene: Scene, functions: str | None, closing: LoopChoices) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs to generate and why some of the usual ones are left out."""
    from symdyn.dynamics import available

    if functions is not None:
        return split(functions), []
    return available(scene, closing)


def split(functions: str) -> tuple[str, ...]:
    """Return the names of a comma-separated list, each once."""
    return tuple(dict.fromkeys(name.strip() for name in functions.split(",") if name.strip()))


def command(options: argparse.Namespace) -> str:
    """Return the command that makes the same files again, free of folders."""
    words = ["symdyn", "generate", *reading_words(options), "--target", options.target]
    words += ["--functions", options.functions.replace(" ", "")] if options.functions else []
    words += ["--real", options.real] if options.real != "double" else []
    words += [f"--{options.option}"] if options.option else []
    words += ["--formulation", options.formulation] if options.formulation else []
    words += closing_words(options)
    words += ["--prepare"] if options.prepare else []
    words += ["--static"] if options.static else []
    return " ".join(words)
