"""Whether this process is the shell's own: nobody else's program runs in it, so libraries need not serve one.

And how an argument is called where messages speak of it: `--start q1=1` to who runs a verb, `start={"q1": 1}` to who
calls a function in Python.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar

_OWN = [False]

_VERB = ContextVar("_VERB", default=False)

SELDOM = 50_000
"""Objects after which Python looks for cycles among them: unasked 700, of which imports and graphs make very many."""


def take() -> None:
    """Say that the process runs one command line and nothing else."""
    _OWN[0] = True
    gc.set_threshold(SELDOM)


def is_own() -> bool:
    """Tell whether that was said."""
    return _OWN[0]


@contextmanager
def a_verb() -> Iterator[None]:
    """Let messages call arguments as the command line does."""
    before = _VERB.set(True)
    try:
        yield
    finally:
        _VERB.reset(before)


def flag(argument: str) -> str:
    """Return what an argument is called: dt, --dt at the shell."""
    return f"--{argument.replace('_', '-')}" if _VERB.get() else argument


def spoken(argument: str, values: Mapping[str, object] | None = None, between: str = ",") -> str:
    """Return an argument as it is given: True, or values by name, which the shell parts by `between`."""
    if _VERB.get():
        said = between.join(f"{name}={value}" for name, value in (values or {}).items())
        return f"{flag(argument)} {said}".rstrip()
    if values is None:
        return f"{argument}=True"
    return f"{argument}={{{', '.join(f'{_quoted(name)}: {_written(value)}' for name, value in values.items())}}}"


def _quoted(name: str) -> str:
    return f'"{name}"'


def _written(value: object) -> str:
    """Return a number as it is, and a formula as text."""
    try:
        float(str(value))
    except ValueError:
        return _quoted(str(value))
    return str(value)
