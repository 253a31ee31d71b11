"""`symdyn equations SCENE`: print the equations of motion in closed form."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from symdyn.cli.scene_options import add_reading_options, read_scene

if TYPE_CHECKING:
    from symdyn.scene import Scene


def register(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the verb."""
    verb = verbs.add_parser("equations", help="print the equations of motion", description=__doc__)
    add_reading_options(verb)
    verb.add_argument("--format", choices=("latex", "text", "sympy"), default="latex", help="default: latex")
    verb.add_argument(
        "--as",
        dest="group",
        choices=("equations", "coefficients", "textbook", "matrix", "base-parameters", "dalembert"),
        default="equations",
        help="one equation a joint (default), coefficient by coefficient, under-braced as in a textbook, M and c; in "
        "place of them the regrouped inertias that they depend on, or D'Alembert's system (5.18) for all reactions",
    )
    verb.add_argument("--angles", choices=("long", "short"), default="long", help="sin(q1 + q2) or s_{12}")
    verb.add_argument("--document", action="store_true", help="a whole LaTeX document with a symbol table")
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the equations."""
    from symdyn.cli.talk import Waiting
    from symdyn.errors import EmitError

    scene = read_scene(options)
    if options.group == "base-parameters" and options.document:
        raise EmitError("a document holds equations; leave --document out, or --as base-parameters")
    if options.group == "dalembert" and options.format != "latex":
        raise EmitError(f"D'Alembert's system is written in LaTeX, not as {options.format}; leave --format out")
    with Waiting() as progress:
        progress("expanding")
        text = _text(scene, options)
    print(text)
    return 0


def _text(scene: Scene, options: argparse.Namespace) -> str:
    """Return what was asked for; each page imports what it needs."""
    if options.group == "dalembert":
        from symdyn.emit.print.dalembert_page import dalembert_text

        return dalembert_text(scene, options.document)
    if options.group == "base-parameters":
        from symdyn.emit.print.base_parameters_page import base_parameters_text

        return base_parameters_text(scene, options.format)
    from symdyn.emit.print.equations_text import equations_text

    return equations_text(scene, options.format, options.group, options.angles, options.document)
