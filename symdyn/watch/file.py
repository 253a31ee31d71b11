"""A file that somebody edits: whether it says something else than before."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

RACY = 0.1
"""s after a change was seen in which a file may be half written, or be written again under the same time stamp."""

Stamp = tuple[int, int, int]


class EditedFile:
    """A file, followed by its name, so that editors may write it in place or put another in its place."""

    def __init__(self, path: Path, clock: Callable[[], float] = time.monotonic) -> None:
        """Take the file as it is now."""
        self.path, self._clock = path, clock
        self._stamp, self._content, self._seen = self._looked(), self._read(), clock()

    @property
    def there(self) -> bool:
        """Whether there is such a file."""
        return self._stamp is not None

    @property
    def settled(self) -> bool:
        """Whether no change was seen just now; a file system's own clock may go wrong."""
        return self._clock() - self._seen >= RACY

    def changed(self) -> bool:
        """Tell whether it says something else than when this was last asked; it is read only where it may."""
        stamp = self._looked()
        if stamp == self._stamp and self.settled:
            return False
        if stamp != self._stamp:
            self._stamp, self._seen = stamp, self._clock()
        before, self._content = self._content, self._read()
        return self._content != before

    def _looked(self) -> Stamp | None:
        try:
            found = os.stat(self.path)
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size, found.st_ino

    def _read(self) -> bytes | None:
        try:
            with self.path.open("rb") as file:
                return file.read(LARGEST)
        except OSError:
            return None


LARGEST = 2**25
"""Bytes of a file that are compared; no scene is longer."""
