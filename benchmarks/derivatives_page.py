"""The part of docs/performance.md about derivatives: what was wanted, and a table an output."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bars import paired

from symdyn.table import Table

Found = Mapping[str, Any]

BEGIN = "<!-- What follows, up to the next mark, is written by `python benchmarks/derivatives.py --docs docs`. -->"
END = "<!-- Here it ends. -->"

TITLES = {
    "inverse_dynamics_derivatives": "Derivatives of inverse dynamics: ∂τ/∂q, ∂τ/∂q̇ and M",
    "forward_dynamics_derivatives": "Derivatives of forward dynamics: ∂q̈/∂q, ∂q̈/∂q̇ and M⁻¹",
    "forward_dynamics_unprojected_derivatives": "The same where four feet are held to the ground",
}

ID, FD, HELD = TITLES
PIN, JACOBIAN, ANALYTICAL = "Pinocchio C++", "CasADi C", "CasADi C, analytical"

WAYS = {"state": "C, one state a call", "batch": "batch", "threads": "batch, two threads"}


@dataclass(frozen=True)
class Bar:
    """How many times as fast as a peer our code is to be.

    Attributes:
        robot, output, way, peer: what is compared; the peer computes one state a call.
        wanted: what was hoped for.
        floor: what must hold; None where nothing must.
    """

    robot: str
    output: str
    way: str
    peer: str
    wanted: float
    floor: float | None = None


BARS = (
    Bar("arm7", ID, "state", PIN, 9, 8),
    Bar("puma560", ID, "state", PIN, 12, 11),
    Bar("anymal", ID, "state", PIN, 11, 10),
    Bar("talos", ID, "state", PIN, 4.5, 4),
    Bar("chain16", ID, "state", PIN, 3.5, 3.3),
    Bar("tree32", ID, "state", PIN, 3.3, 3.3),
    Bar("arm7", ID, "batch", PIN, 30, 28),
    Bar("puma560", ID, "batch", PIN, 37),
    Bar("arm7", ID, "state", JACOBIAN, 6, 5.5),
    Bar("puma560", ID, "state", JACOBIAN, 4.8),
    Bar("arm7", ID, "state", ANALYTICAL, 4, 4),
    Bar("arm7", FD, "state", PIN, 5.5, 5),
    Bar("puma560", FD, "state", PIN, 10, 9),
    Bar("anymal", FD, "state", PIN, 11, 10),
    Bar("talos", FD, "state", PIN, 3.3, 3.3),
    Bar("chain16", FD, "state", PIN, 2.2, 1.9),
    Bar("tree32", FD, "state", PIN, 3.7, 3.5),
    Bar("quadruped", FD, "state", PIN, 4.5, 4),
    Bar("quadruped_held", HELD, "state", PIN, 4, 3),
    Bar("arm7", FD, "batch", PIN, 28, 27),
    Bar("puma560", FD, "batch", PIN, 40),
    Bar("arm7", FD, "state", JACOBIAN, 4.5, 4.2),
    Bar("puma560", FD, "state", JACOBIAN, 5.5),
    Bar("arm7", FD, "state", ANALYTICAL, 2.2),
)


def markdown(found: Found) -> str:
    """Return the part."""
    parts = [_machine(found), _bars(found)]
    parts += [f"### {title}\n\n{_table(found, output)}" for output, title in TITLES.items() if _rows(found, output)]
    if found["notes"]:
        parts.append("Left out:\n\n" + "\n".join(f"- {note}" for note in found["notes"]))
    return "\n\n".join(parts) + "\n"


def placed(page: str, text: str) -> str:
    """Return a page with the part between its marks replaced.

    Raises:
        ValueError: the page has no such marks.
    """
    if BEGIN not in page or END not in page:
        raise ValueError(f"the page has no place for derivatives; it needs the lines\n{BEGIN}\n{END}")
    head, rest = page.split(BEGIN)
    return f"{head}{BEGIN}\n\n{text}\n{END}{rest.split(END)[1]}"


def _machine(found: Found) -> str:
    about = {**found["machine"], **found["peers"]}
    lines = [f"- {key}: {about[key]}" for key in about if key not in ("vector units", "system")]
    return f"`{found['command']}`, {found['rounds']} interleaved rounds.\n\n" + "\n".join(lines)


def _bars(found: Found) -> str:
    rows = [_bar(bar, found) for bar in BARS]
    measured = [row for row in rows if row]
    missing = len(rows) - len(measured)
    text = Table(("", "times", "must be", "wanted", "measured", ""), measured, (2, 3, 4)).markdown(str)
    if missing:
        text += f"\n\n{missing} of {len(rows)} comparisons were not made: their peer or their robot is left out."
    return text


def _bar(bar: Bar, found: Found) -> tuple[str, ...]:
    at = {(row["robot"], row["output"], row["way"], row["peer"]): row for row in found["times"]}
    slow = at.get((bar.robot, bar.output, "state", bar.peer))
    fast = at.get((bar.robot, bar.output, bar.way, "symdyn"))
    if not slow or not fast:
        return ()
    ratio = paired(slow, fast)
    held = bar.floor is None or ratio >= bar.floor
    verdict = "reached" if ratio >= bar.wanted else "as it must be" if held and bar.floor else "**missed**"
    name = bar.output.removesuffix("_dynamics_derivatives")
    floor = "" if bar.floor is None else f"{bar.floor:g}"
    way = ", batch" if bar.way == "batch" else ""
    return f"{name}, {bar.robot}{way}", bar.peer, floor, f"{bar.wanted:g}", f"{ratio:.2f}", verdict


def _rows(found: Found, output: str) -> list[Found]:
    return [row for row in found["times"] if row["output"] == output]


def _table(found: Found, output: str) -> str:
    """Return a column a robot: operations, times with ratios to our scalar C, errors."""
    rows = _rows(found, output)
    robots = list(dict.fromkeys(row["robot"] for row in rows))
    kinds = list(dict.fromkeys((row["peer"], row["way"]) for row in rows))
    kinds.sort(key=lambda kind: list(WAYS).index(kind[1]))
    cells = {(row["peer"], row["way"], row["robot"]): row for row in rows}
    ours = {robot: cells["symdyn", "state", robot] for robot in robots if ("symdyn", "state", robot) in cells}
    counted = [f"{ours[r]['operations']}, {ours[r]['formulation']}" if r in ours else "" for r in robots]
    lines = [("*operations of ours, formulation*", *counted)]
    for peer, way in kinds:
        here = [(cells.get((peer, way, robot)), ours.get(robot)) for robot in robots]
        lines.append((f"{peer}: {WAYS[way]}, ns a state (times ours)", *(_time(*pair) for pair in here)))
    for peer, way in kinds:
        if way == "state" or peer == "symdyn":
            shown = [_error(cells.get((peer, way, robot))) for robot in robots]
            lines.append((f"{peer}: {WAYS[way]}, error 99 %", *shown))
    shares = [f"{ours[r]['share']:.2f}" if r in ours else "" for r in robots]
    lines.append(("*ours: largest error over its running bound*", *shares))
    return Table(("", *robots), lines, range(1, 1 + len(robots))).markdown(str)


def _time(row: Found | None, ours: Found | None) -> str:
    if row is None:
        return ""
    time = f"{row['median']:,.0f}"
    return time if ours is None or row is ours else f"{time} ({paired(row, ours):.2f})"


def _error(row: Found | None) -> str:
    return "" if row is None else f"{row['relative']:.0e}"
