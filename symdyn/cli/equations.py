"""`symdyn equations SCENE`: print the equations of motion in closed form."""

from __future__ import annotations

import argparse

from symdyn.cli.scene_options import read_scene_to_move
from symdyn.cli.talk import Waiting, print_text
from symdyn.emit.print import printed_text


def run(options: argparse.Namespace) -> int:
    """Print the equations."""
    scene = read_scene_to_move(options)
    with Waiting("expanding"):
        text = printed_text(scene, options.format, options.group, options.angles, options.document, options.formulation)
    print_text(text)
    return 0
