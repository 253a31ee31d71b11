"""Paths of points and frames: their positions and orientations as laws in time, from texts, tables and files.

    tool = x, y, z                          its origin in ground axes, m: three laws; _ leaves a component free
    tool = x, y, z, rpy(a, b, c)            and its axes, Rz(c) Ry(b) Rx(a), as URDF turns
    tool = x, y, z, quaternion(w, x, y, z)  the same; divided by its length
    tool = x, y, z, pointing(z, a, b, c)    its axis x, y or z along (a, b, c), free to turn about it
    tool = FILE.csv                         columns x, y, z, or point_tool_x, ... as runs have them, and roll, pitch,
                                            yaw or qw, qx, qy, qz; with rates x_dot and x_ddot where they are known

What a path asks for is linear in the motion of its frame, [v; ω] = J u in ground axes:

    S J u = b        S J u̇ = ḃ - Ṡ J u - S J̇ u

    S            position: rows of 1 for the components that are asked for
                 axes: 1; one axis d: 1 - d dᵀ, whose row along d is empty
    ω, ω̇         of axes: 2 e' e* and 2 e'' e* for a unit quaternion e, e* its conjugate; of one axis: d × ḋ, d × d̈
    residual     p - p*; the rotation vector of R R*ᵀ; of one axis: minus the turn about d' × d that takes d' to d
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError, suggestion
from symdyn.frozen import dataclass, replace
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Faults, split_commas
from symdyn.simulation.prescribed.entries import Entries, read_entries
from symdyn.simulation.prescribed.formulas_in_time import Columns, columns_of, counted, parameter_values
from symdyn.simulation.prescribed.motion_laws import Law, column_law, read_law

TURNS: Mapping[str, tuple[str, ...]] = {
    "rpy": ("roll", "pitch", "yaw"),
    "quaternion": ("qw", "qx", "qy", "qz"),
    "pointing": ("x", "y", "z"),
}
"""Ways to say how a frame is turned, and what their laws are called, as columns of a table are too."""


@dataclass(frozen=True)
class PathRequest:
    """What a path asks of its frame at one time; the module's legend.

    Attributes:
        S, rate_of_S: shapes (k, 6).
        b, rate_of_b: shapes (k,).
        origin: wanted, m, shape (3,); NaN where it is free.
        axes: wanted, shape (3, 3); None where they are free.
        axis: number of the one axis that is asked for, of `axes`; None for all.
    """

    S: Array
    rate_of_S: Array
    b: Array
    rate_of_b: Array
    origin: Array
    axes: Array | None
    axis: int | None

    def residual(self, R: Array, p: Array) -> Array:
        """Return by how much a placement misses it, shape (k,), m and rad."""
        held = np.isfinite(self.origin)
        return np.concatenate([(p - self.origin)[held], self._turned(R)])

    def _turned(self, R: Array) -> Array:
        if self.axes is None:
            return np.zeros(0)
        if self.axis is None:
            return _rotation_vector(R @ self.axes.T)
        d, wanted = R[:, self.axis], self.axes[:, self.axis]
        normal = np.cross(wanted, d)
        sine, cosine = float(np.linalg.norm(normal)), float(d @ wanted)
        if sine == 0.0 and cosine < 0:  # straight back: about any axis across it
            normal = np.cross(wanted, np.eye(3)[int(np.abs(wanted).argmin())])
            return np.asarray(np.pi * normal / np.linalg.norm(normal))
        return normal if sine == 0.0 else np.asarray(np.arctan2(sine, cosine) / sine * normal)


@dataclass(frozen=True)
class PointPath:
    """The path of one point or body."""

    name: str  # of it
    origin: tuple[Law | None, ...]  # laws of its place; None where it is free
    way: str = ""  # "rpy", "quaternion", "pointing", or "" where it may turn as it likes
    turning: tuple[Law, ...] = ()  # laws of `TURNS[way]`
    axis: int | None = None  # number of the axis that points

    @property
    def laws(self) -> tuple[Law, ...]:
        return (*(law for law in self.origin if law is not None), *self.turning)

    @property
    def rows(self) -> int:
        """How many rows it asks for."""
        return sum(law is not None for law in self.origin) + (3 if self.way else 0)

    def at(self, t: float) -> PathRequest:
        """Return what is asked for at a time, s.

        Raises:
            SimulateError: a law has no finite value there, or a direction no length.
        """
        now = np.array([t])
        found = [None if law is None else np.array([float(one[0]) for one in law(now)]) for law in self.origin]
        held = [k for k, one in enumerate(found) if one is not None]
        origin = np.array([np.nan if one is None else one[0] for one in found])
        S, b = np.eye(6)[held], [one[1] for one in found if one is not None]
        rate_of_b = [one[2] for one in found if one is not None]
        rate_of_S, axes = np.zeros_like(S), None
        if self.way:
            laws = np.array([[float(one[0]) for one in law(now)] for law in self.turning]).T
            axes, across, rate_of_across, w, dw = _axes(self.way, laws, self.axis)
            below = np.zeros((3, 3))
            S, rate_of_S = (
                np.vstack([S, np.hstack([below, across])]),
                np.vstack([rate_of_S, np.hstack([below, rate_of_across])]),
            )
            b, rate_of_b = [*b, *w], [*rate_of_b, *dw]
        asked = PathRequest(S, rate_of_S, np.array(b), np.array(rate_of_b), origin, axes, self.axis)
        if not all(np.isfinite(part).all() for part in (asked.b, asked.rate_of_b, origin[held], asked.S)):
            texts = ", ".join(law.text for law in self.laws)
            raise SimulateError(f"path: {self.name}: ({texts}) has no finite value or derivative at t = {t:g} s")
        return asked


@dataclass(frozen=True)
class Approach:
    """The straight way of a frame from a placement, at 0, to where a path asks for it to be, at 1."""

    name: str
    rows: int
    target: PathRequest
    R: Array
    p: Array

    def at(self, s: float) -> PathRequest:
        """Return what is asked for on the way."""
        from scipy.spatial.transform import Rotation

        held = np.isfinite(self.target.origin)
        way = np.where(held, self.target.origin - self.p, np.nan)
        S, axes, turn = np.eye(6)[: 3 if self.target.axes is None else 6], None, np.zeros(0)
        S, rate = S[[*np.flatnonzero(held), *range(3, len(S))]], np.zeros((self.rows, 6))
        if self.target.axes is not None:
            turn = -self.target.residual(self.R, self.p)[held.sum() :]
            axes = Rotation.from_rotvec(s * turn).as_matrix() @ self.R
            if self.target.axis is not None:
                d = axes[:, self.target.axis]
                S[-3:, 3:] -= np.outer(d, d)
                rate[-3:, 3:] = -np.outer(np.cross(turn, d), d) - np.outer(d, np.cross(turn, d))
        return replace(
            self.target,
            S=S,
            rate_of_S=rate,
            b=np.concatenate([way[held], turn]),
            rate_of_b=np.zeros(self.rows),
            origin=self.p + s * way,
            axes=axes,
        )


@dataclass(frozen=True)
class ScenePath:
    """Paths by point; `span` is the first and last time at which all are known."""

    points: tuple[PointPath, ...] = ()

    @property
    def span(self) -> tuple[float, float]:
        """First and last time at which all laws are known."""
        spans = [law.span for point in self.points for law in point.laws]
        return max((low for low, _ in spans), default=-np.inf), min((high for _, high in spans), default=np.inf)


# Turning


@np.errstate(all="ignore")  # what is not finite is told
def _axes(way: str, laws: Array, axis: int | None) -> tuple[Array, Array, Array, Array, Array]:
    """Return R*, the rows that ω is asked for in and their rate, and what is asked of ω and ω̇."""
    x, v, a = laws
    if way == "pointing":
        d, rate, second = _unit(x, v, a)
        R = np.full((3, 3), np.nan)
        R[:, axis or 0] = d
        across, turned = np.eye(3) - np.outer(d, d), -np.outer(rate, d) - np.outer(d, rate)
        return R, across, turned, np.cross(d, rate), np.cross(d, second)
    if way == "rpy":
        x, v, a = _product(_product(_about(2, x, v, a), _about(1, x, v, a)), _about(0, x, v, a))
    e, rate, second = _unit(x, v, a)
    back = e * np.array([1.0, -1.0, -1.0, -1.0])
    w, dw = 2 * _times(rate, back)[1:], 2 * _times(second, back)[1:]  # e'' e* = ω̇/2 - ω²/4: the rest is its scalar
    return _matrix(e), np.eye(3), np.zeros((3, 3)), w, dw


def _unit(x: Array, v: Array, a: Array) -> tuple[Array, Array, Array]:
    """Return x/|x|, its rate and second rate."""
    length = np.sqrt(x @ x)
    first = (x @ v) / length
    second = (v @ v + x @ a - first**2) / length
    return (
        x / length,
        v / length - x * first / length**2,
        a / length - (2 * v * first + x * second) / length**2 + 2 * x * first**2 / length**3,
    )


Quaternion3 = tuple[Array, Array, Array]


def _about(k: int, x: Array, v: Array, a: Array) -> Quaternion3:
    """Return the quaternion of a turn about axis k by angle k of three, its rate and second rate."""
    c, s = np.cos(x[k] / 2), np.sin(x[k] / 2)
    e, way = np.zeros(4), np.zeros(4)
    e[0], e[k + 1], way[0], way[k + 1] = c, s, -s, c
    return e, way * v[k] / 2, way * a[k] / 2 - e * v[k] ** 2 / 4


def _product(one: Quaternion3, other: Quaternion3) -> Quaternion3:
    a, b = one, other
    return (
        _times(a[0], b[0]),
        _times(a[1], b[0]) + _times(a[0], b[1]),
        _times(a[2], b[0]) + 2 * _times(a[1], b[1]) + _times(a[0], b[2]),
    )


def _times(a: Array, b: Array) -> Array:
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], vector])


def _matrix(e: Array) -> Array:
    w, v = e[0], e[1:]
    across = np.cross(np.eye(3), v)  # skew, as rows e_k × v: the matrix of v ×
    return np.asarray((w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * across)


def _rotation_vector(R: Array) -> Array:
    """Return the rotation vector of a rotation, at most π long."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(R).as_rotvec(), dtype=np.float64)


