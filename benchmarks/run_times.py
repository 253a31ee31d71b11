"""What a motion takes once it runs, beside that of another checkout: `python benchmarks/run_times.py OTHER`.

Processes of both take turns. Each simulates a motion twice, of which the first derives and compiles, and a very short
one; printed is the median processor time of the second less that of the short one, so of the steps alone.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from checkouts import HERE, summary, turns

CASES = (  # scene, method, s, where it starts if not as declared
    ("cart_pole", "radau", 4.0, "theta=0.5"),
    ("double_pendulum", "taylor", 2000.0, "q1=1"),
    ("four_bar", "dop853", 20.0, ""),
    ("four_bar", "ida", 10.0, ""),
    ("rolling_disc", "dop853", 20.0, ""),
)

RUN = """
import sys, time
import symdyn
scene = symdyn.read(sys.argv[1])
start = dict(word.split("=") for word in sys.argv[4].split()) or None
def took(until):
    begun = time.process_time()
    symdyn.simulate(scene, until=until, every=until, method=sys.argv[2], start=start)
    return time.process_time() - begun
until = float(sys.argv[3])
took(until), took(1e-6)
print(min(took(until) for _ in range(3)) - min(took(1e-6) for _ in range(3)))
"""


def main() -> None:
    """Print a row a case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", type=Path, help="a checkout to compare with")
    parser.add_argument("--runs", type=int, default=5)
    given = parser.parse_args()
    print(f"{'scene':18}{'method':10}{'here, ms':>12}{'there, ms':>12}{'ratio':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for name, method, until, start in CASES:
            words = [str(HERE / "examples" / f"{name}.toml"), method, str(until), start]
            here, there, ratio = summary(turns(RUN, words, given.other, given.runs, folder))
            print(f"{name:18}{method:10}{1e3 * here:12.1f}{1e3 * there:12.1f}{ratio:8.3f}", flush=True)


if __name__ == "__main__":
    main()
