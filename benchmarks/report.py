"""From measurements to a value that is written as JSON, and from that to Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from bars import bars
from cases import Case
from generation import SYMPY, Generated
from harness import Measured

from symdyn.table import Table

MARK = "<!-- What follows is written by `make bench`. -->"

WAYS = {
    "state": "C, one state a call",
    "batch": "batch",
    "threads": "batch, two threads",
    "million": "a million states",
    "hundred": "from Python, 100 states",
    "python": "from Python, one state",
}

TITLES = {
    "inverse_dynamics": "Inverse dynamics",
    "mass_matrix": "Mass matrix",
    "forward_dynamics": "Forward dynamics",
    "gravity_forces": "Gravity",
}

Found = Mapping[str, Any]


def collect(
    about: Found,
    known: Mapping[str, Case],
    measured: Sequence[Measured],
    generated: Sequence[Generated],
    notes: list[str],
) -> dict[str, Any]:
    """Return everything as plain values."""
    rows = []
    for one in measured:
        timed = one.timed
        counts = known[timed.case].programs[timed.output].routines[0].counts
        low, high = one.quartiles
        rows.append(
            {
                "robot": timed.case,
                "joints": known[timed.case].n,
                "output": timed.output,
                "peer": timed.peer,
                "way": timed.way,
                "states": timed.states,
                "operations": counts.multiplications + counts.additions + counts.divisions,
                "sincos": counts.sincos,
                "median": one.median,
                "quartiles": [low, high],
                "samples": list(one.samples),
            }
        )
    return {**about, "notes": notes, "times": rows, "generation": [asdict(one) for one in generated]}


def markdown(found: Found) -> str:
    """Return the report."""
    parts = [_machine(found), _bars(found)]
    for output, title in TITLES.items():
        table = _times(found, output)
        if table:
            parts.append(f"## {title}\n\n{table}")
    if found["generation"]:
        parts.append(_generation(found["generation"]))
    if found["notes"]:
        parts.append("## Left out\n\n" + "\n".join(f"- {note}" for note in _merged(found["notes"])))
    return "\n\n".join(parts) + "\n"


def _machine(found: Found) -> str:
    lines = [f"- {key}: {value}" for key, value in found["machine"].items()]
    lines += [f"- {key}: {value}" for key, value in found["peers"].items()]
    text = f"`{found['command']}`, {found['rounds']} interleaved rounds."
    return "## Machine\n\n" + text + "\n\n" + "\n".join(lines)


def _bars(found: Found) -> str:
    told = bars(found["times"], multipliers=found["multipliers"])
    rows = [(b.text, b.wanted, b.shown, b.verdict) for b in told]
    if not rows:
        return "## Bars\n\nNone of the robots that the bars are about was measured."
    heads = ("seven-axis arm, unless another robot is named", "bar", "measured", "")
    return "## Bars\n\n" + Table(heads, rows).markdown(str)


def _times(found: Found, output: str) -> str:
    """Return the table of one output: medians, with quartiles, ns a state."""
    rows = [row for row in found["times"] if row["output"] == output]
    robots = list(dict.fromkeys(row["robot"] for row in rows))
    kinds = sorted({(row["peer"], row["way"]) for row in rows}, key=lambda kind: (list(WAYS).index(kind[1]), kind[0]))
    if not rows:
        return ""
    cells = {(row["peer"], row["way"], row["robot"]): row for row in rows}
    operations = {row["robot"]: f"{row['operations']} + {row['sincos']} sincos" for row in rows}
    lines = [("*operations of ours*", *(operations[robot] for robot in robots))]
    lines += [
        (f"{peer}: {WAYS[way]}", *(_cell(cells.get((peer, way, robot))) for robot in robots)) for peer, way in kinds
    ]
    return Table(("ns a state", *robots), lines, range(1, 1 + len(robots))).markdown(str)


def _cell(row: Found | None) -> str:
    if row is None:
        return ""
    low, high = row["quartiles"]
    return f"{_short(row['median'])} ({_short(low)}–{_short(high)})"


def _short(x: float) -> str:
    return f"{x:.1f}" if x < 100 else f"{x:,.0f}"


def _generation(rows: Sequence[Found]) -> str:
    lines = []
    for row in rows:
        what = SYMPY.get(row["what"], f"symdyn, {row['what']}")
        shown = row["words"] if row["seconds"] is None else f"{row['seconds']:.3f}"
        lines.append((what, row["robot"], shown))
    return "## Generation\n\n" + Table(("", "robot", "s"), lines, (2,)).markdown(str)


def _merged(notes: Sequence[str]) -> list[str]:
    """Return the notes with one line for each peer and reason."""
    merged: dict[tuple[str, str], list[str]] = {}
    for note in notes:
        peer, what, reason = (*note.split(": ", 2), "")[:3]
        merged.setdefault((peer, reason), []).append(what.removeprefix("no "))
    return [f"{peer}: {reason} ({', '.join(what)})" for (peer, reason), what in merged.items()]
