"""`symdyn verify SCENE`: prove the derivations equal and measure the built code.

Exit status 0 if every claim holds and there is one, 1 if anything fails or is not shown.

`--rigorous` runs the equations over ball arithmetic instead, and prints how far the built code can be off, guaranteed.

`symdyn verify SCENE --files DIR`: files that were generated long ago, proved to be the scene's equations.

Which functions, which target and which options stands in the files: the command that made them is read as data, by the
parser of that command, and what it must not hold is refused. Nothing of a file is ever run.
"""

from __future__ import annotations

import argparse
import math
import re
import shlex
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

from symdyn.bounds import BOUNDS
from symdyn.cli import Parser, generate
from symdyn.cli.options import add_options
from symdyn.cli.scene_options import closing_of, functions_of, read_numbers, read_scene, split
from symdyn.cli.talk import Waiting, answer, print_table
from symdyn.dynamics import Requested, Workspace
from symdyn.emit import emit
from symdyn.errors import VerifyError, printable
from symdyn.program import lower, prepare
from symdyn.rounding import in_digits
from symdyn.table import Table
from symdyn.verdict import Unclaimed, Verdict
from symdyn.verify import Certificate, Rigorous, certify, rigorous, why_unread

OTHER_CODE = {
    "prepare": "code without prepare",
    "accuracy": "code of full accuracy",
    "targets": "every module that runs quickly here",
}
"""Options of code that --rigorous does not measure, and what it measures."""


def run(options: argparse.Namespace) -> int:
    """Print the certificate, or the bounds."""
    _check_rigorous(options)
    if options.files is not None:
        with Waiting() as progress:
            found = _of_files(options, progress)
        answer(found.as_dict(), lambda: show(found))
        return 0 if found.passed else 1
    scene = read_scene(options)
    closing = closing_of(options, scene)
    outputs = functions_of(options, scene)
    if options.rigorous:
        at = None if options.at is None else read_numbers(options.at, scene)
        sampled = {} if options.states is None else {"states": options.states}
        code = {"seed": options.seed, "real": options.real, "formulation": options.formulation}
        with Waiting() as progress:
            bounds = rigorous(scene, outputs, at, progress=progress, closing=closing, **sampled, **code)
        answer(bounds.as_dict(), lambda: show_bounds(bounds))
        return 0 if bounds.passed else 1
    with Waiting() as progress:
        certificate = certify(
            scene,
            outputs,
            options.seed,
            progress,
            options.real,
            options.formulation,
            options.prepare,
            closing,
            split(options.targets),
            options.accuracy,
        )
    answer(certificate.as_dict(), lambda: show(certificate))
    return 0 if certificate.passed else 1


def _check_rigorous(options: argparse.Namespace) -> None:
    """Raise VerifyError for what would do nothing, with --rigorous or without."""
    for option, value in (("--at", options.at), ("--states", options.states)):
        if value is not None and not options.rigorous:
            raise VerifyError(f"{option} goes with --rigorous: proofs hold everywhere")
    if not options.rigorous:
        return
    for name, code in OTHER_CODE.items():
        if getattr(options, name):
            raise VerifyError(f"--rigorous measures {code}; leave out --{name}")
    if options.at is not None and options.states is not None:
        raise VerifyError("--at is one state, and --states samples others; leave one of the two out")
    if options.states is not None and options.states < 1:
        raise VerifyError(f"--states {options.states}: give one state at least")


def _of_files(options: argparse.Namespace, progress: Callable[[str], None]) -> Certificate:
    """Return the certificate of the files of a folder; their headers say all that options could."""
    said = [
        action.option_strings[0]
        for action in options.parser._actions
        if action.option_strings
        and action.dest not in ("files", "seed", "json", "quiet", "digits", "help")
        and getattr(options, action.dest) != action.default
    ]
    if said:
        raise VerifyError(f"{said[0]} goes without --files: what the files are, their headers say; leave {said[0]} out")
    return certify_files(options, progress)


def show_bounds(result: Rigorous) -> None:
    """Print guaranteed bounds for people: a row an entry, a column a module."""
    modules = list(dict.fromkeys(bound.module for bound in result.bounds))
    rows: dict[tuple[str, tuple[int, ...]], dict[str, str]] = {}
    exact: dict[str, int] = {}
    for bound in result.bounds:
        cell = f"{in_digits(bound.error, 3, 'e')} ({in_digits(bound.ulps, 2)})" if bound.error else "0"
        rows.setdefault((bound.function, bound.index), {})[bound.module] = cell
    for (function, _), cells in rows.items():
        exact[function] = exact.get(function, 0) + all(cell == "0" for cell in cells.values())
    lines = [
        (function, ",".join(map(str, index)), *(cells.get(module, "") for module in modules))
        for (function, index), cells in rows.items()
        if any(cell != "0" for cell in cells.values())
    ]
    lines += [(function, f"{number} others", *("0" for _ in modules)) for function, number in exact.items() if number]
    lines.sort(key=lambda line: list(exact).index(line[0]))
    columns = ("function", "entry", *modules)
    title = f"{result.scene}: guaranteed error (in ulps of the entry)"
    print_table(Table(columns, lines, range(2, len(columns)), title))
    states = max((len(states) for states in result.states.values()), default=0)
    print(
        f"Guaranteed at {states} state{'s' * (states != 1)}; balls of up to {result.bits} bits; --json has the states."
    )
    show_claims(result)
    print(f"{result.scene}: {'every error is bounded' if result.passed else result.verdict}")


