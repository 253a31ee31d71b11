"""Peers of benchmarks/gpu.py, over the same states of the same arm: GRiD's generated kernels, and MJX on JAX.

A peer is a program that prints what it computes at known states, and then seconds. What it computes is held against the
equations; a peer that computes something else, or is not here, is left out in words.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from bars import Bar
from cases import Case
from native import HERE, MissingError

from symdyn.table import Table

TIMED, ID, FD = "arm7", "inverse_dynamics", "forward_dynamics"

BATCHES = (16, 64, 256, 1024, 4096, 16384, 65536, 262144, 1000000)
"""How many states a call has."""

FROM = 1024
"""The batch from which on we shall be ahead."""

CLOSE = {"double": 1e-10, "float": 1e-4}
"""How far a result may be from the equations, relative to the largest entry of a state, forces for accelerations."""

TIME = re.compile(r"\w+ \d+ [\d.e+-]+")
"""A line that tells how long a call takes."""

NO_CARD = 3
"""How a program of CUDA ends where there is no card."""


@dataclass(frozen=True)
class Said:
    """What a program printed.

    Attributes:
        card: on what it ran.
        results: every result at the known states, with the name of its function.
        seconds: of a call, by function and how many states it had.
    """

    card: str = ""
    results: Sequence[tuple[str, np.ndarray]] = ()
    seconds: Mapping[tuple[str, int], float] = field(default_factory=dict)

    def checked(self, case: Case, real: str) -> Said:
        """Return it where every result is right; MissingError tells which is not."""
        for name, found in self.results:
            gap = case.difference(name, found.reshape(len(case.states["q"]), -1))
            if not gap <= CLOSE[real]:
                raise MissingError(f"{name} in {real} is off by {gap:.1e}, and {CLOSE[real]:.0e} is allowed")
        return self


def read(text: str, prefix: str = "") -> Said:
    """Return what a program printed: "card NAME", "result NAME NUMBERS", "NAME STATES SECONDS", and words of others."""
    card, results, seconds = "", [], {}
    for line in text.splitlines():
        word, _, rest = line.partition(" ")
        if word == "card":
            card = rest
        elif word == "result":
            name, *numbers = rest.split()
            results.append((name.removeprefix(prefix), np.array(numbers, float)))
        elif TIME.fullmatch(line):
            states, taken = rest.split()
            seconds[word.removeprefix(prefix), int(states)] = float(taken)
    return Said(card, tuple(results), seconds)


def given(case: Case, folder: Path) -> None:
    """Write the known states for a program of CUDA."""
    np.concatenate([case.states[name].ravel() for name in ("q", "qd", "qdd", "tau")]).tofile(folder / "given.bin")


def ran(command: Sequence[str], folder: Path, prefix: str = "") -> Said:
    """Return what a program says; MissingError where it fails, or finds no card."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode == NO_CARD:
        raise MissingError(f"CUDA finds no card ({done.stderr})")
    if done.returncode:
        raise MissingError(f"it failed: {' '.join(done.stderr.split())[-300:]}")
    return read(done.stdout, prefix)


def grid(case: Case, real: str, nvcc: str, arch: str, check: bool) -> Said:
    """Return what GRiD's kernels take; with `check` they are compiled and not run."""
    installed("grid-rbd")
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "robot.urdf").write_text(case.urdf, "utf-8")
        given(case, folder)
        options = ["--algorithm-list", f"{ID},{FD},aba", "--no-mujoco-kernels", "-o", "grid.cuh"]
        ran_quietly([sys.executable, "-m", "grid_codegen.cli", "robot.urdf", *options], folder, "its generator")
        flags = ["-O3", "-std=c++17", f"-arch={arch}", f"-DREAL={real}", "-I.", f"-I{HERE}"]
        ran_quietly([nvcc, *flags, str(HERE / "gpu_grid.cu"), "-o", "times"], folder, "nvcc")
        return Said(f"compiled for {arch}, not run") if check else ran(["./times"], folder)


def mjx(case: Case, real: str, nvcc: str, arch: str, check: bool) -> Said:
    """Return what MJX takes; with `check` its results alone, wherever JAX computes them."""
    installed("mujoco-mjx")
    command = [sys.executable, str(HERE / "gpu_mjx.py"), real]
    said = ran([*command, "--check"], HERE).checked(case, real)
    if check:
        return said
    if "(gpu)" not in said.card and "(cuda)" not in said.card:
        raise MissingError(f"JAX has no card and computes on {said.card}")
    return ran(command, HERE)


PEERS: Mapping[str, Callable[[Case, str, str, str, bool], Said]] = {"GRiD": grid, "MJX": mjx}


def installed(package: str) -> str:
    """Return the version of a package; MissingError where there is none."""
    try:
        return version(package)
    except PackageNotFoundError as fault:
        raise MissingError(f"it is not installed (pip install {package})") from fault


def ran_quietly(command: Sequence[str], folder: Path, who: str) -> None:
    """Run what has nothing to say; MissingError where it refuses."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise MissingError(f"{who} refused: {' '.join((done.stderr or done.stdout).split())[-300:]}")


def compared(case: Case, real: str, ours: Said, nvcc: str, arch: str) -> str:
    """Return a table of all peers that are here, and bars, as Markdown; the others are left out in words."""
    found, lines, bars = {"symdyn": ours}, [], []
    for name, peer in PEERS.items():
        try:
            found[name] = peer(case, real, nvcc, arch, False).checked(case, real)
        except MissingError as fault:
            lines.append(f"{name} is left out: {fault}.")
    if len(found) == 1:
        return "\n".join([*lines, ""])
    launch = ", ".join(
        f"{name} {one.seconds['nothing', 1] * 1e6:.1f} µs"
        for name, one in found.items()
        if ("nothing", 1) in one.seconds
    )
    rows = []
    for output in (ID, FD):
        for n in BATCHES:
            times = [one.seconds.get((output, n)) for one in found.values()]
            rows.append((output, f"{n:,}", *("" if t is None else f"{t * 1e6:,.2f}" for t in times)))
        for name in list(found)[1:]:
            ratios = [found[name].seconds[output, n] / ours.seconds[output, n] for n in BATCHES if n >= FROM]
            text = f"{output} in {real}, {name}'s time over ours, the least from {FROM:,} states on"
            bars.append(Bar(text, "≥ 1", f"{min(ratios):.2f}", min(ratios) >= 1))
    table = Table((f"{real}, µs a call", "states", *found), rows, range(1, 2 + len(found)))
    lines += [f"A call that does nothing: {launch}.", "", table.markdown(str)]
    return "\n".join([*lines, "", *(f"- {bar.text}: {bar.wanted}, {bar.shown}, {bar.verdict}" for bar in bars), ""])


def checked(case: Case, real: str, nvcc: str, arch: str) -> list[str]:
    """Return what can be said of each peer where there is no card, a line each."""
    lines = []
    for name, peer in PEERS.items():
        try:
            said = peer(case, real, nvcc, arch, True).checked(case, real)
        except MissingError as fault:
            lines.append(f"{name} in {real} is left out: {fault}.")
            continue
        gaps = [f"{word} within {case.difference(word, x.reshape(-1, case.n)):.0e}" for word, x in said.results]
        lines.append(f"{name} in {real}: {', '.join([said.card, *gaps])}.")
    return lines
