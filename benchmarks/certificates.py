"""What `symdyn verify` takes, whole commands in processes of their own: `python benchmarks/certificates.py`.

Cold is an empty cache of compiled code, warm is the same command again; Python's own compiled modules are there. The
processor time has that of all compilers and runtimes in it; medians over rounds in which all cases take turns. Texts of
further targets: writing the files of every option and proving what they say, without what runs them, in one process
each; compiled languages asked for by `--targets` are compiled twice, for one state and for many.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from bars import Bar

HERE = Path(__file__).parent.parent
PUMA, FIVE_BAR = HERE / "examples" / "puma560.toml", HERE / "benchmarks" / "data" / "five_bar.toml"

TEXTS = ("numpy", "c", "js", "casadi", "heyoka", "matlab", "cpp", "julia", "rust", "gpu")

ALONE = "numpy"
"""The target that takes least, with which others are compared."""

LIMITS = {("puma560", ""): (3.0, 1.5), ("five_bar", ""): (10.0, None)}
"""Scene and targets, "" for what runs unasked: seconds cold and warm."""

TEXT_LIMIT = 1.0

TEXT = """
import sys, time
import symdyn
from symdyn.dynamics import Equations, Workspace
from symdyn.emit import TARGETS, emit
from symdyn.errors import MissingProgram
from symdyn.program import lower
from symdyn.verify.certificate import taken
from symdyn.verify.building import files_of
from symdyn.verify.written import languages, printed, prove_texts
workspace = Workspace(symdyn.read(sys.argv[1]))
_, functions, *_ = taken(workspace, None, None)
numbers = printed(lower(Equations(workspace.scene, workspace.graph, functions)), "double")
start = time.process_time()
for option in ("", *TARGETS[sys.argv[2]].options):
    try:
        sources = emit(numbers.program, sys.argv[2], option=option)
    except MissingProgram:
        continue
    assert all(one.passed for one in prove_texts(numbers, files_of(sources), languages(sys.argv[2], option)))
print(time.process_time() - start)
"""


@dataclass(frozen=True)
class Took:
    """Seconds of a command: by the clock, and of all processors."""

    wall: float
    processor: float


def run(words: Sequence[str], cache: str) -> Took:
    """Return what a process took."""
    own = os.environ | {"SYMDYN_CACHE_DIR": cache, "PYTHONPATH": str(HERE)}
    own.pop("PYTHONDONTWRITEBYTECODE", None)
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, *words], env=own, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Took(wall, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)


def certificates(cases: Sequence[tuple[Path, str]], rounds: int) -> dict[tuple[str, str], tuple[Took, Took]]:
    """Return what the command took cold and warm, by scene and targets."""
    found: dict[tuple[str, str], list[tuple[Took, Took]]] = {}
    for number in range(rounds + 1):
        for scene, targets in cases:
            words = ["-m", "symdyn", "verify", str(scene), *(["--targets", targets] if targets else [])]
            with tempfile.TemporaryDirectory() as cache:
                pair = run(words, cache), run(words, cache)
            if number:  # the first round compiles Python's modules
                found.setdefault((scene.stem, targets), []).append(pair)
    return {
        case: (middle([cold for cold, _ in pairs]), middle([warm for _, warm in pairs]))
        for case, pairs in found.items()
    }


def middle(times: Sequence[Took]) -> Took:
    """Return the medians."""
    return Took(median(one.wall for one in times), median(one.processor for one in times))


def texts(scene: Path, target: str, rounds: int) -> float:
    """Return the processor time of a target's text with every option, s."""
    words = [sys.executable, "-c", TEXT, str(scene), target]
    own = os.environ | {"PYTHONPATH": str(HERE)}
    return median(float(subprocess.run(words, env=own, check=True, capture_output=True).stdout) for _ in range(rounds))


def main() -> None:
    """Print a row a command, a row a text, and the bars."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument(
        "--targets", nargs="*", default=[], help="also whole commands with these, e.g. c julia rust cpp"
    )
    given = parser.parse_args()
    cases = [(PUMA, ""), (FIVE_BAR, ""), *((PUMA, name) for name in dict.fromkeys((ALONE, *given.targets)))]
    bars = []
    print(f"{'symdyn verify':28}{'cold, s':>10}{'processor':>11}{'warm, s':>10}{'processor':>11}")
    for (scene, targets), both in certificates(cases, given.rounds).items():
        print(f"{f'{scene} {targets}':28}" + "".join(f"{t.wall:10.2f}{t.processor:11.2f}" for t in both))
        for kind, took, limit in zip(("cold", "warm"), both, LIMITS.get((scene, targets), ()), strict=False):
            if limit is not None:
                bars.append(Bar(f"{scene}, {kind}", f"≤ {limit:g} s", f"{took.wall:.2f} s", took.wall <= limit))
    print(f"\n{'text of puma560':28}{'processor, s':>12}")
    for name in TEXTS:
        took = texts(PUMA, name, given.rounds)
        print(f"{name:28}{took:12.2f}", flush=True)
        bars.append(Bar(f"text of {name}, every option", f"≤ {TEXT_LIMIT:g} s", f"{took:.2f} s", took <= TEXT_LIMIT))
    print()
    for bar in bars:
        print(f"{bar.text:36}{bar.wanted:>8}{bar.shown:>10}  {bar.verdict}")


if __name__ == "__main__":
    main()
