"""Linear feedback of the state, τ = u0 - K (x - x0), and the files that hold it.

    {"K": [[...]], "states": [...], "inputs": [...], "x0": {...}, "u0": {...}}

K has a row an input and a column a state. A state is a coordinate or a velocity by its name. Where a velocity is no
rate of a coordinate, as of a ball or a free body, differences of coordinates are no vector: x - x0 is then the
difference on the group, the rotation vector of R0ᵀ R and R0ᵀ (p - p0), in the axes of the moved frame at x0. Such a
state is called `along VELOCITY`, as in linearisations. x0 names coordinates and velocities; what it does not name is 0,
a rotation none. `period`, `delay` and `limits` may stand beside, as a `Feedback` has them. With "t", rising times in s,
K has a matrix a time, and each number of x0 and u0 may be a list: they are interpolated, and held before and behind.

Reference: Bullo and Murray, Tracking for fully actuated mechanical systems, Automatica 35 (1999) 17, error functions.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError, suggestion
from symdyn.frozen import dataclass, field, replace
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Faults, velocity_name
from symdyn.simulation.prescribed.formulas_in_time import read_file
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

NEEDED, ALLOWED = ("K", "states", "inputs"), ("K", "states", "inputs", "x0", "u0", "t", "period", "delay", "limits")

ALONG = "along "
"""Begins the name of a position that is a displacement along a velocity."""

LARGEST = 1.7e308
"""Numbers beyond are not finite as doubles."""

STEP = 1e-6
"""Difference by which the difference on the group is differentiated."""


@dataclass(frozen=True)
class Gains:
    """Linear feedback of the state; see the module's legend.

    Attributes:
        scene: the mechanism.
        K: shape (m, n).
        states: names of the columns.
        inputs: names of the rows.
        q0, u0: coordinates, shape (nq,), and velocities, shape (nv,), where x - x0 vanishes.
        initial: forces there, shape (m,).
    """

    scene: Scene
    K: Array = field(repr=False)
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    q0: Array = field(repr=False)
    u0: Array = field(repr=False)
    initial: tuple[float, ...]

    @property
    def formulas(self) -> dict[str, str] | None:
        """The forces as formulas in coordinates and velocities, by input; None where states are no differences."""
        names = [*self.scene.coordinates, *self.scene.velocities]
        if not set(self.states) <= set(names):
            return None
        x0 = dict(zip(names, [*self.q0.tolist(), *self.u0.tolist()], strict=True))
        rows = [
            [repr(begin), *(f"({-k!r})*({name} - ({x0[name]!r}))" for k, name in zip(row, self.states, strict=True))]
            for begin, row in zip(self.initial, self.K.tolist(), strict=True)
        ]
        return {name: " + ".join(row) for name, row in zip(self.inputs, rows, strict=True)}

    def __call__(self, t: float, q: Array, u: Array) -> Array:
        """Return the forces of the inputs, shape (m,)."""
        return np.asarray(np.asarray(self.initial) - self._whole @ np.concatenate([self.away(q), u - self.u0]))

    def slope(self, t: float, q: Array, u: Array) -> Array:
        """Return ∂τ/∂(q, u), shape (m, nq + nv)."""
        n = len(self.scene.velocities)
        by_q = np.array([(self.away(q + d) - self.away(q - d)) / (2 * STEP) for d in STEP * np.eye(len(q))]).T
        return -np.hstack([self._whole[:, :n] @ by_q, self._whole[:, n:]])

    @cached_property
    def _whole(self) -> Array:
        """Return K with a column for every position, velocity and state of one's own, shape (m, nv + nu)."""
        names = state_names(self.scene)
        found = np.zeros((len(self.inputs), len(names)))
        found[:, [names.index(name) for name in self.states]] = self.K
        return found

    @cached_property
    def _parts(self) -> list[tuple[slice, slice, bool]]:
        return _parts(self.scene)

    def away(self, q: Array) -> Array:
        """Return q - q0 along the velocities, shape (nv,)."""
        found = np.empty(len(self.scene.velocities))
        for here, along, turns in self._parts:
            away = q[here] - self.q0[here]
            if turns:
                back, turn = _rotation(self.q0[here][-4:]).inv(), _rotation(q[here][-4:])
                shift = back.apply(away[:-4]) if len(away) > len("wxyz") else away[:-4]
                away = np.concatenate([shift, (back * turn).as_rotvec()])
            found[along] = away
        return found

    def far(self, q: Array) -> list[str]:
        """Return what is said of a start that is more than a quarter of a turn from where the gains act."""
        names, away = self.scene.velocities, self.away(q)
        better = "" if self.q0.any() else "; lin.lqr(Q, R), in place of its K, knows its point"
        places = {names.index(rate): name for name in self.states if (rate := velocity_name(name)) in names}
        return [
            f"feedback: the gains act about {name} = {q[self.scene.coordinates.index(name)] - away[k]:.4g} rad, and "
            f"the start is {abs(away[k]):.3g} rad from there{better}"
            for k, name in places.items()
            if SceneUnits(self.scene).letters.get(name) == "rad" and abs(away[k]) > np.pi / 2
        ][:1]


