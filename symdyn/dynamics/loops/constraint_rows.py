"""Constraint rows of loops and contacts, G u = 0, and what each of them forbids; by two formulations.

A tree is cut at joints that close loops, and at contacts of knife edges, wheels and balls with a plane.

    J        frame of the cut joint on its parent; of a contact in a point of the plane, in axes of the body that has it
    X        pose of the joint frame on the child, in J; P is its origin: the point of a knife edge, a wheel's centre
    u, ω     velocities of the mechanism, shape (nv,); angular velocity of the child relative to J
    F, N     wrench k of the joint: force and moment, axes of J, acting at P
    G        G_k u = F·Ṗ + N·ω, where Ṗ is the velocity of P relative to J; axes of J
    bias     Ġ u: the rate of G u at u̇ = 0

Both relative velocities are taken at one spatial point, so that the multiplier λ_k is the size of wrench k off the
constraint manifold too, and Gᵀ λ its generalized force. Constraints that a scene declares by formulas come last.

The *recursive* formulation walks from J to the child along the tree, through their lowest common ancestor: nothing
beyond it enters, so that a planar loop on a floating base stays planar. The formulation *by differentiation*
differentiates X.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), sections 8.1 to 8.5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise

from symdyn.algebra import TrigonometricRing
from symdyn.dynamics.mechanism.kinematics import Relative, Twist, relative_motion
from symdyn.dynamics.mechanism.ropes import Taut
from symdyn.dynamics.mechanism.state import State, body_placements, vector
from symdyn.dynamics.mechanism.tree import Tree
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, evaluate, gradient, reachable, substitute, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Contact, Joint, Place
from symdyn.spatial import Mat, Transform, Vec, Wrench, cross, dot

FLAT = 1e-3
"""Sine of the angle between axis and normal of a wheel that lies flat."""


@dataclass(frozen=True)
class Cut:
    """One cut.

    Attributes:
        owner: name of the loop or of the contact.
        parent, child: bodies; what carries the plane is the parent of a contact.
        on_parent: pose of J in the parent: the joint frame of the predecessor.
        on_child: pose of the frame at P in the child: that of the successor.
        wrenches: constraint wrenches, which the parent exerts on the child without doing work, as functions of X.
        residual: likewise what vanishes where the constraint holds; zero for a nonholonomic one.
        holonomic: for each wrench whether its constraint is holonomic; the residual of another one has no meaning.
        joint: the joint that closes the loop; None for a contact.
        names: of a contact's wrenches, in words; "" where its direction is enough.
    """

    owner: str
    parent: str
    on_parent: Transform
    child: str
    on_child: Transform
    wrenches: Callable[[Transform], tuple[Wrench, ...]]
    residual: Callable[[Transform], tuple[Expr, ...]]
    holonomic: tuple[bool, ...]
    joint: Joint | None
    names: tuple[str, ...] = ()


TENSION = "tension"
"""The name of a rope's wrench."""


def cuts(scene: Scene, graph: Graph) -> list[Cut]:
    """Return the cut joints of a scene, its contacts, and the straight parts of its ropes."""
    found = [*(_joint(joint, graph) for joint in scene.loops), *(contact(row, graph) for row in scene.contacts)]
    if scene.lasting_ropes:
        taut = Taut(scene, graph)
        found += [_stretch(rope.name, taut, *pair) for rope in scene.lasting_ropes for pair in pairwise(rope.ends)]
    return found


def _joint(joint: Joint, graph: Graph) -> Cut:
    kind = JOINTS[joint.type]
    forbids = kind.forbids
    assert forbids, "the scene's check refuses loops of joints that forbid what has no formula"
    return Cut(
        joint.name,
        joint.parent,
        joint.origin.transform(graph),
        joint.child,
        joint.tip.transform(graph).inverse(),
        lambda X: forbids.wrenches(joint, X),
        lambda X: forbids.residual(joint, X),
        (True,) * kind.class_t(joint),
        joint,
    )


def _stretch(owner: str, taut: Taut, near: Place, far: Place) -> Cut:
    """Return the cut of a straight part of a rope, whose tension draws the places at its ends together."""
    return Cut(
        owner,
        *taut.seat(near),
        *taut.seat(far),
        lambda X: (taut.straight(near, far, X).wrench,),
        lambda X: (taut.graph.zero,),
        (True,),
        None,
        (TENSION,),
    )


