"""What the command line says beside its results: tables on stdout, progress on stderr."""

from __future__ import annotations

import json
import re
import sys
import threading
import time
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Self

from symdyn.errors import printable

PATIENCE = 2.0  # seconds after which a user wants to know what is going on
WIDTH = 160  # of tables that are not shown on a terminal
MOST_LEAVES = 8
LONGEST_NUMBER, DIGITS = 8, 6  # digits of a number that is shown as it is, and of one that is rounded

_NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:/\d+)?(?![\w.])")


def say(text: str) -> None:
    """Print talk on stderr, made printable, as it may quote a stranger's file."""
    print(printable(text), file=sys.stderr)


def print_paths(*paths: object) -> None:
    """Print where files were written, one a line, which no name breaks."""
    for path in paths:
        print(printable(str(path), keep=""))


def print_json(value: Any) -> None:
    """Print a result for machines."""
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False)
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    except UnicodeEncodeError:  # JSON has a spelling of its own for what a terminal lacks
        text = json.dumps(value, indent=2, allow_nan=False)
    print(text)


def print_rich(shown: Any) -> None:
    """Print a table or tree of rich's on stdout; a pipe that nobody reads any more ends a verb as it ends `print`."""
    from rich.console import Console

    class Piped(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError  # where rich would exit with 1

    width = None if sys.stdout.isatty() else WIDTH
    Piped(width=width, highlight=False, markup=False, emoji=False).print(shown)


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table on stdout; columns whose name ends in a space are numbers and aligned to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        table.add_column(column.rstrip(), justify="right" if column.endswith(" ") else "left")
    for row in rows:
        table.add_row(*row)
    print_rich(table)


def asking(leaves: Sequence[str]) -> str:
    """Return how poses and Jacobians are asked for, of the bodies that end the branches for example."""
    told = ", ".join(leaves[:MOST_LEAVES]) + (f", ... ({len(leaves)} in all)" if len(leaves) > MOST_LEAVES else "")
    words = f"--functions pose:{leaves[0]},jacobian:{leaves[0]}"
    return f"poses and Jacobians are asked for by name: {words} (branches end with {told})"


def short(text: str) -> str:
    """Return a formula with its numbers rounded to six digits where they are long, and ≈ in front if any was.

    >>> short("2*pi"), short("1/3"), short("-2.0943951023931953"), short("m1 + 0.1234567890123*a2")
    ('2*pi', '1/3', '≈ -2.0944', '≈ m1 + 0.123457*a2')
    """
    rounded = _NUMBER.sub(lambda found: _rounded(found[0]), text)
    return text if rounded == text else f"≈ {rounded}"


def _rounded(number: str) -> str:
    if len(re.sub(r"\D", "", number).strip("0")) <= LONGEST_NUMBER:
        return number
    return f"{float(Fraction(number)):.{DIGITS}g}"


class _Late:
    """What a terminal is shown on stderr once something has taken longer than `PATIENCE`."""

    def __init__(self, stage: str) -> None:
        """Start quiet."""
        self._stage = stage
        self._shown: Any = None

    def __enter__(self) -> Self:
        """Start the clock."""
        return self

    def __exit__(self, *_: object) -> None:
        """Take it away again."""
        if self._shown is not None:
            self._shown.stop()


class Waiting(_Late):
    """Tells what is being done."""

    def __init__(self) -> None:
        """Start quiet."""
        super().__init__("working")
        self._timer = threading.Timer(PATIENCE, self._show)
        self._timer.daemon = True

    def __enter__(self) -> Self:
        """Start the clock, if there is a terminal to talk to."""
        if sys.stderr.isatty():
            self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Take the line away again."""
        self._timer.cancel()
        super().__exit__()

    def __call__(self, stage: str) -> None:
        """Say what comes next."""
        self._stage = stage
        if self._shown is not None:
            self._shown.update(stage)

    def _show(self) -> None:
        from rich.console import Console

        self._shown = Console(stderr=True).status(self._stage)
        self._shown.start()


class Bar(_Late):
    """A progress bar."""

    def __enter__(self) -> Self:
        """Start the clock."""
        self._begin = time.monotonic()
        return self

    def __call__(self, share: float) -> None:
        """Show how much is done, from 0 to 1."""
        if self._shown is None and sys.stderr.isatty() and time.monotonic() - self._begin > PATIENCE:
            self._show()
        if self._shown is not None:
            self._shown.update(self._task, completed=share)

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
        self._shown = Progress(*columns, console=Console(stderr=True), transient=True)
        self._task = self._shown.add_task(self._stage, total=1.0)
        self._shown.start()
