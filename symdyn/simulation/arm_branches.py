"""Closed forms of inverse kinematics: all branches of an arm at a pose, the function `inverse_kinematics`.

An arm that has the output `inverse_kinematics` is solved by its code, others by EAIK's subproblems, from their axes
(serial_arm.py). What they return is held against the pose and the Jacobian that are derived from the scene:

    r(q)     [p - p*; rotation vector of R R*ᵀ], of the pose that is asked for, R* and p*; lengths over the arm's size
    J        [v; ω] = J q̇ of the frame, likewise; σ its smallest singular value over the largest

Where no exact solution of a subproblem exists EAIK has a least-squares one, and says so. That is no branch; but where a
posture is singular a branch is behind it: Newton's method goes there, q - J⁺ r, and a posture that can move without the
frame is then moved next to the start.

Reference: Elias and Wen, IK-Geo, Mechanism and Machine Theory 209 (2025) 105971; EAIK's in serial_arm.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import argument, check_arguments, suggesting
from symdyn.dynamics import Workspace, derive_one
from symdyn.errors import DerivationError, SimulateError
from symdyn.extras import install
from symdyn.frozen import dataclass, field
from symdyn.program import identifier
from symdyn.rounding import in_digits
from symdyn.scene import Scene, SceneLike
from symdyn.scene.values import Faults, velocity_name
from symdyn.shown import Shown
from symdyn.simulation.equations.compiled_routines import compiled, compiled_once, opened
from symdyn.simulation.following import shortest
from symdyn.simulation.initial import Start, Values
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.forces import SceneMotion, read_motion
from symdyn.simulation.prescribed.formulas_in_time import number_of, parameter_values
from symdyn.simulation.prescribed.point_path import ScenePath, read_path
from symdyn.simulation.problem import Problem
from symdyn.simulation.serial_arm import SAME, Arm, arm_of
from symdyn.table import Table

EXACT, ALIKE = 1e-10, 1e-6
"""Entries of r at a branch, at most; rad, within which two branches are one."""

SINGULAR, MOVES = 1e-6, 1e-3
"""σ below it; parts of the motion without the frame, below which they are not told."""

STEPS, WIDEST = 40, 0.5
"""Of Newton's method: how many, and how far one goes, rad."""

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
        notes: which joints can move without the frame, and what was left out.
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

    def __repr__(self) -> str:
        return f"<Branches of {self.scene.name}: {len(self.q)} postures of {self.arm.point}>"

    def chosen(self, branch: int) -> Array:
        """Return the coordinates of a branch, from 1 on, shape (nq,); SimulateError where there is none so called."""
        check_arguments(Branches.chosen, locals(), SimulateError)
        if not 1 <= branch <= len(self.q):
            many = f"branches 1 to {len(self.q)}" if len(self.q) > 1 else "branch 1 alone"
            raise SimulateError(f"branch {branch}: {self.arm.point} has {many} there; 1 is next to the start")
        return np.asarray(self.q[branch - 1])

    def at(self, pose: npt.ArrayLike, start: npt.ArrayLike | None = None) -> Branches:
        """Return those of another pose [R p], shape (3, 4) or (4, 4); SimulateError where it is out of reach, or none.

        The branch next to `start`, coordinates of shape (nq,), is the first; None takes the start of these.
        """
        try:
            T, near = (np.array(one, dtype=np.float64) for one in (pose, self._start if start is None else start))
        except (TypeError, ValueError, OverflowError):  # no numbers
            T = near = np.zeros(0)
        turns = T.shape in ((3, 4), (4, 4)) and np.abs(T[:3, :3] @ T[:3, :3].T - np.eye(3)).max() < SAME
        turns = bool(turns and np.linalg.det(T[:3, :3]) > 0)  # not a mirror image
        if not (turns and near.shape == self._start.shape and np.isfinite([*T.flat, *near]).all()):
            raise SimulateError(
                f"pose, start: arrays of shapes {T.shape}, {near.shape} are none; give [R p], R a rotation, shape "
                f"(4, 4), and coordinates, shape {self._start.shape}"
            )
        return self._solver.branches(T[:3, :3], T[:3, 3], near)

    @property
    def table(self) -> Table[str]:
        """A row a branch: its number, the angles, the largest error, and what is to be known of it."""
        places, rows = [self.scene.coordinates.index(name) for name in self.arm.names], []
        for k, (q, error) in enumerate(zip(self.q, self.error, strict=True)):
            said = ["singular"] * bool(self.singular[k]) + ["beyond limits"] * (not self.within[k])
            angles = [in_digits(float(x), 9) for x in q[places].round(12) + 0.0]
            rows.append((str(k + 1), *angles, in_digits(float(error.max()), 2), ", ".join(said)))
        heads = ("branch", *self.arm.names, "pose error", "")
        return Table(heads, rows, range(2 + len(places)), f"{self.arm.point}: {self.arm.verdict}")

    def as_json(self) -> dict[str, Any]:
        """Return it as numbers and text."""
        told = {name: getattr(self, name).tolist() for name in ("q", "error", "within", "singular")}
        said = {"point": self.arm.point, "names": list(self.arm.names), "family": self.arm.verdict}
        return {**said, **told, "notes": list(self.notes)}


