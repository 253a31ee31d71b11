"""`symdyn draw SCENE`: a picture of the mechanism as SVG, PDF or PNG.

A planar scene is seen face-on, a spatial one in a parallel projection. The position is the scene's start; where it has
none, a position in which the coordinates can be seen. Loops are closed. `--watch` shows it on a page while it is
written.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

from symdyn.algebra import Array
from symdyn.cli.scene_options import STDIN, read_scene, scene_and_notes
from symdyn.cli.talk import Waiting, print_paths, print_text, say
from symdyn.draw import free_body, picture, pose
from symdyn.errors import DrawError
from symdyn.scene import Scene, SceneUnits, parse
from symdyn.scene.values import FormulaError, Unit, fits, split_commas


def run(options: argparse.Namespace) -> int:
    """Draw the scene."""
    view = None if options.view is None else _view(options.view)
    if options.watch:
        return _watched(options, view)
    file = Path(options.output) if options.output else None
    scene = read_scene(options)
    with Waiting() as progress:
        progress("drawing")
        q, values = pose(scene, {} if options.at is None else _at(options.at, scene))
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
        watch(path, lambda: scene_and_notes(options), drawn, opened, {} if options.at is None else _at(options.at))
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


def _at(text: str, scene: Scene | None = None) -> dict[str, float]:
    """Return the coordinates of `q1=0.3, q2=90 deg`; with a scene, in units that fit."""
    values: dict[str, float] = {}
    units = {} if scene is None else SceneUnits(scene).letters
    for part in split_commas(text):
        name, equals, formula = (piece.strip() for piece in part.partition("="))
        if not name or not equals or not formula:
            raise DrawError(f'--at: "{part.strip()}" gives no coordinate a value; write --at q1=0.3,q2=1')
        if name in values:
            raise DrawError(f"--at: {name} gets two values; give one of them")
        try:
            fits(found := parse(formula), Unit.read(units[name]) if units.get(name) else None)
            value = found.at({})
        except FormulaError as fault:
            raise DrawError(f"--at: the value of {name} {fault}") from fault
        if value is None or not math.isfinite(value):
            raise DrawError(f'--at: {name} = "{formula}" is no number; write --at {name}=0.3')
        values[name] = float(value)
    return values
