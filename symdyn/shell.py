"""Whether this process is the shell's own: no other program runs in it, so libraries need not serve one."""

from __future__ import annotations

import gc

_OWN = [False]

SELDOM = 200_000
"""Objects after which Python looks for cycles among them: unasked 700, of which imports and graphs make very many."""


def take() -> None:
    """Say that the process runs one command line and nothing else."""
    _OWN[0] = True
    gc.set_threshold(SELDOM)


def is_own() -> bool:
    """Tell whether that was said."""
    return _OWN[0]
