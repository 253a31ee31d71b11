"""The net under the house: a hash of every file that can be generated from the examples, and from two scenes that hold
what they lack: friction and dampers that act, springs at joints and at one that follows another, a part of a row.

    python tests/net.py                            prints the list that stands in tests/data/net.txt
    python tests/net.py two_link rssr              that of these examples
    python tests/net.py --compare two_link rssr    prints what differs from the list, and ends with 1 if anything does
    python tests/net.py --compare --programs       looks at each program once, as NumPy: half a minute

A line is example, formulation ("-": as preferred), outputs, way and target, then each file with the beginning of its
SHA-256; or "refused" and that of what is said. `make slow` compares; a change that is meant is listed where it is made.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from difflib import unified_diff
from hashlib import sha256
from pathlib import Path

from symdyn import read
from symdyn.dynamics import available
from symdyn.emit import TARGETS, emit
from symdyn.errors import SymdynError
from symdyn.program import Program, formulate, lower, prepare

ROOT = Path(__file__).resolve().parent.parent
NET = ROOT / "tests" / "data" / "net.txt"
EXTRA = ("sled", "struts")
SCENES = {path.stem: path for path in sorted((ROOT / "examples").glob("*.toml"))}
SCENES |= {name: ROOT / "tests" / "data" / f"{name}.toml" for name in EXTRA}
FIRST = ("numpy", "c", "ufunc", "js")
FORMULATIONS = ("-", "rnea", "crba", "aba", "lagrange")
REACTIONS = ("reactions", "forward_reactions")
DIGITS = 12
SHOWN = 6


def lines(example: str, programs_alone: bool = False) -> Iterator[str]:
    """Yield the lines of an example, of its programs alone those that `of_programs` takes."""
    scene = read(SCENES[example])
    for formulation in FORMULATIONS:
        for outputs, names in (("all", available(scene)[0]), ("reactions", REACTIONS)):
            try:
                equations = formulate(scene, names, None if formulation == "-" else formulation)
                plain = lower(equations)
            except SymdynError as refusal:
                yield f"{example} {formulation} {outputs} refused:{_hash(str(refusal))}"
                continue
            if programs_alone:
                yield f"{example} {formulation} {outputs} plain numpy {_named(emit(plain, 'numpy'))}"
                continue
            programs = {"plain": plain, "static": lower(equations.at_rest()), "prepare": prepare(plain)}
            for way, target, found in _files(programs, formulation == "-" and outputs == "all"):
                yield f"{example} {formulation} {outputs} {way} {target} {found}"


def _files(programs: Mapping[str, Program], every: bool) -> Iterator[tuple[str, str, str]]:
    """Yield way, target, and files of a mechanism's programs; of `every` target of functions, or of a few."""
    ways = [(way, program, "double", "") for way, program in programs.items()]
    ways += [("float", programs["plain"], "float", ""), ("batch", programs["plain"], "double", "batch")]
    for way, program, real, option in ways:
        for target in [name for name, row in TARGETS.items() if row.functions is None] if every else FIRST:
            try:
                files = emit(program, target, real, option=option)
                few = (
                    files
                    if target in FIRST
                    else {f"{len(files)}-files": "".join(f"{one}{files[one]!r}" for one in files)}
                )
                yield way, target, _named(few)
            except SymdynError as refusal:
                yield way, target, f"refused:{_hash(str(refusal))}"


def _named(files: Mapping[str, str]) -> str:
    return " ".join(f"{name}:{_hash(text)}" for name, text in files.items())


def _hash(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:DIGITS]


def known(example: str) -> list[str]:
    """Return the lines of an example that stand in the list."""
    return [line for line in NET.read_text(encoding="utf-8").splitlines() if line.startswith(f"{example} ")]


def of_programs(listed: Sequence[str]) -> list[str]:
    """Return the lines that say each program once, and what is refused."""
    return [line for line in listed if " plain numpy " in line or line.count(" ") == 3]


def main() -> int:
    """Print lines, or what differs from those that are known."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--compare", action="store_true")
    options.add_argument("--programs", action="store_true")
    options.add_argument("examples", nargs="*", default=list(SCENES))
    asked = options.parse_args()
    differ = False
    for example in asked.examples:
        found = list(lines(example, asked.programs))
        if asked.compare:
            before = of_programs(known(example)) if asked.programs else known(example)
            found = [line for line in unified_diff(before, found, lineterm="", n=0) if line[1] not in "-+@"]
            differ |= bool(found)
            found = [*found[:SHOWN], f"{example}: {len(found)} lines differ"] if found else []
        print("\n".join(found), end="\n" if found else "", flush=True)
    return int(differ)


if __name__ == "__main__":
    sys.exit(main())
