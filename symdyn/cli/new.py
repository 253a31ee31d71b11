"""`symdyn new NAME`: write a commented scene to start from."""

from __future__ import annotations

import argparse
from pathlib import Path

from symdyn.cli.talk import print_paths
from symdyn.emit import write
from symdyn.emit.code.identifiers import is_device
from symdyn.errors import EmitError
from symdyn.scene.starters import STARTERS, starter


def add_options(verb: argparse.ArgumentParser) -> None:
    """Add what the verb takes."""
    verb.add_argument("name", help="name of the scene; NAME.toml is written here")
    verb.add_argument(
        "--template",
        help="rr, rrp, rrr, cart_pole, puma, arm7, chain, four_bar, slider_crank or n_four_bar; default: NAME, else rr",
    )
    verb.add_argument("--n", type=int, help="number of links of a chain, of four-bars in a row")
    verb.add_argument("--force", action="store_true", help="overwrite an existing file")


def run(options: argparse.Namespace) -> int:
    """Write the scene and print its path."""
    name = options.name.replace("-", "_")
    template = (options.template or (name if name in STARTERS else "rr")).replace("-", "_")
    text = starter(name, template, options.n)
    path = Path(f"{name}.toml")
    if is_device(name):
        raise EmitError(f"{path} is a device on Windows, whatever the letters' case; try {name}1")
    if path.exists() and not options.force:
        raise EmitError(f"{path} exists; give another name, or --force to overwrite it")
    write({path.name: text}, ".")
    print_paths(path)
    return 0
