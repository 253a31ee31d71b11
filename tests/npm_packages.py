"""Packages of npm that tests look at pages and files with, installed once into build/npm by these versions.

A test that needs them is skipped where npm is missing or reaches no registry.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest
from patience import HANG
from programs import path_of

ROOT = Path(__file__).parent.parent
PACKAGES = {
    "axe-core": "4.10.3",
    "gltf-validator": "2.0.0-dev.3.10",
    "mathlive": "0.111.1",
    "puppeteer-core": "24.43.1",
    "three": "0.187.0",
}


def packages() -> Path:
    """Return the folder of the packages, which are installed if they are missing."""
    import fcntl  # not on Windows, where nobody has asked for them yet

    place = ROOT / "build" / "npm"
    there = place / "node_modules"
    place.parent.mkdir(exist_ok=True)
    with open(place.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # several workers may come here at once
        _installed(place)
    return there


def _installed(place: Path) -> None:
    """Install the packages where they are missing; the test is skipped where that cannot be."""
    versions = {name: place / "node_modules" / name / "package.json" for name in PACKAGES}
    if all(path.is_file() and json.loads(path.read_text())["version"] == PACKAGES[name]
           for name, path in versions.items()):  # fmt: skip
        return
    npm = path_of("npm")
    if npm is None:
        pytest.skip("there is no npm; apt-get install npm")
    with tempfile.TemporaryDirectory(dir=place.parent) as aside:
        words = [npm, "install", "--prefix", aside, "--no-audit", "--no-fund", "--no-save", "--ignore-scripts"]
        words += [f"{name}@{version}" for name, version in PACKAGES.items()]
        done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=HANG)
        if done.returncode:
            pytest.skip(f"npm installs no {', '.join(PACKAGES)}: {done.stderr.strip().splitlines()[-1:]}")
        shutil.rmtree(place, ignore_errors=True)
        Path(aside).rename(place)
        Path(aside).mkdir()
