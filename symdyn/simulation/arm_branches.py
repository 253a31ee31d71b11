"""Closed forms of inverse kinematics: all branches of an arm at a pose, the function `inverse_kinematics`.

EAIK takes an arm's axes apart (serial_arm.py) and solves it by canonical subproblems. What it returns is held against
the pose and the Jacobian that are derived here:

    T        pose that is asked for           r(q)     [p - p*; rotation vector of R R*ᵀ], m and rad
    J        [v; ω] = J q̇ of the frame        σ        smallest singular value of J over the largest, lengths over the arm's

Where no exact solution of a subproblem exists it has a least-squares one, and says so. That is no branch; but where a
posture is singular a branch is behind it: Newton's method goes there, q - J⁺ r, and a posture that can move without the
frame is then moved next to the start.

Reference: Ostermeier, Kuelz and Althoff, Automatic geometric decomposition for analytical inverse kinematics, IEEE
Robotics and Automation Letters 10 (2025) 9964; Elias and Wen, IK-Geo, Mechanism and Machine Theory 209 (2025) 105971.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import argument, suggesting
from symdyn.dynamics import Workspace, derive_one
from symdyn.errors import SimulateError
from symdyn.extras import install
from symdyn.rounding import in_digits
from symdyn.scene import Scene, SceneLike
from symdyn.scene.values import Faults, velocity_name
from symdyn.shown import Shown
from symdyn.simulation.equations.compiled_routines import compiled, compiled_once, opened
from symdyn.simulation.following import shortest
from symdyn.simulation.initial import Start, Values
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.formulas_in_time import number_of, parameter_values
from symdyn.simulation.prescribed.forces import SceneMotion, read_motion
from symdyn.simulation.prescribed.point_path import PathRequest, ScenePath, read_path, rotation_vector
from symdyn.simulation.problem import Problem
from symdyn.simulation.serial_arm import Arm, arm_of
from symdyn.table import Table

EXACT = 1e-10
"""Pose error of a branch at most, rad, and m over the arm's size."""

SINGULAR = 1e-6
"""σ below it."""

ALIKE = 1e-6
"""rad, within which two branches are one."""

STEPS, WIDEST = 40, 0.5
"""Of Newton's method: how many, and how far one goes, rad."""

MOVES = 1e-3
"""Parts of a motion that are not told."""

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Branches(Shown):
    """The postures in which an arm has a pose: those within limits first, and of them the one nearest to the start.

    Attributes:
        scene: the mechanism.
        arm: its axes.
        q: coordinates, shape (k, nq); those that are held or do not move the frame are as they start.
        error: by how much each misses the pose, m and rad, shape (k, 2), from the scene's own forward kinematics.
        within: whether each is within the limits of the joints, shape (k,).
        singular: whether its Jacobian has lost rank, shape (k,).
        notes: what is to be said: which joints move without the frame, and of solutions that are none.
    """

    scene: Scene
    arm: Arm
    q: Array
    error: Array
    within: Bools
    singular: Bools
    notes: tuple[str, ...]
    _solver: Solver = field(repr=False)
    _start: Array = field(repr=False)

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        return f"<Branches of {self.scene.name}: {len(self.q)} postures of {self.arm.point}>"

    def chosen(self, branch: int) -> Array:
        """Return the coordinates of a branch, the first is 1, shape (nq,).

        Raises:
            SimulateError: there is none of this number.
        """
        if not 1 <= branch <= len(self.q):
            many = f"branches 1 to {len(self.q)}" if len(self.q) > 1 else "branch 1 alone"
            raise SimulateError(f"branch {branch}: {self.arm.point} has {many} there; 1 is next to the start")
        return np.asarray(self.q[branch - 1])

    def at(self, pose: Array, start: Array | None = None) -> Branches:
        """Return those of another pose, of the same arm.

        Args:
            pose: [R p] in ground axes, shape (3, 4) or (4, 4).
            start: coordinates, shape (nq,), next to which a branch is first; None for the start of these.

        Raises:
            SimulateError: it is out of reach, or no pose.
        """
        T = np.asarray(pose, dtype=np.float64)
        if T.shape not in ((3, 4), (4, 4)) or not np.allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-9):
            raise SimulateError(f"pose: an array of shape {T.shape} is none; give [R p], R a rotation, shape (4, 4)")
        return self._solver.branches(T[:3, :3], T[:3, 3], self._start if start is None else np.asarray(start))

    @property
    def table(self) -> Table[object]:
        """A row a branch: its number, the angles, what is left, and what is to be known of it."""
        places = [self.scene.coordinates.index(name) for name in self.arm.names]
        rows: list[tuple[object, ...]] = []
        for k, (q, error) in enumerate(zip(self.q, self.error, strict=True)):
            said = ["singular"] * bool(self.singular[k]) + ["beyond limits"] * (not self.within[k])
            left = in_digits(float(error.max()), 2)
            rows.append((str(k + 1), *(in_digits(float(x), 9) for x in q[places].round(12) + 0.0), left, ", ".join(said)))
        title = f"{self.arm.point}: {self.arm.verdict}"
        return Table(("branch", *self.arm.names, "pose error", ""), rows, range(2 + len(places)), title)

    def as_json(self) -> dict[str, Any]:
        """Return it as numbers and text."""
        told = {"q": self.q.tolist(), "error": self.error.tolist(), "within": self.within.tolist()}
        told |= {"singular": self.singular.tolist(), "notes": list(self.notes)}
        return {"point": self.arm.point, "names": list(self.arm.names), "family": self.arm.verdict, **told}