class Solver:
    """An arm of a scene, what solves it, and what its solutions are held against."""

    def __init__(self, scene: Scene, point: str, held: Mapping[str, float]) -> None:
        """Take an arm; errors as of `arm_of`, and where it has no closed form or EAIK is not there."""
        self._made_of, arm = (scene, point, held), arm_of(scene, point, held)
        n = len(arm.names)
        if n > 6 or (n == 6 and not arm.family):
            law = argument("motion", {(arm.holding or arm.names)[0]: 0.3})
            more = f"; give laws of {n - 6} of them, such as {law}" if n > 6 else ""
            raise SimulateError(f"{scene.name}: {point}: {arm.verdict}{more}")
        self.scene, self.arm, self.size = scene, arm, max(arm.size, SINGULAR)
        self.places = [scene.coordinates.index(name) for name in arm.names]
        self.held = {scene.coordinates.index(name): x for name, x in held.items()}
        self._rates = [scene.velocities.index(velocity_name(name)) for name in arm.names]
        limits, values = {joint.coordinate: joint.limits for joint in scene.joints}, parameter_values(scene)
        ends = [((limits[x].lower, -np.inf), (limits[x].upper, np.inf)) for x in arm.names]
        found = [[end if x is None else number_of(x, values, "limits", Faults("")) for x, end in one] for one in ends]
        self.low, self.high = np.array(found, dtype=np.float64).T
        free = opened(scene)
        w, names = Workspace(free.scene), [f"pose:{point}", f"jacobian:{point}", f"inverse_kinematics:{point}"]
        if n < 6 or not _is_derived(w, names[2]):
            del names[2]
            self._solved = _eaik(arm.placed())
        make = lambda: compiled(w.scene, w.graph, [derive_one(w, name) for name in names])  # noqa: E731
        calls = compiled_once(("pose", free.scene, point, *names), make).at(free.values)
        self._pose, self._jacobian, *own = (calls[identifier(name)] for name in names)
        if own:
            self._solved = _derived(own[0], self.places)

    def __reduce__(self) -> tuple[Any, ...]:
        return Solver, self._made_of

    def jacobian(self, q: Array) -> Array:
        """Return J of the arm's angles, shape (..., 6, n)."""
        J = np.broadcast_to(self._jacobian(q), (*q.shape[:-1], 6, len(self.scene.velocities)))[..., self._rates].copy()
        J[..., :3, :] /= self.size
        return J

    def missed(self, q: Array, R: Array, p: Array) -> Array:
        """Return r, shape (..., 6)."""
        T = np.broadcast_to(self._pose(q), (*q.shape[:-1], 3, 4))
        return np.concatenate([(T[..., 3] - p) / self.size, _rotation_vectors(T[..., :3] @ R.T)], axis=-1)

    def branches(self, R: Array, p: Array, start: Array) -> Branches:
        """Return all of them; SimulateError where there is none, with how far away the pose is."""
        start = np.array(start, dtype=np.float64)
        start[[*self.held]] = [*self.held.values()]
        solved, least = self._solved(R, p)
        q = np.repeat(start[None], len(solved), axis=0)
        q[:, self.places] = solved
        missed, sigma = self.missed(q, R, p), self._sigma(q)
        if len(q) and np.abs(missed).max() <= EXACT and sigma.min() > SINGULAR:
            return self._told(q, missed, sigma, start, 0)
        mended, kept = [self._mended(one, R, p, start) for one in q], list[Array]()
        for one in mended:
            if one is not None and all(np.abs(_turned(one - x)[self.places]).max() > ALIKE for x in kept):
                kept.append(one)
        if not kept:
            raise SimulateError(self._out_of_reach(np.vstack([q, start]), R, p))
        left = sum(bool(flag) and one is None for flag, one in zip(least, mended, strict=True))
        q = np.array(kept)
        return self._told(q, self.missed(q, R, p), self._sigma(q), start, left)

    def _told(self, q: Array, missed: Array, sigma: Array, start: Array, left: int) -> Branches:
        """Return branches in order, each angle next to the start, or at least within limits."""
        turn, near = 2 * np.pi, start[self.places]
        x = nearest = near + _turned(q[:, self.places] - near)
        x = x + turn * np.maximum(0.0, np.ceil((self.low - x) / turn - EXACT))
        x = x - turn * np.maximum(0.0, np.ceil((x - self.high) / turn - EXACT))
        within = np.asarray(((x >= self.low - EXACT) & (x <= self.high + EXACT)).all(axis=1))
        q[:, self.places] = x = np.where(within[:, None], x, nearest)
        keys = np.column_stack([~within, np.linalg.norm(x - near, axis=1), x]).round(9).tolist()
        order = sorted(range(len(q)), key=keys.__getitem__)
        q, within, bad, said = q[order], within[order], sigma[order] < SINGULAR, list[str]()
        error = np.linalg.norm(missed[order].reshape(-1, 2, 3), axis=2) * [self.size, 1.0]
        for k in np.flatnonzero(bad):
            free = np.abs(self._free(q[k]))
            names = [name for name, part in zip(self.arm.names, free, strict=True) if part > MOVES * free.max()]
            said.append(f"branch {k + 1} is singular: {', '.join(names)} can move without {self.arm.point}")
        said += [f"least-squares solutions of EAIK that miss the pose are left out: {left}"] * bool(left)
        said += ["no branch is within the limits of the joints"] * (not within.any())
        return Branches(self.scene, self.arm, q, error, within, bad, tuple(said), self, start)

    def _mended(self, q: Array, R: Array, p: Array, start: Array) -> Array | None:
        """Return the branch behind a solution; of a family that moves without the frame, the one next to the start."""
        found = self._settled(q, R, p)
        for _ in range(STEPS):
            if found is None or self._sigma(found) > SINGULAR:
                break
            free, way = self._free(found), np.zeros(len(q))
            way[self.places] = free * (free @ _turned(start - found)[self.places])
            moved = self._settled(found + way * min(1.0, WIDEST / max(WIDEST, np.abs(way).max())), R, p)
            if moved is None or np.abs(moved - found).max() < ALIKE:
                break
            found = moved
        return found

    def _settled(self, q: Array, R: Array, p: Array) -> Array | None:
        """Return where Newton's method ends from q, None where that is not the pose."""
        r = self.missed(q, R, p)
        for _ in range(STEPS):
            step = -shortest(self.jacobian(q), r)
            tried = q.copy()
            tried[self.places] += step * min(1.0, WIDEST / max(WIDEST, np.abs(step).max()))
            left = self.missed(tried, R, p)
            if np.abs(r).max() < EXACT**1.5 or not np.abs(left).max() < np.abs(r).max():
                break
            q, r = tried, left
        return q if np.abs(r).max() <= EXACT else None

    def _out_of_reach(self, guesses: Array, R: Array, p: Array) -> str:
        """Return by how much the posture misses a pose that is nearest in least squares, from every guess."""
        from scipy.optimize import least_squares

        def off(x: Array, q: Array) -> Array:
            q[self.places] = x
            return self.missed(q, R, p)

        ends = [least_squares(off, one[self.places], args=(one,)) for one in guesses]
        best = min(ends, key=lambda end: float(end.cost))
        far, turn = (float(np.linalg.norm(x)) for x in np.split(best.fun, 2))
        angles = ", ".join(f"{name} = {x:.6g}" for name, x in zip(self.arm.names, best.x, strict=True))
        gap, place = self.scene.in_shown_unit(f"{far * self.size:.6g}", "m"), ", ".join(f"{x:.6g}" for x in p)
        return (
            f"{self.arm.point}: the pose is out of reach: at {angles}, where it is nearest in least squares, it "
            f"misses ({place}) by {gap} and its turning by {turn:.6g} rad; give a pose nearer to where it can be"
        )

    def _free(self, q: Array) -> Array:
        """Return the motion that moves the frame least."""
        return np.asarray(np.linalg.svd(self.jacobian(q))[2][-1])

    def _sigma(self, q: Array) -> Array:
        values = np.linalg.svd(self.jacobian(q), compute_uv=False)
        return np.asarray(values[..., -1] / np.maximum(values[..., 0], SINGULAR))


