"""`python -m tests.mutants draw | reach | run | show`: see the package and its files."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from . import DRAWN, HERE, drawn

ROOT = HERE.parent.parent
REACHED = ROOT / "build" / "mutants" / "reach.txt"


def main() -> int:
    """Do what is asked."""
    ask = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    ask.add_argument("what", choices=["draw", "reach", "run", "show"])
    ask.add_argument("--at", default="HEAD", help="the commit whose code and tests are taken (default: HEAD)")
    ask.add_argument("--first", type=int, default=len(drawn()) if DRAWN.exists() else 0, help="how many of the list")
    ask.add_argument("--whole", action="store_true", help="those that no test found that reaches them, against all")
    ask.add_argument("--record", type=Path, default=HERE / "after.txt", help="file of verdicts (default: after.txt)")
    ask.add_argument("words", nargs="*", help="reach: words for pytest")
    given = ask.parse_args()
    if given.what == "show":
        from .run import verdicts

        print(*(f"{count} {verdict}" for verdict, count in Counter(verdicts(given.record).values()).most_common()))
        return 0
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        subprocess.run(["git", "clone", "--quiet", "--no-checkout", str(ROOT), str(tree)], check=True)
        subprocess.run(["git", "-C", str(tree), "checkout", "--quiet", given.at], check=True)
        if given.what == "draw":
            from .draw import draw

            print(*draw(tree), sep="\n")
        elif given.what == "reach":
            from .reach import reach

            reach(tree, drawn(), given.words, REACHED)
        else:
            from .reach import reached
            from .run import record

            record(tree, drawn()[: given.first], reached(REACHED), given.record, given.whole)
    return 0


if __name__ == "__main__":
    sys.exit(main())
