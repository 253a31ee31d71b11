"""D'Alembert's method: the equilibrium of every body with its inertia forces, as one linear system for all reactions.

    j          a moving body; its reference joint is the one that carries it, e its other joints
    O_j        origin of the moved joint frame of its reference joint; frame j has its origin there, axes of the body
    F^A_jj     (5.1) bivector [force; moment about O_j] of weight, loads, and the joints' own elements, axes of frame j
    F^D_jj     (5.17) bivector of its inertia forces
    F^R_jj     (5.6) bivector of the reaction and the drive in the reference joint, which the carrying body exerts
    F*_je      (5.8)-(5.10) what the body takes from its other joint e: action = reaction, moved to O_j

    F^A_jj + F^D_jj + F^R_jj + Σ_e F*_je = 0    (5.18), for every moving body: 6 equations, 3 in the plane

Unknowns are t components a joint (5.7), (5.19), and the drives, which take the free places. They enter linearly:
A x + b = 0, A in blocks of one body and one unknown. In a tree every velocity has an unknown drive (a passive joint's
is what its motion would need); in a closed mechanism those have one that are declared to. Where it is written for
readers, idle motions that no loop needs have one too, so that there are as many unknowns as equations: theirs comes out
as zero if the motion is possible.

Its least solution is found in numbers alone, by singular values at one place after the other, so that no choice of
pivots is made beforehand that could fail at another place:

N              null space of A: self-equilibrated reactions, which no motion tells
R = T x + R⁰   the reactions of all joints, [force; moment] by joint; R⁰ what drives that are known and elements do
L              characteristic length: a moment of size M counts as a force M / L

Reference: the textbook, section 5.1.1, eq. (5.1)-(5.20).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics.loops.newton import in_words
from symdyn.dynamics.reactions.closure_equations import (
    flattened,
    independent_in_plane,
    plane,
    refuse_without_place,
    rows_of,
    taken_wrenches,
)
from symdyn.dynamics.reactions.free_bodies import Bivectors, FreeBodies, exerted_on
from symdyn.dynamics.reactions.joint_frames import PLACES, JointFrames, reactions_of
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, evaluate
from symdyn.spatial import Mat, Vec, Wrench, cross, dot

RANK = 1e-9
"""Singular values this much below the largest are zero, at positions that close the loops to the last digits."""

LOOSE = 1e-7
"""Rows of N above it are not zero, a moment counting as a force."""

Flags = np.ndarray[Any, np.dtype[np.bool_]]


@dataclass(frozen=True)
class Least:
    """The least x with A x + b = 0, as far as that can be met."""

    x: Array  # sizes of the unknowns, N or N m
    free: Flags  # which of them are not unique
    rank: int  # of A
    missed: float  # the largest part of the equilibrium that nothing balances, N
    load: float  # the largest entry of b, N
    R: Array  # reactions, shape (joints + loops, 6)
    unique: Flags  # which of their entries are, the same shape


class InNumbers:
    """A system (5.18), ready to be looked at anywhere."""

    def __init__(self, system: Equilibrium) -> None:
        hanging, self.system = system.hanging, system
        zeros = [hanging.graph.zero] * 6 * (len(hanging.joints) + len(hanging.loops))
        balance, shown = system.rows(), system.wrench_rows(zeros)
        self._size = len(balance)
        places = [(r, c) for r, row in enumerate([*balance, *shown]) for c in row]
        self._rows, self._columns = np.array(places, dtype=int).reshape(-1, 2).T
        self._entries = [entry for row in [*balance, *shown] for entry in row.values()]
        self._height = self._size + len(shown)
        self._acts = [x for one in system.unknowns for part in one.acts[0][1] for x in part]

    def matrices(self, values: Mapping[Expr, float]) -> tuple[Array, Array, Array, Array]:
        """Return A, b, T, R⁰ at values of all symbols."""
        whole = np.zeros((self._height, len(self.system.unknowns) + 1))
        whole[self._rows, self._columns] = evaluate(self._entries, Floats(), values)
        A, T = whole[: self._size], whole[self._size :]
        return A[:, :-1], -A[:, -1], T[:, :-1], -T[:, -1]

    def sizes(self, values: Mapping[Expr, float], length: float) -> tuple[Array, Array]:
        """Return what every unknown does in its own joint at unit size, shape (unknowns, 6), and its size, N."""
        acts = np.array(evaluate(self._acts, Floats(), values)).reshape(-1, 6)
        found = np.hypot(np.linalg.norm(acts[:, :3], axis=1), np.linalg.norm(acts[:, 3:], axis=1) / length)
        return acts, np.where(found > 0, found, 1.0)

    def missed(self, values: Mapping[Expr, float], R: Array, length: float) -> float:
        """Return by how much reactions, shape (6 joints,), miss, whatever the unknowns, over the largest load."""
        A, b, T, still = self.matrices(values)
        _, scales = self.sizes(values, length)
        rows = _as_forces(len(b) + len(R), length)
        whole = np.vstack([A, T]) * rows[:, None] / scales
        right = np.concatenate([-b, R - still]) * rows
        left = whole @ np.linalg.lstsq(whole, right, rcond=RANK)[0] - right
        return float(np.abs(left).max(initial=0.0)) / (float(np.abs(right).max(initial=0.0)) or 1.0)

    def least(self, values: Mapping[Expr, float], length: float) -> Least:
        """Return the least solution at values of all symbols, for a characteristic length."""
        A, b, T, still = self.matrices(values)
        _, scales = self.sizes(values, length)
        rows = _as_forces(len(b), length)
        scaled, right = (A * rows[:, None]) / scales, rows * b
        U, s, Vt = np.linalg.svd(scaled, full_matrices=True)
        rank = int((s > RANK * s.max(initial=0.0)).sum())
        y = -Vt[:rank].T @ ((U[:, :rank].T @ right) / s[:rank])
        missed = float(np.abs(scaled @ y + right).max(initial=0.0))
        N = Vt[rank:].T
        shown = (T / scales) @ N * _as_forces(len(T), length)[:, None]
        return Least(
            y / scales,
            np.linalg.norm(N, axis=1) > LOOSE,
            rank,
            missed,
            float(np.abs(right).max(initial=0.0)),
            (T @ (y / scales) + still).reshape(-1, 6),
            (np.linalg.norm(shown, axis=1) <= LOOSE).reshape(-1, 6),
        )


def _as_forces(rows: int, length: float) -> Array:
    """Return what makes rows of [force; moment] comparable: moments count as forces, shape (rows,)."""
    return np.tile([1.0] * 3 + [1.0 / length] * 3, rows // 6)


Rows = list[dict[int, Expr]]

REACTION, DRIVE, COUPLING, ROW = "reaction", "drive", "coupling", "row"


@dataclass(frozen=True)
class Unknown:
    """One unknown size of (5.18).

    Attributes:
        kind: REACTION, DRIVE, COUPLING (what keeps a joint at the ratio of another) or ROW (what keeps a scene's row).
        joint: name of the joint, or of the row.
        number: of the component among those of its kind and joint.
        acts: (number of the hinge, wrench at unit size on its child, axes of its joint frame, about P).
    """

    kind: str
    joint: str
    number: int
    acts: tuple[tuple[int, Wrench], ...]

    @property
    def is_reaction(self) -> bool:
        return self.kind == REACTION

    @property
    def is_drive(self) -> bool:
        return self.kind == DRIVE

    @property
    def is_coupling(self) -> bool:
        """Whether it keeps a joint at the ratio of another."""
        return self.kind == COUPLING


@dataclass(frozen=True)
class Equilibrium:
    """The system (5.18): A x + b = 0.

    Attributes:
        hanging: the mechanism.
        bodies: known bivectors of the moving bodies, in the order of the scene.
        unknowns: in the order of the joints, reactions before drives.
        blocks: (body, unknown) to the bivector that the unknown exerts on the body at unit size, frame j; no zeros.
        kept: components of a bivector that are written: all six, or the three of a planar mechanism.
        own: what drives that are known and the joint's own elements do, by hinge, along each of its D.
    """

    hanging: FreeBodies
    bodies: tuple[Bivectors, ...]
    unknowns: tuple[Unknown, ...]
    blocks: dict[tuple[int, int], Wrench]
    kept: tuple[int, ...]
    own: tuple[tuple[Expr, ...], ...]

    @property
    def in_numbers(self) -> InNumbers:
        """What computes the least solution at values of the state."""
        return InNumbers(self)

    @classmethod
    def of(
        cls, hanging: FreeBodies, planar: bool = False, tau: Sequence[Expr] | None = None, whole: bool = False
    ) -> Equilibrium:
        """Return the system (5.18) of a mechanism.

        Args:
            hanging: the mechanism, open or closed.
            planar: write three equations a body.
            tau: driving forces that are known, shape (nv,); None makes them unknowns.
            whole: nothing is left out and nothing added for readers: joints that close planar loops keep the components
                across the plane, which are then not unique, and idle motions have no drive.

        Raises:
            DerivationError: `planar`, and the mechanism does not move in a plane that is one of coordinates of every
                frame; or a row does not say where its force acts.
        """
        refuse_without_place(hanging.scene)
        normal = coordinate_normal(hanging) if planar else None
        kept = (0, 1, 2, 3, 4, 5) if normal is None else (*(k for k in range(3) if k != normal), 3 + normal)
        own = tuple(tuple(_own(hanging, hinge, tau)) for hinge in hanging.joints)
        bodies = hanging.bivectors(own)
        unknowns = [one for one in _unknowns(hanging, normal, whole) if tau is None or not one.is_drive]
        blocks: dict[tuple[int, int], Wrench] = {}
        for u, unknown in enumerate(unknowns):
            for h, wrench in unknown.acts:
                for j, exerted in exerted_on(hanging, hanging.hinges[h], wrench).items():
                    if not all(x.is_zero for part in exerted for x in part):
                        blocks[j, u] = blocks[j, u] + exerted if (j, u) in blocks else exerted
        return cls(hanging, bodies, tuple(unknowns), blocks, kept, own)

    @classmethod
    def for_readers(cls, hanging: FreeBodies) -> Equilibrium:
        """Return the system, three equations a body where the mechanism moves in a plane of coordinates."""
        try:
            return cls.of(hanging, planar=True)
        except DerivationError:
            return cls.of(hanging)

    def written(self, bivector: tuple[Sequence[Expr], Sequence[Expr]]) -> list[Expr]:
        """Return the components that are written."""
        entries = (*bivector[0], *bivector[1])
        return [entries[k] for k in self.kept]

    @property
    def equations(self) -> int:
        """6(u - 1) of (5.18), or 3(u - 1)."""
        return len(self.kept) * len(self.bodies)

    @property
    def reactions(self) -> int:
        """m_R of (5.19): the number of unknown reactions, what keeps couplings and rows included."""
        return sum(not unknown.is_drive for unknown in self.unknowns)

    @property
    def drives(self) -> int:
        """N of (5.20): the number of unknown drives."""
        return len(self.unknowns) - self.reactions

    @property
    def passive(self) -> list[Unknown]:
        """Unknown drives that the scene does not declare: of passive joints in a tree, of idle motions in loops."""
        motors = {joint.name: joint.drives for joint in self.hanging.scene.joints if joint.motion is None}
        drives = [one for one in self.unknowns if one.is_drive and one.joint in motors]
        return [one for one in drives if not any(motors[one.joint][one.number : one.number + 1])]

    def matrix(self) -> list[list[Expr]]:
        """Return A, shape (equations, unknowns)."""
        zero = self.hanging.graph.zero
        A = [[zero] * len(self.unknowns) for _ in range(self.equations)]
        for (j, u), (force, moment) in self.blocks.items():
            entries = (*force, *moment)
            for row, component in enumerate(self.kept):
                A[len(self.kept) * j + row][u] = entries[component]
        return A

    def right(self) -> list[Expr]:
        """Return b = F^A + F^D, body by body, shape (equations,)."""
        b = []
        for known in self.bodies:
            force, moment = known.action + known.inertia
            entries = (*force, *moment)
            b += [entries[component] for component in self.kept]
        return b

    def rows(self) -> Rows:
        """Return rows of A x = -b, entries by column, what is zero left out; -b is the column behind the unknowns."""
        rows = [{u: entry for u, entry in enumerate(row) if not entry.is_zero} for row in self.matrix()]
        for row, right in zip(rows, self.right(), strict=True):
            row[len(self.unknowns)] = -right
        return rows

    def wrench_rows(self, R: Sequence[Expr]) -> Rows:
        """Return rows which say that the unknowns are R = `reactions` of a tree's joints and those of loops."""
        hanging, last = self.hanging, len(self.unknowns)
        shown = (*hanging.joints, *hanging.loops)
        known = [x for hinge, wrench in zip(shown, self.elements(), strict=False) for x in _entries(hinge, wrench)]
        rows = [{last: r - own} for r, own in zip(R, known, strict=True)]
        for u, unknown in enumerate(self.unknowns):
            for h, wrench in unknown.acts:
                if h < len(shown):
                    for k, entry in enumerate(_entries(shown[h], wrench)):
                        if not entry.is_zero:
                            before = rows[6 * h + k].get(u)
                            rows[6 * h + k][u] = entry if before is None else before + entry
        return rows

    def elements(self) -> list[Wrench]:
        """Return what joints' own elements, and drives that are known, exert in every joint, axes of joint frames."""
        hanging = self.hanging
        total = [Wrench.none(hanging.graph)] * len(hanging.hinges)
        for h, (hinge, forces) in enumerate(zip(hanging.joints, self.own, strict=True)):
            for force, D in zip(forces, hanging.drives(hinge), strict=True):
                total[h] = total[h] + D.scaled(force)
        return total

    def direction(self, unknown: Unknown) -> str:
        """Return what an unknown of fixed direction in its joint frame is, such as "force along x"; else ""."""
        force, moment = unknown.acts[0][1]
        first, second = (self.hanging.samples.at([*force, *moment], seed) for seed in PLACES)
        return in_words(first[:3], first[3:]) if first.any() and abs(first - second).max() < 1e-12 else ""


def _entries(hinge: JointFrames, wrench: Wrench) -> tuple[Expr, ...]:
    """Return [force; moment] on the child, its axes, for a wrench in axes of the joint frame."""
    force, moment = hinge.on_child(wrench)
    return (*force, *moment)


def _own(hanging: FreeBodies, hinge: JointFrames, tau: Sequence[Expr] | None) -> list[Expr]:
    """Return what a joint's elements do along its velocities, known drives included."""
    forces = hanging.own_forces(hinge)
    if tau is None or hinge.joint.coupling is not None:
        return forces
    return [force + tau[k] for force, k in zip(forces, hinge.velocities, strict=True)]


# The unknowns


def _unknowns(hanging: FreeBodies, normal: int | None, whole: bool) -> list[Unknown]:
    graph = hanging.graph
    axes = None if normal is None else Mat.identity(graph)[normal]
    D = {h: hanging.drives(hinge) for h, hinge in enumerate(hanging.joints)}
    feels = {
        k: (h, D[h][i])
        for h, hinge in enumerate(hanging.joints)
        if hinge.joint.coordinates
        for i, k in enumerate(hinge.velocities)
    }
    passive = _passive(hanging, normal is None and not whole)
    found: list[Unknown] = []
    for h, hinge in enumerate(hanging.hinges):
        W = reactions_of(hinge, hanging.samples)
        if axes is not None:
            flat = flattened(W, axes)
            W = tuple(flat[k] for k in independent_in_plane(hanging, W, axes))
        elif h >= len(hanging.joints) and not whole and not hanging.of_rope(hinge):
            W = _in_its_plane(hanging, hinge)
        name = hinge.joint.name
        if found and hanging.of_rope(hinge) and found[-1].joint == name:  # another part of the same rope
            found[-1] = replace(found[-1], acts=(*found[-1].acts, (h, W[0])))
            continue
        found += [Unknown(REACTION, name, k, ((h, wrench),)) for k, wrench in enumerate(W)]
        if hinge.joint.coupling is not None:
            back = ((*feels[k], ratio) for k, _, ratio in hinge.moved_by)
            acts = ((h, D[h][0]), *((leader, drive.scaled(-ratio)) for leader, drive, ratio in back))
            found.append(Unknown(COUPLING, name, 0, acts))
        else:
            found += [
                Unknown(DRIVE, name, i, ((h, D[h][i]),)) for i, k in enumerate(hinge.velocities) if k not in passive
            ]
    for number, row in enumerate(rows_of(hanging)):
        acts = tuple((feels[k][0], feels[k][1].scaled(slope)) for k, slope in enumerate(row.G) if not slope.is_zero)
        found.append(Unknown(ROW, row.owner, number, acts or ((0, Wrench.none(graph)),)))  # a row may forbid nothing
    return found


def _passive(hanging: FreeBodies, with_idle: bool) -> set[int]:
    """Return the velocities without a drive; where idle motions get one, those that determine what closes the loops."""
    scene, decisions = hanging.scene, hanging.decisions
    if not scene.is_constrained:
        return set()
    if with_idle and decisions is not None and decisions.actuated is not None:
        return set(decisions.actuated.dependent)
    return set(scene.passive_velocities)


def _in_its_plane(hanging: FreeBodies, hinge: JointFrames) -> tuple[Wrench, ...]:
    """Return what a joint that closes a loop is taken to exert, without what works on no motion in the loop's plane."""
    twists = hanging.relative_twists(hinge)
    normal = plane(hanging, hinge, twists)
    W = taken_wrenches(hanging, hinge, twists)
    return W if normal is None else tuple(W[k] for k in independent_in_plane(hanging, W, normal))


def coordinate_normal(hanging: FreeBodies) -> int:
    """Return which axis of all frames, 0, 1 or 2, is the normal of the plane that a mechanism moves in."""
    for k in (2, 1, 0):
        n = Mat.identity(hanging.graph)[k]
        if all(_stays(hanging, hinge, n) for hinge in hanging.hinges):
            return k
    raise DerivationError(
        f"{hanging.scene.name}: there is no plane of coordinates of all frames that the mechanism moves in; "
        "write six equations a body"
    )


def _stays(hanging: FreeBodies, hinge: JointFrames, n: Vec) -> bool:
    """Return whether a joint and its frames leave the axis n where it is, at random positions."""
    entries = [*(hinge.origin).R @ n, *hinge.X.R @ n, *hinge.tip.R @ n]
    expected = hanging.samples.at([*n, *n, *n])
    still = all(abs(hanging.samples.at(entries, seed) - expected).max() < 1e-9 for seed in (2, 3))
    turning = [x for _, omega in hinge.S for x in cross(n, omega)] + [dot(n, v) for v, _ in hinge.S]
    return still and all(abs(x) < 1e-9 for seed in (2, 3) for x in hanging.samples.at(turning, seed))
