"""All examples by every formulation that is printed: operations and length of the page, time to derive it, or why not.

    python benchmarks/formulations.py                   prints the tables
    python benchmarks/formulations.py --docs docs       writes docs/formulations.md

A page that takes longer than `LIMIT` seconds of CPU is given up.
"""

from __future__ import annotations

import argparse
import re
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from string import ascii_lowercase

from symdyn.emit.print import FormulationPage, printed_text
from symdyn.emit.print.formulations_page import PAGES
from symdyn.errors import SymdynError
from symdyn.resources import example_files
from symdyn.scene import Scene, read
from symdyn.table import Table

ROOT = Path(__file__).parent.parent

LIMIT = 30
"""Seconds of CPU."""

FORMULATIONS = ("lagrange", *(name for name in PAGES if name != "contact"))  # no example has contacts that open

HEAD = """# Formulations, counted

Made by `python benchmarks/formulations.py --docs docs`; `tests/test_formulations.py` holds some of the numbers.

Every example by every formulation of `symdyn equations --formulation`: what its page takes to be worked out
(multiplications, additions and divisions, what is shared once), how many characters it has without spaces, and how many
milliseconds of CPU it took to derive and write. Lagrange's page holds the equations of motion alone; Hamilton's
momenta, H, and rates solved for; Kane's velocities and partial velocities of every body, so that its length tells how
much is written down on the way, not how long the equations are. A letter: there is no such page; why, stands below.

Of small trees Lagrange's equations are the shortest on paper. Hamilton's take up to three times the operations where q̇
is solved for, and fewer than Lagrange's where it stays in M q̇ = p, as of a PUMA 560: slopes of the energy are shorter
than Coriolis terms. Routh's page is no longer than Hamilton's, and has fewer equations to integrate. Appell's is mostly
half as long as Kane's, which needs no energy and no derivative of one. Of loops Udwadia and Kalaba's is mostly the
shorter page, for its M, Q, A and b are not put together.

[`symdyn walkthrough --formulation`](lessons.md) explains each page, with these counts of its own scene, and proves it
equal to Lagrange's equations.
"""


BOOKS = """
## Held against books

| what is published | test |
| --- | --- |
| spherical pendulum: H, R with its amended potential, transformation to cyclic coordinates (Goldstein, 3.3, 8.1, 10.3) | `test_canonical.py`, `test_formulations.py` |
| heavy symmetric top: H, R, two constant momenta (Goldstein, 5.7) | `test_canonical.py`, `test_formulations.py` |
| Kepler's problem as a linkage: the canonical equations (Goldstein, 8.2) | `test_canonical.py` |
| Kane and Levinson, Dynamics (1985): exercises 10.1, 10.2, 11.8, 11.10 | `test_kane.py`, `test_formulations.py` |
| Udwadia and Kalaba: a particle on a rod (1992), with ẏ = z² ẋ (1996); least forces of a four-bar | `test_formulations.py` |
| Spong's acrobot (1995): partial feedback linearisation, collocated and not, with zero dynamics | `test_linearizing.py` |
| Furuta's pendulum (Cazzolato and Prime, 2011): zero dynamics of both kinds | `test_linearizing.py` |
| inertia wheel pendulum (Ortega and others, 2002), Takegaki and Arimoto (1981), Åström and Furuta (2000): shaping, damping, V' | `test_shaping.py` |
"""  # noqa: E501


@dataclass(frozen=True)
class Page:
    """What a page costs: operations, characters, milliseconds; or why there is none."""

    operations: int = 0
    characters: int = 0
    milliseconds: float = 0.0
    fault: str = ""


def measured(scene: Scene, formulation: str) -> Page:
    """Return what a page costs."""
    signal.signal(signal.SIGVTALRM, _late)
    signal.setitimer(signal.ITIMER_VIRTUAL, LIMIT)
    try:
        begun = time.process_time()
        text = printed_text(scene, "text", formulation=formulation)
        taken = 1000 * (time.process_time() - begun)
        return Page(FormulationPage(scene, formulation).operations, len("".join(text.split())), taken)
    except TimeoutError:
        return Page(fault=f"it takes longer than {LIMIT} s")
    except SymdynError as fault:
        return Page(fault=" ".join(str(fault).removeprefix(f"{scene.name}: ").split()))
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)  # or it ends what this process does next


def _late(*_: object) -> None:
    raise TimeoutError


def in_time(scene: Scene, formulation: str) -> Page:
    """Return the same, in a process of its own, whose CPU time is bounded."""
    with get_context("fork").Pool(1) as pool:
        return pool.apply(measured, (scene, formulation))


def examples() -> Iterator[Scene]:
    """Yield the scenes that come with the package, by their names."""
    for _, path in sorted(example_files().items()):
        if path.suffix in (".toml", ".urdf"):
            yield read(path)


def reason(fault: str) -> str:
    """Return a message without what it calls the scene's own, so that one reason of many scenes is one line."""
    fault = re.sub(r"^(Hamilton|Routh|Kane|Appell)'s equations are written", "they are written", fault)
    fault = re.sub(r"\bjoint \w+ turns", "a joint turns", fault)
    return re.sub(r"^[a-z-]+: ", "", fault)


def page(found: dict[str, dict[str, Page]]) -> str:
    """Return the page of the documentation."""
    reasons = list(dict.fromkeys(reason(cell.fault) for one in found.values() for cell in one.values() if cell.fault))

    def shown(cell: Page) -> str:
        if cell.fault:
            return f"({ascii_lowercase[reasons.index(reason(cell.fault))]})"
        return f"{cell.operations} / {cell.characters} / {float(f'{cell.milliseconds:.2g}'):g}"

    rows = [[name, *(shown(one[formulation]) for formulation in FORMULATIONS)] for name, one in found.items()]
    table = Table(("example", *FORMULATIONS), rows)
    why = [f"- ({letter}) {text}" for letter, text in zip(ascii_lowercase, reasons, strict=False)]
    parts = (
        HEAD,
        "## Operations / characters / milliseconds\n",
        table.markdown(),
        "\n## Where there is none\n",
        *why,
        BOOKS,
    )
    return "\n".join(parts).rstrip() + "\n"


def main() -> int:
    """Measure all, and print or write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--docs", type=Path, help="the folder of the page")
    options = parser.parse_args()
    found: dict[str, dict[str, Page]] = {}
    for scene in examples():
        found[scene.name] = {}
        for formulation in FORMULATIONS:
            found[scene.name][formulation] = in_time(scene, formulation)
            print(scene.name, formulation, found[scene.name][formulation], file=sys.stderr)
    text = page(found)
    if options.docs is None:
        print(text)
    else:
        (options.docs / "formulations.md").write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
