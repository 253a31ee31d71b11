"""What a library from the cache costs, beside that of another checkout: `python benchmarks/cached_load.py OTHER`.

Processes of both take turns; each reads a scene, derives its functions, and opens the extension of the ufunc target,
which was compiled before; `cold_load.py` measures `load` itself. Printed are the size of the library and the median
processor time of opening it: hash, copy, load.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from checkouts import HERE, summary, turns

SCENES = ("two_link", "puma560", "quadruped")

OPEN = """
import sys, time
from symdyn.build.compiler import find_compiler
from symdyn.build.extension import build_extension
from symdyn import derive, lower, read
from symdyn.emit import emit
sources = emit(lower(derive(read(sys.argv[1]))), "ufunc")
find_compiler()
start = time.process_time()
path, _ = build_extension(sources)
print(time.process_time() - start, path.stat().st_size)
"""


def main() -> None:
    """Print a row a scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", type=Path, help="a checkout to compare with")
    parser.add_argument("--runs", type=int, default=15)
    given = parser.parse_args()
    print(f"{'scene':12}{'kB':>8}{'here, ms':>12}{'there, ms':>12}{'more, ms':>12}")
    with tempfile.TemporaryDirectory() as folder:
        for name in SCENES:
            pairs = turns(OPEN, [str(HERE / "examples" / f"{name}.toml")], given.other, given.runs, folder)
            here, there, _ = (1e3 * one for one in summary(pairs))
            size = pairs[0][0][1] / 1024
            print(f"{name:12}{size:8.0f}{here:12.2f}{there:12.2f}{here - there:12.2f}", flush=True)


if __name__ == "__main__":
    main()