@dataclass(frozen=True)
class Schedule:
    """Linear feedback whose gains, place or forces change over time."""

    at: Callable[[float], Gains]  # the gains at a time, s
    inputs: tuple[str, ...]  # names of the forces
    end: float = math.inf  # when what is followed ends without rest, s; infinite where it does not

    @property
    def initial(self) -> tuple[float, ...]:
        """Forces at the begin, where x is x0, shape (m,)."""
        return self.at(0.0).initial

    def __call__(self, t: float, q: Array, u: Array) -> Array:
        """Return the forces of the inputs, shape (m,)."""
        return self.at(t)(t, q, u)

    def slope(self, t: float, q: Array, u: Array) -> Array:
        """Return ∂τ/∂(q, u), shape (m, nq + nv)."""
        return self.at(t).slope(t, q, u)


def state_names(scene: Scene) -> list[str]:
    """Return the names of all that gains may multiply, shape (nv + nu,): positions, velocities, states of one's own."""
    names: list[str] = []
    for here, along, turns in _parts(scene):
        names += [f"{ALONG}{name}" for name in scene.velocities[along]] if turns else scene.coordinates[here]
    return [*names, *scene.velocities, *(one.name for one in scene.states)]


def _parts(scene: Scene) -> list[tuple[slice, slice, bool]]:
    """Return coordinates and velocities of every part of the joints, and whether a quaternion ends the former."""
    found, q, u = [], 0, 0
    for joint in scene.moving:
        for block in JOINTS[joint.type].blocks(joint):
            nq, nu = len(block.coordinates), len(block.velocities)
            found.append((slice(q, q + nq), slice(u, u + nu), nq != nu))
            q, u = q + nq, u + nu
    return found


def read_gains(scene: Scene, path: Path) -> tuple[Gains | Schedule, dict[str, Any]]:
    """Return the gains of a .json file, and what else it says of the controller.

    Raises:
        SimulateError: with every fault, one line each.
    """
    try:
        said = json.loads(read_file(path))
    except (json.JSONDecodeError, RecursionError) as error:
        raise SimulateError(f"{path}: is no JSON: {error}") from None
    if not isinstance(said, Mapping):
        raise SimulateError(f'{path}: holds no gains; write {{"K": [[...]], "states": [...], "inputs": [...]}}')
    return gains_from(scene, said, str(path))


def gains_from(scene: Scene, specified: Mapping[str, Any], where: str) -> tuple[Gains | Schedule, dict[str, Any]]:
    """Return the gains that a mapping says, and what else it says of the controller; errors as of `read_gains`."""
    if "t" not in specified:
        return _gains(scene, specified, where)
    from scipy.interpolate import PchipInterpolator

    try:
        t = np.asarray(specified["t"], dtype=np.float64)
    except (TypeError, ValueError):
        t = np.zeros(0)
    if t.ndim != 1 or len(t) < 2 or not np.isfinite(t).all() or not np.all(np.diff(t) > 0):
        raise SimulateError(f"{where}: t: give two times or more that rise, s")
    found = [_gains(scene, _row(specified, k, len(t), where), where) for k in range(len(t))]
    first, more = found[0]
    curve = PchipInterpolator(t, [np.hstack([one.K.ravel(), one.q0, one.u0, one.initial]) for one, _ in found])
    ends = np.cumsum([first.K.size, len(first.q0), len(first.u0)])

    def at(now: float) -> Gains:
        K, q0, u0, initial = np.split(curve(min(max(now, t[0]), t[-1])), ends)
        return replace(first, K=K.reshape(first.K.shape), q0=_unit(scene, q0), u0=u0, initial=tuple(initial.tolist()))

    return Schedule(at, first.inputs), more


def _row(specified: Mapping[str, Any], k: int, count: int, where: str) -> dict[str, Any]:
    """Return gains over time as they are at one of the times."""
    try:
        named = {
            part: {name: float(np.broadcast_to(x, count)[k]) for name, x in specified.get(part, {}).items()}
            for part in ("x0", "u0")
        }
        K = np.asarray(specified.get("K"), dtype=np.float64)
        if len(K) != count:
            raise ValueError
    except (TypeError, ValueError, AttributeError):
        told = f"{where}: with t, {count} times, K takes as many matrices, and x0 and u0 numbers or as many by name"
        raise SimulateError(told) from None
    return {**{name: one for name, one in specified.items() if name != "t"}, **named, "K": K[k]}


