"""Whether this process is the shell's own: nobody else's program runs in it, so libraries need not serve one."""

from __future__ import annotations

_OWN = [False]


def take() -> None:
    """Say that the process runs one command line and nothing else."""
    _OWN[0] = True


def is_own() -> bool:
    """Tell whether that was said."""
    return _OWN[0]
