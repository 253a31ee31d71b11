"""`symdyn verify SCENE --files DIR`: files that were generated long ago, proved to be the scene's equations.

Which functions, which target and which options stands in the files: the command that made them is read as data, by the
parser of that command, and what it must not hold is refused. Nothing of a file is ever run.
"""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

from symdyn.bounds import BOUNDS
from symdyn.cli import Parser, add_talk, generate
from symdyn.cli.scene_options import closing_of, read_scene, split
from symdyn.dynamics import Requested, Workspace
from symdyn.emit import emit
from symdyn.errors import VerifyError, printable
from symdyn.program import lower, prepare
from symdyn.verdict import Unclaimed
from symdyn.verify import Certificate, why_unread

COMMAND = re.compile(r"^[^\w\n]*(symdyn generate [ -~]{1,4000})\r?$", re.MULTILINE)
"""The line of a header, whatever begins a comment there, or in JSON a string; no line is looked at twice."""

HEADER = 1 << 20
MOST_FILES, LARGEST = BOUNDS["generated files that are read"], BOUNDS["bytes of a generated file"]

NEVER = ("-h", "--help", "-o", "--output", "--json", "-q", "--quiet")
"""What no header says."""


class _Header(Parser):
    """The parser of `symdyn generate`, whose faults are those of a file."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong."""
        raise VerifyError(message)


def certify_files(options: argparse.Namespace, progress: Callable[[str], None]) -> Certificate:
    """Return the certificate of the files of a folder.

    Raises:
        VerifyError: there are none, or they say what no file of ours says.
    """
    folder = Path(options.files)
    commands = commands_in(folder)
    if not commands:
        raise VerifyError(
            f"{folder}: no file there says which command made it; give a folder that symdyn generate has written to"
        )
    wanted = {command: options_of(command, f"{folder / files[0]}") for command, files in commands.items()}
    read = [command for command in commands if not why_unread(wanted[command].target)]
    if not read:
        target, (file, *_) = next(iter(wanted.values())).target, next(iter(commands.values()))
        raise VerifyError(f"{folder / file}: {why_unread(target)}")
    parts = [_of_command(options, folder, command, wanted[command], progress) for command in read]
    names = sorted(_names(folder))
    found = Certificate.of_folder(parts, folder, names)
    judged = {one.file for one in found.written}
    unread = {name: wanted[one].target for one, files in commands.items() if one not in read for name in files}
    left = [name for name in names if name not in judged and name not in unread]
    ours = [name for name in left if any(name in files for files in commands.values())]
    told = (
        [f"not read, by their names they are another scene's: {', '.join(printable(one, '') for one in ours)}"]
        if ours
        else []
    )
    others = ", ".join(printable(one, "") for one in left if one not in ours)
    told += [f"not read, nothing there says it is ours: {others}"]
    told = told if len(left) > len(ours) else told[:-1]
    unreadable = [
        Unclaimed(f"the text of {', '.join(one for one in unread if unread[one] == target)}", why_unread(target))
        for target in dict.fromkeys(unread.values())
    ]
    return replace(found, notes=tuple(dict.fromkeys((*found.notes, *told))), unshown=tuple(unreadable))


def commands_in(folder: Path) -> dict[str, list[str]]:
    """Return the commands that files of a folder say they were made by, each with these files.

    Raises:
        VerifyError: it is no folder, or holds too much.
    """
    if not folder.is_dir():
        raise VerifyError(
            f"{folder}: is no folder; give the one that symdyn generate wrote to, as in --files generated"
        )
    found: dict[str, list[str]] = {}
    for name in sorted(_names(folder)):
        with (folder / name).open("rb") as file:
            header = file.read(HEADER).decode("utf-8", "replace")
        said = COMMAND.search(header)
        if said is not None:
            found.setdefault(said[1].rstrip().removesuffix('",'), []).append(name)
    return found


def _names(folder: Path) -> list[str]:
    """Return the files of a folder and of those in it; of a package for MATLAB, of its private folders too."""
    paths = [path for pattern in ("*", "*/*", "*/private/*") for path in folder.glob(pattern) if path.is_file()]
    if len(paths) > MOST_FILES or any(path.stat().st_size > LARGEST for path in paths):
        raise VerifyError(
            f"{folder}: holds more than {MOST_FILES} files, or one that is too large; give another folder"
        )
    return [path.relative_to(folder).as_posix() for path in paths]


def options_of(command: str, where: str) -> argparse.Namespace:
    """Return what the command of a header asks for; it is data, and never run.

    Raises:
        VerifyError: it asks for what no header does.
    """
    try:
        words = shlex.split(command)[2:]
    except ValueError as fault:
        raise VerifyError(f"{where}: its command is no line of a shell: {fault}") from fault
    strange = [word for word in words if word.partition("=")[0] in NEVER or any(mark in word for mark in "\0\n")]
    if strange:
        raise VerifyError(f"{where}: its command says {strange[0]}, which no file of ours says")
    header = _Header(prog="symdyn generate", add_help=False, allow_abbrev=False)
    generate.add_options(header)
    add_talk(header)
    header.set_defaults(run=None, verb="generate", parser=header)
    try:
        return header.parse_args(words)
    except VerifyError as fault:
        raise VerifyError(f"{where}: its command is none of this version: {fault}") from fault


def _of_command(
    options: argparse.Namespace,
    folder: Path,
    command: str,
    requested: argparse.Namespace,
    progress: Callable[[str], None],
) -> Certificate:
    """Return the certificate of the files of one command, made again for the scene."""
    requested.scene = options.scene
    scene = read_scene(requested)
    closing = closing_of(requested, scene)
    progress("deriving")
    names = split(requested.functions)
    outputs = Requested.of(Workspace(scene, closing)).available()[0] if names is None else names
    equations = generate.equations_of(requested, scene, outputs, closing)
    program = lower(equations)
    if requested.prepare:
        program = prepare(program)
    progress("reading files back")
    fresh = emit(program, requested.target, requested.real, command, requested.option, requested.accuracy)
    there = {name: (folder / name).read_bytes() for name in fresh if (folder / name).is_file()}
    return Certificate.of_files(
        equations, program, fresh, there, options.seed, (f"made by: {command}",), progress
    )  # fmt: skip