class Solver:
    """An arm of a scene, what solves it, and what its solutions are held against."""

    def __init__(self, scene: Scene, point: str, held: Mapping[str, float]) -> None:
        """Take an arm; errors as of `arm_of`, and where it has no closed form or EAIK is not there."""
        arm = arm_of(scene, point, held)
        n = len(arm.names)
        if n > 6 or (n == 6 and not arm.family):
            law = argument("motion", {(arm.holding or arm.names)[0]: 0.3})
            more = f"; give laws of {n - 6} of them, such as {law}" if n > 6 else ""
            raise SimulateError(f"{scene.name}: {point}: {arm.verdict}{more}")
        self.scene, self.arm, self._raw = scene, arm, _eaik(arm.placed())
        self.places = [scene.coordinates.index(name) for name in arm.names]
        self.held = {scene.coordinates.index(name): x for name, x in held.items()}
        self._rates = [scene.velocities.index(velocity_name(name)) for name in arm.names]
        found = opened(scene)
        made = compiled_once(("pose", found.scene, point), lambda: _compiled(found.scene, point))
        self._calls = made.at(found.values)
        self._pose, self._jacobian = (next(one for one in self._calls if one.startswith(x)) for x in ("pose", "jac"))
        self.limits = _limits(scene, arm)
        self.size = max(arm.size, SINGULAR)

    def pose(self, q: Array) -> Array:
        """Return [R p], shape (..., 3, 4)."""
        return np.asarray(self._calls[self._pose](q)).reshape(*q.shape[:-1], 3, 4)

    def jacobian(self, q: Array) -> Array:
        """Return J of the arm's angles, lengths over its size, shape (..., 6, n)."""
        J = np.asarray(self._calls[self._jacobian](q))
        J = np.broadcast_to(J, (*q.shape[:-1], 6, len(self.scene.velocities)))[..., self._rates].copy()
        J[..., :3, :] /= self.size
        return J

    def missed(self, q: Array, R: Array, p: Array) -> Array:
        """Return r, shape (..., 6)."""
        T = self.pose(q)
        return np.concatenate([T[..., 3] - p, rotation_vector(T[..., :3] @ R.T)], axis=-1)

    def branches(self, R: Array, p: Array, start: Array) -> Branches:
        """Return all of them; SimulateError where there is none, with how far away the pose is."""
        start = start.copy()
        for k, x in self.held.items():
            start[k] = x
        solved, least = self._raw(R, p)
        q = np.repeat(start[None], max(1, len(solved)), axis=0)
        q[: len(solved), self.places] = solved.reshape(len(solved), -1)
        missed, sigma = self.missed(q, R, p), self._sigma(q)
        if (self._exact(missed) & (sigma > SINGULAR)).all():
            return self._told(q, missed, sigma, start, ())
        mended = [self._mended(one, R, p, start, float(s)) for one, s in zip(q, sigma, strict=True)]
        good = [one for one in mended if one is not None]
        if not good:
            raise SimulateError(self._out_of_reach(q, R, p, start))
        left, notes = int(least.sum()) - int((least & [one is not None for one in mended]).sum()), list[str]()
        if left:
            notes.append(f"{left} least-squares solution{'s' * (left > 1)} of EAIK are no branches and left out")
        kept: list[Array] = []
        for one in good:
            if all(np.abs(_turned(one - other)[self.places]).max() > ALIKE for other in kept):
                kept.append(one)
        q = np.array(kept)
        return self._told(q, self.missed(q, R, p), self._sigma(q), start, tuple(notes))

    def _told(self, q: Array, missed: Array, sigma: Array, start: Array, notes: tuple[str, ...]) -> Branches:
        """Return branches in order, each angle next to the start, or at least within limits."""
        x, near = q[:, self.places], start[self.places]
        low, high = self.limits
        x = near + _turned(x - near)
        x = x + 2 * np.pi * np.maximum(0.0, np.ceil((low - x) / (2 * np.pi) - EXACT))
        x = x - 2 * np.pi * np.maximum(0.0, np.ceil((x - high) / (2 * np.pi) - EXACT))
        within = ((x >= low - EXACT) & (x <= high + EXACT)).all(axis=1)
        x = np.where(within[:, None], x, near + _turned(x - near))
        far = np.linalg.norm(x - near, axis=1)
        order = sorted(range(len(x)), key=lambda k: (not within[k], round(float(far[k]), 9), *x[k].round(9).tolist()))
        q = q.copy()
        q[:, self.places] = x
        q, within, bad = q[order], within[order], sigma[order] < SINGULAR
        error = np.linalg.norm(missed[order].reshape(-1, 2, 3), axis=2)
        said = [f"branch {k + 1} is singular: {self._free(q[k])}" for k in np.flatnonzero(bad)]
        return Branches(self.scene, self.arm, q, error, within, bad, (*said, *notes), self, start)

    def _mended(self, q: Array, R: Array, p: Array, start: Array, sigma: float) -> Array | None:
        """Return the branch behind a solution; of a family that moves without the frame, next to the start."""
        found = self._settled(q, R, p)
        if found is None or float(self._sigma(found[None])[0]) > SINGULAR:
            return found
        for _ in range(STEPS):
            free = np.linalg.svd(self.jacobian(found))[2][-1]
            way = np.zeros(len(q))
            way[self.places] = free * (free @ _turned(start - found)[self.places])
            if np.abs(way).max() < ALIKE:
                break
            moved = self._settled(found + way * min(1.0, WIDEST / np.abs(way).max()), R, p)
            if moved is None or np.abs(moved - found).max() < ALIKE:
                break
            found = moved
        return found

    def _settled(self, q: Array, R: Array, p: Array) -> Array | None:
        """Return where Newton's method ends from q, None where that is not the pose."""
        q, r = q.copy(), self.missed(q, R, p)
        for _ in range(STEPS):
            if np.abs(r).max() < EXACT * 1e-4:
                break
            scaled = np.concatenate([r[:3] / self.size, r[3:]])
            step = -shortest(self.jacobian(q), scaled)
            tried = q.copy()
            tried[self.places] += step * min(1.0, WIDEST / float(np.abs(step).max(initial=WIDEST)))
            left = self.missed(tried, R, p)
            if not np.abs(left).max() < np.abs(r).max():
                break
            q, r = tried, left
        return q if self._exact(r[None])[0] else None

    def _out_of_reach(self, q: Array, R: Array, p: Array, start: Array) -> str:
        """Return by how much the nearest posture misses a pose: least squares from every solution and the start."""
        from scipy.optimize import least_squares

        def off(x: Array) -> Array:
            at = start.copy()
            at[self.places] = x
            r = self.missed(at, R, p)
            return np.concatenate([r[:3] / self.size, r[3:]])

        ends = [least_squares(off, one[self.places]) for one in (*q, start)]
        best = min(ends, key=lambda end: float(end.cost))
        gap, turn = (float(np.linalg.norm(x)) for x in np.split(best.fun, 2))
        gap = self.scene.in_shown_unit(f"{gap * self.size:.6g}", "m")
        angles = ", ".join(f"{name} = {x:.6g}" for name, x in zip(self.arm.names, best.x, strict=True))
        place = ", ".join(f"{x:.6g}" for x in p)
        return (
            f"{self.arm.point}: the pose is out of reach: at {angles}, where it is nearest in least squares, it misses "
            f"({place}) by {gap} and its turning by {turn:.6g} rad; give a pose nearer to where it can be"
        )

    def _free(self, q: Array) -> str:
        """Return what can move without the frame."""
        free = np.abs(np.linalg.svd(self.jacobian(q))[2][-1])
        names = [name for name, x in zip(self.arm.names, free, strict=True) if x > MOVES * free.max()]
        return f"{', '.join(names)} can move without {self.arm.point}"

    def _exact(self, r: Array) -> Bools:
        sizes = np.abs(r).reshape(-1, 2, 3).max(axis=2)
        return (sizes[:, 0] <= EXACT * max(1.0, self.size)) & (sizes[:, 1] <= EXACT)

    def _sigma(self, q: Array) -> Array:
        values = np.linalg.svd(self.jacobian(q), compute_uv=False)
        return np.asarray(values[:, -1] / np.maximum(values[:, 0], SINGULAR))


