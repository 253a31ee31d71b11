"""Arms: the axes of the joints between the ground and a frame, and what is parallel or meets among them.

    h[i], c[i]   direction of axis i, ground's side first, and a point on it, m, in ground axes where angles are zero
    R, p         the frame there
    T(q)         = exp(h[1], c[1]; q1) ... exp(h[n], c[n]; qn) (R, p): a product of turns about these axes

An axis is a column [v; ω] of the frame's Jacobian there: h = ω, v = h × (p - c), and c = p - v × h is the point of it
next to p. Neighbours that are parallel, or meet, do so at every position; so do three in a row that share a point.

Reference: Lynch and Park, Modern Robotics (2017), section 4.1; Ostermeier, Kuelz and Althoff, Automatic geometric
decomposition for analytical inverse kinematics, IEEE Robotics and Automation Letters 10 (2025) 9964.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.arguments import argument
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.mechanism import joints_below
from symdyn.errors import SimulateError, listed
from symdyn.frozen import dataclass, replace
from symdyn.graph import evaluate
from symdyn.scene import Scene
from symdyn.scene.values import Joint, velocity_name
from symdyn.simulation.equations.compiled_routines import opened

SAME = 1e-9
"""Below it directions are parallel (sine of the angle), and axes meet (gap over the arm's size)."""

CLASSES: tuple[tuple[str, tuple[int, ...], tuple[int, ...]], ...] = (
    ("spherical wrist", (3, 4, 5), ()),
    ("spherical shoulder", (0, 1, 2), ()),
    ("three parallel axes", (), (1, 2, 3)),
    ("three parallel axes", (), (2, 3, 4)),
    ("three parallel axes, and two that meet", (4, 5), (0, 1, 2)),
    ("three parallel axes, and two that meet", (0, 1), (3, 4, 5)),
)
"""Of six joints that have a closed form: name, places of axes that share a point, of parallel ones; the first tells."""


@dataclass(frozen=True, eq=False)
class Arm:
    """The joints that turn between the ground and a frame, a point or a body; the module's legend.

    Attributes:
        point, names: the frame; the angles, n of them.
        h, c, R, p: shapes (n, 3), (n, 3), (3, 3) and (3,).
    """

    point: str
    names: tuple[str, ...]
    h: Array
    c: Array
    R: Array
    p: Array

    @property
    def size(self) -> float:
        """How far axes are from the frame, m, a component at most."""
        return float(np.abs(self.c - self.p).max(initial=0.0))

    @property
    def family(self) -> str:
        """The class of `CLASSES`, "" where it has none, or fewer or more joints than six."""
        fits = (name for name, meet, row in CLASSES if self._meet(meet) and self._parallel(row))
        return next(fits, "") if len(self.names) == 6 else ""

    @property
    def holding(self) -> tuple[str, ...]:
        """Of seven joints those that leave six with a closed form when one is held."""
        return tuple(name for k, name in enumerate(self.names) if len(self.names) == 7 and self.held(k, 0.7).family)

    @property
    def words(self) -> tuple[str, ...]:
        """What is parallel, what meets, and which class that is, a line each."""
        kinds = ((False, "are parallel"), (True, "meet in a point"))
        parts = [f"{listed([self.names[k] for k in row])} {said}" for meet, said in kinds for row in self._rows(meet)]
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

    def held(self, place: int, angle: float) -> Arm:
        """Return it with a joint held: what it carries is turned."""
        h, c, moved = self.h[place], self.c[place], np.arange(len(self.names)) > place
        W = np.cross(np.eye(3), h)  # the matrix of h ×
        turn = np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W
        axes = np.where(moved[:, None], self.h @ turn.T, self.h)
        points = np.where(moved[:, None], (self.c - c) @ turn.T + c, self.c)
        names = (*self.names[:place], *self.names[place + 1 :])
        axes, points = np.delete(axes, place, axis=0), np.delete(points, place, axis=0)
        return Arm(self.point, names, axes, points, turn @ self.R, turn @ (self.p - c) + c)

    def placed(self) -> Arm:
        """Return it with points where axes meet, and parallel axes alike to the last digit."""
        h, c = self.h.copy(), self.c.copy()
        for row in self._rows(False):
            h[list(row)] = np.sign(h[list(row)] @ h[row[0]])[:, None] * h[row[0]]
        for row in sorted(self._rows(True), key=len):
            c[list(row)] = self._crossing(row)[0]
        return replace(self, h=h, c=c)

    def _rows(self, meet: bool) -> list[tuple[int, ...]]:
        """Return the longest rows of neighbours that are parallel, or share a point, by place."""
        found, n, holds = list[tuple[int, ...]](), len(self.names), self._meet if meet else self._parallel
        for first in range(n):
            ends = [end for end in range(first + 2, n + 1) if holds(range(first, end))]
            row = tuple(range(first, max(ends, default=first)))
            found += [] if any({*row} <= {*other} for other in [*found, ()]) else [row]
        return found

    def _parallel(self, row: Sequence[int]) -> bool:
        return all(np.linalg.norm(np.cross(self.h[row[0]], self.h[k])) < SAME for k in row)

    def _meet(self, row: Sequence[int]) -> bool:
        parallel = any(self._parallel(pair) for pair in pairwise(row))
        return not row or (not parallel and self._crossing(row)[1] <= SAME * max(1.0, self.size))

    def _crossing(self, row: Sequence[int]) -> tuple[Array, float]:
        """Return the point that is next to axes, no neighbours of them parallel, and how far it is from them."""
        h, c = self.h[list(row)], self.c[list(row)]
        across = np.eye(3) - h[:, :, None] * h[:, None, :]
        x = np.linalg.solve(across.sum(axis=0), np.einsum("nij,nj->i", across, c))
        return x, float(np.abs(np.einsum("nij,nj->ni", across, x - c)).max())


def arm_of(scene: Scene, point: str, held: Mapping[str, float] | None = None) -> Arm:
    """Return the arm that moves a point or a body, of coordinates that are not held.

    Raises:
        SimulateError: there is none, with every reason.
    """
    held, known, w = held or {}, opened(scene).values, Workspace(scene)
    if scene.is_constrained:
        raise SimulateError(
            f"{scene.name}: its loops and rows have no closed form of inverse kinematics; without a branch, a path is "
            f"followed from a start ({argument('start')})"
        )
    q = {symbol: float(held.get(name, 0.0)) for name, symbol in zip(scene.coordinates, w.state.q, strict=True)}
    at = q | {w.graph.symbol(name): x for name, x in known.items()}
    T, J = (np.array(evaluate(derive_one(w, f"{what}:{point}").entries, Floats(), at)) for what in ("pose", "jacobian"))
    T, columns = T.reshape(3, 4), dict(zip(scene.velocities, J.reshape(6, -1).T, strict=True))
    joints = joints_below(scene, point)
    moved = {joint: joint.coupling.coordinates if joint.coupling else joint.coordinates for joint in joints}
    loose = [joint for joint, names in moved.items() if any(name not in held for name in names)]
    faults = [
        f"{scene.name}: {joint.name} {why}, which has no closed form here; hold it, as in "
        f"{argument('motion', dict.fromkeys(moved[joint], 0.3))}"
        for joint in loose
        if (why := _why_not(joint, columns))
    ]
    if faults or not loose:
        raise SimulateError(faults or f"{scene.name}: nothing that is not held moves {point}")
    names = tuple(joint.coordinates[0] for joint in loose)
    v, h = np.split(np.array([columns[velocity_name(name)] for name in names]), 2, axis=1)
    return Arm(point, names, h, T[:, 3] - np.cross(v, h), T[:, :3], T[:, 3])


def _why_not(joint: Joint, columns: Mapping[str, Array]) -> str:
    """Return why a joint is none of an arm, "" where it turns about an axis."""
    if joint.coupling is not None:
        return f"follows {', '.join(joint.coupling.coordinates)}"
    if joint.motion is not None:
        return "moves by a law of the scene"
    if len(joint.coordinates) != 1 or velocity_name(joint.coordinates[0]) not in columns:
        return f"is {joint.type}, of {len(joint.coordinates)} coordinates"
    v, w = np.split(columns[velocity_name(joint.coordinates[0])], 2)
    return "" if abs(float(w @ w) - 1.0) < SAME and abs(float(v @ w)) < SAME else f"is {joint.type}"
