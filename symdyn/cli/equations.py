"""`symdyn equations SCENE`: print the equations of motion in closed form."""

from __future__ import annotations

import argparse

from symdyn.cli.scene_options import read_scene_to_move
from symdyn.cli.talk import Waiting, print_paths, print_text
from symdyn.emit import write_file
from symdyn.emit.print import printed_text


def run(options: argparse.Namespace) -> int:
    """Print the equations."""
    scene = read_scene_to_move(options)
    with Waiting("expanding"):
        text = printed_text(scene, options.format, options.group, options.angles, options.document, options.formulation)
    if options.output is None:
        print_text(text)
    else:
        print_paths(write_file(options.output, text if text.endswith("\n") else f"{text}\n"))
    return 0
