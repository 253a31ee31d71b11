"""`symdyn play`: a page on which a scene is written, and its picture, equations, code and motion are seen at once.

The page is served to this machine alone, until Ctrl-C. It begins with the scene, follows its file as it is saved, and
writes it where one saves on the page. A robot's file, or one that is read with other options, is shown as the TOML that
it is read as, and never written.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from symdyn.cli.scene_options import STDIN, scene_and_notes
from symdyn.cli.talk import print_text, say
from symdyn.errors import SceneError
from symdyn.playground import Settings, play
from symdyn.scene import write_text

CHANGING = ("symbolic", "bind", "spanning_tree", "floating_base")
"""Options of reading that make another scene of a file."""


def run(options: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C."""
    if options.json:
        raise SceneError("play: a page is no JSON; leave --json out")
    return served(options)


def served(options: argparse.Namespace, **drawn: Any) -> int:
    """Serve the page until Ctrl-C, which is its ordinary end; `drawn` as in `Settings`."""
    path = None if options.scene is None else Path(options.scene)
    if path is not None and (options.scene == STDIN or not path.is_file()):
        raise SceneError(f"the page follows a file; {options.scene} is none: give a file that is there")
    settings = Settings(**drawn, allow_invalid_inertia=options.allow_invalid_inertia, dimensionless=options.no_units)
    if path is not None:
        settings = replace(settings, source=str(path.with_suffix(".toml")))

    def text_of() -> str:
        scene, _ = scene_and_notes(options)
        return write_text(scene, "toml").text

    def opened(address: str) -> None:
        print_text(address)
        sys.stdout.flush()
        say("open this address in a browser; Ctrl-C ends it")

    plain = path is None or (path.suffix == ".toml" and not any(getattr(options, name) for name in CHANGING))
    try:
        play(path, None if plain else text_of, settings, opened)
    except KeyboardInterrupt:
        return 0
    return 0
