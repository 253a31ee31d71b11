"""The command line: one file a verb. Results on stdout, talk on stderr; exit status 0, 1 (our errors) or 2 (usage)."""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn

from symdyn import shell
from symdyn.cli.options import add_options, flag
from symdyn.cli.talk import begin, fail, prepare_streams, print_json, say, silence_stdout
from symdyn.errors import SymdynError, SymdynWarning, choice, hint, nearest, printable, quoted, without_long_words
from symdyn.resources import version
from symdyn.rounding import showing

VERBS = {
    "equations": "print the equations of motion",
    "walkthrough": "write the derivation as a lesson",
    "check-derivation": "compare a student's result with the scene's",
    "generate": "write code for NumPy, C and other tools",
    "verify": "prove the equations, measure the code",
    "simulate": "compute the motion that forces give",
    "sweep": "runs at many values of parameters and starts, and measures of them",
    "inverse": "compute the forces that a motion takes",
    "gait": "a periodic motion, its period and Floquet multipliers",
    "linearize": "A, B, C, D, modes and stability about an operating point",
    "identify": "tell parameters from measured motion",
    "calibrate": "tell lengths, angles and zeros of joints from measured poses",
    "bench": "measure run time against error",
    "stress": "hard cases for the numerics",
    "info": "show the mechanism and what its functions cost",
    "draw": "draw the mechanism",
    "play": "write a scene on a page that shows what it is",
    "convert": "write a scene in another format",
    "new": "write a commented scene to start from",
    "completion": "print what completes all this in a shell",
    "doctor": "tell what is installed, and what is missing for what",
}
"""What each verb does; it is a file here, read once it is chosen."""

EMPTY = ("families", "labels")
"""Options that mean something where they are empty, as their help says."""

CTRL_C = 130
"""Exit status of what was interrupted."""


class Parser(argparse.ArgumentParser):
    """A parser whose messages are printable, whatever an argument holds.

    Options are written out: `--force` is none of `linearize`, which takes `--forces`, and must not be read as one.
    """

    def __init__(self, *words: Any, **named: Any) -> None:
        super().__init__(*words, **{"formatter_class": _formatter, **named})
        self.allow_abbrev, self._given = False, dict[str, list[str]]()

    def parse_known_args(self, *words: Any, **named: Any) -> Any:
        """Parse, knowing all that is taken; what looks like an option and is none is told what was meant."""
        if own := self.get_default("parser") is not None:
            before = [*takewhile(lambda word: word != "--", words[0])]
            self._refuse_unknown([word for word in before if word.startswith("--") and " " not in word])
            for word in before:  # argparse takes "--" away wherever it stands, and leaves a list of nothing
                if word.startswith("-") and word[2:].rpartition("=")[2] == "--" and word.count("=") < 2:
                    self.error(f"{word}: -- is no value; give one, such as ./-- for a file of that name")
        found, rest = super().parse_known_args(*words, **named)
        self._refuse_unknown([word for word in rest if word.startswith("-") and word not in ("-", "--")])
        rest = self._taken_late(found, rest)
        if own and rest and "=" in rest[0] and "=" in (given := words[0][words[0].index(rest[0]) - 1]):
            self.error(f'{rest[0]}: several values are one text with commas, "{",".join((given, *rest))}"')
        return found, rest

    def _taken_late(self, options: argparse.Namespace, rest: list[str]) -> list[str]:
        """Give files behind options to the list that takes any number of them, and return what nothing takes.

        argparse closes that list, empty, at the first option behind the scene: `identify SCENE --bind g=9.81 DATA.csv`.
        """
        for action in self._actions:
            if not action.option_strings and action.nargs == argparse.ZERO_OR_MORE:
                late = [word for word in rest if word != "--"]
                setattr(options, action.dest, [*getattr(options, action.dest), *late])
                return []
        return rest

    def _refuse_unknown(self, words: Sequence[str]) -> None:
        known = {name: str(action.help) for action in self._actions for name in action.option_strings}
        unknown = [name for name in (word.partition("=")[0] for word in words) if name not in known]
        if unknown:
            self.error("; ".join(f"{name} is no option{_meant(name, known)}" for name in unknown))

    def _get_values(self, action: argparse.Action, arg_strings: list[str]) -> Any:
        """Return what an option is given, of a list all that it is given, and of one value one; nothing is refused."""
        option = action.option_strings[-1] if action.option_strings else ""
        if option and "" in map(str.strip, arg_strings) and action.dest not in EMPTY:
            self.error(f"{option}: is empty; give {action.metavar or 'a value'}, or leave it out")
        if option and action.nargs != 0 and not isinstance(action, argparse._AppendAction):
            again, every = option in self._given, [*self._given.get(option, ()), *arg_strings]
            if again and action.nargs not in ("*", "+") and action.metavar != "LIST":
                self.error(f"{option} is given twice{': ' * bool(every)}{' and '.join(every)}; give one")
            self._given[option] = every
            arg_strings = [",".join(every)] if action.metavar == "LIST" else every
        return super()._get_values(action, arg_strings)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            what = f"{action.option_strings[0]}: there is no" if action.option_strings else f"there is no {action.dest}"
            verb = hint("verbs", str(value)) if action.dest == "verb" else ""
            meant = verb.replace("$", str(value)) or choice(str(value), [*map(str, action.choices)])
            raise argparse.ArgumentError(None, f"{what} {quoted(value)}; {meant}")

    def error(self, message: str) -> NoReturn:
        """Print the message and where more stands, and exit with 2."""
        told = printable(without_long_words(message.removeprefix("argument ")), keep="")
        self.exit(2, f"{self.prog}: {told}\nsee: {self.prog} --help\n")