FREE = "_"
AXES = "xyz"
WAYS = 'give text, such as "0.5, 0.1*t, _", or (times, x), x of shape (N, 3), or (N, 7) with a quaternion behind'


def read_path(scene: Scene, entries: Entries) -> ScenePath:
    """Return the paths that words and files say.

    Args:
        scene: the mechanism, its parameters bound.
        entries: `point=x, y, z` as the legend of point_path.py says, or a .toml file of such lines under [path];
            one or several, or by name, where (times, values) of shapes (N,) and (N, 3), or (N, 7) with a quaternion
            behind, are one too.

    Raises:
        SimulateError: with every fault, one line each.
    """
    values, faults = parameter_values(scene), Faults("")
    found: dict[str, PointPath] = {}
    if isinstance(entries, Mapping):
        entries = {name: _together(x) for name, x in entries.items()}
        for name, x in entries.items():
            if isinstance(x, tuple) and len(x) == 2 and _is_table(x[1]):
                _add(found, name, "path", _from_arrays(str(name), *x, faults), scene, faults)
            elif not isinstance(x, (str, Path)) and not callable(x):
                faults.add(f"path: {name}", f"{type(x).__name__} is no path; {WAYS}")
        entries = {name: x for name, x in entries.items() if isinstance(x, (str, Path)) or callable(x)}
    said = read_entries(entries, "path", faults)
    for one in said.tables:
        faults.add(one.source, "whose path is it? write POINT=FILE.csv, or give (times, values) by name")
    for name, _ in said.functions:
        faults.add(f"path: {name}" if name else "path", f"a function is no path; {WAYS}")
    for where, name, text in said.texts:
        if text.lower().endswith(".csv"):
            path = _from_file(name, text, faults)
        else:
            path = _from_laws(name, text, values, f"{where}: {name}", faults)
        _add(found, name, where, path, scene, faults)
    faults.close(SimulateError)
    return ScenePath(tuple(found.values()))


