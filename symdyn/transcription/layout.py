"""Where unknowns and equations of a collocation stand, and what is known of them: bounds, ends, a first guess."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import Faults, suggestion, velocity_name
from symdyn.simulation import Problem, Start
from symdyn.simulation.prescribed import drive_names, number_of, read_formula
from symdyn.transcription.grid import Grid, numbered
from symdyn.transcription.local import Written

Range = tuple[float | None, float | None]

Number = str | float
"""A formula in parameters, or a number."""

CLOSE = 1e-9
"""What a start or an end may be beyond its bounds by rounding."""


def known_names(where: str, names: Sequence[str], known: Sequence[str] | Mapping[str, object], faults: Faults) -> None:
    """Add a fault for every name that is not known."""
    for name in names:
        if name not in known:
            faults.add(where, f"{name} is not known; {suggestion(name, known)}")


def ends_of(given: Range, where: str, faults: Faults) -> tuple[float, float]:
    """Return a smallest and a largest value; None is none."""
    try:
        first, last = given
        least, most = (-np.inf if first is None else float(first)), (np.inf if last is None else float(last))
    except (TypeError, ValueError, OverflowError):
        faults.add(where, f"{given!r} is not a smallest and a largest value, such as (-1, 1) or (None, 5)")
        return -np.inf, np.inf
    if not least <= most:
        faults.add(where, f"nothing lies between {least:g} and {most:g}; give the smaller value first")
        return -np.inf, np.inf
    return least, most


@dataclass
class Layout:
    """Where everything stands, and what is known of it beforehand."""

    scene: Scene
    free: tuple[str, ...]
    written: Written
    grid: Grid
    paths: int
    span: tuple[float, float]

    def __post_init__(self) -> None:
        scene, found, grid = self.scene, self.written, self.grid
        N, P, S = len(grid.widths), len(grid.share), len(grid.stage)
        nq, nv = len(scene.coordinates), len(scene.velocities)
        self.names = drive_names(scene)
        self.place, self.size = numbered(
            {
                "q": (P, nq),
                "u": (P, nv),
                "a": (S, nv),
                "multiplier": (S, found.rows),
                "force": (S, len(found.driven)),
                "slack": (N, len(found.kinds["slack"])),
                "free": (len(self.free),),
                "T": (int(self.span[0] < self.span[1]),),
            }
        )
        self.row, self.rows = numbered(
            {
                "balance": (S, nv + found.rows),
                "defects": (N, grid.target.shape[1], nq + nv),
                "held": (N + 1, len(found.entries["held"])),
                "path": (N + 1, self.paths),
            }
        )

    def bounded(
        self, start: Start, bounds: Mapping[str, Range], values: Mapping[str, Quantity], faults: Faults
    ) -> tuple[Array, Array]:
        """Return the bounds of z: those of joints, those that are given, and the start."""
        scene, place = self.scene, self.place
        lower, upper = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        columns = {name: place["q"][:, k] for k, name in enumerate(scene.coordinates)}
        columns |= {name: place["u"][:, k] for k, name in enumerate(scene.velocities)}
        columns |= {self.names[k]: place["force"][:, i] for i, k in enumerate(self.written.driven)}
        columns |= {name: place["free"][k] for k, name in enumerate(self.free)}
        known_names("bounds", tuple(bounds), columns, faults)
        given = [(name, ends_of(one, f"bounds: {name}", faults)) for name, one in bounds.items() if name in columns]
        for name, (least, most) in [*_limits(scene, self.names, values), *given]:
            if name not in columns:
                continue
            at = columns[name]
            low, high = np.maximum(lower[at], least), np.minimum(upper[at], most)
            if np.any(low > high):
                limits = f"{np.max(lower[at]):g} … {np.min(upper[at]):g}"
                faults.add(f"bounds: {name}", f"{least:g} … {most:g} leaves nothing of its joint's limits, {limits}")
            else:
                lower[at], upper[at] = low, high
        lower[place["T"]], upper[place["T"]] = self.span
        for kind, names, x in (("q", scene.coordinates, start.q), ("u", scene.velocities, start.u)):
            for k, name in enumerate(names):
                self._fix(0, kind, k, name, float(x[k]), "start", lower, upper, faults)
        return lower, upper

    def ended(
        self,
        end: Mapping[str, Number],
        end_rates: Mapping[str, Number],
        values: Mapping[str, Quantity],
        lower: Array,
        upper: Array,
        faults: Faults,
    ) -> Start | None:
        """Fix what is given of the end; return a whole state there for the guess, None where none is found."""
        speeds: dict[str, Number] = {}
        units = SceneUnits(self.scene).letters
        for name, text in end_rates.items():
            speed = velocity_name(name) if velocity_name(name) in self.scene.velocities else name
            if speed in speeds:
                faults.add("end rates", f"{speed} is given twice, as {speeds[speed]} and as {text}")
            speeds[speed] = text
        for where, kind, given, names in (
            ("end", "q", end, self.scene.coordinates),
            ("end rates", "u", speeds, self.scene.velocities),
        ):
            known_names(where, tuple(given), names, faults)
            for name, text in given.items():
                formula = read_formula(str(text), values, f"{where}: {name}", faults, unit=units.get(name, ""))
                x = None if formula is None else number_of(formula, values, f"{where}: {name}", faults)
                if name in names and x is not None:
                    self._fix(-1, kind, names.index(name), name, x, where, lower, upper, faults)
        if faults.lines:
            return None
        try:
            return Problem(self.scene, start=end).initial
        except SimulateError:
            return None

    def _fix(
        self, node: int, kind: str, k: int, name: str, x: float, where: str, lower: Array, upper: Array, faults: Faults
    ) -> None:
        """Give an unknown at the start or the end its value; one beyond its bounds is a fault."""
        column = self.place[kind][self.grid.node[node], k]
        if not lower[column] - CLOSE <= x <= upper[column] + CLOSE:
            faults.add(where, f"{name} = {x:g} is beyond its bounds {lower[column]:g} … {upper[column]:g}")
        lower[column] = upper[column] = x

    def guessed(self, first: Start, last: Start | None, values: Mapping[str, Quantity]) -> Array:
        """Return z of a straight way from the start to the end, free of forces."""
        z, place, share = np.zeros(self.size), self.place, self.grid.share[:, None]
        way = np.zeros_like(first.q) if last is None else last.q - first.q
        z[place["q"]] = first.q + share * way
        duration = sum(self.span) / 2
        if len(first.q) == len(first.u):
            z[place["u"]] = way / duration
        z[place["T"]] = duration
        z[place["free"]] = [number_of(values[n], values, f"parameters.{n}", Faults("")) or 0.0 for n in self.free]
        return z


def _limits(
    scene: Scene, drives: Sequence[str], values: Mapping[str, Quantity]
) -> list[tuple[str, tuple[float, float]]]:
    """Return what joints may do, by the name of a coordinate, velocity or drive."""
    found: list[tuple[str, tuple[float, float]]] = []
    for joint in scene.moving:
        if len(joint.rates) != 1 or len(joint.coordinates) != 1:
            continue
        given = joint.limits
        k = scene.velocities.index(joint.rates[0])

        def value(x: Quantity | None, none: float, joint: str = joint.name) -> float:
            number = None if x is None else number_of(x, values, f"joints.{joint}.limits", Faults(""))
            return none if number is None else number

        speed, effort = value(given.velocity, np.inf), value(given.effort, np.inf)
        found.append((joint.coordinates[0], (value(given.lower, -np.inf), value(given.upper, np.inf))))
        found += [(joint.rates[0], (-speed, speed)), (drives[k], (-effort, effort))]
    return found
