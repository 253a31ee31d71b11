"""symdyn: the same C without AVX-512, as a processor without it runs it; one state a call and batches."""

from __future__ import annotations

from pathlib import Path

from cases import Case
from harness import Timed
from native import MissingError

from peers import ours_c

NAME = "symdyn, AVX2"

FLAGS = ("-mno-avx512f", "-mprefer-vector-width=256")

CPUINFO = Path("/proc/cpuinfo")


def version() -> str:
    """Return how the code is compiled.

    Raises:
        MissingError: this processor has no AVX-512, so that all tables are without it.
    """
    if not CPUINFO.is_file() or "avx512f" not in CPUINFO.read_text("utf-8"):
        raise MissingError("all tables are without AVX-512 here")
    return f"this checkout, gcc {' '.join((*ours_c.flags(), *FLAGS))}"


def timed(case: Case, output: str) -> list[Timed]:
    """Return scalar C and batch C of both layouts."""
    return [one for one in ours_c.timed(case, output, NAME, FLAGS) if one.way != "threads"]
