"""What the command line says: results on stdout, as text or as one JSON object, talk and progress on stderr.

Standard streams as they come: closed, of a terminal that knows few letters, cut off.

A closed stream (`>&-`) becomes the null device, so that nothing that is opened later takes its number and no message is
printed into a file. What the encoding of a stream lacks is written as its nearest letters, never as a traceback.
"""

from __future__ import annotations

import codecs
import json
import os
import re
import sys
import time
import unicodedata
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, Self

from symdyn.errors import SceneError, printable
from symdyn.rounding import digits_or, finite

if TYPE_CHECKING:  # help imports nothing that it does not need
    from symdyn.table import Table

PREFIX = "symdyn: "
PATIENCE = 2.0  # seconds after which a user wants to know what is going on
WIDTH = 160  # of tables that are not shown on a terminal
MOST_LEAVES = 8
LONGEST_NUMBER, DIGITS = 8, 6  # digits of a number that is shown as it is, and of one that is rounded

_NUMBER = r"(?<![\w.])\d+(?:\.\d+)?(?:/\d+)?(?![\w.])"


class Answer:
    """What one command answers, gathered while it runs.

    Attributes:
        quiet: whether nothing but errors goes to stderr.
        json: whether stdout gets one JSON object in the end, and nothing before.
        result: what was found: a JSON value.
        files: what was written.
        notes: what was said on the way, one line each, every line once.
        errors: why nothing was found, or not all.
        places: where in the scene's file each error is; empty where none has a place there.
    """

    def __init__(self, quiet: bool = False, json: bool = False) -> None:
        self.quiet, self.json = quiet, json
        self.result: Any = None
        self.files, self.notes, self.errors = list[str](), list[str](), list[str]()
        self.places = list[dict[str, int]]()

    def as_dict(self, verb: str, scene: str | None, status: int) -> dict[str, Any]:
        """Return the object that `--json` prints, the same of every verb (docs/shell.md)."""
        told = {"verb": verb, "scene": scene, "status": status, "result": finite(self.result)}
        return told | {"files": self.files, "notes": self.notes, "errors": self.errors, "places": self.places}


_ANSWER: ContextVar[Answer] = ContextVar("answer")


def begin(quiet: bool = False, json: bool = False) -> Answer:
    """Return the answer of a command that begins, in which all that it says from now on is gathered."""
    answer = Answer(quiet, json)
    _ANSWER.set(answer)
    return answer


def _answer() -> Answer:
    found = _ANSWER.get(None)
    return begin() if found is None else found


def say(text: str) -> None:
    """Say something beside the result on stderr, one line, once; it is made printable, as it may quote a stranger."""
    answer = _answer()
    line = printable(" ".join(text.removeprefix(PREFIX).splitlines()), keep="")
    if line in answer.notes:
        return
    answer.notes.append(line)
    if not answer.quiet:
        print(f"{PREFIX}{line}", file=sys.stderr)


def fail(text: object) -> None:
    """Say on stderr why a command fails, however quiet it is to be."""
    words = printable(str(text))
    _answer().errors += words.splitlines()
    _answer().places += [place._asdict() for place in text.places] if isinstance(text, SceneError) else []
    print(f"{PREFIX}{words}", file=sys.stderr)


def print_paths(*paths: object) -> None:
    """Print where files were written, one a line, which no name breaks."""
    lines = [printable(str(path), keep="") for path in paths]
    answer = _answer()
    answer.files += lines
    if not answer.json:
        print(*lines, sep="\n", end="\n" * bool(lines))


def wrote(*paths: object) -> None:
    """Say where files were written beside the result that is printed."""
    answer = _answer()
    for path in paths:
        line = printable(str(path), keep="")
        answer.files.append(line)
        if not answer.quiet:
            print(f"{PREFIX}wrote {line}", file=sys.stderr)


def print_text(text: str, end: str = "\n") -> None:
    """Print a result that is text."""
    answer = _answer()
    if answer.json:
        answer.result = text
    else:
        print(text, end=end)


def give(value: Any) -> None:
    """Keep a result for machines: a JSON value, which `--json` prints in the end."""
    _answer().result = value


def answer(value: Any, show: Callable[[], None]) -> None:
    """Keep a result for machines, or show it where nobody asked for JSON."""
    if _answer().json:
        give(value)
    else:
        show()


def print_json(value: Any) -> None:
    """Print JSON."""
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False)
    if not text.replace("\n", "").isprintable():  # a name of a stranger's
        text = "".join(x if x.isprintable() or x == "\n" else json.dumps(x)[1:-1] for x in text)
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


