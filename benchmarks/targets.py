"""Our equations in other tools, side by side: what a call costs in each, against our C and our ufuncs.

    python benchmarks/targets.py [--only casadi,rust] [--rounds 15] [--seconds 0.02] [--docs docs]

Inverse dynamics of the seven-axis arm and its derivatives, doubles, on one core. All tools take turns in one run; what
is compared is compared inside a round. Every result is held against the equations before it is timed. Tools that are
not here are left out by name. `--docs` writes the table of docs/performance-of-runs.md.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from statistics import median

import numpy as np

from symdyn.table import Table

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(Path(__file__).resolve().parent), str(ROOT), str(ROOT / "tests")]

import machine  # noqa: E402
from cases import EXAMPLES, Case  # noqa: E402
from harness import CLOSE, Measured, Timed, measure  # noqa: E402
from native import MissingError  # noqa: E402

from symdyn.errors import SymdynError  # noqa: E402
from symdyn.scene import read  # noqa: E402

BEGIN = "<!-- What follows, up to the next mark, is written by `python benchmarks/targets.py --docs docs`. -->"
END = "<!-- Here it ends. -->"

ID, IDD = "inverse_dynamics", "inverse_dynamics_derivatives"

WORDS = {ID: "τ", IDD: "∂τ/∂q, ∂τ/∂q̇, M"}

Kind = tuple[str, str, str]
"""Tool, output, way: "state", one state a call, or "batch"."""

C, UFUNC = ("symdyn", ID, "state"), ("ufunc", ID, "batch")


@dataclass(frozen=True)
class Bar:
    """What was set out to be reached: so many times `against`, or so many nanoseconds a state where that is None."""

    text: str
    kind: Kind
    most: float
    against: Kind | None = None


BARS = (
    Bar("C++ header, one state, times our C", ("cpp", ID, "state"), 1.05, C),
    Bar("Rust, one state, times our C", ("rust", ID, "state"), 1.3, C),
    Bar("our C called by CasADi, times the C that CasADi writes of our SX", ("casadi, our C", ID, "state"), 1.2,
        ("casadi, its C", ID, "state")),
    Bar("our C mapped by CasADi, times the C that CasADi writes of our SX", ("casadi, our C", ID, "batch"), 1.2,
        ("casadi, its C", ID, "batch")),
    Bar("Octave, text, batch", ("octave", ID, "batch"), 5000),
    Bar("Octave, MEX, times the ufunc", ("mex", ID, "batch"), 1.3, UFUNC),
    Bar("JAX, times the ufunc", ("jax", ID, "batch"), 1.3, UFUNC),
    Bar("JAX, derivatives in one call, times the ufunc's", ("jax", IDD, "batch"), 1.3, ("ufunc", IDD, "batch")),
    Bar("JAX, jacfwd", ("jax, jacfwd", IDD, "batch"), 250),
    Bar("PyTorch, times the ufunc", ("torch", ID, "batch"), 1.3, UFUNC),
    Bar("PyTorch, derivatives in one call, times the ufunc's", ("torch", IDD, "batch"), 1.3, ("ufunc", IDD, "batch")),
)  # fmt: skip

ONCE = (("JAX, compile (s)", "jax, jit", 1.0),)
"""What is done once: text, name among a tool's `seconds`, and how many at most."""


def tools(only: Sequence[str]) -> list[str]:
    """Return the files of tools, ours first."""
    names = sorted(path.stem for path in (ROOT / "benchmarks" / "tools").glob("[!_]*.py") if path.stem != "ours")
    unknown = set(only) - set(names)
    if unknown:
        sys.exit(f"there is no tool {', '.join(sorted(unknown))}; there are {', '.join(names)}")
    return ["ours", *(name for name in names if name in only or not only)]


def close(one: Timed, case: Case) -> float:
    """Return the largest error of an implementation, relative to the largest entry.

    Raises:
        MissingError: it is no rounding error.
    """
    wanted = case.references[one.output]
    found = one.result().reshape(wanted.shape)
    error = float(np.abs(found - wanted).max() / np.abs(wanted).max())
    if not error < CLOSE:
        raise MissingError(f"{one.peer}, {WORDS[one.output]}, {one.way}: off by {error:.1e}, which is not timed")
    return error