def contact(row: Contact, graph: Graph) -> Cut:
    """Return the cut of a contact."""
    law = FORCES[row.kind].touch
    holonomic = law.holonomic(row)
    return Cut(
        row.name,
        row.plane.body,
        Transform(Mat.identity(graph), vector(row.plane.at, graph)),
        row.place.body,
        Transform(Mat.identity(graph), vector(row.place.at, graph)),
        lambda X: law.wrenches(row, X, sine(row, X)),
        lambda X: tuple(law.height(row, X, sine(row, X)) if one else graph.zero for one in holonomic),
        holonomic,
        None,
        law.words(row),
    )


def sine(row: Contact, X: Transform) -> Expr:
    """Return the sine of the angle between axis and normal of a contact; 1 where it is 1 at every position."""
    graph, lean = X.p[0].graph, FORCES[row.kind].touch.lean(row, X)
    if lean is None:
        return graph.one
    square = dot(lean, lean)
    try:
        ring = TrigonometricRing([square])
        (value,) = evaluate([square], ring, ring.values([square]))
    except DerivationError:  # a motion that is no trigonometric polynomial
        return graph.sqrt(square)
    return graph.one if ring.is_zero(value - 1) else graph.sqrt(square)


@dataclass(frozen=True)
class ContactGap:
    """A contact: height of its lowest point, m, and sine of the angle of a wheel's axis and the normal, else 1."""

    row: Contact
    height: Expr
    sine: Expr

    @property
    def flat(self) -> str:
        """The message about a start where the wheel lies flat."""
        return f"contact {self.row.name}: {self._parallel}; give a start at which it leans"

    @property
    def fell_flat(self) -> str:
        """The message where a motion ends because the wheel lies flat."""
        return f"contact {self.row.name}: the motion came to where {self._parallel}"

    def is_flat(self, sine: float) -> bool:
        """Whether a wheel lies flat where the sine has a value."""
        return sine < FLAT

    @property
    def _parallel(self) -> str:
        body = self.row.place.body
        return f"{body} lies flat on its plane, its axis along the normal, so that no point of its rim is the lowest"


def contact_gaps(scene: Scene, graph: Graph) -> tuple[ContactGap, ...]:
    """Return the gaps of all contacts of a scene."""
    placed = body_placements(scene, graph) if scene.contacts else {}
    found = []
    for row in scene.contacts:
        cut, law = contact(row, graph), FORCES[row.kind].touch
        X = (placed[cut.parent] @ cut.on_parent).inverse() @ placed[cut.child] @ cut.on_child
        w = sine(row, X)
        found.append(ContactGap(row, law.height(row, X, w), w))
    return tuple(found)


@dataclass(frozen=True)
class Label:
    """Description of a constraint row, a row of G.

    Attributes:
        owner: name of the loop, or of the scene's constraint.
        number: of the wrench among the owner's.
        wrench: (force, moment) that the parent can exert, axes of J; None for a formula of the user.
        holonomic: whether it is a constraint on positions, so that its residual vanishes too.
        loop: whether it belongs to a joint that closes a loop; else to a constraint of the scene.
        name: of a contact's wrench in words, "" where its direction is enough.
    """

    owner: str
    number: int = 0
    wrench: tuple[Vec, Vec] | None = None
    holonomic: bool = False
    loop: bool = False
    name: str = ""

    @property
    def words(self) -> str:
        """Its owner in words: "the loop cut", "the contact wheel", "the rope r"."""
        kind = "loop" if self.loop else "rope" if self.is_rope else "contact" if self.wrench else "constraint"
        return f"the {kind} {self.owner}"

    @property
    def is_rope(self) -> bool:
        return self.name == TENSION


@dataclass(frozen=True)
class Constraints:
    """All constraint rows, before any is left out as redundant.

    Attributes:
        labels: description of each, shape (m,).
        residual: what vanishes where the constraint holds, shape (m,); 0 for a nonholonomic one.
        G: shape (m, nv).
        bias: Ġ u, shape (m,).
        cuts: of the loops and contacts.
        columns: by loop the relative twists (angular, linear at P, axes of J) of unit velocities, by velocity.
    """

    labels: tuple[Label, ...]
    residual: tuple[Expr, ...]
    G: tuple[tuple[Expr, ...], ...]
    bias: tuple[Expr, ...]
    cuts: tuple[Cut, ...]
    columns: dict[str, dict[int, Twist]]


