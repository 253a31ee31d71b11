"""`symdyn generate SCENE`: a NumPy module, C, JavaScript, or the source of a Python extension for its functions."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from symdyn.cli.reading import (
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
    from symdyn.dynamics import Closing
    from symdyn.scene import Scene


def register(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the verb."""
    verb = verbs.add_parser("generate", help="write a NumPy module, C or JavaScript", description=__doc__)
    add_reading_options(verb)
    verb.add_argument(
        "--target",
        choices=("numpy", "c", "ufunc", "js"),
        default="numpy",
        help="a NumPy module (default), C, C for a Python extension of NumPy ufuncs, which says how to build it, or "
        "JavaScript",
    )
    verb.add_argument("--functions", metavar="LIST", help="comma-separated, e.g. inverse_dynamics,pose:tool")
    verb.add_argument("--real", choices=("double", "float"), default="double", help="number type (default: double)")
    verb.add_argument("--batch", action="store_true", help="C: functions over many states too, fit for vector code")
    add_formulation(verb)
    add_closing(verb)
    add_prepare(verb)
    verb.add_argument("--static", action="store_true", help="at rest: every velocity is zero and no argument")
    verb.add_argument("-o", "--output", metavar="DIR", default=".", help="folder to write to (default: here)")
    verb.set_defaults(run=run)


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
        sources = emit(program, options.target, options.real, command(options), options.batch)
    print_paths(*write(sources, options.output))
    return 0


def requested(scene: Scene, functions: str | None, closing: Closing) -> tuple[tuple[str, ...], list[str]]:
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
    words += ["--batch"] if options.batch else []
    words += ["--formulation", options.formulation] if options.formulation else []
    words += closing_words(options)
    words += ["--prepare"] if options.prepare else []
    words += ["--static"] if options.static else []
    return " ".join(words)