def _together(entry: Any) -> Any:
    """Return formulas and numbers of a list, or of a tuple that is no table, as the text that they would be."""
    parts = entry.tolist() if isinstance(entry, np.ndarray) and entry.ndim == 1 else entry
    plain = isinstance(parts, list | tuple) and all(isinstance(one, str | int | float) for one in parts)
    return ", ".join(map(str, parts)) if plain and parts else entry


def _is_table(values: object) -> bool:
    """Tell whether values are rows of numbers."""
    try:
        return np.ndim(values) == 2  # type: ignore[arg-type]
    except ValueError:  # rows of several lengths; whoever reads entries refuses them
        return False


def _add(
    result: dict[str, PointPath], name: str, where: str, path: PointPath | None, scene: Scene, faults: Faults
) -> None:
    known = (*(one.name for one in scene.points), *(one.name for one in scene.bodies))
    if name not in known:
        faults.add(where, f"{name} is no point and no body; {suggestion(name, known)}")
    elif name in result:
        faults.add(where, f"{name} has a path already")
    elif path is not None:
        result[name] = path


def _from_laws(name: str, text: str, values: Mapping[str, Quantity], where: str, faults: Faults) -> PointPath | None:
    before, parts = len(faults.lines), [part.strip() for part in split_commas(text)]
    if len(parts) not in (3, 4):
        faults.add(
            where,
            f'"{text}" has {counted(len(parts), "part")}; a path is x, y, z, such as {name}=0.5, 0.1*t, _ where _ is '
            "free, and rpy(roll, pitch, yaw), quaternion(w, x, y, z) or pointing(z, a, b, c) behind them if it is to "
            "be turned",
        )
        return None
    origin = tuple(None if part == FREE else read_law(part, values, where, faults, "m") for part in parts[:3])
    way, turning, axis = "", list[Law | None](), None
    if len(parts) == 4 and parts[3] != FREE:
        word, bracket, rest = parts[3].partition("(")
        way, inside = word.strip(), split_commas(rest.rstrip().removesuffix(")"))
        if way in TURNS and not (bracket and rest.rstrip().endswith(")")):
            faults.add(where, f'"{parts[3]}" lacks a bracket; write {way}({_takes(way)})')
            return None
        if way not in TURNS:
            faults.add(where, f'"{parts[3]}" says no turning; {suggestion(way, tuple(TURNS))}')
            return None
        if way == "pointing":
            letter, inside = inside[0].strip() if inside else "", inside[1:]
            axis = AXES.find(letter) if len(letter) == 1 else -1
            if letter and axis < 0:
                faults.add(where, f'"{parts[3]}": {letter} is no axis; write pointing(z, 0, 0, -1)')
        if len(inside) != len(TURNS[way]):
            faults.add(where, f'"{parts[3]}": {way} takes ({_takes(way)})')
        else:
            turning = [read_law(part, values, where, faults, "rad") for part in inside]
    if not way and all(law is None for law in origin):
        faults.add(where, f'"{text}" asks for nothing; give a component')
    if len(faults.lines) > before:
        return None
    return PointPath(name, origin, way, tuple(law for law in turning if law is not None), axis)