Entry = tuple[Label, Expr, tuple[Expr, ...], Expr]


def _gathered(entries: Sequence[Entry], there: Sequence[Cut], columns: dict[str, dict[int, Twist]]) -> Constraints:
    labels, residual, G, bias = zip(*entries, strict=True) if entries else ((), (), (), ())
    return Constraints(tuple(labels), tuple(residual), tuple(G), tuple(bias), tuple(there), columns)


# Recursive


def recursive(scene: Scene, tree: Tree, state: State) -> Constraints:
    """Return the constraint rows of a scene by recursion along its tree."""
    entries, columns, there = [], {}, cuts(scene, tree.graph)
    poses: dict[str, list[Transform]] = {}  # of the straight parts of ropes
    speeds = cache(lambda: (tree.rates(state.qd), tree.bias(state.qd)))
    for cut in there:
        relative = relative_motion(tree, (cut.parent, cut.on_parent), (cut.child, cut.on_child), speeds)
        entries += _of_cut(cut, relative, state)
        if cut.joint:
            columns[cut.owner] = relative.columns
        elif cut.names == (TENSION,):
            poses.setdefault(cut.owner, []).append(relative.X)
    formulas = [_linear_row(*one, scene, state, tree.graph) for one in _formulas(scene)]
    return _gathered(_in_order(scene, _whole(scene, entries, poses) + formulas), there, columns)


def _whole(scene: Scene, entries: list[Entry], poses: dict[str, list[Transform]]) -> list[Entry]:
    """Return the entries, the straight parts of each rope as one row, whose residual is length - L."""
    if not poses:
        return entries
    found = [one for one in entries if not one[0].is_rope]
    for rope in scene.lasting_ropes:
        parts = [one for one in entries if one[0].is_rope and one[0].owner == rope.name]
        label, zero, G, bias = parts[0]
        graph = zero.graph
        for _, _, more, rest in parts[1:]:
            G, bias = tuple(a + b for a, b in zip(G, more, strict=True)), bias + rest
        found_length = Taut(scene, graph).length(rope.ends, poses[rope.name])
        found.append((label, FORCES[rope.kind].length(rope).express(graph) - found_length, G, bias))
    return found


def _in_order(scene: Scene, entries: Sequence[Entry]) -> list[Entry]:
    """Return the entries in the order of the scene: loops, then constraints that it declares."""
    owners = [*((joint.name, True) for joint in scene.loops), *((row.name, False) for row in scene.constraints)]
    place = {owner: k for k, owner in enumerate(owners)}
    return sorted(entries, key=lambda entry: place[entry[0].owner, entry[0].loop])


def _of_cut(cut: Cut, relative: Relative, state: State) -> list[Entry]:
    """Return label, residual, row of G and bias of every wrench of a cut."""
    zero = relative.X.p[0].graph.zero
    wrenches, residual = cut.wrenches(relative.X), cut.residual(relative.X)
    rates = _wrench_rates(cut, relative, state)
    alpha, a = relative.acceleration
    omega, v = relative.twist(state.qd)
    rows = []
    for k, ((F, N), (dF, dN)) in enumerate(zip(wrenches, rates, strict=True)):
        row = [zero] * state.n
        for i, (z, s) in relative.columns.items():
            row[i] = dot(F, s) + dot(N, z)
        bias = dot(F, a) + dot(N, alpha) + dot(dF, v) + dot(dN, omega)
        rows.append((_label(cut, k, (F, N)), residual[k], tuple(row), bias))
    return rows


def _label(cut: Cut, k: int, wrench: tuple[Vec, Vec]) -> Label:
    return Label(cut.owner, k, wrench, cut.holonomic[k], cut.joint is not None, cut.names[k] if cut.names else "")


