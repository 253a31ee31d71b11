"""The command line: one file a verb. Results on stdout, talk on stderr; exit status 0, 1 (our errors) or 2 (usage)."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from typing import Any, NoReturn

from symdyn.cli.streams import prepare_streams, silence_stdout
from symdyn.errors import SymdynError, SymdynWarning, printable

VERBS = {
    "equations": "print the equations of motion",
    "walkthrough": "write the derivation as a lesson",
    "check-derivation": "compare a student's result with the scene's",
    "generate": "write a NumPy module, C or JavaScript",
    "verify": "prove the equations, measure the code",
    "simulate": "compute the motion that forces give",
    "inverse": "compute the forces that a motion takes",
    "linearize": "A, B, C, D, modes and stability next to a point",
    "bench": "measure run time against error",
    "stress": "hard cases for the numerics",
    "info": "show the mechanism and what its functions cost",
    "draw": "draw the mechanism as SVG",
    "convert": "write a scene in another format",
    "new": "write a commented scene to start from",
}
"""What each verb does; it is a file here, read once it is chosen."""


class Parser(argparse.ArgumentParser):
    """A parser whose messages are printable, whatever an argument holds; that of a verb reads the verb's file late."""

    verb = ""

    def complete(self) -> Parser:
        """Return this parser with all that it takes."""
        if self.verb:
            module = import_module(f"symdyn.cli.{self.verb.replace('-', '_')}")
            self.verb, self.description = "", module.__doc__
            module.add_options(self)
            self.set_defaults(run=module.run, parser=self)
        return self

    def parse_known_args(self, *words: Any, **named: Any) -> Any:
        """Parse, knowing all that is taken."""
        self.complete()
        return super().parse_known_args(*words, **named)

    def error(self, message: str) -> NoReturn:
        """Print usage and message, and exit with 2."""
        super().error(printable(message))


def parser() -> argparse.ArgumentParser:
    """Return the parser of all verbs."""
    top = Parser(
        prog="symdyn",
        description="Equations of motion of mechanisms: printed, generated as NumPy and C, and proved.",
        epilog="Start with: symdyn new arm --template rr && symdyn equations arm.toml",
    )
    top.add_argument("--version", action="version", version=f"symdyn {version()}")
    verbs = top.add_subparsers(dest="verb", metavar="VERB", required=True)
    for verb, does in VERBS.items():
        verbs.add_parser(verb, help=does).verb = verb
    return top


def version() -> str:
    """Return the installed version."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        return installed("symdyn")
    except PackageNotFoundError:
        return "(not installed)"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status; warnings of ours are talk."""
    with warnings.catch_warnings():
        warnings.showwarning = partial(_show, warnings.showwarning)
        return run(arguments)


def _show(others: Callable[..., None], message: Warning | str, category: type[Warning], *where: Any) -> None:
    """Print a warning of ours as talk, any other as Python does."""
    if issubclass(category, SymdynWarning):
        print(f"symdyn: {printable(str(message))}", file=sys.stderr)
    else:
        others(message, category, *where)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    prepare_streams()
    try:
        options = parser().parse_args(arguments)
        status: int = options.run(options)
        sys.stdout.flush()
    except SymdynError as fault:
        print(f"symdyn: {fault}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("symdyn: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader, such as head, has seen enough
        silence_stdout()
        return 0
    except OSError as fault:  # a full disk under stdout, for one
        print(f"symdyn: {printable(fault.strerror or str(fault))}", file=sys.stderr)
        return 1
    return status
