"""Bytes that are kept in the cache between processes, and read only if they are what was put there.

Entries are sealed as libraries are, in the same folder: whose they are, who may change them and their hash are looked
at before anything is made of them.
"""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from symdyn.errors import MissingCompiler
from symdyn.runtime.entry import Damaged, read_entry, seal
from symdyn.runtime.folder import folder_aside, trusted_folder
from symdyn.runtime.warned import warn


@dataclass(frozen=True)
class Kept:
    """What is kept in the cache under a name."""

    name: str

    def content(self) -> bytes | None:
        """Return what is kept, None where nothing is that can be trusted."""
        try:
            path = trusted_folder() / self.name
            found = read_entry(path)
            with suppress(OSError):  # a cache that may only be read serves as well
                os.utime(path)  # it was wanted last
        except Damaged as fault:
            warn(f"{path}: {fault}; it is made again")
        except (OSError, MissingCompiler):
            return None
        else:
            return found
        return None

    def keep(self, content: bytes, most: int) -> None:
        """Keep bytes, where the cache can be written to.

        Of entries with its ending those `most` stay that were wanted last.
        """
        with suppress(OSError, MissingCompiler):
            folder = trusted_folder()
            with folder_aside(folder) as aside:
                fresh = aside / self.name
                fresh.write_bytes(content)
                seal(fresh)
                os.replace(fresh, folder / self.name)
            for one in sorted(folder.glob(f"*{Path(self.name).suffix}"), key=_wanted)[:-most]:
                with suppress(OSError):
                    one.unlink()

    def folder(self) -> Path:
        """Return a folder of this name in the cache, made if missing; OSError or MissingCompiler if it cannot be."""
        folder = trusted_folder() / self.name
        folder.mkdir(mode=0o700, exist_ok=True)
        return folder


def _wanted(path: Path) -> float:
    """Return when an entry was wanted last; one that another process takes away was wanted first."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
