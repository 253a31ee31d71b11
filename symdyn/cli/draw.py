"""`symdyn draw SCENE`: a picture of the mechanism as SVG, PDF or PNG.

A planar scene is seen face-on, a spatial one in a parallel projection. The position is the scene's start; where it has
none, a position in which the coordinates can be seen. Loops are closed. `--watch` opens the playground with it, as
`symdyn play` does.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from symdyn.cli.scene_options import read_numbers, read_scene
from symdyn.cli.talk import Waiting, print_paths, print_text
from symdyn.draw import free_body, picture, pose
from symdyn.errors import DrawError
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
    """Serve the playground until Ctrl-C."""
    others = {"-o": options.output, "--body": options.body, "--json": options.json}
    for option, value in others.items():
        if value:
            raise DrawError(f"--watch shows the whole mechanism on a page; leave out {option}")
    from symdyn.cli.play import served

    at = read_numbers(options.at) if options.at else {}
    labels = tuple(filter(None, split_commas(options.labels)))
    return served(options, at=tuple(at.items()), view=view, frames=options.frames, labels=labels, scheme=options.scheme)


def _view(text: str) -> tuple[float, float]:
    parts = split_commas(text)
    try:
        azimuth, elevation = (float(part) for part in parts)
    except ValueError:
        raise DrawError(
            f'--view "{text}" is not two numbers; give azimuth and elevation, such as --view=-60,30'
        ) from None
    return azimuth, elevation