def _turned(x: Array) -> Array:
    """Return angles within half a turn."""
    return x - 2 * np.pi * np.round(x / (2 * np.pi))


def _rotation_vectors(R: Array) -> Array:
    """Return those of rotations, shape (..., 3), about any axis at a half turn; SciPy's takes ten times as long."""
    s = (R[..., [2, 0, 1], [1, 2, 0]] - R[..., [1, 2, 0], [2, 0, 1]]) / 2
    sine = np.sqrt((s * s).sum(axis=-1, keepdims=True))
    angle = np.arctan2(sine, (np.trace(R, axis1=-2, axis2=-1)[..., None] - 1) / 2)
    some = s * angle / np.maximum(sine, 1e-300)
    return np.asarray(np.where((sine > ALIKE) | (angle < 1), some, angle * np.eye(3)[0]))


def _is_derived(w: Workspace, request: str) -> bool:
    with suppress(DerivationError):
        return bool(derive_one(w, request))
    return False


def _derived(call: Callable[[Array], Array], places: Sequence[int]) -> Callable[[Array, Array], tuple[Array, Bools]]:
    """Return what gives solutions at a pose as `_eaik` does, of an arm that has the output."""

    def solved(R: Array, p: Array) -> tuple[Array, Bools]:
        with np.errstate(invalid="ignore"):  # out of reach
            found = call(np.column_stack([R, p]).ravel())[:, places]
        found = found[~np.isnan(found).any(axis=1)]
        return found, np.zeros(len(found), dtype=bool)

    return solved


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
        found = robot.IK(T)
        return np.reshape(found.Q, (-1, len(arm.names))), np.asarray(found.is_LS, dtype=bool).reshape(-1)

    return solved


