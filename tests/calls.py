"""How much work something is, told without a clock: machines differ, and others are at work on them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class Calls:
    """How many functions of Python were called."""

    number = 0

    def hear(self, frame: FrameType, event: str, argument: object) -> None:
        """Count one, for `sys.setprofile`."""
        self.number += event == "call"


@contextmanager
def counted() -> Iterator[Calls]:
    """Yield the calls of what is done inside."""
    found, before = Calls(), sys.getprofile()
    sys.setprofile(found.hear)
    try:
        yield found
    finally:
        sys.setprofile(before)
