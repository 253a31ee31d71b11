"""Time to have equations of motion in SymPy, M, C, c, g and all else, and what is refused in its place.

    python benchmarks/sympy_equations.py

Imports are not counted. A mechanism that would take minutes is refused within seconds, with what works instead.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import sympy  # noqa: F401  not counted

import symdyn
from symdyn.errors import DerivationError
from symdyn.scene import Scene, Starter, read_text, with_symbolic_inertia


def cases() -> Iterator[tuple[str, Scene]]:
    """Yield scenes by name."""
    for name in ("two_link", "four_bar", "puma560", "arm7", "bicycle"):
        yield name, symdyn.example(name)
    yield "puma560, ten symbols a link", with_symbolic_inertia(symdyn.example("puma560"))
    for n in (10, 14, 16, 60):
        yield f"chain of {n}", read_text(Starter("chain").from_template("chain", n), "chain.toml")


def main() -> None:
    """Print the table."""
    print("| mechanism | seconds | operations in M and c |\n|---|---|---|")
    for name, scene in cases():
        start = time.process_time()
        try:
            found = symdyn.equations(scene).sympy()
        except DerivationError:
            print(f"| {name} | {time.process_time() - start:.1f} | refused |")
            continue
        seconds = time.process_time() - start
        print(f"| {name} | {seconds:.1f} | {sum(int(entry.count_ops()) for entry in (*found.M, *found.c))} |")


if __name__ == "__main__":
    main()
