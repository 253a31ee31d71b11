"""The system (5.18) of one scene while its lesson is being written: unknowns with their names, short forms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from symdyn.algebra.compact import Compactor
from symdyn.algebra.form import Form, Symbol, form_of
from symdyn.algebra.sums_of_angles import total_angles
from symdyn.algebra.trigonometric import TrigonometricRing
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.closed_forms.parallel import angle_groups
from symdyn.dynamics.loops.words import in_words
from symdyn.dynamics.reactions.dalembert import COUPLING, DRIVE, REACTION, Equilibrium, Unknown, equilibrium
from symdyn.dynamics.reactions.freedoms import drives
from symdyn.dynamics.reactions.hinges import plus, power, times
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Expr, evaluate
from symdyn.teach.cut import cut
from symdyn.teach.lesson import Prose
from symdyn.teach.looks import Name

MOST_UNKNOWNS = 40
"""Beyond which nobody reads the lesson."""


@dataclass
class Balance(Prose):
    """One scene with its system (5.18) while the document is being written."""

    def __post_init__(self) -> None:
        """Set the system up, in a plane where there is one."""
        for joint in self.scene.joints:
            if joint.velocities:
                raise DerivationError(
                    f"{self.scene.name}: joint {joint.name} turns by a quaternion, for which there are no formulas to "
                    'read; write orientation = "zyx" (or another sequence of axes) to have them'
                )
        self.workspace = Workspace(self.scene)
        self.scene = self.workspace.scene
        self.graph, self.state = self.workspace.graph, self.workspace.state
        self.closed = bool(self.scene.loops or self.scene.rows)
        try:
            self.system = equilibrium(self.workspace.hanging, planar=True)
        except DerivationError:
            self.system = equilibrium(self.workspace.hanging)
        if len(self.system.unknowns) > MOST_UNKNOWNS:
            raise EmitError(
                f"{self.scene.name}: {len(self.system.unknowns)} unknowns are more than anyone reads (the limit is "
                f"{MOST_UNKNOWNS}); the outputs reactions and reactions:joint compute them"
            )
        self.axes = [("F", "xyz"[k]) if k < 3 else ("M", "xyz"[k - 3]) for k in self.system.kept]
        self.solved = None if self.closed else self._solution()
        self.cuts = [cut(self.workspace, self.system, j) for j in range(len(self.scene.bodies))]
        written = [x for one in self.cuts if one is not None for x in one.nodes]
        self.short = _forms(self.system, [written, [*written, *(self.solved or [])]])
        self.unknowns = [self._unknown(u, one) for u, one in enumerate(self.system.unknowns)]

    def _solution(self) -> list[Expr]:
        """Return the unknowns of an open mechanism: its joints' wrenches, found from the tips to the ground, split.

        What is left of a joint's wrench along its motions (D, with D_i · S_j = 1 for i = j, else 0) are drive, elements
        and couplings; the rest is split along reactions, which are at right angles.
        """
        R, hanging = derive_one(self.workspace, "reactions").entries, self.workspace.hanging
        along, rest = [], []
        for h, hinge in enumerate(hanging.joints):
            here = hinge.in_joint_axes((R[6 * h : 6 * h + 3], R[6 * h + 3 : 6 * h + 6]))  # type: ignore[arg-type]
            along.append([power(here, S) for S in hinge.S])
            for size, D in zip(along[-1], drives(hinge, hanging.samples), strict=True):
                here = plus(here, times(-size, D))
            rest.append(here)
            along[-1] = [size - own for size, own in zip(along[-1], self.system.own[h], strict=True)]
        sizes: dict[int, Expr] = {}
        for u, one in enumerate(self.system.unknowns):
            h, wrench = one.acts[0]
            if one.kind == COUPLING:
                sizes[u] = along[h][0]
                for other, against in one.acts[1:]:  # what the coupling takes from the leader is no drive of its
                    leading = hanging.joints[other].S
                    along[other] = [
                        x - power(against, S) * sizes[u] for x, S in zip(along[other], leading, strict=True)
                    ]
            elif one.kind == REACTION:
                sizes[u] = power(rest[h], wrench) / power(wrench, wrench)
        for u, one in enumerate(self.system.unknowns):
            if one.kind == DRIVE:
                sizes[u] = along[one.acts[0][0]][one.number]
        return [sizes[u] for u in range(len(sizes))]

    def _unknown(self, u: int, one: Unknown) -> Symbol:
        """Name an unknown; its value is the solution, or the symbol itself where loops leave only numbers."""
        key = f"{one.kind}:{one.joint}:{one.number}"
        node = self.graph.symbol(key) if self.solved is None else self.solved[u]
        if one.kind == DRIVE:
            joint = next(joint for joint in self.scene.joints if joint.name == one.joint)
            drive = joint.drives[one.number] if one.number < len(joint.drives) else None
            if drive:
                self.names[drive] = Name(None, node)
                return Symbol(drive)
            return self.name(key, "tau", one.joint, str(one.number + 1), node=node)
        words = self.along(one)
        if one.kind == REACTION and words[-2:] in (" x", " y", " z"):
            return self.name(key, "F" if words.startswith("force") else "M", one.joint, words[-1], node=node)
        return self.name(key, "R", one.joint, str(one.number + 1), node=node)

    def along(self, one: Unknown) -> str:
        """Return "force along x" for a unit wrench of fixed direction in its joint frame, else ""."""
        force, moment = one.acts[0][1]
        first, second = (self.workspace.hanging.samples.at([*force, *moment], seed) for seed in (2, 3))
        return in_words(first[:3], first[3:]) if abs(first - second).max() < 1e-12 else ""

    def kept(self, wrench: tuple[Sequence[Expr], Sequence[Expr]]) -> list[Expr]:
        """Return the components that are written."""
        entries = (*wrench[0], *wrench[1])
        return [entries[k] for k in self.system.kept]


def _forms(system: Equilibrium, more: Sequence[Sequence[Expr]]) -> Callable[[Expr], Form]:
    """Return what writes an entry: as short as the ring of sines can, as it stands where there is no such ring.

    Args:
        system: whose entries are written.
        more: what else is written, fewer nodes first: a solution with a pivot that moves is no polynomial.
    """
    state, graph = system.hanging.state, system.hanging.graph
    needed = [x for known in system.bodies for part in (*known.action, *known.inertia) for x in part]
    needed += [x for block in system.blocks.values() for part in block for x in part]
    for others in reversed(more):
        try:
            parallel = angle_groups(system.hanging.scene, graph)
            nodes = list(dict.fromkeys([*needed, *others]))
            ring = TrigonometricRing(nodes, (*state.q, *state.qd, *state.qdd), total_angles(parallel))
            values = dict(zip(nodes, evaluate(nodes, ring, ring.values(nodes)), strict=True))
        except DerivationError:
            continue
        compact = Compactor(ring, parallel)
        return lambda node: compact(values[node]) if node in values else form_of(node)
    return form_of
