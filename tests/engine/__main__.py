"""`python -m engine SEED ..` (in tests/): trials by their numbers, the scene and what differs; `--until N`: the first.

Exit status 1 where something differs.
"""

from __future__ import annotations

import argparse
import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: small matrices wait for threads on a busy machine

from engine.trials.compare import report


def main() -> int:
    """Run trials."""
    parser = argparse.ArgumentParser(prog="python -m engine", description=__doc__)
    parser.add_argument("seeds", nargs="*", type=int)
    parser.add_argument("--until", type=int, help="all trials below this one, up to the first that differs")
    given = parser.parse_args()
    for seed in [*given.seeds, *range(given.until or 0)]:
        text = report(seed)
        if text:
            print(text)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
