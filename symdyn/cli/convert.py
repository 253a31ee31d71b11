"""`symdyn convert SCENE OUT`: the same mechanism in another format, TOML, URDF, SDF or Khalil's .par."""

from __future__ import annotations

import argparse
from pathlib import Path

from symdyn.cli.scene_options import read_scene
from symdyn.cli.talk import give, print_paths, say
from symdyn.emit import write_file
from symdyn.errors import EmitError
from symdyn.scene import format_to_write, write_text


def run(options: argparse.Namespace) -> int:
    """Write the scene and print its path."""
    path = Path(options.output)
    format = format_to_write(path)
    if path.exists() and not options.force:
        raise EmitError(f"{path} exists; give another name, or --force to overwrite it")
    written = write_text(read_scene(options), format, options.lossy)
    write_file(path, written.text)
    give({"format": format, "lost": list(written.lost)})
    for line in written.lost:
        say(f"symdyn: left out: {line}")
    print_paths(path)
    return 0