def branches_of(scene: Scene, path: ScenePath, held: Mapping[str, float], start: Array, t: float) -> Branches:
    """Return the branches at a time of a path; errors as of `inverse_kinematics`."""
    if len(path.points) != 1:
        raise SimulateError(f"path: a branch is one of a frame with a path; {len(path.points)} have one")
    (one,) = path.points
    asked = one.at(t)
    if not np.isfinite(asked.origin).all() or asked.axes is None or asked.axis is not None:
        whole = "x, y, z and rpy(roll, pitch, yaw) or quaternion(w, x, y, z)"
        raise SimulateError(f"path: {one.name}: a closed form takes a whole pose; give {whole}")
    return Solver(scene, one.name, held).branches(asked.axes, asked.origin, start)


@suggesting
def inverse_kinematics(
    scene: SceneLike | Problem,
    path: ScenePath | Entries,
    motion: SceneMotion | Entries = (),
    start: Values | None = None,
    values: Mapping[str, object] | None = None,
    time: float = 0.0,
) -> Branches:
    """Return all postures in which an arm has a pose, by closed forms, each held against the scene's own pose.

    >>> import symdyn
    >>> arm = symdyn.example("scara")
    >>> symdyn.inverse_kinematics(arm, "tool=0.4, 0.2, 0.1, rpy(0, 0, 0)")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    symdyn.errors.SimulateError: scara: stroke is prismatic, which has no closed form here; hold it, as in ...

    Args:
        scene: an arm, a chain of joints that turn; its parameters bound; or a `Problem`, without start rates.
        path: the pose of a point or a body in ground axes, as `inverse` takes it: "tool=x, y, z, rpy(a, b, c)".
        motion: coordinates that are held where their laws are then: of the joints beyond six, and of those that slide.
        start: coordinates, such as "q1=0.3,q2=pi/2", in place of the scene's: the branch next to it is the first.
        values: of parameters, in place of those that the scene gives.
        time: at which path and motion are looked at, s.

    Raises:
        SimulateError: the arm has no closed form, and why; the pose is out of reach, and how far; EAIK is missing.
        SceneError: a value that the scene cannot have, or of no parameter.
    """
    problem, _ = Problem.requested(inverse_kinematics, locals())
    scene = problem.refused("a posture has none", "start_rates", "forces").scene
    motion = motion if isinstance(motion, SceneMotion) else read_motion(scene, motion)
    path = path if isinstance(path, ScenePath) else read_path(scene, path)
    held = {name: float(law(np.array([time]))[0][0]) for name, law in motion.laws.items()}
    return branches_of(scene, path, held, Start.guess(scene, problem.start), time)
