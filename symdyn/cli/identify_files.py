"""What `symdyn identify -o` writes: a page, the identified scene, a table of parameters; the ending says which."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from symdyn.cli.talk import say, wrote
from symdyn.emit import write
from symdyn.errors import IdentifyError
from symdyn.identification import Identification, Outcome
from symdyn.table import Table


@dataclass(frozen=True)
class FileKind:
    """A kind of file.

    Attributes:
        text: what it is, for the help.
        contents: what stands in it.
        scene: whether it is a scene, which nobody wants to overwrite unawares.
    """

    text: str
    contents: Callable[[Outcome], str]
    scene: bool = False


def _page(outcome: Outcome) -> str:
    text, why = outcome.page()
    if why:
        say(f"symdyn: the page has no identified scene: {why}")
    return text


def _scene(outcome: Outcome, format: str) -> str:
    text = outcome.text(format)
    for line in text.lost:
        say(f"symdyn: left out: {line}")
    return text.text


def _table(outcome: Outcome) -> str:
    """Return the base parameters as CSV."""
    found = outcome.identification
    numbers = np.column_stack([found.before, found.after, found.errors, found.interval()])
    heads = ("parameter", "before", "after", "standard error", "from", "to")
    return Table(heads, [(name, *row) for name, row in zip(found.names, numbers.tolist(), strict=True)]).csv()


FILES = {
    ".html": FileKind("a page with all of it", _page),
    ".toml": FileKind("the identified scene", partial(_scene, format="toml"), True),
    ".urdf": FileKind("the same as URDF", partial(_scene, format="urdf"), True),
    ".csv": FileKind("the base parameters", _table),
}
"""By ending."""

MADE = frozenset((".html", ".toml", ".urdf"))
"""Endings of files that tell of the identified scene."""


def add_file_options(verb: argparse.ArgumentParser) -> None:
    """Add what is written, and how inertias are chosen there."""
    known = "; ".join(f"{ending}: {kind.text}" for ending, kind in FILES.items())
    verb.add_argument("-o", "--output", action="append", default=[], metavar="FILE", help=f"may be repeated; {known}")
    verb.add_argument("--total-mass", type=float, metavar="KG", help="of all bodies together, in the identified scene")
    verb.add_argument("--force", action="store_true", help="overwrite a scene that exists")


def check_files(options: argparse.Namespace) -> None:
    """Raise before the work begins what could not be written after it.

    Raises:
        IdentifyError: an ending that is none of these, a scene that exists, a total mass that is none.
    """
    faults = []
    for name in options.output:
        path = Path(name)
        kind = FILES.get(path.suffix.lower())
        if kind is None:
            faults.append(f"{path}: -o writes {', '.join(FILES)} files")
        elif kind.scene and path.exists() and not options.force:
            faults.append(f"{path} exists; give another name, or --force to overwrite it")
    if options.total_mass is not None and not 0 < options.total_mass < float("inf"):
        faults.append(f"--total-mass: {options.total_mass:g} is no mass; give one above zero, kg")
    if options.total_mass is not None and not {Path(name).suffix.lower() for name in options.output} & MADE:
        faults.append("--total-mass: is of the identified scene; give a file for it, such as -o identified.toml")
    if faults:
        raise IdentifyError(faults)


def write_files(identification: Identification, outputs: Sequence[str], total_mass: float | None, command: str) -> None:
    """Write what `-o` asks for, all of it or nothing, and say where."""
    asked = Outcome(identification, total_mass, command)
    paths = [Path(name) for name in outputs]
    contents = [FILES[path.suffix.lower()].contents(asked) for path in paths]
    if any(FILES[path.suffix.lower()].scene for path in paths):
        for note in asked.made.notes:
            say(f"symdyn: {note}")
    for path, text in zip(paths, contents, strict=True):
        write({path.name: text}, path.parent)
    wrote(*paths)
