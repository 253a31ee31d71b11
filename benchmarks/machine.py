"""What a measurement has to say about the machine it was made on."""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Sequence
from pathlib import Path

VECTORS = ("avx512f", "avx2", "fma", "avx", "sse4_2")


def describe(before: str, peers: Sequence[tuple[str, str]]) -> dict[str, object]:
    """Return machine, compiler and versions; `before` is the load before measuring."""
    return {
        "machine": {
            "processor": _field("model name") or platform.machine(),
            "vector units": ", ".join(flag for flag in VECTORS if flag in _field("flags").split()) or "unknown",
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
