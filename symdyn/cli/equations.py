"""`symdyn equations SCENE`: print the equations of motion in closed form."""

from __future__ import annotations

import argparse

from symdyn.cli.scene_options import add_reading_options, read_scene_to_move
from symdyn.cli.talk import Waiting, print_text
from symdyn.emit.print import EquationsOfMotion, printed_text


def add_options(verb: argparse.ArgumentParser) -> None:
    """Add what the verb takes."""
    add_reading_options(verb)
    verb.add_argument("--format", choices=EquationsOfMotion.choices["format"], default="latex", help="default: latex")
    verb.add_argument(
        "--as",
        dest="group",
        choices=EquationsOfMotion.choices["what"],
        default="equations",
        help="one equation a joint (default), coefficient by coefficient, under-braced as in a textbook, M and c; in "
        "place of them the regrouped inertias that they depend on",
    )
    verb.add_argument(
        "--formulation",
        choices=EquationsOfMotion.choices["formulation"],
        default="lagrange",
        help="Lagrange's equations (default), or D'Alembert's system (5.18) for all reactions",
    )
    verb.add_argument(
        "--angles", choices=EquationsOfMotion.choices["angles"], default="long", help="sin(q1 + q2) or s_{12}"
    )
    verb.add_argument("--document", action="store_true", help="a whole LaTeX document with a symbol table")


def run(options: argparse.Namespace) -> int:
    """Print the equations."""
    scene = read_scene_to_move(options)
    with Waiting() as progress:
        progress("expanding")
        text = printed_text(scene, options.format, options.group, options.angles, options.document, options.formulation)
    print_text(text)
    return 0
