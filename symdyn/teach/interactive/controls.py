"""Sliders: what of the state and the parameters can be moved by hand, from where, in which range, and what follows.

A quaternion is moved by roll, pitch and yaw: R = Rz(yaw) Ry(pitch) Rx(roll). In a mechanism with loops coordinates that
follow have a number only.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from symdyn.draw import Text
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.emit import in_html
from symdyn.emit.print import latex_symbols
from symdyn.errors import SymdynError
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Joint, Parameter, acceleration_name
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.dalembert.shown_motion import choose_motion
from symdyn.teach.interactive.reduced import Held
from symdyn.teach.mathml import inline
from symdyn.teach.shown_state import shown_state, starting_rates, undriven

RATES = {"rad": (8.0, 20.0), "m": (3.0, 10.0)}  # largest velocity and acceleration of a slider
UNITS = {
    "rad": ("rad", "rad/s", "rad/s^2", "N\u202fm"),
    "m": ("m", "m/s", "m/s^2", "N"),
    "1": ("", "1/s", "1/s^2", ""),
}
TURNS = (("roll", math.pi), ("pitch", math.pi / 2), ("yaw", math.pi))

Row = dict[str, Any]


def controls(
    scene: Scene, begun: Start, extent: float, tied: Held | None, led: Sequence[int] = ()
) -> list[dict[str, Any]]:
    """Return groups of rows: time where motions are prescribed, positions, velocities, accelerations and parameters.

    A row is a slider (label, unit, range, value), a number that follows (without a range), or a heading of rows. Slides
    go as far as the extent, m; `led` are velocities with a prescribed motion.
    """
    symbols, values, t = latex_symbols(scene), begun.parameters, begun.t
    groups: list[dict[str, Any]] = []
    if led:
        fastest = max(abs(begun.qd[k]) for k in led)
        last = max(t, min(60.0, max(2.0, 4 * math.pi / fastest)) if fastest else 10.0)
        groups.append({"key": "t", "rows": [_row("t", 0, "t", "t", scene.shown_unit("s"), (0.0, last), t)]})
    groups.append({"key": "q", "rows": _positions(scene, symbols, begun, extent, tied, led)})
    accelerations = [acceleration_name(v) for v in scene.velocities]
    for k, key, names, at in ((1, "qd", scene.velocities, begun.qd), (2, "qdd", accelerations, begun.qdd)):
        rows = []
        for i, (name, unit) in enumerate(zip(names, SceneUnits(scene).velocities, strict=True)):
            largest = max(RATES[unit][k - 1], 1.5 * abs(at[i]))
            free = i not in led and (tied is None or i in tied.velocities)
            span = (-largest, largest) if free else None
            rows.append(_row(key, i, name, symbols[name], scene.shown_unit(UNITS[unit][k]), span, at[i], led=i in led))
        groups.append({"key": key, "rows": rows})
    if scene.parameters:
        told = SceneUnits(scene).inferred
        rows = [
            _row("params", k, p.name, symbols[p.name], told[p.name], _range(p, values[p.name]), values[p.name], p.text)
            for k, p in enumerate(scene.parameters)
        ]
        groups.append({"key": "params", "rows": rows})
    return groups


def _positions(
    scene: Scene, symbols: Mapping[str, str], begun: Start, extent: float, tied: Held | None, led: Sequence[int]
) -> list[Row]:
    rows: list[Row] = []
    first, turned, units = 0, 0, SceneUnits(scene).coordinates
    wide = {"rad": math.pi, "m": extent, "1": 1.0}
    for joint in scene.moving:
        ball = JOINTS[joint.type].quaternion(joint)
        prescribed = joint.rates[0] in [scene.velocities[k] for k in led]
        for k, name in enumerate(joint.coordinates):
            unit = units[first + k]
            at, free = begun.q[first + k], not prescribed and (tied is None or first + k in tied.moved)
            if ball is not None and k >= ball and free:
                break
            span = _span(joint, wide[unit], at, begun.parameters) if free else None
            shown = scene.shown_unit(UNITS[unit][0])
            rows.append(_row("q", first + k, name, symbols[name], shown, span, at, led=prescribed))
        if ball is not None and (tied is None or first + ball in tied.moved):
            rows.append({"heading": in_html(joint.name)})
            angles = roll_pitch_yaw(begun.q[first + ball : first + ball + 4])
            for k, ((word, size), angle) in enumerate(zip(TURNS, angles, strict=True)):
                one = _row("turn", turned + k, word, "", scene.shown_unit("rad"), (-size, size), angle)
                rows.append({**one, "word": word, "joint": in_html(joint.name)})
            turned += 3
        first += len(joint.coordinates)
    return rows


def roll_pitch_yaw(e: list[float]) -> tuple[float, float, float]:
    """Return the angles of a unit quaternion (w, x, y, z), rad."""
    w, x, y, z = e
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    return roll, pitch, math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _row(
    group: str,
    k: int,
    name: str,
    latex: str,
    unit: str,
    span: tuple[float, float] | None,
    value: float,
    text: str = "",
    led: bool = False,
) -> Row:
    plain = Text.of_latex(latex).plain if latex else name
    row: Row = {
        "group": group,
        "k": k,
        "label": inline(latex) if latex else "",
        "spoken": in_html(f"{plain}, {text}" if text else plain),
        "text": in_html(text),
        "unit": re.sub(r"\^(\d)", r"<sup>\1</sup>", in_html(unit)),
        "value": value,
        "why": "led" if led else "follows",  # what stands in place of a slider
    }
    return row if span is None else {**row, "low": span[0], "high": span[1]}


def _span(joint: Joint, wide: float, at: float, values: Mapping[str, float]) -> tuple[float, float]:
    """Return the range of a coordinate: the joint's limits where it has them, else `wide` each way."""
    low, high = joint.range(values)
    return min(low if math.isfinite(low) else -wide, at), max(high if math.isfinite(high) else wide, at)


