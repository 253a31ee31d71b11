"""What a measurement has to say about the machine it was made on."""

from __future__ import annotations

import ctypes
import os
import platform
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from native import HERE, NATIVE, MissingError, compiled

VECTORS = ("avx512f", "avx2", "fma", "avx", "sse4_2")


TURNS = 100_000
"""Of each loop that measures a core: some 0.5 ms."""


@dataclass(frozen=True)
class Multipliers:
    """What a core does with its widest vectors: their bits, products a cycle, cycles a nanosecond."""

    width: int
    products: float
    clock: float

    @property
    def count(self) -> int:
        """How many products of 512 bits begin in a cycle; none where vectors are shorter."""
        return round(self.products) if self.width == 512 else 0

    def __str__(self) -> str:
        return f"{self.products:.1f} of {self.width} bits a cycle at {self.clock:.1f} GHz"


def multipliers() -> Multipliers | None:
    """Return what this core's multipliers do, best of 20 short runs; None without a compiler."""
    try:
        library = ctypes.CDLL(str(compiled(HERE / "multipliers.c", (*NATIVE, "-mprefer-vector-width=512"))))
    except MissingError:
        return None
    for name in ("cycle", "product"):
        getattr(library, name).restype, getattr(library, name).argtypes = ctypes.c_double, [ctypes.c_long]
    cycle, product = (min(time(TURNS) for _ in range(20)) for time in (library.cycle, library.product))
    return Multipliers(library.width(), cycle / product, 1e-9 / cycle)


def describe(before: str, peers: Sequence[tuple[str, str]]) -> dict[str, object]:
    """Return machine, compiler and versions; `before` is the load before measuring."""
    core = multipliers()
    return {
        "multipliers": core.count if core else 0,
        "machine": {
            "processor": _field("model name") or platform.machine(),
            "vector units": ", ".join(flag for flag in VECTORS if flag in _field("flags").split()) or "unknown",
            "products of vectors": str(core or "unknown"),
            "cores": str(os.cpu_count()),
            "system": f"{platform.system()} {platform.release().split('-')[0]}",
            "compiler": _first_line("gcc", "--version"),
            "Python": platform.python_version(),
            "load average before and after": f"{before} and {load()}",
        },
        "peers": dict(peers),
    }


def load() -> str:
    """Return how many processes wanted to run in the last minute, as the system says it."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


def _field(name: str) -> str:
    """Return a field of the first processor."""
    path = Path("/proc/cpuinfo")
    if not path.is_file():
        return ""
    lines = (line.split(":", 1) for line in path.read_text("utf-8").splitlines() if ":" in line)
    return next((value.strip() for key, value in lines if key.strip() == name), "")


def _first_line(*command: str) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.splitlines()[0]
    except (OSError, IndexError):
        return "none"
