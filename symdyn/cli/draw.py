"""`symdyn draw SCENE`: a picture of the mechanism as SVG, PDF or PNG.

A planar scene is seen face-on, a spatial one in a parallel projection. The position is the scene's start; where it has
none, a position in which the coordinates can be seen. Loops are closed. `--watch` shows it on a page while it is
written.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from symdyn.algebra import Array
from symdyn.cli.scene_options import STDIN, read_numbers, read_scene, scene_and_notes
from symdyn.cli.talk import Waiting, print_paths, print_text, say
from symdyn.draw import free_body, picture, pose
from symdyn.errors import DrawError
from symdyn.scene import Scene
from symdyn.scene.values import split_commas


def run(options: argparse.Namespace) -> int:
    """Draw the scene."""
    view = None if options.view is None else _view(options.view)
    if options.watch:
        return _watched(options, view)
    file = Path(options.output) if options.output else None
    scene = read_scene(options)
    with Waiting("drawing"):
        q, values = pose(scene, read_numbers(options.at, scene) if options.at else {})
        if options.body is not None:
            text = free_body(scene, options.body, q, None, values, view, "", options.scheme, file)
        else:
            labels = tuple(filter(None, split_commas(options.labels)))
            text = picture(scene, q, values, view, options.frames, labels, (), "", options.scheme, file)
    if file is None:
        print_text(text, end="")
    else:
        print_paths(file)
    return 0


def _watched(options: argparse.Namespace, view: tuple[float, float] | None) -> int:
    """Serve the page until Ctrl-C, which is its ordinary end."""
    from symdyn.watch import watch

    path, others = Path(options.scene), {"-o": options.output, "--body": options.body, "--json": options.json}
    for option, value in others.items():
        if value:
            raise DrawError(f"--watch shows the whole mechanism on a page; leave out {option}")
    if options.scene == STDIN or not path.is_file():
        raise DrawError(f"--watch follows a file; {options.scene} is none: give a file that is there")
    labels = tuple(filter(None, split_commas(options.labels)))

    def drawn(scene: Scene, q: Array, values: dict[str, float]) -> str:
        return picture(scene, q, values, view, options.frames, labels, (), "", options.scheme)

    def opened(address: str) -> None:
        print_text(address)
        sys.stdout.flush()
        say("open this address in a browser; Ctrl-C ends it")

    try:
        watch(path, lambda: scene_and_notes(options), drawn, opened, read_numbers(options.at) if options.at else {})
    except KeyboardInterrupt:
        return 0
    return 0


def _view(text: str) -> tuple[float, float]:
    parts = split_commas(text)
    try:
        azimuth, elevation = (float(part) for part in parts)
    except ValueError:
        raise DrawError(
            f'--view "{text}" is not two numbers; give azimuth and elevation, such as --view=-60,30'
        ) from None
    return azimuth, elevation