def _gains(scene: Scene, specified: Mapping[str, Any], where: str) -> tuple[Gains, dict[str, Any]]:
    """Return gains that stay, as of `gains_from`."""
    faults = Faults(where)
    for name in specified:
        if name not in ALLOWED:
            faults.add(str(name), f"is not known; {suggestion(str(name), ALLOWED)}")
    for name in NEEDED:
        if name not in specified:
            faults.add(name, "is missing")
    faults.close(SimulateError)
    states, inputs = (_names(specified[name], name, faults) for name in ("states", "inputs"))
    known = state_names(scene)
    quaternions = set(scene.coordinates) - set(known)
    for name in states:
        if name in quaternions:
            turns = ", ".join(one for one in known if one.startswith(ALONG))
            faults.add("states", f"{name} is part of a quaternion, whose differences are no vector; give {turns}")
        elif name not in known:
            faults.add("states", f"{name} is not known; {suggestion(name, known)}")
    K = _matrix(specified["K"], inputs, states, faults)
    q0, u0 = _reference(scene, _numbers(specified.get("x0", {}), "x0", faults), faults)
    forces = _numbers(specified.get("u0", {}), "u0", faults)
    for name in forces:
        if name not in inputs:
            faults.add("u0", f"{name} is no input; {suggestion(name, inputs)}")
    more = {name: specified[name] for name in ("period", "delay", "limits") if specified.get(name) is not None}
    faults.close(SimulateError)
    assert K is not None, "checked"
    initial = tuple(forces.get(name, 0.0) for name in inputs)
    return Gains(scene, K, tuple(states), tuple(inputs), q0, u0, initial), more


def _names(specified: object, where: str, faults: Faults) -> list[str]:
    if (
        not isinstance(specified, Sequence)
        or isinstance(specified, str)
        or not all(isinstance(one, str) for one in specified)
    ):
        faults.add(where, "is no list of names")
        return []
    found = list(specified)
    if not found:
        faults.add(where, "names none")
    for name in dict.fromkeys(found):
        if found.count(name) > 1:
            faults.add(where, f"{name} is named twice")
    return found


def _matrix(specified: object, inputs: Sequence[str], states: Sequence[str], faults: Faults) -> Array | None:
    try:
        K = np.asarray(specified, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        faults.add("K", "is no matrix of numbers, a list of rows of the same length")
        return None
    rows, columns = len(inputs), len(states)
    if rows and columns and K.shape != (rows, columns):
        shape, each = " x ".join(map(str, K.shape)) or "a number", f"{', '.join(inputs)} by {', '.join(states)}"
        faults.add("K", f"is {shape}; {rows} inputs and {columns} states need {rows} x {columns}, {each}")
    elif not np.all(np.isfinite(K)):
        faults.add("K", "has an entry that is not finite")
    return K


def _numbers(specified: object, where: str, faults: Faults) -> dict[str, float]:
    if not isinstance(specified, Mapping):
        faults.add(where, "is no table of numbers by name")
        return {}
    for name, value in specified.items():
        if not _finite(value):
            faults.add(where, f"{name} = {value!r} is no finite number")
    return {str(name): float(value) for name, value in specified.items() if _finite(value)}


def _finite(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= LARGEST


def _reference(scene: Scene, specified: Mapping[str, float], faults: Faults) -> tuple[Array, Array]:
    moving = (*scene.velocities, *(one.name for one in scene.states))
    names = (*scene.coordinates, *moving)
    for name, value in specified.items():
        if name.startswith(ALONG) and name in state_names(scene):
            if value:
                faults.add("x0", f"{name} is a displacement from x0, 0 there; give {', '.join(scene.coordinates)}")
        elif name not in names:
            faults.add("x0", f"{name} is not known; {suggestion(name, names)}")
    q0 = np.array([specified.get(name, 0.0) for name in scene.coordinates])
    return _unit(scene, q0), np.array([specified.get(name, 0.0) for name in moving])


def _unit(scene: Scene, q0: Array) -> Array:
    """Return coordinates with quaternions of length one; of length zero they are no rotation."""
    for here, _, turns in _parts(scene):
        if turns:
            e = q0[here][-4:]
            size = float(np.linalg.norm(e))
            q0[here] = np.concatenate([q0[here][:-4], e / size if size else [1.0, 0.0, 0.0, 0.0]])
    return q0


def _rotation(e: Array) -> Rotation:
    """Return the rotation of a quaternion (w, x, y, z) of any length."""
    from scipy.spatial.transform import Rotation  # late: it takes long to load

    return Rotation.from_quat(np.roll(e, -1))
