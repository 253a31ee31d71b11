"""Mutants: faults planted in symdyn, one at a time; most of them in its newer rooms.

    drawn.txt     400 of them, drawn by cosmic-ray's operators and a written seed from the commit named on top
    draw.py       how they were drawn
    run.py        which tests come by the line of which mutant; plants them and runs these tests
    after.txt     what became of them, and why those that live are no faults

`python -m tests.mutants run` goes on where the record ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
DRAWN = HERE / "drawn.txt"


@dataclass(frozen=True)
class Mutant:
    """One line and what it becomes.

    Attributes:
        number: its place in the list.
        file: of the commit from which it was drawn.
        line: its number there, from 1.
        nth: how many lines above it in the file are the same.
        operator: of cosmic-ray.
        before: the line, without its indentation.
        after: what stands there instead; empty if the line is taken out.
    """

    number: int
    file: str
    line: int
    nth: int
    operator: str
    before: str
    after: str

    def place(self, root: Path) -> tuple[Path, int] | None:
        """Return the file and the index of the line in another tree, or None if no such line is there any more."""
        first = root / self.file
        same_name = sorted((root / "symdyn").rglob(first.name))
        for path in [first, *same_name, *sorted((root / "symdyn").rglob("*.py"))]:
            if path.exists():
                lines = path.read_text(encoding="utf-8").splitlines()
                found = [k for k, text in enumerate(lines) if text.strip() == self.before]
                if found:
                    return path, found[min(self.nth, len(found) - 1)]
        return None


def room(file: str) -> str:
    """Return the package of a file: `verify/written` and `emit/targets` are rooms of their own."""
    _, first, *rest = file.split("/")
    return f"{first}/{rest[0]}" if rest and f"{first}/{rest[0]}" in ("verify/written", "emit/targets") else first


def drawn() -> list[Mutant]:
    """Return the mutants of the list."""
    rows = [text.split("\t") for text in DRAWN.read_text(encoding="utf-8").splitlines() if not text.startswith("#")]
    return [Mutant(int(n), file, int(line), int(nth), *rest) for n, file, line, nth, *rest in rows]