def _takes(way: str) -> str:
    return "axis, a, b, c" if way == "pointing" else ", ".join(TURNS[way])


def _from_file(name: str, text: str, faults: Faults) -> PointPath | None:
    try:
        table = Columns.read(Path(text))
    except SimulateError as error:
        faults.lines += error.faults
        return None
    return _from_columns(name, table, faults)


def _from_arrays(name: str, times: object, values: object, faults: Faults) -> PointPath | None:
    names, rows = (*AXES, *TURNS["quaternion"]), np.asarray(values)
    if rows.shape[1] not in (3, 7):
        faults.add(
            f"path: {name}", f"an array of shape {rows.shape} is no path; give x, y, z, or w, x, y, z behind them"
        )
        return None
    with faults.noted():
        return _from_columns(name, columns_of(f"path: {name}", times, dict(zip(names, rows.T, strict=False))), faults)
    return None


def _from_columns(name: str, table: Columns, faults: Faults) -> PointPath | None:
    before = len(faults.lines)
    prefixes = [one for one in (f"point_{name}_", "") if any(one + axis in table.values for axis in AXES)]
    prefix = prefixes[0] if prefixes else ""
    origin = tuple(_column(table, prefix + axis) for axis in AXES)
    ways = [
        (way, laws)
        for way in ("rpy", "quaternion")
        for own in dict.fromkeys((prefix, f"point_{name}_", ""))
        if any(laws := [_column(table, own + one) for one in TURNS[way]])
    ]
    way, turning = ways[0] if ways else ("", [])
    missing = [one for one, law in zip(TURNS.get(way, ()), turning, strict=True) if law is None]
    if missing:
        faults.add(table.source, f"{', '.join(missing)} missing; a frame is turned by ({', '.join(TURNS[way])})")
    if not way and all(law is None for law in origin):
        faults.add(table.source, f"has no column of a place, x, y, z or point_{name}_x, ..., and none of a turning")
    if len(faults.lines) > before:
        return None
    return PointPath(name, origin, way, tuple(law for law in turning if law is not None))


def _column(table: Columns, name: str) -> Law | None:
    return column_law(table, name, f"{name}_dot", f"{name}_ddot") if name in table.values else None
