"""Generated files as a value, and the one place that puts them on disk: all of a file or nothing of it."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from symdyn.errors import EmitError
from symdyn.program import Program


@dataclass(frozen=True)
class Sources(Mapping[str, str]):
    """Generated text by file name.

    Attributes:
        program: what the text computes.
        target: a key of `TARGETS`.
        real: "double" or "float".
        files: pairs of file name and text, the file to compile or to import first.
    """

    program: Program
    target: str
    real: str
    files: tuple[tuple[str, str], ...]

    def __getitem__(self, name: str) -> str:
        """Return the text of one file."""
        return dict(self.files)[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the file names."""
        return (name for name, _ in self.files)

    def __len__(self) -> int:
        """Return the number of files."""
        return len(self.files)


def write(sources: Mapping[str, str], folder: str | Path) -> tuple[Path, ...]:
    """Write every file into `folder`, which is made if it is missing, and return the paths.

    Each file is written aside and renamed, so a reader sees the old text or the new one and never half of it.

    Raises:
        EmitError: the folder cannot be made or written to.
    """
    place = Path(folder)
    aside: list[tuple[Path, Path]] = []
    try:
        place.mkdir(parents=True, exist_ok=True)
        for name, text in sources.items():
            aside.append((_write_aside(place, text), place / name))
        for temporary, final in aside:
            os.replace(temporary, final)
    except OSError as fault:
        reason = fault.strerror or str(fault)
        message = f"{place}: cannot write {', '.join(sources)} there ({reason}); give a folder that you may write to"
        raise EmitError(message) from fault
    finally:
        for temporary, _ in aside:
            temporary.unlink(missing_ok=True)
    return tuple(final for _, final in aside)


def _write_aside(place: Path, text: str) -> Path:
    """Return a new file in `place` that holds `text`, readable as any other file there."""
    handle, name = tempfile.mkstemp(prefix=".symdyn-", dir=place)
    with open(handle, "w", encoding="utf-8", newline="\n") as stream:
        stream.write(text)
    mask = os.umask(0)
    os.umask(mask)
    os.chmod(name, 0o666 & ~mask)
    return Path(name)
