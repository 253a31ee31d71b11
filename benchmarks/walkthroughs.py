"""How long a walkthrough takes in every format, from scene file to text: `python benchmarks/walkthroughs.py`."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from symdyn.errors import SymdynError
from symdyn.scene import read
from symdyn.teach import rendered, walkthrough
from symdyn.teach.render import FORMATS

ROOT = Path(__file__).parent.parent
SCENES = ("examples/two_link.toml", "examples/cart_pole.toml", "examples/spatial_3r.toml")


def main() -> int:
    """Print seconds to derive, to write each format, and kilobytes of its files."""
    for scene in SCENES:
        start = time.perf_counter()
        document = walkthrough(read(ROOT / scene))
        print(f"{scene:36} derive {time.perf_counter() - start:6.2f} s", end="")
        total = time.perf_counter() - start
        for format in FORMATS:
            start = time.perf_counter()
            try:
                files = rendered(document, format)
            except SymdynError as fault:
                print(f"   {format}: {fault}", end="")
                continue
            spent = time.perf_counter() - start
            total += spent
            size = sum(len(x if isinstance(x, bytes) else x.encode()) for x in files.values()) / 1000
            print(f"   {format} {spent:5.2f} s {size:5.0f} kB", end="")
        print(f"   in all {total:5.2f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