def _turned(x: Array) -> Array:
    """Return angles within half a turn."""
    return x - 2 * np.pi * np.round(x / (2 * np.pi))


def _eaik(arm: Arm) -> Callable[[Array, Array], tuple[Array, Bools]]:
    """Return what gives solutions at a pose, shape (k, n), and which of them are least squares; of EAIK."""
    try:
        from eaik.IK_HP import HPRobot
    except ImportError:
        raise SimulateError(f"closed forms of inverse kinematics need EAIK: {install('ik')}") from None
    robot = HPRobot(arm.h, np.diff(np.vstack([np.zeros(3), arm.c, arm.p]), axis=0))
    if not robot.hasKnownDecomposition():
        raise SimulateError(f"{arm.point}: EAIK has no closed form of this arm ({robot.getKinematicFamily()})")

    def solved(R: Array, p: Array) -> tuple[Array, Bools]:
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R @ arm.R.T, p
        try:
            found = robot.IK(T)
        except RuntimeError as error:
            raise SimulateError(f"{arm.point}: EAIK: {error}") from None
        n = len(arm.names)
        return np.asarray(found.Q, dtype=np.float64).reshape(-1, n), np.asarray(found.is_LS, dtype=bool).reshape(-1)

    return solved


def _compiled(scene: Scene, point: str) -> Any:
    w = Workspace(scene)
    return compiled(w.scene, w.graph, [derive_one(w, f"{name}:{point}") for name in ("pose", "jacobian")])


