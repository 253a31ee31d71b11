"""`python -m tests.mutants draw | reach | run | show`: see the package and its files."""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections import Counter
from pathlib import Path

from . import DRAWN, HERE, drawn, room

ROOT = HERE.parent.parent
REACHED = ROOT / "build" / "mutants" / "reach.txt"
TREE = ROOT / "build" / "mutants" / "tree"


def checked_out(commit: str) -> Path:
    """Return a clone with the files of a commit, and with what tests have compiled there before."""
    found = subprocess.run(["git", "-C", str(ROOT), "rev-parse", commit], check=True, capture_output=True, text=True)
    if not TREE.exists():
        subprocess.run(["git", "clone", "--quiet", "--no-checkout", str(ROOT), str(TREE)], check=True)
    subprocess.run(["git", "-C", str(TREE), "fetch", "--quiet"], check=True)
    subprocess.run(["git", "-C", str(TREE), "checkout", "--quiet", "--force", found.stdout.strip()], check=True)
    return TREE


def main() -> int:
    """Do what is asked."""
    ask = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    ask.add_argument("what", choices=["draw", "reach", "run", "show"])
    ask.add_argument("--at", default="HEAD", help="the commit whose code and tests are taken (default: HEAD)")
    ask.add_argument("--first", type=int, default=len(drawn()) if DRAWN.exists() else 0, help="how many of the list")
    ask.add_argument("--again", action="store_true", help="those that live, against the tests that are known by now")
    ask.add_argument("--record", type=Path, default=HERE / "after.txt", help="file of verdicts (default: after.txt)")
    ask.add_argument("words", nargs="*", help="reach: words for pytest")
    given = ask.parse_args()
    if given.what == "show":
        from .run import verdicts

        known = verdicts(given.record)
        found = Counter((room(one.file), known.get(one.number, "left")) for one in drawn())
        print(*(f"{place:20} {verdict:8} {count}" for (place, verdict), count in sorted(found.items())), sep="\n")
        return 0
    tree = checked_out(given.at)
    if given.what == "draw":
        from .draw import draw

        print(*draw(tree), sep="\n")
    elif given.what == "reach":
        from .run import reach

        reach(tree, drawn(), given.words, REACHED)
    else:
        from .run import reached, record

        record(tree, drawn()[: given.first], reached(REACHED), given.record, given.again)
    return 0


if __name__ == "__main__":
    sys.exit(main())