def _formatter(prog: str) -> argparse.HelpFormatter:
    """Return what lays out help; argparse itself asks `shutil` for the width, with all its compressors."""
    said = os.environ.get("COLUMNS", "")
    try:
        width = int(said) if said.isdecimal() and int(said) else os.get_terminal_size().columns
    except OSError:  # no terminal
        width = 80
    return argparse.HelpFormatter(prog, width=width - 2)


class VerbParser:
    """A parser that is made when it is asked: there are many verbs, of which a command has one."""

    def __init__(self, **words: Any) -> None:
        self.words = words

    def parse_known_args(self, *words: Any, **named: Any) -> Any:
        return self.made.parse_known_args(*words, **named)

    @property
    def made(self) -> Parser:
        """A parser with all that the verb takes."""
        found = Parser(**self.words)
        add_options(found, found.prog.rpartition(" ")[2])
        found.set_defaults(parser=found)
        return found


def _meant(word: str, known: Mapping[str, str]) -> str:
    """Return what an unknown option may have meant, in words; "" for nothing near."""
    if told := hint("options", word, known):
        return f"; {told.replace('$', word.lstrip('-')).replace('{template}', known.get('--template', ''))}"
    near = [name for name in known if len(word) > 2 and name.startswith(word)] or filter(None, [nearest(word, known)])
    meant = " or ".join(near)
    return f"; did you mean {meant}?" if meant else ""


class Version(argparse.Action):
    """Prints the version, which is looked up then: that takes longer than to read a command line."""

    def __call__(self, *_: Any) -> NoReturn:
        print(f"symdyn {version()}")
        sys.exit(0)


def parser() -> argparse.ArgumentParser:
    """Return the parser of all verbs."""
    top = Parser(
        prog="symdyn",
        description="Equations of motion of mechanisms: printed, generated as NumPy and C, and proved.",
        epilog="Start with: symdyn new arm --template rr && symdyn equations arm.toml",
    )
    top.add_argument("--version", action=Version, nargs=0, help="show program's version number and exit")
    verbs = top.add_subparsers(dest="verb", metavar="VERB", required=True, parser_class=VerbParser)  # type: ignore[type-var]
    for verb, does in VERBS.items():
        verbs.add_parser(verb, help=does)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status; warnings of ours are talk.

    Without `arguments` it is the process's own command line that is run.
    """
    if arguments is None:
        shell.take()
    with warnings.catch_warnings():
        warnings.showwarning = partial(_show, warnings.showwarning)
        return run(arguments)


def _show(others: Callable[..., None], message: Warning | str, category: type[Warning], *where: Any) -> None:
    if issubclass(category, SymdynWarning):
        say(str(message))
    else:
        others(message, category, *where)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    prepare_streams()
    begin()
    try:
        options = parser().parse_args(arguments)
        answer = begin(options.quiet, options.json)
        status = _status(options)
        if options.json:
            scene = getattr(options, "scene", None)
            print_json(answer.as_dict(options.verb, scene and Path(scene).name, status))
        sys.stdout.flush()
    except KeyboardInterrupt:
        fail("interrupted")
        return CTRL_C
    except BrokenPipeError:  # the reader, such as head, has seen enough
        silence_stdout()
        return 0
    except OSError as fault:  # a full disk under stdout, for one
        fail(f"{fault.filename or 'standard output'}: {fault.strerror or fault}")
        return 1
    return status


def _status(options: argparse.Namespace) -> int:
    """Run a verb and return its exit status; what ends it is told."""
    from symdyn.arguments import naming  # help needs none

    try:
        with showing(options.digits), naming(partial(flag, options.parser._option_string_actions)):
            verb = import_module(f"symdyn.cli.{options.verb.replace('-', '_')}")
            status: int = verb.run(options)
    except SymdynError as fault:
        fail(fault)
        return 1
    except MemoryError as fault:
        fail(f"too little memory ({fault or 'this machine has no more'}); ask for less at once")
        return 1
    except KeyboardInterrupt:
        fail("interrupted")
        return CTRL_C
    return status
