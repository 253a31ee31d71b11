"""What a compiler adds to sources before they become files: binaries, where a target's files hold such."""

from __future__ import annotations

from collections.abc import Callable

from symdyn.emit import Sources
from symdyn.errors import BuildError
from symdyn.runtime.mockup_binary import with_binaries

COMPLETED: dict[str, tuple[Callable[[Sources], Sources], str]] = {
    "fmu": (with_binaries, "sources, and a binary for this platform"),
}
"""By target: what adds to its sources, and what they hold then."""


def complete(sources: Sources) -> tuple[Sources, str]:
    """Return sources with what a compiler adds, as they are where it cannot; and what is to be said, "" for nothing."""
    if sources.target not in COMPLETED:
        return sources, ""
    add, held = COMPLETED[sources.target]
    names = ", ".join(sources)
    try:
        return add(sources), f"{names}: {held}"
    except BuildError as fault:
        return sources, f"{names}: sources alone; {fault}"
