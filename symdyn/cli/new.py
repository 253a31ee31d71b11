"""`symdyn new NAME`: write a commented scene to start from, or one of the examples."""

from __future__ import annotations

import argparse
from pathlib import Path

from symdyn.cli.talk import print_paths
from symdyn.emit import write
from symdyn.emit.code import page_stem
from symdyn.errors import EmitError, SceneError
from symdyn.scene import Starter


def run(options: argparse.Namespace) -> int:
    """Write the scene and print its path."""
    name = (options.name or options.example or "").removesuffix(".toml").replace("-", "_")
    file, text = _example(options, name) if options.example else (f"{name}.toml", _starter(options, name))
    path = Path(file)
    if page_stem(name) != name:
        raise EmitError(f"{path} is a device on Windows, whatever the letters' case; try {name}1")
    if path.exists() and not options.force:
        raise EmitError(f"{path} exists; give another name, or --force to overwrite it")
    write({path.name: text}, ".")
    print_paths(path)
    return 0


def _starter(options: argparse.Namespace, name: str) -> str:
    if not name:
        raise SceneError("new: it needs a name; `symdyn new arm --template rr`, or `symdyn new --example four_bar`")
    template = (options.template or (name if name in Starter.TEMPLATES else "rr")).replace("-", "_")
    return Starter(name).from_template(template, options.n)


def _example(options: argparse.Namespace, name: str) -> tuple[str, str]:
    """Return the file of an example, its name and text, called by the name that was chosen for it."""
    beside = [f"--{word}" for word in ("template", "n") if getattr(options, word) is not None]
    if beside:
        raise SceneError(f"new: --example {options.example} is a whole scene; leave {' and '.join(beside)} out")
    return Starter(name).from_example(options.example.replace("-", "_"))
