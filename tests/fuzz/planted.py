"""`python -m tests.fuzz.planted`: ten faults planted in a copy of the code, and whether the same run finds each.

Every fault takes away what holds a mistake of today: a check, an escape, a bound, or the one statement that must not be
forgotten. The list says where, what stands there, what takes its place, and how the find begins.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .cases import ROOT


@dataclass(frozen=True)
class Plant:
    """A fault.

    Attributes:
        what: it does.
        file: below `symdyn`.
        old, new: texts; `old` stands there once.
        sign: a pattern of what is found.
    """

    what: str
    file: str
    old: str
    new: str
    sign: str


PLANTS = (
    Plant(
        "a scene that is not UTF-8 ends in a traceback",
        "scene/toml.py",
        "except UnicodeDecodeError as error:",
        "except UnicodeEncodeError as error:",
        r"UnicodeDecodeError: scene/toml\.py",
    ),
    Plant(
        "a value beyond the largest double ends in a traceback",
        "scene/values/quantity.py",
        "except OverflowError:",
        "except NotImplementedError:",
        r"OverflowError: scene/quantity\.py",
    ),
    Plant(
        "a formula that divides by zero ends in a traceback",
        "scene/values/folding.py",
        '        raise FormulaError("it divides by zero; check the denominator")',
        "        raise ZeroDivisionError",
        r"ZeroDivisionError: scene/folding\.py",
    ),
    Plant(
        "a cell of a table of forces that is no number ends in a traceback",
        "simulation/prescribed/formulas_in_time.py",
        "        except ValueError:",
        "        except NotImplementedError:",
        r"ValueError: simulation/formulas_in_time\.py",
    ),
    Plant(
        "the reader of homework does not get past **",
        "teach/student/tokens.py",
        '            self._add(kind, "^" if text == "**" else text, end)',
        '            self._add(kind, "^" if text == "**" else text, end - 2 * (text == "**"))',
        r"over .*teach|over .* GB",
    ),
    Plant(
        "a scene with an unknown convention of Denavit and Hartenberg reads memory that is not there",
        "scene/declaration/declare.py",
        '    faults.nameless(entry.where, "convention", convention)\n',
        '    if not convention and "convention" in entry.table:\n        __import__("ctypes").string_at(0)\n'
        '    faults.nameless(entry.where, "convention", convention)\n',
        r"died of SIGSEGV",
    ),
    Plant(
        "a view that is no two numbers ends without a word",
        "cli/draw.py",
        "        raise DrawError(\n            f'--view",
        "        raise SystemExit(1) or DrawError(\n            f'--view",
        r"fails without a word: 'draw'",
    ),
    Plant(
        "a file that is written leaves another one behind",
        "emit/writing.py",
        "                aside.append(temporary := _aside((place / name).parent))\n",
        "                aside.append(temporary := _aside((place / name).parent))\n                _aside(place)\n",
        r"a file left behind",
    ),
    Plant(
        "a converted scene is written beside its folder",
        "cli/convert.py",
        "    write_file(path, written.text)",
        '    write_file(path if path.suffix != ".urdf" else f"../{path.name}", written.text)',
        r"a file outside its folder",
    ),
    Plant(
        "messages quote a stranger's file as it is written",
        "errors.py",
        "    if text.isprintable():",
        "    if True:",
        r"control character in stderr",
    ),
)


def main() -> int:
    """Plant, run, and print which were found; return how many were not."""
    ask = argparse.ArgumentParser(prog="python -m tests.fuzz.planted", description=__doc__)
    ask.add_argument("--cases", type=int, default=20_000)
    ask.add_argument("--seed", default="1")
    given = ask.parse_args()
    with tempfile.TemporaryDirectory() as place:
        copy = Path(place, "copy")
        for part in ("symdyn", "templates", "tests", "examples", "docs"):
            shutil.copytree(ROOT / part, copy / part, ignore=shutil.ignore_patterns("__pycache__"))
        for plant in PLANTS:
            planted(plant, copy / "symdyn")
        command = [sys.executable, "-m", "tests.fuzz", "--cases", str(given.cases), "--seed", given.seed]
        running = subprocess.Popen([*command, "--keep", place], cwd=copy, stdout=subprocess.PIPE, text=True)
        missed = list(PLANTS)
        try:
            for plant, number in _finds(running, PLANTS):
                missed.remove(plant)
                print(f"case {number:10}{plant.what}", flush=True)
        finally:
            running.kill()
    for plant in missed:
        print(f"{'NOT FOUND':15}{plant.what}")
    print(f"{len(PLANTS) - len(missed)} of {len(PLANTS)} found")
    return len(missed)


def planted(plant: Plant, package: Path) -> None:
    """Plant a fault in a copy of the package."""
    path = package / plant.file
    text = path.read_text(encoding="utf-8")
    assert text.count(plant.old) == 1, f"{plant.file}: {plant.old!r} stands there {text.count(plant.old)} times"
    path.write_text(text.replace(plant.old, plant.new), encoding="utf-8")


def _finds(running: subprocess.Popen[str], plants: tuple[Plant, ...]) -> Iterator[tuple[Plant, str]]:
    """Yield each plant with the case that shows it, until all are found or the run ends."""
    assert running.stdout is not None
    left = list(plants)
    for line in running.stdout:
        case, _, sign = line.removeprefix("case ").partition(": ")
        for plant in [plant for plant in left if line.startswith("case ") and re.match(plant.sign, sign)]:
            left.remove(plant)
            yield plant, case
        if not left or line.startswith("verb "):
            return


if __name__ == "__main__":
    sys.exit(main())
