"""What the page plots: coordinates and velocities over time, by unit, and pairs of both for phase portraits."""

from __future__ import annotations

from typing import Any

from symdyn.draw import Text
from symdyn.emit.print import latex_symbols
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.joints import JOINTS
from symdyn.teach.interactive.controls import UNITS


def plotted(scene: Scene) -> list[dict[str, Any]]:
    """Return plots over time: what they are of, which entries (those of one unit), and the words of their axis."""
    symbols, found = latex_symbols(scene), []
    kinds = (
        ("q", scene.coordinates, SceneUnits(scene).coordinates, 0),
        ("qd", scene.velocities, SceneUnits(scene).velocities, 1),
    )
    for group, names, units, order in kinds:
        for unit in dict.fromkeys(units):
            rows = [k for k, one in enumerate(units) if one == unit]
            text = ", ".join(Text.of_latex(symbols[names[k]]).plain for k in rows)
            printed = scene.shown_unit(UNITS[unit][order])
            found.append({"group": group, "rows": rows, "unit": f"{text}, {printed}" if printed else text})
    return found


def pairs(scene: Scene) -> list[tuple[int, int, str, str]]:
    """Return (coordinate, velocity, words of both axes) where the velocity is the coordinate's rate."""
    symbols, found, first, start = latex_symbols(scene), [], 0, 0
    units = SceneUnits(scene).coordinates
    for joint in scene.moving:
        ball = JOINTS[joint.type].quaternion(joint)
        for k in range(len(joint.coordinates) if ball is None else ball):
            i, j = first + k, start + k
            q, u = (Text.of_latex(symbols[name]).plain for name in (scene.coordinates[i], scene.velocities[j]))
            place, rate = (scene.shown_unit(one) for one in UNITS[units[i]][:2])
            found.append((i, j, ", ".join(filter(None, (q, place))), ", ".join(filter(None, (u, rate)))))
        first, start = first + len(joint.coordinates), start + len(joint.rates)
    return found
