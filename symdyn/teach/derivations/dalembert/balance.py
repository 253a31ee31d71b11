"""The system (5.18) of one scene while its lesson is being written: bodies cut free, unknowns with their names, forms.

Of a body that is cut free, beside its bivectors:

P_0j, r_0j     (5.4), (5.2) direction cosines of frame j, r̃ of the position of its origin O_j; axes of the ground
w_0j, I_jj     angular velocity, (5.15) inertia about O_j; axes of frame j
F_0j           (5.11) inertia force, by differentiating the position of the centre of mass; axes of the ground
F_star         (5.16) F*^D_jj; axes of frame j
arm, moved     r_j,Tj from O_j to T_j, and its moment with F*^D_jj, the last term of (5.14); axes of frame j
I_T            inertia about T_j, from I_jj by Steiner's theorem; axes of frame j
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from symdyn.algebra import Compactor, Form, Function, Polynomial, Symbol, TrigonometricRing, with_squares
from symdyn.dynamics import Workspace, angle_groups, derive_one
from symdyn.dynamics.loops import solve_normal
from symdyn.dynamics.mechanism import State
from symdyn.dynamics.reactions import Equilibrium, JointFrames, Unknown
from symdyn.emit.print import length_symbols
from symdyn.errors import DerivationError, EmitError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, evaluate, reachable, substitute, tangents
from symdyn.scene.values import Strut, velocity_name
from symdyn.spatial import Mat, Transform, Vec, Wrench, add, cross, neg, scale, sub, zero_vector
from symdyn.teach.derivations.dalembert.side_by_side import order_of
from symdyn.teach.document import Name
from symdyn.teach.lesson import Prose, refuse_quaternions
from symdyn.teach.student.rows import keeps_points
from symdyn.unlocked import cached_property

MOST_UNKNOWNS = 40
"""Beyond which nobody reads the lesson."""


@dataclass(frozen=True)
class Cut:
    """One body, cut free; see the module's legend.

    Attributes:
        m: mass, kg.
        dw: angular acceleration, axes of frame j.
        centre, origin: place, velocity and acceleration of T_j and of O_j, axes of the ground.
        misread: F̄^D_jj as (5.16) of the text would have it, with a position in place of an acceleration.
    """

    m: Expr
    P: Mat
    r: Mat
    w: Vec
    I: Mat  # noqa: E741  the book's name
    F: Vec
    F_star: Vec
    arm: Vec
    moved: Vec
    I_T: Mat
    misread: Wrench
    dw: Vec
    centre: tuple[Vec, Vec, Vec]
    origin: tuple[Vec, Vec, Vec]

    @property
    def nodes(self) -> list[Expr]:
        """Everything that is written of it."""
        vectors = (self.w, self.dw, self.F, self.F_star, self.arm, self.moved, *self.centre, *self.origin)
        return [self.m, *(x for row in (*self.P, *self.r, *self.I, *self.I_T, *vectors) for x in row)]


def cut(workspace: Workspace, system: Equilibrium, j: int) -> Cut | None:
    """Return what there is to say of body j; None for a body without mass."""
    known, T, state = system.bodies[j], system.hanging.frames[j], workspace.state
    m, motion = known.body.m, known.motion
    if m.is_zero:
        return None
    centre = workspace.centre_of_mass(workspace.scene.bodies[j].name)
    arm = sub(centre, system.hanging.joints[j].place_on_child)
    place, r = T.point(arm), Mat.skew(arm)
    moved = [_differentiated(one, state) for one in (place, T.p)]
    misread = known.inertia_for(T.R.T @ T.p)
    force, force_star = neg(scale(m, moved[0][2])), neg(scale(m, motion.a))
    about = Mat(add(row, scale(m, other)) for row, other in zip(known.body.I, r @ r, strict=True))
    lever = (arm, cross(arm, force_star), about)
    return Cut(m, T.R, Mat.skew(T.p), motion.w, known.body.I, force, force_star, *lever, misread, motion.dw, *moved)


def _differentiated(place: Vec, state: State) -> tuple[Vec, Vec, Vec]:
    """Return a place with its velocity and its acceleration."""
    x, y, z = tangents(place, state.velocity)
    a, b, c = tangents((x, y, z), state.acceleration)
    return place, (x, y, z), (a, b, c)


@dataclass
class Balance(Prose):
    """One scene with its system (5.18) while the document is being written.

    `system` is written for readers, with loops closed; `proved` is the same for proofs.
    """

    def __post_init__(self) -> None:
        """Set the system up, in a plane where there is one."""
        self.workspace = Workspace(self.scene)
        self.scene = self.workspace.scene
        self.graph, self.state = self.workspace.graph, self.workspace.state
        self.closed = self.scene.is_constrained
        self.order = order_of(self.scene)
        hanging = self.workspace.hanging
        self.proved = Equilibrium.for_readers(hanging)
        pinned = hanging.closed_by(_pinned(hanging.cuts)) if self.scene.loops else hanging
        self.system = Equilibrium.for_readers(pinned) if self.scene.loops else self.proved
        if not self.in_letters:
            refuse_quaternions(self.scene)
        if len(self.system.unknowns) > MOST_UNKNOWNS:
            raise EmitError(
                f"{self.scene.name}: {len(self.system.unknowns)} unknowns are more than anyone reads (the limit is "
                f"{MOST_UNKNOWNS}); the outputs reactions and reactions:joint compute them"
            )
        self.axes = [("F", "xyz"[k]) if k < 3 else ("M", "xyz"[k - 3]) for k in self.system.kept]
        self.solved = None if self.closed else self._solution()
        self.cuts = [cut(self.workspace, self.system, j) for j in range(len(self.scene.bodies))]
        written = [x for one in self.cuts if one is not None for x in one.nodes]
        named, lengths = length_symbols(self.system)
        more = [x for one in lengths for x in one[3:]]
        written = [*written, *more]
        self.short = _forms(self.system, [written, [*written, *(self.solved or [])]], self.order, named)
        used = set(reachable(substitute([*_entries(self.system), *written], named)))
        pairs = [pair for one in lengths for pair in self._named_length(*one, named)]
        self.lengths = [(name, form) for name, form in pairs if self.graph.symbol(name) in used]
        self.unknowns = [self._unknown(u, one) for u, one in enumerate(self.system.unknowns)]

    @property
    def in_letters(self) -> bool:
        """Whether accelerations stay letters: of one loop in space, whose formulas nobody reads; figure 5.39."""
        coupled = any(one.is_coupling for one in self.system.unknowns)
        return len(self.scene.loops) == 1 and len(self.system.kept) == 6 and not coupled and not self.scene.constraints

    @cached_property
    def empty(self) -> str:
        """The rows of a bivector that a plane leaves empty, "3, 4, 5"; "" where forces have parts across it."""
        rows = [k for k in range(6) if k not in self.system.kept]
        known = [(*one.action[0], *one.action[1], *one.inertia[0], *one.inertia[1]) for one in self.system.bodies]
        across = [entries[k] for entries in known for k in rows]
        return ", ".join(str(k + 1) for k in rows) if rows and self.workspace.hanging.samples.vanish(across) else ""

    def _named_length(
        self,
        struts: Sequence[Strut],
        index: Sequence[str],
        name: str,
        square: Expr,
        rate: Expr,
        named: Mapping[Expr, Expr],
    ) -> list[tuple[str, Form]]:
        """Name the length of struts and its rate, and return what they stand for."""
        pairs = [(name, Function(Op.SQRT, (self.short(square),))), (velocity_name(name), self.short(rate))]
        for dots, (key, _) in enumerate(pairs):
            node = next(node for node, symbol in named.items() if symbol.value == key)
            self.name(key, self.letters.LENGTH, *index, node=node, dots=dots)
        return pairs

    def _solution(self) -> list[Expr]:
        """Return the unknowns of an open mechanism: its joints' wrenches, found from the tips to the ground, split.

        What is left of a joint's wrench along its motions (D, with D_i · S_j = 1 for i = j, else 0) are drive, elements
        and couplings; the rest is split along reactions.
        """
        R, hanging = derive_one(self.workspace, "reactions").entries, self.workspace.hanging
        along, rest = [], []
        for h, hinge in enumerate(hanging.joints):
            here = hinge.in_joint_axes(Wrench(R[6 * h : 6 * h + 3], R[6 * h + 3 : 6 * h + 6]))  # type: ignore[arg-type]
            along.append([here.power(S) for S in hinge.S])
            for size, D in zip(along[-1], hanging.drives(hinge), strict=True):
                here = here + D.scaled(-size)
            rest.append(here)
            along[-1] = [size - own for size, own in zip(along[-1], self.system.own[h], strict=True)]
        sizes: dict[int, Expr] = {}
        for u, one in enumerate(self.system.unknowns):
            h = one.acts[0][0]
            if one.is_coupling:
                sizes[u] = along[h][0]
                for other, against in one.acts[1:]:  # what the coupling takes from the leader is no drive of its
                    leading = hanging.joints[other].S
                    along[other] = [x - against.power(S) * sizes[u] for x, S in zip(along[other], leading, strict=True)]
        for h, split in enumerate(rest):
            reactions = [(u, one.acts[0]) for u, one in enumerate(self.system.unknowns) if one.is_reaction]
            own = [(u, W) for u, (acting, W) in reactions if acting == h]
            sizes |= zip([u for u, _ in own], self._shares(split, [W for _, W in own]), strict=True)
        for u, one in enumerate(self.system.unknowns):
            if one.is_drive:
                sizes[u] = along[one.acts[0][0]][one.number]
        return [sizes[u] for u in range(len(sizes))]

    def _shares(self, wrench: Wrench, parts: list[Wrench]) -> list[Expr]:
        """Return x with Σ x · part = wrench; parts of a custom joint need not be at right angles."""
        products = [a.power(b) for k, a in enumerate(parts) for b in parts[:k]]
        if not products or self.workspace.hanging.samples.vanish(products):
            return [wrench.power(part) / part.power(part) for part in parts]
        flat = [(*force, *moment) for force, moment in parts]
        return solve_normal([[part[k] for part in flat] for k in range(6)], (*wrench[0], *wrench[1]))

    def _unknown(self, u: int, one: Unknown) -> Symbol:
        """Name an unknown; its value is the solution, or the symbol itself where loops leave only numbers."""
        key = f"{one.kind}:{one.joint}:{one.number}"
        node = self.graph.symbol(key) if self.solved is None else self.solved[u]
        if one.is_drive:
            joint = next(joint for joint in self.scene.joints if joint.name == one.joint)
            drive = joint.drives[one.number] if one.number < len(joint.drives) else None
            if drive:
                self.names[drive] = Name(None, node)
                return Symbol(drive)
            return self.name(key, "tau", one.joint, str(one.number + 1), node=node)
        words = self.system.direction(one)
        if one.is_reaction and words[-2:] in (" x", " y", " z"):
            return self.name(key, "F" if words.startswith("force") else "M", one.joint, words[-1], node=node)
        return self.name(key, "R", one.joint, str(one.number + 1), node=node)


def _pinned(cuts: Sequence[JointFrames]) -> list[JointFrames]:
    """Return the cuts of a mechanism whose loops are closed: what keeps points together acts at the parent's own.

    Seen from the parent that point is where the joint was declared; reached around the loop it is the same place, in
    ten terms. So this is for forms, not for proofs, which know no closed loop beforehand.
    """
    return [
        replace(one, X=Transform(one.X.R, zero_vector(one.X.p[0].graph))) if keeps_points(one) else one for one in cuts
    ]


def _entries(system: Equilibrium) -> list[Expr]:
    """Return all entries of a system."""
    needed = [x for known in system.bodies for part in (*known.action, *known.inertia) for x in part]
    return needed + [x for block in system.blocks.values() for part in block for x in part]


def _forms(
    system: Equilibrium,
    more: Sequence[Sequence[Expr]],
    order: Callable[[Form], Form],
    named: Mapping[Expr, Expr],
) -> Callable[[Expr], Form]:
    """Return what writes an entry: as short as the ring of sines can, as it stands where there is no such ring.

    What else is written has fewer nodes first: a solution with a pivot that moves is no polynomial. Nodes that are
    `named` stand by their symbols.
    """

    def placed(nodes: Sequence[Expr]) -> list[Expr]:
        return substitute(nodes, named) if named else list(nodes)

    state, graph = system.hanging.state, system.hanging.graph
    needed = _entries(system)
    for others in reversed(more):
        try:
            parallel = angle_groups(system.hanging.scene, graph)
            nodes = list(dict.fromkeys(placed([*needed, *others])))
            ring = TrigonometricRing(nodes, (*state.q, *state.qd, *state.qdd), parallel)
            values = dict(zip(nodes, evaluate(nodes, ring, ring.values(nodes)), strict=True))
        except DerivationError:
            continue
        write = _writer(Compactor(ring, parallel), values, order)
        return lambda node: write(placed([node])[0])
    return lambda node: Form.of(placed([node])[0])


def _writer(
    compact: Compactor, values: Mapping[Expr, Polynomial], order: Callable[[Form], Form]
) -> Callable[[Expr], Form]:
    def write(node: Expr) -> Form:
        return order(with_squares(compact(values[node]))) if node in values else Form.of(node)

    return write