def show_claims(result: Certificate | Rigorous) -> None:
    """Print what does not hold and why, what is no claim, and notes."""
    for line in (*result.lines, *(f"Note: {note}" for note in result.notes)):
        print(line)


def show(certificate: Certificate) -> None:
    """Print the certificate for people."""
    rows = []
    for finding in certificate.findings:
        sure = f"1e{finding.error_log10:.0f}" if finding.verdict == Verdict.PROVED else ""
        verdict = (
            f"{finding.verdict} at entry {finding.where}" if finding.verdict == Verdict.DIFFERENT else finding.verdict
        )
        rows.append((finding.claim, verdict, str(finding.degree or ""), sure))
    heads = ("claim", "verdict", "degree", "chance of error")
    print_table(Table(heads, rows, (2, 3), f"{certificate.scene}: equations"))
    fields = certificate.fields
    primes = " and ".join(map(str, fields.primes))
    print(f"Proved at {fields.points} random points each over the primes {primes} (seed {fields.seed}).\n")
    show_written(certificate)
    for one in certificate.blocks:
        lengths = f"{one.functions} functions over 0, 1, … {one.longest} states in {' and in '.join(one.ways)}"
        print(f"{one.target} --{one.option}: {lengths}, as one state at a time: {one.verdict}.\n")
    measured = [
        (
            a.function,
            a.module,
            *(_ulps(x) if a.states else "" for x in (a.median_ulp, a.max_ulp)),
            in_digits(a.worst, 2) if a.states else "",
            a.verdict,
        )
        for a in certificate.accuracy
    ]
    if measured:
        show_measured(certificate, measured)
    show_claims(certificate)
    print(f"{certificate.scene}: {certificate.word}")


OF_ZERO, MOST_ULPS = "of 0", 1e100


def _ulps(error: float) -> str:
    """Return an error in ulps; what is exactly 0 has no last place, in units of which roundings could be counted."""
    return OF_ZERO if MOST_ULPS < error < math.inf else in_digits(error, 2)


def show_measured(certificate: Certificate, measured: Sequence[tuple[str, ...]]) -> None:
    """Print how far built code is off."""
    columns = ("function", "module", "median", "max", "of bound", "")
    states = max(one.states for one in certificate.accuracy)
    title = f"Error of the built code against 50 digits, {states} states, ulp of the largest entry"
    print_table(Table(columns, measured, (2, 3, 4), title))
    zero = f"'{OF_ZERO}': the exact result is 0, which has no ulp. " if any(OF_ZERO in row for row in measured) else ""
    share = "'of bound' is the worst entry's share of its own error bound"
    print(f"Errors are in ulps of the largest entry; {zero}{share}.\n")


def show_written(certificate: Certificate) -> None:
    """Print what was proved of files, if anything."""
    rows = [
        (
            f"{one.target} --{one.option}" if one.option else one.target,
            one.file,
            one.sha256[:12],
            one.verdict or "none",
            str(len(one.functions) or ""),
            str(one.compared),
        )
        for one in certificate.written
    ]
    if rows:
        columns = ("target", "file", "sha256", "arithmetic", "functions", "bytes of fixed text")
        title = "Files read back: the same functions, constants rounded correctly"
        print_table(Table(columns, rows, (4, 5), title))
        print("Fixed text (sines, tiles, loops over blocks) is that of the templates, and measured.\n")


COMMAND = re.compile(r"^[^\w\n]*(symdyn generate [ -~]{1,4000})\r?$", re.MULTILINE)
"""The line of a header, whatever begins a comment there, or in JSON a string; no line is looked at twice."""

HEADER = 1 << 20
MOST_FILES, LARGEST = BOUNDS["generated files that are read"], BOUNDS["bytes of a generated file"]

NEVER = ("-h", "--help", "-o", "--output", "--json", "-q", "--quiet")
"""What no header says."""


class _Header(Parser):
    """The parser of `symdyn generate`, whose faults are those of a file."""

    def error(self, message: str) -> NoReturn:
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
    add_options(header, "generate")
    header.set_defaults(verb="generate", parser=header)
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
    fresh = emit(program, requested.target, requested.real, command, generate.option_of(requested), requested.accuracy)
    there = {name: (folder / name).read_bytes() for name in fresh if (folder / name).is_file()}
    return Certificate.of_files(
        equations, program, fresh, there, options.seed, (f"made by: {command}",), progress
    )  # fmt: skip
