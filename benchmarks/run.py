"""Side by side: our generated code and what users would pick instead, on the same robots, states and machine.

    python benchmarks/run.py [--quick] [--robots arm7,chain8] [--outputs mass_matrix] [--peers ours_c,casadi_c]
                             [--flags=-mno-avx512f] [--docs docs] [-o build/bench/results]

Peers that are not installed are skipped with a note (pip install symdyn[bench] brings them all). Every result is
compared with ours before it is timed; they must agree to 1e-10. What peers have compiled is kept in build/bench.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from importlib import import_module
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(Path(__file__).resolve().parent), str(ROOT)]

import machine  # noqa: E402
import report  # noqa: E402
from cases import OUTPUTS, Case, cases  # noqa: E402
from harness import CLOSE, Timed, measure  # noqa: E402
from native import FOLDER, MORE, MissingError  # noqa: E402
from peers import PEERS  # noqa: E402

from symdyn.errors import SymdynError  # noqa: E402

QUICK = ("two_link", "arm7", "chain8")

LARGEST_MATRIX = 32
"""Joints up to which M is timed: it has n² entries, and the code for 64 joints 32,000 operations."""


def main(arguments: list[str] | None = None) -> int:
    """Measure, and write results.json, results.md and the plots."""
    options = parser().parse_args(arguments)
    MORE.extend(options.flags.split())
    start, known = time.monotonic(), cases()
    robots = options.robots.split(",") if options.robots else list(QUICK if options.quick else known)
    unknown = [name for name in robots if name not in known]
    if unknown:
        print(f"benchmarks: there is no robot {', '.join(unknown)}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    notes: dict[str, None] = {}
    peers = installed(options.peers.split(","), notes)
    rounds, seconds = (5, 0.002) if options.quick else (9, 0.004)
    opening, measured = machine.load(), []
    for name in robots:
        for output in options.outputs.split(","):
            if output == "mass_matrix" and known[name].n > LARGEST_MATRIX:
                continue
            say(f"{name} {output}", start)
            timed = ready(known[name], output, peers, notes)
            measured += measure(timed, rounds, seconds)
    generated = []
    if options.generation:
        import generation

        say("generation", start)
        generated = generation.measure_all(options.quick)
    about = machine.describe(opening, [(peer.NAME, peer.version()) for peer in peers])
    said = " --quick" * options.quick + (f" --flags={options.flags}" if options.flags else "")
    about |= {"rounds": rounds, "command": f"python benchmarks/run.py{said}"}
    found = report.collect(about, known, measured, generated, list(notes))
    write(found, Path(options.output), Path(options.docs) if options.docs else None)
    say("done", start)
    return 0


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.add_argument("--quick", action="store_true", help="three robots and fewer rounds")
    found.add_argument("--robots", help="names, comma-separated; all by default")
    found.add_argument("--outputs", default=",".join(OUTPUTS), help="names, comma-separated; all by default")
    found.add_argument("--peers", default=",".join(PEERS), help="names, comma-separated; all by default")
    found.add_argument("--no-generation", dest="generation", action="store_false", help="leave generation times out")
    found.add_argument("--flags", default="", help="more for the compilers, ours and the peers': --flags=-mno-avx512f")
    found.add_argument("--docs", help="folder whose performance.md gets the results, and the plots")
    found.add_argument("-o", "--output", default=str(FOLDER / "results"), help="folder for results")
    return found


def say(words: str, start: float) -> None:
    """Say on stderr what is measured now."""
    print(f"{time.monotonic() - start:6.1f} s  {words}", file=sys.stderr, flush=True)


def installed(names: list[str], notes: dict[str, None]) -> list[ModuleType]:
    """Return the peers that are there; what is not goes to the notes."""
    found = []
    for name in names:
        peer = import_module(f"peers.{name}")
        try:
            peer.version()
            found.append(peer)
        except (ImportError, MissingError) as fault:
            notes[f"{peer.NAME}: skipped everywhere: {fault}"] = None
    return found


def ready(case: Case, output: str, peers: list[ModuleType], notes: dict[str, None]) -> list[Timed]:
    """Return what can be timed, checked against the reference; what cannot goes to the notes.

    Raises:
        AssertionError: a peer computes something else.
    """
    found: list[Timed] = []
    for peer in peers:
        try:
            found += peer.timed(case, output)
        except (ImportError, OSError, MissingError, SymdynError) as fault:
            notes[f"{peer.NAME}: no {output} of {case.name}: {fault}"] = None
    for one in found:
        difference = case.difference(output, one.result())
        assert difference <= CLOSE, f"{one.peer}, {one.way}: {output} of {case.name} differs by {difference:.1e}"
    return found


def write(found: dict[str, object], folder: Path, docs: Path | None) -> None:
    """Write JSON, Markdown and plots, and put the latter two into the documentation if asked."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "results.json").write_text(json.dumps(found, indent=1) + "\n", "utf-8")
    text = report.markdown(found)
    (folder / "results.md").write_text(text, "utf-8")
    try:
        import plots
    except ImportError as fault:
        print(f"benchmarks: no plots: {fault}; pip install symdyn[bench]", file=sys.stderr)
        return
    for place in [folder, *([docs / "performance"] if docs else [])]:
        place.mkdir(parents=True, exist_ok=True)
        plots.draw(found, place)
    if docs:
        page = docs / "performance.md"
        head = page.read_text("utf-8").split(report.MARK)[0]
        page.write_text(f"{head}{report.MARK}\n\n{text}", "utf-8")
    print(folder / "results.md")


if __name__ == "__main__":
    sys.exit(main())
