"""Arms: the axes of the joints between the ground and a frame, and what is parallel or meets among them.

    h[i], c[i]   direction of axis i in ground axes, and a point on it, m, where all angles are zero; ground's side first
    R, p         the frame there
    T(q)         = exp(h[1], c[1]; q1) ... exp(h[n], c[n]; qn) (R, p): a product of turns about these axes

An axis is a column [v; ω] of the frame's Jacobian there: h = ω, and v = h × (p - c), so that c = p - v × h is the point of
it next to p. Neighbours that are parallel, or meet, do so at every position; so do three in a row that share a point.

A closed form of six joints is known where a class of `CLASSES` fits. Points are then put where axes meet.

Reference: Lynch and Park, Modern Robotics (2017), section 4.1; Pieper, The kinematics of manipulators under computer
control (1968); Ostermeier, Kuelz and Althoff, Automatic geometric decomposition for analytical inverse kinematics,
IEEE Robotics and Automation Letters 10 (2025) 9964.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.arguments import argument
from symdyn.dynamics import Workspace, derive_one
from symdyn.errors import SimulateError
from symdyn.graph import evaluate
from symdyn.scene import Scene
from symdyn.scene.values import Joint, velocity_name
from symdyn.simulation.equations.compiled_routines import opened

SAME = 1e-9
"""Below it directions are parallel (sine of the angle), and axes meet (gap over the arm's size)."""

GENERIC = 0.7
"""rad, at which a joint is held to see what the others are."""


@dataclass(frozen=True)
class Kind:
    """A class of arms of six joints that has a closed form; places count from the ground, or all from the frame.

    Attributes:
        name: in words.
        meeting, parallel: places of axes that share a point, and of parallel ones, in groups.
    """

    name: str
    meeting: tuple[tuple[int, ...], ...] = ()
    parallel: tuple[tuple[int, ...], ...] = ()


CLASSES = (
    Kind("spherical wrist", meeting=((3, 4, 5),)),
    Kind("spherical shoulder", meeting=((0, 1, 2),)),
    Kind("three parallel axes", parallel=((1, 2, 3),)),
    Kind("three parallel axes", parallel=((2, 3, 4),)),
    Kind("three parallel axes, and two that meet", ((4, 5),), ((0, 1, 2),)),
    Kind("three parallel axes, and two that meet", ((0, 1),), ((3, 4, 5),)),
)
"""The first that fits is told."""


@dataclass(frozen=True, eq=False)
class Arm:
    """The joints that turn between the ground and a frame; the module's legend.

    Attributes:
        point: the frame, a point or a body.
        names: of the angles, shape (n,).
        h, c: shapes (n, 3).
        R, p: shapes (3, 3) and (3,).
    """

    point: str
    names: tuple[str, ...]
    h: Array
    c: Array
    R: Array
    p: Array

    def groups(self, least: int, meet: bool) -> list[tuple[int, ...]]:
        """Return the longest rows of neighbours that are parallel, or share a point; so many at least, by place."""
        found: list[tuple[int, ...]] = []
        for first in range(len(self.names)):
            last = first + 1
            while last < len(self.names) and self._together(range(first, last + 1), meet):
                last += 1
            row = tuple(range(first, last))
            if len(row) >= least and not any(set(row) <= set(other) for other in found):
                found.append(row)
        return found

    def meeting(self, places: Sequence[int]) -> Array | None:
        """Return the point that axes share; None where there is none, or they are parallel."""
        h, c = self.h[list(places)], self.c[list(places)]
        across = np.eye(3) - h[:, :, None] * h[:, None, :]  # |across (x - c)| is how far x is from an axis
        if any(np.linalg.norm(np.cross(one, other)) < SAME for one, other in zip(h, h[1:], strict=False)):
            return None
        x = np.linalg.solve(across.sum(axis=0), np.einsum("nij,nj->i", across, c))
        gap = float(np.abs(np.einsum("nij,nj->ni", across, x - c)).max())
        return x if gap <= SAME * max(1.0, self.size) else None

    def _together(self, places: Sequence[int], meet: bool) -> bool:
        if meet:
            return self.meeting(places) is not None
        return all(np.linalg.norm(np.cross(self.h[places[0]], self.h[k])) < SAME for k in places)

    @property
    def size(self) -> float:
        """How far the frame and the axes are apart, m, at most where all angles are zero."""
        return float(np.abs(self.c - self.p).max(initial=0.0))

    @property
    def family(self) -> str:
        """The class of `CLASSES`, or "" where it has none, or fewer or more joints than six."""
        if len(self.names) != 6:
            return ""
        fits = (
            kind.name
            for kind in CLASSES
            if all(self._together(one, True) for one in kind.meeting)
            and all(self._together(one, False) for one in kind.parallel)
        )
        return next(fits, "")

    @property
    def words(self) -> tuple[str, ...]:
        """What is parallel or meets, and which class that is, a line each."""
        parts = [f"{self._called(row)} are parallel" for row in self.groups(2, False)]
        parts += [f"{self._called(row)} meet in a point" for row in self.groups(2, True)]
        return (*parts, self.verdict)

    @property
    def verdict(self) -> str:
        """Whether it has a closed form, in words."""
        n = len(self.names)
        if n > 6:
            said = f"a closed form where one of {', '.join(self.holding)} is held" if self.holding else "no closed form"
            return f"{n} joints: {said}"
        if n < 6:
            return f"{n} joints: a closed form of the poses that they reach"
        lacking = "6 joints: no closed form is known; three axes in a row would have to meet at an end, or be parallel"
        return f"{self.family}: a closed form" if self.family else lacking

    @property
    def holding(self) -> tuple[str, ...]:
        """Of seven joints those that leave six with a closed form when one is held."""
        n = len(self.names)
        return tuple(self.names[k] for k in range(n) if n == 7 and self.held(k).family)

    def held(self, place: int, angle: float = GENERIC) -> Arm:
        """Return it with a joint held: what it carries is turned."""
        h, c = self.h[place], self.c[place]
        W = np.cross(np.eye(3), -h)
        turn = np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W
        moved, kept = slice(place + 1, None), [k for k in range(len(self.names)) if k != place]
        axes, points = self.h.copy(), self.c.copy()
        axes[moved], points[moved] = self.h[moved] @ turn.T, (self.c[moved] - c) @ turn.T + c
        names = tuple(self.names[k] for k in kept)
        return Arm(self.point, names, axes[kept], points[kept], turn @ self.R, turn @ (self.p - c) + c)

    def placed(self) -> Arm:
        """Return it with points where axes meet, and parallel axes alike to the last digit."""
        h, c = self.h.copy(), self.c.copy()
        for row in self.groups(2, False):
            for k in row[1:]:
                h[k] = np.copysign(1.0, h[row[0]] @ h[k]) * h[row[0]]
        for row in sorted(self.groups(2, True), key=len):
            c[list(row)] = self.meeting(row)
        return Arm(self.point, self.names, h, c, self.R, self.p)

    def _called(self, row: Sequence[int]) -> str:
        *most, last = (self.names[k] for k in row)
        return f"{', '.join(most)} and {last}"


def chain(scene: Scene, point: str) -> tuple[Joint, ...]:
    """Return the joints from the ground to a point or a body."""
    found, carrying = list[Joint](), {joint.child: joint for joint in scene.joints}
    body = next((one.body for one in scene.points if one.name == point), point)
    while body in carrying:
        found.append(carrying[body])
        body = found[-1].parent
    return tuple(reversed(found))


def arm_of(scene: Scene, point: str, held: Mapping[str, float] | None = None) -> Arm:
    """Return the arm that moves a point or a body, of coordinates that are not held.

    Raises:
        SimulateError: it has none: with every reason, a line each.
    """
    held, known = held or {}, opened(scene).values
    if scene.is_constrained:
        raise SimulateError(
            f"{scene.name}: its loops and rows have no closed form of inverse kinematics; without a branch, a path is "
            f"followed from a start ({argument('start')})"
        )
    w = Workspace(scene)
    loose = [joint for joint in chain(scene, point) if any(name not in held for name in joint.coordinates)]
    q = {symbol: float(held.get(name, 0.0)) for name, symbol in zip(scene.coordinates, w.state.q, strict=True)}
    at = q | {w.graph.symbol(name): x for name, x in known.items()}
    pose, J = (derive_one(w, f"{name}:{point}") for name in ("pose", "jacobian"))
    values = np.array(evaluate([*pose.entries, *J.entries], Floats(), at), dtype=np.float64)
    T, columns = values[:12].reshape(3, 4), values[12:].reshape(6, -1)
    names, faults, rates = [name for joint in loose for name in joint.coordinates], list[str](), list(scene.velocities)
    turning = [_why_not(joint, columns, rates) for joint in loose]
    for joint, why in zip(loose, turning, strict=True):
        if why:
            hold = argument("motion", dict.fromkeys(joint.coordinates, 0.3))
            way = f"; hold it, as in {hold}" if joint.coordinates else ""
            faults.append(f"{scene.name}: {joint.name} {why}, which has no closed form here{way}")
    if not loose:
        faults.append(f"{scene.name}: nothing that is not held moves {point}")
    if faults:
        raise SimulateError(faults)
    v, h = np.split(columns[:, [rates.index(velocity_name(name)) for name in names]].T, 2, axis=1)
    h = h / np.linalg.norm(h, axis=1)[:, None]
    return Arm(point, tuple(names), h, T[:, 3] - np.cross(v, h), T[:, :3], T[:, 3])


def _why_not(joint: Joint, columns: Array, rates: Sequence[str]) -> str:
    """Return why a joint is none of an arm, "" where it turns about an axis."""
    if joint.coupling is not None:
        return f"follows {', '.join(name for name, _ in joint.coupling.ratios)}"
    if joint.motion is not None:
        return "moves by a law of the scene"
    if len(joint.coordinates) != 1 or velocity_name(joint.coordinates[0]) not in rates:
        return f"is {joint.type}, of {len(joint.coordinates)} coordinates"
    v, w = np.split(columns[:, rates.index(velocity_name(joint.coordinates[0]))], 2)
    turns = abs(float(w @ w) - 1.0) < SAME and abs(float(v @ w)) < SAME
    return "" if turns else f"is {joint.type}"