def _range(parameter: Parameter, value: float) -> tuple[float, float]:
    """Return the range of a parameter's slider: a tenth to three times its value where it must be positive."""
    if value == 0.0:
        return (0.1, 1.0) if parameter.positive else (-1.0, 1.0)
    return (value / 10, 3 * value) if parameter.positive else (-3 * abs(value), 3 * abs(value))


@dataclass(frozen=True)
class Start:
    """A state: q, shape (nq,), qd and qdd, shape (nv,), values of all parameters, and the time, s."""

    q: list[float]
    qd: list[float]
    qdd: list[float]
    parameters: dict[str, float]
    t: float


def start(scene: Scene) -> Start:
    """Return the state at which the scene's lesson shows numbers, with the velocities that the scene starts with.

    Of closed mechanisms that is D'Alembert's lesson. There is none for quaternions: closed ones begin at rest where the
    scene says nothing.
    """
    chosen, still = shown_state(scene), scene.is_closed
    if still and not quaternions(scene):
        with suppress(SymdynError):  # too large for a lesson
            chosen, still = choose_motion(Balance(scene, "en")), False
    led = any(joint.motion is not None for joint in scene.joints)
    declared = any(joint.start_rates for joint in scene.joints)
    if still or (declared and not led and not scene.is_closed):
        rates = dict(zip(scene.velocities, starting_rates(scene, chosen.parameters), strict=True))
        chosen = undriven(scene, chosen.moved({x: rates[str(x.value)] for x in chosen.values if str(x.value) in rates}))
    numbers = {str(symbol.value): value for symbol, value in chosen.values.items()}
    accelerations = [numbers.get(acceleration_name(u), 0.0) for u in scene.velocities]
    return Start(
        list(chosen.q),
        [numbers.get(u, 0.0) for u in scene.velocities],
        accelerations,
        dict(chosen.parameters),
        numbers[TIME] if led else 0.0,
    )
