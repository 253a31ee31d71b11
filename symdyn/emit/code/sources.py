"""Generated files as a value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from symdyn.emit.code.target import Contents
from symdyn.program import Program


@dataclass(frozen=True)
class Sources(Mapping[str, Contents]):
    """Generated files by name.

    Attributes:
        program: what they compute.
        target: a key of `TARGETS`.
        real: "double" or "float".
        option: which of the target's options was chosen; "" for none.
        functions: what the program's functions are called there, in order.
        files: pairs of file name and contents, the file to compile or to import first.
    """

    program: Program
    target: str
    real: str
    option: str
    functions: tuple[str, ...]
    files: tuple[tuple[str, Contents], ...]

    def __getitem__(self, name: str) -> Contents:
        """Return the contents of one file."""
        return dict(self.files)[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the file names."""
        return (name for name, _ in self.files)

    def __len__(self) -> int:
        """Return the number of files."""
        return len(self.files)

    @property
    def texts(self) -> dict[str, str]:
        """The files that are text."""
        return {name: contents for name, contents in self.files if isinstance(contents, str)}
