"""What this package says beside its results: warnings of Python, printed as talk, and a refusal."""

from __future__ import annotations

import warnings
from functools import cache

from symdyn.emit import Sources
from symdyn.errors import BuildError, SymdynWarning


def check_target(sources: Sources, *targets: str) -> None:
    """Raise BuildError for sources of another target."""
    if sources.target not in targets:
        way_out = f"give emit(program, {targets[0]!r})"
        raise BuildError(f"sources of target {sources.target!r} are not of target {targets[0]!r}; {way_out}")


@cache
def warn_once(message: str) -> None:
    """Warn, once a process: of what stays as it is."""
    warn(message)


def warn(message: str) -> None:
    """Warn of what happened."""
    warnings.warn(message, SymdynWarning, stacklevel=2)
