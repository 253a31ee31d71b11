"""What this room says beside its results: warnings of Python, which the command line prints as talk."""

from __future__ import annotations

import warnings
from functools import cache

from symdyn.errors import SymdynWarning


@cache
def warn_once(message: str) -> None:
    """Warn, once a process: of what stays as it is."""
    warn(message)


def warn(message: str) -> None:
    """Warn of what happened."""
    warnings.warn(message, SymdynWarning, stacklevel=2)
