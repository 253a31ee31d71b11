"""Generated files as a value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

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