def _wrench_rates(cut: Cut, relative: Relative, state: State) -> list[tuple[Vec, Vec]]:
    """Return the rates of a cut's wrenches, which may depend on X: a joint's by d/dt R = ω̃ R and d/dt P = Ṗ.

    A contact's are differentiated along q̇, for the simplifications that its axis allows are lost on symbols for R.
    """
    X = relative.X
    if not cut.joint:
        return _paired(tangents(_entries(cut, X), state.velocity))
    graph = X.p[0].graph
    rows = [[graph.symbol(f"R[{r},{c}]") for c in range(3)] for r in range(3)]
    R = Mat((x, y, z) for x, y, z in rows)
    p = tuple(graph.symbol(f"P[{r}]") for r in range(3))
    symbols = [*(entry for row in R for entry in row), *p]
    entries = _entries(cut, Transform(R, p))  # type: ignore[arg-type]
    if not set(symbols).intersection(reachable(entries)):
        return _paired([graph.zero] * len(entries))
    omega, v = relative.twist(state.qd)
    turned = [cross(omega, (X.R[0][c], X.R[1][c], X.R[2][c])) for c in range(3)]
    seeds = {R[r][c]: turned[c][r] for r in range(3) for c in range(3)} | dict(zip(p, v, strict=True))
    values = dict(zip(symbols, [*(entry for row in X.R for entry in row), *X.p], strict=True))
    return _paired(substitute(tangents(entries, seeds), values))


def _entries(cut: Cut, X: Transform) -> list[Expr]:
    return [entry for wrench in cut.wrenches(X) for part in wrench for entry in part]


def _paired(entries: Sequence[Expr]) -> list[tuple[Vec, Vec]]:
    """Return six entries each as force and moment."""
    parts: list[Vec] = [(entries[k], entries[k + 1], entries[k + 2]) for k in range(0, len(entries), 3)]
    return [(parts[k], parts[k + 1]) for k in range(0, len(parts), 2)]


def _formulas(scene: Scene) -> list[tuple[str, Quantity]]:
    """Return the names and the left-hand sides of the constraints that are formulas."""
    return [(row.name, formula) for row in scene.constraints if (formula := FORCES[row.kind].formula(row)) is not None]


def _linear_row(name: str, left: Quantity, scene: Scene, state: State, graph: Graph) -> Entry:
    """Return the constraint row of a formula: its values at unit velocities; it must be linear in them."""
    formula = left.express(graph)
    units = [{qd: graph.one if qd is one else graph.zero for qd in state.qd} for one in state.qd]
    entries = tuple(substitute([formula], unit)[0] for unit in units)
    (rest,) = substitute([formula], dict.fromkeys(state.qd, graph.zero))
    slopes = gradient(formula, state.qd)
    if not rest.is_zero or set(state.qd).intersection(reachable(slopes)):
        raise DerivationError(
            f"{scene.name}: constraints.{name}: the formula is not linear in the velocities; "
            "write a sum of terms coefficient * velocity, without a constant term"
        )
    bias = graph.dot(tangents(entries, state.velocity), state.qd)
    return Label(name), graph.zero, entries, bias


# By differentiation


def differentiated(scene: Scene, graph: Graph, state: State) -> Constraints:
    """Return the constraint rows of a scene by differentiating poses in the ground frame, and lengths of ropes."""
    placed, there = body_placements(scene, graph), cuts(scene, graph)
    entries: list[Entry] = []
    for cut in there:
        X = (placed[cut.parent] @ cut.on_parent).inverse() @ placed[cut.child] @ cut.on_child
        velocity = tangents(X.p, state.velocity)
        turning = X.R.spin([tangents(row, state.velocity) for row in X.R])
        if cut.names == (TENSION,):
            if not any(label.owner == cut.owner and label.is_rope for label, *_ in entries):
                rope = next(one for one in scene.lasting_ropes if one.name == cut.owner)
                gap = FORCES[rope.kind].length(rope).express(graph) - Taut(scene, graph).placed(rope.ends, placed)
                (rate,) = tangents([gap], state.velocity)
                entries.append((_label(cut, 0, cut.wrenches(X)[0]), gap, *_slopes(rate, state)))
            continue
        residual = cut.residual(X)
        for k, (F, N) in enumerate(cut.wrenches(X)):
            power = graph.dot((*F, *N), (*velocity, *turning))
            entries.append((_label(cut, k, (F, N)), residual[k], *_slopes(power, state)))
    for name, left in _formulas(scene):
        label = Label(name)
        entries.append((label, graph.zero, *_slopes(left.express(graph), state)))
    return _gathered(_in_order(scene, entries), there, {})


def _slopes(power: Expr, state: State) -> tuple[tuple[Expr, ...], Expr]:
    """Return the row of G, and Ġ u, of G u."""
    (bias,) = tangents([power], state.velocity)
    return tuple(gradient(power, state.qd)), bias
