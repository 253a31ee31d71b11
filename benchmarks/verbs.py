"""Every verb as a process, with the code of this checkout and of another: `python benchmarks/verbs.py ../older`.

User and system time of whole commands, s: medians over pairs, and of the ratios within them. What is compiled is in
the cache of either side from a first run on. A verb that another checkout does not have, or asks otherwise, is told.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from pathlib import Path

from checkouts import HERE, summary, turns

PROGRAM = """
import os, subprocess, sys
before = os.times()
ran = subprocess.run([sys.executable, "-m", "symdyn", *sys.argv[1:]], capture_output=True, text=True)
after = os.times()
if ran.returncode and not ran.stdout:  # a homework that is wrong is an answer, too
    sys.exit(ran.stderr.strip().splitlines()[-1][:200])
print(after.children_user - before.children_user + after.children_system - before.children_system)
"""

COMMANDS = {
    "--help": "--help",
    "equations": "equations two_link.toml",
    "walkthrough": "walkthrough two_link.toml -o lesson.html",
    "walkthrough of a loop": "walkthrough four_bar.toml -o lesson.html",
    "check-derivation": "check-derivation homework.tex two_link.toml",
    "generate": "generate puma560.toml --target c -o made",
    "verify": "verify puma560.toml",
    "verify a loop": "verify four_bar.toml",
    "simulate": "simulate double_pendulum.toml --until 10 -o run.csv",
    "simulate a loop": "simulate four_bar.toml --until 2 -o run.csv",
    "sweep": "sweep pendulum.toml --over g=linspace(9.7,9.9,20) --measure max(q1) --until 1 -o runs.csv",
    "inverse": "inverse puma560.toml --motion q1=quintic(0,pi/2,1) --until 1 -o torques.csv",
    "linearize": "linearize cart_pole.toml",
    "identify": "identify two_link.toml --excite --bind m1=1,m2=1,h1=1,h2=1,g=9.81 -o motion.csv",
    "bench": "bench two_link.toml --quick --no-trajectories -o page",
    "info": "info puma560.toml",
    "draw": "draw puma560.toml -o arm.svg",
    "convert": "convert puma560.toml arm.urdf --lossy --force",
    "new": "new arm --template rr --force",
    "completion": "completion bash",
    "doctor": "doctor",
}
"""Words of the command line, files beside which they run: the examples."""


def main() -> None:
    """Print a row a command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", type=Path, help="a checkout of symdyn")
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--only", nargs="+", choices=list(COMMANDS), default=list(COMMANDS))
    given = parser.parse_args()
    print(f"{'':24}{'here':>8}{'there':>8}{'ratio':>8}")
    with tempfile.TemporaryDirectory() as cache:
        for scene in (HERE / "examples").glob("*.toml"):
            (Path(cache) / scene.name).write_bytes(scene.read_bytes())
        (Path(cache) / "homework.tex").write_text("M_1 = q_1", encoding="utf-8")
        for name in given.only:
            try:
                pairs = turns(PROGRAM, COMMANDS[name].split(), given.other.resolve(), given.pairs, cache)
            except subprocess.CalledProcessError:
                print(f"{name:24}  is not there, or asks otherwise")
                continue
            here, there, ratio = summary(pairs)
            print(f"{name:24}{here:8.2f}{there:8.2f}{ratio:8.2f}", flush=True)


if __name__ == "__main__":
    main()