def ready(names: Sequence[str], case: Case) -> tuple[list[Timed], dict[str, float], dict[str, str], list[str]]:
    """Return what is timed, what is done once, versions by tool, and why others are left out."""
    timed: list[Timed] = []
    once: dict[str, float] = {}
    versions: dict[str, str] = {}
    notes: list[str] = []
    for name in names:
        tool = import_module(f"tools.{name}")
        try:
            found = tool.timed(case)
            for one in found:
                close(one, case)
            once |= tool.seconds(case) if hasattr(tool, "seconds") else {}
            versions[name] = tool.version()
            timed += found
        except (MissingError, ImportError, SymdynError) as fault:
            notes.append(f"{name}: {fault}")
    return timed, once, versions, notes


def bars(found: Mapping[Kind, Measured], once: Mapping[str, float]) -> list[tuple[str, str, str, str]]:
    """Return a row of a table for every bar for which everything was measured."""
    rows = []
    for bar in BARS:
        one = found.get(bar.kind)
        other = found.get(bar.against) if bar.against else None
        if one is None or (bar.against and other is None):
            continue
        value = one.median if other is None else median(a / b for a, b in zip(one.samples, other.samples, strict=True))
        unit = " ns" if other is None else ""
        verdict = "reached" if value <= bar.most else "**missed**"
        shown = (
            f"{value:,.0f}" if other is None and value >= 100 else f"{value:.1f}" if other is None else f"{value:.2f}"
        )
        rows.append((bar.text, f"≤ {bar.most:g}{unit}", f"{shown}{unit}", verdict))
    for text, name, most in ONCE:
        if name in once:
            verdict = "reached" if once[name] <= most else "**missed**"
            rows.append((text, f"≤ {most:g}", f"{once[name]:.2f}", verdict))
    return rows


def markdown(found: Mapping[Kind, Measured], once: Mapping[str, float], told: Sequence[str]) -> str:
    """Return what stands between the marks of the page."""
    rows = []
    for (peer, output, _), one in found.items():
        low, high = one.quartiles
        states = one.timed.states if one.timed.way == "batch" else 1
        shown = f"{_short(one.median)} ({_short(low)}–{_short(high)})"
        rows.append((peer, WORDS[output], f"{states:,}", shown))
    reached = Table(("", "bar", "measured", ""), bars(found, once), (1, 2)).markdown(str)
    times = Table(("ns a state, median (quartiles)", "", "states a call", ""), rows, (2, 3)).markdown(str)
    return "\n".join([reached, "", times, "", *(f"- {line}" for line in told)])


def _short(x: float) -> str:
    return f"{x:.1f}" if x < 100 else f"{x:,.0f}"


def main() -> None:
    """Measure, print, and write the page's table where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="tools, with commas between; ours is always there")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--seconds", type=float, default=0.02, help="of one sample")
    parser.add_argument("--docs", type=Path, help="the folder of performance-of-runs.md")
    options = parser.parse_args()
    before = machine.load()
    case = Case("arm7", read(EXAMPLES / "arm7.toml"))
    timed, once, versions, notes = ready(tools([name for name in options.only.split(",") if name]), case)
    found = {
        (one.timed.peer, one.timed.output, one.timed.way): one
        for one in measure(timed, options.rounds, options.seconds)
    }
    about = machine.describe(before, list(versions.items()))
    facts = [about[group] for group in ("machine", "peers")]
    told = [f"{key}: {value}" for group in facts for key, value in group.items()]  # type: ignore[attr-defined]
    text = markdown(found, once, [*told, *(f"left out: {note}" for note in notes)])
    print(text)
    if options.docs:
        page = options.docs / "performance-of-runs.md"
        head, rest = page.read_text("utf-8").split(BEGIN)
        page.write_text(f"{head}{BEGIN}\n\n{text}\n\n{END}{rest.split(END)[1]}", "utf-8")


if __name__ == "__main__":
    main()