def print_table(table: Table[Any]) -> None:
    """Print a table on stdout; on a terminal, and where it is too wide for a page, rich breaks its lines."""
    rule = "─" if (sys.stdout.encoding or "").lower().startswith("utf") else "-"
    text = table.text(rule)
    if not sys.stdout.isatty() and len(text.partition("\n")[0]) <= WIDTH:
        print(text)
        return
    from rich.box import SIMPLE_HEAD
    from rich.table import Table as Broken

    shown = Broken(title=table.title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    for k, column in enumerate(table.columns):
        shown.add_column(column, justify="right" if k in table.numbers else "left")
    for row in table.rows:
        shown.add_row(*row)
    print_rich(shown)


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
    rounded = re.sub(_NUMBER, lambda found: _rounded(found[0]), text)
    return text if rounded == text else f"≈ {rounded}"


def _rounded(number: str) -> str:
    digits = digits_or(DIGITS)
    longest = LONGEST_NUMBER if digits == DIGITS else digits
    if len(re.sub(r"\D", "", number).strip("0")) <= longest:
        return number
    from fractions import Fraction

    return f"{float(Fraction(number)):.{digits}g}"


def _shows_progress() -> bool:
    return sys.stderr.isatty() and not _answer().quiet


class _Late:
    """What a terminal is shown on stderr once something has taken longer than `PATIENCE`."""

    def __init__(self, stage: str) -> None:
        self._stage = stage
        self._shown: Any = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._shown is not None:
            self._shown.stop()


class Waiting(_Late):
    """Tells what is being done."""

    def __init__(self, stage: str = "working") -> None:
        super().__init__(stage)
        self._timer: Any = None

    def __enter__(self) -> Self:
        if _shows_progress():
            from threading import Timer

            self._timer = Timer(PATIENCE, self._show)
            self._timer.daemon = True
            self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._timer is not None:
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
        self._begin = time.monotonic()
        return self

    def __call__(self, share: float) -> None:
        """Show how much is done, from 0 to 1."""
        if self._shown is None and _shows_progress() and time.monotonic() - self._begin > PATIENCE:
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


READABLE = {
    "·": "*", "×": "x", "−": "-", "–": "-", "—": "-", "…": "...", "≈": "~", "≤": "<=", "≥": ">=", "→": "->", "←": "<-",
    "⇒": "=>", "°": " deg", "∞": "oo", "∂": "d", "∫": "int", "Σ": "sum", "√": "sqrt", "„": '"', "“": '"', "”": '"',
    "‘": "'", "’": "'", "′": "'", "″": "''", "⋅": "*", "±": "+-", "≠": "!=", "≡": "=", "½": "1/2", "⅓": "1/3",
    "─": "-", "━": "-", "│": "|", "└": "`", "├": "|", "✓": "+", "✗": "x", "\xa0": " ",
}  # fmt: skip
"""Characters of our own texts, and what a terminal without them shows."""

LACKING = "symdyn.nearest"
"""Name of the handler of characters that an encoding lacks."""


def prepare_streams() -> None:
    """Put the null device where a standard stream is closed, and let no character end a command."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, _null_device(number, mode))
    codecs.register_error(LACKING, _nearest)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a test's or a notebook's stream may have no encoding to fail at
            stream.reconfigure(errors=LACKING)


def silence_stdout() -> None:
    """Put the null device where nobody reads results any more."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _null_device(number: int, mode: str) -> Any:
    """Return the null device as a stream, under the number of the standard stream that it stands for."""
    opened = os.open(os.devnull, os.O_RDONLY if mode == "r" else os.O_WRONLY)
    if opened != number:
        os.dup2(opened, number)
        os.close(opened)
    return open(number, mode, encoding="utf-8", closefd=False)


def _nearest(error: UnicodeError) -> tuple[str, int]:
    """Return the nearest ASCII letters for what an encoding lacks, and where to go on; "?" if there are none."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    wanted = error.object[error.start : error.end]
    return "".join(_ascii(character) for character in wanted), error.end


def _ascii(character: str) -> str:
    if character in READABLE:
        return READABLE[character]
    if unicodedata.combining(character):
        return ""
    bare = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode("ascii")
    if bare:
        return bare
    name = unicodedata.name(character, "").split()
    return name[-1].lower() if name[:2] in (["GREEK", "SMALL"], ["GREEK", "CAPITAL"]) and len(name) == 4 else "?"
