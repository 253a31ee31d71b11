"""A smaller case with the same fault: halves, then quarters, then less of each file and of each word are left out."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from .cases import Case
from .crew import alone

PATIENCE = 40.0
"""Seconds for a find."""


def minimised(case: Case, sign: str, patience: float = PATIENCE) -> Case:
    """Return the smallest case found in time that a worker of its own gives the same sign; else the case itself."""
    end = time.monotonic() + patience

    def same(one: Case) -> bool:
        return time.monotonic() < end and alone(one).sign == sign

    if not same(case):  # it needs what ran before it
        return case
    for k in reversed(range(1, len(case.argv))):
        shorter = replace(case, argv=case.argv[:k] + case.argv[k + 1 :])
        case = shorter if same(shorter) else case
    for name in case.files:
        for cut in (b"\n", b""):
            case = _with_less(case, name, cut, same)
    return case


def _with_less(case: Case, name: str, cut: bytes, same: Callable[[Case], bool]) -> Case:
    def other(content: bytes) -> Case:
        return replace(case, files={**case.files, name: content})

    return other(_less(case.files[name], cut, lambda content: same(other(content))))


def _less(content: bytes, cut: bytes, fits: Callable[[bytes], bool]) -> bytes:
    """Leave out ever smaller pieces, of lines or of bytes, as long as it fits."""
    parts = content.split(cut) if cut else [content[k : k + 1] for k in range(len(content))]
    size = len(parts) // 2
    while size:
        at = 0
        while at < len(parts):
            fewer = parts[:at] + parts[at + size :]
            if fits(cut.join(fewer)):
                parts = fewer
            else:
                at += size
        size //= 2
    return cut.join(parts)