def _limits(scene: Scene, arm: Arm) -> tuple[Array, Array]:
    """Return the lowest and highest angles, rad, shape (n,) each; infinite where there is no limit."""
    values, faults = parameter_values(scene), Faults("")
    joints = {joint.coordinate: joint for joint in scene.joints}
    found = [(joints[name].limits.lower, joints[name].limits.upper) for name in arm.names]
    low, high = (
        np.array([end if x is None else number_of(x, values, "limits", faults) for x in some], dtype=np.float64)
        for some, end in zip(zip(*found, strict=True), (-np.inf, np.inf), strict=True)
    )
    faults.close(SimulateError)
    return low, high


def wanted(path: ScenePath, t: float) -> tuple[str, PathRequest]:
    """Return the frame whose whole pose a path asks for, and what that is at a time; SimulateError where it does not."""
    if len(path.points) != 1:
        raise SimulateError(f"path: a branch is one of a frame with a path; {len(path.points)} have one")
    (one,) = path.points
    asked = one.at(t)
    if not np.isfinite(asked.origin).all() or asked.axes is None or asked.axis is not None:
        raise SimulateError(
            f"path: {one.name}: a closed form takes a whole pose; give x, y, z and rpy(roll, pitch, yaw) or "
            "quaternion(w, x, y, z)"
        )
    return one.name, asked


def branches_of(scene: Scene, path: ScenePath, held: Mapping[str, float], start: Array, t: float) -> Branches:
    """Return the branches at a time of a path; errors as of `inverse_kinematics`."""
    point, asked = wanted(path, t)
    assert asked.axes is not None, "it is a whole pose"
    return Solver(scene, point, held).branches(asked.axes, asked.origin, start)


@suggesting
def inverse_kinematics(
    scene: SceneLike | Problem,
    path: ScenePath | Entries,
    motion: SceneMotion | Entries = (),
    start: Values | None = None,
    values: Mapping[str, object] | None = None,
    time: float = 0.0,
) -> Branches:
    """Return all postures in which an arm has a pose, by closed forms of EAIK, each held against the scene's own pose.

    >>> import symdyn
    >>> arm = symdyn.example("scara")
    >>> symdyn.inverse_kinematics(arm, "tool=0.4, 0.2, 0.1, rpy(0, 0, 0)")
    Traceback (most recent call last):
    ...
    symdyn.errors.SimulateError: scara: stroke is prismatic, which has no closed form here; hold it, as in motion={"q3": 0.3}

    Args:
        scene: an arm, a chain of joints that turn; its parameters bound; or a `Problem`, without start rates.
        path: the pose of a point or a body in ground axes, as `inverse` takes it: "tool=x, y, z, rpy(a, b, c)".
        motion: coordinates that are held where their laws are then: of the joints beyond six, and of those that slide.
        start: coordinates, such as "q1=0.3,q2=pi/2", in place of the scene's: the branch next to it is the first.
        values: of parameters, in place of those that the scene gives.
        time: at which path and motion are looked at, s.

    Raises:
        SimulateError: the arm has no closed form, which says why; the pose is out of reach, by how much; EAIK is missing.
        SceneError: a value that the scene cannot have, or of no parameter.
    """
    problem, _ = Problem.requested(inverse_kinematics, locals())
    scene = problem.refused("a posture has none", "start_rates", "forces").scene
    motion = motion if isinstance(motion, SceneMotion) else read_motion(scene, motion)
    path = path if isinstance(path, ScenePath) else read_path(scene, path)
    held = {name: float(law(np.array([time]))[0][0]) for name, law in motion.laws.items()}
    return branches_of(scene, path, held, Start.guess(scene, problem.start), time)
