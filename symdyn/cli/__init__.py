"""The command line: one file a verb. Results on stdout, talk on stderr; exit status 0, 1 (our errors) or 2 (usage)."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NoReturn

from symdyn.cli import (
    bench,
    check_derivation,
    convert,
    draw,
    equations,
    generate,
    info,
    inverse,
    new,
    simulate,
    stress,
    verify,
    walkthrough,
)
from symdyn.cli.streams import prepare_streams, silence_stdout
from symdyn.errors import SymdynError, SymdynWarning, printable

VERBS = (
    equations,
    walkthrough,
    check_derivation,
    generate,
    verify,
    simulate,
    inverse,
    bench,
    stress,
    info,
    draw,
    convert,
    new,
)


class Parser(argparse.ArgumentParser):
    """A parser whose messages are printable, whatever an argument holds.

    Where what it takes stands in a table that is slow to import, `add_options` adds it once the verb is chosen.
    """

    def __init__(
        self, *words: Any, add_options: Callable[[argparse.ArgumentParser], None] | None = None, **named: Any
    ) -> None:
        super().__init__(*words, **named)
        self._add_options = add_options

    def complete(self) -> Parser:
        """Return this parser with all that it takes."""
        if self._add_options is not None:
            self._add_options(self)
            self._add_options = None
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
    for verb in VERBS:
        verb.register(verbs)
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
